"""Runs of the benches of bench_real.py in which an effect begins in mid-run, at once or evenly.

The run with the effect and its twin without have the same motion, load and noise; the readings of the output go from
one to the other. The loop is written for drives that simulate the whole run with either figure; so are these benches,
but by other code, with other steps, noise and loggers.
"""

from dataclasses import replace

import numpy as np

from mbcdm_cad.design.drive import Drive
from tests.support.bench_data import Simulated, stream
from tests.support.bench_real import simulate_real

# Cases whose effect begins in mid-run, and the name of the effect that changes.
CHANGES = {
    "modulus_low": "stiffness_error",
    "preload_low": "preload_error",
    "mu_low": "cable_friction",
    "friction": "friction",
    "lash_output": "lash",
    "ratio_encoder": "ratio_error",
    "stiffness_shaft": "stiffness_error",
}
BEGINS = (0.3, 0.7)
TRANSITION_S = 0.05


def simulate_change(drive: Drive, case: str, seed: int, evenly: bool = False) -> tuple[Simulated, float]:
    """The run, and the time at which the effect begins, s."""
    with_it, without = simulate_real(drive, case, seed), simulate_real(drive, case, seed, without_effects=True)
    t = with_it.bench.time_s
    at = float(stream(case, seed, "change").uniform(*BEGINS)) * float(t[-1])
    weight = t / t[-1] if evenly else np.clip((t - at) / TRANSITION_S, 0.0, 1.0)
    step = float(np.min(np.diff(np.unique(with_it.sensed["output"]))))
    blended = (1.0 - weight) * without.sensed["output"] + weight * with_it.sensed["output"]
    sensed = {**with_it.sensed, "output": np.round(blended / step) * step}
    return replace(with_it, sensed=sensed, drum_rad=sensed["output"]), at
