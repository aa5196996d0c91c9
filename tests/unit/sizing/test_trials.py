"""The engine by trials: rules of the drum by its stress, windows, order of the rules, drives that it knows, preload."""

import copy
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import pytest
import yaml

from mbcdm_cad.checks.structure import drum_stress
from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.design.sized import SizingError
from mbcdm_cad.layouts.head_dims import CLOSED_GAIN
from mbcdm_cad.layouts.loader import layout_of, load_design, load_text
from mbcdm_cad.layouts.preload import preload_rule
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.layouts.siso_bevel.sizing import DirectKnown
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.siso_spur.sizing.basis import SpurKnown
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.layouts.trial_drives import TrialDrives
from mbcdm_cad.parts.drum_sector.part import DrumSector
from mbcdm_cad.sizing import Found, KnownFields, Rule, constant, fill, largest, rounded_down, rounded_up
from tests.support.checked import short_file, statuses
from tests.support.layout_bound import Asked, excluding, least_column_mm
from tests.support.reference import PARAMS

ANTENNA = short_file("siso_spur", 120.0, 8.0, 300.0, 150.0, rope={"type": "7x19-2.0"})
# A printed drum whose windows leave little web beside the slot.
SOFT = short_file("siso_bevel", 62.1, 1.9, 31.7, 0.052, support={"material": "pla"})
LIGHT = short_file("siso_spur", 40.0, 8.0, 60.0, 0.5)


def sized(data: dict[str, Any], **drum: Any) -> LoadedDesign:
    """As strength and place ask for it: any stiffness will do."""
    data = {**data, "loads": {**data["loads"], "stiffness_Nm_rad": 1.0}}
    return load_text(yaml.safe_dump({**data, **({"drum": drum} if drum else {})}))


def drum_g(loaded: LoadedDesign) -> float:
    drive = loaded.drive
    dims = layout_of(drive).drum
    return (
        float(DrumSector(dims, drive.screw(dims.set_screw).thread_mm).volume_mm3())
        * 1e-3
        * float(drive.drum_material.density_g_cm3)
    )


def turn(loaded: LoadedDesign) -> float:
    structure = structure_of(layout_of(loaded.drive))
    assert structure is not None
    return float(sum(c.urad_Nm for c in structure.causes if c.in_drum))


def test_a_stressed_web_has_no_windows_and_is_lighter_and_stiffer() -> None:
    closed, open_ = sized(ANTENNA), sized(ANTENNA, windows="outer")
    record = next(v for v in closed.sized if v.field == "drum.windows")
    assert (record.value, record.driver) == ("none", "drum_stress") and not layout_of(closed.drive).drum.windows
    assert layout_of(open_.drive).drum.windows and open_.drive.drum.windows == "outer"
    assert drum_g(closed) < 0.8 * drum_g(open_) and turn(closed) < 0.4 * turn(open_)
    for design in (closed, open_):
        assert statuses(design)["drum_stress"] == "pass"


def test_windows_that_cost_much_stiffness_for_their_mass_are_closed() -> None:
    closed, open_ = sized(SOFT, material="pla"), sized(SOFT, material="pla", windows="outer")
    assert closed.drive.drum.windows == "none" and not layout_of(closed.drive).drum.windows
    assert statuses(open_)["drum_stress"] == "pass", "stress alone closes them: this design shows nothing"
    assert turn(open_) * drum_g(open_) > CLOSED_GAIN * turn(closed) * drum_g(closed)


def test_a_web_that_bears_its_stress_keeps_them_and_a_file_may_close_them() -> None:
    usual, closed = sized(LIGHT), sized(LIGHT, windows="none")
    assert layout_of(usual.drive).drum.windows and not [v for v in usual.sized if v.field == "drum.windows"]
    assert not layout_of(closed.drive).drum.windows
    assert turn(closed) < turn(usual) and drum_g(closed) > drum_g(usual)
    assert drum_g(closed) == pytest.approx(drum_g(usual), rel=0.15)


