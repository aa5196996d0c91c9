"""The chain alone: equilibrium, memory, conservation of rope under transport, slack.

Marks on the rig's rope, counted where they pass from a body to a span and back, against the zones of the life.
"""

import importlib.util
import sys
from collections import Counter
from dataclasses import replace
from math import log

import numpy as np
import pytest

from mbcdm_cad.layouts.life import ropes_in_use
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.layouts.turns import turns_of
from mbcdm_cad.model.analysis import reversal_swing_mrad
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.model.rope_zones import Level, RopeLife, rope_life
from mbcdm_cad.model.stiffness import drum_backlash
from mbcdm_cad.rig import chain
from mbcdm_cad.rig.bench import RigCable, bench_of, cables_of
from mbcdm_cad.rig.experiment import Physics
from tests.support.reference import PARAMS


@pytest.fixture(scope="module")
def cables(project):
    return cables_of(load_design(project / "params" / "mbcdm.yaml").drive)


def first_loading(c, tension):
    """Integral of the exponential profile, worked out by hand: span, then a wrap that slips until T_pre holds."""
    reach = (c.input_radius_m + c.drum_radius_m) / c.friction
    slip = abs(tension - c.preload_N - c.preload_N * log(tension / c.preload_N))
    sign = 1.0 if tension > c.preload_N else -1.0
    return ((tension - c.preload_N) * c.free_span_m + sign * reach * slip) / c.stiffness_N


@pytest.mark.parametrize("to_N", [75.0, 64.0, 100.0])
def test_first_loading_is_the_integral_of_the_capstan_profile(cables, to_N):
    state = chain.chains(cables, transport=False, piece_rad=0.005)
    delta = first_loading(cables[0], to_N)
    found = chain.advance(state, 0, 0.0, 0.0, delta)
    assert found == pytest.approx(to_N, abs=1e-3 * abs(to_N - 70.0)), f"{found} N"


def test_reversal_is_twice_as_wide_as_first_loading(cables):
    state = chain.chains(cables, transport=False, piece_rad=0.005)
    delta = first_loading(cables[0], 74.0)
    chain.advance(state, 0, 0.0, 0.0, delta)
    back = chain.advance(state, 0, 0.0, 0.0, -delta)
    assert back == pytest.approx(66.0, abs=0.15), f"{back} N"
    again = chain.advance(state, 0, 0.0, 0.0, delta)
    assert again == pytest.approx(74.0, abs=0.02), f"the loop closes at {again} N"


def test_look_changes_nothing_and_its_slope_is_right(cables):
    state = chain.chains(cables, transport=False)
    before = [array.copy() for array in state]
    tension, slope = chain.look(state, 1, 2e-5)
    assert all(np.array_equal(a, b) for a, b in zip(before, state, strict=True))
    step = 1e-9
    found = (chain.look(state, 1, 2e-5 + step)[0] - chain.look(state, 1, 2e-5 - step)[0]) / (2 * step)
    assert slope == pytest.approx(found, rel=1e-4)
    assert slope < cables[1].stiffness_N / cables[1].free_span_m
    assert tension > 70.0


@pytest.mark.parametrize("passed_slip", [False, True])
def test_running_sum_is_the_sum_of_the_pieces_after_long_travel(cables, passed_slip):
    state = chain.chains(cables, passed_slip=passed_slip)
    for k in range(4000):
        drum = 0.5 * np.sin(k * 0.01)
        chain.advance(state, 2, 9.0 * drum, drum, 3e-5 * np.sin(k * 0.037))
    for w in range(3):
        wrap, pieces = state.wraps[2, w], state.pieces[2, w]
        total = 0.0
        for k in range(int(np.floor(wrap[chain.LOW] / 0.02)), int(np.ceil(wrap[chain.HIGH] / 0.02))):
            extent = min((k + 1) * 0.02, wrap[chain.HIGH]) - max(k * 0.02, wrap[chain.LOW])
            total += extent * (pieces[k % pieces.size] - 70.0)
        assert wrap[chain.SUM] == pytest.approx(total, abs=1e-9), w


def test_rope_wound_on_under_load_comes_back_with_its_tension(cables):
    state = chain.chains(cables)
    for k in range(200):  # load first, then wind on to the input under a stretch held fixed
        chain.advance(state, 1, 0.0, 0.0, 4e-5 * k / 199)
    loaded = state.tension[1]
    for k in range(500):
        drum = 0.3 * k / 499
        chain.advance(state, 1, 9.0 * drum, drum, 4e-5)
    wrap = state.wraps[1, chain.INPUT]
    top = int(wrap[chain.HIGH] / 0.02) - 40
    assert state.pieces[1, chain.INPUT, top] > 71.0, "rope laid on under load holds more than the preload"
    assert state.tension[1] < loaded, "the drum's rope comes off at preload, so that the tension sinks"


