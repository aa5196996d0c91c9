"""Input pulleys, collar, guide and axle: walls, clearances and seats."""

from dataclasses import replace
from math import hypot, sqrt

import pytest

from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.support import plate_screw_of
from mbcdm_cad.parts.coupling import collar_sweep_mm


def test_surfaces_are_cut_at_half_a_cable_under_the_pitch_radii(dims: BevelLayout) -> None:
    assert dims.guide.surface_radii == pytest.approx((8.595, 9.195, 9.795, 10.395), abs=1e-12)
    cut = [(p.lower_surface_radius, p.upper_surface_radius) for p in dims.inputs]
    assert cut == [pytest.approx((5.595, 5.995), abs=1e-12), pytest.approx((6.395, 6.795), abs=1e-12)]


def test_guide_walls_stand_half_way_between_the_steps(dims: BevelLayout) -> None:
    assert dims.guide.walls_z == pytest.approx((55.8, 59.4, 63.0), abs=1e-12)


def test_journals_carry_bearings_and_necks_carry_their_inner_rings(drive: BevelDrive, dims: BevelLayout) -> None:
    for p in dims.inputs:
        low, up = drive.bearings.input_lower, drive.bearings.input_upper
        assert (2 * p.lower_journal_radius, 2 * p.upper_journal_radius) == (low.bore_mm, up.bore_mm)
        for neck, bearing, name in ((p.lower_neck_radius, low, "lower"), (p.upper_neck_radius, up, "upper")):
            assert bearing.bore_mm / 2 < neck <= bearing.inner_shoulder_mm / 2, f"{p.name}, {name}: neck {neck:.3f} mm"
        assert p.journal_bottom_z < p.lower_neck_bottom_z < p.land_bottom_z < p.wall_z < p.land_top_z
        assert p.land_top_z < p.upper_neck_top_z < p.journal_top_z


def test_bore_takes_the_gearheads_shaft_and_the_slit_ends_above_the_collar(
    drive: BevelDrive, dims: BevelLayout
) -> None:
    v, gear = dims.levels, drive.gearhead
    for p in dims.inputs:
        assert 2 * p.bore_radius == gear.shaft_diameter_mm
        shaft_end = v.motor_shelf_bottom_z + gear.shaft_length_mm
        assert p.bore_top_z == pytest.approx(shaft_end + 0.5)
        assert p.journal_bottom_z < dims.collar.bottom_z < dims.collar.top_z < p.slit_top_z
        grip = shaft_end - dims.collar.bottom_z
        assert grip > drive.gearhead.shaft_diameter_mm, f"{p.name}: shaft reaches {grip:.2f} mm into the clamp"
        assert p.lower_journal_radius - p.bore_radius >= 0.9, "no spring left in the slit journal"


def test_slots_open_to_the_end_face_by_their_own_step(dims: BevelLayout) -> None:
    for p in dims.inputs:
        low, up = p.slots
        assert low.face_z == p.land_bottom_z and up.face_z == p.land_top_z
        assert p.land_bottom_z < low.end_z < p.wall_z < up.end_z < p.land_top_z
        for slot, surface, neck in (
            (low, p.lower_surface_radius, p.lower_neck_radius),
            (up, p.upper_surface_radius, p.upper_neck_radius),
        ):
            outer = slot.bend_radius + slot.stop_radius + 0.05
            corner = hypot(outer, slot.stop_start + 0.05)
            assert surface - corner >= 0.5, f"{slot.cable_name}: wall of {surface - corner:.3f} mm"
            inner = slot.bend_radius - slot.stop_radius - 0.05
            assert inner > neck, f"{slot.cable_name}: stop's pocket at {inner:.3f} mm cuts the neck at {neck:.3f} mm"


def test_collar_screw_passes_between_bore_and_rim(drive: BevelDrive, dims: BevelLayout) -> None:
    c, screw = dims.collar, drive.screw(dims.collar.screw)
    wall = drive.frame_material.min_wall_mm
    assert c.screw_offset - screw.clearance_mm / 2 - c.bore_radius == pytest.approx(wall)
    tip = screw.length_mm - c.head_seat
    assert tip - c.slit_width / 2 >= screw.thread_mm, f"{tip - c.slit_width / 2:.2f} mm of thread engaged"
    assert sqrt(c.radius**2 - tip**2) - c.screw_offset - screw.thread_mm / 2 == pytest.approx(wall), "wall at the tip"
    inner_edge = c.screw_offset - screw.head_diameter_mm / 2 - 0.1
    assert hypot(inner_edge, c.head_seat) >= c.bore_radius + wall - 1e-12, "the head's flat cuts into the bore's wall"
    assert collar_sweep_mm(drive) >= hypot(
        c.screw_offset + screw.head_diameter_mm / 2, c.head_seat + screw.head_height_mm
    )


def test_collar_lies_in_the_coupling_space(drive: BevelDrive, dims: BevelLayout) -> None:
    v = dims.levels
    head = drive.screw(drive.gearhead.screw).head_height_mm
    assert v.motor_shelf_top_z + head < dims.collar.bottom_z < dims.collar.top_z < v.bearing_shelf_bottom_z


