"""Arrangement of the motors: setback of the input axes, gearheads with two to four screws; the bill of the parts."""

import re
from collections import Counter
from dataclasses import replace
from itertools import product
from math import atan2, hypot, radians

import numpy as np
import pytest

from mbcdm_cad.design.fields import ENTRY_NAME
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import load_text, new_design_text
from mbcdm_cad.layouts.miso_bevel.bill import bill
from mbcdm_cad.layouts.miso_bevel.cable_path import GUIDE, routed
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive, bevel
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.parts.bill import Item, cable_item, entry_stem, sorted_items
from mbcdm_cad.parts.bodies import screw_places
from mbcdm_cad.parts.fits import limits
from mbcdm_cad.parts.input_pulley.part import InputPulley
from mbcdm_cad.parts.making import land_band_mm
from mbcdm_cad.routes.curves import Arc, Line
from mbcdm_cad.routes.route import Span, Wrap
from tests.support.checked import result, statuses


@pytest.fixture(scope="module")
def reference() -> BevelDrive:
    """The reference drive."""
    return bevel(load_text(new_design_text("reference")).drive)


def set_back(drive: BevelDrive, setback_mm: float, distance_mm: float = 42.0) -> BevelDrive:
    """The drive with its input axes moved, and its back plate with them."""
    back = drive.support.back_y_mm - setback_mm
    return replace(
        drive,
        centre_distance_mm=distance_mm,
        input_setback_mm=setback_mm,
        support=replace(drive.support, back_y_mm=back),
    )


@pytest.mark.parametrize("distance_mm", [36.5, 42.0, 55.0, 62.0])
def test_a_setback_lets_the_terminals_pass_the_gearheads(reference: BevelDrive, distance_mm: float) -> None:
    before, after = (statuses(set_back(reference, mm, distance_mm)) for mm in (0.0, 1.2))
    assert before["drum_sweep"] == "fail" and after["drum_sweep"] == "pass"
    worse = {name for name in after if after[name] == "fail" and before[name] != "fail"} - {"envelope_y", "envelope_x"}
    assert not worse, f"the setback breaks {worse}"


@pytest.mark.parametrize("setback_mm", [0.0, 1.2, 9.0])
def test_routes_and_drawn_paths_agree_with_a_setback(reference: BevelDrive, setback_mm: float) -> None:
    """Two derivations: the model's by formula, the drawing's from tangent points."""
    drive = set_back(reference, setback_mm)
    model = routed(drive)
    routes, dims = model.routes, BevelLayout(drive)
    for route, path, run in zip(routes.cables, dims.cable_paths(0.0), drive.cables, strict=True):
        guide, span = path.piece("guide"), path.piece("span")
        assert isinstance(guide, Arc) and isinstance(span, Line)
        wrap = next(p for p in route.pieces if isinstance(p, Wrap) and p.body == GUIDE)
        drawn_deg, model_deg = np.degrees([abs(guide.angle_end - guide.angle_start), wrap.angle_rad])
        assert drawn_deg == pytest.approx(model_deg, abs=1e-9), run.name
        free = next(p for p in route.pieces if isinstance(p, Span) and p.length_m > 0.0)
        plan = span.tangent(0.0)[:2] / hypot(*span.tangent(0.0)[:2])
        assert np.abs(plan - np.array(free.direction[:2])).max() < 1e-9, f"{run.name}: {plan} against {free.direction}"
        start, end = path.piece("span_in").points(np.array([0.0]))[0], guide.points(np.array([0.0]))[0]
        assert hypot(*(end - start)[:2]) == pytest.approx(1e3 * free.length_m, abs=1e-9)
        assert hypot(*(start[:2] - np.array([run.input_side * drive.input_x_mm, -setback_mm]))) == pytest.approx(
            run.input_radius_mm, abs=1e-9
        )
    for body in routes.bodies:
        if body.kind == "input":
            x, y = 1e3 * np.array(body.point_m)[:2]
            assert (hypot(x, y), y) == pytest.approx((drive.centre_distance_mm, -setback_mm), abs=1e-9), body.name


