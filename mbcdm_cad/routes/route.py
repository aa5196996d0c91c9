"""The route of a cable as plain data: the bodies that it runs on, and its wraps and spans from the input to the drum.

Frame and signs are the project's: lengths in m, angles in rad, right-handed about each body's axis. Pieces are listed
in the direction from the input to the drum. A span of direction t touches a body of axis a on which the cable turns in
the sense s (+1 right-handed about a) at the axis point plus ``height_m`` a - s r (a x t).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

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

    ``angle_rad`` is infinite where the wrap ends at an anchor beyond all slip and its length has not been set
    (:meth:`CableRoute.with_anchored_wraps`). ``passed``: the rope runs on at both ends, nothing is anchored.
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

    def with_anchored_wraps(self, input_rad: float, drum_rad: float) -> CableRoute:
        """The route with the live wraps on input and drum set, from the tangent point to the anchor."""
        first, last = 1, len(self.pieces) - 2
        angles = {first: input_rad, last: drum_rad}
        pieces = tuple(
            replace(piece, angle_rad=angles[k]) if isinstance(piece, Wrap) and k in angles else piece
            for k, piece in enumerate(self.pieces)
        )
        return replace(self, pieces=pieces)


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


def contact_point_m(body: Body, wrap: Wrap, direction: Triple) -> Floats:
    """Point (3,) at which a span of this direction touches the wrap's pitch circle."""
    axis = np.array(body.axis)
    out = np.cross(axis, direction)
    return np.asarray(np.array(body.point_m) + wrap.height_m * axis - wrap.turning * wrap.radius_m * out)