def test_without_friction_the_whole_rope_shares_the_stretch(cables):
    from dataclasses import replace

    c = replace(cables[0], friction=0.0)
    state = chain.chains((c,), transport=False)
    length = c.free_span_m + c.input_radius_m * 16.0 + c.drum_radius_m * 3.0
    tension = chain.advance(state, 0, 0.0, 0.0, 1e-4)
    assert tension == pytest.approx(70.0 + c.stiffness_N * 1e-4 / length, rel=1e-12)


def test_a_rope_cannot_push(cables):
    state = chain.chains(cables, transport=False)
    assert chain.advance(state, 0, 0.0, 0.0, -5e-3) == 0.0
    assert chain.advance(state, 0, 0.0, 0.0, 0.0) > 0.0
    assert state.pieces[0].min() >= 0.0


def test_strain_of_the_stuck_rope_slackens_it_uniformly(cables):
    state = chain.chains(cables, transport=False)
    c = cables[0]
    chain.strain(state, 0, np.full(3, 1e-4))
    tension = chain.advance(state, 0, 0.0, 0.0, -1e-4 * c.free_span_m)
    assert tension == pytest.approx(70.0 - c.stiffness_N * 1e-4, rel=1e-12)


def test_a_travel_that_empties_a_wrap_is_refused(cables):
    with pytest.raises(ValueError, match="winds off"):
        chain.chains(cables, reach_rad=2.0)


MARK_M, STEPS = 0.2e-3, 201
# By hand, in a cycle over the whole travel: what winds on and off bends once, what passes the guide and returns twice.
BY_HAND = {
    "mbcdm": {"input": 1.0, "guide": 2.0, "drum": 1.0},
    "siso_spur": {"input": 1.0, "drum": 1.0},
    "miso_spur": {"input": 1.0, "drum": 1.0},
    "siso_bevel": {"input": 1.0, "drum": 1.0},
}


def rig_of(name: str) -> tuple[tuple[RigCable, ...], float, RopeLife]:
    """The rig's cables of the first rope of a reference, half its travel, and the life's zones of that rope."""
    drive = load_design(PARAMS / f"{name}.yaml").drive
    layout = layout_of(drive)
    half, si = layout.half_travel_rad, layout.loads.si
    rope = next(iter(ropes_in_use(layout, si)))
    # Without directions bends of opposite sense count as any other.
    plain = replace(rope, tangents=tuple(replace(t, normal=(0.0, 0.0, 0.0)) for t in rope.tangents))
    tension = np.full((si.n_cables, 2), 50.0)
    life = rope_life(plain, [Level(np.array([-half, half]), tension, tension)])
    sides = {t.cable for t in rope.tangents}
    return tuple(c for j, c in enumerate(cables_of(drive)) if j in sides), half, life


def counted(cables: tuple[RigCable, ...], half_rad: float) -> tuple[Counter[float], dict[str, float]]:
    """Length in mm by bendings in a cycle, and the most bendings on each kind of body."""
    state = chain.chains(cables, passed_slip=True, reach_rad=half_rad, input_wrap_rad=12.0, drum_wrap_rad=2.5)
    lengths: Counter[float] = Counter()
    most: dict[str, float] = {}
    way = np.linspace(-half_rad, half_rad, STEPS)
    for j, c in enumerate(cables):
        spans = [span.length_m for span in c.route.spans]
        first = c.input_radius_m * 12.0
        marks = np.arange(first - 0.2, first + 0.4, MARK_M)
        before: np.ndarray | None = None
        halves = {k: np.zeros(marks.size) for k in range(len(spans) + 1)}
        for drum in np.concatenate([way, way[-2::-1]]):
            chain.carry(state, j, float(drum * c.drum_radius_m / c.input_radius_m), float(drum))
            wraps = state.wraps[j, :, chain.HIGH] - state.wraps[j, :, chain.LOW]
            ends = [c.input_radius_m * wraps[0]]
            for k, span in enumerate(spans, start=1):
                ends.append(ends[-1] + span)
                if k < len(spans):
                    ends.append(ends[-1] + wraps[k] * state.wraps[j, k, chain.RADIUS])
            # Even places are bodies: the input, those passed, the drum.
            now = np.searchsorted(np.array(ends), marks)
            if before is not None:
                for k in halves:
                    halves[k] += (now == 2 * k) != (before == 2 * k)
            before = now
        each = sum(halves.values()) / 2.0
        for number in np.unique(each[each > 0.0]):
            lengths[float(number)] += 1e3 * MARK_M * float(np.sum(each == number))
        kinds = ["input", *(["guide"] * (len(spans) - 1)), "drum"]
        for k, kind in enumerate(kinds):
            most[kind] = max(most.get(kind, 0.0), float(halves[k].max()) / 2.0)
    return lengths, most


