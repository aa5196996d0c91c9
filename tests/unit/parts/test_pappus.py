"""Turned parts compared with closed forms from the drawing: sums of rings, cones and prisms."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from math import acos, pi, radians, sqrt
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
from mbcdm_cad.layouts.miso_bevel.support.parts import TopPlate
from mbcdm_cad.parts.bill import CABLE, Bill
from mbcdm_cad.parts.drum_sector.part import DrumSector
from mbcdm_cad.parts.input_pulley.draw import create_input_pulley
from mbcdm_cad.parts.making import NoPriceError, bought_cost_EUR, material_cost_EUR
from mbcdm_cad.parts.part import BoughtPart, MadePart
from mbcdm_cad.parts.sheet import Linear
from mbcdm_cad.workshop.kernel import bounding_box, measure, validate_faces, validate_solid
from mbcdm_cad.workshop.mass import combined, item_mass
from mbcdm_cad.workshop.meshing import mesh_solid
from tests.support.random_generator import Passing, passing
from tests.support.reference import PARAMS

from .golden import golden_volumes

PAPPUS_TOLERANCE = 1e-9


def ring(outer: float, inner: float, height: float) -> float:
    return pi * (outer**2 - inner**2) * height


def cone(first: float, last: float, height: float) -> float:
    return pi * height / 3 * (first**2 + first * last + last**2)


def hexagon(across_flats: float, height: float) -> float:
    return sqrt(3) / 2 * across_flats**2 * height


def close(solid: cq.Solid, expected: float, name: str) -> None:
    error = solid.Volume() / expected - 1
    assert abs(error) < PAPPUS_TOLERANCE, (
        f"{name}: {solid.Volume():.9f} mm^3, closed form {expected:.9f} ({error:+.1e})"
    )


def test_guide(dims: BevelLayout, solids: dict[str, cq.Solid]) -> None:
    g = dims.guide
    z = [g.bottom_z, *g.walls_z, g.top_z]
    steps = sum(ring(r, 0.0, b - a) for r, a, b in zip(g.surface_radii, z[:-1], z[1:], strict=True))
    length = g.top_z - g.bottom_z
    hollow = ring(g.seat_radius, 0.0, 2 * g.seat_depth) + ring(g.shoulder_radius, 0.0, length - 2 * g.seat_depth)
    close(solids["guide"], steps - hollow, "guide")


def test_guide_axle_and_spacer(dims: BevelLayout, solids: dict[str, cq.Solid]) -> None:
    a = dims.axle
    collar = ring(a.collar_radius, a.radius, a.collar_top_z - a.collar_bottom_z)
    c = 0.3
    rod = ring(a.radius, 0.0, a.top_z - a.bottom_z - 2 * c) + 2 * cone(a.radius, a.radius - c, c)
    close(solids["guide_axle"], rod + collar, "guide axle")
    close(solids["guide_spacer"], ring(a.collar_radius, a.radius, a.spacer_top_z - a.spacer_bottom_z), "spacer")


def test_drum_shaft(dims: BevelLayout, solids: dict[str, cq.Solid]) -> None:
    s, c = dims.drum_shaft, 0.3
    body = ring(s.radius, 0.0, s.y_end - s.y_start - 2 * c) + 2 * cone(s.radius, s.radius - c, c)
    flange = ring(s.flange_radius, s.radius, s.flange_end_y - s.flange_start_y)
    # Two circular segments, where the hub's set screws press.
    segment = s.radius**2 * acos(s.flat / s.radius) - s.flat * sqrt(s.radius**2 - s.flat**2)
    solid = body + flange - ring(s.bore_radius, 0.0, s.y_end - s.y_start) - 2 * segment * s.flat_length
    close(solids["drum_shaft"], solid, "drum shaft")
    spring = dims.preload_spring
    close(solids["wave_spring"], ring(spring.outer_radius, spring.inner_radius, spring.height), "wave spring")


def test_terminal_stop_and_pins(drive: Drive, dims: BevelLayout, solids: dict[str, cq.Solid]) -> None:
    t, spec, c = dims.drum.tensioners[0], drive.tensioner, 0.2
    swage, stud, bore = spec.swage_diameter_mm / 2, spec.thread_mm / 2, drive.cable.diameter_mm / 2
    body = cone(swage - c, swage, c) + ring(swage, 0.0, t.swage_end - t.swage_start - c)
    body += ring(stud, 0.0, t.tip - t.swage_end - c) + cone(stud, stud - c, c)
    flat = spec.swage_flats_mm / 2
    # Two circular segments along the sleeve, smaller in its chamfer.
    wide = np.maximum(swage - c + c * np.linspace(0.0, 1.0, 400001), flat)
    segment = wide**2 * np.arccos(flat / wide) - flat * np.sqrt(wide**2 - flat**2)
    in_chamfer = float((segment[1:] + segment[:-1]).mean()) / 2 * c
    body -= 2 * (in_chamfer + float(segment[-1]) * (t.swage_end - t.swage_start - c))
    close(solids["terminal"], body - ring(bore, 0.0, t.cable_end - t.swage_start), "terminal")
    slot = dims.inputs[0].slots[0]
    close(solids["stop"], ring(slot.stop_radius, bore, slot.stop_start - slot.stop_end), "stop")
    for name, radius, length in (
        ("dowel", 1.0, 6.0),
        ("stop_pin", 1.5, dims.drum.web_end_y + 0.5 - dims.frame.stop_pin_start_y),
    ):
        c = min(0.3, radius / 3)
        close(solids[name], ring(radius, 0.0, length - 2 * c) + 2 * cone(radius, radius - c, c), name)


def test_bearings(drive: Drive, solids: dict[str, cq.Solid]) -> None:
    """Two full rings, the shield between them set back on both sides."""
    for b in {b.name: b for b in drive.bearings.all()}.values():
        back = min(0.2, b.width_mm / 8)
        full = ring(b.outer_diameter_mm / 2, b.bore_mm / 2, b.width_mm)
        recess = ring(b.outer_shoulder_mm / 2, b.inner_shoulder_mm / 2, 2 * back)
        close(solids["bearing_" + b.name.replace("/", "-")], full - recess, b.name)


def test_motor_gearhead_encoder(drive: Drive, solids: dict[str, cq.Solid]) -> None:
    c, m, g, e = 0.3, drive.motor, drive.gearhead, drive.encoder
    r = m.diameter_mm / 2
    close(solids["motor"], ring(r, 0.0, m.length_mm - c) + cone(r, r - c, c), "motor")
    r, screw = g.diameter_mm / 2, drive.screw(g.screw)
    depth = screw.length_mm - drive.support.motor_shelf_mm + 1.0
    body = ring(r, 0.0, g.length_mm - c) + cone(r, r - c, c) + ring(g.pilot_diameter_mm / 2, 0.0, g.pilot_height_mm)
    body += ring(g.shaft_diameter_mm / 2, 0.0, g.shaft_length_mm - g.pilot_height_mm)
    close(solids["gearhead"], body - g.screw_count * ring(screw.thread_mm / 2, 0.0, depth), "gearhead")
    r, screw = e.diameter_mm / 2, drive.screw(e.screw)
    head_pocket = screw.head_height_mm + 0.2
    depth = screw.length_mm - (drive.support.top_plate_mm - head_pocket) + 0.5
    body = ring(r, 0.0, e.length_mm - c) + cone(r, r - c, c) - ring(e.bore_mm / 2, 0.0, 10.5)
    close(solids["encoder"], body - e.screw_count * ring(screw.thread_mm / 2, 0.0, depth), "encoder")


def test_screws_and_nut(drive: Drive, solids: dict[str, cq.Solid]) -> None:
    for name in [n for n in solids if n.startswith("screw_")]:
        s = drive.screw(name.removeprefix("screw_"))
        thread = ring(s.thread_mm / 2, 0.0, s.length_mm)
        if s.head_height_mm:
            head = ring(s.head_diameter_mm / 2, 0.0, s.head_height_mm)
            expected = thread + head - hexagon(s.key_mm, s.head_height_mm / 2)
        else:
            expected = thread - hexagon(s.key_mm, min(s.length_mm / 2, s.key_mm))
        close(solids[name], expected, name)
    t = drive.tensioner
    nut = hexagon(t.nut_across_flats_mm, t.nut_height_mm) - ring(t.thread_mm / 2, 0.0, t.nut_height_mm)
    close(solids["nut"], nut, "nut")


def slit_area(outer: float, inner: float, width: float) -> float:
    """Area of a ring's two cuts by a strip of ``width`` through its centre."""

    def strip(r: float) -> float:
        h = width / 2
        return 2 * (h * sqrt(r**2 - h**2) + r**2 * float(np.arcsin(h / r))) if r else 0.0

    return strip(outer) - strip(inner)


