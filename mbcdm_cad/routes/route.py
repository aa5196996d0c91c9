"""The route of a cable as plain data: the bodies that it runs on, and its wraps and spans from the input to the drum.

Frame and signs are the project's: lengths in m, angles in rad, right-handed about each body's axis. Pieces are listed
in the direction from the input to the drum. A span of direction t touches a body of axis a on which the cable turns in
the sense s (+1 right-handed about a) at the axis point plus ``height_m`` a - s r (a x t).

Displacing a body by e, where the cable arrives along u_in and leaves along u_out, changes its path by
e . (u_in - u_out) to first order; at an anchored end one of the two is missing. The exact change is a sum over the
spans. With D the line of centres of its two bodies in their plane, R = s_2 r_2 - s_1 r_1 and beta the turn of the span,

    L = sqrt(D^2 - R^2),  change = L' - L - R beta,

the last term being the rope that both wraps gain. Where the axes are not parallel, or the cable changes to the next
body at a point, only the first order is used; the second order is the rotation of the span, some nm for 10 um.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, Protocol

import numpy as np

from mbcdm_cad.routes import Floats

Triple = tuple[float, float, float]


@dataclass(frozen=True)
class Body:
    """A rotating body that cables run on.

    ``turns_per_drum`` is its angle about ``axis`` per angle of the drum about the drum's axis, the mean over the cables
    that run on it. An input's axis points so that this is positive. ``reference`` is the direction of angle zero.
    """

    name: str
    kind: Literal["input", "passed", "drum"]
    point_m: Triple
    axis: Triple
    reference: Triple
    turns_per_drum: float


@dataclass(frozen=True)
class Anchor:
    """The cable's end on an input."""

    body: str


@dataclass(frozen=True)
class Terminal:
    """The cable's end on the drum, where its preload is set."""

    body: str


@dataclass(frozen=True)
class Wrap:
    """The cable on a body. ``turning`` is the sense in which it runs round the axis in the direction to the drum.

    ``angle_rad`` is infinite where the wrap ends at an anchor beyond all slip and its length has not been set.
    ``passed``: the rope runs on at both ends, nothing is anchored.
    ``may_slip_through``: only friction holds the cable there. ``lead_m`` is the advance along the axis a turn.
    """

    body: str
    radius_m: float
    angle_rad: float
    height_m: float
    turning: int
    passed: bool = False
    may_slip_through: bool = False
    lead_m: float = 0.0


@dataclass(frozen=True)
class Span:
    """A straight piece between two wraps; length 0 where the cable changes from one body to the next at a point."""

    length_m: float
    direction: Triple


def input_body(input_name: str) -> str:
    """Name of the body that the input ``input_name`` drives."""
    return f"input_{input_name}"


# At an end that is anchored a cable runs nowhere.
_NOWHERE: Triple = (0.0, 0.0, 0.0)
Piece = Anchor | Wrap | Span | Terminal


@dataclass(frozen=True)
class Contact:
    """Directions in which the cable runs onto a body and off it: unit vectors, None at an end that is anchored."""

    wrap: Wrap
    arriving: Triple | None
    leaving: Triple | None


