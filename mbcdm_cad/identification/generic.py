"""Shapes without a name, one coefficient each: what several names of the vocabulary can imitate between them.

A compliance that grows with the load looks like a soft shaft with some friction and a preload to go with it. Where one
of these shapes does alone what the names do, the names are taken back and the verdict is unknown.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mbcdm_cad.identification.effects.base import Effect, Parameter
from mbcdm_cad.identification.setup import Setup, Simulator
from mbcdm_cad.measurement.run import Floats

# Names that a shape of load or speed can be mistaken for. Winding history is not: nothing else has its drift.
MISTAKEN = ("stiffness_error", "preload_error", "cable_friction", "friction", "delay", "lash", "slip_step")


def _decoy(form: str, unit: str, size: float, shape: Callable[[Setup], Floats]) -> Effect:
    def apply(setup: Setup, values: Floats, _: Simulator) -> Setup:
        return setup.with_added(values[0] * shape(setup))

    return Effect("unknown", form, f"goes with the {form}", "", "", (Parameter(f"coefficient_{unit}", size),), apply)


def decoys(loaded: bool) -> tuple[Effect, ...]:
    """The shapes: of speed always, of load where it was measured."""
    of_speed = (
        _decoy("square of the speed", "rad_s2", 1e-4, lambda s: s.p.speed_rad_s**2),
        _decoy(
            "square of the speed with its sign", "rad_s2", 1e-4, lambda s: np.abs(s.p.speed_rad_s) * s.p.speed_rad_s
        ),
    )
    if not loaded:
        return of_speed
    return (
        _decoy("square of the load with its sign", "rad_Nm2", 1e-6, lambda s: s.load * np.abs(s.load)),
        _decoy("square of the load", "rad_Nm2", 1e-6, lambda s: s.load**2),
        *of_speed,
    )
