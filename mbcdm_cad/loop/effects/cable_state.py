"""Preload and friction of the cables, which determine how far the cables slip."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from mbcdm_cad.loop.effect import Effect, Figure, Parameter
from mbcdm_cad.loop.prepare.prepared import Prepared
from mbcdm_cad.loop.prepare.setup import Setup, Simulator
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.routes import Floats

SHARE = (Parameter("share", 0.02, -0.8, 4.0),)
# Starts of the fit: ropes settle and wear, and may lose more than half of the preload that was set.
PRELOAD_STARTS = ([0.0], [-0.4], [0.6])
FRICTION_STARTS = ([0.0], [-0.4], [1.0])
TENSION = "the tension of {cables} is {share} {way_share} than the design file says"
SEPARATE = "re-tension to a measured value and run again; friction stays as it was"


def _preload(indices: Sequence[int], setup: Setup, values: Floats, _: Simulator) -> Setup:
    d = setup.drive
    factor = np.ones(d.n_cables)
    factor[list(indices)] += values[0]
    return replace(setup, d=d.with_(preload_N=d.preload_N * factor))


def _friction(setup: Setup, values: Floats, _: Simulator) -> Setup:
    d = setup.drive
    return replace(setup, d=d.with_(friction_coefficient=d.friction_coefficient * (1.0 + values[0])))


def _from(starts: Sequence[Sequence[float]], setup: Setup, residual: Floats) -> list[list[float]]:
    return [list(start) for start in starts]


def offer(d: DriveSI | None, p: Prepared) -> list[Effect]:
    """With torque, where the drive is known."""
    if d is None or p.load_Nm is None:
        return []
    name = "preload_error"
    share = Figure("share", lambda v: float(v[0]))
    mean = Figure("preload_N", lambda v: float(np.mean(d.preload_N) * (1.0 + v[0])))
    each = [Figure("preload_N", lambda v, t=t: float(t * (1.0 + v[0]))) for t in d.preload_N]  # type: ignore[misc]
    mu = Figure("friction_coefficient", lambda v: float(d.friction_coefficient * (1.0 + v[0])))
    everything = Effect(
        name,
        "all cables",
        "the tension set at all tensioners differs: slip goes with 1/T_pre",
        "tension of each cable by plucking or a gauge",
        SEPARATE,
        SHARE,
        partial(_preload, range(d.n_cables)),
        starts=partial(_from, PRELOAD_STARTS),
        cables=d.cable_names,
        figures=(share, mean),
        physical=(mean,),
        plain=TENSION,
    )
    single = [
        Effect(
            name,
            "one cable",
            "the tension of one cable differs: its slip, and the balance of its input",
            f"tension of {cable} by plucking or a gauge",
            SEPARATE,
            SHARE,
            partial(_preload, (j,)),
            starts=partial(_from, PRELOAD_STARTS),
            cables=(cable,),
            figures=(share, each[j]),
            physical=(each[j],),
            plain=TENSION,
        )
        for j, cable in enumerate(d.cable_names)
    ]
    friction = Effect(
        "cable_friction",
        "rope on pulley",
        "mu differs: to second order only mu T_pre counts",
        "lubrication, wear and dirt on the wraps",
        SEPARATE,
        SHARE,
        _friction,
        starts=partial(_from, FRICTION_STARTS),
        figures=(share, mu),
        physical=(mu,),
        plain="the friction between rope and pulleys is {share} {way_share} than the design file says",
    )
    return [everything, *single, friction]
