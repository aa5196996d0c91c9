"""How the inputs share the load of the drum: by the stiffness of their cables, wherever the inputs are held."""

from __future__ import annotations

import numpy as np

from mbcdm_cad.checks.comparison import Check, Comparison, at_most, worst
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.configurations.miso_spur.design_under_test import RoundDrumUnderTest

# Torque of the most loaded input over the mean (a choice: what a motor has in reserve beside the others).
LARGEST_OVER_MEAN = 1.1


def load_shares(s: RoundDrumUnderTest) -> np.ndarray:
    """Share (2, n_inputs) of peak torque, each way, that every input takes beyond what it holds without a load."""
    idle, forward, back, *_ = s.loads.input_torque_Nm
    taken = np.stack([forward - idle, back - idle])
    return np.asarray(taken / taken.sum(axis=1, keepdims=True))


def sharing(s: RoundDrumUnderTest) -> Comparison:
    """The input that takes most of peak torque against the mean."""
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
        "Inputs share the load",
        "model; 1.1: a choice",
        sharing,
        "warn",
        adjust=(up("rope.preload_N"), down("loads.peak_torque_Nm")),
        advice="give all cables the same preload",
    ),
)
