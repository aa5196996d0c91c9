"""Generic regressors: curves of load or speed without a name, one coefficient each.

Several effects of the library together can imitate such a curve: a compliance that grows with the load looks like a
soft shaft with some friction and a preload error. Where one regressor alone explains as much as the named effects, the
names are withdrawn and the verdict is unknown.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mbcdm_cad.loop.effect import Effect, Parameter
from mbcdm_cad.loop.prepare.setup import Setup, Simulator
from mbcdm_cad.routes import Floats


def _regressor(form: str, unit: str, size: float, shape: Callable[[Setup], Floats]) -> Effect:
    def apply(setup: Setup, values: Floats, _: Simulator) -> Setup:
        return setup.with_added(values[0] * shape(setup))

    return Effect("unknown", form, f"goes with the {form}", "", "", (Parameter(f"coefficient_{unit}", size),), apply)


def regressors(loaded: bool) -> tuple[Effect, ...]:
    """The regressors: of speed always, of load if it was measured."""
    of_speed = (
        _regressor("square of the speed", "rad_s2", 1e-4, lambda s: s.p.speed_rad_s**2),
        _regressor(
            "square of the speed with its sign", "rad_s2", 1e-4, lambda s: np.abs(s.p.speed_rad_s) * s.p.speed_rad_s
        ),
    )
    if not loaded:
        return of_speed
    return (
        _regressor("square of the load with its sign", "rad_Nm2", 1e-6, lambda s: s.load * np.abs(s.load)),
        _regressor("square of the load", "rad_Nm2", 1e-6, lambda s: s.load**2),
        *of_speed,
    )
