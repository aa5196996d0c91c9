"""Mass, centre of gravity and inertia, of a part from its shape, of an assembly from its items; a part's cached files.

Masses in g, lengths in mm, inertia in g mm^2 (1 g mm^2 = 1e-9 kg m^2).
"""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.parts.bill import Item, Placement, Vector
from mbcdm_cad.routes.curves import Piece
from mbcdm_cad.workshop.export.files import stl_bytes
from mbcdm_cad.workshop.trianglemesh import TriangleMesh

Matrix = tuple[Vector, Vector, Vector]
_KG_M2_PER_G_MM2 = 1e-9
_CM3_PER_MM3 = 1e-3
# Points on each piece of a rod's centre line; each stands for the same length.
_POINTS = 48


@dataclass(frozen=True)
class ShapeProperties:
    """Volume, centroid and inertia of a solid's shape in its own frame.

    ``inertia_mm5`` is the inertia tensor about the centroid for a density of 1 per mm^3, with the off-diagonal terms
    of a tensor (minus the products of inertia). ``low_mm`` and ``high_mm`` are the corners of the tight box.
    """

    volume_mm3: float
    area_mm2: float
    centroid_mm: Vector
    inertia_mm5: Matrix
    low_mm: Vector
    high_mm: Vector

    def to_json(self) -> str:
        """The properties as JSON text."""
        return json.dumps(asdict(self))

    @classmethod
    def from_json(cls, text: str | bytes) -> "ShapeProperties":
        """The properties from :meth:`to_json`, to the last bit."""
        content = json.loads(text)
        vectors = {name: vector(content[name]) for name in ("centroid_mm", "low_mm", "high_mm")}
        return cls(**content | vectors | {"inertia_mm5": _matrix(content["inertia_mm5"])})


def rod_shape(pieces: Sequence[Piece], radius_mm: float) -> ShapeProperties:
    """Properties of a rod of ``radius_mm`` with flat ends along ``pieces`` (mm).

    Volume and area are exact by Pappus: cross-section and circumference times length. The centroid lies within
    r^2/(4 R) of the centre line's, R the radius of its bends (derived); the box may be the radius too large at an end.
    """
    fraction = (np.arange(_POINTS) + 0.5) / _POINTS
    points = np.concatenate([piece.points(fraction) for piece in pieces])
    lengths = np.repeat([piece.length_mm / _POINTS for piece in pieces], _POINTS)
    step = np.concatenate([np.gradient(piece.points(fraction), axis=0) for piece in pieces])
    along = step / np.linalg.norm(step, axis=1)[:, None]
    length, section = float(lengths.sum()), np.pi * radius_mm**2
    centroid = lengths @ points / length
    away = points - centroid
    # Second moments of the line, and of the circular section across it: r^2/4 in both directions.
    spread = np.einsum("k,ki,kj->ij", lengths, away, away)
    spread += radius_mm**2 / 4.0 * (length * np.eye(3) - np.einsum("k,ki,kj->ij", lengths, along, along))
    inertia = section * (np.trace(spread) * np.eye(3) - spread)
    ends = np.concatenate([piece.points(np.array([0.0, 1.0])) for piece in pieces] + [points])
    low, high = ends.min(axis=0) - radius_mm, ends.max(axis=0) + radius_mm
    area = 2.0 * np.pi * radius_mm * (length + radius_mm)
    return ShapeProperties(section * length, area, vector(centroid), _matrix(inertia), vector(low), vector(high))


