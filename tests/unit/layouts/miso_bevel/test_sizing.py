"""Sizing of miso_bevel: the reference from its requirements, laws for every file, the first guess of the frame."""

import copy
from typing import Any

import pytest
import yaml

from mbcdm_cad.checks.drum_sector import hub_length, stop_slot
from mbcdm_cad.checks.size import kept_mass_g
from mbcdm_cad.checks.structure import drum_stress, frame_windup, mounting_screws, payload_screws
from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.design.sized import SizedValue
from mbcdm_cad.design.yamltree import leaves
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import layout_of, load_design, load_text, reference_data
from mbcdm_cad.layouts.miso_bevel.checks.spans import input_walk
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.sizing import size
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.solving.question import question_of
from tests.support.checked import failing, short_file
from tests.support.reference import PARAMS

REFERENCE = reference_data()


def sector_of(loaded: LoadedDesign) -> SectorLayout:
    layout = layout_of(loaded.drive)
    assert isinstance(layout, SectorLayout)
    return layout


# What the reference states: the paper's tables, its torques and parts, its mass and box, and one depth.
STATED = [
    *("name", "configuration", "travel.half_angle_deg"),
    *("transmission.centre_distance_mm", "transmission.drum_radii_mm", "transmission.ratios"),
    *("rope.type", "rope.modulus_GPa", "rope.modulus_area", "rope.friction_coefficient", "rope.preload_N"),
    *("drive", "loads", "limits.bend_ratio_min", "limits.frame_windup_max_mrad", "limits.losses"),
    *("targets", "support.back_y_mm"),
]


def stated() -> dict[str, Any]:
    """The reference design with every field left out that a rule gives."""
    data: dict[str, Any] = {}
    for path in STATED:
        *blocks, last = path.split(".")
        source, at = REFERENCE, data
        for block in blocks:
            source, at = source[block], at.setdefault(block, {})
        at[last] = copy.deepcopy(source[last])
    return data


def test_the_sized_reference_passes_every_check_and_turns_no_more_than_the_stated_one() -> None:
    """Rules need not choose the paper's values, but mass times turn is as low as with them."""
    sized, whole = (load_text(yaml.safe_dump(data)) for data in (stated(), REFERENCE))
    assert failing(sized) == {}
    worth = [kept_mass_g(layout) / structure_of(layout).stiffness_Nm_rad for layout in map(sector_of, (sized, whole))]
    assert worth[0] <= 1.01 * worth[1], worth


def test_a_short_file_gives_a_whole_drive() -> None:
    data = short_file("miso_bevel", 35.0, 9.0, 54.0, 3.0)
    del data["name"]
    loaded = load_text(yaml.safe_dump(data), "short_one.yaml")
    assert loaded.drive.name == "short_one" and len(loaded.sized) > 45
    ratios = [c.drum_radius_mm / c.input_radius_mm for c in loaded.drive.cables]
    assert ratios == pytest.approx([9.0] * 4, rel=1e-6), ratios


def test_twice_the_size_takes_a_rope_of_one_and_a_half_millimetres() -> None:
    loaded = load_text(yaml.safe_dump(short_file("miso_bevel", 35.0, 9.0, 108.0, 3.15, rope={"type": "7x7-1.5"})))
    assert loaded.drive.cable.diameter_mm == 1.5
    assert failing(loaded) == {}


@pytest.mark.parametrize(("radius_mm", "ratio", "setback_mm"), [(70.0, 4.5, 0.0), (50.0, 5.0, 20.0)])
def test_wide_motors_pass_beside_a_large_guide_or_are_set_back(
    radius_mm: float, ratio: float, setback_mm: float
) -> None:
    """Motors of 87 mm without gearhead: beside the smaller drum so large a guide leaves its terminals no way."""
    more = {"drive": {"motor": "tmotor-u8-100kv", "gearhead": "none"}}
    more |= {part: {"material": "pla"} for part in ("drum", "guide", "support")}
    loaded = load_text(yaml.safe_dump(short_file("miso_bevel", 35.0, ratio, radius_mm, 3.0, **more)))
    assert loaded.drive.input_setback_mm >= setback_mm, loaded.drive.input_setback_mm
    assert failing(loaded) == {}