def test_input_pulley_without_its_slots(dims: BevelLayout) -> None:
    """Journals, necks, two steps; the gearhead's bore and the slit across it."""
    c = 0.2
    for p in dims.inputs:
        body = cone(p.lower_journal_radius - c, p.lower_journal_radius, c)
        body += ring(p.lower_journal_radius, 0.0, p.lower_neck_bottom_z - p.journal_bottom_z - c)
        body += ring(p.lower_neck_radius, 0.0, p.land_bottom_z - p.lower_neck_bottom_z)
        body += ring(p.lower_surface_radius, 0.0, p.wall_z - p.land_bottom_z)
        body += ring(p.upper_surface_radius, 0.0, p.land_top_z - p.wall_z)
        body += ring(p.upper_neck_radius, 0.0, p.upper_neck_top_z - p.land_top_z)
        body += ring(p.upper_journal_radius, 0.0, p.journal_top_z - p.upper_neck_top_z - c)
        body += cone(p.upper_journal_radius, p.upper_journal_radius - c, c)
        bore = ring(p.bore_radius, 0.0, p.bore_top_z - p.journal_bottom_z)
        assert p.slit_top_z > p.bore_top_z, "the slit must run past the bore's bottom for the journal to spring"
        height = p.bore_top_z - p.journal_bottom_z
        slit = slit_area(p.lower_journal_radius, p.bore_radius, p.slit_width) * (height - c)
        slit += slit_area(p.lower_journal_radius, 0.0, p.slit_width) * (p.slit_top_z - p.bore_top_z)
        z, w = np.polynomial.legendre.leggauss(8)
        in_chamfer = [slit_area(p.lower_journal_radius - c * (1 - (x + 1) / 2), p.bore_radius, p.slit_width) for x in z]
        slit += float(np.dot(w, in_chamfer)) / 2 * c
        close(create_input_pulley(replace(p, slots=())), body - bore - slit, f"input pulley {p.name}")


