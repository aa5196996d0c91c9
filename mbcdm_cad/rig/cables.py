"""A cable of the rig as built, in SI; it may differ from the design file."""

from __future__ import annotations

import math
from dataclasses import dataclass

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.routes.route import CableRoute, DriveRoutes, Wrap


@dataclass(frozen=True)
class RigCable:
    """One cable, SI. ``sigma``: sense in which its tension turns the drum; ``input_index``: the input on which it runs.

    ``route`` is its route in the design; the radii of input and drum are those as built. ``own_wrap_rad`` is this
    side's half of a wrap over the input that only friction holds; 0 where the cable counts as anchored there.
    ``anchor_m_N``: how far its end on the drum gives way for each newton there, by springs.
    """

    name: str
    sigma: int
    input_index: int
    input_radius_m: float
    drum_radius_m: float
    stiffness_N: float  # E A
    preload_N: float
    friction: float
    route: CableRoute
    own_wrap_rad: float = 0.0
    anchor_m_N: float = 0.0

    @property
    def free_span_m(self) -> float:
        """Free span L_free of the design, m."""
        return self.route.free_length_m

    @property
    def passed(self) -> tuple[Wrap, ...]:
        """The wraps on bodies between input and drum."""
        return self.route.passed


def routes_of(drive: Drive) -> DriveRoutes:
    """The routes of the cables of ``drive``. Raises ValueError where the geometry leaves no free span."""
    found = drive.layout.routed
    routes = found.routes
    if any(math.isnan(route.free_length_m) for route in routes.cables):
        raise ValueError(found.geometry.fault(found.parameters))
    return routes


def cables_of(drive: Drive) -> tuple[RigCable, ...]:
    """The cables with the values of the design file. Raises ValueError where the geometry leaves no free span."""
    routes = routes_of(drive)
    return tuple(
        RigCable(
            name=route.cable,
            sigma=route.sense,
            input_index=drive.input_names.index(route.input_name),
            input_radius_m=route.input_radius_m,
            drum_radius_m=route.drum_radius_m,
            stiffness_N=drive.cable.axial_stiffness_N,
            preload_N=run.preload_N,
            friction=drive.friction_coefficient,
            route=route,
            anchor_m_N=drive.anchor_m_N,
        )
        for run, route in zip(drive.cables, routes.cables, strict=True)
    )
