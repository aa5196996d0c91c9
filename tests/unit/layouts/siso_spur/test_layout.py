"""Geometry of the plain capstan drive: cable path, walk, groove under the cable, checks of the winding."""

from dataclasses import replace
from math import degrees, pi
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.checks.run import run_check
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.base import FrameCompliance
from mbcdm_cad.layouts.loader import layout_of, load_text, new_design_text
from mbcdm_cad.layouts.siso_spur.bill import bill
from mbcdm_cad.layouts.siso_spur.cable_path import cable_path
from mbcdm_cad.layouts.siso_spur.checks.room import drum_and_input
from mbcdm_cad.layouts.siso_spur.checks.winding import FAMILIES, fleet_angle, input_slip, turn_distance_mm
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive, laid
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.siso_spur.support.stiffness import frame_compliance, out_of_line_mrad, seat_forces
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.model.stiffness import unit_tensions_N
from mbcdm_cad.parts.input_pulley.part import InputPulley
from mbcdm_cad.parts.milled import cut
from mbcdm_cad.routes.route import Body, Wrap, contact_point_m
from tests.support.checked import failing
from tests.support.smooth_path import assert_joined

ROOT = Path(__file__).parents[4]


def test_params_file_is_what_the_schema_writes() -> None:
    """After a change of schema or reference:
    ``rm params/siso_spur.yaml && mbcdm init params/siso_spur.yaml --reference --configuration siso_spur``."""
    assert (ROOT / "params/siso_spur.yaml").read_text("utf-8") == new_design_text("siso_spur", "siso_spur")


def test_reference_design_fails_no_check(drive: SpurDrive) -> None:
    failed = failing(drive)
    assert not failed, failed


def test_a_wide_rim_below_the_encoder_is_told(drive: SpurDrive) -> None:
    """A printed drum of two cables met the encoder at every pose, and no check knew."""
    large = replace(drive.encoder, diameter_mm=40.0)
    assert drum_and_input(layout_of(replace(drive, encoder=large))).actual > 0.25
    wide = replace(drive, encoder=large, drum=replace(drive.drum, outer_face_y_mm=60.0))
    found = drum_and_input(layout_of(wide))
    assert "encoder" in found.subject and found.actual == pytest.approx(
        drive.centre_distance_mm - 20.0 - drive.drum_radius_mm - layout_of(drive).flank_mm
    ), found


@pytest.mark.parametrize("hub_mm", [20.0, 70.0])
def test_the_stop_pin_stands_outside_hub_and_boss(drive: SpurDrive, hub_mm: float) -> None:
    """Its slot leaves a web beside the hub, and the boss that stands out of the plate does not meet it."""
    bearing = replace(drive.bearings.drum, outer_diameter_mm=66.0)
    changed = replace(
        drive, drum=replace(drive.drum, hub_diameter_mm=hub_mm), bearings=replace(drive.bearings, drum=bearing)
    )
    dims = SpurLayout(changed)
    pin, slot = dims.frame.stop_pin_radius, dims.drum.stop_slot_width / 2
    beside_hub = dims.frame.stop_pin_z - slot - hub_mm / 2
    beside_boss = dims.frame.stop_pin_z - pin - dims.frame.boss.radius
    assert beside_hub >= 2 * drive.drum_material.min_wall_mm, f"{beside_hub} mm"
    assert beside_boss >= drive.clearances.running_mm, f"{beside_boss} mm"
    assert dims.drum.stop_radius == dims.frame.stop_pin_z


