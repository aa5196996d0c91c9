"""Two cables anchored on input and drum, and cables in parallel: paths, grooves, slots, loads, checks, messages."""

from dataclasses import replace
from math import degrees, pi, radians, tau

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.checks.geometry import CABLE_GAP_MM, in_pieces, nearest_mm
from mbcdm_cad.checks.run import run_all, run_check
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.life import ropes_in_use
from mbcdm_cad.layouts.loader import layout_of, load_text
from mbcdm_cad.layouts.siso_spur.bill import bill
from mbcdm_cad.layouts.siso_spur.cable_path import cable_paths, input_wrap_rad
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive, laid
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.siso_spur.path_figures import plan
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.model.analysis import analyse
from mbcdm_cad.model.capability import torque_at_slip_Nm
from mbcdm_cad.model.equilibrium import bearing_loads, solve_equilibrium
from mbcdm_cad.model.stiffness import sticking_stiffness_Nm_rad
from mbcdm_cad.parts.input_pulley.dims import CHAMFER_MM
from mbcdm_cad.parts.making import land_band_mm
from mbcdm_cad.rig.bench import cables_of
from mbcdm_cad.rig.chain import pairs_of
from mbcdm_cad.storage.compiled import compiled
from tests.support.sliced_cables import assert_joined, by_bisection, contact_point_m, stretch_m

TEXT = """name: parallel
configuration: siso_spur
travel: {half_angle_deg: 35.0}
transmission: {input_to_drum: 9.0, parallel: 2}
loads: {peak_torque_Nm: 4.0}
"""
REMOVED = "transmission: {input_to_drum: 9.0, parallel: 2, %s}"


def uneven(drive: SpurDrive, **figures: float) -> SpurLayout:
    """The layout with ``figures`` in place of those that it works out."""
    layout = SpurLayout(drive)
    vars(layout).update(figures)
    return layout


def lands_off(lay: SpurLayout, off_mm: float) -> float:
    """How far ratios are off where diameters differ by this: radii within a quarter of it on both sides."""
    return float(np.hypot(*(off_mm / 4.0 / r for r in (lay.drive.drum_radius_mm, lay.drive.input_radius_mm))))


def beside(drive: SpurDrive, count: int) -> SpurDrive:
    """``drive`` with ``count`` of its cable side by side."""
    cables = tuple(replace(c, name=f"{c.name}_{k + 1}") for k in range(count) for c in drive.cables)
    sigmas = drive.sigmas.of_cables([0, 1] * count)
    return laid(replace(drive, parallel=count, cables=cables, sigmas=sigmas))


@pytest.fixture(scope="module")
def two() -> SpurLayout:
    """Two cables as the rules give them."""
    layout = layout_of(load_text(TEXT).drive)
    assert isinstance(layout, SpurLayout)
    return layout


@settings(max_examples=20, deadline=None)
@given(count=st.integers(2, 4), load=st.floats(-2.0, 2.0))
def test_each_cable_is_the_plain_drive_s_with_its_share(drive: SpurDrive, count: int, load: float) -> None:
    """n cables under n M turn as far as one under M, at its tensions; stiffness and torque at slip are n times its."""
    one, all_ = layout_of(drive).si, layout_of(beside(drive, count)).si
    alone, together = solve_equilibrium(one, load), solve_equilibrium(all_, count * load)
    assert float(together.drum_angle_rad) == pytest.approx(float(alone.drum_angle_rad), rel=1e-9, abs=1e-15)
    assert together.tension_N.reshape(count, 2) == pytest.approx(np.tile(alone.tension_N, (count, 1)), rel=1e-9)
    assert float(sticking_stiffness_Nm_rad(all_)) == pytest.approx(count * float(sticking_stiffness_Nm_rad(one)))
    assert torque_at_slip_Nm(all_, 1) == pytest.approx([count * float(torque_at_slip_Nm(one, 1)[0])] * count)
    own, its = bearing_loads(one, alone.tension_N).inputs[0], bearing_loads(all_, together.tension_N).inputs[0]
    assert its.force_N == pytest.approx(count * own.force_N, rel=1e-9)


