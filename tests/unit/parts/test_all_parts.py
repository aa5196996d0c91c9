"""Every part of the reference design: one valid solid, a watertight mesh, the reviewed volume, and its box."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import cadquery as cq
import numpy as np
import pytest
import trimesh

import mbcdm_cad as mc
from mbcdm_cad.checks.size import estimated_mass_g
from mbcdm_cad.design.bought import Entry
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts import registry
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.layouts.miso_bevel.bill import bill
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive, bevel
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.parts.bill import CABLE, Bill
from mbcdm_cad.parts.making import NoPriceError, bought_cost_EUR, material_cost_EUR
from mbcdm_cad.parts.part import BoughtPart, MadePart
from mbcdm_cad.parts.sheet import Linear
from mbcdm_cad.workshop.kernel import bounding_box, measure, validate_faces, validate_solid
from mbcdm_cad.workshop.mass import combined, item_mass
from mbcdm_cad.workshop.meshing import mesh_solid
from tests.support.random_generator import Passing, passing

from .golden import golden_volumes

GOLDEN = golden_volumes()
TOLERANCE = 1e-6


def test_the_table_of_volumes_holds_every_part_and_no_other(centred: Bill) -> None:
    assert set(GOLDEN) == set(centred.parts), "regenerate: python tests/unit/parts/golden.py"


@pytest.mark.parametrize("name", GOLDEN)
def test_volume_is_what_it_was(solids: dict[str, cq.Solid], name: str) -> None:
    """A golden figure: it proves nothing but that geometry has not changed unnoticed."""
    volume = solids[name].Volume()
    error = volume / GOLDEN[name] - 1
    assert abs(error) < TOLERANCE, f"{name}: {volume:.6f} mm^3, was {GOLDEN[name]:.6f} ({error:+.2e})"


@pytest.mark.parametrize("name", GOLDEN)
def test_is_one_sound_solid(solids: dict[str, cq.Solid], name: str) -> None:
    validate_solid(name, solids[name])
    validate_faces(name, solids[name])


@pytest.mark.parametrize("name", GOLDEN)
def test_mesh_is_watertight_and_of_nearly_the_same_volume(solids: dict[str, cq.Solid], name: str) -> None:
    # A cable wound at 0.02 mm has a quarter of a million triangles; its chords may be longer.
    vertices, faces = (
        solids[name].copy(mesh=False).tessellate(*((0.05, 0.3) if name.startswith(CABLE) else (0.02, 0.1)))
    )
    mesh = trimesh.Trimesh([v.toTuple() for v in vertices], faces)
    mesh.merge_vertices(digits_vertex=7)
    assert mesh.is_watertight and mesh.is_winding_consistent, f"{name}: open mesh"
    assert mesh.body_count == 1, f"{name}: {mesh.body_count} bodies"
    error = mesh.volume / solids[name].Volume() - 1
    assert abs(error) < 0.02, f"{name}: mesh volume off by {error:+.2%}"


def boxes(dims: BevelLayout) -> dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]]:
    """Low and high corners by the drawing, part's own frame."""
    v, drive, d, f = dims.levels, dims.drive, dims.drum, dims.frame
    side, gear, nut = v.side_outer_x, drive.gearhead, drive.tensioner
    motor, encoder, ring = drive.motor, drive.encoder, drive.drum_encoder
    left = dims.inputs[0]
    reach = d.lands[-1].surface_radius_mm
    half = np.radians(d.half_angle_deg)
    outermost = max(t.y_mm for t in d.tensioners if t.cut_through)
    lugs_inner = min(t.y_mm for t in d.tensioners) - d.lug_half_width
    corner = nut.nut_across_flats_mm / 3**0.5
    assert outermost < d.lands[-1].y_end
    return {
        "frame": ((-side, v.back_y, -f.boss.radius), (side, v.boss_front_y, v.top_plate_bottom_z)),
        "top_plate": ((-side, v.back_y, v.top_plate_bottom_z), (side, v.front_y, v.top_plate_top_z)),
        "guide": (
            (-dims.guide.surface_radii[-1], -dims.guide.surface_radii[-1], v.guide_bottom_z),
            (dims.guide.surface_radii[-1], dims.guide.surface_radii[-1], v.guide_top_z),
        ),
        "drum": (
            (-reach * np.sin(half), min(d.spigot_y, lugs_inner), -d.hub_radius),
            (reach * np.sin(half), d.hub_face_y, reach),
        ),
        "drum_shaft": (
            (-dims.drum_shaft.flange_radius, v.back_y, -dims.drum_shaft.flange_radius),
            (dims.drum_shaft.flange_radius, v.hub_face_y, dims.drum_shaft.flange_radius),
        ),
        "input_pulley_left": (
            (-left.upper_surface_radius, -left.upper_surface_radius, left.journal_bottom_z),
            (left.upper_surface_radius, left.upper_surface_radius, left.journal_top_z),
        ),
        "motor": (
            (-motor.diameter_mm / 2, -motor.diameter_mm / 2, -motor.length_mm),
            (motor.diameter_mm / 2, motor.diameter_mm / 2, 0.0),
        ),
        "gearhead": (
            (-gear.diameter_mm / 2, -gear.diameter_mm / 2, -gear.length_mm),
            (gear.diameter_mm / 2, gear.diameter_mm / 2, gear.shaft_length_mm),
        ),
        "encoder": (
            (-encoder.diameter_mm / 2, -encoder.diameter_mm / 2, 0.0),
            (encoder.diameter_mm / 2, encoder.diameter_mm / 2, encoder.length_mm),
        ),
        "drum_encoder": ((-ring.diameter_mm / 2, -11.0, 0.0), (ring.diameter_mm / 2, 11.0, ring.length_mm)),
        "nut": ((-corner, -nut.nut_across_flats_mm / 2, 0.0), (corner, nut.nut_across_flats_mm / 2, nut.nut_height_mm)),
    }