@pytest.mark.parametrize(
    ("layout", "ratio", "radius_mm"), [("siso_spur", 8, 80), ("siso_bevel", 8, 60), ("miso_bevel", 9, 60)]
)
def test_a_printed_hub_is_as_wide_as_its_torsion_asks(layout: str, ratio: float, radius_mm: float) -> None:
    more = {"loads": {"stiffness_Nm_rad": 1.0}, "drum": {"material": "pla"}, "support": {"material": "pla"}}
    loaded = load_text(yaml.safe_dump(short_file(layout, 40.0, ratio, radius_mm, 4.0, **more)))
    record = next(v for v in loaded.sized if v.field == "drum.hub_diameter_mm")
    assert record.driver == "drum_stress", record
    drive = loaded.drive
    sector = layout_of(drive)
    assert isinstance(sector, SectorLayout)
    assert drum_stress(sector).holds, drum_stress(sector)
    narrower = layout_of(replace(drive, drum=replace(drive.drum, hub_diameter_mm=record.value - 1.0)))
    assert isinstance(narrower, SectorLayout)
    refused = drum_stress(narrower)
    assert "the hub" in refused.subject and not refused.holds, refused


def test_a_printed_web_bears_its_stress_beside_the_slot_of_a_thick_pin() -> None:
    more = {"transmission": {"centre_distance_mm": 34.0}, "rope": {"type": "7x7-0.45"}}
    more |= {part: {"material": "pa12"} for part in ("drum", "guide", "support")}
    layout = layout_of(load_text(yaml.safe_dump(short_file("miso_bevel", 50.2, 6.94, 31.4, 1.89, **more))).drive)
    assert isinstance(layout, SectorLayout)
    assert layout.drive.drum.stop_pin_mm >= 5.0 and drum_stress(layout).holds, drum_stress(layout)


RULES = (
    constant("a.first", 2.0, "always two", "nothing"),
    Rule("a.second", "twice the first", "a", lambda given: Found(2 * given["a.first"], "b", "none")),
    Rule("b.third", "the second and what may be", "c", lambda given: given["a.second"] + given.get("b.extra", 0.0)),
    Rule("b.never", "not of this design", "d", lambda given: 1.0, applies=lambda given: False),
)


def test_rules_fill_in_order_and_say_what_they_rest_on() -> None:
    sizing = fill(KnownFields({}), RULES)
    assert sizing.data == {"a": {"first": 2.0, "second": 4.0}, "b": {"third": 4.0}}
    second, third = sizing.values[1:]
    assert (second.driver, dict(second.rests_on)) == ("b", {"a.first": 2.0})
    assert (third.driver, dict(third.rests_on)) == ("c", {"a.second": 4.0})


def test_what_is_given_is_a_pin_and_what_follows_rests_on_it() -> None:
    sizing = fill(KnownFields({"a": {"second": 7.0}, "b": {"extra": 0.5}}), RULES)
    assert sizing.of("a.second") is None
    third = sizing.of("b.third")
    assert third is not None and third.value == 7.5
    assert dict(third.rests_on) == {"a.second": 7.0, "b.extra": 0.5}


def test_a_rule_that_stands_too_early_is_found() -> None:
    with pytest.raises(KeyError, match=r"a\.second is not known"):
        fill(KnownFields({}), RULES[2:])


def test_the_need_that_sets_a_value_is_named() -> None:
    assert largest({"low": 1.0, "high": 2.01}, 0.5) == Found(2.5, "high", "up to 0.5")


@pytest.mark.parametrize(("value", "up", "down"), [(0.3, 0.3, 0.3), (0.30000001, 0.4, 0.3), (-1.05, -1.0, -1.1)])
def test_rounding_leaves_what_is_on_its_step(value: float, up: float, down: float) -> None:
    assert (rounded_up(value, 0.1), rounded_down(value, 0.1)) == (up, down)


