"""Idlers of siso_spur: the taut strand, its loads, its lengths, its friction, the parts that carry it, its messages."""

from dataclasses import replace
from functools import cache
from itertools import combinations, pairwise
from math import pi, radians, sin, sqrt

import cadquery as cq
import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra
from shapely.geometry import Point
from shapely.ops import unary_union

from mbcdm_cad.checks.comparison import families
from mbcdm_cad.checks.fixings import bent_axle_Nmm
from mbcdm_cad.checks.run import run_check
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.layouts.loader import layout_of, load_text
from mbcdm_cad.layouts.siso_spur.checks import idlers
from mbcdm_cad.layouts.siso_spur.checks.idlers import LoadedPin, bearing_forces_N
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive, spur
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.siso_spur.routes import Circle, Strand, taut
from mbcdm_cad.layouts.siso_spur.support.stiffness import seat_forces
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.losses import bearing_torque_Nm, tangent_share
from mbcdm_cad.model.stiffness import unit_tensions_N
from mbcdm_cad.model.structure.causes import Acting, Section, bending_urad_Nm
from mbcdm_cad.model.structure.drum_sector import Isotropic
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.route import Span, Wrap, body_load
from mbcdm_cad.workshop.kernel import location, validate_solid
from tests.support.checked import failing, result, results
from tests.support.sliced_cables import assert_joined

TEXT = """\
name: led
configuration: siso_spur
travel: {half_angle_deg: 60.0}
transmission: {input_to_drum: 8.0, drum_radius_mm: 60.0, centre_distance_mm: 200.0}
loads: {peak_torque_Nm: 2.0}
"""
LED = TEXT + "idlers: {pairs: 1}\n"


def led() -> SpurDrive:
    return in_parallel(1)


@cache
def straight() -> SpurDrive:
    return spur(load_text(TEXT, "led.yaml").drive)


@cache
def in_parallel(count: int) -> SpurDrive:
    """With so many equal cables on its idlers' axles, as the rules size it."""
    text = LED if count == 1 else LED.replace("200.0}", f"200.0, parallel: {count}}}")
    return spur(load_text(text, "led.yaml").drive)


def shortest(circles: list[Circle]) -> float:
    """Length of the shortest line from the -x side of the input to the +x side of the drum, by Dijkstra.

    It knows no tangents: its nodes are points on the circles, its edges arcs, and the straight lines that enter no
    circle and cross no wall. Walls run from the axes up from the input, to +x from idlers, down from the drum, so that
    the line passes the idlers on their -x side.
    """
    angle = 2.0 * pi * np.arange(POINTS) / POINTS
    ring = np.stack([np.sin(angle), np.cos(angle)], axis=1)
    centre = np.array([[float(c.x), float(c.z)] for c in circles])
    radius = np.array([float(c.radius) for c in circles])
    node = np.concatenate([c + r * ring for c, r in zip(centre, radius, strict=True)])
    away = [(0.0, 1e3), *[(1e3, 0.0)] * (len(circles) - 2), (0.0, -1e3)]
    index, rows, columns, lengths = np.arange(len(node)), [], [], []
    for k, r in enumerate(radius):
        own = index[k * POINTS : (k + 1) * POINTS]
        # The two arcs at the circle's wall are left out.
        wall = round(np.arctan2(*away[k]) / (2.0 * pi) * POINTS)
        kept = np.delete(np.arange(POINTS), [(wall - 1) % POINTS, wall % POINTS])
        rows.append(own[kept])
        columns.append(np.roll(own, -1)[kept])
        lengths.append(np.full(len(kept), 2.0 * pi * r / POINTS))
    for k, m in combinations(range(len(circles)), 2):
        one, two = (g.ravel() for g in np.meshgrid(*(index[j * POINTS : (j + 1) * POINTS] for j in (k, m))))
        start, way = node[one], node[two] - node[one]
        free = np.ones(len(one), dtype=bool)
        for c, r, wall in zip(centre, radius, away, strict=True):
            at = np.clip(((c - start) * way).sum(axis=1) / (way**2).sum(axis=1), 0.0, 1.0)
            free &= np.linalg.norm(start + at[:, None] * way - c, axis=1) > r * (1.0 - 0.6 * (pi / POINTS) ** 2) - 1e-9
            # The line meets the wall c + t wall where both parameters lie in 0..1.
            across = way[:, 0] * wall[1] - way[:, 1] * wall[0]
            off = c - start
            with np.errstate(divide="ignore", invalid="ignore"):
                u = (off[:, 0] * wall[1] - off[:, 1] * wall[0]) / across
                t = (off[:, 0] * way[:, 1] - off[:, 1] * way[:, 0]) / across
            free &= ~((u >= 0.0) & (u <= 1.0) & (t >= 0.0) & (t <= 1.0))
        rows.append(one[free])
        columns.append(two[free])
        lengths.append(np.linalg.norm(way[free], axis=1))
    edges = coo_matrix((np.concatenate(lengths), (np.concatenate(rows), np.concatenate(columns))), (len(node),) * 2)
    # From the input's -x side to the drum's +x side.
    begin, end = 3 * POINTS // 4, (len(circles) - 1) * POINTS + POINTS // 4
    return float(dijkstra(edges.tocsr(), directed=False, indices=begin)[end])