def test_the_distance_of_the_axes_stays_l(reference: BevelDrive) -> None:
    drive = set_back(reference, 5.0)
    assert hypot(drive.input_x_mm, drive.input_y_mm) == pytest.approx(drive.centre_distance_mm, abs=1e-12)


def test_a_setback_beyond_half_of_l_is_refused_with_its_line() -> None:
    text = new_design_text("x").replace("  centre_distance_mm:", "  input_setback_mm: 20.0\n  centre_distance_mm:")
    with pytest.raises(InputError, match="too far behind") as raised:
        load_text(text)
    assert raised.value.problems[0].line > 1


@pytest.mark.parametrize("count", [2, 3, 4])
def test_screws_of_a_flange_mirror_in_its_middle_plane(count: int) -> None:
    places = screw_places(count, 6.5)
    assert len(places) == count
    assert {(round(-x, 6) + 0.0, round(y, 6)) for x, y in places} == {
        (round(x, 6) + 0.0, round(y, 6)) for x, y in places
    }
    angles = np.sort([atan2(y, x) % (2 * np.pi) for x, y in places])
    assert np.diff(angles) == pytest.approx(2 * np.pi / count, abs=1e-6)


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5])
def test_every_gearhead_screw_is_in_the_bill_and_counted(reference: BevelDrive, count: int) -> None:
    drive = replace(reference, gearhead=replace(reference.gearhead, screw_count=count))
    items = [item.name for item in bill(BevelLayout(drive)).items if item.name.startswith("gearhead_screw_left")]
    assert items == [f"gearhead_screw_left_{n}" for n in range(1, count + 1)]
    assert statuses(drive)["screw_counts"] == ("pass" if count in (2, 3, 4) else "fail")


def grooved(drive: BevelDrive, lead_mm: float = 0.89) -> BevelDrive:
    """The drive with a helical groove for each cable on the input pulleys."""
    pulleys = replace(drive.input_pulleys, surface="grooved")
    return replace(drive, input_pulleys=pulleys, helix_lead_mm=lead_mm)


def test_grooves_allow_the_fleet_angle_that_smooth_pulleys_do_not(reference: BevelDrive) -> None:
    near = replace(reference, centre_distance_mm=31.0)
    smooth = result(near, "fleet_angle")
    assert smooth.status == "fail" and "input_pulleys.surface: grooved" in smooth.remedy, smooth
    after = statuses(grooved(near))
    assert {after[name] for name in ("fleet_angle", "groove_walls", "helix_lead", "self_clearance")} == {"pass"}
    assert statuses(grooved(near, 0.87))["helix_lead"] == "fail"


@pytest.mark.parametrize("angle_deg", [-35.0, -10.0, 0.0, 35.0])
def test_the_cable_lies_along_the_middle_of_its_groove(reference: BevelDrive, angle_deg: float) -> None:
    """At every drum angle the wound rope, seen on the turned pulley, follows the groove, which goes on at both ends."""
    drive = grooved(reference)
    dims = BevelLayout(drive)
    motions = {body.name: body.motion(angle_deg) for body in dims.moving_bodies}
    paths = {path.cable.name: path for path in dims.cable_paths(np.radians(angle_deg))}
    for pulley in dims.inputs:
        for groove in pulley.grooves:
            helix = paths[groove.cable_name].piece("helix")
            points = motions[f"input_{pulley.name}"].inverse.apply(helix.points(np.linspace(0.0, 1.0, 200)))
            angle = np.unwrap(np.arctan2(points[:, 1], points[:, 0]))
            turns = 2 * np.pi * np.round((angle[0] - groove.start_angle_rad) / (2 * np.pi))
            share = (angle - turns - groove.start_angle_rad) / (groove.end_angle_rad - groove.start_angle_rad)
            assert share.min() > 0.0 and share.max() < 1.0, f"{groove.cable_name} winds past its groove: {share}"
            z = groove.start_z + share * (groove.end_z - groove.start_z)
            assert np.abs(z - points[:, 2]).max() < 1e-9
            assert np.hypot(points[:, 0], points[:, 1]) == pytest.approx(
                groove.root_radius + drive.cable.diameter_mm / 2
            )


