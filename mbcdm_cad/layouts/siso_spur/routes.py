"""Routes of the cables: from the input on crossed or open spans to the drum (Fig. 1 a and b).

The origin is on the drum's axis (Y), in the middle of the winding on the first input. The axis of the first input is at
z = L; the axes of other inputs are turned about Y and moved along it; all are parallel. A continuous cable goes N times
round its input, is anchored nowhere on it, and runs to the drum on both sides as an internal tangent, or, with open
spans, as an external one. As long as a part of it sticks on the input, each side acts as a separate cable. Two anchored
cables replace these sides: they are wound outwards from the points where their spans leave, so that the spans converge
along Y.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import cos, sin

import numpy as np

from mbcdm_cad.layouts.siso_spur.drive import SpurDrive
from mbcdm_cad.layouts.siso_spur.idlers import SENSE, Circle, Strand, idler_body, no_strand, taut
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.geometry import DRUM_RADIUS, INPUT_RADIUS, AnchoredGeometry, RoutedDrive, Varied
from mbcdm_cad.routes.route import Anchor, Body, CableRoute, DriveRoutes, Piece, Span, Terminal, Wrap, input_body

DISTANCE = "centre_distance_m"
DRUM = "drum"
IDLER_RADIUS = "idler_radius_m"
_MM = 1e-3
_Y, _Z, _BACK = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)


@dataclass(frozen=True)
class SpurGeometry(AnchoredGeometry):
    """Spans from radii and centre distance. ``drum_side`` and ``outward`` (n_cables,) are those of the runs.

    ``angle_rad`` (n_inputs,): position of each input about Y, from +Z towards +X. ``level_m``: position along Y of each
    pair of runs, which are the sides of one continuous cable and follow each other.
    ``apart_m``: half the distance along Y at which two anchored cables leave an input; None for a continuous cable.
    ``input_sense``: -1 where the spans do not cross.
    ``idlers``: x and z in m of those of the side +x from the input on, with that input at +Z.
    """

    cable_names: tuple[str, ...]
    input_names: tuple[str, ...]
    input_of: tuple[int, ...]
    angle_rad: tuple[float, ...]
    level_m: tuple[float, ...]
    drum_side: tuple[int, ...]
    outward: tuple[int, ...]
    turns: int
    lead_m: float
    apart_m: float | None = None
    idlers: tuple[tuple[float, float], ...] = ()
    input_sense: int = 1
    varied: tuple[Varied, ...] = (
        Varied(DISTANCE, "centre distance", (67e-3, 70e-3, 75e-3, 85e-3, 100e-3), (68e-3, 80e-3)),
    )

    @property
    def per_cable(self) -> tuple[str, ...]:
        """Radii."""
        return (INPUT_RADIUS, DRUM_RADIUS, IDLER_RADIUS) if self.idlers else (INPUT_RADIUS, DRUM_RADIUS)

    @property
    def passed_radii(self) -> dict[str, str]:
        """The idlers of each cable, from the drum on; they all have one radius."""
        numbers = range(len(self.idlers), 0, -1)
        return {idler_body(n, cable): IDLER_RADIUS for n in numbers for cable in self.cable_names}

    def strand(self, parameters: Mapping[str, Floats]) -> Strand:
        """Paths from input to drum in m, mirrored to the side +x: (n_spans, n_cables, *batch)."""
        return taut(
            [
                Circle(0.0, parameters[DISTANCE], parameters[INPUT_RADIUS], -self.input_sense),
                *(Circle(x, z, parameters[IDLER_RADIUS], SENSE) for x, z in self.idlers),
                Circle(0.0, 0.0, parameters[DRUM_RADIUS], 1),
            ]
        )

    def free_span_m(self, parameters: Mapping[str, Floats]) -> Floats:
        """L_free, all spans; without idlers sqrt(L^2 - (r_o +- r_i)^2), Eq. (11); minus for open spans.

        NaN where pulleys overlap, or an idler is not touched.
        """
        found = self.strand(parameters)
        return np.where((found.wraps > 0.0).all(axis=0), found.length.sum(axis=0), np.nan)

    def passed_wrap_rad(self, parameters: Mapping[str, Floats]) -> tuple[Floats, ...]:
        """Wrap on each idler, which one cable alone passes."""
        wraps = self.strand(parameters).wraps if self.idlers else np.empty(0)
        found = []
        for n in range(len(self.idlers), 0, -1):
            for j in range(len(self.cable_names)):
                own = np.zeros_like(wraps[n - 1])
                own[j] = wraps[n - 1][j]
                found.append(own)
        return tuple(found)

    def through_wrap_rad(self, parameters: Mapping[str, Floats]) -> Floats | None:
        """N turns less the angles from the line of centres to both spans; (n_cables / 2, *batch). None if anchored."""
        if self.apart_m is not None:
            return None
        leaving = self.strand(parameters).leaving_rad
        return np.asarray(2 * np.pi * self.turns - (leaving[::2] + leaving[1::2]))

    def fault(self, parameters: Mapping[str, Floats]) -> str:
        """Message if the pulleys overlap, or the cable does not touch an idler, else empty."""
        if self.idlers:
            return no_strand(self.strand(parameters))
        reach = parameters[DRUM_RADIUS] + parameters[INPUT_RADIUS]
        return (
            f"free span: centre distance {np.min(parameters[DISTANCE]):.6g} m does not exceed r_o + r_i = "
            f"{np.max(reach):.6g} m, so the cable has no straight span; raise centre_distance_mm or cut the radii"
        )

    def routes(self, parameters: Mapping[str, Floats]) -> DriveRoutes:
        """Bodies and both sides of one design."""
        distance, ratio = float(parameters[DISTANCE]), parameters[DRUM_RADIUS] / parameters[INPUT_RADIUS]
        bodies = [Body(DRUM, "drum", (0.0, 0.0, 0.0), _Y, _Z, 1.0)]
        for i, (name, angle) in enumerate(zip(self.input_names, self.angle_rad, strict=True)):
            out = (sin(angle), 0.0, cos(angle))
            turns = float(np.mean(ratio[np.array(self.input_of) == i]))
            # With crossed spans the input turns against the drum, with open ones with it: its angle about this axis has
            # the sign of the drum's.
            axis = _BACK if self.input_sense > 0 else _Y
            bodies.append(
                Body(input_body(name), "input", (distance * out[0], 0.0, distance * out[2]), axis, out, turns)
            )
        bodies[1:1] = self._idler_bodies(parameters)
        found = self.strand(parameters)
        sides = tuple(self._side(parameters, j, found) for j in range(len(self.cable_names)))
        return DriveRoutes(tuple(bodies), sides)

    def _idler_bodies(self, parameters: Mapping[str, Floats]) -> Iterator[Body]:
        """The idlers, each turning about +Y against the drum."""
        for n in range(len(self.idlers), 0, -1):
            x, z = self.idlers[n - 1]
            for j, cable in enumerate(self.cable_names):
                angle = self.angle_rad[self.input_of[j]]
                turns = SENSE * float(parameters[DRUM_RADIUS][j] / parameters[IDLER_RADIUS][j])
                at, out = turned(angle, self.drum_side[j] * x, z), turned(angle, 0.0, 1.0)
                yield Body(idler_body(n, cable), "passed", at, _Y, out, turns)

    def _side(self, parameters: Mapping[str, Floats], j: int, found: Strand) -> CableRoute:
        """A side over its idlers, if there are any; it rises along Y by its slope, on all its way."""
        side, cable = self.drum_side[j], self.cable_names[j]
        input_name, level = self.input_names[self.input_of[j]], self.level_m[j // 2]
        r_i, r_o = float(parameters[INPUT_RADIUS][j]), float(parameters[DRUM_RADIUS][j])
        through, apart, rises = self._winding(parameters, j)
        slope, at = rises * self.lead_m / (2 * np.pi * r_i), level + self.outward[j] * apart
        name = input_body(input_name)
        pieces: list[Piece] = [
            Anchor(name),
            # Heights count along the input's own axis, -Y, or Y with open spans.
            Wrap(name, r_i, np.inf, -self.input_sense * at, side, may_slip_through=through, lead_m=self.lead_m),
        ]
        for n in range(1, len(self.idlers) + 1):
            span, wrap = float(found.length[n - 1, j]), float(found.wraps[n - 1, j])
            r_k = float(parameters[IDLER_RADIUS][j])
            pieces.append(Span(span, self._direction(side, found, n - 1, j)))
            at += slope * (span + r_k * wrap / 2)
            pieces.append(Wrap(idler_body(n, cable), r_k, wrap, at, side * SENSE, passed=True))
            at += slope * r_k * wrap / 2
        last = float(found.length[-1, j])
        pieces += [
            Span(last, self._direction(side, found, -1, j)),
            Wrap(DRUM, r_o, np.inf, at + slope * last, side, lead_m=self.lead_m * r_o / r_i),
            Terminal(DRUM),
        ]
        return CableRoute(cable, input_name, self.sense[j], tuple(pieces))

    def _winding(self, parameters: Mapping[str, Floats], j: int) -> tuple[bool, float, int]:
        """Whether a cable may slip through on its input; how far a side leaves it from the cable's middle, m; and the
        sense along Y in which the side goes on from there."""
        through = self.through_wrap_rad(parameters)
        if through is None:
            return False, self.apart_m or 0.0, -self.outward[j]
        return True, self.lead_m * float(through[j // 2]) / (4 * np.pi), self.outward[j]

    def _direction(self, side: int, found: Strand, span: int, j: int) -> tuple[float, float, float]:
        heading = float(found.heading[span, j])
        return turned(self.angle_rad[self.input_of[j]], side * sin(heading), cos(heading))


def turned(angle_rad: float, x: float, z: float) -> tuple[float, float, float]:
    """A vector given with its input above the drum, where the input stands at this angle from +Z towards +X."""
    return x * cos(angle_rad) + z * sin(angle_rad), 0.0, z * cos(angle_rad) - x * sin(angle_rad)


def routed(drive: SpurDrive, unit: float = _MM) -> RoutedDrive:
    """The routes of ``drive``, and the lengths that follow from its file; ``unit``: a mm, in m."""
    geometry = SpurGeometry(
        cable_names=tuple(run.name for run in drive.cables),
        input_names=tuple(drive.input_names),
        input_of=tuple(drive.input_names.index(run.input_name) for run in drive.cables),
        angle_rad=drive.angles_rad[: len(drive.input_names)],
        level_m=tuple((drive.level_mm + level) * unit for level in drive.levels_mm),
        drum_side=tuple(run.drum_side for run in drive.cables),
        outward=tuple(run.outward for run in drive.cables),
        turns=drive.turns,
        lead_m=drive.helix_lead_mm * unit,
        apart_m=drive.leave_mm * unit if drive.anchored else None,
        idlers=tuple((p.x_mm * unit, p.z_mm * unit) for p in drive.idler_places),
        input_sense=drive.input_sense,
    )
    parameters = {
        INPUT_RADIUS: np.array([run.input_radius_mm * unit for run in drive.cables]),
        DRUM_RADIUS: np.array([run.drum_radius_mm * unit for run in drive.cables]),
        DISTANCE: np.asarray(drive.centre_distance_mm * unit),
    }
    if drive.idlers:
        parameters[IDLER_RADIUS] = np.full(len(drive.cables), drive.idlers.radius_mm * unit)
    return RoutedDrive(geometry, parameters, {"centre_distance_mm": drive.centre_distance_mm})