def test_slots_take_no_more_than_their_room(dims: BevelLayout, solids: dict[str, cq.Solid]) -> None:
    """Each slot is a bent channel and a pocket: between one and three times channel and pocket as straight prisms."""
    for p in dims.inputs:
        whole = create_input_pulley(replace(p, slots=())).Volume()
        taken = whole - solids[f"input_pulley_{p.name}"].Volume()
        straight = 0.0
        for s in p.slots:
            deep = abs(s.face_z - s.end_z) + s.width / 2
            straight += s.width * deep * s.bend_radius / 2 + 4 * s.stop_radius**2 * deep
        assert straight / 2 < taken < 3 * straight, f"{p.name}: slots take {taken:.2f} mm^3, estimate {straight:.2f}"


def test_top_plate(drive: Drive, dims: BevelLayout) -> None:
    """A rounded plate less its holes; wide enough here that no head's pocket breaks out of its edge."""
    levels, e = replace(dims.levels, side_outer_x=dims.levels.side_outer_x + 3.0), dims.top_plate.encoder_holes
    assert e is not None
    t = replace(dims.top_plate, levels=levels)
    thick = levels.top_plate_top_z - levels.top_plate_bottom_z
    area = 2 * levels.side_outer_x * (levels.front_y - levels.back_y) - (4 - pi) * t.corner_radius**2
    holes = ring(t.axle_radius, 0.0, thick)
    seat = ring(t.seat_radius, 0.0, t.seat_depth) + ring(t.shoulder_radius, 0.0, thick - t.seat_depth)
    encoder_hole = ring(e.clearance, 0.0, thick - e.head_depth) + ring(e.head_radius, 0.0, e.head_depth)
    holes += len(t.input_x) * (seat + 2 * encoder_hole)
    head = ring(t.screw_head_radius, 0.0, t.screw_head_depth)
    holes += len(t.screws) * (ring(t.screw_clearance, 0.0, thick - t.screw_head_depth) + head)
    holes += len(t.dowels) * ring(t.dowel_radius, 0.0, thick)
    close(TopPlate(t).solid(), area * thick - holes, "top plate")


