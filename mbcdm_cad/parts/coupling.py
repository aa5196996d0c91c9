"""What couples an input pulley to its gearhead or motor: clamp collar; wheels and belt of a stage in the coupling
space.

The collar, slit on one side, has one tangential screw. Seen along the axis: the slit points to the right, the screw
crosses it from top to bottom, its head on an open flat.

A stage along the input's axis, heights from the motor's shelf towards the pulley:

    motor shelf | screws' heads | driven wheel | its split hub in the clamp collar | bearing shelf

The driven wheel sits on the pulley's journal, its split hub pressed on by the collar. The driver sits in the same plane
on the shaft of motor or gearhead, which stands beside the input, away from the drum; it is bonded to its shaft."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, hypot, pi, sin, sqrt

import numpy as np

from mbcdm_cad.design.stage import BELT_SIDE_MM, DENSITY_G_CM3, FLANGE_MM, FLANGE_WIDTH_MM, Stage
from mbcdm_cad.parts.drum_sector.design import SectorDrive
from mbcdm_cad.parts.fits import FITS, thread
from mbcdm_cad.parts.milled import PlainRing, Step, Turned, block, cylinder
from mbcdm_cad.parts.part import BoughtPart, MadePart, Ring, cq
from mbcdm_cad.parts.sheet import CuttingLine, FitLine, Holes, Linear, Sheet, View, X, Y, Z, minus, mm
from mbcdm_cad.parts.sheet_blocks import hole_labels, hole_table

COLLAR_SLIT_MM = 1.0
HEAD_PLAY_MM = 0.1
# Collar above and below its screw's head, and beyond a grip of one shaft's diameter.
HEAD_EDGE_MM = 0.2
# Collar over the heads of the gearhead's screws.
COLLAR_OVER_HEADS_MM = 0.8


@dataclass(frozen=True)
class CollarDims:
    """Clamp collar that squeezes the slit journal onto the gearhead's shaft; one tangential screw."""

    bore_radius: float
    radius: float
    bottom_z: float
    top_z: float
    slit_width: float
    screw: str
    screw_offset: float
    head_seat: float  # along the screw, from the slit's middle to the head's seat


def _section(drive: SectorDrive) -> tuple[float, float, float, float]:
    """Bore's and outer radius, screw's distance from the axis, and its seat's distance from the slit's middle.

    With a stage the collar clamps the driven wheel's hub, which is on the journal at the gearhead.
    """
    journal, wall = drive.bearings.input_lower.bore_mm, drive.frame_material.min_wall_mm
    bore = journal / 2 if drive.stage is None else hub_radius_mm(journal)
    screw = drive.screw(drive.input_pulleys.collar_screw)
    offset = bore + wall + screw.clearance_mm / 2
    inner_edge = offset - screw.head_diameter_mm / 2 - HEAD_PLAY_MM
    # Below the flat a wall remains round the bore, and one beside the slit.
    seat = max(sqrt(max(0.0, (bore + wall) ** 2 - inner_edge**2)), COLLAR_SLIT_MM / 2 + 1.0)
    # The thread has a wall around it up to the screw's end.
    return bore, hypot(offset + screw.thread_mm / 2 + wall, screw.length_mm - seat), offset, seat


def collar_width_mm(drive: SectorDrive) -> float:
    """Least width, mm, for the screw's head and a grip length of one shaft diameter.

    It is not larger, because in the coupling space the collar must pass over the end of the gearhead's shaft.
    """
    head, shaft = drive.screw(drive.input_pulleys.collar_screw).head_diameter_mm, drive.gearhead.shaft_diameter_mm
    return max(head + 2 * HEAD_EDGE_MM, shaft + HEAD_EDGE_MM)


def collar_sweep_mm(drive: SectorDrive) -> float:
    """Radius that collar and screw sweep about the pulley's axis."""
    (_, radius, offset, seat), screw = _section(drive), drive.screw(drive.input_pulleys.collar_screw)
    return max(radius, hypot(offset + screw.head_diameter_mm / 2, seat + screw.head_height_mm))


def collar_over_shelf_mm(drive: SectorDrive) -> float:
    """Height of the collar over the motor shelf: just above the heads of the gearhead's screws."""
    return drive.screw(drive.gearhead.screw).head_height_mm + COLLAR_OVER_HEADS_MM