@pytest.mark.slow
def test_grooved_pulleys_are_sound_and_clear_their_cables(reference: BevelDrive) -> None:
    """Metal removed by Pappus' theorem for a helix; the rope's rod and the pulley share nothing."""
    from mbcdm_cad.parts.input_pulley.draw import create_input_pulley
    from mbcdm_cad.workshop.kernel import common, rod, validate_faces, validate_solid
    from mbcdm_cad.workshop.pairs import CABLE_UNDERSIZE_MM, VOLUME_LIMIT_MM3

    drive = grooved(reference)
    dims, d = BevelLayout(drive), drive.cable.diameter_mm
    pulley = dims.inputs[0]
    solid = create_input_pulley(pulley)
    validate_solid("input_pulley", solid)
    validate_faces("input_pulley", solid)
    plain = replace(pulley, grooves=(), lower_surface_radius=pulley.lower_land_radius)
    plain = replace(plain, upper_surface_radius=pulley.upper_land_radius)
    removed = create_input_pulley(plain).Volume() - solid.Volume()
    expected = 0.0
    for groove in pulley.grooves:
        r, h, half = groove.radius, groove.depth, groove.half_width
        area = r**2 * np.arccos((r - h) / r) - (r - h) * half
        # Of a circular segment, from the middle of its circle.
        centroid = (2 * half) ** 3 / (12 * area)
        turned = abs(groove.end_angle_rad - groove.start_angle_rad)
        expected += area * (groove.root_radius + r - centroid) * turned
    # Less what the slots have taken already.
    assert 0.93 * expected < removed < expected, (removed, expected)
    item = next(i for i in bill(dims, 35.0).items if i.name == f"input_pulley_{pulley.name}")
    for path in dims.cable_paths(np.radians(35.0)):
        if path.cable.input_name == pulley.name:
            for stretch in path.stretches[:2]:
                line = path.only(stretch.pieces).line
                volume, place = common(rod(line, d / 2 - CABLE_UNDERSIZE_MM), solid, item.location)
                assert abs(volume) < VOLUME_LIMIT_MM3, (path.cable.name, stretch.body, volume, place)


def test_terminals_of_a_wide_sector_stand_at_its_ends(reference: BevelDrive) -> None:
    """Beyond a right angle every degree of the sector is one more of travel, for each cable alike."""

    def anchors(sector_deg: float) -> np.ndarray:
        drive = replace(reference, drum=replace(reference.drum, sector_half_angle_deg=sector_deg))
        return np.degrees([t.anchor_rad for t in BevelLayout(drive).drum.tensioners])

    assert anchors(120.0) - anchors(100.0) == pytest.approx(20.0, abs=0.2)
    wide = replace(reference, half_travel_deg=60.0, drum=replace(reference.drum, sector_half_angle_deg=105.0))
    after = statuses(wide)
    assert {after[name] for name in ("wrap_left", "terminal_clears_guide", "spans_clear", "drum_sweep")} == {"pass"}


@pytest.mark.slow
def test_the_section_of_a_grooved_pulley_is_that_of_its_helices(reference: BevelDrive) -> None:
    """The views have rings in place of helices: cut along X, where the section lies, both give the same face."""
    import cadquery as cq

    from mbcdm_cad.drawings.draw import PartFacts, draw_sheet
    from mbcdm_cad.workshop.kernel import validate_solid
    from tests.support.drawing_reader import dimensions, document
    from tests.support.rebuilt import pulley

    plane = cq.Face.makePlane(200.0, 200.0, cq.Vector(0, 0, 0), cq.Vector(0, 1, 0))
    plain, cut = (BevelLayout(drive).inputs[0] for drive in (reference, grooved(reference)))
    assert InputPulley(plain).in_views() == InputPulley(plain)
    part = InputPulley(cut)
    true, drawn = (plane.intersect(p.solid()) for p in (part, part.in_views()))
    validate_solid("input_pulley", part.in_views().solid())
    smooth = replace(cut, grooves=(), lower_surface_radius=cut.lower_land_radius)
    smooth = replace(smooth, upper_surface_radius=cut.upper_land_radius)
    grooves = plane.intersect(InputPulley(smooth).solid()).Area() - true.Area()
    assert grooves > 1.0, "mm2 of grooves"
    assert true.cut(drawn).Area() + drawn.cut(true).Area() < 0.01 * grooves, (true.Area(), drawn.Area(), grooves)
    shown = part.in_views().solid()
    doc = document(draw_sheet(part.sheet("p"), shown, PartFacts("d", "m", 1.0, "0", 0.02))["dxf"])
    assert pulley(doc, dimensions(doc)) == pytest.approx(shown.Volume(), rel=2e-3), "made from its sheet"