def test_unequal_preloads_load_one_cable_more_and_another_slips_first(drive: SpurDrive) -> None:
    """Checks see the spread. When the loosest slips, wraps summed up in slices stretch alike, as one drum turns all."""
    spread, three = 0.2, beside(drive, 3)
    layout, equal = uneven(three, preload_spread=spread), uneven(three, preload_spread=0.0)
    si, preload = layout.loads.si, drive.cables[0].preload_N
    assert si.preload_N == pytest.approx(preload * np.repeat([1 + spread, 1.0, 1 - spread], 2))
    assert layout_of(three).si.preload_N == pytest.approx([preload] * 6)
    assert layout.loads.highest_N == pytest.approx(equal.loads.highest_N + spread * preload, rel=0.02)
    at = solve_equilibrium(si, torque_at_slip_Nm(si, 1).min())
    ratios = (at.tension_N[::2] / at.tension_N[1::2]) ** si.sigma[::2]
    holds = np.exp(drive.friction_coefficient * drive.wrap_rad)
    assert ratios[2] == pytest.approx(holds, rel=1e-6) and ratios[0] < ratios[1] < 0.8 * holds, (ratios, holds)
    rope, spans = drive.cable.axial_stiffness_N, (drive.free_span_mm, drive.input_radius_mm, drive.drum_radius_mm)
    for run, tension, own in zip(three.cables, at.tension_N, si.preload_N, strict=True):
        along = stretch_m(tension, own, tuple(1e-3 * x for x in spans), rope, drive.friction_coefficient)
        turned = -run.sense * float(at.drum_angle_rad) * drive.drum_radius_mm * 1e-3
        assert along == pytest.approx(turned, rel=1e-3), run.name
    check = next(c for c in checks_of(three) if c.id == "input_slip")
    lower = [run_check(check, one).actual for one in (equal, layout)]
    # A loose cable's slip zones are longer, so that it takes less than its share.
    assert 1 - spread < lower[1] / lower[0] < 0.9, lower


def test_the_rules_share_the_load_and_pass(two: SpurLayout) -> None:
    found = run_all(checks_of(two.drive), two)
    assert not [r.id for r in found if r.status == "fail"]
    assert {"sectors_apart", "hub_dowels", "dowel_holes", "parallel_spread"} <= {r.id for r in found}
    check = next(c for c in checks_of(two.drive) if c.id == "parallel_spread")
    told = run_check(check, two)
    cable = two.drive.cables[0]
    # A nut's turn over the length that it draws: EA pitch / L, a twenty-fourth of it.
    rope, length, preload = two.drive.cable.axial_stiffness_N, min(two.tensioned_lengths_mm()), cable.preload_N
    assert two.by_nut == pytest.approx(rope * two.drive.tensioner.pitch_mm / 24 / length / preload, rel=1e-6)
    assert two.by_lands == pytest.approx(uneven(two.drive, lands_off=lands_off(two, _band_mm(two))).by_lands)
    assert told.actual == pytest.approx(float(np.hypot(two.by_nut, two.by_lands)))
    # The spread is what nuts, lands and the pitch of a span leave; beyond half of the preload it warns.
    assert told.actual < two.preload_spread < 0.5 and told.status == "pass", told
    assert run_check(check, uneven(two.drive, lands_off=5.0 * two.lands_off)).status == "warn"
    # Where nothing slips the span takes all that the drum winds on too much.
    drive = replace(two.drive, friction_coefficient=1e6)
    off = float(np.hypot(0.0005 / cable.drum_radius_mm, 0.0005 / cable.input_radius_mm))
    way = off * cable.drum_radius_mm * two.half_travel_rad / drive.strand_mm
    assert uneven(drive, lands_off=off).by_lands == pytest.approx(rope * way / preload, rel=1e-4)
    assert [rope.name for rope in ropes_in_use(two, two.loads.si)] == list(two.drive.cable_names)
    assert {slot.cable_name for slot in two.inputs[0].grooves} == set(two.drive.cable_names)