def collar(drive: SectorDrive, motor_shelf_top_z: float) -> CollarDims:
    """Collar about its own axis, heights as in the assembly: just above the gearhead's screws, whose heads lie on the
    motor shelf."""
    bore, radius, offset, seat = _section(drive)
    bottom = motor_shelf_top_z + collar_over_shelf_mm(drive)
    return CollarDims(
        bore_radius=bore,
        radius=radius,
        bottom_z=bottom,
        top_z=bottom + collar_width_mm(drive),
        slit_width=COLLAR_SLIT_MM,
        screw=drive.input_pulleys.collar_screw,
        screw_offset=offset,
        head_seat=seat,
    )


@dataclass(frozen=True)
class Collar(PlainRing, MadePart):
    """Collar about its own axis, heights as in the assembly; slit towards +X, screw along Y with its head at +Y.

    Diameters in mm: of the screw's thread, which the drill for tapping may replace, clearance hole and head.
    """

    what = "collar"

    dims: CollarDims
    screw_thread: float
    screw_clearance: float
    head_diameter: float

    def ring(self) -> Ring:
        """Round the journal."""
        return (self.dims.radius, self.dims.bore_radius, self.dims.bottom_z, self.dims.top_z)

    @property
    def _flat_x(self) -> float:
        """Where the flat of the screw's head begins."""
        return self.dims.screw_offset - self.head_diameter / 2 - HEAD_PLAY_MM

    def cuts(self) -> list[cq.Shape]:
        """Slit towards +X, screw along Y with its head at +Y."""
        d, half, reach = self.dims, self.dims.slit_width / 2, self.dims.radius + 1.0
        middle, high = (d.screw_offset, 0.0, (d.bottom_z + d.top_z) / 2), (d.bottom_z - 1, d.top_z + 1)
        return [
            block((0.0, reach), (-half, half), high),
            cylinder(self.screw_clearance / 2, middle, (0, 1, 0), reach),
            cylinder(self.screw_thread / 2, middle, (0, -1, 0), reach),
            # An open flat, because a counterbore would leave walls of only a quarter of a millimetre.
            block((self._flat_x, reach), (d.head_seat, reach), high),
        ]

    def volume_mm3(self) -> float:
        """Clamp collar: ring less slit, screw and the flat of the screw's head."""
        d, edge, width = self.dims, self._flat_x, self.dims.top_z - self.dims.bottom_z
        slit = d.slit_width * (d.radius - d.bore_radius) * width
        below = sqrt(max(d.radius**2 - d.screw_offset**2, 0))
        hole = pi / 4 * (self.screw_clearance**2 * d.head_seat + self.screw_thread**2 * below)
        over = np.sqrt(np.maximum(d.radius**2 - np.linspace(edge, d.radius, 101) ** 2, 0.0)) - d.head_seat
        flat = float(np.maximum(over, 0.0).mean()) * (d.radius - edge)
        return super().volume_mm3() - slit - hole - max(flat, 0.0) * width

    def sheet(self, part: str) -> Sheet:
        """View along the axis, section through the bore, and a view onto the screw's seat."""
        d = self.dims
        low, high, r = d.bottom_z, d.top_z, d.radius
        z, flat, head = (low + high) / 2, self._flat_x, self.head_diameter / 2
        half = d.slit_width / 2
        fit = FITS["collar_bore"].code
        # The screw's two holes end at the slit; they break out of the ring below.
        seat = (d.screw_offset, d.head_seat, z)
        above = Holes("S", self.screw_clearance, "to slit", (seat,), "seat", "clamp screw")
        places = ((d.screw_offset, -half, z),)
        below = Holes("T", self.screw_thread, "through", places, "slit", "clamp screw", threaded=True)
        end = View(
            "end",
            right=X,
            up=Y,
            hidden=True,
            axes=(
                ((-r, 0.0, high), (r, 0.0, high)),
                ((0.0, -r, high), (0.0, r, high)),
                ((d.screw_offset, -sqrt(r**2 - d.screw_offset**2), z), (d.screw_offset, d.head_seat, z)),
            ),
        )
        side = View(
            "side",
            right=Z,
            up=Y,
            column=1,
            cut=(0.0, 0.0, 0.0),
            title="A-A",
            axes=(((0.0, 0.0, low), (0.0, 0.0, high)),),
        )
        top = View(
            "top",
            right=X,
            up=minus(Z),
            row=-1,
            axes=(
                ((0.0, 0.0, low), (0.0, 0.0, high)),
                ((d.screw_offset, 0.0, low), (d.screw_offset, 0.0, high)),
                ((d.screw_offset - head, 0.0, z), (d.screw_offset + head, 0.0, z)),
            ),
        )
        edge = sqrt(r**2 - half**2)
        corner = sqrt(max(r**2 - d.head_seat**2, 0.0))
        return Sheet(
            part=part,
            title="Clamp collar",
            views=(end, side, top),
            dimensions=(
                Linear("end", (0.0, -r, high), (0.0, r, high), 2 * r, "left", "%%c"),
                Linear("end", (edge, -half, high), (edge, half, high), d.slit_width, "right"),
                Linear("end", (0.0, 0.0, high), (corner, d.head_seat, high), d.head_seat, "right", decimals=3),
                Linear("end", (0.0, 0.0, high), (d.screw_offset, -r / 2, z), d.screw_offset, "below"),
                Linear("end", (0.0, r, high), (flat, d.head_seat, high), flat, "above"),
                Linear(
                    "side",
                    (0.0, -d.bore_radius, high),
                    (0.0, d.bore_radius, high),
                    2 * d.bore_radius,
                    "right",
                    "%%c",
                    fit=fit,
                ),
                Linear("side", (0.0, -r, low), (0.0, -r, high), high - low, "below"),
            ),
            labels=hole_labels((above,), "top"),
            tables=(hole_table((above, below)),),
            holes=(above, below),
            fits=(FitLine(2 * d.bore_radius, fit, "bore"),),
            cutting_lines=(CuttingLine("end", (0.0, -r, high), (0.0, r, high), "A", X),),
            notes=(
                "Both holes on one axis, half way up the width.",
                "The flat is open towards the slit's side and over the whole width.",
                f"{thread(self.screw_thread).name} reaches through the lower half; slit sawn last, "
                f"{mm(d.slit_width)} wide.",
            ),
        )


