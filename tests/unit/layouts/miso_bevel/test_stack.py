"""Levels along Y and Z: identities of the envelope, order, clearances, and the effect of each field."""

from dataclasses import fields, replace
from math import radians
from typing import Any

import pytest

from mbcdm_cad.layouts.miso_bevel.cable_path import guide_landing_walk_mm, winding
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.stack import band, stack
from mbcdm_cad.parts.drum_sector.design import END_PLAY_MM, SHELF_GAP_MM
from mbcdm_cad.parts.input_pulley.dims import helix_stop_land_mm


def test_height_is_the_sum_of_what_stands_on_each_other(drive: BevelDrive, dims: BevelLayout) -> None:
    """Motor, gearhead, motor shelf, coupling space, bearing shelf, gap, pulley, gap and play, top plate, encoder."""
    pulley = dims.inputs[0].land_top_z - dims.inputs[0].land_bottom_z
    low = min(p.land_bottom_z for p in dims.inputs)
    high = max(p.land_top_z for p in dims.inputs)
    assert pulley < high - low
    s = drive.support
    expected = (
        drive.motor.length_mm
        + drive.gearhead.length_mm
        + s.motor_shelf_mm
        + s.coupling_space_mm
        + s.bearing_shelf_mm
        + (high - low)
        + 2 * SHELF_GAP_MM
        + END_PLAY_MM
        + s.top_plate_mm
        + drive.encoder.length_mm
    )
    assert dims.levels.height_mm == pytest.approx(expected, rel=1e-12)
    assert dims.levels.height_mm == pytest.approx(drive.targets.envelope_mm[1], abs=drive.targets.envelope_tolerance_mm)


def test_depth_runs_from_the_back_plate_to_the_hubs_face(drive: BevelDrive, dims: BevelLayout) -> None:
    assert dims.levels.depth_mm == drive.drum.hub_face_y_mm - drive.support.back_y_mm
    assert dims.levels.depth_mm == pytest.approx(34.8, abs=1e-12)


def test_levels_are_in_order(dims: BevelLayout) -> None:
    v = dims.levels
    up = [
        v.motor_bottom_z,
        v.gearhead_bottom_z,
        v.motor_shelf_bottom_z,
        v.motor_shelf_top_z,
        v.bearing_shelf_bottom_z,
        v.bearing_shelf_top_z,
        v.guide_bottom_z,
        v.guide_top_z,
        v.top_plate_bottom_z,
        v.top_plate_top_z,
        v.encoder_top_z,
    ]
    assert up == sorted(up)
    back = [v.back_y, v.pocket_floor_y, v.front_y, v.boss_front_y, v.drum_inner_y, v.drum_outer_y, v.hub_face_y]
    assert back == sorted(back)


def test_input_pulley_reaches_past_its_turns_by_the_slots_wall(drive: BevelDrive, dims: BevelLayout) -> None:
    for pulley in dims.inputs:
        low, high = sorted((c for c in drive.cables if c.input_name == pulley.name), key=lambda c: c.step)
        assert pulley.land_bottom_z == band(drive, low).low_mm - helix_stop_land_mm(drive)
        assert pulley.land_top_z == band(drive, high).high_mm + helix_stop_land_mm(drive)
        assert pulley.land_bottom_z < low.drum_radius_mm < pulley.wall_z < high.drum_radius_mm < pulley.land_top_z


@pytest.mark.parametrize("stop_radius_ratio", [1.0, 2.0])
def test_no_stop_stands_out_of_its_pulley(drive: BevelDrive, stop_radius_ratio: float) -> None:
    """A rope of 2 mm has a stop that is thicker than the slot's wall; beyond the land are shelf and top plate."""
    thick = replace(drive, termination=replace(drive.termination, stop_radius_ratio=stop_radius_ratio))
    for pulley in BevelLayout(thick).inputs:
        for slot in pulley.slots:
            beyond = max(pulley.land_bottom_z - (slot.chord_z - slot.stop_radius), 0.0)
            beyond = max(slot.chord_z + slot.stop_radius - pulley.land_top_z, beyond)
            assert beyond < 1e-9, f"{slot.cable_name}: {beyond:.3f} mm"


def test_dead_turns_lie_on_the_outer_ends(drive: BevelDrive) -> None:
    """Both helices of a pulley have the same hand and wind apart, or they would meet in the middle."""
    for cable in drive.cables:
        outward, limits = winding(drive, cable).outward, band(drive, cable)
        assert outward == (1 if cable.step in (2, 4) else -1)
        assert abs(limits.dead_end_mm - cable.drum_radius_mm) == pytest.approx(0.761 + 0.87, abs=0.001)
        assert (limits.dead_end_mm - cable.drum_radius_mm) * outward > 0