def test_the_sheet_of_a_grooved_pulley_gives_grooves_as_a_table(reference: BevelDrive) -> None:
    drive = grooved(reference)
    sheet = InputPulley(BevelLayout(drive).inputs[0]).sheet("p")
    table = {row[0]: row[1:] for row in next(t for t in sheet.tables if t.title == "Helical grooves").rows}
    assert table["lead"] == ("0.89", "0.89") and table["root %%c"] == ("11.19", "11.99")
    assert table["hand of the helix"] == ("right", "right")
    radii = {c.input_radius_mm for c in drive.cables if c.input_name == drive.input_names[0]}
    bands = {f.nominal_mm: limits(f.nominal_mm, f.code).upper_mm / 2 for f in sheet.fits if f.what.startswith("root")}
    counted = {round(2 * r - drive.cable.diameter_mm, 6): land_band_mm(drive, r, "pulley") for r in radii}
    assert bands == pytest.approx(counted), "the sheet's roots and what the model counts"


@pytest.mark.parametrize("kind", ["bearing", "screw"])
def test_every_name_that_the_schema_allows_is_a_part_of_its_own(kind: str, dims: BevelLayout) -> None:
    allowed = [chr(k) for k in range(128) if re.fullmatch(ENTRY_NAME, f"a{chr(k)}")]
    signs = [sign for sign in allowed if not sign.isalnum()] + ["P"]
    names = ["".join(name) for name in product("a", *([signs] * 4))] + ["618/4", "9" * 64, "9" + 63 * "/"]
    stems = {entry_stem(kind, name) for name in names}
    assert len(stems) == len(names)
    assert (entry_stem("bearing", "618/4"), entry_stem("screw", "M2x3-set")) == ("bearing_618-4", "screw_M2x3-set")
    item = bill(dims).items[0]
    for stem in stems:  # as a file's name
        sorted_items([replace(item, part=stem)], {stem})


def test_counts_of_what_comes_more_than_once(dims: BevelLayout) -> None:
    count = Counter(item.part for item in bill(dims).items)
    drive = dims.drive
    assert count["terminal"] == count["stop"] == 4 and count["nut"] == 8
    assert count["motor"] == count["gearhead"] == count["encoder"] == count["collar"] == 2
    assert sum(n for part, n in count.items() if part.startswith("bearing_")) == 8
    screws = Counter(item.part for item in bill(dims).items if item.part.startswith("screw_"))
    expected: Counter[str] = Counter()
    expected["screw_M2x6"] += 4  # top plate
    expected[f"screw_{drive.gearhead.screw}"] += 2 * drive.gearhead.screw_count
    expected[f"screw_{drive.encoder.screw}"] += 2 * drive.encoder.screw_count
    expected[f"screw_{drive.drum_encoder.screw}"] += drive.drum_encoder.screw_count
    expected[f"screw_{dims.collar.screw}"] += 2
    expected[f"screw_{dims.drum.set_screw}"] += 2
    expected["screw_M2x3-set"] += 1  # guide axle
    assert screws == expected


def test_names_are_unique_and_every_part_is_used(dims: BevelLayout) -> None:
    b = bill(dims)
    assert sorted_items(b.items, b.parts)
    assert {item.part for item in b.items} == set(b.parts)


def test_bought_items_carry_catalogue_masses_and_made_ones_none(dims: BevelLayout) -> None:
    b = bill(dims)
    for item in b.items:
        assert (item.mass_g is None) == (item.kind == "made"), item.name
    drive = dims.drive
    motors = [item.mass_g for item in b.items if item.part == "motor"]
    assert motors == [drive.motor.mass_g] * 2


