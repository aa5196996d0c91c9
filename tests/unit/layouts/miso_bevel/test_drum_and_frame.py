"""Drum, gaps with tolerances, loads on the support and the estimate of its windup: equilibrium, laws, messages."""

from dataclasses import replace
from itertools import combinations
from math import atan2, cos, degrees, hypot, radians, sin, tan

import numpy as np
import pytest
from hypothesis import assume, given, reject, settings
from hypothesis import strategies as st

from mbcdm_cad.checks.transfer import TransferStacks, ratio_contributions
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.miso_bevel.cable_path import fleet_angle_deg
from mbcdm_cad.layouts.miso_bevel.checks import spans as gaps
from mbcdm_cad.layouts.miso_bevel.checks.spans import stacks, straight_span_clearance_mm
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive, BevelRun
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.stack import stack
from mbcdm_cad.layouts.miso_bevel.support.stiffness import frame_compliance, seat_loads
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.model.equations import pair_mismatch_m
from mbcdm_cad.model.stiffness import unit_tensions_N
from mbcdm_cad.model.tolerance import Contribution, linear_error, tolerance_stack
from mbcdm_cad.parts.drum_sector.sizes import half_width_mm, lands, tensioners
from mbcdm_cad.parts.fits import radius_band_mm
from mbcdm_cad.parts.making import model_tolerances
from mbcdm_cad.parts.terminal import Tensioner

from .designs import drives, mirrored, reference

WALLS = ("back_plate_mm", "side_wall_mm", "motor_shelf_mm", "bearing_shelf_mm", "top_plate_mm", "rib_mm")


def with_walls(drive: BevelDrive, **walls: float) -> BevelDrive:
    return replace(drive, support=replace(drive.support, **walls))


def drawable(drive: BevelDrive) -> BevelLayout:
    """The layout, where the random radii leave one."""
    lay = BevelLayout(drive)
    try:
        assert all((lay.drum, lay.drum_shaft, lay.inputs, lay.guide, lay.axle, lay.frame, lay.top_plate))
    except NoFigureError:
        reject()
    return lay


@settings(max_examples=25, deadline=None)
@given(drives())
def test_load_of_1_Nm_leaves_the_mount_a_moment_about_the_drum_alone(drive: BevelDrive) -> None:
    dims = drawable(drive)
    loads = seat_loads(dims, unit_tensions_N(layout_of(drive).si))
    force = loads.force_N.sum(axis=0)
    moment = np.cross(loads.point_mm, loads.force_N).sum(axis=0) / 1e3
    moment[2] += loads.gearhead_torque_Nm.sum()
    size = abs(loads.force_N).max()
    assert abs(force).max() < 1e-9 * size, f"net force {force} N"
    # A load that opposes positive rotation turns the support against +Y.
    assert np.allclose(moment, [0.0, -1.0, 0.0], atol=1e-9), f"net moment {moment} N m"


@settings(max_examples=25, deadline=None)
@given(drives(), st.lists(st.floats(0.0, 200.0), min_size=4, max_size=4))
def test_any_tensions_load_the_mount_by_their_moment_on_the_drum(drive: BevelDrive, tension: list[float]) -> None:
    d = layout_of(drive).si
    loads = seat_loads(drawable(drive), np.array(tension))
    on_drum = float((d.sigma * np.array(tension) * d.drum_radius_m).sum())
    moment = np.cross(loads.point_mm, loads.force_N).sum(axis=0) / 1e3
    moment[2] += loads.gearhead_torque_Nm.sum()
    assert np.allclose(loads.force_N.sum(axis=0), 0.0, atol=1e-9 * (1 + max(tension)))
    assert np.allclose(moment, [0.0, -on_drum, 0.0], atol=1e-9 * (1 + max(tension))), f"{moment}, drum {on_drum} N m"


