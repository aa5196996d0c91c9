"""Cables in parallel: each is the plain drive's with its share; unequal preloads, hubs in line, as drawn, messages."""

from __future__ import annotations

from dataclasses import replace
from math import degrees, radians

import cadquery as cq
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.checks.cable_gaps import CABLE_GAP_MM, in_pieces, nearest_mm
from mbcdm_cad.checks.run import run_all, run_check
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.life import ropes_in_use
from mbcdm_cad.layouts.loader import load_text
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive, laid
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.model.capability import torque_at_slip_Nm
from mbcdm_cad.model.equilibrium import bearing_loads, solve_equilibrium
from mbcdm_cad.model.si import to_si
from mbcdm_cad.model.stiffness import sticking_stiffness_Nm_rad
from mbcdm_cad.parts.making import land_band_mm
from mbcdm_cad.parts.part import MadePart, StandardPart
from mbcdm_cad.rig.cables import cables_of
from mbcdm_cad.rig.through import pairs_of
from mbcdm_cad.storage.compiled import compiled
from mbcdm_cad.workshop.kernel import location
from tests.support.sliced_cables import stretch_m

TEXT = """name: parallel
configuration: siso_spur
travel: {half_angle_deg: 35.0}
transmission: {input_to_drum: 9.0, parallel: 2}
loads: {peak_torque_Nm: 4.0}
"""
ROCKER = "transmission: {input_to_drum: 9.0, parallel: 2, equaliser: rocker}"


def beside(drive: SpurDrive, count: int, spread: float = 0.0) -> SpurDrive:
    """``drive`` with ``count`` of its cable side by side."""
    cables = tuple(replace(c, name=f"{c.name}_{k + 1}") for k in range(count) for c in drive.cables)
    sigmas = drive.sigmas.of_cables([0, 1] * count)
    return laid(replace(drive, parallel=count, parallel_spread=spread, cables=cables, sigmas=sigmas))


@pytest.fixture(scope="module")
def two() -> SpurLayout:
    """Two cables as the rules give them."""
    layout = load_text(TEXT).drive.layout
    assert isinstance(layout, SpurLayout)
    return layout


@settings(max_examples=20, deadline=None)
@given(count=st.integers(2, 4), load=st.floats(-2.0, 2.0))
def test_each_cable_is_the_plain_drive_s_with_its_share(drive: SpurDrive, count: int, load: float) -> None:
    """n cables under n M turn as far as one under M, at its tensions; stiffness and torque at slip are n times its."""
    one, all_ = to_si(drive), to_si(beside(drive, count))
    alone, together = solve_equilibrium(one, load), solve_equilibrium(all_, count * load)
    assert float(together.drum_angle_rad) == pytest.approx(float(alone.drum_angle_rad), rel=1e-9, abs=1e-15)
    assert together.tension_N.reshape(count, 2) == pytest.approx(np.tile(alone.tension_N, (count, 1)), rel=1e-9)
    assert float(sticking_stiffness_Nm_rad(all_)) == pytest.approx(count * float(sticking_stiffness_Nm_rad(one)))
    assert torque_at_slip_Nm(all_, 1) == pytest.approx([count * float(torque_at_slip_Nm(one, 1)[0])] * count)
    own, its = bearing_loads(one, alone.tension_N).inputs[0], bearing_loads(all_, together.tension_N).inputs[0]
    assert its.force_N == pytest.approx(count * own.force_N, rel=1e-9)


