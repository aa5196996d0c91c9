"""What a part of the drive is: an object with its dimensions that draws itself; a made one has volume and sheet too."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from mbcdm_cad.parts.volume import Gyration, Ring, gyration

if TYPE_CHECKING:
    import cadquery as cq

    from mbcdm_cad.parts.sheets.description import Sheet


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
