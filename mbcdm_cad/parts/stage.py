"""Wheels, belt and hub clamp of a stage between motor and input, in the coupling space of a motor head.

Along the input's axis, heights from the motor's shelf towards the pulley:

    motor shelf | screws' heads | driven wheel | its split hub in the clamp collar | bearing shelf

The driven wheel sits on the pulley's journal, its split hub pressed on by the collar. The driver sits in the same plane
on the shaft of motor or gearhead, which stands beside the input, away from the drum; it is bonded to its shaft.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi, sin
from typing import TYPE_CHECKING

from mbcdm_cad.design.stage import BELT_SIDE_MM, DENSITY_G_CM3, FLANGE_MM, FLANGE_WIDTH_MM, Stage
from mbcdm_cad.parts.milled import block, cut, turned
from mbcdm_cad.parts.part import BoughtPart, Ring, rings_mm3

if TYPE_CHECKING:
    import cadquery as cq

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

    def in_rings(self) -> tuple[Ring, ...]:
        """Body and hub less the bore; teeth count by the drawn radius."""
        top, edge = self.width, FLANGE_WIDTH_MM
        rims = ((self.flange, self.drawn, 0.0, edge), (self.flange, self.drawn, top - edge, top))
        hub = (self.hub_radius, self.bore, top, top + self.hub_length)
        return ((self.drawn, self.bore, 0.0, top), *(rims if self.flange else ()), hub)

    @property
    def volume_mm3(self) -> float:
        """Of its rings."""
        return rings_mm3(self.in_rings())


@dataclass(frozen=True)
class Wheel(BoughtPart):
    """A belt pulley or a gear from z = 0, its split hub above; the slit points to +X as the collar's does."""

    entry: WheelSpec

    def in_rings(self) -> tuple[Ring, ...]:
        """Those of its body."""
        return self.entry.in_rings()

    def solid(self) -> cq.Solid:
        """Turned body; teeth are not drawn."""
        w = self.entry
        top, end = w.width, w.width + w.hub_length
        outline = [(w.bore, 0.0)]
        if w.flange:
            edge = FLANGE_WIDTH_MM
            outline += [(w.flange, 0.0), (w.flange, edge), (w.drawn, edge)]
            outline += [(w.drawn, top - edge), (w.flange, top - edge), (w.flange, top)]
        else:
            outline += [(w.drawn, 0.0), (w.drawn, top)]
        if w.hub_length:
            outline += [(w.hub_radius, top), (w.hub_radius, end), (w.bore, end)]
        else:
            outline += [(w.bore, top)]
        body = turned(outline, w.name)
        if not w.hub_length:
            return body
        half = HUB_SLIT_MM / 2
        return cut(body, [block((0.0, w.hub_radius + 1.0), (-half, half), (top + HUB_EDGE_MM, end + 1.0))], w.name)


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
        import cadquery as cq

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
