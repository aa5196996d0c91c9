"""A periodic error in angle whose order is not known beforehand."""

from dataclasses import replace
from functools import partial

import numpy as np

from mbcdm_cad.loop.effect import Effect, Effects, Figure, Parameter, length, pair, phase
from mbcdm_cad.loop.prepare.setup import MOST_ORDER, Prepared, Setup, Simulator, input_shares, strongest_orders
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.routes import Floats


def _inside(values: Floats, setup: Setup) -> Floats:
    """The same line over a smoothed angle, since the cables are simulated with it."""
    angle = values[2] * setup.drum_rad
    return np.asarray(values[0] * np.cos(angle) - values[1] * np.sin(angle))


def _at_input(index: int, setup: Setup, values: Floats, _: Simulator) -> Setup:
    setup = setup.following(values[2] / setup.ratio)
    share = float(input_shares(setup.drive)[index])
    return setup.with_shift(index, setup.ratio / share * _inside(values, setup))


def _in_path(cable: int, setup: Setup, values: Floats, _: Simulator) -> Setup:
    setup = setup.following(values[2] / setup.ratio)
    d = setup.drive
    stiffness = d.drum_radius_m / d.free_span_m
    lever = float((stiffness * d.drum_radius_m).sum() / (d.sigma * stiffness)[cable])
    path = np.zeros((d.n_cables, setup.p.time_s.size))
    path[cable] = lever * _inside(values, setup)
    return setup.with_path(path)


def offer(d: DriveSI | None, p: Prepared) -> Effects:
    """Always as an error of the reading; with torque as a motion of each input and in the path of each cable."""
    order = Parameter("cycles_per_output_rev", 0.05, 2.0, MOST_ORDER, role="order")
    reading = Effect(
        "ripple",
        "line in angle",
        "something turns or meshes so many times a turn of the output",
        "gear meshes, motor turns, encoder sub-division of that order",
        "the same travel at another speed",
        (*pair(1e-6, "rad"), order),
        lambda s, v, _: s.with_line((float(v[0]), float(v[1]), float(v[2]))),
        starts=lambda s, residual: [[0.0, 0.0, order] for order in strongest_orders(s, residual)],
        figures=(
            Figure("cycles_per_output_rev", lambda v: float(v[2])),
            Figure("amplitude_rad", length),
            Figure("phase_rad", phase),
        ),
        several=True,
        plain="the output reading ripples by {amplitude_rad}, {cycles_per_output_rev} times a turn of the drum",
    )
    yield reading
    if d is None or p.load_Nm is None:
        return
    inputs = [
        (f"motion of input {name}", f"gearhead of input {name}, then the others", partial(_at_input, k))
        for k, name in enumerate(d.input_names)
    ]
    paths = [
        (f"path of {name}", f"strands of {name}, or of another, on the pulleys", partial(_in_path, k))
        for k, name in enumerate(d.cable_names)
    ]
    yield from (
        replace(
            reading,
            form=form,
            physics="a ripple inside the drive: it moves the cables to and fro and eases their friction",
            where_to_look=where,
            apply=apply,
            inside=True,
            plain="a part of the drive makes the drum ripple by {amplitude_rad}, {cycles_per_output_rev} times a turn",
        )
        for form, where, apply in inputs + paths
    )
