"""The attachment of idlers: their dimensions, those of axles, posts and strap, the strap as a part.

In section through the axis of a pair, y to the right (front), z up; the cables come down between the two idlers:

     plate      post            strap
      | |=======================| |
      | |  collar               | |
      |=|===| idler      |=====||=|  axle
      | |                       | |

Idlers of cables in parallel follow each other on one longer axle, with a spacer between two.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from mbcdm_cad.layouts.base import Attachment
from mbcdm_cad.layouts.siso_spur.routes import flange_radius_mm, idler_body
from mbcdm_cad.model.losses import BearingPair, body_bearings
from mbcdm_cad.parts.bill import ALONG_Y, BillBuilder, Placement
from mbcdm_cad.parts.fits import FITS
from mbcdm_cad.parts.milled import Bores, Feature, Milled, Slab
from mbcdm_cad.parts.sheet import FitLine, Linear, Sheet, View, X, Y, Z, minus
from mbcdm_cad.parts.sheet_blocks import THROUGH, hole_labels, hole_table, position_table
from mbcdm_cad.parts.turned import Axle, AxleDims, IdlerDims, IdlerPulley, Spacer
from mbcdm_cad.routes import Floats

if TYPE_CHECKING:
    from mbcdm_cad.design.bought import Screw
    from mbcdm_cad.layouts.siso_spur.drive import SpurDrive, SpurRun
    from mbcdm_cad.model.si import DriveSI
    from mbcdm_cad.model.structure.causes import Cause

# Thickness of an idler's flanges.
FLANGE_MM = 1.0
# Gap between the spacer on an axle and the strap.
END_PLAY_MM = 0.1
SPACER_NOTE = f"The idlers on the axle keep a play of {END_PLAY_MM:g} mm along it."
# Depth and least width of a post in diameters of its screw: the wall round the thread.
POST_DIAMETERS = 2.4
# Radius of a strap's corners.
CORNER_MM = 2.0
# Strap beside the bores of the axles, in their diameters.
STRAP_WALL = 1.0


@dataclass(frozen=True)
class StandDims:
    """Posts, which are part of the frame, and strap of one pair of idlers where they stand in the assembly; mm."""

    x: float  # of the axle at +x
    z: float
    axle_radius: float
    post_x: tuple[float, float]  # of the post at +x
    post_z: tuple[float, float]
    back_y: float  # of the plate
    front_y: float
    strap_back_y: float
    strap_front_y: float
    half_width: float  # of the strap
    low_z: float
    thread_radius: float
    thread_depth: float
    clearance_radius: float

    @property
    def screw_x(self) -> float:
        """Axis of the screw in the post at +x."""
        return (self.post_x[0] + self.post_x[1]) / 2

    @property
    def supports_mm(self) -> tuple[float, float]:
        """Middles of plate and strap along y, which hold the axles."""
        return (self.back_y + self.front_y) / 2, (self.strap_back_y + self.strap_front_y) / 2

    @property
    def screw_z(self) -> float:
        """Axis of the screws."""
        return (self.post_z[0] + self.post_z[1]) / 2


class Idler(NamedTuple):
    """One idler: its body in the routes, its dimensions along y, its cable, and the number of its pair from 0 on."""

    body: str
    dims: IdlerDims
    cable: SpurRun
    number: int


def idlers(drive: SpurDrive) -> Iterator[Idler]:
    """Each idler, those of the pair next to the input first; on one axle from the back."""
    for n, level in enumerate(drive.idler_levels_mm):
        for k, cable in enumerate(drive.cables):
            middle = drive.level_mm + drive.levels_mm[k // 2] + cable.outward * level
            yield Idler(idler_body(n + 1, cable.name), idler(drive, middle), cable, n)


def idler(drive: SpurDrive, middle_mm: float) -> IdlerDims:
    """Idler with flanges whose middle is at ``middle_mm`` along y."""
    led, bearing = drive.leading, drive.idler_bearing
    d, half = drive.cable.diameter_mm, led.width_mm / 2
    flange = flange_radius_mm(led.radius_mm, d)
    return IdlerDims(
        bottom_z=middle_mm - half - FLANGE_MM,
        top_z=middle_mm + half + FLANGE_MM,
        surface_radii=(flange, led.radius_mm - d / 2, flange),
        walls_z=(middle_mm - half, middle_mm + half),
        seat_radius=bearing.outer_diameter_mm / 2,
        seat_depth=bearing.width_mm,
        shoulder_radius=bearing.outer_shoulder_mm / 2,
    )


def strap_screw(drive: SpurDrive) -> Screw:
    """Screw of a strap: of the thread that mounts the frame, the shortest that engages by its diameter."""
    thread = drive.screw(drive.support.mount_bolt).thread_mm
    long = [s for s in drive.screws if s.thread_mm == thread and s.head_height_mm > 0.0]
    needed = drive.support.encoder_shelf_mm + thread
    return min(long, key=lambda s: (s.length_mm < needed, abs(s.length_mm - needed)))


def stands(drive: SpurDrive, plate_y: tuple[float, float]) -> tuple[StandDims, ...]:
    """Posts and straps of all pairs, from the input on; ``plate_y``: back and front of the plate."""
    if drive.idlers is None:
        return ()
    led, bearing = drive.idlers, drive.idler_bearing
    d, running, screw = drive.cable.diameter_mm, drive.clearances.running_mm, strap_screw(drive)
    flange, wide = flange_radius_mm(led.radius_mm, d), POST_DIAMETERS * screw.thread_mm
    found = []
    for place, level in zip(led.places, drive.idler_levels_mm, strict=True):
        back = drive.level_mm + drive.band_mm + abs(level) + led.width_mm / 2 + FLANGE_MM + END_PLAY_MM + running
        # Beside the cables, which run between the posts towards the input.
        inner = max(abs(place.x_mm - led.radius_mm), drive.input_radius_mm) + d / 2 + 2 * running
        outer = max(place.x_mm + flange, inner + wide)
        low = place.z_mm + flange + running
        found.append(
            StandDims(
                x=place.x_mm,
                z=place.z_mm,
                axle_radius=bearing.bore_mm / 2,
                post_x=(inner, outer),
                post_z=(low, low + wide),
                back_y=plate_y[0],
                front_y=plate_y[1],
                strap_back_y=back,
                strap_front_y=back + drive.support.encoder_shelf_mm,
                half_width=outer,
                low_z=place.z_mm - (0.5 + STRAP_WALL) * bearing.bore_mm,
                thread_radius=screw.thread_mm / 2,
                thread_depth=screw.length_mm - drive.support.encoder_shelf_mm + 0.5 * screw.thread_mm,
                clearance_radius=screw.clearance_mm / 2,
            )
        )
    return tuple(found)


def axle(drive: SpurDrive, stand: StandDims, pin: Sequence[Idler], index: int = 0) -> AxleDims:
    """Axle from the back of the plate to the front of the strap, with its collar; the spacer is that before one idler.

    ``index``: of that idler, which the spacer holds away from the next one, or from the strap.
    """
    bearing, before = drive.idler_bearing, pin[index + 1 :]
    return AxleDims(
        radius=stand.axle_radius,
        bottom_z=stand.back_y,
        top_z=stand.strap_front_y,
        collar_radius=bearing.inner_shoulder_mm / 2,
        collar_bottom_z=stand.front_y,
        collar_top_z=pin[0].dims.bottom_z,
        spacer_bottom_z=pin[index].dims.top_z,
        spacer_top_z=before[0].dims.bottom_z if before else stand.strap_back_y - END_PLAY_MM,
    )


@dataclass(frozen=True)
class Strap(Milled):
    """Strap where it stands in the assembly."""

    what = "strap"

    dims: StandDims

    def bodies(self) -> Sequence[Feature]:
        """A plate with rounded corners."""
        d = self.dims
        y, z = (d.strap_back_y, d.strap_front_y), (d.low_z, d.post_z[1])
        return (Slab((-d.half_width, d.half_width), y, z, CORNER_MM, along="Y"),)

    def taken(self) -> Sequence[Feature]:
        """Bores of the axles and holes of the screws."""
        d, back, front = self.dims, minus(Y), self.dims.strap_front_y
        axles, screws = (
            tuple((side * x, front, z) for side in (-1, 1)) for x, z in ((d.x, d.z), (d.screw_x, d.screw_z))
        )
        thick, bore = front - d.strap_back_y, FITS["axle_bore"].code
        return (
            Bores("A", 2 * d.axle_radius, THROUGH, axles, "front", "axles", fit=bore, into=back, metal=thick),
            Bores("B", 2 * d.clearance_radius, THROUGH, screws, "front", "screws", into=back, metal=thick),
        )

    def sheet(self, part: str) -> Sheet:
        """From the front and from the side; positions from the drum's axis."""
        d = self.dims
        front, high, wide = d.strap_front_y, d.post_z[1], d.half_width
        holes = self.bores()
        return Sheet(
            part=part,
            title="Idler strap",
            views=(View("front", minus(X), Z), View("side", Y, Z, column=1)),
            dimensions=(
                Linear("front", (-wide, front, high), (wide, front, high), 2 * wide, "above"),
                Linear("front", (wide, front, d.low_z), (wide, front, high), high - d.low_z, "left"),
                Linear("side", (0.0, d.strap_back_y, d.low_z), (0.0, front, d.low_z), front - d.strap_back_y, "below"),
            ),
            labels=hole_labels(holes, "front"),
            holes=holes,
            tables=(hole_table(holes), position_table(holes, (0, 2), "Positions from the drum's axis")),
            fits=(FitLine(2 * d.axle_radius, FITS["axle_bore"].code, "axles"),),
            notes=("Corners R2. Bores of the axles together with those of the frame, Ra 1.6.",),
        )