def test_unequal_preloads_load_one_cable_more_and_another_slips_first(drive: SpurDrive) -> None:
    """Checks see the spread. When the loosest slips, wraps summed up in slices stretch alike, as one drum turns all."""
    spread, three = 0.2, beside(drive, 3, 0.2)
    layout, equal = SpurLayout(three), SpurLayout(beside(drive, 3))
    si, preload = layout.loads.si, drive.cables[0].preload_N
    assert si.preload_N == pytest.approx(preload * np.repeat([1 + spread, 1.0, 1 - spread], 2))
    assert to_si(three).preload_N == pytest.approx([preload] * 6)
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
    assert two.by_lands == pytest.approx(SpurLayout(replace(two.drive, matched_lands_mm=_band_mm(two))).by_lands)
    assert told.actual == pytest.approx(float(np.hypot(two.by_nut, two.by_lands)))
    # Left out, the spread is what nuts, lands and the pitch of a span leave, without a warning; a smaller one warns.
    assert told.actual < two.preload_spread < 0.5 and told.status == "pass", told
    tight = SpurLayout(replace(two.drive, parallel_spread=0.9 * told.actual))
    assert run_check(check, tight).status == "warn"
    # Where nothing slips the span takes all that the drum winds on too much.
    drive = replace(two.drive, matched_lands_mm=0.002, friction_coefficient=1e6)
    off = float(np.hypot(0.0005 / cable.drum_radius_mm, 0.0005 / cable.input_radius_mm))
    way = off * cable.drum_radius_mm * two.half_travel_rad / drive.strand_mm
    matched = SpurLayout(drive)
    assert matched.by_lands == pytest.approx(rope * way / preload, rel=1e-4)
    assert "within 0.002 mm" in str(run_check(check, matched))
    assert any("in the order in which their lands were cut" in step.text for step in matched.assembly_order)
    for name in ("drum", "input_pulley_main"):
        notes = matched.bill().made[name].sheet(name).notes
        assert any("within 0.002 of each other" in note for note in notes), name
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
def _settle(rope: np.ndarray, at: int, span: float, drum: float, pulley: float, rocker: float) -> None:
    """Let nodes of both cables slip until friction holds them all.

    A ``rocker`` lets the ends on the drum pull unequally by no more than so much of their mean; below 0 there is none.
    """
    moved = 1.0
    while moved > 1e-6:
        moved = 0.0
        if rocker >= 0.0:
            half, held = (rope[0, 0] - rope[1, 0]) / 2, rocker * (rope[0, 0] + rope[1, 0]) / 2
            half = max(half - held, 0.0) + min(half + held, 0.0)
            moved = abs(half)
            rope[0, 0] -= half
            rope[1, 0] += half
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
def _half_range(
    cells: tuple[int, int, float], drum: float, pulley: float, e: float, off: float, load: float, rocker: float
) -> float:
    """Half of what the tensions of two spans differ by, over their mean, at most in the last cycle of the drum.

    One side of two cables in cells of rope; ``cells``: of the travel, of the wrap that is always on the drum, and of
    the span; ``drum``, ``pulley``: mu times the angle of a cell there. In a step a cell of each goes over with its
    tension, and the drum pulls ``e`` (tension of a cell, of the preload) more of one and less of the other than the
    input pays out; then a load stretches both spans by ``load`` and, reversed, as much the other way. Preloads begin
    ``off`` up and down. The far ends, on the input, stick.
    """
    travel, least, span = cells
    sides = np.array([1.0, -1.0])
    rope = np.ones((2, least + travel + 41))
    rope[0] += off
    rope[1] -= off
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
                _settle(rope, at, span, drum, pulley, rocker)
        if step >= 2 * travel * (CYCLES - 1):
            largest = max(largest, abs(rope[0, at] - rope[1, at]) / (rope[0, at] + rope[1, at]))
    return largest


def _simulated(lay: SpurLayout, off_mm: float, off: float = 0.0, load: float = 0.0, rocker: float = -1.0) -> float:
    """The same of a drive whose lands differ by ``off_mm`` in diameter; ``load``: what it changes of a preload."""
    drive, cable = lay.drive, lay.drive.cables[0]
    radii, step, mu = (cable.drum_radius_mm, cable.input_radius_mm), radians(STEP_DEG), lay.drive.friction_coefficient
    cell, wrap_deg = cable.drum_radius_mm * step, degrees(lay.units[0].anchor_rad(lay.units[0].drive.cables[0]))
    least = max(round((wrap_deg - drive.half_travel_deg) / STEP_DEG), 1)
    cells = (round(2 * drive.half_travel_deg / STEP_DEG), least, drive.strand_mm / cell)
    e = float(np.hypot(*(off_mm / 4.0 / r for r in radii))) * drive.cable.axial_stiffness_N / cable.preload_N
    pull = (load * drive.strand_mm + sum(radii) * load**2 / (2.0 * mu)) / cell
    return float(_half_range(cells, mu * step, mu * step * radii[0] / radii[1], e, off, pull, rocker))


