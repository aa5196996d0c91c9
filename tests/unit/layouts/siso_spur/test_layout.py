"""The plain capstan drive: path, walk, groove, whole drums, bearings of the output; slip, equilibrium and loads."""

from dataclasses import replace
from math import atan2, degrees, exp, hypot, pi, radians, tanh, tau

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.checks.run import run_all, run_check
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.base import FrameCompliance
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.loader import layout_of, load_design, load_text, new_design_text
from mbcdm_cad.layouts.siso_spur.bill import bill
from mbcdm_cad.layouts.siso_spur.cable_path import cable_path
from mbcdm_cad.layouts.siso_spur.checks import winding
from mbcdm_cad.layouts.siso_spur.checks.frame import drum_and_input
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive, laid
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.siso_spur.support.stiffness import frame_compliance, out_of_line_mrad, seat_forces
from mbcdm_cad.model.analysis import analyse
from mbcdm_cad.model.bulk import analyse_many
from mbcdm_cad.model.capability import requirements, torque_at_slip_Nm
from mbcdm_cad.model.equilibrium import bearing_loads, solve_equilibrium
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.model.stiffness import unit_tensions_N
from mbcdm_cad.model.structure.quadrilateral import elements, solve
from mbcdm_cad.model.structure.sector_mesh import RimStep, SectorShape, sector_mesh
from mbcdm_cad.parts.drum_sector.dims import SET_SCREW_ANGLES_DEG, start_deg
from mbcdm_cad.parts.drum_sector.part import DrumSector
from mbcdm_cad.parts.input_pulley.part import InputPulley
from mbcdm_cad.parts.milled import cut
from mbcdm_cad.report.analysis_report import analyse_design
from mbcdm_cad.routes.route import Body, Wrap
from mbcdm_cad.workshop.kernel import validate_solid
from tests.support.checked import failing, result
from tests.support.reference import PARAMS, ROOT
from tests.support.sliced_cables import assert_joined, by_bisection, contact_point_m


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
    assert winding.turn_distance_mm(r, lead) == pytest.approx(nearest, abs=1e-4)


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
    found = next(c for c in winding.FAMILIES[1].checks if c.id == check)
    result = run_check(found, SpurLayout(laid(replace(drive, **change))))
    assert result.status == status, result.message


def test_remedy_of_slip_names_the_turns_that_hold(drive: SpurDrive) -> None:
    found = winding.input_slip
    result = run_check(found, SpurLayout(laid(replace(drive, turns=1))))
    assert "raise transmission.turns to 3" in result.remedy, result.remedy


def test_smooth_input_is_refused_a_steep_helix(drive: SpurDrive) -> None:
    smooth = replace(drive, input_pulleys=replace(drive.input_pulleys, surface="smooth"))
    found = winding.fleet_angle
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


SHORT = """\
name: output
configuration: {layout}
travel: {{half_angle_deg: 45.0}}
transmission: {{input_to_drum: 9.0, drum_radius_mm: 75.0}}
loads: {{peak_torque_Nm: {torque}}}
drum: {{{drum}}}
"""


def made(drum: str, torque: float = 8.0, layout: str = "siso_spur") -> SpurLayout:
    found = layout_of(load_text(SHORT.format(layout=layout, torque=torque, drum=drum)).drive)
    assert isinstance(found, SpurLayout)
    return found


@pytest.mark.parametrize(("circle_mm", "screws"), [(40.0, 6), (32.0, 3), (50.0, 8)])
def test_the_circle_and_the_number_are_those_of_the_file(circle_mm: float, screws: int) -> None:
    layout = made(f"output_circle_mm: {circle_mm}, output_screws: {screws}")
    places = layout.drum.payload_places
    assert [round(2 * hypot(x, z), 9) for x, z in places] == [circle_mm] * screws
    turned = sorted(degrees(atan2(x, z)) % 360.0 for x, z in places)
    assert np.allclose(np.diff(turned), 360.0 / screws), turned
    assert layout.drum.hub_radius > circle_mm / 2
    assert failing(layout) == {}