class Idlers(Attachment):
    """Idlers with their bearings, axles, spacers and straps."""

    block = "idlers"

    def add_at_input(self, b: BillBuilder, turn: Placement, mark: str) -> None:
        """Idlers with their bearings, which turn with them, axles and spacers, and the straps with their screws."""
        at, lay, drive = Placement.translation, self.layout, self.layout.drive
        ring, metal, spec = drive.material("bearing-steel"), drive.shaft_material, drive.idler_bearing
        for pin in lay.pins:
            first = pin[0]
            stand = lay.frame.stands[first.number]
            where = turn @ at(first.cable.drum_side * stand.x, 0.0, stand.z)
            tags = [own.body.removeprefix("idler_") for own in pin]
            pulley, between = IdlerPulley(first.dims, "Idler"), axle(drive, stand, pin)
            b.add(f"idler_axle_{tags[0]}", Axle(between, "Idler axle"), material=metal, place=where @ ALONG_Y)
            for k, (tag, (body, own, _, _)) in enumerate(zip(tags, pin, strict=True)):
                # Those of one axle are equal, and so are the spacers between them.
                level, last = at(0.0, drive.levels_mm[k], 0.0), k == len(tags) - 1
                b.add(body, pulley, part=first.body, material=drive.drum_material, group=body, place=level @ ALONG_Y)
                for end, y in (("rear", own.bottom_z), ("front", own.top_z - spec.width_mm)):
                    b.bearing(f"idler_bearing_{end}_{tag}", spec, ring, at(0.0, y, 0.0) @ ALONG_Y, body)
                b.add(
                    f"idler_spacer_{tag}",
                    Spacer(axle(drive, stand, pin, k) if last else between, "Idler spacer", SPACER_NOTE),
                    part=f"idler_spacer_{tag if last else tags[0]}",
                    material=metal,
                    place=where @ ALONG_Y if last else where @ level @ ALONG_Y,
                )
        for n, stand in enumerate(lay.frame.stands, 1):
            b.add(f"idler_strap{mark}_{n}", Strap(stand), material=drive.frame_material, place=turn)
            for k, side in enumerate((-1, 1), 1):
                place = turn @ at(side * stand.screw_x, stand.strap_front_y, stand.screw_z) @ ALONG_Y
                b.screw(f"idler_strap_screw{mark}_{n}_{k}", strap_screw(drive), drive.material("steel"), place)

    def bearings(self, d: DriveSI) -> Iterator[BearingPair]:
        """See the base class."""
        spec = self.layout.drive.idler_bearing
        for body, own, _, _ in self.layout.idlers:
            yield body_bearings(d, d.routes.body(body), "idlers' bearings", (spec, spec), own.bearings_mm)

    def structure(self, unit_tension_N: Floats) -> Iterator[Cause]:
        """Axles between plate and strap, and their bearings."""
        from mbcdm_cad.layouts.structure import axle_causes, elastic
        from mbcdm_cad.model.structure.causes import Section

        drive = self.layout.drive
        material = elastic(drive.shaft_material)
        for unit, pin in ((one, each) for one in self.layout.input_units for each in one.pins):
            stand = unit.frame.stands[pin[0].number]
            rear, front = stand.supports_mm
            section = Section(rear, front, stand.axle_radius)
            on_it = {own.body: own.dims.bearings_mm for own in pin}
            yield from axle_causes(
                self.layout, on_it, unit_tension_N, (rear, front), drive.idler_bearing, section, material
            )