@dataclass(frozen=True)
class CableRoute:
    """One cable from its input to the drum. ``sense`` (sigma): the sense in which its tension turns the drum."""

    cable: str
    input_name: str
    sense: int
    pieces: tuple[Piece, ...]

    def __post_init__(self) -> None:
        kinds = [type(piece) for piece in self.pieces]
        inner = kinds[1:-1]
        alternate = inner[::2] == [Wrap] * len(inner[::2]) and inner[1::2] == [Span] * len(inner[1::2])
        if kinds[:1] != [Anchor] or kinds[-1:] != [Terminal] or len(inner) < 3 or len(inner) % 2 == 0 or not alternate:
            raise ValueError(
                f"cable {self.cable}: its pieces are {', '.join(kind.__name__ for kind in kinds)}; "
                "give Anchor, Wrap, Span, Wrap, ..., Wrap, Terminal"
            )

    @property
    def wraps(self) -> tuple[Wrap, ...]:
        """All wraps, that on the input first and that on the drum last."""
        return tuple(piece for piece in self.pieces if isinstance(piece, Wrap))

    @property
    def spans(self) -> tuple[Span, ...]:
        """All spans; span k lies between the wraps k and k + 1."""
        return tuple(piece for piece in self.pieces if isinstance(piece, Span))

    @property
    def passed(self) -> tuple[Wrap, ...]:
        """The wraps between input and drum, on which nothing is anchored."""
        return self.wraps[1:-1]

    @property
    def input_radius_m(self) -> float:
        """Lever arm of the tension at the input, m."""
        return self.wraps[0].radius_m

    @property
    def drum_radius_m(self) -> float:
        """Lever arm of the tension at the drum, m."""
        return self.wraps[-1].radius_m

    @property
    def free_length_m(self) -> float:
        """L_free: all spans together, the length that stretches without friction."""
        return sum(span.length_m for span in self.spans)

    @property
    def length_m(self) -> float:
        """Length of the cable from anchor to terminal along its pitch line; infinite unless the wraps are set."""
        return self.free_length_m + sum(
            float(np.hypot(w.radius_m, w.lead_m / (2 * np.pi))) * w.angle_rad for w in self.wraps
        )

    def contacts(self) -> Iterator[Contact]:
        """Each wrap with the directions of travel at its ends."""
        spans = self.spans
        for k, wrap in enumerate(self.wraps):
            arriving = spans[k - 1].direction if k > 0 else None
            leaving = spans[k].direction if k < len(spans) else None
            yield Contact(wrap, arriving, leaving)


@dataclass(frozen=True, eq=False)
class DriveRoutes:
    """Bodies and cables of one drive."""

    bodies: tuple[Body, ...]
    cables: tuple[CableRoute, ...]

    def body(self, name: str) -> Body:
        """The body called ``name``; KeyError if there is none."""
        for body in self.bodies:
            if body.name == name:
                return body
        raise KeyError(name)

    @cached_property
    def pulls(self) -> Mapping[str, tuple[tuple[int, float, Triple], ...]]:
        """For each body its contacts: number of the cable, height along the axis in m, pull for 1 N in the cable."""
        found: dict[str, list[tuple[int, float, Triple]]] = {body.name: [] for body in self.bodies}
        for j, route in enumerate(self.cables):
            for at in route.contacts():
                ax, ay, az = _NOWHERE if at.arriving is None else at.arriving
                lx, ly, lz = _NOWHERE if at.leaving is None else at.leaving
                found[at.wrap.body].append((j, at.wrap.height_m, (lx - ax, ly - ay, lz - az)))
        return {name: tuple(contacts) for name, contacts in found.items()}

    @property
    def drum(self) -> Body:
        """The body that all cables end on."""
        return next(body for body in self.bodies if body.kind == "drum")

    @property
    def passed(self) -> tuple[Body, ...]:
        """Bodies that cables pass and are not anchored on."""
        return tuple(body for body in self.bodies if body.kind == "passed")

    @property
    def inputs(self) -> tuple[Body, ...]:
        """Bodies that are driven, in the order of the design's inputs."""
        return tuple(body for body in self.bodies if body.kind == "input")


def offset_m(body: Body, eccentricity_m: float, angle_rad: Floats) -> Floats:
    """Displacement (3, n), m, of a groove's centre at ``angle_rad`` (n,) about the axis from the reference."""
    first = np.array(body.reference)
    second = np.cross(body.axis, first)
    angle = np.asarray(angle_rad, dtype=float)
    return np.asarray(eccentricity_m * (first[:, None] * np.cos(angle) + second[:, None] * np.sin(angle)))


def path_slope(route: CableRoute, body: str) -> Floats:
    """u_in - u_out (3,): growth of the path per displacement of ``body``; zero if the cable does not run on it."""
    total = np.zeros(3)
    for contact in route.contacts():
        if contact.wrap.body == body:
            total = total + (0.0 if contact.arriving is None else np.array(contact.arriving))
            total = total - (0.0 if contact.leaving is None else np.array(contact.leaving))
    return total


def path_change_m(routes: DriveRoutes, route: CableRoute, offsets_m: Mapping[str, Floats]) -> Floats:
    """Exact change (n,) of the path's length for displacements (3, n) of bodies, by name."""
    n = next(iter(offsets_m.values())).shape[1]
    total = np.zeros(n)
    wraps = route.wraps
    for k, span in enumerate(route.spans):
        first, second = wraps[k], wraps[k + 1]
        apart = np.zeros((3, n))
        if second.body in offsets_m:
            apart = apart + offsets_m[second.body]
        if first.body in offsets_m:
            apart = apart - offsets_m[first.body]
        if apart.any():
            total = total + _span_change_m(routes, (first, second), span, apart)
    return total