def test_unit_tensions_carry_1_Nm(drive: BevelDrive) -> None:
    d = layout_of(drive).si
    carried = float((d.sigma * unit_tensions_N(d) * d.drum_radius_m).sum())
    assert carried == pytest.approx(1.0, abs=1e-12), f"{carried} N m"


def test_reference_keeps_its_limit_and_shares_add_up(dims: BevelLayout) -> None:
    found = frame_compliance(dims)
    limit, torque = dims.windup_limit_mrad, dims.drive.loads.test_torque_Nm
    assert found.windup_mrad(torque) <= limit, f"{found.windup_mrad(torque):.4f} mrad, limit {limit} mrad"
    assert sum(found.shares_urad_Nm.values()) == pytest.approx(found.windup_urad_Nm)
    assert min(found.shares_urad_Nm.values()) > 0.0, f"{found.shares_urad_Nm}"


def test_windup_is_inverse_to_the_modulus(drive: BevelDrive, as_drawn_urad_Nm: float) -> None:
    material = drive.frame_material
    softer = replace(material, youngs_modulus_GPa=material.youngs_modulus_GPa / 3)
    soft = frame_compliance(BevelLayout(replace(drive, frame_material=softer))).windup_urad_Nm
    ratio = soft / as_drawn_urad_Nm
    assert ratio == pytest.approx(3.0, rel=1e-6), f"{ratio}"


@pytest.fixture(scope="module")
def as_drawn_urad_Nm() -> float:
    """Windup of the reference support."""
    return frame_compliance(BevelLayout(reference())).windup_urad_Nm


@pytest.mark.parametrize("wall", WALLS)
def test_a_thicker_wall_is_stiffer(drive: BevelDrive, as_drawn_urad_Nm: float, wall: str) -> None:
    thickness = getattr(drive.support, wall)
    thick = frame_compliance(BevelLayout(with_walls(drive, **{wall: 1.25 * thickness}))).windup_urad_Nm
    assert thick < as_drawn_urad_Nm, (
        f"{wall}: {as_drawn_urad_Nm:.3f} urad per N m at {thickness} mm, {thick:.3f} at 1.25 times as much"
    )


def test_mirror_image_is_as_stiff(drive: BevelDrive, as_drawn_urad_Nm: float) -> None:
    there = frame_compliance(BevelLayout(mirrored(drive))).windup_urad_Nm
    assert there == pytest.approx(as_drawn_urad_Nm, rel=1e-6), f"{as_drawn_urad_Nm} and {there} urad per N m"


@settings(max_examples=6, deadline=None)
@given(drives(), st.tuples(*[st.floats(0.5, 9.0)] * 6))
def test_any_design_has_a_windup_or_a_sentence(drive: BevelDrive, walls: tuple[float, ...]) -> None:
    dims = drawable(with_walls(drive, **dict(zip(WALLS, walls, strict=True))))
    try:
        found = frame_compliance(dims).windup_urad_Nm
    except ValueError as error:
        said = str(error)
    else:
        said = "frame: a figure"
        assert np.isfinite(found), f"windup {found}"
        assert found > 0.0, f"windup {found}"
    assert said.startswith("frame: "), said


def test_a_solid_column_yields_less_than_a_hollow_one() -> None:
    dims = BevelLayout(reference())
    hollow = frame_compliance(dims).windup_urad_Nm
    filled = replace(dims.frame, column_pocket_bottom_z=dims.levels.motor_shelf_bottom_z)
    assert not filled.has_column_pocket
    solid = frame_compliance(dims.with_dimensions(frame=filled)).windup_urad_Nm
    assert 0.3 * hollow < solid < hollow, f"solid {solid:.3g}, hollow {hollow:.3g} urad/(N m)"


def test_wall_of_no_thickness_is_named() -> None:
    dims = BevelLayout(reference())
    levels = replace(dims.levels, motor_shelf_top_z=dims.levels.motor_shelf_bottom_z)
    with pytest.raises(ValueError, match="motor shelf 0 mm"):
        frame_compliance(dims.with_dimensions(levels=levels))