def test_guide_is_longer_than_the_steps_by_walk_and_flank(drive: BevelDrive, dims: BevelLayout) -> None:
    r = [c.drum_radius_mm for c in drive.cables]
    walk = max(guide_landing_walk_mm(drive, c) for c in drive.cables)
    flank = drive.cable.diameter_mm / 2
    assert dims.levels.guide_bottom_z < r[0] - flank - walk - 0.5
    assert dims.levels.guide_top_z > r[-1] + flank + walk + 0.5


def test_bodies_come_closest_at_the_transfer(drive: BevelDrive, dims: BevelLayout) -> None:
    """0.155 mm from the guide's first step to the drum's inner face, 0.255 at the walls: no cable slips in."""
    gap = dims.levels.drum_inner_y - dims.guide.surface_radii[0]
    assert gap == pytest.approx(drive.clearances.transfer_gap_mm, abs=1e-12) and gap < drive.cable.diameter_mm / 2
    walls = [land.y_start for land in dims.drum.lands[1:]]
    assert walls == pytest.approx([9.45, 10.05, 10.65], abs=1e-12)
    at_walls = [wall - radius for wall, radius in zip(walls, dims.guide.surface_radii[1:], strict=True)]
    assert at_walls == pytest.approx([0.255] * 3, abs=1e-12)


def test_frame_stays_clear_of_the_drum_and_of_the_tensioners(drive: BevelDrive, dims: BevelLayout) -> None:
    v, running = dims.levels, drive.clearances.running_mm
    nut = drive.tensioner.nut_across_flats_mm / 3**0.5
    assert v.front_y + running <= min(t.y_mm for t in dims.drum.tensioners) - nut + 1e-12
    assert v.front_y + running <= v.drum_inner_y
    assert v.boss_front_y == dims.drum.spigot_y < dims.drum.hub_start_y < dims.drum.web_start_y


def test_walls_stand_beside_the_widest_of_what_turns_and_hangs_there(drive: BevelDrive, dims: BevelLayout) -> None:
    half_room = dims.levels.side_inner_x - drive.centre_distance_mm
    flank = drive.cable.diameter_mm / 2
    for what, radius in {
        "gearhead": drive.gearhead.diameter_mm / 2,
        "motor": drive.motor.diameter_mm / 2,
        "cable on the pulley": max(c.input_radius_mm for c in drive.cables) + flank,
        "collar": dims.collar.radius,
    }.items():
        assert half_room - radius >= drive.clearances.running_mm - 1e-9, f"{what}: {half_room - radius:.3f} mm"


# field of the drive or of its blocks, and the level that must follow it one to one.
FOLLOWS: list[tuple[str, str, str, int]] = [
    ("support", "motor_shelf_mm", "motor_bottom_z", -1),
    ("support", "coupling_space_mm", "motor_shelf_top_z", -1),
    ("support", "bearing_shelf_mm", "bearing_shelf_bottom_z", -1),
    ("support", "top_plate_mm", "encoder_top_z", +1),
    ("support", "side_wall_mm", "side_outer_x", +1),
    ("support", "back_y_mm", "back_y", +1),
    ("support", "back_plate_mm", "pocket_floor_y", +1),
    ("drum", "outer_face_y_mm", "drum_outer_y", +1),
    ("drum", "hub_face_y_mm", "hub_face_y", +1),
    ("clearances", "transfer_gap_mm", "drum_inner_y", +1),
    ("", "centre_distance_mm", "side_inner_x", +1),
]


@pytest.mark.parametrize(("block", "field", "level", "sign"), FOLLOWS, ids=lambda v: str(v))
def test_a_level_follows_its_field(drive: BevelDrive, block: str, field: str, level: str, sign: int) -> None:
    before: Any = getattr(drive, block) if block else drive
    moved = replace(before, **{field: getattr(before, field) + 0.125})
    after = stack(replace(drive, **{block: moved}) if block else moved)
    change = getattr(after, level) - getattr(stack(drive), level)
    if (block, field) == ("", "centre_distance_mm"):
        # The walk on the guide shrinks a little with the span, which moves nothing along x.
        assert change == pytest.approx(0.125, abs=1e-12)
    assert change == pytest.approx(sign * 0.125, abs=1e-12), f"{level} moved by {change}"


def test_longer_travel_makes_longer_pulleys(drive: BevelDrive) -> None:
    """Walk outward at the top of one pulley, inward at the bottom of the other: p i_c / 2 pi mm per rad each way."""
    more = stack(replace(drive, half_travel_deg=drive.half_travel_deg + 5.0))
    per_rad = drive.helix_lead_mm * 9 / (2 * 3.141592653589793)
    change = more.top_plate_bottom_z - stack(drive).top_plate_bottom_z
    assert change == pytest.approx(per_rad * radians(5.0), rel=1e-9)


def test_every_level_is_a_finite_number(dims: BevelLayout) -> None:
    for field in fields(dims.levels):
        value = getattr(dims.levels, field.name)
        assert abs(value) < 1e3, f"{field.name} = {value}"