def test_guide_has_metal_between_bearing_seat_and_every_step(drive: BevelDrive, dims: BevelLayout) -> None:
    g, bearing = dims.guide, drive.bearings.guide
    levels = [g.bottom_z, *g.walls_z, g.top_z]
    for radius, low, high in zip(g.surface_radii, levels[:-1], levels[1:], strict=True):
        in_seat = low < g.bottom_z + g.seat_depth or high > g.top_z - g.seat_depth
        inside = g.seat_radius if in_seat else g.shoulder_radius
        assert radius - inside >= 1.0, f"step at {radius:.3f} mm: {radius - inside:.3f} mm left"
    assert (g.seat_radius, g.seat_depth) == (bearing.outer_diameter_mm / 2, bearing.width_mm)
    assert g.top_z - g.bottom_z > 2 * bearing.width_mm + 1.0


def test_guides_inner_rings_are_held_between_collar_and_spacer(drive: BevelDrive, dims: BevelLayout) -> None:
    a, v = dims.axle, dims.levels
    assert (a.bottom_z, a.top_z) == (v.bearing_shelf_bottom_z, v.top_plate_top_z)
    assert (a.collar_bottom_z, a.collar_top_z) == (v.bearing_shelf_top_z, v.guide_bottom_z)
    assert (a.spacer_bottom_z, a.spacer_top_z) == (v.guide_top_z, v.top_plate_bottom_z)
    assert 2 * a.radius == drive.bearings.guide.bore_mm
    assert a.collar_radius < dims.guide.shoulder_radius, "the collar would rub on the outer ring"


def test_a_larger_journal_makes_a_larger_collar_and_wider_walls(drive: BevelDrive) -> None:
    big = next(b for b in (drive.bearings.drum,) if b.bore_mm == 8.0)
    other = BevelLayout(replace(drive, bearings=replace(drive.bearings, input_lower=big)))
    assert other.collar.radius > BevelLayout(drive).collar.radius + 1.0
    room = other.levels.side_inner_x - drive.centre_distance_mm
    assert room >= collar_sweep_mm(other.drive) + drive.clearances.running_mm - 1e-12


def test_support_seats_fit_their_bearings(drive: BevelDrive, dims: BevelLayout) -> None:
    f, t, b = dims.frame, dims.top_plate, drive.bearings
    for seat, depth, shoulder, bearing, thickness in (
        (f.seat_radius, f.seat_depth, f.seat_shoulder_radius, b.input_lower, drive.support.bearing_shelf_mm),
        (t.seat_radius, t.seat_depth, t.shoulder_radius, b.input_upper, drive.support.top_plate_mm),
    ):
        assert (2 * seat, depth, 2 * shoulder) == (
            bearing.outer_diameter_mm,
            bearing.width_mm,
            bearing.outer_shoulder_mm,
        )
        assert thickness - depth >= 0.8, f"{bearing.name}: shoulder of {thickness - depth:.2f} mm"


def test_top_plate_and_frame_share_their_screws_and_dowels(drive: BevelDrive, dims: BevelLayout) -> None:
    assert dims.frame.plate_screws == dims.top_plate.screws and dims.frame.dowels == dims.top_plate.dowels
    screw = plate_screw_of(drive)
    below = drive.support.top_plate_mm - dims.top_plate.screw_head_depth
    engaged = screw.length_mm - below
    assert engaged >= 1.5 * screw.thread_mm, f"{engaged:.2f} mm of thread engaged"
    assert dims.frame.plate_screw_depth >= engaged + 0.4


def test_encoder_screws_leave_a_wall_to_the_bearing_seat(drive: BevelDrive, dims: BevelLayout) -> None:
    head = drive.screw(drive.encoder.screw).head_diameter_mm / 2 + 0.1
    wall = drive.encoder.bolt_circle_mm / 2 - head - dims.top_plate.seat_radius
    assert wall >= drive.frame_material.min_wall_mm, f"{wall:.3f} mm"


def test_key_reaches_the_gearheads_screws_through_the_empty_seat(drive: BevelDrive, dims: BevelLayout) -> None:
    f = dims.frame
    key = drive.screw(drive.gearhead.screw).key_mm
    assert 2 * f.key_hole_radius > key * 2 / sqrt(3), "a hexagon key's corners do not pass"
    assert f.gear_bolt_circle + f.key_hole_radius < f.seat_radius, "the key's hole breaks out of the bearing seat"


def test_stop_pin_has_metal_round_it(drive: BevelDrive, dims: BevelLayout) -> None:
    f, v = dims.frame, dims.levels
    below = f.stop_pin_z - f.stop_pin_radius - v.motor_shelf_bottom_z
    above = v.bearing_shelf_bottom_z - f.stop_pin_z - f.stop_pin_radius
    beside = f.web_half_width - f.stop_pin_radius
    assert min(below, above, beside) >= drive.frame_material.min_wall_mm, f"{below:.2f}, {above:.2f}, {beside:.2f} mm"
    assert v.front_y - f.stop_pin_start_y >= 3 * 2 * f.stop_pin_radius, "pressed in less than three diameters"


def test_column_pocket_and_encoder_pocket_keep_a_wall_between_them(drive: BevelDrive, dims: BevelLayout) -> None:
    f = dims.frame
    assert f.column_pocket_bottom_z - max(f.boss.encoder_pocket_radius, f.boss.radius) >= drive.support.rib_mm - 1e-12
    assert dims.levels.motor_shelf_bottom_z - f.column_pocket_bottom_z > 2 * f.corner_radius


def test_guides_cables_clear_the_pockets_floor(drive: BevelDrive, dims: BevelLayout) -> None:
    lowest = -max(c.guide_radius_mm for c in drive.cables) - drive.cable.diameter_mm / 2
    assert lowest - dims.frame.upper_floor_y >= drive.clearances.running_mm - 1e-12