def _band_mm(lay: SpurLayout) -> float:
    """Difference of diameters, the same on drum and input, that leaves what the tolerances of both leave."""
    radii = (lay.drive.drum_radius_mm, lay.drive.input_radius_mm)
    off = (
        np.hypot(*(land_band_mm(lay.drive, r, b) / r for b, r in zip(("drum", "pulley"), radii, strict=True))) / 2**0.5
    )
    return float(4.0 * off / np.hypot(*(1.0 / r for r in radii)))


CYCLES, STEP_DEG = 6, 3.5


@compiled
def _settle(rope: np.ndarray, at: int, span: float, drum: float, pulley: float) -> None:
    """Let nodes of both cables slip until friction holds them all."""
    moved = 1.0
    while moved > 1e-6:
        moved = 0.0
        for k in range(2):
            for j in range(rope.shape[1] - 1):
                holds = np.exp(drum if j < at - 1 else drum / 2 if j < at else pulley / 2 if j == at else pulley)
                one, other = span if j == at else 1.0, span if j + 1 == at else 1.0
                slips = 0.0
                if rope[k, j + 1] > rope[k, j] * holds:
                    slips = (rope[k, j + 1] - rope[k, j] * holds) / (1.0 / other + holds / one)
                elif rope[k, j] > rope[k, j + 1] * holds:
                    slips = -(rope[k, j] - rope[k, j + 1] * holds) / (1.0 / one + holds / other)
                rope[k, j] += slips / one
                rope[k, j + 1] -= slips / other
                moved = max(moved, abs(slips))


@compiled
def _half_range(cells: tuple[int, int, float], drum: float, pulley: float, e: float, load: float) -> float:
    """Half of what the tensions of two spans differ by, over their mean, at most in the last cycle of the drum.

    One side of two cables in cells of rope; ``cells``: of the travel, of the wrap that is always on the drum, and of
    the span; ``drum``, ``pulley``: mu times the angle of a cell there. In a step a cell of each goes over with its
    tension, and the drum pulls ``e`` (tension of a cell, of the preload) more of one and less of the other than the
    input pays out; then a load stretches both spans by ``load`` and, reversed, as much the other way. The far ends, on
    the input, stick.
    """
    travel, least, span = cells
    sides = np.array([1.0, -1.0])
    rope = np.ones((2, least + travel + 41))
    at, way, largest = least + travel // 2, 1, 0.0
    for step in range(2 * travel * CYCLES):
        way = -1 if at == least + travel else 1 if at == least else way
        for k in range(2):
            rope[k, at] += (way * e * sides[k] + rope[k, at + way] - rope[k, at]) / span
            rope[k, at + way] = rope[k, at]
        at += way
        for pull in (0.0, load, -2.0 * load, load):
            for k in range(2):
                rope[k, at] += pull / span
            if pull != 0.0 or load == 0.0:
                _settle(rope, at, span, drum, pulley)
        if step >= 2 * travel * (CYCLES - 1):
            largest = max(largest, abs(rope[0, at] - rope[1, at]) / (rope[0, at] + rope[1, at]))
    return largest


def _simulated(lay: SpurLayout, off_mm: float, load: float = 0.0) -> float:
    """The same of a drive whose lands differ by ``off_mm`` in diameter; ``load``: what it changes of a preload."""
    drive, cable = lay.drive, lay.drive.cables[0]
    radii, step, mu = (cable.drum_radius_mm, cable.input_radius_mm), radians(STEP_DEG), lay.drive.friction_coefficient
    cell, wrap_deg = cable.drum_radius_mm * step, degrees(lay.units[0].anchor_rad(lay.units[0].drive.cables[0]))
    least = max(round((wrap_deg - drive.half_travel_deg) / STEP_DEG), 1)
    cells = (round(2 * drive.half_travel_deg / STEP_DEG), least, drive.strand_mm / cell)
    e = lands_off(lay, off_mm) * drive.cable.axial_stiffness_N / cable.preload_N
    pull = (load * drive.strand_mm + sum(radii) * load**2 / (2.0 * mu)) / cell
    return float(_half_range(cells, mu * step, mu * step * radii[0] / radii[1], e, pull))


