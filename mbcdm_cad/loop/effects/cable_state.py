"""Preload and friction of the cables, which determine how far the cables slip."""

from dataclasses import replace
from functools import partial

import numpy as np

from mbcdm_cad.loop.effect import Effect, Effects, Figure, Parameter
from mbcdm_cad.loop.prepare.setup import DriveSI, Floats, Prepared, Setup, Simulator

SHARE = (Parameter("share", 0.02, -0.8, 4.0),)
# Starts of the fit: ropes settle and wear, and may lose more than half of the preload that was set.
PRELOAD_STARTS = ([0.0], [-0.4], [0.6])
FRICTION_STARTS = ([0.0], [-0.4], [1.0])
SEPARATE = "re-tension to a measured value and run again; friction stays as it was"


def _preload(indices: list[int], setup: Setup, values: Floats, _: Simulator) -> Setup:
    d = setup.drive
    factor = np.ones(d.n_cables)
    factor[indices] += values[0]
    return replace(setup, d=d.with_(preload_N=d.preload_N * factor))


def _friction(setup: Setup, values: Floats, _: Simulator) -> Setup:
    d = setup.drive
    return replace(setup, d=d.with_(friction_coefficient=d.friction_coefficient * (1.0 + values[0])))


def offer(d: DriveSI | None, p: Prepared) -> Effects:
    """With torque, where the drive is known."""
    if d is None or p.load_Nm is None:
        return
    share = Figure("share", lambda v: float(v[0]))

    def preload(form: str, physics: str, where: str, indices: list[int], cables: tuple[str, ...]) -> Effect:
        tension = Figure("preload_N", lambda v: float(np.mean(d.preload_N[indices]) * (1.0 + v[0])))
        return Effect(
            "preload_error",
            form,
            physics,
            where,
            SEPARATE,
            SHARE,
            partial(_preload, indices),
            starts=lambda setup, residual: [list(start) for start in PRELOAD_STARTS],
            cables=cables,
            figures=(share, tension),
            physical=(tension,),
            plain="the tension of {cables} is {share} {way_share} than the design file says",
        )

    everywhere = "the tension set at all tensioners differs: slip goes with 1/T_pre"
    every = list(range(d.n_cables))
    yield preload("all cables", everywhere, "tension of each cable by plucking or a gauge", every, d.cable_names)
    for j, cable in enumerate(d.cable_names):
        here = "the tension of one cable differs: its slip, and the balance of its input"
        yield preload("one cable", here, f"tension of {cable} by plucking or a gauge", [j], (cable,))
    mu = Figure("friction_coefficient", lambda v: float(d.friction_coefficient * (1.0 + v[0])))
    yield Effect(
        "cable_friction",
        "rope on pulley",
        "mu differs: to second order only mu T_pre counts",
        "lubrication, wear and dirt on the wraps",
        SEPARATE,
        SHARE,
        _friction,
        starts=lambda setup, residual: [list(start) for start in FRICTION_STARTS],
        figures=(share, mu),
        physical=(mu,),
        plain="the friction between rope and pulleys is {share} {way_share} than the design file says",
    )
