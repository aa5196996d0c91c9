"""Turned parts: round rings and pins (swaged stops, nuts, pins), axis Z from z = 0; idlers, the drum's shaft, axles.

An idler is a stepped pulley that cables pass, smooth, with a bearing in each end; two of its steps may be flanges. The
drum's shaft is hollow, with a flange, and comes with the spring that preloads its bearings. An axle of a guide or idler
has a collar that carries the lower bearing's inner ring, and a spacer above it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import cos, pi, radians, sin, sqrt

from mbcdm_cad.parts.fits import FITS, Datum, GeometricTolerance, thread
from mbcdm_cad.parts.milled import PlainRing, Point2, Step, Turned, cut, cylinder_z, hexagon_z
from mbcdm_cad.parts.part import MadePart, Ring, StandardPart, cq, ring_mm3, segment_mm2
from mbcdm_cad.parts.sheet import FitLine, Label, Linear, Sheet, Table, Vector, View, Y, minus, mm3
from mbcdm_cad.parts.sheet_blocks import ALONG_Y, ALONG_Z, MAIN

_SMALLEST_ISO_NUT_MM = 1.6


@dataclass(frozen=True)
class Sleeve(PlainRing, MadePart):
    """Stop swaged on a cable's end; sizes in mm."""

    what = "sleeve"

    bore_radius: float
    radius: float
    length: float

    def ring(self) -> Ring:
        """Round the cable."""
        return (self.radius, self.bore_radius, 0.0, self.length)

    def sheet(self, part: str) -> Sheet:
        """Stop, after it is swaged on the cable's end."""
        bore_radius, radius, length = self.bore_radius, self.radius, self.length
        return Sheet(
            part=part,
            title="Cable stop, swaged",
            views=(ALONG_Z.view(0.0, length, section=True),),
            dimensions=(
                ALONG_Z.diameter(bore_radius, 0.0, "left"),
                ALONG_Z.diameter(radius, length, "right", decimals=3),
                ALONG_Z.length(0.0, length, "below", (radius, radius), decimals=3),
            ),
            notes=("Sizes after swaging on the cable; the sleeve before swaging is that of the rope's maker.",),
        )


@dataclass(frozen=True)
class Nut(StandardPart):
    """Hexagon nut; sizes in mm, the thread a plain bore at its diameter."""

    cut_in_sections = False

    across_flats: float
    height: float
    thread: float

    def solid(self) -> cq.Solid:
        """Hexagon nut; the thread is a plain bore at the nominal diameter."""
        across_flats, height, thread = self.across_flats, self.height, self.thread
        return cut(hexagon_z(across_flats, 0.0, height), [cylinder_z(thread / 2, 0, 0, -1.0, height + 1.0)], "nut")

    def in_rings(self) -> tuple[Ring, ...]:
        """As round as a circle that is wider than its flats by a twentieth: of the hexagon's area."""
        return ((1.05 * self.across_flats / 2, self.thread / 2, 0.0, self.height),)

    def volume_mm3(self) -> float:
        """Hexagon nut."""
        across_flats, height, thread = self.across_flats, self.height, self.thread
        return sqrt(3) / 2 * across_flats**2 * height - ring_mm3(thread / 2, 0.0, height)

    @property
    def designation(self) -> str:
        """The standard's name: ISO 4032 from M1.6 on; smaller nuts are those of DIN 934."""
        standard = "ISO 4032" if self.thread >= _SMALLEST_ISO_NUT_MM else "DIN 934"
        return f"{standard} - {thread(self.thread).name}"


def _chamfers_mm3(radius: float, chamfer: float) -> float:
    """What the chamfers at both ends of a pin take."""
    return 2 * pi * chamfer**2 * (radius - chamfer / 3)


@dataclass(frozen=True)
class PlainPin(PlainRing):
    """Pin with chamfered ends; sizes in mm."""

    what = "pin"
    cut_in_sections = False

    radius: float
    length: float

    @property
    def chamfers_mm(self) -> Point2:  # type: ignore[override]
        """Those of a thin pin are smaller."""
        return (min(0.3, self.radius / 3),) * 2

    def ring(self) -> Ring:
        """Solid."""
        return (self.radius, 0.0, 0.0, self.length)

    def volume_mm3(self) -> float:
        """Pin with chamfered ends."""
        return super().volume_mm3() - _chamfers_mm3(self.radius, self.chamfers_mm[0])


