"""Long runs are cut so that the model remembers what it would have remembered of the whole."""

from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.loop.prepare.prepared import prepare
from mbcdm_cad.loop.prepare.samples import SEARCH_SAMPLES, Cut, search_cut, whole_cut
from mbcdm_cad.loop.search.fit import Fitter
from mbcdm_cad.measurement.run import Run, Sensors, half_sweeps

D = layout_of(load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive).si
RATIO = float(np.mean(D.total_ratio))
STEP_S = 0.01


def triangle(periods: int, period: int) -> np.ndarray:
    t = np.arange(periods * period) / period
    return np.asarray(0.45 * 2.0 / np.pi * np.arcsin(np.sin(2.0 * np.pi * t)))


def test_half_sweeps_begin_where_the_output_turns() -> None:
    period, rng = 800, np.random.default_rng(1)
    output = triangle(30, period) + rng.normal(0.0, 1e-3, 30 * period)
    sweep = half_sweeps(output)
    turns = np.flatnonzero(np.diff(sweep)) + 1
    true = period / 4 + period / 2 * np.arange(60)
    off = np.abs(turns - true[: turns.size])
    assert turns.size == 60, turns
    assert off.max() <= 8, off


@pytest.mark.parametrize("half_sweep", [40, 400, 4000])
@pytest.mark.parametrize("samples", [30_000, 300_000, 1_000_000])
def test_cuts_cover_the_run_in_order_and_keep_whole_half_sweeps(half_sweep: int, samples: int) -> None:
    sweep = np.arange(samples) // half_sweep
    load = np.cos(np.arange(samples) * 0.37)

    def check(cut: Cut, most: int) -> None:
        dense = cut.index[~cut.lead]
        figures = (
            f"{cut.index.size} samples, {cut.lead.sum()} of them lead in, stride {cut.stride}, starts {cut.starts}"
        )
        assert (np.diff(cut.index) > 0).all(), figures
        assert dense.size <= 1.3 * most, figures
        assert dense[0] == 0, figures
        assert dense[-1] >= samples - 2 * half_sweep - cut.stride, figures
        judged = cut.index[~cut.unknown]
        assert np.unique(sweep[judged]).size >= 0.6 * np.unique(sweep[dense]).size, figures
        for start in cut.starts[1:]:
            assert cut.index[start] % half_sweep == 0, f"a stretch begins where the drive does not turn: {figures}"

    part = search_cut(sweep, load)
    assert part is not None
    check(part, SEARCH_SAMPLES)
    check(whole_cut(sweep, load, STEP_S), 250_000)


@pytest.mark.parametrize("lowest", range(3, 57, 6))
def test_the_extremes_of_the_load_are_searched(lowest: int) -> None:
    """The lowest load occurs in one half sweep of sixty, the highest in another."""
    sweep = np.arange(60_000) // 1000
    highest = (lowest + 20) % 54 + 3
    load = np.where(sweep == lowest, -1.0, np.where(sweep == highest, 0.9, 0.1 * np.cos(sweep)))
    cut = search_cut(sweep, load)
    assert cut is not None
    judged = set(sweep[cut.index[~cut.unknown]].tolist())
    assert {lowest, highest} <= judged, f"half sweeps {lowest} and {highest} are wanted, {sorted(judged)} are searched"


def test_short_runs_are_not_cut() -> None:
    sweep = np.arange(16_000) // 500
    assert search_cut(sweep, None) is None
    cut = whole_cut(sweep, None, STEP_S)
    assert np.array_equal(cut.index, np.arange(16_000))
    assert not cut.unknown.any()


def test_stretches_remember_what_the_whole_remembers() -> None:
    """Loads change sign from sweep to sweep: a stretch that began from nothing would be tens of microradians off."""
    period = 1600
    output = triangle(60, period)
    n = output.size
    half = np.maximum(0, half_sweeps(output) - 1)
    load = np.array([1.2, 0.3, 1.2, 0.3, -0.3, -1.2, -0.3, -1.2])[half % 8]
    kernel = np.full(21, 1.0 / 21.0)
    load = np.asarray(np.convolve(np.pad(load, 10, mode="edge"), kernel, mode="valid"))
    inputs = RATIO * np.stack([output, output])
    time_s = np.arange(n, dtype=float) * STEP_S
    run = Run(time_s, inputs, output, load, sensors=Sensors(1e-4, 1e-6))
    part, whole = prepare(run, RATIO)
    assert part.cut.starts.size == 4
    at_all = Fitter(D, RATIO, [whole]).predict((), (), np.zeros(1))
    at_part = Fitter(D, RATIO, [part]).predict((), (), np.zeros(1))
    everywhere = np.interp(part.cut.index, whole.cut.index, at_all)
    off = 1e6 * np.abs(at_part - everywhere)
    # On the load's flanks, where the drive turns, the two interpolate between other samples.
    level = part.used & (np.abs(part.cut.index % (period // 2) - period // 4) > 30)
    typical, worst = float(np.sqrt(np.mean(off[part.used] ** 2))), float(off[level].max())
    assert typical < 0.3, typical
    assert worst < 1.0, worst


@pytest.mark.parametrize("seed", range(6))
def test_the_searched_part_holds_back_its_own_share_of_loads_and_directions(seed: int) -> None:
    """Each half sweep has a load of its own, in no rhythm; the search sees a part of them."""
    rng = np.random.default_rng(seed)
    output = triangle(30, 1600)
    sweep = np.maximum(0, half_sweeps(output) - 1)
    load = rng.uniform(-1.0, 1.0, 64)[sweep]
    time_s = np.arange(output.size) * STEP_S
    part, whole = prepare(Run(time_s, RATIO * np.stack([output, output]), output, load), RATIO)
    assert part is not whole
    for one in (part, whole):
        share = one.test.sum() / one.used.sum()
        ups = {bool(v) for v in np.sign(one.speed_rad_s[one.test]) > 0.0}
        spread = float(np.std(one.load_Nm[one.test]) / np.std(one.load_Nm[one.used]))  # type: ignore[index]
        assert 0.12 <= share <= 0.38, f"{share:.2f} of the samples are held back"
        assert ups == {True, False}
        assert spread >= 0.5, f"the spread of the held back loads is {spread:.2f} of that of all"
    assert set(np.unique(part.sweep[part.test])) <= set(np.unique(whole.sweep[whole.test]))