# Points on each circle.
POINTS = 480


def counted(circles: list[Circle], found: Strand) -> float:
    """The same length by the formulas."""
    on = float(circles[0].radius) * (0.5 * pi - float(found.leaving_rad))
    on += float(circles[-1].radius) * (0.5 * pi - float(found.landing_rad))
    arcs = sum(float(c.radius) * float(w) for c, w in zip(circles[1:-1], found.wraps, strict=True))
    return on + arcs + float(found.length.sum())


@pytest.mark.parametrize(
    ("distance", "r_i", "r_k", "gap", "above"),
    [
        (200.0, 7.5, 9.5, 1.1, 4.0),
        (400.0, 4.0, 20.0, 2.0, 1.0),
        (180.0, 12.0, 8.0, 0.5, 20.0),
        (300.0, 10.0, 15.0, 10.0, 8.0),
    ],
)
def test_the_strand_is_the_shortest_line_over_its_pulleys(
    distance: float, r_i: float, r_k: float, gap: float, above: float
) -> None:
    circles = [
        Circle(0.0, distance, r_i, -1),
        Circle(r_k + gap, 60.0 + r_k + above, r_k, -1),
        Circle(0.0, 0.0, 60.0, 1),
    ]
    found = taut(circles)
    assert float(found.wraps.min()) > 0.05
    assert counted(circles, found) == pytest.approx(shortest(circles), abs=2e-3)


def test_pulleys_of_one_sense_have_the_hull_of_their_circles() -> None:
    """Both tangents, and what is left of both circles, are the outline of the convex hull (shapely)."""
    one, two = (0.0, 200.0, 7.5), (10.6, 73.5, 9.5)
    hull = unary_union([Point(x, z).buffer(r, 4096) for x, z, r in (one, two)]).convex_hull.length
    lengths, headings = [], []
    for sense in (1, -1):
        found = taut([Circle(*one, sense), Circle(*two, sense)])
        lengths.append(float(found.length[0]))
        headings.append(float(found.heading[0]))
    between = (headings[1] - headings[0]) % (2.0 * pi)
    assert sum(lengths) + one[2] * (2 * pi - between - pi) + two[2] * (pi + between) == pytest.approx(
        hull, rel=1e-5
    ) or sum(lengths) + one[2] * (pi + between) + two[2] * (pi - between) == pytest.approx(hull, rel=1e-5)