class Dowel(PlainPin, StandardPart):
    """Dowel of a length that the standard has."""

    @property
    def designation(self) -> str:
        """The standard's name."""
        return f"ISO 2338 - {2 * self.radius:g} {FITS['pin'].code} x {self.length:g}"


class Pin(PlainPin, MadePart):
    """Pin of a length of its own, cut from a ground rod or a longer dowel."""

    def sheet(self, part: str) -> Sheet:
        """Parallel pin."""
        radius, length, chamfer = self.radius, self.length, self.chamfers_mm[0]
        fit = FITS["pin"].code
        return Sheet(
            part=part,
            title="Parallel pin",
            views=(ALONG_Z.view(0.0, length, section=False),),
            dimensions=(
                ALONG_Z.diameter(radius, chamfer, "left", fit=fit),
                ALONG_Z.length(0.0, length, "below", (radius - chamfer, radius - chamfer)),
                ALONG_Z.chamfer(chamfer, radius, length, -1.0, "above", count=2),
            ),
            fits=(FitLine(2 * radius, fit, "pin"),),
            notes=("May be cut from a longer parallel pin of ISO 2338 or ISO 8734.",),
        )


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
class IdlerPulley(Turned, MadePart):
    """Idler pulley where it stands in the assembly, axis Z."""

    what = "idler pulley"

    dims: IdlerDims
    title: str = "Guide pulley"

    def steps(self) -> tuple[Step, ...]:
        """Lands and flanges."""
        levels = (self.dims.bottom_z, *self.dims.walls_z, self.dims.top_z)
        return tuple((r, low, high) for r, (low, high) in zip(self.dims.surface_radii, pairwise(levels), strict=True))

    def bores(self) -> tuple[Step, ...]:
        """Seats, and the bore between them."""
        d = self.dims
        low, high = d.bottom_z + d.seat_depth, d.top_z - d.seat_depth
        return ((d.seat_radius, d.bottom_z, low), (d.shoulder_radius, low, high), (d.seat_radius, high, d.top_z))

    def sheet(self, part: str) -> Sheet:
        """Section along the axis; the steps as a table from end A, the lower end."""
        dims, steps = self.dims, self.steps()
        low, high = dims.bottom_z, dims.top_z
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
            for n, (radius, a, b) in enumerate(steps, 1)
        )
        rows = tuple(
            (str(n), mm3(2 * radius), land, "end" if end == high else mm3(end - low))
            for n, (radius, _, end) in enumerate(steps, 1)
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
                ALONG_Z.run_out(tuple((r, (a + b) / 2) for r, a, b in steps), 0.01, "D"),
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


# Depth of the flats for the hub's set screws: the burr of a screw then lies below the shaft's surface (estimate).
FLAT_DEPTH_MM = 0.3
# At 45 degrees, on every outer edge that is chamfered.
CHAMFER_MM = 0.3


@dataclass(frozen=True)
class DrumShaftDims:
    """Hollow shaft: flange behind the rear bearing, hub clamped in front, encoder at the back."""

    radius: float
    bore_radius: float
    y_start: float
    y_end: float
    flange_radius: float
    flange_start_y: float
    flange_end_y: float
    rear_bearing_y: float
    front_bearing_y: float
    flat_y: float  # middle of the two flats
    flat_length: float
    flat_angles_deg: tuple[float, float]  # directions in which the flats face, from +Z towards +X

    @property
    def flat(self) -> float:
        """From the axis to each flat."""
        return self.radius - FLAT_DEPTH_MM


@dataclass(frozen=True)
class PreloadSpringDims:
    """Wave spring that presses the two bearings apart, so that neither has play; bought, drawn as a plain ring."""

    inner_radius: float
    outer_radius: float
    height: float  # pressed to its force
    start_y: float
    force_N: float
    source: str


_FLATS = "flats"


def _facing(dims: DrumShaftDims, index: int) -> Vector:
    angle = radians(dims.flat_angles_deg[index])
    return (sin(angle), 0.0, cos(angle))


def _flats(dims: DrumShaftDims) -> tuple[Linear, ...]:
    """Where the flats stand along the shaft and what is left of its diameter there."""
    down = _facing(dims, 1)

    def point(out: float, y: float) -> Vector:
        return (down[0] * out, y, down[2] * out)

    low, high = dims.flat_y - dims.flat_length / 2, dims.flat_y + dims.flat_length / 2
    return (
        Linear(_FLATS, point(dims.flat, low), point(dims.flat, high), dims.flat_length, "below", "2x "),
        Linear(_FLATS, point(dims.flat, high), point(dims.radius, dims.y_end), dims.y_end - high, "below"),
        Linear(
            _FLATS,
            point(dims.flat, high),
            point(-dims.radius, high),
            dims.flat + dims.radius,
            "right",
            "2x ",
            " over flat",
        ),
    )


@dataclass(frozen=True)
class DrumShaft(Turned, MadePart):
    """Drum shaft where it stands in the assembly, axis Y."""

    what, about_y, chamfers_mm = "drum shaft", True, (CHAMFER_MM, CHAMFER_MM)

    dims: DrumShaftDims

    def steps(self) -> tuple[Step, ...]:
        """Shaft with its flange."""
        d = self.dims
        start, end = d.flange_start_y, d.flange_end_y
        return ((d.radius, d.y_start, start), (d.flange_radius, start, end), (d.radius, end, d.y_end))

    def bores(self) -> tuple[Step, ...]:
        """All through, if it is hollow."""
        return ((self.dims.bore_radius, self.dims.y_start, self.dims.y_end),)

    def cuts(self) -> list[cq.Shape]:
        """Its flats."""
        d, origin, y = self.dims, cq.Vector(0.0, 0.0, 0.0), cq.Vector(0.0, 1.0, 0.0)
        low, r = d.flat_y - d.flat_length / 2, d.radius
        box = cq.Solid.makeBox(2 * r, d.flat_length, r, cq.Vector(-r, low, d.flat))
        return [box.rotate(origin, y, deg) for deg in d.flat_angles_deg]

    def volume_mm3(self) -> float:
        """Hollow shaft with its flange, less its flats."""
        return super().volume_mm3() - 2 * segment_mm2(self.dims.radius, self.dims.flat) * self.dims.flat_length

    def sheet(self, part: str) -> Sheet:
        """Section along the axis, and the side with the flats."""
        dims = self.dims
        low, high, r = dims.y_start, dims.y_end, dims.radius
        fit = FITS["drum_shaft"].code
        bore = (ALONG_Y.diameter(dims.bore_radius, high, "right"),) if dims.bore_radius > 0.0 else ()
        # Square on the first flat, so that the second one, a right angle on, stands in the outline below.
        axis = ((0.0, low, 0.0), (0.0, high, 0.0))
        on_flat = View(_FLATS, Y, minus(_facing(dims, 1)), row=-1, title="On a flat", axes=(axis,))
        return Sheet(
            part=part,
            title="Drum shaft",
            views=(ALONG_Y.view(low, high, section=True), on_flat),
            dimensions=(
                *bore,
                ALONG_Y.diameter(r, low + CHAMFER_MM, "left", fit=fit, count=2, datum="D"),
                ALONG_Y.diameter(dims.flange_radius, dims.flange_start_y, "left"),
                ALONG_Y.length(low, dims.flange_start_y, "below", (r, dims.flange_radius)),
                ALONG_Y.length(
                    dims.flange_start_y, dims.flange_end_y, "below", (dims.flange_radius, dims.flange_radius)
                ),
                ALONG_Y.length(low, high, "below", (r - CHAMFER_MM, r - CHAMFER_MM)),
                ALONG_Y.chamfer(CHAMFER_MM, r, high, -1.0, "above", count=2),
                *_flats(dims),
            ),
            tolerances=(ALONG_Y.square((r, dims.flange_radius), (dims.flange_end_y, dims.flange_start_y), 0.01, "D"),),
            fits=(FitLine(2 * r, fit, "bearings, encoder, hub"),),
            notes=("Outside ground, Ra 0.4.", "Flats for the hub's set screws at a right angle to each other."),
        )


# At 45 degrees, on both ends of the axle.


@dataclass(frozen=True)
class AxleDims:
    """Axle between two plates, of an idler or the guide, with a collar below the bearing and a spacer above."""

    radius: float
    bottom_z: float
    top_z: float
    collar_radius: float
    collar_bottom_z: float
    collar_top_z: float
    spacer_bottom_z: float
    spacer_top_z: float


@dataclass(frozen=True)
class Axle(Turned, MadePart):
    """Axle where it stands in the assembly, axis Z."""

    what, chamfers_mm = "axle", (CHAMFER_MM, CHAMFER_MM)
    cut_in_sections = False

    dims: AxleDims
    title: str = "Guide axle"

    def steps(self) -> tuple[Step, ...]:
        """Axle with its collar."""
        d = self.dims
        low, high = d.collar_bottom_z, d.collar_top_z
        return ((d.radius, d.bottom_z, low), (d.collar_radius, low, high), (d.radius, high, d.top_z))

    def volume_mm3(self) -> float:
        """With its chamfers."""
        return super().volume_mm3() - _chamfers_mm3(self.dims.radius, min(CHAMFER_MM, self.dims.radius / 3))

    def sheet(self, part: str) -> Sheet:
        """View from the side; the axle is solid, so it is not cut."""
        dims = self.dims
        low, high, r, collar = dims.bottom_z, dims.top_z, dims.radius, dims.collar_radius
        fit = FITS["idler_axle"].code
        return Sheet(
            part=part,
            title=self.title,
            views=(ALONG_Z.view(low, high, section=False),),
            dimensions=(
                ALONG_Z.diameter(r, low + CHAMFER_MM, "left", fit=fit, count=2, datum="D"),
                ALONG_Z.diameter(collar, dims.collar_top_z, "right"),
                ALONG_Z.length(low, dims.collar_bottom_z, "below", (r - CHAMFER_MM, collar)),
                ALONG_Z.length(dims.collar_bottom_z, dims.collar_top_z, "below", (collar, collar), decimals=3),
                ALONG_Z.length(low, high, "below", (r - CHAMFER_MM, r - CHAMFER_MM), decimals=3),
                ALONG_Z.chamfer(CHAMFER_MM, r, high, -1.0, "above", count=2),
            ),
            fits=(FitLine(2 * r, fit, "bearings, shelf, top plate"),),
            tolerances=(ALONG_Z.square((r, collar), (dims.collar_top_z, dims.collar_bottom_z), 0.01, "D"),),
            notes=("Bearing journals Ra 0.8.",),
        )


@dataclass(frozen=True)
class Spacer(PlainRing, MadePart):
    """Spacer above the upper bearing's inner ring, where it stands in the assembly, axis Z."""

    what = "spacer"

    dims: AxleDims
    title: str = "Guide spacer"
    note: str = "Ground to the length that leaves the guide's bearings free of play."

    def ring(self) -> Ring:
        """Round the axle."""
        return (self.dims.collar_radius, self.dims.radius, self.dims.spacer_bottom_z, self.dims.spacer_top_z)

    def sheet(self, part: str) -> Sheet:
        """Section along the axis."""
        dims = self.dims
        low, high = dims.spacer_bottom_z, dims.spacer_top_z
        fit, middle = FITS["spacer_bore"].code, (dims.radius + dims.collar_radius) / 2
        return Sheet(
            part=part,
            title=self.title,
            views=(ALONG_Z.view(low, high, section=True),),
            dimensions=(
                ALONG_Z.diameter(dims.radius, low, "left", fit=fit),
                ALONG_Z.diameter(dims.collar_radius, high, "right"),
                ALONG_Z.length(low, high, "below", (dims.collar_radius, dims.collar_radius), decimals=3),
            ),
            fits=(FitLine(2 * dims.radius, fit, "bore"),),
            datums=(Datum(MAIN, ALONG_Z.point(middle, low), "E"),),
            tolerances=(GeometricTolerance(MAIN, ALONG_Z.point(middle, high), "parallelism", 0.01, ("E",)),),
            notes=(self.note,),
        )