@pytest.mark.slow
def test_lands_off_wind_the_cables_against_each_other_and_a_rocker_helps_only_under_load(two: SpurLayout) -> None:
    """Rope in cells with friction at each: the law of the spread, with slip on most of the wrap and on little of it.

    A rocker at both ends on the drum sees lands and nuts only where a load carries slip through the wrap to it.
    """
    slow = load_text(TEXT.replace("9.0,", "3.0, drum_radius_mm: 60.0,")).drive.layout
    assert isinstance(slow, SpurLayout)
    for lay in (two, slow):
        for off_mm in (_band_mm(lay), 0.2 * _band_mm(lay)):
            law = SpurLayout(replace(lay.drive, matched_lands_mm=off_mm)).by_lands
            assert 0.75 < _simulated(lay, off_mm) / law < 1.3, (off_mm, law)
    lands, nut, cable = _band_mm(two), two.by_nut, two.drive.cables[0]
    peak = two.drive.loads.peak_torque_Nm * 1e3 / (4.0 * cable.drum_radius_mm) / cable.preload_N
    assert _simulated(two, lands, rocker=0.0) > 0.85 * _simulated(two, lands)
    assert 0.9 * nut < _simulated(two, 0.0, nut, rocker=0.0) < nut
    assert _simulated(two, lands, load=peak) < 0.7 * _simulated(two, lands)
    assert _simulated(two, lands, load=peak, rocker=0.0) < 0.03
    assert 0.04 < _simulated(two, lands, load=peak, rocker=0.05) < 0.08
    # How much remains by the law, at loads whose slip reaches the end in no, a part and all of the travel.
    cases = ((two, lands, (0.1, 0.2, 0.3)), (two, 0.2 * lands, (0.05, 0.15)), (slow, _band_mm(slow), (0.1,)))
    for lay, off_mm, loads in cases:
        matched = SpurLayout(replace(lay.drive, matched_lands_mm=off_mm))
        for share in loads:
            torque = share * 4e-3 * lay.drive.drum_radius_mm * lay.drive.cables[0].preload_N
            law = (matched.spread_under(torque) ** 2 - matched.by_setting**2) ** 0.5
            remains = _simulated(lay, off_mm, load=share, rocker=0.0)
            assert 0.45 * law < remains < 1.15 * law + 0.03, (off_mm, share, law, remains)


@pytest.fixture(scope="module")
def equalised() -> SpurLayout:
    """The same with rockers."""
    layout = load_text(TEXT.replace("parallel: 2", "parallel: 2, equaliser: rocker")).drive.layout
    assert isinstance(layout, SpurLayout)
    return layout


def test_a_rocker_replaces_the_nut_in_the_spread(two: SpurLayout, equalised: SpurLayout) -> None:
    found = {r.id: r for r in run_all(checks_of(equalised.drive), equalised)}
    assert not [name for name, r in found.items() if r.status == "fail"]
    bars, drive = equalised.drive.equaliser, equalised.drive
    assert bars is not None and bars.arm == pytest.approx(drive.pitch_mm / 2)
    # Balance of a rocker whose dowel holds by friction, its arms as unequal as the sheet allows, tipped by the way.
    friction, tipped = 0.15 * bars.dowel_radius, bars.crown_radius * equalised.rocker_way_mm / drive.pitch_mm
    arms = [bars.arm + sign * (0.05 + tipped) for sign in (1, -1)]
    low = (arms[1] - friction) / (arms[0] + friction)
    assert equalised.by_setting == pytest.approx((1 - low) / (1 + low), rel=1e-6)
    assert equalised.by_setting < two.by_nut < equalised.preload_spread < two.preload_spread
    # The peak torque reaches the rockers at every angle, a small one at none.
    assert equalised.spread_under(drive.loads.peak_torque_Nm) == pytest.approx(equalised.by_setting)
    assert equalised.spread_under(0.01) == pytest.approx(equalised.preload_spread)
    assert found["equaliser_way"].actual > 2 * found["equaliser_way"].limit
    assert found["equaliser_bars"].actual == pytest.approx(355 / bars.bending_MPa(equalised.loads.highest_N))
    # Both bars are a part of the give of the ends, as in a spring.
    assert to_si(drive).anchor_m_N == pytest.approx(1e-3 * bars.give_mm_N(210e3))
    causes = {c.name: c.urad_Nm for c in equalised.structure.causes}
    assert 0.0 < causes["equaliser of the terminals"] < 0.05 * equalised.loads.test_urad_Nm