# Wall of the split hub, and hub beyond the collar on each side, mm.
HUB_WALL_MM, HUB_EDGE_MM = 1.5, 0.2
HUB_SLIT_MM = 0.6
# Gears are drawn as plain cylinders that clear each other by this, though their teeth mesh; so belts clear pulleys.
DRAWN_GAP_MM = 0.02


@dataclass(frozen=True)
class WheelSpec:
    """A wheel along its axis from z = 0: bore, radius over the teeth, flanges of a belt's pulley, split hub above; mm.

    ``drawn``: radius of the body, that of the pitch circle for gears, so that bodies of a pair do not overlap.
    """

    name: str
    bore: float
    outside: float
    drawn: float
    width: float
    flange: float
    hub_radius: float
    hub_length: float

    @property
    def source(self) -> str:
        """What to buy; the mass is that of the volume."""
        return f"{self.name}; mass: estimate from its volume"

    @property
    def volume_mm3(self) -> float:
        """Of the wheel; teeth count by the drawn radius."""
        return Wheel(self).volume_mm3()


@dataclass(frozen=True)
class Wheel(Turned, BoughtPart):
    """A belt pulley or a gear from z = 0, its split hub above; the slit points to +X as the collar's does."""

    what = "wheel"

    entry: WheelSpec

    def steps(self) -> tuple[Step, ...]:
        """Flanges, body and hub; teeth are not drawn."""
        w, top, edge = self.entry, self.entry.width, FLANGE_WIDTH_MM if self.entry.flange else 0.0
        rims = ((w.flange, 0.0, edge), (w.flange, top - edge, top)) if w.flange else ()
        hub = ((w.hub_radius, top, top + w.hub_length),) if w.hub_length else ()
        return (*rims[:1], (w.drawn, edge, top - edge), *rims[1:], *hub)

    def bores(self) -> tuple[Step, ...]:
        """The shaft's."""
        return ((self.entry.bore, 0.0, self.entry.width + self.entry.hub_length),)

    def cuts(self) -> list[cq.Shape]:
        """The hub's slit."""
        w, half = self.entry, HUB_SLIT_MM / 2
        z = (w.width + HUB_EDGE_MM, w.width + w.hub_length + 1.0)
        return [block((0.0, w.hub_radius + 1.0), (-half, half), z)] if w.hub_length else []


@dataclass(frozen=True)
class BeltSpec:
    """A belt round two pulleys, the driven one at the origin, the driver at (0, centre); mm."""

    name: str
    driven: float
    driver: float
    centre: float
    slant_rad: float
    inner: float
    outer: float
    width: float

    @property
    def source(self) -> str:
        """What to buy; the mass is that of the volume."""
        return f"{self.name}; mass: estimate from its volume"

    @property
    def volume_mm3(self) -> float:
        """Band with its teeth, which fill half of their height."""
        middle = (self.inner + self.outer) / 2
        arcs = (self.driven + self.driver + 2 * middle) * pi + 2 * self.slant_rad * (self.driven - self.driver)
        return (2 * self.centre * cos(self.slant_rad) + arcs) * (self.outer - self.inner) * self.width


