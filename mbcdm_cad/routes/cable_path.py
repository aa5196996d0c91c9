"""The true centre line of one cable at one drum angle, as pieces of known curves; it is drawn and measured."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from math import ceil
from typing import Any

import numpy as np

from mbcdm_cad.design.drive import CableRun
from mbcdm_cad.routes.curves import Piece, Vector

# Drum angles over the travel at which paths have figures.
STATIONS = 9


@dataclass(frozen=True)
class Stretch:
    """Neighbouring pieces of a cable that move together with ``body``; None: they are free, or slide over a body."""

    body: str | None
    pieces: tuple[str, ...]


@dataclass(frozen=True)
class EndOfTravel:
    """A drum angle (deg, either sign) at which the travel ends, and the reason."""

    angle_deg: float
    cause: str


@dataclass(frozen=True)
class CableWraps:
    """One cable without a guide, or one side of a continuous one, over the travel: tuples over drum angles.

    ``length_um`` is the change of the whole cable's length from the centred drum: 0 except for rounding, since the
    length that leaves the drum on one side is wound on the input, or on the drum's other side.
    """

    name: str
    length_mm: float
    input_wrap_deg: tuple[float, ...]
    drum_wrap_deg: tuple[float, ...]
    length_um: tuple[float, ...]


def wrap_lines(c: dict[str, Any]) -> Iterator[str]:
    """:class:`CableWraps` as a dict, for a terminal."""
    middle = len(c["drum_wrap_deg"]) // 2
    wound, on_drum = c["input_wrap_deg"], c["drum_wrap_deg"]
    yield (
        f"  {c['name']:<10} length {c['length_mm']:.2f} mm; wrap on the input {wound[middle]:.0f} "
        f"({wound[0]:.0f}, {wound[-1]:.0f}), on the drum {on_drum[middle]:.1f} "
        f"({on_drum[0]:.1f}, {on_drum[-1]:.1f}) deg"
    )


@dataclass(frozen=True)
class CablePath:
    """Pieces of one cable's centre line, each under its own name, from its end on the input to its end on the drum.

    ``stretches`` says what carries them and names every piece once. ``diameter_mm``: of a cable that is not the
    design's own, as those of a first stage.
    """

    cable: CableRun
    drum_angle_rad: float
    pieces: tuple[tuple[str, Piece], ...]
    stretches: tuple[Stretch, ...] = ()
    diameter_mm: float | None = None

    def piece(self, name: str) -> Piece:
        """The piece called ``name``."""
        return dict(self.pieces)[name]

    @property
    def line(self) -> tuple[Piece, ...]:
        """The pieces without their names: all that a rod along the path depends on."""
        return tuple(p for _, p in self.pieces)

    @cached_property
    def length_mm(self) -> float:
        """Length of the whole centre line."""
        return sum(p.length_mm for _, p in self.pieces)

    def only(self, names: tuple[str, ...]) -> CablePath:
        """The path made of the pieces called ``names`` alone."""
        kept = tuple(p for p in self.pieces if p[0] in names)
        return CablePath(self.cable, self.drum_angle_rad, kept, diameter_mm=self.diameter_mm)

    def sample(self, step_mm: float) -> Vector:
        """Points (n, 3) along the pieces, no further apart than ``step_mm``."""
        counts = [max(2, ceil(piece.length_mm / step_mm) + 1) for _, piece in self.pieces]
        return np.concatenate(
            [p.points(np.linspace(0.0, 1.0, n)) for (_, p), n in zip(self.pieces, counts, strict=True)]
        )


def over_travel(
    paths_at: Callable[[float], tuple[CablePath, ...]], half_travel_deg: float
) -> tuple[tuple[float, ...], list[tuple[CablePath, ...]]]:
    """``STATIONS`` drum angles (deg) evenly over the travel, and all cables at each; ``paths_at`` gets it in rad."""
    angles = np.linspace(-half_travel_deg, half_travel_deg, STATIONS)
    return tuple(angles.tolist()), [paths_at(float(angle)) for angle in np.radians(angles)]


def by_sense(ends: Iterable[EndOfTravel]) -> tuple[tuple[EndOfTravel, ...], tuple[EndOfTravel, ...]]:
    """Ends of the travel at positive drum angles, and at the others, the nearest first."""
    nearest = sorted(ends, key=lambda end: abs(end.angle_deg))
    return tuple(e for e in nearest if e.angle_deg > 0.0), tuple(e for e in nearest if e.angle_deg <= 0.0)