def test_without_an_idler_the_strand_is_eq_11() -> None:
    found, drive = taut([Circle(0.0, 200.0, 7.5, -1), Circle(0.0, 0.0, 60.0, 1)]), straight()
    assert float(found.length[0]) == pytest.approx(sqrt(200.0**2 - 67.5**2))
    assert float(found.landing_rad) == pytest.approx(float(found.leaving_rad)) == pytest.approx(drive.landing_rad)


def test_two_cables_over_idlers_pass() -> None:
    """With idlers, rim and hub as wide as their levels need; too wide an idler meets the next one on its axle."""
    drive = in_parallel(2)
    failed = failing(drive)
    assert not failed, failed
    wide = replace(drive, idlers=replace(drive.leading, width_mm=drive.pitch_mm - 2.0))
    found = result(SpurLayout(wide), "sectors_apart")
    assert found.status == "fail" and "an idler from the next" in found.message and found.remedy, found


def test_a_design_with_idlers_passes_and_lands_nearer_the_middle() -> None:
    """They leave the drum a longer wrap: a plain drive with the motor that far away has none left at +-115 degrees."""
    failed = failing(led())
    assert not failed, failed
    assert led().landing_rad < 0.6 * straight().landing_rad


@pytest.mark.parametrize("angle_deg", [-60.0, -17.0, 0.0, 60.0])
def test_the_drawn_cable_is_smooth_and_keeps_its_length(angle_deg: float) -> None:
    layout = SpurLayout(led())
    (path,), (centred,) = (layout.cable_paths(radians(angle)) for angle in (angle_deg, 0.0))
    assert_joined(path)
    assert path.length_mm == pytest.approx(centred.length_mm, abs=1e-9)
    assert sum(s.count("idler") for s, _ in path.pieces) == 2


def test_the_cable_walks_on_the_idler_without_sliding_along_it() -> None:
    """A mark on the rope stays in its plane across the axes from the input to the drum, on spans and idlers."""
    layout, at, marks = SpurLayout(led()), 0.0, []
    for angle in np.radians(np.linspace(-20.0, 20.0, 9)):
        path = layout.cable_paths(float(angle))[0]
        ends = np.cumsum([piece.length_mm for _, piece in path.pieces])
        # The path begins in the terminal on the drum: so far along it lies the same point of the rope.
        names = [name for name, _ in path.pieces]
        at = at or float(ends[names.index("idler_1_side_1")]) + 8.0
        n = int(np.searchsorted(ends, at))
        piece = path.pieces[n][1]
        point = piece.points(np.array([1.0 - (ends[n] - at) / piece.length_mm]))[0]
        marks.append((names[n], *point))
    assert {name for name, *_ in marks} >= {"span_side_1", "idler_1_side_1", "span_2_side_1"}, marks
    assert np.ptp([y for _, _, y, _ in marks]) < 2e-3 and np.ptp([z for *_, z in marks]) > 10.0, marks


@pytest.mark.parametrize(("load_Nm", "count"), [(0.0, 1), (2.0, 1), (-2.0, 1), (5.0, 2)])
def test_the_pulls_on_all_bodies_balance_the_torques(load_Nm: float, count: int) -> None:
    """Static balance of all cables: bodies' forces add up to nothing, their moments to the shafts' torques."""
    d = layout_of(in_parallel(count)).si
    tension = solve_equilibrium(d, load_Nm).tension_N
    force, moment = np.zeros(3), 0.0
    for body in d.routes.bodies:
        load = body_load(d.routes, body.name, tension)
        force += load.force_N
        moment += float(np.cross(np.array(body.point_m), load.force_N)[1])
    assert np.abs(force).max() < 1e-9
    at_drum = float((d.sigma * tension * d.drum_radius_m).sum())
    # The input's axis is -Y: cables turn it about that by minus sigma T r.
    at_input = float((d.sigma * tension * d.input_radius_m).sum())
    assert moment + at_drum + at_input == pytest.approx(0.0, abs=1e-9)