def radial_hole(radius: float, inner: float, outer: float) -> float:
    """Cylinder along a radius, between two coaxial cylinders of ``inner`` and ``outer`` radius."""
    x, w = np.polynomial.legendre.leggauss(60)
    x = x * radius
    chord = 2 * np.sqrt(radius**2 - x**2)
    return float(np.sum(w * radius * chord * (np.sqrt(outer**2 - x**2) - np.sqrt(inner**2 - x**2))))


def test_drum_without_terminals_and_windows(dims: BevelLayout) -> None:
    """Sector of stepped rings, web, hub with spigot; the stop's slot, the payload's and the set screws' holes."""
    d = replace(dims.drum, tensioners=(), windows=())
    share, c, thread = 2 * d.half_angle_deg / 360, 0.3, 3.0
    rim = sum(ring(land.surface_radius_mm, d.rim_inner_radius, land.y_end - land.y_start) for land in d.lands)
    web = ring(d.rim_inner_radius, d.hub_radius, d.web_end_y - d.web_start_y)
    web += ring(d.root_radius, d.hub_radius, d.root_end_y - d.web_end_y)
    hub = ring(d.hub_radius, d.bore_radius, d.hub_face_y - d.hub_start_y - c)
    hub += cone(d.hub_radius, d.hub_radius - c, c) - ring(d.bore_radius, 0.0, c)
    hub += ring(d.spigot_radius, d.bore_radius, d.hub_start_y - d.spigot_y)
    half = d.stop_slot_width / 2
    slot_area = 2 * radians(d.stop_slot_end_deg) * d.stop_radius * d.stop_slot_width + pi * half**2
    holes = slot_area * (d.web_end_y - d.web_start_y)
    holes += 4 * ring(d.payload_hole / 2, 0.0, d.payload_depth)
    holes += 2 * radial_hole(thread / 2, d.bore_radius, d.hub_radius)
    error = DrumSector(d, thread).solid().Volume() / (share * (rim + web) + hub - holes) - 1
    assert abs(error) < 1e-6, f"{error:+.2e}"


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
def spur() -> Drive:
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


def test_material_at_one_price_costs_the_made_mass(spur: Drive) -> None:
    bill = layout_of(spur).bill()
    made_g = estimated_mass_g(bill) - sum(item.mass_g or 0.0 for item in bill.items)
    assert material_cost_EUR(_at_one_price(bill)) == pytest.approx(made_g * 1e-3)


def test_bought_parts_cost_their_number_and_the_rope_its_length(spur: Drive) -> None:
    bill = _at_one_price(layout_of(spur).bill())
    rope = replace(spur.cable, price_EUR=3.0)
    length_m = sum(path.length_mm for path in layout_of(spur).cable_paths(0.0)) * 1e-3
    with_entry = [item for item in bill.items if _of_catalogue(bill.parts[item.part].part)]
    assert not [item for item in with_entry if item.name.startswith(CABLE)]
    assert bought_cost_EUR(bill, rope) == pytest.approx(2.0 * len(with_entry) + 3.0 * length_m)


def test_entries_without_a_price_are_named(spur: Drive) -> None:
    with pytest.raises(NoPriceError) as refused:
        bought_cost_EUR(layout_of(spur).bill(), spur.cable)
    assert spur.motor.name in str(refused.value)
    assert spur.cable.name in str(refused.value)
