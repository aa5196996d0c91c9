"""Items of an assembly: named instances of parts, as plain numbers; the solids are stored separately."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Literal

from mbcdm_cad.design.bought import Material
from mbcdm_cad.parts.placement import Placement

# Names are used as file stems, STEP products and nodes of the GLB, so only characters valid in all three are allowed.
# Long enough for a name of the design file (64) with a word before and a number after it.
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,95}")


@dataclass(frozen=True)
class Item:
    """One instance of a part. ``part`` is the file stem that all instances of one part share.

    ``group`` names what moves together ("fixed", "drum", ...). ``mass_g`` is the catalogue mass of a bought item;
    None where the mass follows from volume and the material's density.
    """

    name: str
    part: str
    material: Material
    kind: Literal["made", "bought"]
    location: Placement
    group: str
    mass_g: float | None = None


def sorted_items(items: Sequence[Item], parts: Collection[str]) -> list[Item]:
    """The items sorted by group, then name: the order in all files, independent of the order of creation.

    Raises ``ValueError`` naming the item if a name is not plain or not unique, if its part has no solid, or if two
    instances of a part differ in material, kind or mass.
    """
    seen: set[str] = set()
    first_of_part: dict[str, Item] = {}
    for item in items:
        for what, text in (("name", item.name), ("part", item.part), ("group", item.group)):
            if not _NAME.fullmatch(text):
                raise ValueError(f"{what} {text!r} of item {item.name!r} must match {_NAME.pattern}")
        if item.name in seen:
            raise ValueError(f"two items are named {item.name!r}: number the instances")
        if item.part not in parts:
            raise ValueError(f"item {item.name!r} is of part {item.part!r}, which has no solid: {sorted(parts)}")
        seen.add(item.name)
        first = first_of_part.setdefault(item.part, item)
        if (item.material, item.kind, item.mass_g) != (first.material, first.kind, first.mass_g):
            raise ValueError(f"{first.name!r} and {item.name!r} are one part but differ in material, kind or mass")
    return sorted(items, key=lambda item: (item.group, item.name))
