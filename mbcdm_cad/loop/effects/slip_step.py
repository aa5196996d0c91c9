"""An anchor or a mount that slipped once: a step in time."""

from functools import partial

import numpy as np

from mbcdm_cad.loop.effect import Effect, Effects, Parameter, best_step, elapsed_s
from mbcdm_cad.loop.prepare.setup import DriveSI, Floats, Prepared, Setup, Simulator

# Duration of a step: an estimate, far shorter than the fit can resolve.
RISE_S = 0.02
# Largest slip of an anchor, in multiples of the stretch that the preload causes.
MOST_STRETCHES = 5.0
SEPARATE = "run again: a step does not come twice"


def step(setup: Setup, at_s: float) -> Floats:
    """0 before, 1 after."""
    return np.asarray(0.5 + 0.5 * np.tanh((elapsed_s(setup) - at_s) / (2.0 * RISE_S)))


def _anchor(cable: int, setup: Setup, values: Floats, _: Simulator) -> Setup:
    path = np.zeros((setup.drive.n_cables, setup.p.time_s.size))
    path[cable] = -values[0] * step(setup, values[1])
    return setup.with_path(path)


def _jumps(size: float, setup: Setup, residual: Floats) -> list[list[float]]:
    """Where one step explains the residual best."""
    used = setup.p.used
    return [[size, best_step(elapsed_s(setup)[used], residual[used])]]


def offer(d: DriveSI | None, p: Prepared) -> Effects:
    """At the output's mount always; at a cable's anchor where the drive is known and loaded."""
    duration = float(p.time_s[-1] - p.time_s[0])
    when = Parameter("at_s", 0.02, 0.0, duration, role="place")
    yield Effect(
        "slip_step",
        "mount or coupling",
        "the output's reading jumps once",
        "screws of encoder, hub and coupling",
        SEPARATE,
        (Parameter("step_rad", 1e-5), when),
        lambda s, v, _: s.with_added(v[0] * step(s, v[1])),
        starts=partial(_jumps, 0.0),
        once=True,
        hangs_on="time",
        plain="a mount or coupling of the output slipped once, by {step_rad} at {at_s}",
    )
    if d is not None and p.load_Nm is not None:
        # More than a few times the stretch under preload is no longer a slip of the anchor.
        most = MOST_STRETCHES * d.preload_N / d.axial_stiffness_N * d.free_span_m
        yield from (
            Effect(
                "slip_step",
                f"anchor of {cable}",
                "one cable gives way at its anchor and loses tension",
                f"anchor and tensioner of {cable}",
                SEPARATE,
                (Parameter("slip_m", 1e-6, -most[j], most[j]), when),
                partial(_anchor, j),
                starts=partial(_jumps, 0.0),
                once=True,
                hangs_on="time",
                plain="the {form} slipped once, by {slip_m} at {at_s}",
            )
            for j, cable in enumerate(d.cable_names)
        )
