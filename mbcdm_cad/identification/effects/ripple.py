"""A periodic error in angle whose order is not known beforehand."""

from __future__ import annotations

import numpy as np

from mbcdm_cad.identification.effect import Effect, Figure, Parameter, length, pair, phase
from mbcdm_cad.identification.lines import strongest_orders
from mbcdm_cad.identification.prepared import Prepared
from mbcdm_cad.identification.setup import Setup, Simulator
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.routes import Floats


def _apply(setup: Setup, values: Floats, _: Simulator) -> Setup:
    # The output's own encoder has the finest phase; a fast order would be blurred by a smoothed angle.
    reading = setup.p.output_rad
    angle = values[2] * (reading - np.mean(reading - setup.drum_rad))
    return setup.with_added(values[0] * np.cos(angle) - values[1] * np.sin(angle))


def _starts(setup: Setup, residual: Floats) -> list[list[float]]:
    return [[0.0, 0.0, order] for order in strongest_orders(setup, residual)]


def offer(d: DriveSI | None, p: Prepared) -> list[Effect]:
    """Always."""
    order = Parameter("cycles_per_output_rev", 0.05, 2.0, role="order")
    return [
        Effect(
            "ripple",
            "line in angle",
            "something turns or meshes so many times a turn of the output",
            "gear meshes, motor turns, encoder sub-division of that order",
            "the same travel at another speed",
            (*pair(1e-6, "rad"), order),
            _apply,
            starts=_starts,
            figures=(
                Figure("cycles_per_output_rev", lambda v: float(v[2])),
                Figure("amplitude_rad", length),
                Figure("phase_rad", phase),
            ),
            several=True,
            plain="the output reading ripples by {amplitude_rad}, {cycles_per_output_rev} times a turn of the drum",
        )
    ]