@pytest.mark.parametrize(
    ("radius_mm", "torque_Nm", "bearing", "encoder"),
    [
        (34.6, 4.64, "618/4", "encoder-17"),
        (34.6, 1.0, "618/5", "encoder-19-ring-5"),
        (38.0, 4.64, "618/5", "encoder-19-ring-5"),
    ],
)
def test_a_small_drum_that_pulls_hard_gets_the_smaller_boss(
    radius_mm: float, torque_Nm: float, bearing: str, encoder: str
) -> None:
    """The lighter pair would leave no web beside the stop's slot."""
    more = {"loads": {"stiffness_Nm_rad": 1.0}, "rope": {"type": "uhmwpe-0.8"}}
    loaded = load_text(yaml.safe_dump(short_file("miso_bevel", 13.2, 4.3, radius_mm, torque_Nm, **more)))
    assert failing(loaded) == {}
    assert (loaded.design.drum.bearing, loaded.design.drive.drum_encoder) == (bearing, encoder)


@pytest.mark.parametrize(
    ("radius_mm", "ratio", "travel_deg"), [(40.0, 3.2, 50.0), (45.0, 4.0, 50.0), (60.0, 3.2, 60.0)]
)
def test_at_a_small_ratio_the_terminals_take_up_the_cable_on_guide_and_inputs(
    radius_mm: float, ratio: float, travel_deg: float
) -> None:
    """Half of a cable lies on a guide of half the drum's radius and on the inputs; a fibre rope beds in by 1 %."""
    data = short_file("miso_bevel", travel_deg, ratio, radius_mm, 1.0, rope={"type": "uhmwpe-0.8"})
    loaded = load_text(yaml.safe_dump(data))
    assert failing(loaded) == {}


FIGURES = [found for found in size(stated()).values if isinstance(found.value, float)]


@pytest.mark.parametrize("found", FIGURES, ids=lambda found: found.field)
def test_a_pin_stays_where_it_is(found: SizedValue) -> None:
    data = stated()
    *blocks, last = found.field.split(".")
    at = data
    for block in blocks:
        at = at.setdefault(block, {})
    at[last] = round(found.value * 1.01, 6)
    sizing = size(data)
    assert sizing.of(found.field) is None
    at = sizing.data
    for block in blocks:
        at = at[block]
    assert at[last] == round(found.value * 1.01, 6)


@pytest.mark.parametrize(
    ("field", "said"),
    [
        ("travel.half_angle_deg", "travel.half_angle_deg: missing"),
        ("loads.peak_torque_Nm", "loads.peak_torque_Nm: missing"),
        ("transmission.drum_radii_mm", "transmission.drum_radius_mm: missing"),
    ],
)
def test_a_requirement_cannot_be_left_out(field: str, said: str) -> None:
    data = stated()
    block, last = field.split(".")
    del data[block][last]
    with pytest.raises(InputError) as refused:
        load_text(yaml.safe_dump(data), "f.yaml")
    assert said in str(refused.value), refused.value


def test_a_whole_file_is_left_to_no_rule_and_the_short_one_holds_its_mass_and_box() -> None:
    short, whole = load_design(PARAMS / "mbcdm-short.yaml"), load_design(PARAMS / "mbcdm.yaml")
    assert not whole.sized and len(short.sized) > 40, len(short.sized)
    assert failing(short) == failing(whole) == {}


def test_one_dimension_is_held_by_hand() -> None:
    question = question_of((PARAMS / "mbcdm-short.yaml").read_text("utf-8"))
    assert list(question.releases) == ["support.back_y_mm"]
    assert len(list(leaves(question.data))) <= 20


# A rope that is stiff beside a printed frame, and a torque at which M3 slip on it.
STIFF_ROPE = """name: soft-frame
configuration: miso_bevel
travel: {half_angle_deg: 18.6}
transmission: {ratio: 4.48, drum_radius_mm: 72.4}
loads: {peak_torque_Nm: 0.572}
rope: {type: 7x19-0.81}
drum: {material: pa12}
guide: {material: pa12}
"""
HIGH_TORQUE = """name: strong
configuration: miso_bevel
travel: {half_angle_deg: 41.1}
transmission: {ratio: 12.3, drum_radius_mm: 130.0}
loads: {peak_torque_Nm: 37.2}
drum: {material: pa12}
guide: {material: pa12}
"""
# A rope beside which back plate and ribs alone are not enough.
STIFFER_ROPE = """name: softer-frame
configuration: miso_bevel
travel: {half_angle_deg: 27.6}
transmission: {ratio: 7.39, drum_radius_mm: 89.7}
loads: {peak_torque_Nm: 5.9}
rope: {type: vectran-1.5}
drum: {material: pa12}
guide: {material: pa12}
"""
PRINTED = "support: {material: pa12%s}\n"


def _sized(text: str) -> BevelLayout:
    layout = layout_of(load_text(text, "a.yaml").drive)
    assert isinstance(layout, BevelLayout)
    return layout