def on_strap_N(pin: LoadedPin, state: int) -> Floats:
    """The force of an axle on the strap with the cables in the middle of their walk."""
    rows = pin.states_N[2 * state : 2 * state + 2]
    return np.mean([bent_axle_Nmm(forces, pin.at_mm, pin.ends_mm)[1] for forces in rows], axis=0)


def test_a_shared_axle_carries_the_vector_sum_of_its_spans() -> None:
    """The strap holds what the spans of all its idlers pull, by their levers from the plate."""
    layout = SpurLayout(in_parallel(2))
    d, loads = layout.loads.si, layout.loads.on_bodies
    for pin in bearing_forces_N(layout):
        for state, (_, tension) in enumerate(layout.loads.states):
            lever = np.zeros(3)
            for body in pin.bodies:
                route = next(route for route in d.routes.cables if route.cable == body.removeprefix("idler_1_"))
                pull = float(tension[d.cable_names.index(route.cable)])
                # The rope pulls an idler towards both spans, from the input to it and from it to the drum.
                before, after = (np.array(piece.direction) for piece in route.pieces if isinstance(piece, Span))
                force = pull * (after - before)
                assert loads[state].bodies[body].force_N == pytest.approx(force, abs=1e-9 * pull)
                wrap = next(piece for piece in route.pieces if isinstance(piece, Wrap) and piece.body == body)
                lever += force * (wrap.height_m * 1e3 - pin.ends_mm[0])
            strap = on_strap_N(pin, state)
            assert strap == pytest.approx(lever / (pin.ends_mm[1] - pin.ends_mm[0]), abs=1e-9 * pull)


def test_an_axle_bends_as_seen_from_its_other_end() -> None:
    """Moments from the far end, and the turn by its bending and shear with the textbook's influence coefficients."""
    rng, at, ends = np.random.default_rng(7), np.array([6.0, 11.0, 30.0, 37.0, 52.0, 58.0]), (0.0, 70.0)
    forces = rng.normal(0.0, 50.0, (6, 3)) * (1.0, 0.0, 1.0)
    most, far = bent_axle_Nmm(forces, at, ends)
    beyond = [far * (70.0 - a) - forces.T @ np.maximum(at - a, 0.0) for a in at]
    assert most == pytest.approx(max(np.linalg.norm(beyond, axis=1)))
    section, metal = Section(*ends, 4.0), Isotropic(2.1e5, 0.3)
    near = forces.sum(axis=0) - far
    loads = [(a, f) for a, f in zip(at, forces, strict=True)] + [(0.0, -near), (70.0, -far)]
    found = bending_urad_Nm(np.array([0.0, 1.0, 0.0]), [Acting(a, f, np.zeros(3)) for a, f in loads], [section], metal)
    low, high = np.minimum.outer(at, at), 70.0 - np.maximum.outer(at, at)
    bent = low * high * (70.0**2 - low**2 - high**2) / (6.0 * 70.0 * metal.modulus_MPa * section.second_moment_mm4)
    sheared = low * high / (70.0 * metal.shear_MPa * section.shear_area_mm2(metal.poisson))
    assert found == pytest.approx(1e3 * float(np.einsum("ia,ij,ja->", forces, bent + sheared, forces)), rel=2e-3)


@pytest.mark.parametrize("count", [1, 2])
def test_the_frame_is_in_balance_with_the_load(count: int) -> None:
    """Forces on its seats, idlers included, by 1 N m on the drum: none left across, and 1 N m about the drum's axis."""
    layout = SpurLayout(in_parallel(count))
    forces = seat_forces(layout, unit_tensions_N(layout.si))
    assert len(forces) == 7
    across = sum(force for _, _, force, _ in forces)
    about = sum(couple + at[2] * force for _, at, force, couple in forces)
    assert across == pytest.approx(0.0, abs=1e-9)
    assert abs(about) == pytest.approx(1e3, rel=1e-6)