def _per_unit(found: tuple[Contribution, ...], name: str) -> float:
    return next(c.per_unit for c in found if c.name == name)


def _with(drive: BevelDrive, cable: BevelRun, **changes: float) -> tuple[BevelDrive, BevelRun]:
    changed = replace(cable, **changes)  # type: ignore[arg-type]
    return replace(drive, cables=tuple(changed if c is cable else c for c in drive.cables)), changed


@settings(max_examples=30, deadline=None)
@given(drives())
def test_closed_form_of_the_self_clearance_is_that_of_the_search(drive: BevelDrive) -> None:
    """For leads and slopes as designs have them: both small against the pulley."""
    for cable in drive.cables:
        try:
            searched = straight_span_clearance_mm(drive, cable)
        except ValueError:
            assume(False)
        lead = drive.helix_lead_mm
        slope = tan(radians(fleet_angle_deg(drive, cable)))
        assume(lead < cable.input_radius_mm / 3 and slope < 0.1)
        found, _ = gaps.last_turn_gap(drive, cable)
        assert found == pytest.approx(searched, abs=0.01 * lead), (found, searched)


def test_what_each_tolerance_does_to_the_self_clearance() -> None:
    """Against differences of the searched clearance; the slope of the span moves with the centre distance."""
    drive = reference()
    for cable in drive.cables:
        _, found = gaps.last_turn_gap(drive, cable)
        h = 1e-4

        def clearance(d: BevelDrive, c: BevelRun) -> float:
            return straight_span_clearance_mm(d, c)

        thick = replace(drive, cable=replace(drive.cable, diameter_mm=drive.cable.diameter_mm + h))
        thicker = (clearance(*_with(thick, cable)) - clearance(drive, cable)) / h
        assert _per_unit(found, "rope's diameter") == pytest.approx(thicker, abs=0.02)
        far = replace(drive, centre_distance_mm=drive.centre_distance_mm + h)
        further = (clearance(far, cable) - clearance(drive, cable)) / h
        assert _per_unit(found, "centre distance") == pytest.approx(further, rel=0.1)


def test_a_pair_disagrees_by_what_its_radii_are_off() -> None:
    """Against the model's mismatch of a drive with that one radius off."""
    drive = reference()
    pair = (drive.cables[0], drive.cables[1])
    found = gaps.pair_path_contributions(drive, pair)
    for cable in pair:
        for field, name in (("drum_radius_mm", "drum radius"), ("input_radius_mm", "input radius")):
            off, _ = _with(drive, cable, **{field: getattr(cable, field) + 0.01})
            si = layout_of(off).si
            # The drum at the end of its travel where the input's own radii put it.
            angle = radians(drive.half_travel_deg) * si.total_ratio[:1]
            length = float(np.abs(pair_mismatch_m(si, np.array([angle, angle]))[0]).max()) * 1e3
            expected = 0.01 * _per_unit(found, f"{name} of {cable.name}")
            # Told at the second cable's land, with the drum where the first wants it.
            lever = pair[1].drum_radius_mm / cable.drum_radius_mm
            assert length == pytest.approx(expected * lever, rel=0.01), (cable.name, field)


def test_ratio_of_a_drive_with_one_size_off() -> None:
    drive = reference()
    cable = drive.cables[2]
    found = ratio_contributions(drive, cable)
    ratio = cable.drum_radius_mm / cable.input_radius_mm
    h = 1e-5
    thick = (cable.drum_radius_mm + h / 2) / (cable.input_radius_mm + h / 2)
    small = cable.drum_radius_mm / (cable.input_radius_mm + h)
    assert _per_unit(found, "rope's diameter") == pytest.approx((thick / ratio - 1) / h, rel=1e-4)
    assert _per_unit(found, "input radius") == pytest.approx((small / ratio - 1) / h, rel=1e-4)