@pytest.mark.slow
def test_lands_off_wind_the_cables_against_each_other(two: SpurLayout) -> None:
    """Rope in cells with friction at each: the law of the spread, with slip on most of the wrap and on little of it."""
    slow = layout_of(load_text(TEXT.replace("9.0,", "3.0, drum_radius_mm: 60.0,")).drive)
    assert isinstance(slow, SpurLayout)
    for lay in (two, slow):
        for off_mm in (_band_mm(lay), 0.2 * _band_mm(lay)):
            law = uneven(lay.drive, lands_off=lands_off(lay, off_mm)).by_lands
            assert 0.75 < _simulated(lay, off_mm) / law < 1.3, (off_mm, law)
    lands, cable = _band_mm(two), two.drive.cables[0]
    peak = two.drive.loads.peak_torque_Nm * 1e3 / (4.0 * cable.drum_radius_mm) / cable.preload_N
    assert _simulated(two, lands, load=peak) < 0.7 * _simulated(two, lands)


def test_cables_as_drawn_lie_side_by_side_in_their_grooves(two: SpurLayout) -> None:
    drive, pulley = two.drive, two.inputs[0]
    for angle in np.linspace(-1.0, 1.0, 5) * two.half_travel_rad:
        one, other = two.cable_paths(float(angle))
        for (_, piece), (_, next_) in zip(one.pieces, other.pieces, strict=True):
            shift = next_.points(np.linspace(0.0, 1.0, 5)) - piece.points(np.linspace(0.0, 1.0, 5))
            assert shift == pytest.approx(np.tile([0.0, drive.pitch_mm, 0.0], (5, 1)), abs=1e-9)
        first, second = (in_pieces(path.sample(0.5)) for path in (one, other))
        assert nearest_mm(first, second, 0.5) - drive.cable.diameter_mm > CABLE_GAP_MM
        for path, groove in zip((one, other), pulley.grooves, strict=True):
            ends = dict(path.pieces)["wound"].points(np.array([0.0, 1.0]))[:, 1]
            low, high = sorted((groove.start_z, groove.end_z))
            assert low < ends.min() and ends.max() < high, (degrees(angle), ends, low, high)
    heights = [route.wraps[-1].height_m * 1e3 for route in layout_of(drive).si.routes.cables]
    assert np.subtract(heights[2:], heights[:2]) == pytest.approx([drive.pitch_mm] * 2)
    places = {item.name: item.location.shift_mm for item in two.bill().items}
    for side in (1, 2):
        apart = np.subtract(places[f"terminal_side_{side}_2"], places[f"terminal_side_{side}_1"])
        assert apart == pytest.approx([0.0, drive.pitch_mm, 0.0], abs=1e-9)


def test_every_item_joins_once_and_each_cable_has_its_parts(two: SpurLayout) -> None:
    joined = [name for step in two.assembly_order for name in step.items]
    items = {item.name for item in two.bill().items}
    assert sorted(joined) == sorted(items)
    assert {"cable_main_1", "cable_main_2", "drum_1", "drum_2", "hub_dowel_1_1", "terminal_side_2_2"} <= items


def test_hubs_in_line_turn_by_the_torque_that_each_passes_on(two: SpurLayout) -> None:
    """The mean turn of the webs, hub after hub from the payload, each with the torque of those behind it."""
    causes, alone = (
        {c.name: c.urad_Nm for c in structure_of(one).causes} for one in (two, SpurLayout(two.drive.unit(0)))
    )
    hub = alone["drum: hub to the set screws"] + alone["drum: hub to the payload"]
    last = 1.0 * hub
    first = last + 0.5 * hub
    mean = 0.5 * (first + last)
    told = causes["drum: hub to the set screws"] + causes["drum: hub to the payload"]
    assert told == pytest.approx(mean, rel=1e-6), (told, mean)
    assert causes["drum: web and rim"] == pytest.approx(alone["drum: web and rim"] / 2, rel=0.05)