def test_a_longer_way_makes_the_cable_softer_and_each_idler_takes_its_share() -> None:
    near, far = layout_of(led()).si, layout_of(replace(led(), centre_distance_mm=400.0)).si
    turn = [float(np.diff(solve_equilibrium(d, np.array([0.0, 0.5])).drum_angle_rad)[0]) for d in (near, far)]
    assert abs(turn[1]) > 1.2 * abs(turn[0])
    train, d = layout_of(led()).losses, led().cable.diameter_mm
    bends = {bend.name: bend.share for bend in train.rope}
    both = 2.0 * float(tangent_share(d, 2.0 * led().leading.radius_mm))
    assert bends["cables on the idler_1_side_1"] == pytest.approx([both, 0.0])
    assert bends["cables on the idler_1_side_2"] == pytest.approx([0.0, both])


def test_an_idlers_bearings_drag_by_the_pull_of_both_spans() -> None:
    """By hand: 2 T sin(wrap / 2) on both bearings together, mu/2 P d, as often as the idler turns for the drum."""
    drive = led()
    d = layout_of(drive).si
    tension = solve_equilibrium(d, 0.0).tension_N
    own = [pair for pair in layout_of(drive).losses.bearings if pair.name == "idlers' bearings"]
    assert len(own) == 2
    pull = 2.0 * float(tension[0]) * sin(float(drive.strand.wraps[0]) / 2)
    expected = float(bearing_torque_Nm(pull, 0.0, drive.idler_bearing.bore_mm * 1e-3))
    assert abs(own[0].turns) == pytest.approx(60.0 / drive.leading.radius_mm)
    assert float(own[0].torque_Nm(tension)) == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize(
    ("field", "value", "check"), [("width_mm", 4.0, "idler_walk"), ("radius_mm", 40.0, "idler_room")]
)
def test_what_does_not_fit_fails_with_a_remedy(field: str, value: float, check: str) -> None:
    changed = replace(led(), idlers=replace(led().leading, **{field: value}))
    result = run_check(getattr(idlers, check), SpurLayout(changed))
    assert result.status == "fail" and result.remedy, result


def test_thresholds() -> None:
    """A weak bearing, a short wrap's friction and a slow span each reach their limits."""
    weak = replace(led().idler_bearing, static_rating_N=10.0)
    drive = replace(led(), bearings=replace(led().bearings, idler=weak))
    checks = families(idlers)[0].checks
    by_id = {c.id: c for c in checks}
    assert run_check(by_id["idler_bearings"], SpurLayout(drive)).status == "fail"
    assert run_check(by_id["idler_turns"], SpurLayout(replace(led(), friction_coefficient=1e-5))).status == "fail"
    heavy = replace(led(), cable=replace(led().cable, mass_g_m=2000.0))
    assert run_check(by_id["span_mode"], SpurLayout(heavy)).status == "warn"
    thin = replace(led(), shaft_material=replace(led().shaft_material, yield_MPa=1.0))
    assert run_check(by_id["idler_axles"], SpurLayout(thin)).status == "fail"
    tight = replace(led(), cables=tuple(replace(c, preload_N=3000.0) for c in led().cables))
    assert run_check(by_id["idler_strap"], SpurLayout(tight)).status == "fail"
    for check in checks:
        assert run_check(check, SpurLayout(led())).status == "pass", check.id
        assert not check.asked_of(straight())


def test_the_mode_of_a_span_is_that_of_a_string() -> None:
    drive = led()
    result = run_check(idlers.span_mode, SpurLayout(drive))
    slackest = min(float(t.min()) for _, t in layout_of(drive).loads.states)
    span = float(drive.strand.length.max()) * 1e-3 * drive.stretched
    assert result.actual == pytest.approx(sqrt(slackest / (drive.cable.mass_g_m * 1e-3)) / (2 * span))


MADE = ("idler_1_side_1", "idler_1_side_2", "idler_axle_1_side_1", "idler_spacer_1_side_2", "idler_strap_1", "frame")


