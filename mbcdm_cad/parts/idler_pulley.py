"""Idler: a stepped pulley that cables pass, smooth, with a bearing in each end; two of its steps may be flanges."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

from mbcdm_cad.parts.fits import FITS
from mbcdm_cad.parts.part import MadePart
from mbcdm_cad.parts.shapes import Point2, turned
from mbcdm_cad.parts.sheets.description import FitLine, Label, Sheet, Table, mm3
from mbcdm_cad.parts.sheets.turned import ALONG_Z, MAIN
from mbcdm_cad.parts.volume import Ring, rings_mm3

if TYPE_CHECKING:
    import cadquery as cq


@dataclass(frozen=True)
class IdlerDims:
    """Idler pulley: smooth steps, a bearing in each end."""

    bottom_z: float
    top_z: float
    surface_radii: tuple[float, ...]
    walls_z: tuple[float, ...]
    seat_radius: float
    seat_depth: float
    shoulder_radius: float

    @property
    def flanged(self) -> bool:
        """Whether the steps at both ends are flanges."""
        return len(self.surface_radii) == 3 and self.surface_radii[1] < min(
            self.surface_radii[0], self.surface_radii[2]
        )

    @property
    def bearings_mm(self) -> tuple[float, float]:
        """Middles of the bearings along the axis."""
        return self.bottom_z + self.seat_depth / 2, self.top_z - self.seat_depth / 2


@dataclass(frozen=True)
class IdlerPulley(MadePart):
    """Idler pulley where it stands in the assembly, axis Z."""

    dims: IdlerDims
    title: str = "Guide pulley"

    def solid(self) -> cq.Solid:
        """Idler pulley where it stands in the assembly, axis Z."""
        dims = self.dims
        levels = [dims.bottom_z, *dims.walls_z, dims.top_z]
        outside: list[Point2] = []
        for radius, low, high in zip(dims.surface_radii, levels[:-1], levels[1:], strict=True):
            outside += [(radius, low), (radius, high)]
        inside: list[Point2] = [
            (dims.seat_radius, dims.top_z),
            (dims.seat_radius, dims.top_z - dims.seat_depth),
            (dims.shoulder_radius, dims.top_z - dims.seat_depth),
            (dims.shoulder_radius, dims.bottom_z + dims.seat_depth),
            (dims.seat_radius, dims.bottom_z + dims.seat_depth),
            (dims.seat_radius, dims.bottom_z),
        ]
        return turned(outside + inside, "idler pulley")

    def in_rings(self) -> tuple[Ring, ...]:
        """Its steps less seats and bore."""
        d = self.dims
        levels = [d.bottom_z, *d.walls_z, d.top_z]
        steps = zip(d.surface_radii, levels[:-1], levels[1:], strict=True)
        low, high = d.bottom_z + d.seat_depth, d.top_z - d.seat_depth
        return (
            *((r, 0.0, a, b) for r, a, b in steps),
            (0.0, d.seat_radius, d.bottom_z, low),
            (0.0, d.shoulder_radius, low, high),
            (0.0, d.seat_radius, high, d.top_z),
        )

    def volume_mm3(self) -> float:
        """Idler pulley: its steps less seats and bore."""
        return rings_mm3(self.in_rings())

    def sheet(self, part: str) -> Sheet:
        """Section along the axis; the steps as a table from end A, the lower end."""
        dims = self.dims
        low, high = dims.bottom_z, dims.top_z
        levels = (low, *dims.walls_z, high)
        seat, land = FITS["idler_seat"].code, FITS["land"].code
        largest = max(dims.surface_radii)
        dimensions = (
            ALONG_Z.diameter(dims.seat_radius, low, "left", fit=seat, count=2, datum="D"),
            ALONG_Z.diameter(dims.shoulder_radius, high - dims.seat_depth, "right"),
            ALONG_Z.length(low, low + dims.seat_depth, "below", (dims.surface_radii[0], dims.seat_radius), count=2),
            ALONG_Z.length(low, high, "below", (dims.surface_radii[0], dims.surface_radii[-1]), decimals=3),
        )
        labels = tuple(
            Label(MAIN, ALONG_Z.point(radius, (a + b) / 2), str(n), leader=True)
            for n, (radius, (a, b)) in enumerate(zip(dims.surface_radii, pairwise(levels), strict=True), 1)
        )
        rows = tuple(
            (str(n), mm3(2 * radius), land, "end" if end == high else mm3(end - low))
            for n, (radius, end) in enumerate(zip(dims.surface_radii, levels[1:], strict=True), 1)
        )
        return Sheet(
            part=part,
            title=self.title,
            views=(ALONG_Z.view(low, high, section=True),),
            dimensions=dimensions,
            labels=(*labels, Label(MAIN, ALONG_Z.point(-(dims.seat_radius + largest) / 2, low), "A", leader=True)),
            tables=(Table("Steps, ends measured from face A", ("Step", "%%c", "Fit", "ends at"), rows),),
            fits=(
                FitLine(2 * dims.seat_radius, seat, "bearing seats"),
                *(FitLine(round(2 * r, 6), land, f"step {n}") for n, r in enumerate(dims.surface_radii, 1)),
            ),
            tolerances=(
                ALONG_Z.run_out(
                    tuple((r, (a + b) / 2) for r, (a, b) in zip(dims.surface_radii, pairwise(levels), strict=True)),
                    0.01,
                    "D",
                ),
                ALONG_Z.square(
                    (dims.shoulder_radius, dims.seat_radius), (low + dims.seat_depth, high - dims.seat_depth), 0.01, "D"
                ),
            ),
            notes=(
                "Steps: Ra 0.8; corner between land and flange at most R0.2."
                if dims.flanged
                else "Steps: Ra 0.8, no flanges; corner between two steps at most R0.05.",
            ),
        )
