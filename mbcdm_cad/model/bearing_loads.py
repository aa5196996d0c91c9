"""Loads that the cable tensions put on every body of a drive; the vector sums are in :mod:`mbcdm_cad.routes.loads`."""

from __future__ import annotations

from dataclasses import dataclass

from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.loads import BodyLoad, body_load, two_bearing_reactions_N

__all__ = ["BearingLoads", "BodyLoad", "bearing_loads", "two_bearing_reactions_N"]


@dataclass(frozen=True)
class BearingLoads:
    """The load on each body, by name."""

    bodies: dict[str, BodyLoad]
    inputs: tuple[BodyLoad, ...]
    drum: BodyLoad


def bearing_loads(d: DriveSI, tension_N: Floats) -> BearingLoads:
    """Loads for the free-span tensions of one design and one load, shape (n_cables,)."""
    loads = {body.name: body_load(d.routes, body.name, tension_N) for body in d.routes.bodies}
    return BearingLoads(loads, tuple(loads[body.name] for body in d.routes.inputs), loads[d.routes.drum.name])
