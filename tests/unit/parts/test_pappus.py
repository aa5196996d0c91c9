"""Turned parts compared with closed forms from the drawing: sums of rings, cones and prisms."""

from __future__ import annotations

from dataclasses import replace
from math import acos, pi, radians, sqrt

import cadquery as cq
import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.support.top_plate import TopPlate
from mbcdm_cad.parts.drum_sector.part import DrumSector
from mbcdm_cad.parts.input_pulley.draw import create_input_pulley

TOLERANCE = 1e-9


def ring(outer: float, inner: float, height: float) -> float:
    return pi * (outer**2 - inner**2) * height


def cone(first: float, last: float, height: float) -> float:
    return pi * height / 3 * (first**2 + first * last + last**2)


def hexagon(across_flats: float, height: float) -> float:
    return sqrt(3) / 2 * across_flats**2 * height


def close(solid: cq.Solid, expected: float, name: str) -> None:
    error = solid.Volume() / expected - 1
    assert abs(error) < TOLERANCE, f"{name}: {solid.Volume():.9f} mm^3, closed form {expected:.9f} ({error:+.1e})"


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
    levels = replace(dims.levels, side_outer_x=dims.levels.side_outer_x + 3.0)
    t = replace(dims.top_plate, levels=levels)
    thick = levels.top_plate_top_z - levels.top_plate_bottom_z
    area = 2 * levels.side_outer_x * (levels.front_y - levels.back_y) - (4 - pi) * t.corner_radius**2
    head_radius, head_depth = 1.6, 1.8
    holes = ring(t.axle_radius, 0.0, thick)
    seat = ring(t.seat_radius, 0.0, t.seat_depth) + ring(t.shoulder_radius, 0.0, thick - t.seat_depth)
    encoder_hole = ring(t.encoder_screw_clearance, 0.0, thick - head_depth) + ring(head_radius, 0.0, head_depth)
    holes += len(t.input_x) * (seat + 2 * encoder_hole)
    head = ring(t.screw_head_radius, 0.0, t.screw_head_depth)
    holes += len(t.screws) * (ring(t.screw_clearance, 0.0, thick - t.screw_head_depth) + head)
    holes += len(t.dowels) * ring(t.dowel_radius, 0.0, thick)
    close(TopPlate(t, head_radius, head_depth).solid(), area * thick - holes, "top plate")


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
