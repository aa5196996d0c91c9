"""How the cable runs: round the input, crossed over to the drum, both ends on the drum (Fig. 1 a).

Origin on the drum's axis (Y), in the middle of what the cable takes of the input; the input's axis stands at z = L,
parallel. One cable goes N times round the input, is anchored nowhere on it, and crosses to the drum as an internal
tangent on both sides. As long as a part of it sticks on the input, each side acts as a cable of its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mbcdm_cad.configurations.siso_spur.drive import SpurDrive
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.geometry import DRUM_RADIUS, INPUT_RADIUS, RoutedDrive, Varied, tangent_length_m
from mbcdm_cad.routes.route import Anchor, Body, CableRoute, DriveRoutes, Span, Terminal, Wrap, input_body

DISTANCE = "centre_distance_m"
DRUM = "drum"
_MM = 1e-3
_Y, _Z, _BACK = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)


@dataclass(frozen=True)
class SpurGeometry:
    """Crossed spans from radii and centre distance. ``drum_side`` and ``outward`` (n_cables,) as of the runs."""

    cable_names: tuple[str, ...]
    input_names: tuple[str, ...]
    drum_side: tuple[int, ...]
    outward: tuple[int, ...]
    turns: int
    lead_m: float
    per_cable: tuple[str, ...] = (INPUT_RADIUS, DRUM_RADIUS)
    varied: tuple[Varied, ...] = (
        Varied(DISTANCE, "centre distance", (67e-3, 70e-3, 75e-3, 85e-3, 100e-3), (68e-3, 80e-3)),
    )

    @property
    def input_of(self) -> tuple[int, ...]:
        """Both sides run from the one input."""
        return (0,) * len(self.cable_names)

    @property
    def sense(self) -> tuple[int, ...]:
        """The side that runs towards +x turns the drum negative about +Y."""
        return tuple(-side for side in self.drum_side)

    @property
    def passed_radii(self) -> dict[str, str]:
        """The cable passes no other body."""
        return {}

    def free_span_m(self, parameters: Mapping[str, Floats]) -> Floats:
        """L_free = sqrt(L^2 - (r_o + r_i)^2), Eq. (11)."""
        return tangent_length_m(parameters[DISTANCE], parameters[INPUT_RADIUS] + parameters[DRUM_RADIUS])

    def passed_wrap_rad(self, parameters: Mapping[str, Floats]) -> tuple[Floats, ...]:
        """None."""
        return ()

    def through_wrap_rad(self, parameters: Mapping[str, Floats]) -> Floats:
        """N turns less the angles from the line of centres to both landings; (1, *batch)."""
        reach = (parameters[INPUT_RADIUS] + parameters[DRUM_RADIUS]) / parameters[DISTANCE]
        with np.errstate(invalid="ignore"):
            return np.asarray(2 * np.pi * self.turns - np.arccos(reach).sum(axis=0))[None]

    def fault(self, parameters: Mapping[str, Floats]) -> str:
        """The pulleys overlap."""
        reach = parameters[DRUM_RADIUS] + parameters[INPUT_RADIUS]
        return (
            f"free span: centre distance {np.min(parameters[DISTANCE]):.6g} m does not exceed r_o + r_i = "
            f"{np.max(reach):.6g} m, so the cable has no straight span; raise centre_distance_mm or cut the radii"
        )

    def routes(self, parameters: Mapping[str, Floats]) -> DriveRoutes:
        """Bodies and both sides of one design."""
        name, distance = input_body(self.input_names[0]), float(parameters[DISTANCE])
        ratio = float(np.mean(parameters[DRUM_RADIUS] / parameters[INPUT_RADIUS]))
        bodies = (
            Body(DRUM, "drum", (0.0, 0.0, 0.0), _Y, _Z, 1.0),
            # Crossed, it turns against the drum, in one sense with it about -Y.
            Body(name, "input", (0.0, 0.0, distance), _BACK, _Z, ratio),
        )
        free = self.free_span_m(parameters)
        cables = tuple(self._side(parameters, j, float(free[j])) for j in range(len(self.cable_names)))
        return DriveRoutes(bodies, cables)

    def _side(self, parameters: Mapping[str, Floats], j: int, free_m: float) -> CableRoute:
        side, name = self.drum_side[j], input_body(self.input_names[0])
        r_i, r_o = float(parameters[INPUT_RADIUS][j]), float(parameters[DRUM_RADIUS][j])
        distance = float(parameters[DISTANCE])
        cosine, sine = (r_o + r_i) / distance, free_m / distance
        through = self.through_wrap_rad(parameters)
        leave = self.outward[j] * self.lead_m * float(through[0]) / (4 * np.pi)
        land = leave + self.outward[j] * self.lead_m / (2 * np.pi * r_i) * free_m
        pieces = (
            Anchor(name),
            # Heights count along the input's own axis, -Y.
            Wrap(name, r_i, np.inf, -leave, side, may_slip_through=True, lead_m=self.lead_m),
            Span(free_m, (side * cosine, 0.0, -sine)),
            Wrap(DRUM, r_o, np.inf, land, side),
            Terminal(DRUM),
        )
        return CableRoute(self.cable_names[j], self.input_names[0], self.sense[j], pieces)


def routed(drive: SpurDrive) -> RoutedDrive:
    """How the cable of ``drive`` runs, and the lengths that follow from its file."""
    geometry = SpurGeometry(
        cable_names=tuple(run.name for run in drive.cables),
        input_names=tuple(drive.input_names),
        drum_side=tuple(run.drum_side for run in drive.cables),
        outward=tuple(run.outward for run in drive.cables),
        turns=drive.turns,
        lead_m=drive.helix_lead_mm * _MM,
    )
    parameters = {
        INPUT_RADIUS: np.array([run.input_radius_mm * _MM for run in drive.cables]),
        DRUM_RADIUS: np.array([run.drum_radius_mm * _MM for run in drive.cables]),
        DISTANCE: np.asarray(drive.centre_distance_mm * _MM),
    }
    return RoutedDrive(geometry, parameters, {"centre_distance_mm": drive.centre_distance_mm})