def test_the_rig_pairs_the_sides_of_each_cable(two: SpurLayout) -> None:
    wound = tuple(replace(cable, own_wrap_rad=1.0) for cable in cables_of(two.drive))
    assert pairs_of(wound).tolist() == [[0, 1], [2, 3]]


@pytest.mark.parametrize(
    ("line", "what"),
    [
        ("transmission: {input_to_drum: 9.0, parallel: 2, cables: two_anchored}", "end faces.*continuous"),
        ("drum: {output_screws: 6}", "output_screws"),
        ("configuration: miso_spur", "each input has one cable"),
        (REMOVED % "matched_lands_mm: 0.005", r":5: .*matched_lands_mm.*removed field.*remove it; checks count"),
        (REMOVED % "equaliser: rocker", r":5: .*equaliser.*removed field.*drum.spring under the nuts"),
        (REMOVED % "rocker_mm: 3.0", r":5: .*rocker_mm.*removed field.*remove it"),
        (REMOVED % "parallel_spread: 0.2", r":5: .*parallel_spread.*removed field.*worked out from nuts"),
        ("rope: {preload_by: knee}", r":6: .*preload_by.*removed field.*mbcdm preload"),
    ],
)
def test_what_parallel_cables_cannot_be_beside(line: str, what: str) -> None:
    keys = [one.split(":")[0] for one in line.splitlines()]
    kept = [one for one in TEXT.splitlines() if one.split(":")[0] not in keys]
    with pytest.raises(InputError, match=what):
        load_text("\n".join([*kept, line]) + "\n")


ANGLES_DEG = (-35.0, 0.0, 20.0, 35.0)


@pytest.fixture(scope="module")
def lay(anchored: SpurDrive) -> SpurLayout:
    return SpurLayout(anchored)


@settings(max_examples=40, deadline=None)
@given(
    ratio=st.floats(3.0, 9.9),
    distance=st.floats(68.0, 120.0),
    turns=st.integers(2, 6),
    lead=st.floats(0.85, 2.0),
    angle=st.floats(-35.0, 35.0),
    surface=st.sampled_from(("smooth", "grooved")),
)
def test_paths_keep_their_length_and_join_without_a_kink(
    anchored: SpurDrive, ratio: float, distance: float, turns: int, lead: float, angle: float, surface: str
) -> None:
    """What leaves the drum lands on the input, and one slope runs from the stop's bend to the terminal's plane."""
    cables = tuple(replace(c, input_radius_mm=c.drum_radius_mm / ratio) for c in anchored.cables)
    reach = cables[0].drum_radius_mm + cables[0].input_radius_mm
    changed = laid(
        replace(
            anchored,
            cables=cables,
            centre_distance_mm=max(distance, reach + 1.0),
            turns=turns,
            helix_lead_mm=lead,
            input_pulleys=replace(anchored.input_pulleys, surface=surface),
        )
    )
    anchors = {c.name: (changed.landing_rad + 1.0, 5.0) for c in cables}
    for centred, path in zip(*(cable_paths(changed, anchors, at) for at in (0.0, np.radians(angle))), strict=True):
        assert path.length_mm == pytest.approx(centred.length_mm, abs=1e-9)
        assert_joined(path)


def test_each_groove_lies_under_its_cable_and_ends_in_the_slot_of_its_stop(lay: SpurLayout) -> None:
    """In the pulley's own frame, at every angle; the end of the winding stays where the slot begins."""
    pulley = lay.inputs[0]
    assert [g.right_handed for g in pulley.grooves] == [True, True]
    for k, (groove, slot) in enumerate(zip(pulley.grooves, pulley.slots, strict=True)):
        assert groove.cable_name == slot.cable_name == lay.drive.cables[k].name
        sense = np.sign(groove.end_angle_rad - groove.start_angle_rad)
        for angle in ANGLES_DEG:
            place = next(i.location for i in bill(lay, angle).items if i.name == "input_pulley_main")
            path = lay.cable_paths(np.radians(angle))[k]
            own = place.inverse.apply(path.piece("wound").points(np.linspace(0.0, 1.0, 60)))
            assert np.hypot(own[:, 0], own[:, 1]) == pytest.approx(groove.root_radius + 0.405, abs=1e-9)
            at = groove.start_angle_rad + sense * np.abs(own[:, 2] - groove.start_z) / (groove.lead / (2 * pi))
            off = np.arctan2(own[:, 1], own[:, 0]) - at
            assert np.abs(np.angle(np.exp(1j * off))).max() < 1e-9, f"{groove.cable_name} at {angle}"
            assert max(abs(at - groove.start_angle_rad)) < abs(groove.end_angle_rad - groove.start_angle_rad)
            end = own[0]
            assert np.arctan2(end[1], end[0]) % tau == pytest.approx(slot.end_angle_rad % tau, abs=1e-9)
            assert end[2] == pytest.approx(slot.end_z, abs=1e-9)


