"""The bill of an assembly: parts, their instances (items) with places as plain numbers, moving bodies.

A place is a rigid motion as plain numbers. This module needs no CAD kernel: if all parts are in the cache, a build
draws nothing."""

import math
import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.design.bought import Bearing, InsertSpec, Material, Screw
from mbcdm_cad.parts.bodies import BearingBody, InsertBody, ScrewBody
from mbcdm_cad.parts.part import MadePart, Part, StandardPart

Row = tuple[float, float, float, float]
Vector = tuple[float, float, float]

_ORTHONORMAL_LIMIT = 1e-9


@dataclass(frozen=True)
class Placement:
    """Rigid motion from a part's own frame to the assembly's: the upper three rows of the 4 x 4 matrix, in mm.

    Raises ``ValueError`` for a matrix that scales, shears, mirrors or holds a number that is not finite.
    """

    rows: tuple[Row, Row, Row]

    def __post_init__(self) -> None:
        # Plain arithmetic: thousands of placements are made for one design, and small arrays are slow.
        if not all(math.isfinite(value) for row in self.rows for value in row):
            raise ValueError(f"placement holds a number that is not finite: {self.rows}")
        (a, b, c, _), (d, e, f, _), (g, h, i, _) = self.rows
        lengths = (a * a + b * b + c * c - 1.0, d * d + e * e + f * f - 1.0, g * g + h * h + i * i - 1.0)
        slants = (a * d + b * e + c * f, a * g + b * h + c * i, d * g + e * h + f * i)
        error = max(abs(value) for value in lengths + slants)
        determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
        if error > _ORTHONORMAL_LIMIT or determinant < 0.0:
            raise ValueError(
                f"placement is not a rigid motion: R R^T differs from 1 by {error:.3g} (limit {_ORTHONORMAL_LIMIT:g}), "
                f"det R = {determinant:.6g} (must be +1): {self.rows}"
            )

    @classmethod
    def identity(cls) -> "Placement":
        """The part's frame is the assembly's frame."""
        return cls.translation(0.0, 0.0, 0.0)

    @classmethod
    def translation(cls, x_mm: float, y_mm: float, z_mm: float) -> "Placement":
        """A shift without rotation."""
        return cls(((1.0, 0.0, 0.0, x_mm), (0.0, 1.0, 0.0, y_mm), (0.0, 0.0, 1.0, z_mm)))

    @classmethod
    def about(cls, axis: Vector, angle_deg: float, point_mm: Vector = (0.0, 0.0, 0.0)) -> "Placement":
        """Right-handed rotation by ``angle_deg`` about the line through ``point_mm`` along ``axis`` (any length).

        Multiples of 90 degrees about a coordinate axis come out exact (no 6e-17 in the files).
        """
        length = math.hypot(*axis)
        if length == 0.0:
            raise ValueError(f"rotation by {angle_deg} deg has no axis: {axis}")
        x, y, z = (component / length for component in axis)
        quarter_turns, remainder = divmod(angle_deg, 90.0)
        if remainder == 0.0:
            cosine, sine = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(quarter_turns) % 4]
        else:
            cosine, sine = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
        rest = 1.0 - cosine
        rotation = np.array(
            [
                [cosine + x * x * rest, x * y * rest - z * sine, x * z * rest + y * sine],
                [y * x * rest + z * sine, cosine + y * y * rest, y * z * rest - x * sine],
                [z * x * rest - y * sine, z * y * rest + x * sine, cosine + z * z * rest],
            ]
        )
        point = np.array(point_mm)
        return cls._of(rotation, point - rotation @ point)

    @classmethod
    def _of(cls, rotation: NDArray[np.float64], shift: NDArray[np.float64]) -> "Placement":
        rows = np.column_stack((rotation, shift)) + 0.0
        first, second, third = ((float(a), float(b), float(c), float(d)) for a, b, c, d in rows)
        return cls((first, second, third))

    @property
    def rotation(self) -> NDArray[np.float64]:
        """The 3 x 3 rotation matrix."""
        return np.array(self.rows)[:, :3]

    @property
    def shift_mm(self) -> NDArray[np.float64]:
        """Place of the part's origin in the assembly, mm, shape (3,)."""
        return np.array(self.rows)[:, 3]

    def __matmul__(self, inner: "Placement") -> "Placement":
        """``(a @ b)`` moves by b first, then by a."""
        (r0, r1, r2), columns = self.rows, tuple(zip(*inner.rows, strict=True))
        return Placement((_times(r0, columns), _times(r1, columns), _times(r2, columns)))

    @property
    def inverse(self) -> "Placement":
        """The inverse motion."""
        back = self.rotation.T
        return self._of(back, -back @ self.shift_mm)

    def apply(self, points_mm: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points (..., 3) of the part's frame in the assembly's frame, mm."""
        return np.asarray(points_mm) @ self.rotation.T + self.shift_mm


def _times(row: Row, columns: tuple[tuple[float, ...], ...]) -> Row:
    """One row of the product of two placements."""
    a, b, c, shift = row
    x, y, z, along = (a * u + b * v + c * w for u, v, w in columns)
    # Adding 0.0 turns -0.0 into 0.0, so that equal placements are written alike.
    return x + 0.0, y + 0.0, z + 0.0, along + shift + 0.0


# Turns parts that are drawn along +Z to +Y, to -Y and to -Z.
ALONG_Y, AGAINST_Y, UPSIDE_DOWN = (Placement.about((1.0, 0.0, 0.0), angle_deg) for angle_deg in (-90.0, 90.0, 180.0))
# File stems, STEP products and nodes of the GLB; long enough for an entry (128, as below) and a cable (64) in one name.
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,219}")


def entry_stem(kind: str, name: str) -> str:
    """Part of a catalogue entry, such as bearing_618-4 of 618/4: no other entry of the kind has the same."""
    signs = {"/": "_-", "+": "_P", "_": "__"} | ({"/": "-", "-": "_-"} if kind == "bearing" else {})
    return f"{kind}_{''.join(signs.get(sign, sign) for sign in name)}"


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


CABLE = "cable_"
FIXED = "fixed"
_Body = ScrewBody | InsertBody | BearingBody


@dataclass(frozen=True)
class PartSpec:
    """A part with the name of its files. ``drilled``: it with its tapped holes at their tap drills, if it has any."""

    name: str
    part: Part
    drilled: Part | None = None


@dataclass(frozen=True)
class MovingBody:
    """A group of items that turn together, with its axis and its angle.

    ``origin_mm`` is a point of the axis and the origin of the frame in which the group's items are placed;
    ``numerator_mm`` / ``denominator_mm`` are the radii whose ratio is the body's angle about ``axis`` per angle of the
    drum, with its sign.
    """

    name: str
    kind: Literal["drum", "passed", "input", "stage"]
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

    @property
    def made(self) -> dict[str, MadePart]:
        """The made parts by name, in the order of their first instance; those of a plain :class:`Part` are left out."""
        names = dict.fromkeys(item.part for item in self.items if item.kind == "made")
        found = {name: self.parts[name].part for name in names}
        return {name: part for name, part in found.items() if isinstance(part, MadePart)}

    @cached_property
    def volumes_mm3(self) -> dict[str, float]:
        """Volume of each made part by its name, in closed form."""
        return {name: part.volume_mm3() for name, part in self.made.items()}

    def inertia_g_mm2(self, body: MovingBody) -> float:
        """Moment of inertia about the axis of ``body`` of all items that turn with it, in closed form."""
        axis, origin, total = np.array(body.axis), np.array(body.origin_mm), 0.0
        for item in self.items:
            if item.group != body.name:
                continue
            own = self.parts[item.part].part.gyration()
            mass_g = item.mass_g
            if mass_g is None:
                mass_g = self.volumes_mm3[item.part] * item.material.density_g_cm3 * 1e-3
            offset = item.location.apply(np.array(own.along) * own.centre_mm) - origin
            share = float(item.location.rotation @ own.along @ axis) ** 2
            apart = float(offset @ offset - (offset @ axis) ** 2)
            total += mass_g * (apart + share * own.about_mm2 + (1.0 - share) * own.across_mm2)
        return total

    def holes(self) -> dict[str, list[dict[str, Any]]]:
        """The holes of each made part that has some, as its sheet's table gives them, by the part's name."""
        found = {name: part.holes(name) for name, part in self.made.items()}
        return {name: holes for name, holes in found.items() if holes}


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
        what: Part,
        *,
        part: str | None = None,
        drilled: Part | None = None,
        material: Material,
        group: str = FIXED,
        place: Placement | None = None,
        mass_g: float | None = None,
    ) -> None:
        """An instance of ``what``, called ``name``, with files called ``part`` (as the instance if not given).

        It is bought where it has a mass; ``drilled`` as in :class:`PartSpec`, where the part does not know it.
        """
        stem = part or name
        if drilled is None and isinstance(what, MadePart):
            drilled = what.tapped()
        self.parts.setdefault(stem, PartSpec(stem, what, drilled))
        location = self.motions[group] @ (place or Placement.identity())
        self.items.append(Item(name, stem, material, "made" if mass_g is None else "bought", location, group, mass_g))

    def standard(
        self, name: str, what: StandardPart, *, part: str, material: Material, place: Placement, group: str = FIXED
    ) -> None:
        """A part of a standard, with the mass of its volume."""
        mass_g = what.volume_mm3() * material.density_g_cm3 * 1e-3
        self.add(name, what, part=part, material=material, group=group, place=place, mass_g=mass_g)

    def screw(self, name: str, screw: Screw, material: Material, place: Placement, group: str = FIXED) -> None:
        """A screw of the catalogue."""
        self._bought(name, ScrewBody(screw), entry_stem("screw", screw.name), material, place, group)

    def insert(self, name: str, insert: InsertSpec, brass: Material, place: Placement, group: str = FIXED) -> None:
        """A heat-set insert of the catalogue, below z = 0 of its place."""
        self._bought(name, InsertBody(insert), entry_stem("insert", insert.name), brass, place, group)

    def bearing(self, name: str, bearing: Bearing, material: Material, place: Placement, group: str = FIXED) -> None:
        """A bearing of the catalogue."""
        self._bought(name, BearingBody(bearing), entry_stem("bearing", bearing.name), material, place, group)

    def _bought(self, name: str, body: _Body, stem: str, material: Material, place: Placement, group: str) -> None:
        self.add(name, body, part=stem, material=material, group=group, place=place, mass_g=body.entry.mass_g)

    def bill(self) -> Bill:
        """The bill with all parts and items that were added."""
        return Bill(self.angle_deg, self.parts, tuple(self.items))