@pytest.mark.parametrize(
    ("text", "walls"),
    [
        (STIFF_ROPE, ", back_plate_mm: 4.0, rib_mm: 4.0, side_wall_mm: 4.0"),
        (HIGH_TORQUE, ", back_plate_mm: 7.0, rib_mm: 8.0, side_wall_mm: 6.0"),
        (STIFFER_ROPE, ", back_plate_mm: 7.0, rib_mm: 8.0, side_wall_mm: 6.0"),
    ],
)
def test_walls_of_a_printed_frame_follow_from_its_windup(text: str, walls: str) -> None:
    by_rule, usual = _sized(text + PRINTED % ""), _sized(text + PRINTED % walls)
    assert frame_windup(by_rule).holds, frame_windup(by_rule)
    assert not frame_windup(usual).holds, "usual walls hold: this design shows nothing"


def test_mounting_screws_follow_from_the_torque() -> None:
    by_rule, smallest = _sized(HIGH_TORQUE + PRINTED % ""), _sized(HIGH_TORQUE + PRINTED % ", mount_screw: M3")
    found = mounting_screws(by_rule)
    assert found.holds and by_rule.mounting.name in found.subject, found
    assert by_rule.mounting.thread_mm > 3.0 and not mounting_screws(smallest).holds, mounting_screws(smallest)
    # The rules choose the thinnest that holds.
    thinner = {"M6": "M5", "M5": "M4", "M4": "M3"}[by_rule.mounting.name]
    less = _sized(HIGH_TORQUE + PRINTED % f", mount_screw: {thinner}")
    assert not mounting_screws(less).holds, mounting_screws(less)


def test_heads_on_washers_have_room() -> None:
    layout = _sized(HIGH_TORQUE + PRINTED % "")
    assert layout.mount_washers and layout.frame.mount_head_radius > layout.mounting.washer_mm / 2
    milled = _sized(HIGH_TORQUE + "support: {material: aluminium-7075}\n")
    assert not milled.mount_washers and milled.mounting.name == "M3", milled.mounting


def test_more_payload_screws_hold_the_torque_on_a_hub_that_leaves_a_wall_to_the_stop_slot() -> None:
    by_rule, four = (
        _sized(HIGH_TORQUE + PRINTED % ""),
        _sized(HIGH_TORQUE.replace("drum: {", "drum: {output_screws: 4, ") + PRINTED % ""),
    )
    assert len(by_rule.drum.payload_places) > 4 and stop_slot(by_rule).holds, stop_slot(by_rule)
    assert payload_screws(by_rule).holds
    assert not (stop_slot(four).holds and payload_screws(four).holds), "four screws hold: this design shows nothing"


def test_a_hub_is_longer_where_its_set_screws_stand_behind_the_payloads_holes() -> None:
    text = "name: strong\nconfiguration: miso_bevel\ntravel: {half_angle_deg: 59.7}\nloads: {peak_torque_Nm: 23.4}\n"
    by_rule = _sized(text + "transmission: {ratio: 3.46, drum_radius_mm: 48.5}\ndrum: {output_screws: 5}\n")
    d = by_rule.drum
    assert hub_length(by_rule).holds, hub_length(by_rule)
    assert d.hub_face_y - d.payload_depth > d.set_screw_y > d.web_end_y


def test_a_printed_web_has_no_windows_beside_which_it_bears_too_little() -> None:
    text = (
        "name: a\nconfiguration: miso_bevel\ntravel: {half_angle_deg: 51.8}\n"
        "transmission: {ratio: 11.9, drum_radius_mm: 131.0}\nloads: {peak_torque_Nm: 11.8, stiffness_Nm_rad: 1.0}\n"
        "support: {material: pa12}\n"
    )
    by_rule, windows = (
        _sized(text + "drum: {material: pa12}\n"),
        _sized(text + "drum: {material: pa12, windows: outer}\n"),
    )
    assert drum_stress(by_rule).holds and not by_rule.drum.windows, drum_stress(by_rule)
    webs = [layout.drive.drum.web_thickness_mm for layout in (by_rule, windows)]
    assert not drum_stress(windows).holds or webs[1] > webs[0], "the web bears enough beside windows"


def test_the_lead_leaves_room_between_the_steps() -> None:
    thick = "name: thick\nconfiguration: miso_bevel\ntravel: {half_angle_deg: 59.0}\nrope: {type: 1x19-2}\n"
    layout = _sized(thick + "transmission: {ratio: 7.13, drum_radius_mm: 113.0}\nloads: {peak_torque_Nm: 12.9}\n")
    assert input_walk(layout).holds, input_walk(layout)
