"""Time and memory of the loop from 1e4 to 1e6 samples (1e7 with --most 1e7), compared with a plain least-squares fit.

    python benchmarks/loop.py [--most 1e6] [--plain-most 1e5] [--effects worked|additive] [--json FILE]

Each figure is measured in its own process: time to read the CSV and close the loop, peak memory of the process. The
plain fit is scipy.optimize.least_squares with the effects that are in the data and finite differences. worked: E,
guide pulley as sine and cosine in the cables' paths, ratio, offset, on the model's whole series. additive: ratio,
delay, offset, on a run without a torque column, on which all effects only add to the reading. Only the ratios can be
compared between machines: plain fit over loop, and time per sample over that at the size before.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from timing import ROOT, Figure, finish

from mbcdm_cad.layouts.registry import layout_of

DESIGN = ROOT / "params" / "mbcdm.yaml"
BLOCK = 1_000_000  # samples simulated; longer runs repeat them with fresh sensor noise
LIMIT_S, LIMIT_ADDITIVE_S, LIMIT_MIB = 12.0, 3.0, 1536.0


def write_series(folder: Path, samples: int, effects: str) -> Path:
    """A measured run of ``samples`` with the effects in it; the path of its measurement file."""
    from mbcdm_cad.layouts.loader import load_design
    from tests.support.bench_data import Simulated, drum_angle, write_run
    from tests.support.bench_effects import Effect
    from tests.support.bench_motion import RATE_HZ, Bench, Plan, bench_run, chain_of, read_sensors

    drive = load_design(DESIGN).drive
    chain = chain_of(drive)
    rng = np.random.default_rng(7)
    length = min(samples, BLOCK)
    load = "bias" if effects == "worked" else "bare"
    plan = Plan(amplitude_rad=0.45, frequency_hz=0.0625, load=load, duration_s=length / RATE_HZ)
    bench = bench_run(plan, float(np.mean(chain.r_drum / chain.r_in)), len(drive.input_names), rng)
    present = [Effect("ratio_error", "output_scale", {"share": 2e-4})]
    if effects == "worked":
        size = {"eccentricity_m": 6e-6, "phase_rad": 0.7}
        present.append(Effect("once_per_rev", "pulley", size, stage="guide"))
    else:
        present.append(Effect("delay", "latency", {"delay_s": 1e-3}))
    drum = drum_angle(chain, drive.input_names, bench, tuple(present), rng)
    times = -(-samples // length)
    columns = ("torque",) if effects == "worked" else ()
    t = np.arange(samples) / RATE_HZ

    def tiled(values: np.ndarray) -> np.ndarray:
        return np.tile(values, times)[..., :samples]

    whole = Bench(t, tiled(bench.input_rad), tiled(bench.load_Nm), tiled(bench.speed_rad_s), tiled(bench.air_degC))
    run = Simulated(plan, whole, tiled(drum), read_sensors(whole, tiled(drum), rng), tuple(present), columns)
    write_run(folder, f"run-{samples}", run, drive.input_names)
    return folder / f"run-{samples}.yaml"


def loop_once(path: Path) -> dict[str, Any]:
    """Read and close the loop, timed apart."""
    from mbcdm_cad.layouts.loader import load_design
    from mbcdm_cad.loop.search.engine import close_loop
    from mbcdm_cad.measurement.reading import load_measurement

    drive = load_design(DESIGN).drive
    if os.environ.get("BENCH_WARM"):
        close_loop(drive, [load_measurement(Path(os.environ["BENCH_WARM"]))])
    start = time.perf_counter()
    run = load_measurement(path)
    read = time.perf_counter()
    result = close_loop(drive, [run]).to_json()
    end = time.perf_counter()
    return {
        "read_s": read - start,
        "loop_s": end - read,
        "named": [f"{e['name']} {e.get('stage', '')}".strip() for e in result["effects"]],
        "after_rad": result["error"]["after_rad"],
    }


def plain_once(path: Path, effects: str) -> dict[str, Any]:
    """The same effects fitted by scipy.optimize.least_squares on the model's series."""
    from scipy.optimize import least_squares

    from mbcdm_cad.layouts.loader import load_design
    from mbcdm_cad.measurement.reading import load_measurement
    from mbcdm_cad.model.hysteresis import simulate
    from tests.support.bench_motion import chain_of, path_of_eccentric

    drive = load_design(DESIGN).drive
    run = load_measurement(path)
    start = time.perf_counter()
    declared, chain = layout_of(drive).si, chain_of(drive)
    drum = run.input_rad.mean(axis=0) / float(np.mean(chain.r_drum / chain.r_in))
    shaft = -drum * float(np.mean(chain.r_drum / chain.r_guide))
    paths = [path_of_eccentric(chain, "guide", 1e-6, phase, shaft) for phase in (0.0, 0.5 * np.pi)]
    speed = np.gradient(drum, run.time_s)
    calls = 0

    def miss(p: np.ndarray) -> np.ndarray:
        nonlocal calls
        calls += 1
        if run.load_Nm is not None:
            stiffer = declared.with_(modulus_Pa=declared.modulus_Pa * (1.0 + 0.1 * p[2]))
            predicted = simulate(stiffer, run.input_rad, run.load_Nm, p[3] * paths[0] + p[4] * paths[1]).drum_angle_rad
        else:
            predicted = drum - 1e-3 * p[2] * speed
        return np.asarray((predicted * (1.0 + 1e-4 * p[0]) + 1e-5 * p[1] - run.output_rad) * 1e6)

    found = least_squares(miss, np.zeros(5 if effects == "worked" else 3))
    end = time.perf_counter()
    return {"plain_s": end - start, "calls": calls, "rms_rad": float(np.sqrt(np.mean(found.fun**2)) * 1e-6)}


