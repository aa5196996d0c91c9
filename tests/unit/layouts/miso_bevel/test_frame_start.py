"""Screws and walls of the frame follow from torque and stiffness where the file leaves them open."""

import pytest

from mbcdm_cad.checks.drum_sector import hub_length, stop_slot
from mbcdm_cad.checks.structure import drum_stress, frame_windup, mounting_screws, payload_screws
from mbcdm_cad.layouts.loader import layout_of, load_text
from mbcdm_cad.layouts.miso_bevel.checks.spans import input_walk
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout

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
