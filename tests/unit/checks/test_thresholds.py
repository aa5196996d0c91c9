"""The limit of every check: a design just inside it passes, a design just outside it fails."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest
from designs import Change, preloaded, put, radius_of, reference, scaled, to

from mbcdm_cad.checks.comparison import TOLERANCE, Check
from mbcdm_cad.checks.run import run_check
from mbcdm_cad.design.bought import SpringSpec
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.miso_bevel.checks import CHECKS
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout

BY_ID = {check.id: check for check in CHECKS}
BISECTIONS = 60
# Margins that differ by less are those of one design.
SAME = 5e-9


class Way(NamedTuple):
    """One parameter of the reference design from a value that passes to one that fails."""

    change: Change
    passing: float
    failing: float


def grooved_at_lead(drive: Drive, lead_mm: float) -> Drive:
    """Grooved input pulleys with a helix of this lead."""
    return put(put(drive, "input_pulleys.surface", "grooved"), "helix_lead_mm", lead_mm)


SPRING = SpringSpec(
    name="spring",
    kind="disc",
    outside_mm=5.0,
    inside_mm=2.0,
    strip_mm=0.3,
    free_mm=0.5,
    solid_mm=0.3,
    stiffness_N_mm=1000.0,
    usable_share=0.75,
    mass_g=0.05,
    material="steel",
    source="test",
)


def sprung(path: str) -> Change:
    """A value of the springs, or another one, of the reference with springs."""
    return lambda drive, value: put(put(drive, "spring", SPRING), path, value)


PEAK, TEST = "loads.peak_torque_Nm", "loads.test_torque_Nm"
WAYS: dict[str, Way] = {
    "eq1_guide_drum": Way(radius_of(1, "guide_radius_mm"), 9.6, 9.7),
    "eq1_first_input": Way(radius_of(1, "input_radius_mm"), 6.4, 6.3),
    "eq1_second_input": Way(radius_of(3, "input_radius_mm"), 7.2, 7.3),
    "drum_stress": Way(to("drum_material.yield_MPa"), 503.0, 10.0),
    "payload_screws": Way(to(PEAK), 3.15, 60.0),
    "shaft_stress": Way(to("shaft_material.yield_MPa"), 355.0, 5.0),
    "mounting_screws": Way(to(PEAK), 3.15, 60.0),
    "frame_windup": Way(to("limits.frame_windup_max_mrad"), 0.0232, 0.01),
    "stiffness": Way(to("loads.stiffness_Nm_rad"), 2500.0, 4000.0),
    "structure_share": Way(to("loads.structure_share"), 0.9, 0.3),
    "equal_total_ratio": Way(scaled("input_radius_mm", (2, 3)), 1.0, 1.01),
    "pair_mismatch": Way(radius_of(1, "input_radius_mm"), 6.4, 6.5),
    "surface_radius": Way(scaled("input_radius_mm"), 1.0, 0.2),
    "bend_ratio": Way(to("limits.bend_ratio_min"), 14.8, 20.0),
    "bend_ratio_minimum": Way(to("cable.bend_ratio_minimum"), 10.0, 28.0),
    "bend_ratio_desired": Way(to("cable.bend_ratio_desired"), 10.0, 42.0),
    "anchor_bend": Way(scaled("input_radius_mm"), 1.0, 0.6),
    "pitch_line": Way(radius_of(0, "guide_radius_mm"), 9.0, 9.1),
    "radii_rise": Way(radius_of(1, "drum_radius_mm"), 57.6, 53.0),
    "land_width": Way(to("cable.diameter_mm"), 0.81, 1.0),
    "land_edge": Way(to("clearances.land_edge_mm"), 0.15, 0.0),
    "outermost_land": Way(to("drum.outer_face_y_mm"), 13.0, 11.0),
    "bodies_clear": Way(to("clearances.transfer_gap_mm"), 0.155, 0.01),
    "transfer_gap": Way(to("clearances.transfer_gap_mm"), 0.155, 0.6),
    "centre_distance": Way(to("centre_distance_mm"), 34.6, 17.0),
    "pulley_gap": Way(to("centre_distance_mm"), 34.6, 17.0),
    "guide_wrap": Way(to("centre_distance_mm"), 34.6, 2000.0),
    "fleet_angle": Way(to("helix_lead_mm"), 0.87, 1.0),
    "helix_lead": Way(to("helix_lead_mm"), 0.87, 0.7),
    "groove_walls": Way(grooved_at_lead, 0.9, 0.85),
    "self_clearance": Way(to("helix_lead_mm"), 0.87, 0.8),
    "input_walk": Way(to("helix_lead_mm"), 0.87, 3.0),
    "guide_walk": Way(to("helix_lead_mm"), 0.87, 9.0),
    "dead_turns": Way(to("dead_turns"), 1.0, 0.0),
    "self_clearance_stack": Way(to("making.rope_diameter_share"), 0.0, 0.1),
    "transfer_gap_stack": Way(to("making.position_mm"), 0.02, 0.3),
    "bodies_clear_stack": Way(to("making.run_out_mm"), 0.02, 0.5),
    "land_edge_stack": Way(to("making.position_mm"), 0.0, 0.1),
    "flank_stack": Way(to("cable.diameter_mm"), 0.6, 0.81),
    "guide_walk_stack": Way(to("making.position_mm"), 0.02, 2.0),
    "pair_mismatch_stack": Way(preloaded, 70.0, 12.5),
    "wrap_left": Way(to("half_travel_deg"), 35.0, 65.0),
    "wrap_under_turn": Way(to("half_travel_deg"), 35.0, 300.0),
    "terminal_clears_guide": Way(to("half_travel_deg"), 35.0, 65.0),
    "no_slack": Way(to(PEAK), 3.15, 60.0),
    "life": Way(to("targets.life_cycles"), 2000.0, 20000.0),
    "life_shown": Way(to("targets.life_cycles"), 100.0, 1000.0),
    "tension": Way(to(PEAK), 3.15, 20.0),
    "preload_share": Way(to("limits.preload_share_max"), 0.5, 0.05),
    "cable_ends": Way(to(PEAK), 3.15, 20.0),
    "termination_fits": Way(to("termination.largest_mm"), 6.0, 0.5),
    "sleeve_fits": Way(to("tensioner.swage_diameter_mm"), 2.0, 1.0),
    "preload_bias": Way(preloaded, 40.0, 100.0),
    "motor_torque_forward": Way(to(PEAK), 3.15, 5.0),
    "motor_torque_back": Way(to(PEAK), 3.15, 5.0),
    "gearhead_maximum": Way(to(PEAK), 3.15, 6.0),
    "retension": Way(to("cable.creep_per_decade"), 1e-4, 0.1),
    "motor_losses": Way(to(PEAK), 1.0, 3.15),
    "backdrive": Way(to("loads.backdrive_Nm"), 2.0, 0.3),
    "continuous_torque": Way(to("loads.continuous_torque_Nm"), 0.5, 3.15),
    "gearhead_continuous": Way(to(PEAK), 0.5, 3.15),
    "input_bearings": Way(to("bearings.input_lower.static_rating_N"), 255.0, 10.0),
    "guide_bearings": Way(to("bearings.guide.static_rating_N"), 180.0, 10.0),
    "drum_bearings": Way(to("bearings.drum.static_rating_N"), 570.0, 10.0),
    "quiet_running": Way(to("bearings.guide.static_rating_N"), 300.0, 100.0),
    "drum_bearing_spacing": Way(to("support.back_y_mm"), -14.0, -10.0),
    "coupling_runout": Way(to("pulley_material.youngs_modulus_GPa"), 210.0, 1.0),
    "collar_grip": Way(to(PEAK), 3.15, 20.0),
    "hub_set_screws": Way(to("bearings.drum.outer_diameter_mm"), 16.0, 3e4),
    "stop_pin": Way(to("drum.web_thickness_mm"), 2.0, 20.0),
    "pulley_stress": Way(to("pulley_material.yield_MPa"), 355.0, 5.0),
    "stop_pocket_wall": Way(to("cable.diameter_mm"), 0.81, 4.0),
    "stop_pocket_floor": Way(to("pulley_material.min_wall_mm"), 0.5, 20.0),
    "stop_pocket_bore": Way(to("pulley_material.min_wall_mm"), 0.5, 20.0),
    "bore_wall": Way(to("gearhead.shaft_diameter_mm"), 3.0, 5.0),
    "bearing_shoulders": Way(to("bearings.input_lower.inner_shoulder_mm"), 6.2, 5.0),
    "encoder_fit": Way(to("encoder.bore_mm"), 4.0, 3.0),
    "bought_depth": Way(to("encoder.length_mm"), 14.0, 5.0),
    "shaft_grip": Way(to("gearhead.shaft_length_mm"), 10.0, 6.0),
    "pilot_room": Way(to("gearhead.pilot_height_mm"), 1.0, 9.0),
    "coupling_height": Way(to("support.coupling_space_mm"), 10.6, 5.0),
    "guide_wall": Way(to("bearings.guide.outer_diameter_mm"), 9.0, 19.0),
    "guide_length": Way(to("bearings.guide.width_mm"), 2.5, 8.0),
    "axle_stress": Way(to("axle_material.yield_MPa"), 355.0, 10.0),
    "rim_height": Way(to("drum.rim_inner_radius_mm"), 47.0, 54.0),
    "web_in_rim": Way(to("drum.web_thickness_mm"), 2.0, 6.0),
    "land_thickness": Way(to("clearances.land_edge_mm"), 0.15, 0.6),
    "hub_walls": Way(to("drum.hub_diameter_mm"), 20.0, 10.0),
    "hub_length": Way(to("drum.hub_face_y_mm"), 20.8, 14.0),
    "hub_spigot": Way(to("bearings.drum.inner_shoulder_mm"), 9.5, 8.0),
    "set_screw_tips": Way(to("bearings.drum.bore_mm"), 8.0, 2.5),
    "shaft_wall": Way(to("drum.shaft_bore_mm"), 4.0, 7.9),
    "stop_slot": Way(to("drum.sector_half_angle_deg"), 78.1, 36.0),
    "stop_after_travel": Way(to("stop_clearance_deg"), 0.25, -0.1),
    "stop_within_half_degree": Way(to("stop_clearance_deg"), 0.25, 0.7),
    "terminals_apart": Way(to("tensioner.nut_across_flats_mm"), 3.2, 9.0),
    "lands_intact": Way(to("drum_material.min_internal_radius_mm"), 0.5, 3.0),
    "outer_face": Way(to("drum.outer_face_y_mm"), 13.0, 12.0),
    "pocket_corners": Way(to("drum_material.min_internal_radius_mm"), 0.5, 5.0),
    "stud_stress": Way(to("tensioner.stress_area_mm2"), 1.27, 0.1),
    "take_up": Way(to("tensioner.stud_length_mm"), 12.5, 9.0),
    "thread_at_end": Way(to("tensioner.lug_thickness_mm"), 1.8, 0.2),
    "terminal_angles": Way(radius_of(0, "terminal_angle_rad"), 0.5, 2.0),
    "terminal_twist": Way(to("tensioner.swage_flats_mm"), 1.6, 1.9),
    "lug_stress": Way(to("drum_material.yield_MPa"), 503.0, 10.0),
    "walls": Way(to("support.rib_mm"), 3.0, 0.3),
    "bearing_shelf": Way(to("support.bearing_shelf_mm"), 4.0, 3.0),
    "top_plate": Way(to("support.top_plate_mm"), 3.6, 2.0),
    "engagement": Way(to("support.motor_shelf_mm"), 3.0, 6.0),
    "dowel_engagement": Way(to("support.top_plate_mm"), 3.6, 13.0),
    "front_wall": Way(to("bearings.input_lower.outer_diameter_mm"), 11.0, 14.0),
    "side_wall": Way(to("support.side_wall_mm"), 6.0, 4.0),
    "hole_webs": Way(to("support.side_wall_mm"), 5.6, 4.0),
    "wall_holes": Way(to("support.side_wall_mm"), 5.6, 2.0),
    "key_access": Way(to("gearhead.bolt_circle_mm"), 8.4, 10.0),
    "head_seats": Way(to("gearhead.bolt_circle_mm"), 8.4, 12.0),
    "pulley_corner": Way(to("clearances.running_mm"), 0.25, 1.0),
    "pocket_depth": Way(scaled("input_radius_mm"), 1.0, 1.7),
    "mounts": Way(to("support.coupling_space_mm"), 8.5, 5.0),
    "boss": Way(to("support.back_y_mm"), -14.0, -8.0),
    "encoder_screws": Way(to("drum_encoder.bolt_circle_mm"), 19.6, 17.0),
    "corner_radii": Way(to("frame_material.min_internal_radius_mm"), 0.5, 12.0),
    "drives_apart": Way(to("centre_distance_mm"), 34.6, 19.0),
    "screwdriver": Way(to("encoder.diameter_mm"), 17.0, 30.0),
    "drum_sweep": Way(to("gearhead.diameter_mm"), 16.0, 20.0),
    "frame_front": Way(to("tensioner.swage_diameter_mm"), 2.5, 6.0),
    "collar_space": Way(to("support.back_plate_mm"), 2.6, 9.0),
    "cables_apart": Way(radius_of(1, "drum_radius_mm"), 57.6, 54.2),
    "spans_clear": Way(to("half_travel_deg"), 35.0, 60.0),
    "envelope_x": Way(to("drum.sector_half_angle_deg"), 78.1, 70.0),
    "envelope_z": Way(to("targets.envelope_tolerance_mm"), 0.5, 0.0001),
    "envelope_y": Way(to("drum.hub_face_y_mm"), 20.8, 25.0),
    "spring_fits": Way(sprung("spring.inside_mm"), 2.0, 1.7),
    "spring_flat": Way(sprung("spring.stiffness_N_mm"), 1000.0, 100.0),
    "spring_free": Way(sprung(PEAK), 3.15, 60.0),
    "spring_keeps": Way(sprung("cable.bedding_in_share"), 0.001, 0.02),
    "mass_estimate": Way(to("targets.mass_tolerance_g"), 10.0, 0.1),
}
# Told without a limit, or tried in a test of their own.
OTHERS = {"path_length", "transmission_error", "shaft_twist", "cut_at_pitch", "screw_counts"} | {
    "wrap_slip_test",
    "wrap_slip_peak",
    "spring_hold",
    *("speed", "duty", "seat_temperature"),
}


def test_every_check_has_its_border_tried() -> None:
    assert set(WAYS) | OTHERS == set(BY_ID), set(WAYS) ^ (set(BY_ID) - OTHERS)


def _margin(check: Check, drive: Drive) -> float:
    """Of the figure from its limit; none where it is only told."""
    with np.errstate(all="ignore"):
        found = check.measure(BevelLayout(drive))
    return found.margin if found.sense else np.inf


def _border(margin: Callable[[float], float], passing: float, failing: float) -> tuple[float, float]:
    """Both ends moved together until the margins differ by rounding, or the ends do where the margin jumps.

    By secants that aim a little beyond the border, further where the same end stays twice, and by halves where these do
    not close in.
    """
    inside, outside, stays, stretch = margin(passing), margin(failing), 0, 1.0
    for step in range(BISECTIONS):
        if inside - outside < SAME:
            break
        share = 0.5
        if step % 3 < 2 and np.isfinite(inside - outside):
            stretch = 4.0 * stretch if abs(stays) > 1 else 1.0
            to_border, whole = inside + TOLERANCE, inside - outside
            if stays < 0:
                share = max(0.5, 1.0 - stretch * (whole - to_border + SAME / 3.0) / whole)
            else:
                share = min(0.5, stretch * (to_border + SAME / 3.0) / whole)
        middle = passing + share * (failing - passing)
        found = margin(middle)
        if found >= -TOLERANCE:
            passing, inside, stays = middle, found, max(stays, 0) + 1
        else:
            failing, outside, stays = middle, found, min(stays, 0) - 1
    return passing, failing


@pytest.mark.parametrize("name", WAYS)
def test_one_design_just_passes_and_one_just_fails(name: str) -> None:
    check, way = BY_ID[name], WAYS[name]

    def design(value: float) -> Drive:
        return way.change(reference(), value)

    passing, failing = way.passing, way.failing
    assert _margin(check, design(passing)) >= -TOLERANCE, check.measure(BevelLayout(design(passing)))
    assert _margin(check, design(failing)) < -TOLERANCE, check.measure(BevelLayout(design(failing)))
    passing, failing = _border(lambda value: _margin(check, design(value)), passing, failing)
    good, bad = (run_check(check, BevelLayout(design(value))) for value in (passing, failing))
    assert good.status == "pass" and good.remedy == "", good
    assert bad.status == check.severity, bad
    assert bad.remedy, bad
    # The two designs differ by rounding alone, so the figure must not jump at the border.
    assert good.margin is not None and bad.margin is not None and bad.limit is not None
    jump = good.margin - bad.margin
    assert -1e-8 <= bad.margin < 0.0 <= good.margin + 1e-8 and jump < 1e-6 * max(1.0, abs(bad.limit)), (
        f"{name}: margins {good.margin} and {bad.margin} at {passing} and {failing}"
    )