def test_more_screws_on_a_wider_circle_need_a_thinner_thread() -> None:
    """Friction holds mu F r for each screw: twice the screws on twice the circle hold four times the torque."""
    few, many = made("output_circle_mm: 24.0, output_screws: 4"), made("output_circle_mm: 48.0, output_screws: 8")
    assert many.drum.payload_screw_thread < few.drum.payload_screw_thread


def test_left_out_it_is_what_it_was() -> None:
    drum = made("outer_face_y_mm: 30.0").drum
    assert drum.payload_angles_deg == (0.0, 90.0, 180.0, 270.0)
    assert drum.payload_circle_radius == (drum.hub_radius + drum.bore_radius) / 2


@pytest.mark.parametrize(("screws", "apart_deg"), [(3, 45.0), (4, 45.0), (5, 27.0), (6, 15.0), (8, 22.5)])
def test_the_first_screw_keeps_all_of_them_away_from_the_set_screws(screws: int, apart_deg: float) -> None:
    holes = [start_deg(screws, SET_SCREW_ANGLES_DEG) + 360.0 / screws * k for k in range(screws)]
    off = [abs((hole - radial + 180.0) % 360.0 - 180.0) for hole in holes for radial in SET_SCREW_ANGLES_DEG]
    assert min(off) == apart_deg, sorted(off)[:3]


@pytest.mark.parametrize(("drum", "behind"), [("output_circle_mm: 24.0, output_screws: 12", True), ("", False)])
def test_set_screws_stand_behind_holes_that_would_come_near_them(drum: str, behind: bool) -> None:
    layout = made(drum)
    d, screw = layout.drum, layout.drive.screw(layout.drum.set_screw)
    assert failing(layout) == {}
    middle = (d.web_end_y + d.hub_face_y) / 2
    assert (d.set_screw_y < middle) is behind, (d.set_screw_y, middle)
    # The metal between the two cylinders, by points on both.
    turn, part = np.meshgrid(np.linspace(0.0, 2 * np.pi, 61), np.linspace(0.0, 1.0, 41))
    (x, z), *_ = sorted(d.payload_places, key=lambda at: abs(atan2(at[0], at[1]) - radians(SET_SCREW_ANGLES_DEG[0])))
    r = d.payload_hole / 2
    hole = np.stack([x + r * np.cos(turn), d.hub_face_y - part * d.payload_depth, z + r * np.sin(turn)], -1)
    out, a = d.bore_radius + part * (d.hub_radius - d.bore_radius), radians(SET_SCREW_ANGLES_DEG[0])
    r = screw.thread_mm / 2
    aside = r * np.cos(turn)
    set_screw = np.stack(
        [out * np.sin(a) + aside * np.cos(a), d.set_screw_y + r * np.sin(turn), out * np.cos(a) - aside * np.sin(a)], -1
    )
    wall = np.linalg.norm(hole.reshape(-1, 1, 3) - set_screw.reshape(1, -1, 3), axis=-1).min()
    assert wall >= layout.drive.drum_material.min_wall_mm - 1e-6, wall


def test_a_circle_without_walls_fails_with_the_figure() -> None:
    assert (
        "wall beside the payload's threads"
        in failing(made("output_circle_mm: 40.0, hub_diameter_mm: 40.0"))["hub_walls"]
    )


def test_a_stack_of_sectors_has_four_screws() -> None:
    with pytest.raises(InputError, match=r"drum.output_screws: the dowels between the hubs stand between four screws"):
        made("output_screws: 6", layout="miso_spur")


TEXT = """name: turns
configuration: siso_spur
travel: {half_angle_deg: HALF}
transmission: {input_to_drum: 6.0}
drive: {motor: maxon-ec60flat-200W, gearhead: none, encoder: none, drum_encoder: none}
loads: {peak_torque_Nm: 2.0}
"""


def drive_of(half_deg: float, more: str = "") -> SpurDrive:
    drive = load_text(TEXT.replace("HALF", str(half_deg)) + more).drive
    assert isinstance(drive, SpurDrive)
    return drive