def test_an_unknown_part_is_bad_input() -> None:
    given = KnownFields({"drive": {"motor": "none"}})
    with pytest.raises(SizingError) as refused:
        given.entry("motors", "drive.motor")
    (broken,) = refused.value.broken
    assert broken.path == ("drive", "motor") and "known here: motor-" in broken.remedy


@pytest.fixture(scope="module")
def whole() -> dict[str, Any]:
    return dict(load_text(yaml.safe_dump(short_file("siso_spur", 35.0, 8.0, 60.0, 2.0))).data)


def trial(whole: dict[str, Any], block: str, **values: Any) -> dict[str, Any]:
    found = copy.deepcopy(whole)
    found[block] |= values
    return found


def test_trials_give_the_same_in_a_row_as_each_alone(whole: dict[str, Any]) -> None:
    given = SpurKnown(copy.deepcopy(whole), {})
    asked = ("tension", "drum_bearings", "input_bearings", "lug_stress", "hub_walls", "free_span")
    trials = [
        whole,
        trial(whole, "drum", outer_face_y_mm=9.0),
        trial(whole, "transmission", centre_distance_mm=80.0),
        trial(whole, "rope", preload_N=30.0),
        trial(whole, "loads", test_torque_Nm=1.9),
        trial(whole, "drum", outer_face_y_mm=-1e9),
        whole,
    ]
    checks, schema = SpurLayout.checks_by_id(), SpurLayout.design_file().schema
    in_a_row = [given.drives.margins(data, asked, checks) for data in trials]
    alone = [TrialDrives(schema, given.of_design).margins(data, asked, checks) for data in trials]
    assert in_a_row == alone
    assert in_a_row[0] == in_a_row[-1] != in_a_row[3]


def test_what_is_known_already_is_not_worked_out_again(whole: dict[str, Any]) -> None:
    made = list[Any]()
    given = SpurKnown(copy.deepcopy(whole), {})

    def of_design(design: Any) -> Any:
        made.append(design)
        return given.of_design(design)

    drives = TrialDrives(given.layout.design_file().schema, of_design)
    for data in (whole, trial(whole, "drum", web_thickness_mm=3.0), copy.deepcopy(whole)):
        drives.margins(data, ("hub_walls",), SpurLayout.checks_by_id())
    first, second = made
    assert second.support is first.support and second.drum.web_thickness_mm == 3.0


class Margins(DirectKnown):
    """Margins of a field by formula: ``near`` from 3 mm on, ``far`` from 5, ``never`` at no value."""

    def margins(
        self, field: str, value: Any, checks: Iterable[str], to_first_miss: bool = False
    ) -> dict[str, tuple[float, str]]:
        known = {"near": value - 3.0, "far": value - 5.0, "never": -20.0 - value, "below": 4.0 - value}
        return {name: (known[name], "mm") for name in checks}


@pytest.mark.parametrize(
    ("checks", "value", "words"),
    [
        (("near", "far"), 5.0, "up to 0.1"),
        (("near", "never"), 3.0, "no value meets never"),
        # Each holds somewhere, both nowhere: the value that misses least.
        (("far", "below"), 5.0, "no value passes"),
    ],
)
def test_moved(checks: tuple[str, ...], value: float, words: str) -> None:
    found = Margins({}, {}).moved("drum.hub_diameter_mm", 1.0, 0.1, checks)
    assert found.value == pytest.approx(value) and words in found.rounding, found


def test_a_check_left_out_in_a_pass_before_is_not_named_when_it_holds() -> None:
    """What no value met in the first pass may hold once the fields it depends on are known."""
    known = Margins({}, {})
    assert "no value meets never" in known.moved("drum.hub_diameter_mm", 1.0, 0.1, ("near", "never")).rounding
    known.margins = lambda field, value, checks, to_first_miss=False: dict.fromkeys(checks, (value - 3.0, "mm"))  # type: ignore[method-assign,misc]
    found = known.moved("drum.hub_diameter_mm", 1.0, 0.1, ("near", "never"))
    assert found.value == pytest.approx(3.0) and "never" not in found.rounding, found