def _span_change_m(routes: DriveRoutes, ends: tuple[Wrap, Wrap], span: Span, apart_m: Floats) -> Floats:
    """Change of one span, and of the rope that its rotation winds on or off at both ends, m (n,)."""
    one, two = (routes.body(wrap.body) for wrap in ends)
    axis = np.array(one.axis)
    parallel = float(np.dot(axis, two.axis))
    if span.length_m == 0.0 or abs(parallel) < 1.0 - 1e-12:
        return np.asarray(np.array(span.direction) @ apart_m)
    x = np.array(one.reference)
    plane = np.stack([x, np.cross(axis, x)])
    centres = plane @ (np.array(two.point_m) - np.array(one.point_m))
    radius = ends[1].turning * np.sign(parallel) * ends[1].radius_m - ends[0].turning * ends[0].radius_m
    moved = centres[:, None] + plane @ apart_m
    length = np.sqrt((moved * moved).sum(axis=0) - radius**2)
    turned = np.arctan2(moved[1], moved[0]) - np.arctan2(centres[1], centres[0])
    turned = np.arctan2(np.sin(turned), np.cos(turned))
    inclination = np.arctan2(radius, length) - np.arctan2(radius, span.length_m)
    return np.asarray(length - span.length_m - radius * (turned - inclination))


@dataclass(frozen=True, eq=False)
class BodyLoad:
    """Force (3,) in N on a body, and the moment (3,) in N m about the point of its axis at ``height_m``.

    The moment leaves out its component along the axis, which is the torque that the body transmits.
    """

    force_N: Floats
    height_m: float
    moment_Nm: Floats


def body_load(routes: DriveRoutes, name: str, tension_N: Floats) -> BodyLoad:
    """Load on the body ``name`` for free-span tensions (n_cables,), which may be differences and negative.

    The moment is about the height of the pull's line of action on an input, the middle of the steps on a body that is
    passed, and the origin of the drum's axis.
    """
    body = routes.body(name)
    tension = np.asarray(tension_N, dtype=float).tolist()
    # Plain numbers: a body has a few contacts, and numpy's calls take several times as long for so few.
    pulls = [(tension[j], height, [tension[j] * part for part in pull]) for j, height, pull in routes.pulls[name]]
    if not pulls:
        return BodyLoad(np.zeros(3), 0.0, np.zeros(3))
    middle = 0.0
    if body.kind == "input":
        weights = [max(pulled, 1e-12) for pulled, _, _ in pulls]
        middle = sum(at * weight for (_, at, _), weight in zip(pulls, weights, strict=True)) / sum(weights)
    elif body.kind == "passed":
        heights = [at for _, at, _ in pulls]
        middle = 0.5 * (min(heights) + max(heights))
    moments = []
    for _, at, (x, y, z) in pulls:
        ax, ay, az = ((at - middle) * part for part in body.axis)
        moments.append((ay * z - az * y, az * x - ax * z, ax * y - ay * x))
    return BodyLoad(_summed([pull for _, _, pull in pulls]), middle, _summed(moments))


def _summed(vectors: Sequence[Sequence[float]]) -> Floats:
    return np.array([sum(parts) for parts in zip(*vectors, strict=True)])


def two_bearing_reactions_N(
    force_N: Floats, moment_Nm: Floats, at_m: float, lower_m: float, upper_m: float, axis: Triple = (0.0, 0.0, 1.0)
) -> Floats:
    """Radial reactions (2, 3) of bearings at ``lower_m`` and ``upper_m`` to a force at height ``at_m`` and a moment.

    Heights count along the unit vector ``axis``.
    """
    arm = upper_m - lower_m
    # Equilibrium about the lower bearing: a x R_upper arm + a x F (at - lower) + moment = 0.
    (ax, ay, az), (mx, my, mz) = axis, moment_Nm
    # Minus the cross product a x moment, written out: numpy's takes several times as long for one vector.
    from_moment = np.array([az * my - ay * mz, ax * mz - az * mx, ay * mx - ax * my]) / arm
    upper = -np.asarray(force_N) * (at_m - lower_m) / arm - from_moment
    return np.stack([-np.asarray(force_N) - upper, upper])


