"""How often the loop names a second mode, where there is none and where there is one: tables with odd noise.

    python -m benchmarks.studies.second_mode --rows out/modes.jsonl --runs 48 [--second] --first-seed 1000

Tables of two masses in closed form, or of three with ``--second``: as designed, soft, heavy or late, with or without
the design. Their noise in turn is what the loop does not expect: see ``KINDS``. A row of the file is a table.
"""

import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from scipy.signal import coherence, csd, welch

import mbcdm_cad as mc
from benchmarks.study import Row, Study, parser
from tests.support.bench_score import interval
from tests.unit.loop.test_frequency_response import DESIGN, PLATE_KG_M2, RATIO, ThreeMasses, designed, forms

Floats, Complex, Rng = np.ndarray, np.ndarray, np.random.Generator
Rows = tuple[Floats, Complex, Floats | None]
LOWEST_HZ, HIGHEST_HZ = 4.0, 150.0


def lines(rng: Rng, mode_Hz: float) -> Floats:
    """Frequencies as analysers have them: even in the logarithm, even, dense about the mode, or with a gap."""
    n = int(rng.integers(60, 400))
    kind = rng.integers(4)
    if kind == 0:
        return np.geomspace(LOWEST_HZ, HIGHEST_HZ, n)
    if kind == 1:
        return np.linspace(LOWEST_HZ, HIGHEST_HZ, n)
    if kind == 2:
        near = mode_Hz * (1.0 + rng.uniform(0.1, 0.3) * np.linspace(-1.0, 1.0, n // 2))
        return np.unique(np.concatenate([np.geomspace(LOWEST_HZ, HIGHEST_HZ, n // 2), near]))
    f = np.geomspace(LOWEST_HZ, HIGHEST_HZ, n)
    gap = rng.uniform(8.0, 120.0)
    return f[(f < gap) | (f > gap * rng.uniform(1.05, 1.3))]


def noisy(rng: Rng, n: int, share: Any) -> Complex:
    return 1.0 + share * (rng.normal(size=n) + 1j * rng.normal(size=n))


def averaged(bench: Any, rng: Rng) -> Rows:
    """Few averages of a noisy output: its noise hangs on no frequency, so that the coherence falls with the gain."""
    f = lines(rng, bench.frequency_Hz)
    count, level = int(rng.choice([2, 4, 16, 64])), 10 ** rng.uniform(-2.0, -1.0)
    shape = (count, f.size)
    x = rng.normal(size=shape) + 1j * rng.normal(size=shape)
    y = bench.over_inputs(2j * np.pi * f) * x + level * (rng.normal(size=shape) + 1j * rng.normal(size=shape))
    cross, below, above = (x.conj() * y).mean(0), (abs(x) ** 2).mean(0), (abs(y) ** 2).mean(0)
    return f, cross / below, np.abs(cross) ** 2 / below / above


def windowed(bench: Any, rng: Rng) -> Rows:
    """Welch's segments of noise, with a window that spreads the peak."""
    rate, n = 1000.0, int(rng.integers(30, 120)) * 1000
    x = rng.normal(size=n)
    at = np.fft.rfftfreq(n, 1.0 / rate)
    y = np.fft.irfft(np.fft.rfft(x) * bench.over_inputs(2j * np.pi * np.maximum(at, 1e-6)), n)
    y = y + 10 ** rng.uniform(-2.5, -1.0) * rng.normal(size=n)
    how = {"fs": rate, "nperseg": int(rng.choice([1024, 2048, 4096])), "window": str(rng.choice(["hann", "boxcar"]))}
    f, cross = csd(x, y, **how)
    kept = (f > LOWEST_HZ) & (f < HIGHEST_HZ)
    return f[kept], (cross / welch(x, **how)[1])[kept], coherence(x, y, **how)[1][kept]


def leaning(bench: Any, rng: Rng) -> Rows:
    """A gain that leans over the band and a phase that is some degrees off, as of a sensor's amplifier."""
    f = lines(rng, bench.frequency_Hz)
    lean = np.exp(rng.normal(0.0, 0.01) * np.log(f / 20.0) + 1j * rng.normal(0.0, 0.02) * np.log(f / 20.0))
    return f, bench.over_inputs(2j * np.pi * f) * lean * noisy(rng, f.size, 0.005), None


def rounded(bench: Any, rng: Rng) -> Rows:
    """Decibels and degrees with one or no digit behind the point."""
    f = lines(rng, bench.frequency_Hz)
    value = bench.over_inputs(2j * np.pi * f) * noisy(rng, f.size, 0.003)
    decibel, degree = ((0.1, 1.0), (0.05, 0.1), (0.5, 1.0))[rng.integers(3)]
    gain = decibel * np.round(20.0 * np.log10(np.abs(value) / RATIO) / decibel)
    phase = degree * np.round(np.degrees(np.angle(value)) / degree)
    return f, RATIO * 10.0 ** (gain / 20.0) * np.exp(1j * np.radians(phase)), None


def mains(bench: Any, rng: Rng) -> Rows:
    """Rows at 50 and 100 Hz that the mains have spoilt."""
    f = lines(rng, bench.frequency_Hz)
    value = bench.over_inputs(2j * np.pi * f) * noisy(rng, f.size, 0.005)
    for at in (50.0, 100.0):
        near = np.argsort(np.abs(f - at))[: int(rng.integers(1, 4))]
        value[near] *= noisy(rng, near.size, rng.uniform(0.05, 0.3))
    return f, value, None


def smooth(bench: Any, rng: Rng) -> Rows:
    """Rows that the analyser smoothed, so that they scatter too little and the peak is low."""
    f, width = lines(rng, bench.frequency_Hz), int(rng.choice([3, 5, 9]))
    value = bench.over_inputs(2j * np.pi * f) * noisy(rng, f.size, 0.02)
    inside = slice(width // 2, f.size - width // 2)
    return f[inside], np.convolve(value, np.full(width, 1.0 / width), "valid"), None


def fading(bench: Any, rng: Rng) -> Rows:
    """A noise of the output that no column tells: above the mode little is left."""
    f = lines(rng, bench.frequency_Hz)
    value, level = bench.over_inputs(2j * np.pi * f), 10 ** rng.uniform(-2.5, -1.5)
    return f, value + level * (noisy(rng, f.size, 1.0) - 1.0), None


def wandering(bench: Any, rng: Rng) -> Rows:
    """A stepped sine while the drive warms: the mode moves by some per mille from the first row to the last."""
    f = lines(rng, bench.frequency_Hz)
    moved = 1.0 + rng.normal(0.0, 0.004) * np.arange(f.size) / f.size
    return f, bench.over_inputs(2j * np.pi * f / moved) * noisy(rng, f.size, 0.005), None


KINDS = {one.__name__: one for one in (averaged, windowed, leaning, rounded, mains, smooth, fading, wandering)}


def judged(task: tuple[int, bool]) -> Row:
    """What the loop says of one table."""
    seed, second = task
    rng = np.random.default_rng([seed, 46])
    kind = list(KINDS)[seed % len(KINDS)]
    design = bool(rng.random() < 0.67)
    give, inertia, delay = ((1, 1, 0), (1, 1, 0), (1.4, 1, 0), (1, 1.2, 0), (1, 1, 4e-4))[rng.integers(5)]
    two = designed(give, inertia)
    bench: Any = replace(two, damping=float(np.exp(rng.uniform(np.log(0.008), np.log(0.06)))))
    true = ({"stiffness_error", "payload_inertia"} if give != inertia else set()) if design else {"torsional_mode"}
    row: Row = {"kind": kind, "design": design, "second": second}
    if second:
        what, far = str(rng.choice(["arm", "frame", "front"])), rng.uniform(1.4, 2.6)
        own = two.frequency_Hz * (1.0 / far if what == "arm" and rng.random() < 0.4 else far)
        share = float(rng.uniform(0.05, 0.3))
        bench = ThreeMasses(two.frequency_Hz, bench.damping, two.inertia_kg_m2, what=what, second_Hz=own, share=share)
        row |= {"what": what, "modes_Hz": bench.modes_Hz.tolist(), "share": share}
    f, value, gamma = KINDS[kind](bench, rng)
    value = value * np.exp(-2j * np.pi * f * delay) / RATIO
    columns = {"frequency": (f, "Hz"), "gain": (np.abs(value), "-"), "phase": (np.degrees(np.angle(value)), "deg")}
    columns |= {} if gamma is None else {"coherence": (gamma, "-")}
    block = {"over": "inputs"} | ({"amplitude_rad": 1e-7} if rng.random() < 0.7 else {})
    content: dict[str, Any] = {
        "data": "t.csv",
        "kind": "frequency_response",
        "columns": {key: {"column": k, "unit": unit} for k, (key, (_, unit)) in enumerate(columns.items(), 1)},
        "response": block,
    }
    own_words: dict[str, Any] = {"parts": {"output_at": "payload"}, "inertia_plate": {"inertia_kg_m2": PLATE_KG_M2}}
    content |= own_words if design else {"ratio": RATIO}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        np.savetxt(folder / "t.csv", np.stack([one for one, _ in columns.values()], axis=1), "%.9g", ",")
        content["header"] = "none"
        (folder / "t.yaml").write_text(yaml.safe_dump(content))
        return row | said(
            mc.load(DESIGN) if design else None, [folder / "t.yaml"], true | ({"delay"} if delay else set())
        )


def said(design: Any, files: list[Path], true: set[str]) -> dict[str, Any]:
    """The loop's finding as figures of a row."""
    begun = time.process_time()
    result = mc.close_loop(design, files).result
    at = [one.parameters["natural_frequency_Hz"] for one in result.effects if one.name == "second_mode"]
    found = forms(result)
    return {
        "cpu_s": time.process_time() - begun,
        "found": sorted(found),
        "wrong": sorted(found - true - {"second_mode"}),
        "missed": bool(true and not found & true),
        "second_Hz": [(one.value, one.low, one.high) for one in at],
        "over_floor": result.errors.after.value / result.errors.floor_rad,
        "verdict": result.verdict,
        "sentence": result.sentence,
    }


def summary(rows: list[Row]) -> str:
    """Shares with their 95 % intervals, by kind of noise."""
    found = []
    for second in (False, True):
        for kind in ("", *KINDS):
            mine = [row for row in rows if row["second"] == second and kind in ("", row["kind"])]
            if mine:
                named = sum("second_mode" in row["found"] for row in mine)
                low, high = interval(named, len(mine))
                odd = sum(bool(row["wrong"]) for row in mine)
                text = f"{'two modes' if second else 'one mode'}, {kind or 'all tables'}: second_mode in {named} of "
                found.append(f"{text}{len(mine)} ({low:.0%} to {high:.0%}), another wrong name in {odd}")
    return "\n".join(found)


def main() -> None:
    """Parse and do."""
    options = parser(__doc__)
    options.add_argument("--second", action="store_true", help="tables of three masses")
    given = options.parse_args()
    seeds = range(given.first_seed, given.first_seed + given.runs)
    Study(judged, summary).run([(seed, given.second) for seed in seeds], given)


if __name__ == "__main__":
    main()
