"""A bench with fine encoders and a torque sensor that is wrong: gain, zero, low-pass. The cables are bench_chain's."""

from dataclasses import dataclass

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.measurement.run import Run, Sensors
from tests.support.bench_data import drum_angle
from tests.support.bench_effects import Effect
from tests.support.bench_motion import Plan, bench_run, chain_of

NOISE_RAD, STEP_RAD, TORQUE_NOISE_NM = 5e-7, 2e-7, 1e-3
EVERY = 2


@dataclass(frozen=True)
class TorqueSensor:
    """What the sensor shows of a load: low-pass of ``lag_s``, times 1 + ``gain``, plus ``zero_Nm``."""

    gain: float = 0.0
    zero_Nm: float = 0.0
    lag_s: float = 0.0

    def shown(self, load_Nm: np.ndarray, step_s: float) -> np.ndarray:
        out, now = load_Nm.copy(), load_Nm[0]
        share = 1.0 - np.exp(-step_s / self.lag_s) if self.lag_s else 1.0
        for k, value in enumerate(load_Nm):
            now += share * (value - now)
            out[k] = now
        return out * (1.0 + self.gain) + self.zero_Nm


def torque_bench(
    drive: Drive, sensor: TorqueSensor, effects: tuple[Effect, ...] = (), seed: int = 0, load: str = "steps"
) -> Run:
    """One run of the bench."""
    rng = np.random.default_rng(seed)
    plan = Plan(amplitude_rad=0.45, load=load, load_Nm=0.9, wave="sine", frequency_hz=0.1, duration_s=120.0)
    chain = chain_of(drive)
    ratio = float(np.mean(chain.r_drum / chain.r_in))
    bench = bench_run(plan, ratio, len(drive.input_names), rng)
    drum = drum_angle(chain, drive.input_names, bench, effects, rng)
    shown = sensor.shown(bench.load_Nm, float(bench.time_s[1] - bench.time_s[0]))
    at = slice(None, None, EVERY)
    n = bench.time_s[at].size
    return Run(
        bench.time_s[at],
        bench.input_rad[:, at],
        drum[at] + rng.normal(0.0, NOISE_RAD, n),
        shown[at] + rng.normal(0.0, TORQUE_NOISE_NM, n),
        sensors=Sensors(STEP_RAD, STEP_RAD, TORQUE_NOISE_NM, NOISE_RAD, NOISE_RAD),
        input_names=tuple(drive.input_names),
    )
