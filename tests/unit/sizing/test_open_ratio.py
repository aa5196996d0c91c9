"""A file without ratio and motor: what it asks for chooses both, and no other ratio gives a lighter drive."""

import re
from math import inf
from typing import Any

import pytest

from mbcdm_cad.checks.size import kept_mass_g
from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.design.rules import Broken
from mbcdm_cad.design.sized import Sizing, SizingError
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.loader import layout_of, load_text
from mbcdm_cad.layouts.open_ratio import RATIOS, lightest
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.report.check_report import check_design
from mbcdm_cad.sizing.known import KnownFields
from mbcdm_cad.sizing.rule import Rule
from mbcdm_cad.solving.question import Fixed, Point, Times, question_of
from mbcdm_cad.solving.trials import Trials
from tests.support.checked import failing

RATIO = {"siso_spur": "input_to_drum", "miso_spur": "input_to_drum", "miso_bevel": "ratio"}


def _text(layout: str, loads: str, ratio: float | None = None) -> str:
    stated = "" if ratio is None else f"{RATIO[layout]}: {ratio}, "
    return (
        f"name: open\nconfiguration: {layout}\ntravel: {{half_angle_deg: 35}}\n"
        f"transmission: {{{stated}drum_radius_mm: 60}}\nloads: {{peak_torque_Nm: 2, {loads}}}\n"
    )


def _ratio(found: LoadedDesign) -> Any:
    field = f"transmission.{RATIO[layout_of(found.drive).name]}"
    return next(value.value for value in found.sized if value.field == field)


def _mass_g(found: LoadedDesign) -> float:
    layout = layout_of(found.drive)
    return kept_mass_g(layout)


def _failing(found: LoadedDesign) -> list[str]:
    return list(failing(found.drive))


@pytest.mark.parametrize("layout", RATIO)
def test_ease_of_turning_chooses_ratio_motor_and_gearhead(layout: str) -> None:
    found = load_text(_text(layout, "backdrive_Nm: 0.3"))
    assert not _failing(found)
    back = layout_of(found.drive).losses.backdrive
    assert back is not None and back.start_Nm <= 0.3
    if layout == "siso_spur":
        assert _mass_g(load_text(_text(layout, "test_torque_Nm: 0.6"))) < _mass_g(found), "the wish costs mass"


def test_no_other_ratio_gives_a_lighter_drive_as_fast() -> None:
    """Each of them stated in a file of its own; between the round ones the mass may fall a little further."""
    found = load_text(_text("siso_spur", "speed_deg_s: 400, continuous_torque_Nm: 1"))
    assert not _failing(found)
    others = {
        r: load_text(_text("siso_spur", "speed_deg_s: 400, continuous_torque_Nm: 1", r)) for r in (*RATIOS, 7.0, 14.0)
    }
    passing = {ratio: _mass_g(one) for ratio, one in others.items() if not _failing(one)}
    assert len(passing) > 4 and _ratio(found) == min(RATIOS, key=lambda r: passing.get(r, inf)), passing
    assert _mass_g(found) <= 1.05 * min(passing.values()), passing


def test_a_file_that_states_what_was_chosen_is_the_same_drive() -> None:
    found = load_text(_text("siso_spur", "backdrive_Nm: 0.3"))
    stated = load_text(_text("siso_spur", "backdrive_Nm: 0.3", _ratio(found)))
    assert stated.drive == found.drive
    told, motor = check_design(found).text(), found.drive.motor.name
    assert f"chosen for the lightest drive: transmission.input_to_drum {_ratio(found)}, drive.motor {motor}, " in told
    # The lightest drive is a slow one, which a file that asks for no speed would not learn.
    assert re.search(r"N m [0-9.]+ deg/s \(loads.speed_deg_s asks for more\)", told), told
    assert "chosen" not in check_design(stated).text()


def test_where_none_does_the_nearest_is_shown() -> None:
    found = load_text(_text("miso_spur", "backdrive_Nm: 0.01"))
    assert _failing(found) == ["backdrive"]


def test_a_search_moves_the_ratio_from_what_was_chosen() -> None:
    asked = question_of(_text("siso_spur", "backdrive_Nm: 0.3"))
    near, alone = Trials(asked, jobs=1), Trials(asked, jobs=1)
    start = near.begin_at({})
    assert start is not None and start.sizing is not None and start.sizing.ratio in RATIOS
    moved: list[Point] = [{"transmission.input_to_drum": Times(0.9)}, {"drum.hub_diameter_mm": Times(1.1)}]
    assert near.many(moved) == alone.many(moved)
    found = asked.resolve(*asked.trial(moved[0]), start.sizing)
    assert found.data["transmission"]["input_to_drum"] == pytest.approx(0.9 * start.sizing.ratio)
    assert near({"transmission.input_to_drum": Fixed(8.0)}).passes


def test_a_fault_of_the_file_is_told_as_such() -> None:
    with pytest.raises(InputError, match=r"rope.type: not in the catalogue of ropes"):
        load_text(_text("siso_spur", "test_torque_Nm: 0.5") + "rope: {type: nowhere}\n")


def test_what_no_ratio_gives_is_told_with_its_reason() -> None:
    def none(data: Any, moved: Any, similar: Any, ratio: tuple[Rule, ...]) -> Sizing:
        raise SizingError(Broken(("drum",), f"too thin at {ratio[0].value(KnownFields({})).value:g}", "", "", ""))

    with pytest.raises(SizingError, match=r"no ratio from 2 to 20 gives a drive: too thin at 2"):
        lightest(none, "transmission.input_to_drum", {"name": "none"}, None, None, layout=SpurLayout)


def test_drives_without_figures_at_every_ratio_are_a_fault_of_the_file_too() -> None:
    def none(data: Any, moved: Any, similar: Any, ratio: tuple[Rule, ...]) -> Sizing:
        raise NoFigureError("no free span")

    with pytest.raises(SizingError, match=r"no ratio from 2 to 20 gives a drive: no free span"):
        lightest(none, "transmission.input_to_drum", {"name": "without"}, None, None, layout=SpurLayout)
