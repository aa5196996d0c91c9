"""The cable's way from the input to the drum on crossed or open spans (Fig. 1 a and b): model routes, drawn line.

The origin is on the drum's axis (Y), in the middle of the winding on the first input. The axis of the first input is at
z = L; the axes of other inputs are turned about Y and moved along it; all are parallel. A continuous cable goes N times
round its input, is anchored nowhere on it, and runs to the drum on both sides as an internal tangent, or, with open
spans, as an external one. As long as a part of it sticks on the input, each side acts as a separate cable. Two anchored
cables replace these sides: they are wound outwards from the points where their spans leave, so that the spans converge
along Y.

The centre line is drawn at a given drum angle: of one cable from terminal to terminal, of two from their stops. Input,
span and drum have the same helix angle: the turns move along the input by one lead a turn, each span leaves in line
with them, and on the drum the cable lies on a helix of the same slope. The cable therefore bends in no other direction
at any angle of the drum, and the landing points move along the drum together with the turns on the input. Beyond the
last point that ever leaves the drum, the cable changes into the plane of its terminal.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from math import cos, pi, radians, sin, tan, tau

import numpy as np

from mbcdm_cad.layouts.siso_spur.drive import CHANGE_RAD, SpurDrive, SpurRun, contact_rad
from mbcdm_cad.layouts.siso_spur.strand import SENSE, Circle, Strand, idler_body, no_strand, taut
from mbcdm_cad.parts.drum_sector.design import SectorRun
from mbcdm_cad.parts.drum_sector.sizes import SWAGE_START_MM
from mbcdm_cad.parts.input_pulley.dims import STOP_PIECES, StopGeometry, stop_geometry, stop_pieces
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.curves import Arc, CablePath, Coil, Line, Parabola, Stretch, Triple, reverse, triple
from mbcdm_cad.routes.curves import Piece as Drawn
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


# Way of a terminal that a whole drum's cable counts as drawn in (estimate: more than any of the catalogue has).
DRAWN_IN_MM = 10.0
ON_INPUT = ("wound",)
_ON_DRUM = ("drum", "lay", "dead", "tail")


def led_names(drive: SpurDrive) -> tuple[str, ...]:
    """Names of the pieces between input and drum: spans and, between them, wraps on idlers."""
    between = tuple(name for n in range(1, len(drive.idler_places) + 1) for name in (f"idler_{n}", f"span_{n + 1}"))
    return ("span", *between)


def input_wrap_rad(drive: SpurDrive, cable: SectorRun, drum_angle_rad: float) -> float:
    """Wrap of one side on the input, from the cable's middle or stop, at a drum angle.

    It decreases with the drum angle for a side that runs to +x. Negative if the middle has left the input.
    """
    return drive.wound_rad - cable.drum_side * drive.total_ratio * drum_angle_rad


def walked_mm(drive: SpurDrive, drum_angle_rad: float) -> float:
    """Movement of turns, spans and landing points along y since the centred drum."""
    return drive.input_radius_mm * drive.slope * drive.total_ratio * drum_angle_rad


def side_pieces(drive: SpurDrive, cable: SpurRun, anchor_rad: float, tail_mm: float, angle_rad: float) -> list[Drawn]:
    """Pieces of one side at a drum angle, from the point where it leaves the input to its terminal.

    ``anchor_rad``: angle on the drum, from +Z towards the cable's side, at which the cable leaves its land with the
    drum centred; ``tail_mm``: straight length from there into the terminal.
    """
    side, r_i, r_o = cable.drum_side, cable.input_radius_mm, cable.drum_radius_mm
    middle = drive.level_mm + walked_mm(drive, angle_rad)
    leave, land = (middle + cable.outward * y for y in (drive.leave_mm, drive.land_mm))
    at = contact_rad(drive, side)
    off = (r_i * sin(at), leave, drive.centre_distance_mm + r_i * cos(at))

    def on_drum(angle: float, y: float, radius: float = r_o) -> Triple:
        return (side * radius * sin(angle), y, radius * cos(angle))

    # Angles on the drum from +Z towards the cable's side.
    moved, landing = side * angle_rad, drive.landing_rad
    start = landing + radians(drive.half_travel_deg) + CHANGE_RAD + moved
    last, end = start + CHANGE_RAD, start + 2 * CHANGE_RAD
    plane = cable.terminal_y_mm
    # Direction along y in which the helix continues: away from the middle, or for two anchored cables across it.
    onward = -cable.outward if drive.anchored else cable.outward
    start_y = plane - onward * r_o * drive.slope * tan(CHANGE_RAD)
    anchor = anchor_rad + moved
    along = np.array([side * cos(anchor), 0.0, -sin(anchor)])
    leaving = np.array(on_drum(anchor, plane))
    return [
        *_led(drive, side, off, on_drum(landing, land)),
        Coil((0.0, 0.0, 0.0), _Y, _Z, r_o, side * landing, side * start, land, start_y),
        Parabola(on_drum(start, start_y), on_drum(last, plane, r_o / cos(CHANGE_RAD)), on_drum(end, plane)),
        Arc((0.0, plane, 0.0), _Z, (float(side), 0.0, 0.0), r_o, end, anchor),
        Line(triple(leaving), triple(leaving + tail_mm * along)),
    ]


def _led(drive: SpurDrive, side: int, off: Triple, on: Triple) -> list[Drawn]:
    """Spans and wraps on idlers between the points where a side leaves the input and lands on the drum."""
    found, r, pieces, start = drive.strand, drive.idler_mm, list[Drawn](), off
    for place, before, span, wrap in zip(drive.idler_places, found.heading, found.length, found.wraps, strict=False):
        slope = (on[1] - off[1]) / drive.strand_mm
        y = start[1] + slope * float(span)
        end_y = y + slope * r * float(wrap)
        # Where the span touches: the axis and a quarter of a turn from its direction.
        first = float(before) - SENSE * pi / 2
        last = first + SENSE * float(wrap)
        centre, ends = (side * place.x_mm, 0.0, place.z_mm), []
        for angle, at_y in ((first, y), (last, end_y)):
            ends.append((centre[0] + side * r * sin(angle), at_y, centre[2] + r * cos(angle)))
        pieces += [Line(start, ends[0]), Coil(centre, _Y, _Z, r, side * first, side * last, y, end_y)]
        start = ends[1]
    return [*pieces, Line(start, on)]


def cable_paths(
    drive: SpurDrive, anchors: Mapping[str, tuple[float, float]], angle_rad: float
) -> tuple[CablePath, ...]:
    """Centre lines at a drum angle; ``anchors``: (anchor_rad, tail_mm) of each side by its name."""
    if drive.anchored:
        return tuple(anchored_path(drive, c, *anchors[c.name], angle_rad) for c in drive.cables)
    return (cable_path(drive, anchors, angle_rad),)


def stop_of(drive: SpurDrive, cable: SpurRun) -> StopGeometry:
    """End of an anchored cable in the input pulley; its angle is in the frame of the pulley."""
    end = contact_rad(drive, cable.drum_side) - pi / 2 + cable.drum_side * drive.wound_rad
    return stop_geometry(drive, cable.input_radius_mm, end, cable.drum_side)


def anchored_path(drive: SpurDrive, cable: SpurRun, anchor_rad: float, tail_mm: float, angle_rad: float) -> CablePath:
    """Centre line of one of two anchored cables, from the end of its stop; arguments as of :func:`side_pieces`."""
    axis = (0.0, 0.0, drive.centre_distance_mm)
    leave = drive.level_mm + walked_mm(drive, angle_rad) + cable.outward * drive.leave_mm
    wrap = input_wrap_rad(drive, cable, angle_rad)
    at = contact_rad(drive, cable.drum_side)
    end, end_y = at + cable.drum_side * wrap, leave + cable.outward * drive.helix_lead_mm * wrap / tau
    wound = Coil(axis, _Y, _Z, cable.input_radius_mm, end, at, end_y, leave)
    start = wound.points(np.array([0.0]))[0]
    radial = np.array([sin(end), 0.0, cos(end)])
    ends = stop_pieces(start, radial, -wound.tangent(0.0), cable.input_radius_mm, stop_of(drive, cable))
    side = side_pieces(drive, cable, anchor_rad, tail_mm, angle_rad)
    on_input = (*STOP_PIECES, *ON_INPUT)
    led = led_names(drive)
    pieces = (*zip(on_input, (*ends, wound), strict=True), *zip((*led, *_ON_DRUM), side, strict=True))
    stretches = (Stretch(f"input_{cable.input_name}", on_input), Stretch(None, led), Stretch("drum", _ON_DRUM))
    return CablePath(cable, angle_rad, pieces, stretches)


def cable_path(drive: SpurDrive, anchors: Mapping[str, tuple[float, float]], angle_rad: float) -> CablePath:
    """Centre line of the one cable, which has the name of its input; arguments as of :func:`cable_paths`."""
    first, second = drive.cables
    ends = [side_pieces(drive, c, *anchors[c.name], angle_rad) for c in (first, second)]
    at = contact_rad(drive, first.drum_side)
    middle = drive.level_mm + walked_mm(drive, angle_rad)
    leave = [middle + c.outward * drive.leave_mm for c in (first, second)]
    wound = Coil(
        (0.0, 0.0, drive.centre_distance_mm),
        _Y,
        _Z,
        drive.input_radius_mm,
        at,
        at + drive.input_sense * first.drum_side * drive.wrap_rad,
        leave[0],
        leave[1],
    )
    led = led_names(drive)
    free = len(led)
    names = [[f"{name}_{c.name}" for name in (*led, *_ON_DRUM)] for c in (first, second)]
    pieces: tuple[tuple[str, Drawn], ...] = (
        *((name, reverse(piece)) for name, piece in zip(names[0][::-1], ends[0][::-1], strict=True)),
        (ON_INPUT[0], wound),
        *zip(names[1], ends[1], strict=True),
    )
    stretches = (
        Stretch("drum", tuple(names[0][: free - 1 : -1])),
        Stretch(None, tuple(names[0][free - 1 :: -1])),
        Stretch(f"input_{first.input_name}", ON_INPUT),
        Stretch(None, tuple(names[1][:free])),
        Stretch("drum", tuple(names[1][free:])),
    )
    return CablePath(replace(first, name=first.input_name), angle_rad, pieces, stretches)


def side_length_mm(drive: SpurDrive, cable: SpurRun, anchor_rad: float, tail_mm: float) -> float:
    """Length of one side, from the middle of the cable or the end of its stop to the bottom of the swage's bore."""
    wound = drive.input_radius_mm * drive.stretched * drive.wound_rad
    if drive.anchored:
        wound += stop_length_mm(stop_of(drive, cable), cable.input_radius_mm)
    return wound + sum(piece.length_mm for piece in side_pieces(drive, cable, anchor_rad, tail_mm, 0.0))


def stop_length_mm(stop: StopGeometry, radius_mm: float) -> float:
    """Length of bend and chord in the input pulley."""
    return pi / 2 * stop.bend_radius_mm + (radius_mm - stop.bend_radius_mm) - stop.stop_end_mm


def longest_mm(drive: SpurDrive, anchor_rad: float) -> float:
    """Upper estimate of the length of a side that leaves its land at ``anchor_rad``."""
    wound = drive.input_radius_mm * drive.wound_rad + drive.strand_mm
    if drive.anchored:
        first = drive.cables[0]
        wound += stop_length_mm(stop_of(drive, first), first.input_radius_mm)
    on_drum = drive.drum_radius_mm * max(anchor_rad - drive.landing_rad, 0.0)
    tail = 6.0 * drive.cable.diameter_mm
    if drive.whole_drum:
        # The terminal lies at ``anchor_rad`` itself, not before it: the rope in the sleeve counts, drawn in.
        tail = max(tail, SWAGE_START_MM + drive.tensioner.swage_length_mm + DRAWN_IN_MM)
    return (wound + on_drum) * drive.stretched + tail