def test_stop_lies_on_the_end_of_its_cable(lay: SpurLayout) -> None:
    """Both ends of each stop, as the bill places it, are points of the chord of its path."""
    items = {item.name: item for item in bill(lay, 20.0).items}
    for path, slot in zip(lay.cable_paths(radians(20.0)), lay.inputs[0].slots, strict=True):
        chord = path.piece("chord").points(np.array([0.0, 1.0]))
        stop = items[f"stop_{path.cable.name}"].location.apply(np.array([[0.0, 0.0, slot.stop_start - slot.stop_end]]))
        assert stop[0] == pytest.approx(chord[0], abs=1e-9), path.cable.name


def test_windings_stand_side_by_side_on_the_land(lay: SpurLayout) -> None:
    """Lowest and highest point of each cable on the input over the travel, against each other and the land's ends."""
    low, high = (
        np.concatenate(
            [lay.cable_paths(np.radians(a))[k].piece("wound").points(np.linspace(0, 1, 50))[:, 1] for a in ANGLES_DEG]
        )
        for k in (0, 1)
    )
    flank, pulley = 0.405, lay.inputs[0]
    assert low.max() + flank < high.min() - flank
    assert low.min() - flank > pulley.land_bottom_z + 0.5 and high.max() + flank < pulley.land_top_z - 0.5
    # A lead a turn over the travel: 0.9 x 9.9 x 70 / 360, on top of what is wound at the unwound end.
    turns = lay.drive.dead_turns + 9.9 * 70.0 / 360.0
    assert high.max() - high.min() == pytest.approx(0.9 * turns, abs=1e-9)


def test_turns_cover_travel_and_reserve(anchored: SpurDrive) -> None:
    """3 turns less 9.9 x 70 degrees: 1.075 stay on at the end of the travel that unwinds a cable."""
    assert anchored.dead_turns == pytest.approx(3.0 - 9.9 * 70.0 / 360.0)
    for c in anchored.cables:
        ends = [degrees(input_wrap_rad(anchored, c, c.drum_side * way * radians(35.0))) for way in (1, -1)]
        assert ends == pytest.approx([360.0 * anchored.dead_turns, 1080.0], abs=1e-9)


def test_routes_touch_both_pulleys_where_the_paths_do(lay: SpurLayout) -> None:
    """Points where the spans leave the input and land on the drum, heights along the axes included."""
    d = lay.si
    for route, path in zip(d.routes.cables, lay.cable_paths(0.0), strict=True):
        span = path.piece("span").points(np.array([0.0, 1.0])) * 1e-3
        direction = route.spans[0].direction
        touched = [contact_point_m(d.routes.body(wrap.body), wrap, direction) for wrap in route.wraps]
        assert np.array(touched) == pytest.approx(span, abs=1e-12), route.cable


def test_nothing_slips_on_the_input(anchored: SpurDrive, drive: SpurDrive) -> None:
    assert layout_of(anchored).si.through_wrap_rad is None and layout_of(drive).si.through_wrap_rad is not None
    causes = [{limit.cause for limit in analyse(layout_of(d)).limits} for d in (drive, anchored)]
    assert causes[0] - causes[1] == {"slip"} and causes[1] <= causes[0]
    assert not any(wrap.may_slip_through for route in layout_of(anchored).si.routes.cables for wrap in route.wraps)