def test_play_and_run_out_shrink_the_transfer_gap_as_a_displaced_guide_does() -> None:
    """Every part drawn at random within its tolerance: the gap between the two circles moves as the stack says."""
    drive = reference()
    cable, making = drive.cables[0], drive.making
    rng = np.random.default_rng(1)
    n = 100_000
    guide = rng.uniform(-1, 1, (4, n))
    surface = (
        cable.guide_radius_mm
        + guide[0] * radius_band_mm(cable.guide_radius_mm - drive.cable.diameter_mm / 2, "land")
        + guide[1] * making.run_out_mm / 2
        + guide[2] * making.bearing_play_mm / 2
        + guide[3] * making.position_mm
    )
    drum = rng.uniform(-1, 1, (3, n))
    face = cable.guide_radius_mm + 1.0 + (drum[0] + drum[1]) * making.position_mm + drum[2] * making.run_out_mm / 2
    stack = TransferStacks("guide", "axle").contributions(drive, cable)
    assert np.std(face - surface) * np.sqrt(3.0) == pytest.approx(np.sqrt(sum(c.shift**2 for c in stack)), rel=0.01)


def test_stacks_stand_in_the_order_of_the_gaps_and_name_what_costs_most() -> None:
    found = list(stacks(BevelLayout(reference())))
    assert len(found) == 7
    clearance, flank = found[0], found[4]
    assert clearance.costliest.name == "rope's diameter", clearance
    assert 0.0 < clearance.margin < clearance.rss < clearance.worst_case, "7 um are no clearance with real rope"
    assert flank.figure.startswith("flank of"), flank


def test_linear_error_of_the_check_is_that_of_the_study() -> None:
    drive = reference()
    si, sizes, half = layout_of(drive).si, model_tolerances(drive), radians(drive.half_travel_deg)
    names, error = linear_error(si, half, sizes, poses=31)
    study = tolerance_stack(si, half, sizes, draws=2, poses=31)
    assert names == study.contributor
    assert np.sqrt((error**2).mean(axis=1)) == pytest.approx(study.contribution_rad, abs=1e-15)
    assert sizes.drum_eccentricity_m == pytest.approx(drive.making.run_out_mm / 4e3)


def test_lands_are_cut_at_half_a_cable_under_the_pitch_radius(drive: BevelDrive, dims: BevelLayout) -> None:
    surfaces = [land.surface_radius_mm for land in dims.drum.lands]
    assert surfaces == pytest.approx([53.595, 57.195, 60.795, 64.395], abs=1e-12)
    for before, after in zip(dims.drum.lands[:-1], dims.drum.lands[1:], strict=True):
        assert before.y_end == after.y_start


def test_contact_lines_lie_on_their_lands(drive: BevelDrive, dims: BevelLayout) -> None:
    """Edge 0.15 mm behind the contact line, flank 0.045 mm clear of the next wall: 0.6 - 0.405 in all."""
    for cable, land in zip(drive.cables, dims.drum.lands, strict=True):
        assert cable.guide_radius_mm - land.y_start >= 0.15 - 1e-12
    for cable, land in zip(drive.cables[:-1], dims.drum.lands[1:], strict=True):
        gap = land.y_start - cable.guide_radius_mm - drive.cable.diameter_mm / 2
        assert gap == pytest.approx(0.045, abs=1e-12), f"{cable.name}: flank gap {gap:.4f} mm"


@settings(max_examples=50, deadline=None)
@given(drives())
def test_land_widths_add_up_to_the_rim(drive: BevelDrive) -> None:
    levels = stack(drive)
    rims = lands(drive, levels)
    width = sum(land.y_end - land.y_start for land in rims)
    assert width == pytest.approx(levels.drum_outer_y - levels.drum_inner_y, rel=1e-12, abs=1e-12)


def angle_of(t: Tensioner, s: float, n: float) -> float:
    x, z = t.at(s, n)
    return atan2(t.side * x, z)


