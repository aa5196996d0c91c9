"""After a loop that ended in a set: the run that tells its members apart best, as an experiment file.

Travel and load stay within what the design and the runs so far had; motion and load are drawn from a short list.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import radians
from typing import Any

import numpy as np
import yaml

from mbcdm_cad.cli.plan import run_of
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.identification.noise import Noise
from mbcdm_cad.identification.result import LoopResult, Named
from mbcdm_cad.identification.separating import wrong_choice
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.model.errors import ModelError
from mbcdm_cad.rig.quasistatic.experiment import Experiment
from mbcdm_cad.rig.result import RigError

# Planned runs are worked out at this rate, Hz; the file asks for that of the run so far.
PLANNING_HZ = 25.0
# Share of the travel of the design that is used, and the short travel.
TRAVEL_SHARE, SHORT_SHARE = 0.9, 0.15
# Half sweeps of a run, slow and fast.
SLOW_SWEEPS, FAST_SWEEPS = 10, 32
LEAST_DURATION_S = 60.0
# Below this probability of a wrong choice the first run of the list will do, which is the one that needs least.
SURE = 1e-3


@dataclass(frozen=True)
class NextRun:
    """The best experiment, and the probability to name the wrong member of the set: so far, and with it."""

    experiment: Experiment
    members: tuple[Named, ...]
    wrong_before: float
    wrong_after: float

    def words(self) -> str:
        """For the terminal."""
        names = " from ".join(named.words for named in self.members)
        how = f"{self.experiment.about}: expected odds {odds(self.wrong_after)}, {odds(self.wrong_before)} so far"
        return f"to tell {names}: {how}"

    def text(self) -> str:
        """The experiment file."""
        content = self.experiment.model_dump(mode="json", exclude_defaults=True)
        return f"# {self.words()}\n" + yaml.safe_dump(content, sort_keys=False, allow_unicode=True, width=110)


def odds(wrong: float) -> str:
    """Odds to name the right one, for people."""
    return "even" if wrong > 0.49 else f"{min((1.0 - wrong) / max(wrong, 1e-9), 9999.0):.0f} to 1"


def next_run(drive: Drive, runs: Sequence[Run], result: LoopResult) -> NextRun | None:
    """The run that separates the first set of ``result`` best; None where there is no set."""
    if not result.one_of or result.noise is None:
        return None
    members, noise = result.one_of[0], result.noise
    step = float(np.median([run.step_s for run in runs]))
    before = min(_wrong(drive, run, members, noise, run.step_s) for run in runs)
    tried = [(_wrong(drive, _planned(drive, one), members, noise, step), one) for one in candidates(drive, runs)]
    sure = (pair for pair in tried if pair[0] < SURE)
    wrong, best = next(sure, None) or min(tried, key=lambda pair: pair[0])
    best = best.model_copy(update={"sample_rate_Hz": float(np.clip(round(1.0 / step, 3), 1.0, 5000.0))})
    return NextRun(best, members, before, wrong)


def candidates(drive: Drive, runs: Sequence[Run]) -> list[Experiment]:
    """Runs that a bench can make: long travel first, then slow ones, then in the order of what the load needs."""
    seen = max(0.5 * float(np.ptp(run.output_rad)) for run in runs)
    travel = max(seen, TRAVEL_SHARE * radians(drive.half_travel_deg))
    duration = max(LEAST_DURATION_S, max(float(np.ptp(run.time_s)) for run in runs))
    loads: list[tuple[str, dict[str, Any]]] = [("no load", {"kind": "none"})]
    torques = [float(np.abs(run.load_Nm).max()) for run in runs if run.load_Nm is not None]
    if torques:
        most = max(max(torques), drive.loads.test_torque_Nm)
        levels = [round(share * most, 3) for share in (0.15, 0.4, 0.7, 1.0)]
        bias = round(0.5 * most, 3)
        loads = [
            ("a brake at four levels", {"kind": "brake", "levels_Nm": levels, "periods_per_level": 1.0}),
            ("a brake at half the load and a weight", {"kind": "brake", "levels_Nm": [bias], "bias_Nm": bias}),
            ("a weight alone", {"kind": "none", "bias_Nm": levels[-1]}),
            (
                "a torque motor, sine of a period of its own",
                {"kind": "torque_motor", "levels_Nm": levels[-1:], "wave": "sine", "wave_period_s": duration / 13.7},
            ),
            (
                "a torque motor that steps up and down",
                {"kind": "torque_motor", "levels_Nm": levels[-1:], "wave": "square", "wave_period_s": duration / 8.3},
            ),
        ]
    found = []
    for amplitude, travels in ((travel, "long travel"), (SHORT_SHARE * travel, "short travel")):
        for sweeps, speeds in ((SLOW_SWEEPS, "slow"), (FAST_SWEEPS, "fast")):
            period = round(2.0 * duration / sweeps, 3)
            motion = {"amplitude_mrad": round(min(1e3 * amplitude, 1200.0), 2), "period_s": period}
            for name, load in loads:
                found.append(
                    Experiment.model_validate(
                        {
                            "name": "next-run",
                            "about": f"{travels}, {speeds}, {name}",
                            "duration_s": round(duration, 3),
                            "sample_rate_Hz": PLANNING_HZ,
                            "motion": motion,
                            "load": load,
                            "sensors": _sensors(runs[0].sensors, bool(torques)),
                            "physics": {"cable_transport": False},
                        }
                    )
                )
    return found


def _sensors(sensors: Sensors, torque: bool) -> dict[str, Any]:
    """The sensors of the bench, as the experiment file has them; the rig's own where the measurement file is silent."""
    fields = {
        "input_resolution_rad": sensors.input_resolution_rad,
        "output_resolution_rad": sensors.output_resolution_rad,
        "torque_noise_Nm": sensors.torque_noise_Nm,
        "input_noise_rad": sensors.input_noise_rad,
        "output_noise_rad": sensors.output_noise_rad,
    }
    return {name: value for name, value in fields.items() if value is not None} | {"log_torque": torque}


def _planned(drive: Drive, experiment: Experiment) -> Run | None:
    try:
        return run_of(drive, experiment)
    except RigError:
        return None


def _wrong(drive: Drive, run: Run | None, members: Sequence[Named], noise: Noise, step_s: float) -> float:
    if run is None:
        return 0.5
    try:
        return wrong_choice(drive, run, members, noise, step_s)
    except ModelError:
        return 0.5