def in_a_process(*arguments: str, warm: Path | None = None) -> dict[str, Any]:
    """Run this file's --child with ``arguments``; its JSON with peak memory added."""
    environment = {**os.environ, **({"BENCH_WARM": str(warm)} if warm else {})}
    done = subprocess.run(
        [sys.executable, __file__, "--child", *arguments], capture_output=True, text=True, env=environment, check=False
    )
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(arguments)} failed:\n{done.stderr[-2000:]}")
    return dict(json.loads(done.stdout.splitlines()[-1]))


def child(what: str, path: str, effects: str) -> None:
    """What runs in the process that is measured."""
    figures = loop_once(Path(path)) if what == "loop" else plain_once(Path(path), effects)
    figures["peak_MiB"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    print(json.dumps(figures))


def main() -> int:
    """Run all sizes; exit code 1 if a limit is exceeded."""
    if sys.argv[1:2] == ["--child"]:
        child(*sys.argv[2:5])
        return 0
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--most", type=float, default=1e6)
    parser.add_argument("--plain-most", type=float, default=1e5)
    parser.add_argument("--effects", choices=["worked", "additive"], default="worked")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    rows: list[dict[str, Any]] = []
    figures: list[Figure] = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        sizes = [10**k for k in range(4, 8) if 10**k <= options.most]
        warm = write_series(folder, 8_000, options.effects)
        before = None
        for samples in sizes:
            path = write_series(folder, samples, options.effects)
            row = {"samples": samples, **in_a_process("loop", str(path), options.effects, warm=warm)}
            row["total_s"] = row["read_s"] + row["loop_s"]
            row["growth"] = row["total_s"] / samples / before if before else None
            before = row["total_s"] / samples
            if samples <= options.plain_most:
                row |= {"plain": in_a_process("plain", str(path), options.effects)}
                row["plain_over_loop"] = row["plain"]["plain_s"] / row["loop_s"]
            rows.append(row)
            print(_line(row), flush=True)
            if samples == 10**6:
                limit = LIMIT_ADDITIVE_S if options.effects == "additive" else LIMIT_S
                figures.append(Figure("1e6 samples, read and loop", row["total_s"], "s", limit))
                figures.append(Figure("1e6 samples, peak memory", row["peak_MiB"], "MiB", LIMIT_MIB))
            path.with_suffix(".csv").unlink()
    for figure in figures:
        print(figure)
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1))
    return finish(figures, None)


def _line(row: dict[str, Any]) -> str:
    text = f"{row['samples']:>9d} samples: read {row['read_s']:.2f} s, loop {row['loop_s']:.2f} s, "
    text += f"peak {row['peak_MiB']:.0f} MiB, named {row['named']}"
    if row["growth"]:
        text += f"; time per sample {row['growth']:.2f} of that at a tenth of the size"
    if "plain" in row:
        plain = row["plain"]
        text += f"; plain fit {plain['plain_s']:.2f} s ({plain['calls']} runs of the model), "
        text += f"{row['plain_over_loop']:.2f} of the loop"
    return text


if __name__ == "__main__":
    sys.exit(main())
