"""Solids and items in place of a design: every surface type, and instances; no real mechanism."""

import math

import cadquery as cq

from mbcdm_cad.design.bought import Material
from mbcdm_cad.parts.bill import Item, Placement


def material(name: str, density_g_cm3: float, colour: tuple[float, float, float]) -> Material:
    return Material(
        name=name,
        density_g_cm3=density_g_cm3,
        youngs_modulus_GPa=70.0,
        poisson_ratio=0.33,
        yield_MPa=300.0,
        process="milled",
        min_wall_mm=1.0,
        min_internal_radius_mm=1.0,
        colour=colour,
        source="test",
    )


ALUMINIUM = material("aluminium", 2.81, (0.6, 0.62, 0.65))
STEEL = material("steel", 7.85, (0.25, 0.27, 0.3))
PLASTIC = material("pa12", 1.01, (0.8, 0.1, 0.05))


def _swept() -> cq.Solid:
    points = [(10 * math.cos(0.2 * k), 10 * math.sin(0.2 * k), 0.3 * k) for k in range(20)]
    plane = cq.Plane((10, 0, 0), (1, 0, 0), (0, 1, 0))
    return cq.Workplane(plane).circle(0.4).sweep(cq.Workplane().spline(points)).val()


def _helix() -> cq.Solid:
    wire = cq.Workplane(cq.Wire.makeHelix(0.87, 0.87 * 1.75, 6.4))
    plane = cq.Plane((6.4, 0, 0), (1, 0, 0), (0, 1, 0))
    return cq.Workplane(plane).circle(0.405).sweep(wire, isFrenet=True).val()


def make_solids() -> dict[str, cq.Solid]:
    """One part of every kind of surface; the sizes are those of a small drive."""
    plate = cq.Workplane().box(60, 40, 5).edges("|Z").fillet(3).faces(">Z").chamfer(0.5)
    plate = plate.faces(">Z").workplane().rarray(40, 20, 2, 2).hole(4)
    return {
        "plate": plate.val().Solids()[0],
        "disc": cq.Workplane().circle(64).extrude(4).val(),
        "ball": cq.Solid.makeSphere(5, cq.Vector(), cq.Vector(0, 0, 1), -90, 90, 360),
        "ring": cq.Solid.makeTorus(20, 0.405),
        "cone": cq.Solid.makeCone(20, 12, 10),
        "rounded": cq.Workplane().box(30, 20, 6).edges().fillet(1.0).val().Solids()[0],
        "swept": _swept(),
        "helix": _helix(),
    }


def make_items() -> list[Item]:
    """Two instances of every part, in two groups, placed apart and turned."""
    materials = (ALUMINIUM, STEEL, PLASTIC)
    return [
        Item(
            name=f"{part}_{instance}",
            part=part,
            material=materials[index % 3],
            kind="made",
            location=Placement.translation(150.0 * index, 150.0 * instance, 0.0)
            @ Placement.about((1.0, 2.0, 3.0), 25.0 * index),
            group=("fixed", "drum")[instance],
        )
        for index, part in enumerate(sorted(make_solids()))
        for instance in range(2)
    ]
