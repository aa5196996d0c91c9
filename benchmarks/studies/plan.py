"""Compare the power that ``mbcdm plan`` predicts with that found on noisier benches.

    python -m benchmarks.studies.plan --runs 100 --rows out/plan.jsonl
    python -m benchmarks.studies.plan --runs 100 --only lash,delay

On each bench a pilot run without an effect gives the noise (``mbcdm plan --noise-from``), and the plan gives the size
of each effect that is named with a probability of 0.5 and of 0.9. The loop then judges runs with that size, which are
made by the physics of tests/support/bench_chain.py. One run of each size on each bench, because what a bench does
beside its noise is the same in all its runs. A wave has the phase that shows least on the bench; an effect that may
have either sign has one drawn at random, with the size of that sign. A size is found if its effect is named, or a
member of a set that the data cannot separate; the aim is a share within 10 percentage points of the promised one.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import count, islice

import numpy as np

from benchmarks.study import ROOT, Row, Study, parser
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.loop.result import Noise
from mbcdm_cad.loop.search.engine import close_loop
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.planning.plan import RunPlan, noise_from, plan_of
from tests.support.bench_data import Simulated, drum_angle, stream, through_files
from tests.support.bench_effects import ALL, Effect
from tests.support.bench_motion import Bench, Plan, bench_run, chain_of
from tests.support.bench_real import Traits, draw_traits, logged, tracked
from tests.support.bench_score import interval, outcome_of, said_of

DRIVE = load_design(ROOT / "params" / "mbcdm.yaml").drive
POWERS = (0.5, 0.9)
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


@lru_cache(maxsize=1)
def stood(number: int) -> tuple[Stand, Run, Noise]:
    """A bench, its pilot run and the noise by it."""
    one = stand(number)
    pilot = one.read((), "pilot")
    return one, pilot, noise_from(DRIVE, pilot)


@lru_cache(maxsize=2)
def planned(number: int, power: float) -> RunPlan:
    """What is promised of a run of that bench."""
    _, pilot, noise = stood(number)
    return plan_of(DRIVE, pilot, noise, power)


def promised(task: tuple[int, str, float]) -> tuple[Run, Effect] | None:
    """The run of a bench with the size that is promised to be found; None where the planned motion cannot show it, or
    the cables of the bench find no balance."""
    (number, label, power), (one, _, _) = task, stood(task[0])
    seen = next(one for one in planned(number, power).effects if one.label == label)
    sign = float(stream("plan", number, f"{label} {power}").choice([-1.0, 1.0])) if label in BOTH_SIGNS else 1.0
    signed = {1.0: seen.if_positive, -1.0: seen.if_negative}
    if signed[sign] is None and signed[-sign] is not None:
        sign = -sign
    size = signed[sign] or seen.smallest
    if size is None:
        return None
    effect = EFFECTS[label](sign * size, one.worst_phase(EFFECTS[label], size) if label in WAVES else 0.0)
    try:
        return one.read((effect,), f"{label} {power}"), effect
    except ValueError:
        return None


def judged(task: tuple[int, str, float]) -> Row:
    """One promise."""
    made = promised(task)
    row: Row = {"effect": task[1], "power": task[2], "floor_rad": stood(task[0])[2].total_rad}
    if made is None:
        return row | {"outcome": "left out"}
    result = close_loop(DRIVE, [made[0]]).to_json()
    outcome = outcome_of(result, [made[1].as_truth()])
    return row | {"size": made[1].size, "outcome": outcome, "said": said_of(result)}


def table(rows: list[Row]) -> str:
    """Found power by effect and promised power, as Markdown."""
    lines = [
        "| effect | promised | found | of | share | 95 % | named outright | wrong name |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for power in POWERS:
        for label in [*EFFECTS, ""]:
            chosen = [r for r in rows if r["power"] == power and label in ("", r["effect"]) and "said" in r]
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


def main() -> None:
    """Parse and do."""
    options = parser(__doc__)
    options.add_argument("--only", default="", help="words of which one is in the name of each effect, by commas")
    given = options.parse_args()
    labels = [label for label in EFFECTS if any(word in label for word in given.only.split(","))]
    each = [(label, power) for label in labels for power in POWERS]
    tasks = ((number, *one) for number in count(given.first_seed) for one in each)
    Study(judged, table).run(islice(tasks, given.runs), given)


if __name__ == "__main__":
    main()
