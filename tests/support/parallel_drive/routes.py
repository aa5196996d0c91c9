"""Routes of the cables of the parallel drive: a wrap on the input, a crossed span, a wrap on the drum.

The span of a cable that turns the drum in the sense s_d = -sigma has the direction (-cos beta, 0, -s_d sin beta) with
sin beta = (r_o + r_i)/L, so that both ends touch their pulleys (derived).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import acos, degrees, pi, radians, sqrt

import numpy as np

from mbcdm_cad.design.drive import CableRun, Drive
from mbcdm_cad.routes import Floats, route
from mbcdm_cad.routes.curves import Arc, CablePath, Line, Stretch, Triple
from parallel_drive.design_file import ParallelDrive

DISTANCE = "centre_distance_m"
_MM = 1e-3
# Wrap left on the drum and on the input where a cable is unwound.
RESERVE_DEG = 20.0
STATIONS = 9


@dataclass(frozen=True)
class ParallelGeometry:
    """See :class:`mbcdm_cad.routes.route.Geometry`."""

    cable_names: tuple[str, ...]
    input_names: tuple[str, ...]
    input_of: tuple[int, ...]
    sense: tuple[int, ...]
    heights_m: tuple[float, ...]
    per_cable: tuple[str, ...] = (route.INPUT_RADIUS, route.DRUM_RADIUS)
    varied: tuple[route.Varied, ...] = (
        route.Varied(DISTANCE, "centre distance", (45e-3, 50e-3, 60e-3), (48e-3, 60e-3)),
    )

    @property
    def passed_radii(self) -> dict[str, str]:
        """No cable passes a body."""
        return {}

    def free_span_m(self, parameters: Mapping[str, Floats]) -> Floats:
        """Crossed tangent."""
        return route.tangent_length_m(
            parameters[DISTANCE], parameters[route.INPUT_RADIUS] + parameters[route.DRUM_RADIUS]
        )

    def passed_wrap_rad(self, parameters: Mapping[str, Floats]) -> tuple[Floats, ...]:
        """None."""
        return ()

    def through_wrap_rad(self, parameters: Mapping[str, Floats]) -> None:
        """Every cable is anchored on its input."""

    def fault(self, parameters: Mapping[str, Floats]) -> str:
        """The pulleys overlap."""
        return "free span: centre distance does not exceed r_o + r_i; raise centre_distance_mm or cut the radii"

    def routes(self, parameters: Mapping[str, Floats]) -> route.DriveRoutes:
        """Two bodies, two cables."""
        drum, pulley = parameters[route.DRUM_RADIUS], parameters[route.INPUT_RADIUS]
        distance, body = float(parameters[DISTANCE]), route.input_body(self.input_names[0])
        bodies = (
            route.Body("drum", "drum", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0), 1.0),
            route.Body(
                body, "input", (distance, 0.0, 0.0), (0.0, -1.0, 0.0), (1.0, 0.0, 0.0), float(np.mean(drum / pulley))
            ),
        )
        spans = self.free_span_m(parameters)
        cables = []
        for k, name in enumerate(self.cable_names):
            turning, sine = -self.sense[k], float((drum[k] + pulley[k]) / distance)
            cosine = float(np.sqrt(max(1.0 - sine**2, 0.0)))
            height = self.heights_m[k]
            pieces = (
                route.Anchor(body),
                # About the input's own axis, -Y, the crossed cable turns as it does on the drum about +Y.
                route.Wrap(body, float(pulley[k]), np.inf, -height, turning),
                route.Span(float(spans[k]), (-cosine, 0.0, -turning * sine)),
                route.Wrap("drum", float(drum[k]), np.inf, height, turning),
                route.Terminal("drum"),
            )
            cables.append(route.CableRoute(name, self.input_names[0], self.sense[k], pieces))
        return route.DriveRoutes(bodies, tuple(cables))


def routed(drive: Drive) -> route.RoutedDrive:
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
        route.INPUT_RADIUS: np.array([run.input_radius_mm * _MM for run in drive.cables]),
        route.DRUM_RADIUS: np.array([run.drum_radius_mm * _MM for run in drive.cables]),
        DISTANCE: np.asarray(drive.centre_distance_mm * _MM),
    }
    return route.RoutedDrive(geometry, parameters, {"centre_distance_mm": drive.centre_distance_mm})


def height_mm(run: CableRun) -> float:
    """The plane in which a cable runs: one above, one below the middle."""
    return run.sigma * 1.5


def wraps_rad(drive: Drive, run: CableRun, drum_angle_rad: float) -> tuple[float, float]:
    """(input, drum) wrap of a cable at a drum angle; a cable of sense sigma leaves the drum as it turns by +sigma."""
    half, reserve = radians(drive.half_travel_deg), radians(RESERVE_DEG)
    taken = half - run.sigma * drum_angle_rad
    return reserve + run.drum_radius_mm / run.input_radius_mm * (2 * half - taken), reserve + taken


def cable_path(drive: ParallelDrive, run: CableRun, drum_angle_rad: float) -> CablePath:
    turning, y = -run.sigma, height_mm(run)
    r_i, r_o, distance = run.input_radius_mm, run.drum_radius_mm, drive.centre_distance_mm
    beta = acos((r_i + r_o) / distance)
    # Contact on the drum, an angle from +X towards -Z about +Y; on the input half a turn further.
    at_drum = turning * beta
    at_input = at_drum + pi
    on_input, on_drum = wraps_rad(drive, run, drum_angle_rad)
    x, z = (1.0, 0.0, 0.0), (0.0, 0.0, -1.0)
    wound = Arc((distance, y, 0.0), x, z, r_i, at_input + turning * on_input, at_input)
    drum = Arc((0.0, y, 0.0), x, z, r_o, at_drum, at_drum + turning * on_drum)
    span = Line(_end(wound, 1.0), _end(drum, 0.0))
    pieces = (("wound", wound), ("span", span), ("drum", drum))
    stretches = (Stretch(f"input_{run.input_name}", ("wound",)), Stretch(None, ("span",)), Stretch("drum", ("drum",)))
    return CablePath(run, drum_angle_rad, pieces, stretches)


def _end(arc: Arc, fraction: float) -> Triple:
    x, y, z = arc.points(np.array([fraction]))[0]
    return float(x), float(y), float(z)


@dataclass(frozen=True)
class Limit:
    """Where the travel ends in one direction."""

    angle_deg: float
    cause: str


@dataclass(frozen=True)
class CableFigures:
    """What the report asks for of every cable."""

    name: str
    length_mm: float
    length_um: tuple[float, ...]
    input_wrap_deg: tuple[float, ...]
    drum_wrap_deg: tuple[float, ...]


@dataclass(frozen=True)
class ParallelFigures:
    """Figures of the paths over the travel."""

    drum_angle_deg: tuple[float, ...]
    cables: tuple[CableFigures, ...]
    limits_positive: tuple[Limit, ...]
    limits_negative: tuple[Limit, ...]

    @property
    def usable_deg(self) -> tuple[float, float]:
        """The nearest limits."""
        return self.limits_negative[0].angle_deg, self.limits_positive[0].angle_deg


def path_figures(drive: ParallelDrive) -> ParallelFigures:
    """Lengths and wraps at nine angles."""
    half, stop = drive.half_travel_deg, drive.half_travel_deg + drive.stop_clearance_deg
    angles = tuple(float(a) for a in np.linspace(-half, half, STATIONS))
    cables = []
    for run in drive.cables:
        centred = cable_path(drive, run, 0.0).length_mm
        lengths = [cable_path(drive, run, radians(a)).length_mm for a in angles]
        wraps = [wraps_rad(drive, run, radians(a)) for a in angles]
        cables.append(
            CableFigures(
                run.name,
                centred,
                tuple((length - centred) * 1e3 for length in lengths),
                tuple(degrees(w[0]) for w in wraps),
                tuple(degrees(w[1]) for w in wraps),
            )
        )
    beyond = half + RESERVE_DEG
    return ParallelFigures(
        angles,
        tuple(cables),
        (Limit(stop, "hard stop"), Limit(beyond, "wrap on the drum ends")),
        (Limit(-stop, "hard stop"), Limit(-beyond, "wrap on the drum ends")),
    )


def free_span_mm(drive: ParallelDrive, run: CableRun) -> float:
    """Internal tangent."""
    return sqrt(drive.centre_distance_mm**2 - (run.input_radius_mm + run.drum_radius_mm) ** 2)