@dataclass(frozen=True)
class MassProperties:
    """Mass, centre of gravity, and the inertia tensor about it in the directions of the frame in use."""

    mass_g: float
    cog_mm: Vector
    inertia_g_mm2: Matrix

    @property
    def inertia_kg_m2(self) -> Matrix:
        """The inertia tensor about the centre of gravity in SI."""
        return _matrix(np.array(self.inertia_g_mm2) * _KG_M2_PER_G_MM2)

    def placed(self, placement: Placement) -> "MassProperties":
        """The properties of the same body after the motion ``placement``."""
        rotation = placement.rotation
        turned = rotation @ np.array(self.inertia_g_mm2) @ rotation.T
        return MassProperties(self.mass_g, vector(placement.apply(np.array(self.cog_mm))), _matrix(turned))

    def about_axis(self, direction: Vector, point_mm: Vector = (0.0, 0.0, 0.0)) -> float:
        """Moment of inertia in g mm^2 about the line through ``point_mm`` along ``direction`` (any length)."""
        unit = np.array(direction) / np.linalg.norm(direction)
        offset = np.array(self.cog_mm) - np.array(point_mm)
        across = offset - unit * (offset @ unit)
        return float(unit @ np.array(self.inertia_g_mm2) @ unit + self.mass_g * (across @ across))


def item_mass(item: Item, shape: ShapeProperties) -> MassProperties:
    """Mass properties of one item at its place.

    Mass is the item's catalogue mass where it has one, spread evenly over its volume, else volume times density.
    """
    volume_mass_g = item.material.density_g_cm3 * shape.volume_mm3 * _CM3_PER_MM3
    mass_g = volume_mass_g if item.mass_g is None else item.mass_g
    inertia = np.array(shape.inertia_mm5) * (mass_g / shape.volume_mm3)
    return MassProperties(mass_g, shape.centroid_mm, _matrix(inertia)).placed(item.location)


def combined(bodies: Iterable[MassProperties]) -> MassProperties:
    """Mass properties of several bodies together, all seen from one frame (Steiner). Raises ``ValueError`` if none."""
    parts = list(bodies)
    mass_g = sum(part.mass_g for part in parts)
    if not mass_g > 0.0:
        raise ValueError(f"{len(parts)} bodies with {mass_g} g have no centre of gravity")
    cog = sum((part.mass_g * np.array(part.cog_mm) for part in parts), np.zeros(3)) / mass_g
    inertia = np.zeros((3, 3))
    for part in parts:
        offset = np.array(part.cog_mm) - cog
        inertia += np.array(part.inertia_g_mm2) + part.mass_g * (offset @ offset * np.eye(3) - np.outer(offset, offset))
    return MassProperties(mass_g, vector(cog), _matrix(inertia))


def assembly_mass(items: Iterable[Item], shapes: Mapping[str, ShapeProperties]) -> MassProperties:
    """Mass properties of all ``items`` together; ``shapes`` maps each part to its shape's properties."""
    return combined(item_mass(item, shapes[item.part]) for item in items)


def vector(values: Iterable[float] | NDArray[np.float64]) -> Vector:
    """Three numbers of any kind as a vector."""
    x, y, z = (float(value) for value in values)
    return x, y, z


def _matrix(rows: Iterable[Iterable[float]] | NDArray[np.float64]) -> Matrix:
    first, second, third = (vector(row) for row in rows)
    return first, second, third


@dataclass(frozen=True)
class PartFiles:
    """A drawn part: its solid in the kernel's form, STEP file, mesh and measured figures."""

    name: str
    brep: bytes
    step: bytes
    mesh: TriangleMesh
    shape: ShapeProperties

    @property
    def stl(self) -> bytes:
        """The part's STL file."""
        return stl_bytes(self.name, self.mesh)

    @cached_property
    def mesh_volume_error(self) -> float:
        """Volume of the mesh over that of the solid, minus one."""
        return self.mesh.volume_mm3 / self.shape.volume_mm3 - 1.0

    def to_blobs(self) -> dict[str, bytes]:
        """The part as data for the cache, by name."""
        properties = self.shape.to_json().encode()
        return {"brep": self.brep, "step": self.step, "mesh": self.mesh.to_bytes(), "properties": properties}

    @classmethod
    def from_blobs(cls, name: str, blobs: Mapping[str, bytes]) -> "PartFiles":
        """The part from :meth:`to_blobs`."""
        mesh = TriangleMesh.from_bytes(blobs["mesh"])
        return cls(name, blobs["brep"], blobs["step"], mesh, ShapeProperties.from_json(blobs["properties"]))
