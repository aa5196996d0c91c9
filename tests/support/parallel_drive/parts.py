"""Parts of the parallel drive, a cylinder and a box, and its bill."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians
from typing import TYPE_CHECKING

from mbcdm_cad.parts.bill import AssemblyStep, Bill, BillBuilder, MovingBody, Placement, cable_item
from mbcdm_cad.parts.bodies import CableRod, MotorBody
from mbcdm_cad.parts.part import Part

if TYPE_CHECKING:
    import cadquery as cq

    from parallel_drive.layout import ParallelLayout


@dataclass(frozen=True)
class Cylinder(Part):
    """Cylinder along Y about the middle; sizes in mm."""

    radius: float
    half_width: float

    def solid(self) -> cq.Solid:
        """From -half_width to half_width."""
        import cadquery as cq

        low, along = cq.Vector(0, -self.half_width, 0), cq.Vector(0, 1, 0)
        return cq.Solid.makeCylinder(self.radius, 2 * self.half_width, low, along)


@dataclass(frozen=True)
class Base(Part):
    """Box below y = 0; sizes in mm."""

    length: float
    thickness: float
    width: float

    def solid(self) -> cq.Solid:
        """Its middle at x = z = 0."""
        import cadquery as cq

        corner = cq.Vector(-self.length / 2, -self.thickness, -self.width / 2)
        return cq.Solid.makeBox(self.length, self.thickness, self.width, corner)


def moving_bodies(lay: ParallelLayout) -> tuple[MovingBody, ...]:
    """Drum about +Y, input about -Y."""
    run, distance = lay.drive.cables[0], lay.drive.centre_distance_mm
    return (
        MovingBody("drum", "drum", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
        MovingBody(
            f"input_{run.input_name}",
            "input",
            (distance, 0.0, 0.0),
            (0.0, -1.0, 0.0),
            run.drum_radius_mm,
            run.input_radius_mm,
        ),
    )


def bill(lay: ParallelLayout, drum_angle_deg: float = 0.0) -> Bill:
    """Base, drum, input pulley, motor below the base, two cables."""
    drive = lay.drive
    metal = drive.material("aluminium-7075")
    b = BillBuilder(lay.moving_bodies, drum_angle_deg)
    name, distance = drive.input_names[0], drive.centre_distance_mm
    size = (4 * lay.drum_radius, lay.base_thickness, 3 * lay.drum_radius)
    b.add("base", Base(*size), material=metal, place=Placement.translation(0.0, lay.base_top, 0.0))
    width = lay.half_width
    b.add("drum", Cylinder(lay.drum_radius, width), material=metal, group="drum")
    pulley = (lay.input_radius, width)
    b.add(f"input_pulley_{name}", Cylinder(*pulley), material=metal, group=f"input_{name}")
    b.add(
        f"motor_{name}",
        MotorBody(drive.motor),
        part="motor",
        material=drive.material("stainless"),
        place=Placement.translation(distance, lay.base_top - lay.base_thickness, 0.0)
        @ Placement.about((1.0, 0.0, 0.0), -90.0),
        mass_g=drive.motor.mass_g,
    )
    rope = drive.material(drive.cable.material)
    for path in lay.cable_paths(radians(drum_angle_deg)):
        b.add(
            cable_item(path.cable.name),
            CableRod(path.line, drive.cable.diameter_mm / 2),
            material=rope,
            mass_g=drive.cable.mass_g_m * path.length_mm / 1e3,
        )
    return b.bill()


def assembly_order(lay: ParallelLayout) -> tuple[AssemblyStep, ...]:
    """All in one step."""
    return (AssemblyStep("Put everything in its place.", tuple(item.name for item in bill(lay).items)),)