@pytest.mark.parametrize("name", MADE)
def test_a_part_is_one_solid_of_the_volume_it_says(name: str) -> None:
    part = layout_of(led()).bill().made[name]
    solid = part.solid()
    validate_solid(name, solid)
    assert part.volume_mm3() == pytest.approx(solid.Volume(), rel=0.01)
    sheet = part.sheet(name)
    assert sheet.title and len(sheet.dimensions) >= 2
    assert {d.view for d in sheet.dimensions} | {x.view for x in sheet.labels} <= {view.name for view in sheet.views}


@pytest.mark.parametrize(
    ("angle_deg", "count"), [(-60.0, 1), (0.0, 1), (60.0, 1), pytest.param(60.0, 2, marks=pytest.mark.slow)]
)
def test_nothing_near_the_idlers_meets(angle_deg: float, count: int) -> None:
    """Common volume of idlers, axles, spacers, strap and frame, and of the cable with all but what it lies on."""
    bill = layout_of(in_parallel(count)).bill(angle_deg)
    solids = {
        item.name: bill.parts[item.part].part.solid().moved(cq.Location(location(item.location)))
        for item in bill.items
        if item.name.startswith("idler") or item.name in ("frame", "drum")
    }
    for one, two in combinations(solids, 2):
        common = solids[one].intersect(solids[two]).Volume()
        assert common < 0.05, f"{one} and {two} share {common:.3f} mm^3"


@pytest.mark.parametrize("count", [1, 2])
def test_the_order_of_assembly_adds_each_part_once(count: int) -> None:
    layout = layout_of(in_parallel(count))
    joined = [name for step in layout.assembly_order for name in step.items]
    assert sorted(joined) == sorted(item.name for item in layout.bill().items)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("idlers: {pairs: 1, places: [{x_mm: 12.0, z_mm: 90.0}, {x_mm: 11.0, z_mm: 75.0}]}\n", "remove pairs"),
        ("idlers: {places: [{x_mm: 12.0, z_mm: 90.0, y_mm: 3.0}]}\n", "y_mm"),
        ("idlers: {bearing: 62x, places: [{x_mm: 12.0, z_mm: 90.0}]}\n", "catalogue of bearings"),
    ],
)
def test_what_is_refused(text: str, words: str) -> None:
    with pytest.raises(MbcdmError, match=words):
        load_text(TEXT + text, "led.yaml")


def test_an_idler_that_the_cable_misses_is_named() -> None:
    text = TEXT + "idlers: {places: [{x_mm: 10.6, z_mm: 130.0}, {x_mm: 10.6, z_mm: 73.5}]}\n"
    found = results(load_text(text, "led.yaml"))
    assert any("cable off idler 1" in one.message for one in found), found[0].message


def test_two_pairs_are_sized_and_pass() -> None:
    text = TEXT + "idlers: {places: [{x_mm: 12.0, z_mm: 140.0}, {x_mm: 30.0, z_mm: 70.0}]}\n"
    drive = spur(load_text(text, "led.yaml").drive)
    assert len(drive.strand.wraps) == 2 and (drive.strand.wraps > 0.0).all(), drive.strand.wraps
    headings = drive.strand.heading
    assert all(a > b for a, b in pairwise(headings)), headings
    assert len(layout_of(drive).bill().made) > 0


def test_drum_bearing_carries_a_forearm() -> None:
    """The passes end with a bearing that carries the drum on the distance of that pass."""
    text = LED.replace("60.0}\ntr", "90.0}\ntr").replace(
        "8.0, drum_radius_mm: 60.0, centre_distance_mm: 200.0", "10.0, centre_distance_mm: 250.0"
    )
    layout = layout_of(load_text(text.replace("peak_torque_Nm: 2.0", "peak_torque_Nm: 5.0"), "forearm.yaml").drive)
    found = result(layout, "drum_bearings")
    assert found.status == "pass", (layout.drive.bearings.drum.name, found.message)