@pytest.mark.parametrize(
    ("checks", "value", "words"),
    [
        (("near", "far"), 6.0, "first that does"),
        (("near", "never"), 4.0, "no candidate meets never"),
        (("never",), 1.0, "no candidate does"),
    ],
)
def test_first(checks: tuple[str, ...], value: float, words: str) -> None:
    found = Margins({}, {}).first("drum.bearing", (1.0, 2.0, 4.0, 6.0), checks)
    assert found.value == value and words in found.rounding, found


def test_first_of_nothing_is_told() -> None:
    with pytest.raises(ValueError, match="no entry that fits"):
        Margins({}, {}).first("drum.bearing", (), ("near",))


# The bound on drives without a guide: what it excludes and why; it does not exclude the references.


REFERENCES = {
    "siso_bevel": Asked(4.5, 58.05, 35.0, 0.98, "FF-081"),
    "siso_spur": Asked(9.9, 59.4, 35.0, 2.15, "FF-081"),
}


@pytest.mark.parametrize("layout", REFERENCES)
def test_a_reference_is_within_the_bound(layout: str) -> None:
    assert excluding(layout, REFERENCES[layout]) == ((), "")


@pytest.mark.parametrize(
    ("layout", "changed", "names", "why"),
    [
        ("siso_bevel", {"ratio": 5.0}, ("ratio", "travel"), "360 degrees"),
        ("siso_bevel", {"radius": 30.0}, ("radius",), "higher than the drum's radius"),
        ("siso_bevel", {"rope": "uhmwpe-2"}, ("ratio", "radius", "rope"), "the rope's stop"),
        # A 4 mm bearing would fit behind the drum, but no key passes it to the gearhead's screws.
        ("siso_bevel", {"ratio": 5.6, "radius": 43.5, "travel": 20.0, "rope": None}, ("ratio", "radius"), "no bearing"),
        ("siso_spur", {"rope": "7x7-1.0", "ratio": 14.0}, ("ratio", "radius", "rope"), "too thin for the bend"),
        ("siso_spur", {"surface": "smooth", "ratio": 13.0}, ("ratio", "radius", "rope", "surface"), "slope too much"),
        ("siso_spur", {"rope": "uhmwpe-0.8", "torque": 20.0}, ("radius", "torque", "rope"), "too weak"),
    ],
)
def test_what_excludes_itself_is_named(
    layout: str, changed: dict[str, float | str], names: tuple[str, ...], why: str
) -> None:
    found = excluding(layout, replace(REFERENCES[layout], **changed))  # type: ignore[arg-type]
    assert found[0] == names and why in found[1], found


def test_the_column_s_least_height_grows_with_wall_and_rope() -> None:
    thin, thick = least_column_mm(0.8, 0.3), least_column_mm(1.2, 2.0)
    # Three walls of 0.4 mm more, 0.2 mm of the shelf (at least 3 mm), and 0.85 mm of rope.
    assert thin == pytest.approx(41.3) and thick - thin == pytest.approx(3 * 0.4 + 0.2 + 0.85), f"{thin}, {thick}"


@pytest.mark.parametrize("name", ["mbcdm", "siso_spur", "miso_spur", "siso_bevel"])
def test_the_knee_of_the_computed_curve_is_the_mean_of_its_ends(name: str) -> None:
    """A swing a + b/T is furthest from its chord at sqrt(T_0 T_1); the curve of the whole model is nearly one."""
    rule = preload_rule(layout_of(load_design(PARAMS / f"{name}.yaml").drive))
    assert rule.knee_N == pytest.approx((rule.slack_N * rule.most_N) ** 0.5, rel=0.04)