def test_terminals_stay_inside_the_sector_and_its_width(drive: BevelDrive, dims: BevelLayout) -> None:
    half = radians(drive.drum.sector_half_angle_deg)
    nut = drive.tensioner.nut_across_flats_mm / 3**0.5
    width = half_width_mm(drive)
    assert 2 * width == pytest.approx(drive.targets.envelope_mm[0], abs=drive.targets.envelope_tolerance_mm)
    for t in dims.drum.tensioners:
        assert angle_of(t, t.tip, 0.0) < half, (
            f"{t.cable_name}: stud ends at {degrees(angle_of(t, t.tip, 0.0)):.2f} deg"
        )
        for s in (t.lug_end, t.nuts_end):
            x, _ = t.at(s, nut)
            assert abs(x) <= width, f"{t.cable_name}: nut at |x| = {abs(x):.3f} mm, sector ends at {width:.3f}"


def test_terminal_lies_on_the_tangent_at_the_anchor(dims: BevelLayout) -> None:
    for t in dims.drum.tensioners:
        for s in (0.0, t.swage_start, t.tip):
            x, z = t.at(s)
            assert hypot(x, z) == pytest.approx(hypot(t.radius_mm, s), rel=1e-12)
        x, z = t.at(0.0, 1.0)
        assert (x, z) == pytest.approx(
            (t.side * (t.radius_mm + 1) * sin(t.anchor_rad), (t.radius_mm + 1) * cos(t.anchor_rad)), rel=1e-12
        )


def test_terminal_is_swage_gap_lug_two_nuts_and_a_stud_that_passes_them(drive: BevelDrive, dims: BevelLayout) -> None:
    spec = drive.tensioner
    for t in dims.drum.tensioners:
        assert t.swage_end - t.swage_start == pytest.approx(spec.swage_length_mm)
        assert t.lug_end - t.lug_start == pytest.approx(spec.lug_thickness_mm)
        assert t.nuts_end - t.lug_end == pytest.approx(2 * spec.nut_height_mm)
        assert t.slack_start < t.swage_start < t.cable_end < t.swage_end < t.last_end < t.lug_start < t.nuts_end
        assert t.nuts_end < t.tip - t.drawn_in < t.tip < t.last_tip


def test_cable_is_still_on_the_drum_at_both_ends_of_travel(drive: BevelDrive, dims: BevelLayout) -> None:
    for t in dims.drum.tensioners:
        left = degrees(t.anchor_rad) - drive.half_travel_deg
        assert left > 18.0, f"{t.cable_name}: {left:.1f} deg of wrap at the end of travel"


def polar_box(t: Tensioner, s0: float, s1: float, n0: float, n1: float) -> tuple[float, float, float, float]:
    angles = [angle_of(t, s, n) for s in (s0, s1) for n in (n0, n1)]
    radii = [hypot(*t.at(s, n)) for s in (s0, s1) for n in (n0, n1)]
    return min(angles), max(angles), min(radii), max(radii)


def test_neighbours_on_one_side_do_not_share_a_place(drive: BevelDrive, dims: BevelLayout) -> None:
    """Each terminal's hardware against the other's lug, and no pocket under a cable's land before it ends."""
    nut, d = drive.tensioner.nut_across_flats_mm / 3**0.5, dims.drum
    for a, b in combinations(d.tensioners, 2):
        if a.side != b.side:
            continue
        inner, outer = sorted((a, b), key=lambda t: t.radius_mm)
        for one, other in ((inner, outer), (outer, inner)):
            lug = polar_box(one, one.lug_start, one.lug_end, -d.swage_pocket, d.lug_half_width)
            hardware = polar_box(other, other.swage_start, other.nuts_end, -nut, nut)
            apart = lug[0] > hardware[1] or hardware[0] > lug[1] or lug[2] > hardware[3] or hardware[2] > lug[3]
            assert apart, f"lug of {one.cable_name} meets the terminal of {other.cable_name}"
        pocket = polar_box(inner, inner.swage_start - 0.2, inner.tip, -d.nut_pocket, inner.pocket_top)
        lands_end = outer.anchor_rad
        reaches = pocket[3] > outer.radius_mm - drive.cable.diameter_mm / 2
        assert pocket[0] > lands_end or not reaches, f"pocket of {inner.cable_name} cuts the land of {outer.cable_name}"


