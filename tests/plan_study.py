"""Compare the power that ``mbcdm plan`` predicts with that found on noisier benches.

    python tests/plan_study.py --benches 0:5 --store out/plan-study.jsonl       five benches, one run of each size
    python tests/plan_study.py --benches 0:5 --only lash,delay                  of some effects
    python tests/plan_study.py --store out/plan-study.jsonl --table docs/plan-promises.md      what was counted so far

On each bench a pilot run without an effect gives the noise, and the plan gives the size of each effect that is named
with a probability of 0.5 and of 0.9. The loop then judges runs with that size, which are made by the physics of
tests/support/bench_chain.py. One run of each size on each bench, because what a bench does beside its noise is the same
in all its runs. Results are collected in the store; what is stored is not run again.
"""

from __future__ import annotations

import argparse
import json
import sys
import textwrap
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests" / "support"), str(ROOT)]

from bench_data import Simulated, drum_angle, stream, through_files  # noqa: E402
from bench_effects import ALL, Effect  # noqa: E402
from bench_geometry import chain_of  # noqa: E402
from bench_motion import Bench, Plan, bench_run  # noqa: E402
from bench_real import Traits, draw_traits, logged, tracked  # noqa: E402
from bench_score import interval, outcome_of, said_of  # noqa: E402

from mbcdm_cad.layouts.loader import load_design  # noqa: E402
from mbcdm_cad.loop.search.engine import close_loop  # noqa: E402
from mbcdm_cad.measurement.run import Run  # noqa: E402
from mbcdm_cad.planning.plan import noise_from, plan_of  # noqa: E402
from tests.support.many import add_workers, run_many  # noqa: E402

DRIVE = load_design(ROOT / "params" / "mbcdm.yaml").drive
POWERS = (0.5, 0.9)
# Of the text of the page.
WIDTH = 120
MOTION = Plan(amplitude_rad=0.45, frequency_hz=0.1, wave="sine", load="steps", load_Nm=0.8, duration_s=100.0)
# The effect of a size, with its sign; a wave at a phase.
Make = Callable[[float, float], Effect]


def _signed(name: str, kind: str, key: str, cables: tuple[int, ...] = ()) -> Make:
    return lambda size, phase: Effect(name, kind, {key: size}, cables=cables)


def _wave(name: str, kind: str, key: str, stage: str | None, **figures: float) -> Make:
    return lambda size, phase: Effect(name, kind, {**figures, key: size, "phase_rad": phase}, stage=stage)


# Label in the plan -> how the bench makes it.
EFFECTS: dict[str, Make] = {
    "once_per_rev drum (eccentric encoder)": _wave("once_per_rev", "output_encoder", "amplitude_rad", "drum"),
    "once_per_rev guide (eccentric pulley)": _wave("once_per_rev", "pulley", "eccentricity_m", "guide"),
    "ratio_error (pitch radius or encoder scale)": _signed("ratio_error", "output_scale", "share"),
    "ripple of order 200": _wave("ripple", "division", "amplitude_rad", None, cycles_per_output_rev=200.0),
    "stiffness_error (modulus of the rope)": _signed("stiffness_error", "modulus", "share"),
    "stiffness_error (compliance in series)": _signed("stiffness_error", "shaft_compliance", "compliance_rad_Nm"),
    "preload_error (all cables)": _signed("preload_error", "preload", "share", ALL),
    "delay (late sensor)": _signed("delay", "latency", "delay_s"),
    "friction (bearing torque)": _signed("friction", "bearing", "torque_Nm"),
    "lash (play at the output)": _signed("lash", "output_play", "play_rad"),
}
WAVES = [label for label in EFFECTS if label.startswith(("once_per_rev", "ripple"))]
BOTH_SIGNS = ["ratio_error (pitch radius or encoder scale)", "stiffness_error (modulus of the rope)"]
BOTH_SIGNS += ["preload_error (all cables)"]


@dataclass(frozen=True)
class Stand:
    """One bench: what it does beside what it is told, and its true signals on the planned motion."""

    number: int
    traits: Traits
    bench: Bench

    def drum(self, effects: tuple[Effect, ...]) -> np.ndarray:
        """The true angle of the drum."""
        return drum_angle(CHAIN, DRIVE.input_names, self.bench, effects, stream("plan", self.number, "wander"))

    def worst_phase(self, make: Make, size: float) -> float:
        """Phase at which a wave moves the drum's reading least, in RMS about its mean after the first half sweep."""
        known = self.bench.time_s > 0.5 / MOTION.frequency_hz
        still = self.drum(())
        waves = np.stack([(self.drum((make(size, phase),)) - still)[known] for phase in (0.0, 0.5 * np.pi)])
        least = np.linalg.eigh(np.cov(waves))[1][:, 0]
        return float(np.arctan2(least[1], least[0]))

    def read(self, effects: tuple[Effect, ...], name: str) -> Run:
        """The run as the logger of the bench shows it, with noise of its own for each ``name``. Raises ValueError where
        the cables of the bench find no balance."""
        whole = Simulated(MOTION, self.bench, self.drum(effects), {}, effects, ("inputs", "output", "torque"))
        rng = stream("plan", self.number, f"sensors {name}")
        return through_files(logged(whole, self.traits, RATIO, rng), DRIVE.input_names)


CHAIN = chain_of(DRIVE)
RATIO = float(np.mean(CHAIN.r_drum / CHAIN.r_in))