def test_a_groove_that_the_kernel_cuts_through_the_pulley_is_cut_turn_by_turn(
    dims: SpurLayout, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The kernel cut a pulley of 10 turns into 3 bodies; here the first cut of 1.2 turns is made to fail so."""
    (groove,) = dims.inputs[0].grooves
    share = 1.2 * 2 * pi / (groove.end_angle_rad - groove.start_angle_rad)
    short = replace(
        groove,
        end_angle_rad=groove.start_angle_rad + 1.2 * 2 * pi,
        end_z=groove.start_z + share * (groove.end_z - groove.start_z),
    )
    pulley, tools = InputPulley(replace(dims.inputs[0], grooves=(short,))), list[object]()
    whole = pulley.solid().Volume()

    def cut_through(body: object, cutters: list[object], name: str) -> object:
        tools.append(cutters)
        if len(tools) == 1:
            raise ValueError(f"{name}: drawing gave 3 bodies")
        return cut(body, cutters, name)  # type: ignore[arg-type]

    monkeypatch.setattr("mbcdm_cad.parts.input_pulley.draw.cut", cut_through)
    in_turns = pulley.solid().Volume()
    assert len(tools) > 2 and in_turns == pytest.approx(whole, rel=1e-4), f"{in_turns} for {whole} mm^3"


@settings(max_examples=40, deadline=None)
@given(
    ratio=st.floats(3.0, 9.9),
    distance=st.floats(68.0, 120.0),
    turns=st.integers(1, 6),
    lead=st.floats(0.85, 2.0),
    angle=st.floats(-35.0, 35.0),
    open_spans=st.booleans(),
)
def test_path_keeps_its_length_and_joins_without_a_kink(
    drive: SpurDrive, ratio: float, distance: float, turns: int, lead: float, angle: float, open_spans: bool
) -> None:
    """One slope all the way: whatever the winding, nothing bends sideways and nothing stretches over the travel."""
    cables = tuple(replace(c, input_radius_mm=c.drum_radius_mm / ratio) for c in drive.cables)
    reach = cables[0].drum_radius_mm + cables[0].input_radius_mm
    changed = replace(
        drive,
        cables=cables,
        centre_distance_mm=max(distance, reach + 1.0),
        turns=turns,
        helix_lead_mm=lead,
        open_spans=open_spans,
    )
    changed = laid(changed)
    anchors = {c.name: (changed.landing_rad + 1.0, 5.0) for c in cables}
    centred, path = (cable_path(changed, anchors, at) for at in (0.0, np.radians(angle)))
    assert path.length_mm == pytest.approx(centred.length_mm, abs=1e-9)
    assert_joined(path)


def test_spans_walk_one_lead_a_turn_and_leave_their_turns_apart(dims: SpurLayout) -> None:
    """Walk over the travel: lead x ratio x travel / 360; apart: lead x wrap / 360; both measured on the path."""
    drive = dims.drive
    ends = []
    for angle in (-35.0, 35.0):
        wound = dims.cable_paths(np.radians(angle))[0].piece("wound").points(np.array([0.0, 1.0]))
        ends.append(wound[:, 1])
    assert ends[1] - ends[0] == pytest.approx([0.9 * 9.9 * 70.0 / 360.0] * 2, abs=1e-9)
    assert ends[0][1] - ends[0][0] == pytest.approx(0.9 * degrees(drive.wrap_rad) / 360.0, abs=1e-9)


@pytest.mark.parametrize("open_spans", [False, True])
def test_groove_lies_under_the_cable_at_every_angle(drive: SpurDrive, open_spans: bool) -> None:
    """In the pulley's own frame the wound cable follows the groove's helix, and the groove reaches beyond it."""
    dims = SpurLayout(laid(replace(drive, open_spans=open_spans)))
    groove = dims.inputs[0].grooves[0]
    for angle in (-35.0, 0.0, 20.0, 35.0):
        place = next(i.location for i in bill(dims, angle).items if i.name == "input_pulley_main")
        wound = dims.cable_paths(np.radians(angle))[0].piece("wound").points(np.linspace(0.0, 1.0, 60))
        own = place.inverse.apply(wound)
        assert np.hypot(own[:, 0], own[:, 1]) == pytest.approx(groove.root_radius + 0.405, abs=1e-9)
        per_rad = (groove.end_z - groove.start_z) / (groove.end_angle_rad - groove.start_angle_rad)
        at = groove.start_angle_rad + (own[:, 2] - groove.start_z) / per_rad
        off = np.arctan2(own[:, 1], own[:, 0]) - at
        assert np.abs(np.angle(np.exp(1j * off))).max() < 1e-9
        low, high = sorted((groove.start_angle_rad, groove.end_angle_rad))
        assert low < at.min() and at.max() < high


@pytest.mark.parametrize("open_spans", [False, True])
def test_spans_do_no_work_on_drum_and_input_together(drive: SpurDrive, open_spans: bool) -> None:
    """The pull of each drawn span on both bodies, with their turns: whichever way the input turns.

    The routes have the same contact points as the drawn cable.
    """
    dims = SpurLayout(laid(replace(drive, open_spans=open_spans)))
    body = next(b for b in dims.moving_bodies if b.name == "input_main")
    assert body.axis == ((0.0, 1.0, 0.0) if open_spans else (0.0, -1.0, 0.0))
    si, (path,) = layout_of(dims.drive).si, dims.cable_paths(0.0)
    for k, run in enumerate(dims.drive.cables):
        span = path.piece(f"span_{run.name}")
        ends = span.points(np.array([0.0, 1.0])) * 1e-3
        off, on = sorted(ends, key=lambda p: -p[2])
        pull = (on - off) / np.linalg.norm(on - off)
        at_input = np.cross(off - np.array(body.origin_mm) * 1e-3, pull) @ np.array(body.axis)
        at_drum = np.cross(on, -pull)[1]
        assert abs(at_input * dims.drive.total_ratio + at_drum) < 1e-12, (at_input, at_drum)
        route = si.routes.cables[k]
        for wrap, own, point in ((route.wraps[0], si.routes.inputs[0], off), (route.wraps[1], si.routes.drum, on)):
            found = contact_point_m(own, wrap, route.spans[0].direction)
            assert np.allclose(found, point, atol=1e-9), (run.name, wrap.body, found, point)
    assert si.free_span_m[0] * 1e3 == pytest.approx(span.length_mm / dims.drive.stretched, rel=1e-9)


def test_open_spans_bend_the_cable_one_way_and_wrap_less(drive: SpurDrive) -> None:
    crossed, parallel = SpurLayout(drive), SpurLayout(laid(replace(drive, open_spans=True)))
    for dims, straight in ((crossed, False), (parallel, True)):
        each = [len({np.sign(w.turning * b.axis[1]) for w, b in _wraps_with_bodies(dims, k)}) for k in (0, 1)]
        assert each == ([1, 1] if straight else [2, 2]), each
    assert parallel.drive.wrap_rad < crossed.drive.wrap_rad
    assert not parallel.inputs[0].grooves[0].right_handed and crossed.inputs[0].grooves[0].right_handed
    # Circles that overlap have an external tangent: pulleys do not.
    with pytest.raises(ModelError, match="does not exceed r_o"):
        layout_of(replace(parallel.drive, centre_distance_mm=parallel.drive.drum_radius_mm + 1.0)).si.free_span_m  # noqa: B018


def _wraps_with_bodies(dims: SpurLayout, k: int = 0) -> list[tuple[Wrap, Body]]:
    routes = layout_of(dims.drive).si.routes
    return [(wrap, routes.body(wrap.body)) for wrap in routes.cables[k].wraps]


@pytest.mark.parametrize(
    ("line", "what"),
    [
        ("idlers: {pairs: 1}", "not beside idlers"),
        ("first_stage: {total_ratio: 24.0}", "not beside first_stage"),
        ("configuration: miso_spur", "the inputs turn against the drum"),
    ],
)
def test_what_open_spans_cannot_be_beside(line: str, what: str) -> None:
    text = f"name: o\nconfiguration: siso_spur\n{line}\ntravel: {{half_angle_deg: 30.0}}\n"
    if line.startswith("configuration"):
        text = text.replace("configuration: siso_spur\n", "")
    text += "transmission: {input_to_drum: 4.0, spans: open}\nloads: {peak_torque_Nm: 2.0}\n"
    with pytest.raises(InputError, match=what):
        load_text(text)


def test_turns_beside_each_other_by_brute_force(drive: SpurDrive) -> None:
    """The span, going on in line with its helix, against the turn before it, both as points."""
    r, lead = drive.input_radius_mm, drive.helix_lead_mm
    slope = lead / (2 * pi * r)
    a = np.linspace(-2.5, 2.5, 4001)
    turn = np.stack([r * (1 - np.cos(a)), r * np.sin(a), slope * r * a - lead], axis=1)
    s = np.linspace(0.0, 6.0, 601)
    span = np.stack([0 * s, s, slope * s], axis=1)
    nearest = min(float(np.linalg.norm(turn - point, axis=1).min()) for point in span)
    assert turn_distance_mm(r, lead) == pytest.approx(nearest, abs=1e-4)


@pytest.mark.parametrize(
    ("check", "change", "status"),
    [
        ("input_slip", {"turns": 2}, "pass"),
        ("input_slip", {"turns": 1}, "fail"),
        ("input_sticks", {"turns": 2}, "warn"),
        ("input_sticks", {"turns": 3}, "pass"),
        ("helix_lead", {"helix_lead_mm": 0.88}, "fail"),
        ("free_span", {"centre_distance_mm": 65.45}, "fail"),
        ("land_spacing", {"turns": 1}, "fail"),
    ],
)
def test_winding_against_its_limits(drive: SpurDrive, check: str, change: dict[str, float], status: str) -> None:
    found = next(c for c in FAMILIES[1].checks if c.id == check)
    result = run_check(found, SpurLayout(laid(replace(drive, **change))))
    assert result.status == status, result.message


def test_remedy_of_slip_names_the_turns_that_hold(drive: SpurDrive) -> None:
    found = input_slip
    result = run_check(found, SpurLayout(laid(replace(drive, turns=1))))
    assert "raise transmission.turns to 3" in result.remedy, result.remedy


def test_smooth_input_is_refused_a_steep_helix(drive: SpurDrive) -> None:
    smooth = replace(drive, input_pulleys=replace(drive.input_pulleys, surface="smooth"))
    found = fleet_angle
    for lead, status in ((0.9, "pass"), (1.1, "fail")):
        result = run_check(found, SpurLayout(laid(replace(smooth, helix_lead_mm=lead))))
        assert result.status == status, result.message


def test_every_item_joins_once_in_the_order_of_assembly(dims: SpurLayout) -> None:
    joined = [name for step in dims.assembly_order for name in step.items]
    assert sorted(joined) == sorted(item.name for item in bill(dims).items)


def test_two_sides_must_run_apart() -> None:
    text = new_design_text("x", "siso_spur").replace("drum_side: -x", "drum_side: +x")
    with pytest.raises(Exception, match="both sides run to one side"):
        load_text(text)


def test_forces_of_1_Nm_leave_the_mounts_its_moment_alone(dims: SpurLayout) -> None:
    forces = seat_forces(dims, unit_tensions_N(layout_of(dims.drive).si))
    assert sum(f for _, _, f, _ in forces) == pytest.approx(0.0, abs=1e-9)
    assert sum(p[2] * f + c for _, p, f, c in forces) * 1e-3 == pytest.approx(-1.0, rel=1e-9)
    assert sum(p[1] * f for _, p, f, _ in forces) * 1e-3 == pytest.approx(0.0, abs=1e-9)


@pytest.mark.slow
def test_thicker_walls_turn_less(drive: SpurDrive) -> None:
    def found(**walls: float) -> FrameCompliance:
        return frame_compliance(SpurLayout(replace(drive, support=replace(drive.support, **walls))))

    now = found()
    assert 25.0 < now.windup_urad_Nm < 40.0, f"{now} urad per N m; solid elements 34"
    for wall, thick in {"plate": 6.0, "bridge": 5.0, "encoder shelf": 5.0}.items():
        thicker = found(**{f"{wall.replace(' ', '_')}_mm": thick})
        assert thicker.shares_urad_Nm[wall] < now.shares_urad_Nm[wall], wall
        # The middle of a thicker plate is further from the bridge, which then bends more.
        assert thicker.windup_urad_Nm < (1.01 if wall == "plate" else 1.0) * now.windup_urad_Nm, wall


def test_the_shelf_has_a_wall_beside_the_heads_of_the_encoder_screws(drive: SpurDrive) -> None:
    """Of a material with thick walls, such as PLA, the shelf is wider than the encoder."""
    for wall in (0.8, 1.2):
        material = replace(drive.frame_material, min_wall_mm=wall)
        f = SpurLayout(replace(drive, frame_material=material)).frame
        beside = f.shelf_half_width - f.encoder_circle_radius - f.encoder_head_radius
        assert beside >= wall - 1e-9, f"{beside} mm of {wall}"


def test_the_pull_of_the_cables_bends_the_yoke_as_a_cantilever(drive: SpurDrive) -> None:
    """Seat against shaft: F l^2 / 2EI less F l^3 / 3EI over the bearings' distance; the plate turns both alike."""
    pull_N, thick_mm, turns = 50.0, (1.0, 1.5), []
    for bridge_mm in thick_mm:
        s = SpurLayout(replace(drive, support=replace(drive.support, bridge_mm=bridge_mm)))
        turns.append(out_of_line_mrad(s, 0.0, pull_N)[1])
    f, (lower, upper), material = s.frame, s.input_bearings_mm(0), drive.frame_material
    v = s.levels
    long, wide = (v.top_plate_bottom_z + v.top_plate_top_z) / 2 - v.front_y, 2 * f.shelf_half_width
    # The bridge is wider than long, so that it bends as a plate.
    modulus = material.youngs_modulus_GPa * 1e3 / (1.0 - material.poisson_ratio**2)
    give = [12.0 / (modulus * wide * thick**3) for thick in thick_mm]
    beams = [pull_N * each * (long**2 / 2 - long**3 / 3 / abs(upper - lower)) * 1e3 for each in give]
    assert turns[0] - turns[1] == pytest.approx(beams[0] - beams[1], rel=0.15), f"{turns} mrad, beams {beams} mrad"
