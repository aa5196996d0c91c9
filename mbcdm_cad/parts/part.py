"""What a part of the drive is: an object with its dimensions that draws itself; a made one has volume and sheet too.

Volumes are those of plain bodies in closed form: an estimate of mass without a kernel. Small features (edge breaks,
corner reliefs, the ends of slots) are left out; turned parts come out within 0.5 %, the drum within 3 %.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from importlib import import_module
from math import acos, pi, sqrt
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol

if TYPE_CHECKING:
    import cadquery

    from mbcdm_cad.parts.sheet import Sheet

    cq = cadquery
else:

    class _WhenDrawn:
        def __getattr__(self, name):
            return getattr(import_module("cadquery"), name)

    # The library is loaded when something is drawn: it takes a second, and checks and analysis do without.
    cq = _WhenDrawn()


# Metal that remains in each rounded corner, as a share of the radius squared: 1 - pi/4.
CORNER = 1.0 - pi / 4


def ring_mm3(outer: float, inner: float, height: float) -> float:
    """Ring, or a cylinder with ``inner`` 0; nothing where it has no height."""
    return pi * (outer**2 - inner**2) * max(height, 0.0)


def segment_mm2(radius: float, distance: float) -> float:
    """Area of a circle beyond a chord at ``distance`` from its middle."""
    at = min(max(distance, -radius), radius)
    return radius**2 * acos(at / radius) - at * sqrt(max(radius**2 - at**2, 0.0))


def pocket_mm3(x: float, y: float, z: float, radius: float, corners: int = 4) -> float:
    """Box milled along y, some of its edges rounded; nothing where it has no extent."""
    if min(x, y, z) <= 0.0:
        return 0.0
    return (x * z - corners * CORNER * pocket_corner_mm(radius, x, z) ** 2) * y


# The end mill is a little thinner than the pocket, so that the shorter side of the pocket has a straight part.
_SHARE = 0.49


def pocket_corner_mm(radius_mm: float, width_mm: float, height_mm: float) -> float:
    """Corner radius of a pocket, mm: ``radius_mm``, or less if the pocket is narrow."""
    return min(radius_mm, _SHARE * min(width_mm, height_mm))


# Radius outside and inside, start and end along the axis, mm; one with the larger radius inside is taken away.
Ring = tuple[float, float, float, float]


def rings_mm3(rings: Iterable[Ring]) -> float:
    """Volume of rings on one axis."""
    return sum(pi * (outer**2 - inner**2) * max(end - start, 0.0) for outer, inner, start, end in rings)


class Gyration(NamedTuple):
    """How a body's volume lies about an axis of its own frame, ``along``: with its density the inertia follows.

    ``centre_mm``: its centre on that axis; mean squares of the distances from the axis, and from a line across it
    through the centre, mm2.
    """

    along: tuple[float, float, float] = (0.0, 0.0, 1.0)
    centre_mm: float = 0.0
    about_mm2: float = 0.0
    across_mm2: float = 0.0


def gyration(rings: Iterable[Ring], along: tuple[float, float, float] = (0.0, 0.0, 1.0)) -> Gyration:
    """That of rings on one axis; of no ring that of a point in the origin."""
    found = [
        (pi * (outer**2 - inner**2) * max(end - start, 0.0), (outer**2 + inner**2) / 2, (start + end) / 2, end - start)
        for outer, inner, start, end in rings
    ]
    whole = sum(volume for volume, *_ in found)
    if not whole > 0.0:
        return Gyration(along)
    centre = sum(volume * middle for volume, _, middle, _ in found) / whole
    about = sum(volume * square for volume, square, *_ in found) / whole
    lengthwise = sum(v * (high**2 / 12 + (middle - centre) ** 2) for v, _, middle, high in found) / whole
    return Gyration(along, centre, about, about / 2 + lengthwise)


class Part(ABC):
    """A frozen dataclass of plain data from which one solid follows. Parts are equal if their solids are.

    ``solid`` imports the kernel inside, so that checks and analysis start without it.
    """

    # Fasteners, pins and axles are drawn whole in sections of an assembly (ISO 128-3).
    cut_in_sections: ClassVar[bool] = True

    @abstractmethod
    def solid(self) -> cq.Solid:
        """One solid in the part's own frame, mm. Raises ``ValueError`` where the dimensions give none."""

    def in_rings(self) -> tuple[Ring, ...]:
        """Its volume as rings on its axis, Z unless :meth:`gyration` says another; of a part that turns with others."""
        return ()

    def gyration(self) -> Gyration:
        """How its volume lies about its axis, within 1 % of the solid's where the part is large in its group."""
        return gyration(self.in_rings())


class HasSource(Protocol):
    """An entry of the catalogue."""

    @property
    def source(self) -> str:
        """Where its figures come from."""


class BoughtPart(Part):
    """A part that is bought; the body is a simple one, its figures are those of its entry."""

    entry: HasSource


class StandardPart(Part):
    """A part that is bought by the name of its standard, which says all of it; its mass is that of its volume."""

    @property
    @abstractmethod
    def designation(self) -> str:
        """What to order, such as ``ISO 2338 - 2 m6 x 6``."""

    @abstractmethod
    def volume_mm3(self) -> float:
        """Volume in closed form from the same dimensions, within 1 % of the solid's."""


class MadePart(Part):
    """A part that is made, not bought."""

    @abstractmethod
    def volume_mm3(self) -> float:
        """Volume in closed form from the same dimensions, within 1 % of the solid's."""

    @abstractmethod
    def sheet(self, part: str) -> Sheet:
        """Content of its drawing under the name ``part``."""

    def tapped(self) -> MadePart | None:
        """It with its tapped holes at their tap drills; None if it has none, or does not know them."""
        return None

    def in_views(self) -> MadePart:
        """What the views of its sheet show: the part itself, or without a feature that only the tables state."""
        return self

    def holes(self, part: str) -> list[dict[str, Any]]:
        """The holes of the sheet's table as plain data; an empty list if it has none."""
        return [group.data() for group in self.sheet(part).holes]
