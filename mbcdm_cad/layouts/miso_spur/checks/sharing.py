"""Shares of the inputs in the load of the drum, which follow from the stiffness of their cables."""

from __future__ import annotations

import numpy as np

from mbcdm_cad.checks.comparison import Check, Comparison, at_most, worst
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.layouts.miso_spur.layout import RoundDrumLayout

# Largest torque of an input over the mean (a choice: reserve of its motor compared with the others).
LARGEST_OVER_MEAN = 1.1


def load_shares(s: RoundDrumLayout) -> np.ndarray:
    """Share (2, n_inputs) of the peak torque, each direction, that every input takes besides its bias torque."""
    idle, forward, back, *_ = s.loads.input_torque_Nm
    taken = np.stack([forward - idle, back - idle])
    return np.asarray(taken / taken.sum(axis=1, keepdims=True))


def sharing(s: RoundDrumLayout) -> Comparison:
    """Torque of the most loaded input at peak torque over the mean of all inputs."""
    shares = load_shares(s)
    listed = ", ".join(f"{name} {share:.1%}" for name, share in zip(s.drive.input_names, shares[0], strict=True))
    return worst(
        at_most(
            f"torque of the {s.drive.input_names[int(way.argmax())]} input over the mean of all at peak torque",
            float(way.max()) * s.drive.n_inputs,
            LARGEST_OVER_MEAN,
            "times",
            f"shares {listed}, by the stiffness of the cables while the inputs are held",
        )
        for way in shares
    )


CHECKS = (
    Check(
        "load_sharing",
        "Shares of the inputs in the load",
        "model; 1.1: a choice",
        sharing,
        "warn",
        adjust=(up("rope.preload_N"), down("loads.peak_torque_Nm")),
        advice="leave out preload_N of single entries of cables, so that rope.preload_N is that of all",
    ),
)