def point(item: Item) -> np.ndarray:
    return item.location.shift_mm


@pytest.mark.parametrize("angle_deg", [-35.0, 10.0, 35.0])
def test_groups_turn_as_the_cables_make_them(dims: BevelLayout, angle_deg: float) -> None:
    """theta_g = -6 theta_o, theta_m = +9 theta_o: a mark on each rim moves as far as the cable on it."""
    motions = {body.name: body.motion(angle_deg) for body in dims.moving_bodies}
    theta = radians(angle_deg)
    for cable in dims.drive.cables:
        mark = np.array([0.0, 0.0, cable.drum_radius_mm])
        drum = motions["drum"].apply(mark)
        assert np.arctan2(drum[0], drum[2]) == pytest.approx(theta, abs=1e-12)
        for group, radius, ratio in (
            ("guide", cable.guide_radius_mm, -6.0),
            (f"input_{cable.input_name}", cable.input_radius_mm, 9.0),
        ):
            turned = motions[group].rotation @ np.array([radius, 0.0, 0.0])
            moved = radius * (np.arctan2(turned[1], turned[0]) - ratio * theta)
            assert moved / radius % (2 * np.pi) == pytest.approx(0.0, abs=1e-9) or moved / radius % (
                2 * np.pi
            ) == pytest.approx(2 * np.pi, abs=1e-9), f"{cable.name} on {group}"


def test_only_what_moves_moves(dims: BevelLayout) -> None:
    rest, turned = bill(dims, 0.0), bill(dims, 20.0)
    for a, b in zip(rest.items, turned.items, strict=True):
        assert a.name == b.name and a.group == b.group
        if a.group == "fixed":
            assert a.location == b.location, a.name
        elif np.linalg.norm(point(a)[[0, 2]]) > 1.0 and a.group == "drum":
            assert np.linalg.norm(point(a) - point(b)) > 0.1, f"{a.name} stays behind"


def test_cables_end_where_stop_and_terminal_stand(dims: BevelLayout) -> None:
    for angle in (-30.0, 0.0, 30.0):
        items = {item.name: item for item in bill(dims, angle).items}
        for path in dims.cable_paths(radians(angle)):
            name = path.cable.name
            tail = path.piece("tail").points(np.array([0.0, 1.0]))
            terminal = items[f"terminal_{name}"].location
            moved = next(t.drawn_in for t in dims.drum.tensioners if t.cable_name == name)
            land = terminal.apply(np.array([0.0, 0.0, -moved]))
            assert np.abs(land - tail[0]).max() < 1e-9, f"{name} at {angle}"
            axis = terminal.rotation @ np.array([0.0, 0.0, 1.0])
            assert np.abs(axis - path.piece("tail").tangent(0.0)).max() < 1e-9
            stop = items[f"stop_{name}"].location
            chord = path.piece("chord")
            assert np.abs(stop.rotation @ [0, 0, 1] + chord.tangent(0.0)).max() < 0.03, f"{name}: stop not on its chord"
            start = chord.points(np.array([0.0]))[0]
            length = next(s for p in dims.inputs for s in p.slots if s.cable_name == name)
            end = stop.apply(np.array([0.0, 0.0, length.stop_start - length.stop_end]))
            assert np.linalg.norm(end - start) < 0.05, f"{name}: cable ends {np.linalg.norm(end - start):.3f} mm off"


def test_a_cable_may_have_the_name_of_any_other_part(dims: BevelLayout) -> None:
    """Its item is called cable_NAME all the same."""
    names = ("frame", "drum", "cable_x", "1")
    cables = tuple(replace(c, name=n) for c, n in zip(dims.drive.cables, names, strict=True))
    from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout

    b = bill(BevelLayout(replace(dims.drive, cables=cables)))
    sorted_items(b.items, b.parts)
    assert [cable_item(n) for n in names] == ["cable_frame", "cable_drum", "cable_x", "cable_1"]
    assert len(b.items) == len(bill(dims).items)