@pytest.fixture(scope="module")
def turns() -> SpurLayout:
    """A drum that turns two and a quarter times each way."""
    layout = layout_of(drive_of(810.0))
    assert isinstance(layout, SpurLayout)
    return layout


def test_the_rules_give_a_drum_of_many_turns_that_passes(turns: SpurLayout) -> None:
    drive = turns.drive
    assert drive.whole_drum and not drive.stopped
    found = run_all(checks_of(drive), turns)
    assert not [r.id for r in found if r.status == "fail"]
    assert "stop_pin" not in {item.name for item in turns.bill().items} and not turns.drum.has_slot
    told = {r.id for r in found}
    assert {"turns_on_drum", "no_stop"} <= told and not {"stop_slot", "stop_pin", "wrap_under_turn"} & told


def test_turns_beside_each_other_on_the_drum_as_drawn(turns: SpurLayout) -> None:
    """Distances of the drawn centre line to itself and to the pockets, against the check's closed form."""
    drive, d = turns.drive, turns.drum
    lengths = [turns.cable_paths(float(a))[0].length_mm for a in np.linspace(-14.1, 14.1, 7)]
    assert np.ptp(lengths) < 1e-9 * lengths[0], lengths
    check = winding.turns_on_drum
    pocket_gaps = []
    (path,) = turns.cable_paths(0.0)
    for t, run in zip(d.tensioners, sorted(drive.cables, key=lambda c: c.step), strict=True):
        pieces = [p for n, p in path.pieces if n in {f"{kind}_{run.name}" for kind in ("drum", "lay", "dead")}]
        points = np.concatenate([p.points(np.linspace(0.0, 1.0, 4001)) for p in pieces])
        assert np.allclose(np.hypot(points[:, 0], points[:, 2]), t.radius_mm, atol=0.02)
        angle = np.unwrap(np.arctan2(points[:, 0], points[:, 2]))
        order = np.argsort(angle)
        angle, y = angle[order], points[order, 1]
        # The same place one turn further.
        apart = np.abs(np.interp(angle + tau, angle, y, right=np.nan) - y)
        turn = drive.helix_lead_mm * drive.total_ratio
        assert np.nanmax(apart) == pytest.approx(turn, rel=1e-6)
        along = t.side * angle
        along -= tau * round((along.min() - drive.landing_rad) / tau)
        off = along - t.anchor_rad + tau
        beside = (off > 0.0) & (off < atan2(t.pocket_end, t.radius_mm))
        pocket_gaps.append(float(np.abs(y[beside] - t.y_mm).min()) - d.nut_pocket - turns.flank_mm)
    told = run_check(check, turns)
    assert told.actual == pytest.approx(min(pocket_gaps), abs=2e-3), (told, pocket_gaps)


def test_terminals_come_by_the_input_and_their_pockets_stay_apart(turns: SpurLayout) -> None:
    drive, d = turns.drive, turns.drum
    rear, front = d.tensioners
    assert not rear.front and front.front and rear.y_mm < 0.0 < front.y_mm
    assert d.pocket_y(rear, d.nut_pocket)[1] < d.pocket_y(front, d.nut_pocket)[0]
    nut = drive.tensioner.nut_across_flats_mm / 3**0.5
    furthest = max(hypot(t.radius_mm + nut, t.nuts_end) for t in d.tensioners)
    furthest = max(furthest, *(hypot(t.radius_mm, t.last_tip) for t in d.tensioners))
    assert furthest < turns.frame.shelf_bottom_z and furthest < drive.centre_distance_mm - drive.input_radius_mm


def test_the_ring_is_one_solid_of_its_volume(turns: SpurLayout) -> None:
    part = DrumSector(turns.drum, 2.5)
    solid = part.solid()
    validate_solid("drum", solid)
    assert solid.Volume() == pytest.approx(part.volume_mm3(), rel=2e-3)