@settings(max_examples=50, deadline=None)
@given(st.floats(1.0, 8.0), st.floats(50.0, 85.0), st.floats(20.0, 90.0))
def test_no_thin_wall_before_a_land_further_out(step: float, sector: float, radius: float) -> None:
    """Either the pocket opens the land's surface, or at least 1 mm is left at its thin end."""
    first = reference()
    cables = tuple(replace(c, drum_radius_mm=radius + step * k) for k, c in enumerate(first.cables))
    drive = replace(first, cables=cables, drum=replace(first.drum, sector_half_angle_deg=sector))
    surfaces = [c.drum_radius_mm - drive.cable.diameter_mm / 2 for c in cables]
    for t in tensioners(drive, BevelLayout(drive).terminal_way):
        left = radians(sector) - t.anchor_rad
        end = min(t.pocket_end, t.radius_mm * sin(left) / cos(left))
        for surface in surfaces:
            if surface > t.radius_mm:
                thick = surface - hypot(t.radius_mm + t.pocket_top, end)
                opened = t.radius_mm + t.pocket_top > surface
                assert opened or thick >= 1.0 - 1e-9, f"{t.cable_name}: wall of {thick:.3f} mm under {surface:.3f}"


def test_stops_engage_between_the_travel_and_half_a_degree_more(drive: BevelDrive, dims: BevelLayout) -> None:
    """The pin touches the slot's end when their centres are apart by the difference of their radii."""
    d, pin = dims.drum, dims.frame.stop_pin_radius
    play = degrees((d.stop_slot_width / 2 - pin) / d.stop_radius)
    engages = d.stop_slot_end_deg + play
    assert engages == pytest.approx(drive.half_travel_deg + drive.stop_clearance_deg, abs=1e-9)
    assert 35.0 < engages < 35.5
    assert d.stop_radius == dims.frame.stop_pin_z


def test_windows_outside_the_slot_leave_spokes_and_a_rim(drive: BevelDrive, dims: BevelLayout) -> None:
    d, half_slot = dims.drum, dims.drum.stop_slot_width / 2
    assert len(d.windows) == 2
    for w in d.windows:
        assert d.stop_radius + half_slot < w.r_inner < w.r_outer < d.rim_inner_radius - 2.0
        crosses = w.start_deg < d.stop_slot_end_deg and w.end_deg > -d.stop_slot_end_deg
        radial_gap = max(w.r_inner - d.stop_radius, d.stop_radius - w.r_outer) - half_slot
        assert not crosses or radial_gap > 1.0, f"window {w} is {radial_gap:.3f} mm from the stop's slot"
    for a, b in combinations(d.windows, 2):
        assert a.end_deg <= b.start_deg or b.end_deg <= a.start_deg or a.r_outer < b.r_inner or b.r_outer < a.r_inner


def test_shaft_stack_fills_the_boss(drive: BevelDrive, dims: BevelLayout) -> None:
    s, f, width = dims.drum_shaft, dims.frame, drive.bearings.drum.width_mm
    spring = dims.preload_spring.height
    assert s.rear_bearing_y == s.flange_end_y and f.boss.rear_seat_end_y == pytest.approx(
        s.rear_bearing_y + width + spring
    )
    assert f.boss.front_seat_start_y == s.front_bearing_y
    assert s.front_bearing_y + width == pytest.approx(dims.levels.boss_front_y)
    assert s.front_bearing_y - f.boss.rear_seat_end_y > width, "bearings closer than their own width"
    assert f.boss.shoulder_radius < f.boss.seat_radius
    assert s.flange_start_y >= f.boss.encoder_pocket_floor_y, "flange in the encoder"