@pytest.mark.parametrize("name", BY_HAND)
def test_marks_on_the_rigs_rope_bend_as_the_zones_say(name: str) -> None:
    cables, half, life = rig_of(name)
    seen, most = counted(cables, half)
    found: Counter[float] = Counter()
    by_body: dict[str, float] = {}
    for zone in life.zones:
        found[round(sum(zone.bendings.values()), 6)] += 1e3 * (zone.end_m - zone.start_m)
        for body, count in zone.bendings.items():
            kind = body.split(" ")[-1]
            by_body[kind] = max(by_body.get(kind, 0.0), count)
    assert by_body == most == BY_HAND[name]
    assert set(found) == set(seen), (found, seen)
    for count, length_mm in found.items():
        # Steps of the travel and the distance of the marks.
        assert seen[count] == pytest.approx(length_mm, abs=2.5), (count, found, seen)


# The rig compared with the analytic model. Only this file imports both.


@pytest.fixture(scope="module")
def comparison(project):
    spec = importlib.util.spec_from_file_location("rig_against_model", project / "benchmarks" / "rig_against_model.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    yield module
    del sys.modules[spec.name]


@pytest.fixture(scope="module")
def drive(comparison, project):
    return comparison.stiff_rope(load_design(project / "params" / "mbcdm.yaml").drive)


def test_they_agree_where_the_model_s_assumptions_hold(comparison, drive):
    rows = comparison.agreement(drive) + comparison.winding(drive)
    assert len(rows) == 9
    for row in rows:
        assert abs(row.difference) <= row.tolerance, row


def test_the_figures_are_those_known_from_elsewhere(comparison, drive):
    """Backlash, swing and drive limits checked by hand-made discretisations before this code was written."""
    rows = {row.name: row.rig for row in comparison.agreement(drive)}
    known = [145.95, 291.9, None, None, 3.747, 3.194]
    for (name, found), expected in zip(rows.items(), known, strict=True):
        assert expected is None or found == pytest.approx(expected, rel=1e-3), name


def test_they_part_by_as_much_as_is_known(comparison, drive):
    short, long, guide = comparison.parting(drive)
    assert short.rig == pytest.approx(167.3, abs=0.3), short
    assert long.rig == pytest.approx(396.0, abs=1.0), long
    assert guide.difference == pytest.approx(0.08, abs=0.005), guide
    soft = comparison.winding(drive)[2]
    assert soft.rig == pytest.approx(163.9, abs=1.0), soft


def test_finer_pieces_come_nearer(comparison, drive):
    errors = [abs(comparison.agreement(drive, piece)[0].difference) for piece in (0.08, 0.02, 0.005)]
    assert errors[0] > 4 * errors[1] > 4 * errors[2], errors


def test_they_agree_on_one_cable_that_friction_holds_on_its_input(comparison, project):
    """Plain capstan drive, each side a cable from the middle of the input: first loading, and the swing back."""
    plain = comparison.stiff_rope(load_design(project / "params" / "siso_spur.yaml").drive)
    load = np.concatenate([np.linspace(0.0, 2.15, 200), np.linspace(2.15, -2.15, 400)])
    found, _ = comparison.held(plain, load, piece_rad=0.02)
    d = layout_of(plain).si
    assert found[199] == pytest.approx(float(solve_equilibrium(d, 2.15).drum_angle_rad), rel=1e-3)
    model = simulate(d, np.zeros((1, load.size)), load).drum_angle_rad
    assert found[-1] - found[199] == pytest.approx(model[-1] - model[199], rel=1e-3)


def test_slip_on_the_guide_is_one_choice_of_the_design(comparison, drive):
    """Declared as counted, model, time series and rig turn alike; without it they agree on the smaller turn."""
    counted = replace(drive, guide_slips=True)
    load = np.concatenate([np.linspace(0.0, 0.91, 200), np.linspace(0.91, -0.91, 400)])
    turns = {}
    for name, one in (("none", drive), ("counted", counted)):
        d = layout_of(one).si
        slips = layout_of(one).slips_on_passed
        found, _ = comparison.held(one, load, piece_rad=0.01, passed_slip=slips)
        assert found[199] == pytest.approx(float(solve_equilibrium(d, 0.91).drum_angle_rad), rel=2e-3)
        swing = float(drum_backlash(d, 0.91).reversal_swing_rad)
        assert abs(found[-1] - found[199]) == pytest.approx(swing, rel=2e-3)
        model = simulate(d, np.zeros((2, load.size)), load).drum_angle_rad
        assert abs(model[-1] - model[199]) == pytest.approx(swing, rel=1e-6)
        assert turns_of(layout_of(one)).cables.swing_mrad == pytest.approx(swing * 1e3, rel=1e-9)
        assert reversal_swing_mrad(layout_of(one)) == pytest.approx(swing * 1e3, rel=1e-9)
        turns[name] = swing
    assert turns["counted"] / turns["none"] - 1.0 == pytest.approx(0.08, abs=0.01), turns
    physics = Physics()
    for one, slips in ((drive, False), (counted, True)):
        bench = bench_of(one, np.arange(3.0), np.zeros(3), np.zeros((2, 3)), np.random.default_rng(1), physics)
        assert bench.passed_slip is slips and not bench.unseen_slip