def test_wraps_of_more_than_a_turn_hold_as_endless_ones(turns: SpurLayout) -> None:
    """Friction of 0.15 over a turn holds e^0.94: at the test torque nothing slips as far as the terminals."""
    loads = turns.loads
    torque = turns.drive.loads.test_torque_Nm * np.array([0.0, 1.0])
    endless = np.ptp(solve_equilibrium(loads.si, torque).drum_angle_rad)
    _, on_drum = turns.wraps_rad(0.0)
    assert on_drum.min() > 2 * tau
    real = np.ptp(solve_equilibrium(loads.si.with_(drum_wrap_rad=on_drum), torque).drum_angle_rad)
    assert real == pytest.approx(endless, rel=1e-9)


def test_a_closed_web_turns_as_a_ring_in_shear() -> None:
    """T (1/a^2 - 1/b^2) / (4 pi G t), the exact solution; a seam that is left open turns 15 % further."""
    modulus, nu, a, b, t = 71700.0, 0.33, 10.0, 50.0, 2.0
    exact = 1e3 / (4 * pi * modulus / (2 * (1 + nu)) * t) * (1 / a**2 - 1 / b**2)
    mesh = sector_mesh(SectorShape(pi, a, (RimStep(b, 0.0, t),)), b / 14)
    parts = elements(mesh.node_mm, mesh.corner, mesh.thickness_mm, modulus, nu)
    stiffness = parts.stiffness.copy()
    held = np.isclose(mesh.radius_mm[mesh.corner], a)
    for k in range(8):
        stiffness[:, k, k] += 1e9 * held[:, k // 2]
    rim = np.flatnonzero(np.isclose(mesh.radius_mm, b))
    angle = mesh.angle_rad[rim]
    share = np.gradient(angle)
    share[[0, -1]] /= 2.0
    load = np.zeros((2 * len(mesh.node_mm), 1))
    load[2 * rim, 0], load[2 * rim + 1, 0] = np.cos(angle) * share, -np.sin(angle) * share
    load *= 1e3 / b / share.sum()
    moved = mesh.solved(stiffness, load)
    assert float(load[:, 0] @ moved[:, 0]) / 1e3 == pytest.approx(exact, rel=2e-3)
    cut = solve(mesh.corner, stiffness, load)
    assert float(load[:, 0] @ cut[:, 0]) / 1e3 > 1.1 * exact


def test_a_printed_drum_has_lugs_up_to_the_turn_beside_them() -> None:
    """Rules lengthen stud and lead until the terminal of a long fibre rope reaches its preload and its lug holds."""
    more = "rope: {type: uhmwpe-1}\ndrum: {material: pla}\nsupport: {material: pla}\n"
    s = layout_of(drive_of(270.0, more))
    assert isinstance(s, SpurLayout)
    found = {r.id: r for r in run_all(checks_of(s.drive), s)}
    assert not [r for r in found.values() if r.status == "fail"]
    assert found["take_up"].actual >= found["take_up"].limit and s.drum.lug_reach > s.drum.nut_pocket
    for t in s.drum.tensioners:
        # Most of its side is wound at one end of the travel.
        turned = t.side * s.half_travel_rad
        (path,) = s.cable_paths(turned)
        piece = next(p for n, p in path.pieces if n == f"drum_{t.cable_name}")
        x, y, z = piece.points(np.linspace(0.0, 1.0, 4001)).T
        off = np.arctan2(x, z) - turned - np.arctan2(*t.at(t.lug_start))
        near = np.abs((off + pi) % tau - pi) < 0.25
        low, high = s.drum.lug_y(t)
        gap = np.maximum(low - y[near], y[near] - high).min() - s.flank_mm
        assert near.any() and gap >= s.drive.drum_material.min_wall_mm - 0.01, gap


def test_an_input_of_too_many_turns_names_travel_and_ratio() -> None:
    with pytest.raises(InputError, match="too many turns on the input") as caught:
        load_text(TEXT.replace("HALF", "1080.0").replace("6.0", "20.0"))
    assert "input_to_drum" in str(caught.value)


def test_a_sector_that_is_too_small_names_the_whole_drum() -> None:
    drive = drive_of(100.0, "drum: {sector_half_angle_deg: 170.0}\n")
    wider = replace(drive, half_travel_deg=200.0)
    (told,) = run_all([c for c in checks_of(wider) if c.id == "wrap_under_turn"], layout_of(wider))
    assert told.status == "fail" and "drum.sector_half_angle_deg to 180" in told.remedy, told


@pytest.mark.parametrize(
    ("more", "what"),
    [
        ("drum: {sector_half_angle_deg: 177.0}\n", "no gap is left"),
        ("drum: {sector_half_angle_deg: 180.0}\nCROSSED", "two anchored cables would cross"),
        ("drum: {sector_half_angle_deg: 180.0}\nidlers: {pairs: 1}\n", "no whole drum beside idlers"),
    ],
)
def test_what_a_whole_drum_cannot_have(more: str, what: str) -> None:
    text = TEXT.replace("HALF", "60.0") + more.replace("CROSSED", "")
    if "CROSSED" in more:
        text = text.replace("{input_to_drum: 6.0}", "{input_to_drum: 6.0, cables: two_anchored}")
    with pytest.raises(InputError, match=what):
        load_text(text)


def stated(half_deg: float, ratio: float, radius_mm: float, torque_Nm: float, more: str = "") -> SpurDrive:
    text = TEXT.replace("HALF", str(half_deg)).replace("drive: {", "#").replace("2.0}", f"{torque_Nm}}}")
    drive = load_text(text.replace("6.0}", f"{ratio}, drum_radius_mm: {radius_mm}}}") + more).drive
    assert isinstance(drive, SpurDrive)
    return drive


@pytest.mark.parametrize(
    ("asked", "rope", "thicker"),
    [((300.0, 6.0, 40.0, 3.0), "FF-081", "7x7-1.0"), ((130.0, 15.0, 70.0, 2.0), "7x7-0.61", "FF-081")],
)
def test_a_stated_radius_takes_the_thickest_rope_that_bends_on_its_input(
    asked: tuple[float, float, float, float], rope: str, thicker: str
) -> None:
    """The thinnest rope for the usual preload bent too sharply; with less preload a thinner one holds."""
    drive = stated(*asked)
    assert drive.cable.name == rope
    assert not [r.id for r in run_all(checks_of(drive), layout_of(drive)) if r.status == "fail"]
    assert "bend_ratio" in {
        r.id
        for r in run_all(
            [check for check in checks_of(drive) if check.id == "bend_ratio"],
            layout_of(stated(*asked, f"rope: {{type: {thicker}}}\n")),
        )
        if r.status == "fail"
    }


@pytest.mark.slow
def test_the_web_of_a_wide_rim_bears_its_stress() -> None:
    drive = stated(150.0, 12.0, 90.0, 8.0)
    assert drive.drum.web_thickness_mm > 2.0
    assert not [r.id for r in run_all(checks_of(drive), layout_of(drive)) if r.status == "fail"]


def belt_tensions_N(preload_N: float, mu: float, wrap_rad: float, pulled_N: float) -> tuple[float, float]:
    """(tight, slack) end tensions of an elastic belt over a held pulley, by nodes that each obey Coulomb's law.

    Both sides are equal springs (unit stiffness, so that a way is a force); one end is pulled, the other let go, by
    ``pulled_N`` in steps. Nothing says where the belt sticks: every node moves until friction on its own few degrees
    holds it.
    """
    nodes, cell = 12, 150.0
    hold = exp(mu * wrap_rad / nodes)
    moved = [0.0] * nodes
    for pulled in np.linspace(0.0, pulled_N, 9)[1:].tolist():
        for _ in range(3000):
            worst = 0.0
            for k in (*range(nodes), *range(nodes - 2, -1, -1)):
                left_k, right_k = (1.0 if k == 0 else cell), (1.0 if k == nodes - 1 else cell)
                left = preload_N + left_k * (moved[k] + pulled if k == 0 else moved[k] - moved[k - 1])
                right = preload_N + right_k * (-pulled - moved[k] if k == nodes - 1 else moved[k + 1] - moved[k])
                step = 0.0
                if left > right * hold:
                    step = (right * hold - left) / (left_k + right_k * hold)
                elif right > left * hold:
                    step = (right - left * hold) / (right_k + left_k * hold)
                moved[k] += step
                worst = max(worst, abs(step))
            if worst < 1e-7:
                break
    return preload_N + moved[0] + pulled_N, preload_N - pulled_N - moved[-1]


@pytest.mark.parametrize(("mu", "wrap"), [(0.15, 2.0), (0.15, 6.0), (0.3, 4.0)])
def test_belt_of_nodes_slips_where_the_closed_form_says(mu: float, wrap: float) -> None:
    """T_h - T_l = 2 T_pre tanh(mu theta/2) with equal linear sides; pulled further it carries no more."""
    limit = 2 * 70.0 * tanh(mu * wrap / 2)
    tight, slack = belt_tensions_N(70.0, mu, wrap, 0.6 * limit / 2)
    assert tight - slack == pytest.approx(0.6 * limit, rel=0.03)
    tight, slack = belt_tensions_N(70.0, mu, wrap, 1.6 * limit / 2)
    assert tight / slack == pytest.approx(exp(mu * wrap), rel=1e-3)
    assert tight - slack == pytest.approx(limit, rel=0.03)


@settings(max_examples=40, deadline=None)
@given(mu=st.floats(0.05, 0.4), turns=st.integers(1, 5), way=st.sampled_from((1, -1)))
def test_slip_begins_where_the_tensions_differ_by_the_capstan_factor(
    drive: SpurDrive, mu: float, turns: int, way: int
) -> None:
    d = layout_of(replace(drive, friction_coefficient=mu, turns=turns)).si
    load = float(torque_at_slip_Nm(d, way)[0])
    tension = solve_equilibrium(d, way * load).tension_N
    factor = exp(mu * replace(drive, turns=turns).wrap_rad)
    assert float(tension.max() / tension.min()) == pytest.approx(factor, rel=1e-6)


def test_short_wraps_on_the_drum_leave_the_linear_law(drive: SpurDrive) -> None:
    """With next to nothing on the drum both sides are almost linear, and the torque at slip that of the tanh."""
    d = layout_of(drive).si.with_(drum_wrap_rad=[1e-3] * 2, input_wrap_rad=[1e-3] * 2)
    expected = 2 * 70.0 * tanh(0.15 * drive.wrap_rad / 2) * 59.4e-3
    assert float(torque_at_slip_Nm(d, 1)[0]) == pytest.approx(expected, rel=1e-3)


def test_wrap_is_what_both_contact_points_leave_of_the_turns(drive: SpurDrive) -> None:
    """By the angle between the points where the spans leave, seen from the input's axis."""
    d = layout_of(drive).si
    through = d.through_wrap_rad
    assert through is not None
    axis = d.routes.inputs[0]
    at = [contact_point_m(axis, route.wraps[0], route.spans[0].direction) for route in d.routes.cables]
    points = [point - np.array(axis.point_m) for point in at]
    angles = [np.arctan2(p[0], -p[2]) for p in points]
    assert float(through[0]) == pytest.approx(2 * pi * 3 - abs(angles[0] - angles[1]), rel=1e-12)
    assert float(through[0]) == pytest.approx(drive.wrap_rad, rel=1e-12)


def test_spans_touch_both_pulleys_where_the_path_does(drive: SpurDrive) -> None:
    for route in layout_of(drive).si.routes.cables:
        ends = [
            contact_point_m(layout_of(drive).si.routes.body(wrap.body), wrap, route.spans[0].direction)
            for wrap in route.wraps
        ]
        across = (ends[1] - ends[0]) * np.array([1.0, 0.0, 1.0])
        assert np.linalg.norm(across) == pytest.approx(route.spans[0].length_m, rel=1e-12)
        assert across / np.linalg.norm(across) == pytest.approx(route.spans[0].direction, abs=1e-12)


def test_equilibrium_is_that_of_cables_summed_up_in_slices(drive: SpurDrive) -> None:
    at = solve_equilibrium(layout_of(drive).si, 2.15)
    angle, tensions = by_bisection(drive, drive.free_span_mm * 1e-3, 2.15)
    assert float(at.drum_angle_rad) == pytest.approx(angle, rel=1e-4)
    assert at.tension_N == pytest.approx(tensions, rel=1e-5)


@settings(max_examples=30, deadline=None)
@given(load=st.floats(0.05, 3.0))
def test_both_senses_are_alike(drive: SpurDrive, load: float) -> None:
    d = layout_of(drive).si
    one, other = (solve_equilibrium(d, way * load) for way in (1.0, -1.0))
    assert float(one.drum_angle_rad) == pytest.approx(-float(other.drum_angle_rad), rel=1e-9)
    assert one.tension_N == pytest.approx(other.tension_N[::-1], rel=1e-9)


def test_input_holds_the_load_over_the_ratio(drive: SpurDrive) -> None:
    d = layout_of(drive).si
    for load in (0.3, -0.8):
        assert float(solve_equilibrium(d, load).input_torque_Nm(d)[0]) == pytest.approx(load / 9.9, rel=1e-9)


def test_spans_pull_input_and_drum_together(drive: SpurDrive) -> None:
    """Both spans point to the drum: their parts along the line of centres add up, across it they cancel."""
    loads = bearing_loads(layout_of(drive).si, np.array([70.0, 70.0]))
    pull = 2 * 70.0 * drive.free_span_mm / drive.centre_distance_mm
    assert loads.inputs[0].force_N == pytest.approx([0.0, 0.0, -pull], abs=1e-9)
    assert loads.drum.force_N == pytest.approx([0.0, 0.0, pull], abs=1e-9)


def test_slip_limits_the_torque_in_the_analysis_and_in_bulk(drive: SpurDrive) -> None:
    """One turn on a pulley of low friction: the cable slips before the motor reaches its limit."""
    slippery = replace(drive, turns=1, friction_coefficient=0.05)
    found = analyse(layout_of(slippery))
    slip = {limit.direction: limit.torque_Nm for limit in found.limits if limit.cause == "slip"}
    assert found.peak_torque_Nm == pytest.approx((slip[1], slip[-1]))
    assert slip[1] < 1.5
    d = layout_of(slippery).si
    figures = analyse_many(d.spread(2), requirements(layout_of(slippery)))
    # Many designs at once have no terminals, so that their wraps have no end: they slip a little later.
    endless = float(torque_at_slip_Nm(d, 1)[0])
    assert figures.peak_torque_Nm[0] == pytest.approx([endless] * 2, rel=1e-6)
    assert slip[1] < endless, f"{slip[1]} N m with wraps that end, {endless} without"
    assert "slip" in {limit.cause for limit in analyse(layout_of(drive)).limits}


def test_limited_wraps_at_the_end_of_travel_turn_the_drum_less(drive: SpurDrive) -> None:
    even = layout_of(drive).si
    short = even.with_(drum_wrap_rad=[radians(20.0)] * 2)
    turned = [abs(float(solve_equilibrium(d, 2.15).drum_angle_rad)) for d in (even, short)]
    assert turned[1] < turned[0], turned


RING = """name: ring
configuration: siso_spur
travel: {half_angle_deg: 86}
transmission: {input_to_drum: 18.6, drum_radius_mm: 111}
loads: {peak_torque_Nm: 3.55}
"""


@pytest.mark.parametrize("name", ["siso_spur.yaml", "gallery/capstan.yaml", "ring"])
def test_slip_is_one_figure_in_check_and_analyse(name: str) -> None:
    loaded = load_text(RING) if name == "ring" else load_design(PARAMS / name)
    check = result(loaded, "input_slip")
    told = [t.torque_Nm for t in analyse_design(loaded.drive).figures.limits if t.cause == "slip"]
    checked = check.actual * loaded.drive.loads.peak_torque_Nm
    assert min(told) == pytest.approx(checked, rel=1e-6), f"analyse {told} N m, check {checked} N m"