def test_a_rocker_as_drawn_lies_between_lugs_and_nuts(equalised: SpurLayout) -> None:
    bill, bars = equalised.bill(), equalised.drive.equaliser
    assert bars is not None
    items = {item.name: item for item in bill.items}
    joined = [name for step in equalised.assembly_order for name in step.items]
    assert sorted(joined) == sorted(items)
    solids = {}
    for n, side in ((1, "side_1"), (2, "side_2")):
        for what in ("bridge", "dowel", "rocker"):
            item = items[f"equaliser_{what}_{n}"]
            part = bill.parts[item.part].part
            solid = part.solid()
            assert isinstance(part, MadePart | StandardPart)
            assert part.volume_mm3() == pytest.approx(solid.Volume(), rel=0.01), what
            solids[what, n] = solid.moved(cq.Location(location(item.location)))
        studs = [items[f"terminal_{side}_{k}"].location.shift_mm for k in (1, 2)]
        middle = np.mean([solids[what, n].Center().toTuple() for what in ("bridge", "rocker")], axis=0)
        assert middle[1] == pytest.approx(np.mean(studs, axis=0)[1], abs=1e-4)
        # From the lug to the nut, whose faces the bars touch.
        nut, lug = (
            np.array(items[f"nut_{side}_1_1"].location.shift_mm),
            items[f"equaliser_bridge_{n}"].location.shift_mm,
        )
        assert np.linalg.norm((nut - lug)[[0, 2]]) == pytest.approx(bars.height)
        assert solids["bridge", n].distance(solids["rocker", n]) == pytest.approx(bars.gap, abs=1e-6)
        for one, other in (("bridge", "rocker"), ("bridge", "dowel"), ("rocker", "dowel")):
            assert solids[one, n].intersect(solids[other, n]).Volume() < 1e-6, (one, other)


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
    heights = [route.wraps[-1].height_m * 1e3 for route in to_si(drive).routes.cables]
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
    causes, alone = ({c.name: c.urad_Nm for c in one.structure.causes} for one in (two, SpurLayout(two.drive.unit(0))))
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
        ("transmission: {input_to_drum: 9.0, matched_lands_mm: 0.005}", "no lands to be matched"),
        ("transmission: {input_to_drum: 9.0, equaliser: rocker}", "two arms, not 1"),
        ("transmission: {input_to_drum: 9.0, parallel: 3, equaliser: rocker}", "set transmission.parallel to 2"),
        ("transmission: {input_to_drum: 9.0, parallel: 2, rocker_mm: 3.0}", "no equaliser is stated"),
        (f"{ROCKER}\ndrum: {{spring: disc-6x3.2x0.3}}", "drum.spring"),
        (f"{ROCKER}\ntravel: {{half_angle_deg: 150.0}}", "a whole drum"),
    ],
)
def test_what_parallel_cables_cannot_be_beside(line: str, what: str) -> None:
    keys = [one.split(":")[0] for one in line.splitlines()]
    kept = [one for one in TEXT.splitlines() if one.split(":")[0] not in keys]
    with pytest.raises(InputError, match=what):
        load_text("\n".join([*kept, line]) + "\n")
