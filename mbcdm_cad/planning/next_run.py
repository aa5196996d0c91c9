"""After a loop that ended with a set of possible effects: the run that separates them best, as an experiment file.

Each member is put into the planned run with the size that was found. What each other member cannot imitate, nuisances
integrated out, gives the probability to choose the wrong one (:mod:`mbcdm_cad.planning.foresight`).

Travel and load stay within those of the design and of the runs so far; motion and load come from a short list.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from itertools import permutations
from math import degrees, radians
from typing import Any

import numpy as np

from mbcdm_cad.design.blocks import TORQUE_MAX_NM, TRAVEL_MAX_DEG
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.loop.result import LoopResult, Named, Noise, ways_apart
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.planning.best_run import LEAST_DURATION_S, TRAVEL_SHARE, candidates, experiment_text, run_of
from mbcdm_cad.planning.foresight import Foresight
from mbcdm_cad.planning.plan import PlannedMotion
from mbcdm_cad.rig.bench import MOST_DURATION_S, BenchLimits
from mbcdm_cad.rig.experiment import Experiment, RigError


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
    most = min(max(*torques, drive.loads.test_torque_Nm), TORQUE_MAX_NM) if torques else None
    return BenchLimits.model_validate(
        {
            "half_travel_deg": min(degrees(max(seen, TRAVEL_SHARE * radians(drive.half_travel_deg))), TRAVEL_MAX_DEG),
            "duration_s": float(np.clip(max(np.ptp(run.time_s) for run in runs), LEAST_DURATION_S, MOST_DURATION_S)),
            "sample_rate_Hz": float(np.clip(round(1.0 / step_s, 3), 1.0, 5000.0)),
            "loads": ("brake", "weight", "torque_motor") if torques else (),
            "torque_Nm": most,
            "sensors": _sensors(runs[0].sensors, bool(torques)),
        }
    )


def _sensors(sensors: Sensors, torque: bool) -> dict[str, Any]:
    """Sensors of the bench for the experiment file; those of the rig if the measurement file does not state them."""
    stated = {name: value for name, value in asdict(sensors).items() if value is not None and name != "torque_class"}
    return {**stated, "log_torque": torque}


def _planned(drive: Drive, experiment: Experiment) -> Run | None:
    try:
        return run_of(drive, experiment)
    except RigError:
        return None
