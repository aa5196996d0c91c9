"""The bill of an assembly: parts with the functions that draw them, instances with their places, moving bodies.

This module needs no CAD kernel: if all parts are in the cache, a build draws nothing.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, Literal

from mbcdm_cad.design.bought import Bearing, InsertSpec, Material, Screw
from mbcdm_cad.parts.item import Item
from mbcdm_cad.parts.placement import Placement, Vector

CABLE = "cable_"
FIXED = "fixed"


@dataclass(frozen=True)
class PartSpec:
    """The function that draws one part, ``module:function``, and its arguments (plain data only).

    ``drilled``: the arguments that draw its tapped holes at their tap drills; None if it has no tapped holes.
    """

    name: str
    maker: str
    args: tuple[Any, ...]
    drilled: tuple[Any, ...] | None = None


@dataclass(frozen=True)
class MovingBody:
    """A group of items that turn together, with its axis and its angle.

    ``origin_mm`` is a point of the axis and the origin of the frame in which the group's items are placed;
    ``numerator_mm`` / ``denominator_mm`` are the radii whose ratio is the body's angle about ``axis`` per angle of the
    drum, with its sign.
    """

    name: str
    kind: Literal["drum", "passed", "input"]
    origin_mm: Vector
    axis: Vector
    numerator_mm: float = 1.0
    denominator_mm: float = 1.0

    @property
    def turns_per_drum(self) -> float:
        """Angle of the body about its axis for one of the drum."""
        return self.numerator_mm / self.denominator_mm

    def motion(self, drum_angle_deg: float) -> Placement:
        """The group's frame with the drum at ``drum_angle_deg``."""
        turned = Placement.about(self.axis, drum_angle_deg * self.numerator_mm / self.denominator_mm)
        return Placement.translation(*self.origin_mm) @ turned


@dataclass(frozen=True)
class Bill:
    """Parts by name and all their instances at one drum angle."""

    drum_angle_deg: float
    parts: dict[str, PartSpec]
    items: tuple[Item, ...]


@dataclass(frozen=True)
class AssemblyStep:
    """One step: what to do, and the items of the assembly that join in it, in this order."""

    text: str
    items: tuple[str, ...] = ()


def cable_item(cable_name: str) -> str:
    """Name of a cable's item and part; its prefix is unique, whatever name the design gives the cable."""
    return CABLE + cable_name.removeprefix(CABLE)


class BillBuilder:
    """Collects parts and items at one drum angle; a part is registered by its first instance.

    Items of the group ``"fixed"`` stand still, those of a moving body turn with it. ``materials`` holds those of the
    catalogue that bought parts are made of.
    """

    def __init__(self, bodies: Iterable[MovingBody], drum_angle_deg: float) -> None:
        self.angle_deg = drum_angle_deg
        self.motions = {FIXED: Placement.identity(), **{body.name: body.motion(drum_angle_deg) for body in bodies}}
        self.parts: dict[str, PartSpec] = {}
        self.items: list[Item] = []

    def add(
        self,
        name: str,
        maker: str,
        args: tuple[Any, ...],
        *,
        part: str | None = None,
        material: Material,
        group: str = FIXED,
        place: Placement | None = None,
        mass_g: float | None = None,
    ) -> None:
        """An instance called ``name`` of ``part`` (of its own name if not given); bought where it has a mass."""
        stem = part or name
        self.parts.setdefault(stem, PartSpec(stem, maker, args))
        location = self.motions[group] @ (place or Placement.identity())
        self.items.append(Item(name, stem, material, "made" if mass_g is None else "bought", location, group, mass_g))

    def drilled(self, part: str, *args: Any) -> None:
        """The arguments that draw ``part``, which was added, with its tapped holes at their tap drills."""
        self.parts[part] = replace(self.parts[part], drilled=args)

    def screw(self, name: str, screw: Screw, material: Material, place: Placement, group: str = FIXED) -> None:
        """A screw of the catalogue."""
        self.add(
            name,
            "mbcdm_cad.parts.bought.draw:create_screw",
            (screw,),
            part=f"screw_{screw.name}",
            material=material,
            group=group,
            place=place,
            mass_g=screw.mass_g,
        )

    def insert(self, name: str, insert: InsertSpec, brass: Material, place: Placement, group: str = FIXED) -> None:
        """A heat-set insert of the catalogue, below z = 0 of its place."""
        self.add(
            name,
            "mbcdm_cad.parts.bought.draw:create_insert",
            (insert,),
            part=f"insert_{insert.name}",
            material=brass,
            group=group,
            place=place,
            mass_g=insert.mass_g,
        )

    def bearing(self, name: str, bearing: Bearing, material: Material, place: Placement, group: str = FIXED) -> None:
        """A bearing of the catalogue."""
        self.add(
            name,
            "mbcdm_cad.parts.bought.draw:create_bearing",
            (bearing,),
            part="bearing_" + bearing.name.replace("/", "-"),
            material=material,
            group=group,
            place=place,
            mass_g=bearing.mass_g,
        )

    def bill(self) -> Bill:
        """The bill with all parts and items that were added."""
        return Bill(self.angle_deg, self.parts, tuple(self.items))
