"""Runs that a bench can make: the best of a short list within its limits, and the one that separates a set of effects.

The runs of the list are compared by the sizes from which each names an effect. After a loop that ended with a set of
possible effects each member is put into the planned run with the size that was found: what each other member cannot
imitate, nuisances integrated out, gives the probability to choose the wrong one.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import permutations, product
from math import degrees, exp, floor, inf, log, log10, pi, radians, sin
from typing import Any

import numpy as np
import yaml

from mbcdm_cad.design.blocks import TORQUE_MAX_NM, TRAVEL_MAX_DEG
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.loop.result import LoopResult, Named, Noise, ways_apart
from mbcdm_cad.measurement.loads import weighed
from mbcdm_cad.measurement.run import Run, Sensors, TorqueClass
from mbcdm_cad.measurement.schema import FREQUENCY_RESPONSE, MOTION, NO_PLATE, CountedParts, InertiaPlate
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.planning.plan import Foreseen, Foresight, PlannedMotion, RunPlan, plan_of
from mbcdm_cad.rig.bench import MOST_DURATION_S, BenchLimits
from mbcdm_cad.rig.dynamic.simulate import simulate as simulate_dynamic
from mbcdm_cad.rig.experiment import DynamicExperiment, Experiment, RigError, counted_parts
from mbcdm_cad.rig.motion import LONGEST_PERIOD_S, WIDEST_MRAD, Load
from mbcdm_cad.rig.quasistatic import simulate

# Planned runs are computed at this rate, Hz; the experiment file has the rate of the bench.
PLANNING_HZ = 25.0
# Share of the travel of the design that is used, and the short travel.
TRAVEL_SHARE, SHORT_SHARE = 0.9, 0.15
# Half sweeps of a run, slow and fast.
SLOW_SWEEPS, FAST_SWEEPS = 10, 32
LEAST_DURATION_S = 60.0
# On a triangle the speed has one size, so what grows with the speed looks like what has its sign; on a sine it varies.
SHAPES = ("triangle", "sine")


def candidates(drive: Drive, limits: BenchLimits) -> list[Experiment]:
    """Runs within the limits, sorted: long travel first, then slow motion first, then triangle before sine, then the
    simplest load first."""
    travel = TRAVEL_SHARE * radians(drive.half_travel_deg)
    if limits.half_travel_deg is not None:
        travel = radians(limits.half_travel_deg)
    sensors = {**limits.sensors.model_dump(), "log_torque": bool(limits.loads) and limits.sensors.log_torque}
    if limits.motor_current is not None:
        sensors |= {"torque_noise_Nm": limits.motor_current.noise_Nm}
    found = []
    for amplitude, travels in ((travel, "long travel"), (SHORT_SHARE * travel, "short travel")):
        for sweeps, speeds in ((SLOW_SWEEPS, "slow"), (FAST_SWEEPS, "fast")):
            period = round(2.0 * limits.duration_s / sweeps, 3)
            if limits.drum_speed_max_deg_s is not None:
                # The period of a sine whose largest speed is within the limit; a slower run is allowed.
                period = max(period, round(2.0 * pi * amplitude / radians(limits.drum_speed_max_deg_s), 3))
            if period > LONGEST_PERIOD_S:
                continue
            motion = {"amplitude_mrad": round(min(1e3 * amplitude, WIDEST_MRAD), 2), "period_s": period}
            for shape, (name, load) in product(SHAPES, _loads(limits, amplitude)):
                planned = {
                    "name": "planned",
                    "about": f"{travels}, {speeds} {shape}, {name}",
                    "duration_s": round(limits.duration_s, 3),
                    "sample_rate_Hz": PLANNING_HZ,
                    "motion": {**motion, "shape": shape},
                    "load": load,
                    "sensors": sensors,
                    "physics": {"cable_transport": False},
                }
                found.append(Experiment.model_validate(planned))
    return found


def _loads(limits: BenchLimits, amplitude: float) -> Iterator[tuple[str, dict[str, Any]]]:
    """(description, load of the experiment file) at an amplitude of the drum, rad, the simplest equipment first."""
    most = limits.torque_Nm
    if most is None:
        yield "no load", {"kind": "none"}
        return
    digits = max(3, 2 - floor(log10(most)))
    levels = [round(share * most, digits) for share in (0.15, 0.4, 0.7, 1.0)]
    bias, kinds = round(0.5 * most, digits), limits.loads
    motor = {"kind": "torque_motor", "levels_Nm": levels[-1:]}
    if "brake" in kinds:
        yield "a brake at four levels", {"kind": "brake", "levels_Nm": levels, "periods_per_level": 1.0}
    if "brake" in kinds and "weight" in kinds:
        yield "a brake at half the load and a weight", {"kind": "brake", "levels_Nm": [bias], "bias_Nm": bias}
    if "weight" in kinds and limits.motor_current is not None:
        # On an arm that hangs at the centre: its torque is known at each angle, and gives the torque constant.
        moment = round(most / sin(min(amplitude, 0.5 * pi)), digits)
        yield "a weight on an arm", {"kind": "inertia_plate", "unbalance_Nm": moment}
    elif "weight" in kinds:
        yield "a weight alone", {"kind": "none", "bias_Nm": levels[-1]}
    if "torque_motor" in kinds:
        period = limits.duration_s / 13.7
        yield "a torque motor, sine with its own period", {**motor, "wave": "sine", "wave_period_s": period}
        period = limits.duration_s / 8.3
        yield "a torque motor, square wave", {**motor, "wave": "square", "wave_period_s": period}


def experiment_text(experiment: Experiment, about: str) -> str:
    """The experiment file, with a comment at its head."""
    content = experiment.model_dump(mode="json", exclude_defaults=True)
    return f"# {about}\n" + yaml.safe_dump(content, sort_keys=False, allow_unicode=True, width=110)


def class_of_load(limits: BenchLimits, load: Load) -> TorqueClass:
    """How well a load is known on a bench."""
    current = limits.motor_current
    if current is None:
        return TorqueClass()
    by_weight = inf if load.unbalance_Nm == 0.0 else 0.5 * TorqueClass().share
    return TorqueClass.of_motors(weighed(current.torque_constant_share, by_weight)[1])


def run_of(drive: Drive, wanted: Experiment | DynamicExperiment, torque_class: TorqueClass | None = None) -> Run:
    """The run as the bench would log it for the declared drive. Raises ``RigError`` if the rig stops.

    ``torque_class``: how well its load is known, as a usual sensor's if left out. Of the dynamic rig it is a chirp.
    """
    plain = wanted.physics.model_copy(update={"cable_transport": False})
    wanted, kind = wanted.model_copy(update={"effects": (), "physics": plain}), FREQUENCY_RESPONSE
    s, quasistatic = wanted.sensors, isinstance(wanted, Experiment)
    if isinstance(wanted, Experiment):
        run, kind = simulate(drive, wanted), MOTION if wanted.record == "samples" else wanted.record
        rows = wanted.rows(run.time_s)
    else:
        run = simulate_dynamic(drive, wanted)
        rows = np.arange(run.time_s.size)
    sensors = Sensors(
        s.input_resolution_rad or None,
        s.output_resolution_rad or None,
        s.torque_noise_Nm or None,
        s.input_noise_rad or None,
        s.output_noise_rad or None,
        torque_class or TorqueClass(),
    )
    return Run(
        run.time_s[rows],
        run.measured_input_rad[:, rows],
        run.measured_output_rad[rows],
        None if run.measured_load_Nm is None else run.measured_load_Nm[rows],
        None if run.measured_temperature_C is None else run.measured_temperature_C[rows],
        sensors,
        tuple(drive.input_names) if len(drive.input_names) > 1 else ("input",),
        wanted.name,
        counted=CountedParts.model_validate(counted) if (counted := counted_parts(wanted)) else None,
        kind=kind,
        excitation=None if quasistatic else run.excitation_rad,
        plate=NO_PLATE if quasistatic else InertiaPlate(inertia_kg_m2=wanted.load.inertia_kg_m2),
    )


# A run that needs an effect this many times larger than the best run does is as bad as one that cannot show it.
BLIND = 10.0


@dataclass(frozen=True)
class Rated:
    """Rating of a run: geometric mean over the effects of its smallest size over that of the best run; 1 is best.

    ``blind`` effects are shown by another run but not by this one, or this one never separates them from a rival.
    """

    mean_multiple: float
    blind: int


def alone_from(effect: Foreseen) -> float:
    """Size from which the effect is named and not confused with another; infinite if no size is enough."""
    if effect.smallest is None:
        return inf
    return max([effect.smallest, *(inf if rival.from_size is None else rival.from_size for rival in effect.rivals)])


def rated(plans: Sequence[RunPlan]) -> list[Rated]:
    """The rating of each plan against all others; effects that no plan shows do not count.

    A part of a friction that one run tells from a constant one, and another does not, counts as an effect.
    """
    alike = [{words.split(":")[0] for words in plan.friction_alike} for plan in plans]
    parts = set[str]().union(*alike)
    sizes = [
        {one.label: alone_from(one) for one in plan.effects} | {part: inf if part in own else 1.0 for part in parts}
        for plan, own in zip(plans, alike, strict=True)
    ]
    best = {label: min(size.get(label, inf) for size in sizes) for size in sizes for label in size}
    shown = {label: size for label, size in best.items() if size < inf}
    found = []
    for size in sizes:
        multiples = [min(size.get(label, inf) / least, BLIND) for label, least in shown.items()]
        mean = exp(sum(map(log, multiples)) / len(multiples)) if multiples else inf
        found.append(Rated(mean, sum(size.get(label, inf) == inf for label in shown)))
    return found


# Number of compared runs that are listed.
LISTED = 6


@dataclass(frozen=True)
class BestRun:
    """The compared runs, best first, and the plan of the best one at the sample rate of the bench."""

    runs: tuple[tuple[Experiment, Rated], ...]
    plan: RunPlan

    @property
    def experiment(self) -> Experiment:
        """The best run."""
        return self.runs[0][0]

    def experiment_text(self, bench: str) -> str:
        """The experiment file of the best run; ``bench`` names the file of limits in its first line."""
        return experiment_text(self.experiment, f"the best run within {bench}: {self.experiment.about}")

    def text(self) -> str:
        """The comparison and the plan as text."""
        lines = [
            f"{len(self.runs)} runs compared. 'size': smallest size of an effect that is named and separated, divided",
            "by that of the best run for this effect; mean of all effects. 'cannot': number of effects that the run",
            "does not show or cannot separate.",
            "",
            f"{'size':>6}  {'cannot':>6}  run",
        ]
        lines += [f"{one.mean_multiple:6.2f}  {one.blind:6d}  {run.about}" for run, one in self.runs[:LISTED]]
        return "\n".join([*lines, "", f"best: {self.experiment.about}", "", self.plan.text()])


def best_run(
    drive: Drive,
    limits: BenchLimits,
    noise: Noise | None,
    own: Sequence[Experiment] = (),
    progress: Callable[[str], None] = lambda name: None,
) -> BestRun:
    """The best of the runs within ``limits`` and of ``own``. Raises ``MbcdmError`` if none of them can be made."""
    found = []
    for experiment in (*own, *candidates(drive, limits)):
        progress(f"plan of {experiment.about or experiment.name}")
        plan = _plan(drive, experiment, noise, class_of_load(limits, experiment.load))
        if plan is not None:
            found.append((experiment, plan))
    if not found:
        raise MbcdmError("no run within these limits can be made on this drive; allow more torque or travel")
    ranked = sorted(
        zip((experiment for experiment, _ in found), rated([plan for _, plan in found]), strict=True),
        key=lambda pair: pair[1].mean_multiple,
    )
    ranked = [(run.model_copy(update={"sample_rate_Hz": limits.sample_rate_Hz}), one) for run, one in ranked]
    at_rate = _plan(drive, ranked[0][0], noise, class_of_load(limits, ranked[0][0].load))
    assert at_rate is not None
    return BestRun(tuple(ranked), at_rate)


def _plan(drive: Drive, experiment: Experiment, noise: Noise | None, torque_class: TorqueClass) -> RunPlan | None:
    try:
        return plan_of(drive, run_of(drive, experiment, torque_class), noise)
    except (RigError, ModelError):
        return None


def wrong_choice(drive: Drive, run: Run | None, members: Sequence[Named], noise: Noise, step_s: float) -> float:
    """Probability of a wrong choice between the two of ``members`` that ``run`` separates worst, 0 to 0.5.

    ``step_s`` is the time between samples of the run to be made; ``run`` may have fewer samples. The result is also 0.5
    where there is no run, where it does not show one of them at all, or cannot be simulated with it.
    """
    if run is None:
        return 0.5
    try:
        # White noise of as many samples as the run will have.
        white_rad = noise.white_rad * float(np.sqrt(step_s / run.step_s))
        planned = PlannedMotion(drive, run, replace(noise, white_rad=white_rad))
        found = [planned.found(one) for one in members]
    except ModelError:
        return 0.5
    shown = [one for one in found if one is not None]
    if len(shown) < len(members):
        return 0.5
    foresight = Foresight(planned.white, shown, planned.names)
    return max((foresight.wrong(i, j) for i, j in permutations(range(len(shown)), 2)), default=0.0)


# Below the first probability of a wrong choice the first run of the list, which is the simplest, is good enough: the
# loop separates two effects only if its own noise, from few sweeps and sectors, leaves less than 1 %, so it needs about
# twice the difference for which 1 % is expected. From the second on (odds of 4 to 1) a run is unlikely to settle the
# set, and is not proposed.
SURE, USELESS = 1e-6, 0.2


@dataclass(frozen=True)
class NextRun:
    """The best experiment, and the probability of naming the wrong effect of the set: so far, and with it."""

    experiment: Experiment
    members: tuple[Named, ...]
    wrong_before: float
    wrong_after: float

    @property
    def useful(self) -> bool:
        """Whether the run is likely to separate them."""
        return self.wrong_after < USELESS

    def words(self) -> str:
        """The result as one sentence."""
        names = " from ".join(named.words for named in self.members)
        if not self.useful:
            limits = "within the travel, loads and time so far"
            return f"no run {limits} is likely to tell {names}. What would: {ways_apart(self.members)}"
        how = f"{self.experiment.about}: expected odds {odds(self.wrong_after)}, {odds(self.wrong_before)} so far"
        return f"to tell {names}: {how}"

    def text(self) -> str:
        """The experiment file."""
        return experiment_text(self.experiment, self.words())


def odds(wrong: float) -> str:
    """Odds of naming the right effect, as text."""
    return "even" if wrong > 0.49 else f"{min((1.0 - wrong) / max(wrong, 1e-9), 9999.0):.0f} to 1"


def next_run(drive: Drive, runs: Sequence[Run], result: LoopResult) -> NextRun | None:
    """The run that separates the first set of ``result`` that a run can separate; None if there is no set.

    If no run can separate any of them, the one that comes nearest.
    """
    if not result.one_of or result.noise is None:
        return None
    step = float(np.median([run.step_s for run in runs]))
    limits = _limits(drive, runs, step)
    offered = candidates(drive, limits)
    planned = list[Run | None]()  # predicted only as far as they are looked at
    found = []
    for members in result.one_of:
        wrong, best = 1.0, offered[0]
        for k, one in enumerate(offered):
            if k == len(planned):
                planned.append(_planned(drive, one))
            now = wrong_choice(drive, planned[k], members, result.noise, step)
            if now < wrong:
                wrong, best = now, one
            if wrong < SURE:
                break
        before = min(wrong_choice(drive, run, members, result.noise, run.step_s) for run in runs)
        best = best.model_copy(update={"name": "next-run", "sample_rate_Hz": limits.sample_rate_Hz})
        found.append(NextRun(best, members, before, wrong))
        if found[-1].useful:
            break
    return min(found, key=lambda one: one.wrong_after)


def _limits(drive: Drive, runs: Sequence[Run], step_s: float) -> BenchLimits:
    """Limits of the bench, taken from what these runs reached."""
    seen = max(0.5 * float(np.ptp(run.output_rad)) for run in runs)
    torques = [float(np.abs(run.load_Nm).max()) for run in runs if run.load_Nm is not None]
    # Sensors that the measurement file does not state are those of the rig.
    sensors = asdict(runs[0].sensors).items()
    stated = {name: value for name, value in sensors if value is not None and name != "torque_class"}
    most = min(max(*torques, drive.loads.test_torque_Nm), TORQUE_MAX_NM) if torques else None
    return BenchLimits.model_validate(
        {
            "half_travel_deg": min(degrees(max(seen, TRAVEL_SHARE * radians(drive.half_travel_deg))), TRAVEL_MAX_DEG),
            "duration_s": float(np.clip(max(np.ptp(run.time_s) for run in runs), LEAST_DURATION_S, MOST_DURATION_S)),
            "sample_rate_Hz": float(np.clip(round(1.0 / step_s, 3), 1.0, 5000.0)),
            "loads": ("brake", "weight", "torque_motor") if torques else (),
            "torque_Nm": most,
            "sensors": {**stated, "log_torque": bool(torques)},
        }
    )


def _planned(drive: Drive, experiment: Experiment) -> Run | None:
    try:
        return run_of(drive, experiment)
    except RigError:
        return None