def test_each_form_has_the_checks_of_what_holds_it(anchored: SpurDrive, drive: SpurDrive) -> None:
    one, two = ({check.id for check in checks_of(d)} for d in (drive, anchored))
    assert one - two == {"input_slip", "input_sticks", "land_spacing"}
    stops = {"stop_pocket_wall", "stop_pocket_floor", "stop_pocket_bore", "anchor_bend", "dead_turns"}
    assert two - one == stops | {"cables_apart"}


@settings(max_examples=20, deadline=None)
@given(load=st.floats(0.05, 3.0), way=st.sampled_from((1, -1)))
def test_turns_as_the_continuous_drive_while_its_wrap_sticks(
    anchored: SpurDrive, drive: SpurDrive, load: float, way: int
) -> None:
    """Where a part of the one cable sticks wholly, each side ends there: two anchored cables are the same springs."""
    one, two = (solve_equilibrium(layout_of(d).si, way * load) for d in (drive, anchored))
    assert float(two.drum_angle_rad) == pytest.approx(float(one.drum_angle_rad), rel=1e-9)
    # Sides are in the order of y, which is the other one where cables are wound outwards.
    assert two.tension_N == pytest.approx(one.tension_N[::-1], rel=1e-9)


def test_equilibrium_is_that_of_cables_summed_up_in_slices(anchored: SpurDrive) -> None:
    at = solve_equilibrium(layout_of(anchored).si, 2.15)
    angle, tensions = by_bisection(anchored, anchored.free_span_mm * 1e-3, 2.15)
    assert float(at.drum_angle_rad) == pytest.approx(angle, rel=1e-4)
    assert at.tension_N == pytest.approx(tensions, rel=1e-5)


@pytest.mark.parametrize(
    ("check", "change", "status"),
    [
        ("dead_turns", {"turns": 3}, "pass"),
        ("dead_turns", {"turns": 2}, "fail"),
        ("helix_lead", {"helix_lead_mm": 0.88}, "fail"),
        ("groove_crest", {"helix_lead_mm": 0.84}, "fail"),
        ("stop_pocket_bore", {}, "pass"),
        ("cables_apart", {}, "pass"),
        ("cables_apart", {"centre_distance_mm": 640.0}, "fail"),
    ],
)
def test_winding_against_its_limits(anchored: SpurDrive, check: str, change: dict[str, float], status: str) -> None:
    changed = laid(replace(anchored, **change))
    found = next(c for c in checks_of(changed) if c.id == check)
    result = run_check(found, SpurLayout(changed))
    assert result.status == status, result.message


def test_too_few_turns_are_told_how_many_it_takes(anchored: SpurDrive) -> None:
    few = laid(replace(anchored, turns=2))
    result = run_check(next(c for c in checks_of(few) if c.id == "dead_turns"), SpurLayout(few))
    assert "transmission.turns" in result.remedy and "3" in result.remedy, result.remedy


def test_every_item_joins_once_in_the_order_of_assembly(lay: SpurLayout) -> None:
    joined = [name for step in lay.assembly_order for name in step.items]
    assert sorted(joined) == sorted(item.name for item in bill(lay).items)
    assert {"stop_side_1", "stop_side_2", "cable_side_1", "cable_side_2"} <= set(joined)


def test_cut_lengths_are_those_of_the_paths_with_their_stops(lay: SpurLayout) -> None:
    """Each cable is cut as long as its centre line, shorter by its stretch and bedding-in."""
    for setting, path in zip(plan(lay).cables, lay.cable_paths(0.0), strict=True):
        assert 0.97 < setting.cut_length_m * 1e3 / path.length_mm < 1.0, (setting.name, setting.cut_length_m)


def test_necks_stay_clear_of_the_stops(lay: SpurLayout) -> None:
    pulley = lay.inputs[0]
    for slot in pulley.slots:
        clear = slot.bend_radius - slot.stop_radius - max(pulley.lower_neck_radius, pulley.upper_neck_radius)
        assert clear > 0.09, f"{slot.cable_name}: {clear} mm"
    assert pulley.lower_journal_radius - CHAMFER_MM > pulley.bore_radius