INPUT_RADIUS, DRUM_RADIUS = "input_radius_m", "drum_radius_m"


@dataclass(frozen=True)
class Varied:
    """A length of the whole design that studies vary: its label, values for a plot over it and a range, in m."""

    name: str
    label: str
    values_m: tuple[float, ...]
    range_m: tuple[float, float]


class Geometry(Protocol):
    """Cables and inputs of a drive, and how spans and wraps follow from its lengths.

    ``input_radius_m`` and ``drum_radius_m`` are always among the lengths of each cable. ``passed_radii`` gives for each
    passed body, from the drum on, the name of the length that is its radius.
    """

    @property
    def cable_names(self) -> tuple[str, ...]:
        """Names of the cables: axis 0 of every array."""

    @property
    def input_names(self) -> tuple[str, ...]:
        """Names of the inputs."""

    @property
    def input_of(self) -> tuple[int, ...]:
        """For each cable the index of its input."""

    @property
    def sense(self) -> tuple[int, ...]:
        """For each cable the sense (+1 or -1) in which its tension turns the drum."""

    @property
    def per_cable(self) -> tuple[str, ...]:
        """Names of the lengths that each cable has separately."""

    @property
    def varied(self) -> tuple[Varied, ...]:
        """The lengths of the whole design."""

    @property
    def passed_radii(self) -> dict[str, str]:
        """Passed body -> name of the length that is its radius."""

    def free_span_m(self, parameters: Mapping[str, Floats]) -> Floats:
        """Free length of each cable, (n_cables, *batch), NaN where there is no geometry.

        Lengths of cables are (n_cables, *batch), those of the whole design (*batch).
        """

    def passed_wrap_rad(self, parameters: Mapping[str, Floats]) -> tuple[Floats, ...]:
        """Wrap of each cable on each passed body, (n_cables, *batch); 0 where it does not run on it."""

    def through_wrap_rad(self, parameters: Mapping[str, Floats]) -> Floats | None:
        """Wrap of each cable over its input that friction alone holds there, (n, *batch); its two sides are neighbours.

        None where cables are anchored on their inputs. A cable without an anchor counts as two, one for each sense,
        from the point at which it sticks on the input; the ratio of their tensions is at most e^(mu wrap).
        """

    def fault(self, parameters: Mapping[str, Floats]) -> str:
        """Message for lengths without a geometry: problem, value, limit and remedy in one sentence."""

    def routes(self, parameters: Mapping[str, Floats]) -> DriveRoutes:
        """Bodies and cables of one design."""


class AnchoredGeometry:
    """What geometries share whose cables end on a drum's sides, are anchored on their inputs, and pass no body."""

    # Side to which each cable runs on the drum.
    drum_side: tuple[int, ...]

    @property
    def sense(self) -> tuple[int, ...]:
        """A cable that runs towards +x turns the drum negative about +Y."""
        return tuple(-side for side in self.drum_side)

    @property
    def passed_radii(self) -> dict[str, str]:
        """None."""
        return {}

    def passed_wrap_rad(self, parameters: Mapping[str, Floats]) -> tuple[Floats, ...]:
        """None."""
        return ()

    def through_wrap_rad(self, parameters: Mapping[str, Floats]) -> Floats | None:
        """None."""
        return None


def tangent_length_m(distance_m: Floats, radius_sum_m: Floats) -> Floats:
    """Length of the tangent common to two circles, NaN where there is none; Eq. (11).

    ``radius_sum_m`` is r_1 + r_2 where the tangent crosses the line of centres, |r_1 - r_2| where it does not.
    """
    square = np.asarray(distance_m) ** 2 - np.asarray(radius_sum_m) ** 2
    return np.asarray(np.sqrt(np.where(square > 0.0, square, np.nan)))


@dataclass(frozen=True, eq=False)
class RoutedDrive:
    """The routes of one design as a configuration supplies them: geometry, its lengths in m, and those of the file.

    ``parameters`` are (n_cables,) or scalar; ``shown`` are the lengths of the whole design by their names in the file.
    """

    geometry: Geometry
    parameters: dict[str, Floats]
    shown: dict[str, float]

    @property
    def routes(self) -> DriveRoutes:
        """Bodies and cables of this design."""
        return self.geometry.routes(self.parameters)