@dataclass(frozen=True)
class Belt(BoughtPart):
    """A belt from z = 0 along its true path, its back without the teeth, which lie in the pulleys' grooves.

    ``inner`` and ``outer`` count from the pitch radii.
    """

    entry: BeltSpec

    def solid(self) -> cq.Solid:
        """The band between two offsets of its pitch line."""
        b = self.entry

        def loop(offset: float) -> cq.Wire:
            large, small, lean = b.driven + offset, b.driver + offset, b.slant_rad

            def at(radius: float, y: float, angle: float) -> cq.Vector:
                return cq.Vector(radius * cos(angle), y + radius * sin(angle), 0.0)

            # Points of contact lie at the slant above the line across the axes.
            a, c = at(large, 0.0, lean), at(small, b.centre, lean)
            d, e = at(small, b.centre, pi - lean), at(large, 0.0, pi - lean)
            return cq.Wire.assembleEdges(
                [
                    cq.Edge.makeLine(a, c),
                    cq.Edge.makeThreePointArc(c, at(small, b.centre, pi / 2), d),
                    cq.Edge.makeLine(d, e),
                    cq.Edge.makeThreePointArc(e, at(large, 0.0, -pi / 2), a),
                ]
            )

        return cq.Solid.extrudeLinear(loop(b.outer), [loop(b.inner)], cq.Vector(0, 0, b.width))


@dataclass(frozen=True)
class StageDims:
    """Heights along the input's axis from the motor towards the pulley, and the bodies; mm."""

    stage: Stage
    bottom_z: float  # of both wheels
    driven: WheelSpec
    driver: WheelSpec
    belt: BeltSpec | None

    @property
    def top_z(self) -> float:
        """Of both wheels."""
        return self.bottom_z + self.driven.width

    @property
    def hub_top_z(self) -> float:
        """Of the driven wheel's hub."""
        return self.top_z + self.driven.hub_length

    @property
    def middle_z(self) -> float:
        """Middle of belt or teeth."""
        return self.bottom_z + self.driven.width / 2

    def mass_g(self, spec: WheelSpec | BeltSpec) -> float:
        """Of one of the bodies."""
        density = 1.2 if isinstance(spec, BeltSpec) else DENSITY_G_CM3[self.stage.kind]
        return spec.volume_mm3 * density * 1e-3


def hub_radius_mm(journal_mm: float) -> float:
    """Outside of the driven wheel's split hub, on a journal of this diameter."""
    return journal_mm / 2 + HUB_WALL_MM


def stage_dims(stage: Stage, bottom_z: float, journal_mm: float, collar_mm: float, shaft_mm: float) -> StageDims:
    """Dimensions of a stage whose wheels begin at ``bottom_z``; diameters of journal and driver's shaft."""

    def wheel(name: str, teeth: int, pitch: float, bore: float, hub: float) -> WheelSpec:
        outside = stage.outside_mm(pitch)
        return WheelSpec(
            name=f"{name}, {teeth} teeth {stage.belt or f'module {stage.module_mm:g}'}",
            bore=bore / 2,
            outside=outside,
            drawn=outside if stage.is_belt else pitch - DRAWN_GAP_MM / 2,
            width=stage.wheel_width_mm,
            # The driver has no flanges, so that a key passes it to the motor's screws.
            flange=outside + FLANGE_MM if stage.is_belt and hub else 0.0,
            hub_radius=hub_radius_mm(bore) if hub else 0.0,
            hub_length=hub,
        )

    word = "pulley" if stage.is_belt else "gear"
    belt = None
    if stage.is_belt:
        below, back = stage.type.below_mm, stage.type.back_mm
        belt = BeltSpec(
            f"belt {stage.belt}, {stage.belt_teeth} teeth, {stage.width_mm:g} mm wide",
            stage.driven_mm,
            stage.driver_mm,
            stage.centre_mm,
            stage.slant_rad,
            DRAWN_GAP_MM - below,
            back - below,
            stage.width_mm,
        )
    return StageDims(
        stage,
        bottom_z,
        wheel(f"driven {word}", stage.driven_teeth, stage.driven_mm, journal_mm, collar_mm + 2 * HUB_EDGE_MM),
        wheel(f"driving {word}", stage.driver_teeth, stage.driver_mm, shaft_mm, 0.0),
        belt,
    )


def belt_bottom_mm() -> float:
    """Height of the belt over the end of its pulleys."""
    return FLANGE_WIDTH_MM + BELT_SIDE_MM