Boxes = Callable[[BevelLayout], dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]]]


def test_boxes_are_those_of_the_drawing(dims: BevelLayout, solids: dict[str, cq.Solid]) -> None:
    for name, (low, high) in boxes(dims).items():
        found = bounding_box(solids[name])
        assert np.abs(np.subtract(found, (low, high))).max() < 1e-4, f"{name}: {found}, drawn {low} to {high}"


@pytest.mark.parametrize("name", [n for n in GOLDEN if n.startswith(("screw_", "bearing_"))])
def test_bought_parts_stand_on_their_seat(solids: dict[str, cq.Solid], name: str) -> None:
    """Screws hang below their head's seat at z = 0; bearings stand on it."""
    low, high = bounding_box(solids[name])
    if name.startswith("bearing_"):
        assert low[2] == pytest.approx(0.0, abs=1e-6)
    else:
        assert low[2] < 0.0 <= high[2] + 1e-6


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


MASS_SHARE = 0.01


def drawn_mass_g(drive: BevelDrive) -> float:
    """Mass of all items from the solids' volumes."""
    found = bill(BevelLayout(drive))
    made = {item.part for item in found.items if item.mass_g is None}
    volumes = {name: found.parts[name].part.solid().Volume() for name in made}
    return sum(
        volumes[item.part] * item.material.density_g_cm3 * 1e-3 if item.mass_g is None else item.mass_g
        for item in found.items
    )


def _close(drive: BevelDrive, what: str) -> None:
    drawn, estimated = drawn_mass_g(drive), estimated_mass_g(bill(BevelLayout(drive)))
    assert estimated == pytest.approx(drawn, rel=MASS_SHARE), f"{what}: {estimated:.1f} g, drawn {drawn:.1f} g"


@pytest.mark.slow
@pytest.mark.parametrize("seed", [4, 5, 6])
def test_mass_of_random_designs(seed: int) -> None:
    found = passing(seed)
    if isinstance(found, Passing):
        _close(bevel(found.loaded.drive), f"seed {seed}")


@pytest.mark.slow
def test_mass_with_grooves_setback_and_four_screws(drive: Drive) -> None:
    design = bevel(drive)
    pulleys = replace(design.input_pulleys, surface="grooved")
    gearhead = replace(design.gearhead, screw_count=4)
    _close(
        replace(design, input_pulleys=pulleys, gearhead=gearhead, helix_lead_mm=0.9, input_setback_mm=1.5),
        "grooves, setback, four screws",
    )


@pytest.fixture(scope="module")
def drive() -> mc.Drive:
    return mc.load("params/siso_spur.yaml").drive


def _of_catalogue(part: object) -> bool:
    return isinstance(getattr(part, "entry", None), Entry)


def _at_one_price(bill: Any) -> Any:
    """Every material for 1 EUR/kg, every part for 2 EUR."""
    items = tuple(replace(item, material=replace(item.material, price_EUR=1.0)) for item in bill.items)
    parts = {
        name: replace(spec, part=replace(spec.part, entry=replace(spec.part.entry, price_EUR=2.0)))
        if _of_catalogue(spec.part)
        else spec
        for name, spec in bill.parts.items()
    }
    return replace(bill, items=items, parts=parts)


def test_material_at_one_price_costs_the_made_mass(drive: mc.Drive) -> None:
    bill = layout_of(drive).bill()
    made_g = estimated_mass_g(bill) - sum(item.mass_g or 0.0 for item in bill.items)
    assert material_cost_EUR(_at_one_price(bill)) == pytest.approx(made_g * 1e-3)


def test_bought_parts_cost_their_number_and_the_rope_its_length(drive: mc.Drive) -> None:
    bill = _at_one_price(layout_of(drive).bill())
    rope = replace(drive.cable, price_EUR=3.0)
    length_m = sum(path.length_mm for path in layout_of(drive).cable_paths(0.0)) * 1e-3
    with_entry = [item for item in bill.items if _of_catalogue(bill.parts[item.part].part)]
    assert not [item for item in with_entry if item.name.startswith(CABLE)]
    assert bought_cost_EUR(bill, rope) == pytest.approx(2.0 * len(with_entry) + 3.0 * length_m)


def test_entries_without_a_price_are_named(drive: mc.Drive) -> None:
    with pytest.raises(NoPriceError) as refused:
        bought_cost_EUR(layout_of(drive).bill(), drive.cable)
    assert drive.motor.name in str(refused.value)
    assert drive.cable.name in str(refused.value)
