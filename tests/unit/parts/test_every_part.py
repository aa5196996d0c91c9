"""Every made part of every layout: one valid solid, closed mesh, volume as it says of itself, a complete sheet."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import cadquery as cq
import pytest

from mbcdm_cad.layouts import registry
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.parts.bill import Bill
from mbcdm_cad.parts.part import BoughtPart, MadePart
from mbcdm_cad.parts.sheet import Linear
from mbcdm_cad.workshop.kernel import measure, validate_solid
from mbcdm_cad.workshop.mass import combined, item_mass
from mbcdm_cad.workshop.meshing import mesh_solid

PARAMS = Path(__file__).parents[3] / "params"
FILES = {"miso_bevel": "mbcdm", "siso_bevel": "siso_bevel", "siso_spur": "siso_spur", "miso_spur": "miso_spur"}


@cache
def bill_of(layout: str) -> Bill:
    """Bill of the reference design of a layout."""
    found: Bill = layout_of(load_design(PARAMS / f"{FILES[layout]}.yaml").drive).bill()
    return found


@cache
def solid_of(layout: str, name: str) -> cq.Solid:
    """Solid of a part of that design."""
    return bill_of(layout).parts[name].part.solid()


def test_every_layout_has_its_reference_here() -> None:
    assert set(FILES) == set(registry.names())


EVERY = [(layout, name) for layout in FILES for name, part in bill_of(layout).made.items()]


@pytest.mark.parametrize("layout", FILES)
def test_every_part_is_made_or_bought_as_its_items_say(layout: str) -> None:
    bill = bill_of(layout)
    for item in bill.items:
        part = bill.parts[item.part].part
        assert isinstance(part, MadePart) == (item.mass_g is None), f"{item.name}: {type(part).__name__}"
        assert not isinstance(part, BoughtPart) or part.entry.source, f"{item.name}: no source"


@pytest.mark.parametrize(("layout", "name"), EVERY)
def test_a_made_part_is_what_it_says_of_itself(layout: str, name: str) -> None:
    part = bill_of(layout).made[name]
    solid = solid_of(layout, name)
    validate_solid(name, solid)
    drawn, said = solid.Volume(), part.volume_mm3()
    assert said == pytest.approx(drawn, rel=0.01), f"{name}: {said:.2f} mm^3, drawn {drawn:.2f}"
    mesh = mesh_solid(name, solid, 0.05)
    assert len(mesh.open_edges_mm()) == 0 and mesh.volume_mm3 == pytest.approx(drawn, rel=0.02), mesh.volume_mm3
    # What a frame or a datum of the sheet points at is a face of the part, a cylinder where its axis is meant.
    sheet = part.sheet(name)
    places = [(at, tolerance.axis) for tolerance in sheet.tolerances for at in tolerance.places]
    for at, axis in [*places, *((datum.at, False) for datum in sheet.datums)]:
        near = min(solid.Faces(), key=lambda face: face.distance(cq.Vertex.makeVertex(*at)))
        away = near.distance(cq.Vertex.makeVertex(*at))
        # A tolerance of a land is at its crest, where the groove of a grooved one may run.
        assert away < (0.5 if getattr(part, "dims", None) and getattr(part.dims, "grooves", ()) else 1e-6), (
            f"{name}: {at} is {away:.4g} mm from the nearest face"
        )
        assert not axis or near.geomType() == "CYLINDER", f"{name}: {at} is on a {near.geomType()}"


@pytest.mark.parametrize("layout", FILES)
def test_what_turns_together_has_the_inertia_of_its_solids(layout: str) -> None:
    """About each moving body's axis, of all parts but the smallest by their solids: `analyse` draws none of them."""
    bill = bill_of(layout)
    for body in layout_of(load_design(PARAMS / f"{FILES[layout]}.yaml").drive).moving_bodies:
        items = [item for item in bill.items if item.group == body.name]
        drawn = {item.part: measure(solid_of(layout, item.part)) for item in items}
        solids = combined(item_mass(item, drawn[item.part]) for item in items).about_axis(body.axis, body.origin_mm)
        assert bill.inertia_g_mm2(body) == pytest.approx(solids, rel=0.015), body.name


@pytest.mark.parametrize(("layout", "name"), EVERY)
def test_the_sheet_of_a_made_part_is_complete(layout: str, name: str) -> None:
    part = bill_of(layout).made[name]
    sheet = part.sheet(name)
    views = {view.name for view in sheet.views}
    assert sheet.part == name and sheet.title
    letters = {x.datum for x in sheet.dimensions if isinstance(x, Linear)} | {x.letter for x in sheet.datums}
    for tolerance in sheet.tolerances:
        assert {letter for datum in tolerance.datums for letter in datum.split("-")} <= letters, tolerance
    assert len(views) == len(sheet.views) >= 1, views
    assert len(sheet.dimensions) >= 2, sheet.dimensions
    assert {d.view for d in sheet.dimensions} | {label.view for label in sheet.labels} <= views
    assert part.holes(name) == [group.data() for group in sheet.holes]
    spec = bill_of(layout).parts[name]
    assert (spec.drilled is not None) == any(hole["thread"] for hole in part.holes(name)), name
