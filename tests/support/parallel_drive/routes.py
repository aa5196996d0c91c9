"""Routes of the cables of the parallel drive: a wrap on the input, a crossed span, a wrap on the drum.

The span of a cable that turns the drum in the sense s_d = -sigma has the direction (-cos beta, 0, -s_d sin beta) with
sin beta = (r_o + r_i)/L, so that both ends touch their pulleys (derived).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.geometry import DRUM_RADIUS, INPUT_RADIUS, RoutedDrive, Varied, tangent_length_m
from mbcdm_cad.routes.route import Anchor, Body, CableRoute, DriveRoutes, Span, Terminal, Wrap, input_body
from parallel_drive.design_file import ParallelDrive
from parallel_drive.layout import height_mm

DISTANCE = "centre_distance_m"
_MM = 1e-3


@dataclass(frozen=True)
class ParallelGeometry:
    """See :class:`mbcdm_cad.routes.geometry.Geometry`."""

    cable_names: tuple[str, ...]
    input_names: tuple[str, ...]
    input_of: tuple[int, ...]
    sense: tuple[int, ...]
    heights_m: tuple[float, ...]
    per_cable: tuple[str, ...] = (INPUT_RADIUS, DRUM_RADIUS)
    varied: tuple[Varied, ...] = (Varied(DISTANCE, "centre distance", (45e-3, 50e-3, 60e-3), (48e-3, 60e-3)),)

    @property
    def passed_radii(self) -> dict[str, str]:
        """No cable passes a body."""
        return {}

    def free_span_m(self, parameters: Mapping[str, Floats]) -> Floats:
        """Crossed tangent."""
        return tangent_length_m(parameters[DISTANCE], parameters[INPUT_RADIUS] + parameters[DRUM_RADIUS])

    def passed_wrap_rad(self, parameters: Mapping[str, Floats]) -> tuple[Floats, ...]:
        """None."""
        return ()

    def through_wrap_rad(self, parameters: Mapping[str, Floats]) -> None:
        """Every cable is anchored on its input."""

    def fault(self, parameters: Mapping[str, Floats]) -> str:
        """The pulleys overlap."""
        return "free span: centre distance does not exceed r_o + r_i; raise centre_distance_mm or cut the radii"

    def routes(self, parameters: Mapping[str, Floats]) -> DriveRoutes:
        """Two bodies, two cables."""
        drum, pulley = parameters[DRUM_RADIUS], parameters[INPUT_RADIUS]
        distance, body = float(parameters[DISTANCE]), input_body(self.input_names[0])
        bodies = (
            Body("drum", "drum", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0), 1.0),
            Body(body, "input", (distance, 0.0, 0.0), (0.0, -1.0, 0.0), (1.0, 0.0, 0.0), float(np.mean(drum / pulley))),
        )
        spans = self.free_span_m(parameters)
        cables = []
        for k, name in enumerate(self.cable_names):
            turning, sine = -self.sense[k], float((drum[k] + pulley[k]) / distance)
            cosine = float(np.sqrt(max(1.0 - sine**2, 0.0)))
            height = self.heights_m[k]
            pieces = (
                Anchor(body),
                # About the input's own axis, -Y, the crossed cable turns as it does on the drum about +Y.
                Wrap(body, float(pulley[k]), np.inf, -height, turning),
                Span(float(spans[k]), (-cosine, 0.0, -turning * sine)),
                Wrap("drum", float(drum[k]), np.inf, height, turning),
                Terminal("drum"),
            )
            cables.append(CableRoute(name, self.input_names[0], self.sense[k], pieces))
        return DriveRoutes(bodies, tuple(cables))


def routed(drive: Drive) -> RoutedDrive:
    """Geometry and lengths of one design."""
    assert isinstance(drive, ParallelDrive)
    geometry = ParallelGeometry(
        cable_names=tuple(run.name for run in drive.cables),
        input_names=tuple(drive.input_names),
        input_of=(0,) * len(drive.cables),
        sense=tuple(run.sigma for run in drive.cables),
        heights_m=tuple(height_mm(run) * _MM for run in drive.cables),
    )
    parameters = {
        INPUT_RADIUS: np.array([run.input_radius_mm * _MM for run in drive.cables]),
        DRUM_RADIUS: np.array([run.drum_radius_mm * _MM for run in drive.cables]),
        DISTANCE: np.asarray(drive.centre_distance_mm * _MM),
    }
    return RoutedDrive(geometry, parameters, {"centre_distance_mm": drive.centre_distance_mm})