def stand(number: int) -> Stand:
    """Bench ``number``: noise 1.3 to 3 times what the encoders' steps make, at 50 Hz."""
    inputs = len(DRIVE.input_names)
    rng = stream("plan", number, "traits")
    traits = draw_traits(rng, inputs)
    noise = float(rng.uniform(4e-6, 12e-6))
    traits = replace(traits, rate_hz=50.0, gaps=0, white_rad=0.9 * noise, coloured_rad=0.4 * noise, drift_rad=0.0)
    bench = bench_run(MOTION, RATIO, inputs, stream("plan", number, "motion"))
    return Stand(number, traits, tracked(bench, RATIO, traits, stream("plan", number, "tracking")))


def judged(task: tuple[int, list[tuple[str, float]]]) -> list[dict[str, Any]]:
    """The rows of one bench with the effects and promised powers that are wanted there."""
    return list(_judged(*task))


def _judged(number: int, wanted: list[tuple[str, float]]) -> Iterator[dict[str, Any]]:
    one = stand(number)
    pilot = one.read((), "pilot")
    noise = noise_from(DRIVE, pilot)
    plans = {power: plan_of(DRIVE, pilot, noise, power) for power in POWERS}
    for label, power in wanted:
        seen = next(one for one in plans[power].effects if one.label == label)
        sign = float(stream("plan", number, f"{label} {power}").choice([-1.0, 1.0])) if label in BOTH_SIGNS else 1.0
        signed = {1.0: seen.if_positive, -1.0: seen.if_negative}
        if signed[sign] is None and signed[-sign] is not None:
            sign = -sign
        size = signed[sign] or seen.smallest
        if size is None:
            print(f"left out: bench {number}, {label}: the planned motion cannot show it", file=sys.stderr)
            continue
        phase = one.worst_phase(EFFECTS[label], size) if label in WAVES else 0.0
        effect = EFFECTS[label](sign * size, phase)
        try:
            run = one.read((effect,), f"{label} {power}")
        except ValueError as error:
            print(f"left out: bench {number}, {label} of {sign * size:.3g}: {error}", file=sys.stderr)
            continue
        start = time.process_time()
        result = close_loop(DRIVE, [run]).to_json()
        yield {
            "bench": number,
            "effect": label,
            "power": power,
            "size": sign * size,
            "floor_rad": noise.total_rad,
            "outcome": outcome_of(result, [effect.as_truth()]),
            "said": said_of(result),
            "seconds": time.process_time() - start,
        }


def table(rows: list[dict[str, Any]]) -> str:
    """Found power by effect and promised power, as Markdown."""
    lines = [
        "| effect | promised | found | of | share | 95 % | named outright | wrong name |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for power in POWERS:
        for label in [*EFFECTS, ""]:
            chosen = [r for r in rows if r["power"] == power and label in ("", r["effect"])]
            if not chosen:
                continue
            right = sum(r["outcome"] in ("exact", "set") for r in chosen)
            outright = sum(r["outcome"] == "exact" for r in chosen)
            wrong = sum(r["outcome"] in ("wrong", "wrong set") for r in chosen)
            low, high = interval(right, len(chosen))
            lines.append(
                f"| {label or '**all**'} | {power:g} | {right} | {len(chosen)} | {right / len(chosen):.0%} | "
                f"{low:.0%} to {high:.0%} | {outright} | {wrong} |"
            )
    return "\n".join(lines)


def page(rows: list[dict[str, Any]]) -> str:
    """The page of docs/."""
    benches = sorted({r["bench"] for r in rows})
    return "\n".join(
        [
            "# Does a plan keep its promises?",
            "",
            textwrap.fill(
                f"Made by `python tests/plan_study.py --benches {benches[0]}:{benches[-1] + 1}`: {len(rows)} runs on "
                f"{len(benches)} simulated benches. The noise of each bench is 1.3 to 3 times what its declared "
                "encoder steps make; its two servos track unlike; its cables are chains of pieces with Coulomb "
                "friction, not the equations of the model. Each size is tried once on each bench.",
                WIDTH,
            ),
            "",
            textwrap.fill(
                "On each bench a pilot run without an effect gives the noise (`mbcdm plan --noise-from`). The plan "
                "gives, for each effect, the size that is found with a probability of 0.5 and of 0.9 (`mbcdm plan` "
                "prints the size for 0.9). Runs with that size go to the loop. A wave has the phase that shows least "
                "on the bench; an effect that may have either sign has one drawn at random, with the size of that "
                "sign. *Found*: the effect is named, or a member of a set that the data cannot separate. The aim is a "
                "found share within 10 percentage points of the promised one.",
                WIDTH,
            ),
            "",
            table(rows),
            "",
        ]
    )


def main() -> None:
    """Parse and do."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--benches", default="0:0", help="first and last, as 0:5; the last is not made")
    parser.add_argument("--only", default="", help="words of which one is in the name of each effect, by commas")
    parser.add_argument("--store", type=Path, default=ROOT / "out" / "plan-study.jsonl")
    parser.add_argument("--table", type=Path, help="Markdown page to write")
    add_workers(parser)
    options = parser.parse_args()
    options.store.parent.mkdir(parents=True, exist_ok=True)
    rows = [json.loads(line) for line in options.store.read_text().splitlines()] if options.store.exists() else []
    done = {(r["bench"], r["effect"], r["power"]) for r in rows}
    labels = [label for label in EFFECTS if any(word in label for word in options.only.split(","))]
    first, last = (int(word) for word in options.benches.split(":"))
    each = [(label, power) for label in labels for power in POWERS]
    wanted = {number: [one for one in each if (number, *one) not in done] for number in range(first, last)}
    tasks = [(number, effects) for number, effects in wanted.items() if effects]
    with options.store.open("a") as kept:
        for bench in run_many(judged, tasks, options):
            for row in bench:
                rows.append(row)
                kept.write(json.dumps(row) + "\n")
                kept.flush()
    if options.table:
        options.table.write_text(page(rows), encoding="utf-8")
    print(table(rows))


if __name__ == "__main__":
    main()
