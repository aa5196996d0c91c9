"""Routes of the bevel drive, checked independently: taut strings, vector sums, finite differences, rigid rotation.

Each kind of piece: exact length compared with chords, end tangents with differences, and values by hand.
"""

from dataclasses import replace
from itertools import pairwise
from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.layouts.miso_bevel.cable_path import BevelGeometry, routed
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.curves import _GAUSS, Arc, Coil, Helix, Line, Parabola, Piece, cut
from mbcdm_cad.routes.route import (
    Anchor,
    CableRoute,
    DriveRoutes,
    RoutedDrive,
    Span,
    Terminal,
    Wrap,
    body_load,
    offset_m,
    path_change_m,
    path_slope,
)
from tests.support.sliced_cables import contact_point_m

REFERENCE = routed(load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive)


@st.composite
def drives(draw: st.DrawFn) -> RoutedDrive:
    """Two to six cables on one to three inputs, any radii whose pulleys leave a free span."""
    n_inputs = draw(st.integers(1, 3))
    input_of = tuple(sorted([*range(n_inputs), *draw(st.lists(st.integers(0, n_inputs - 1), min_size=1, max_size=3))]))
    n = len(input_of)
    sides = st.sampled_from([-1, 1])
    radii = draw(st.lists(st.floats(3e-3, 20e-3), min_size=n, max_size=n))
    geometry = BevelGeometry(
        tuple(f"c{j}" for j in range(n)),
        tuple(f"i{i}" for i in range(n_inputs)),
        input_of,
        tuple(draw(sides) for _ in range(n_inputs)),
        tuple(draw(sides) for _ in range(n)),
    )
    r = np.array(radii)
    reach = 2.5 * float(r.max())
    lengths = {
        "input_radius_m": r,
        "guide_radius_m": 1.5 * r,
        "drum_radius_m": r * draw(st.floats(4.0, 12.0)),
        "centre_distance_m": np.asarray(reach * draw(st.floats(1.02, 3.0))),
    }
    return RoutedDrive(geometry, lengths, {})


def ends_of_spans(routes: DriveRoutes, route: CableRoute) -> list[tuple[Floats, Floats]]:
    """Where each span leaves one body and touches the next."""
    found = []
    for (one, two), span in zip(pairwise(route.wraps), route.spans, strict=True):
        begin = contact_point_m(routes.body(one.body), one, span.direction)
        found.append((begin, contact_point_m(routes.body(two.body), two, span.direction)))
    return found


@given(drives())
def test_spans_join_the_tangent_points_of_their_bodies(drive: RoutedDrive) -> None:
    routes = drive.routes
    for route in routes.cables:
        for span, (begin, end) in zip(route.spans, ends_of_spans(routes, route), strict=True):
            along = begin + span.length_m * np.array(span.direction)
            assert np.abs(along - end).max() < 1e-12, f"{route.cable}: {along} against {end} m"


@given(drives())
def test_wraps_on_passed_bodies_turn_the_arriving_span_into_the_leaving_one(drive: RoutedDrive) -> None:
    for route in drive.routes.cables:
        for contact in list(route.contacts())[1:-1]:
            axis = np.array(drive.routes.body(contact.wrap.body).axis)
            arriving, leaving = np.array(contact.arriving), np.array(contact.leaving)
            turned = np.arctan2(np.cross(arriving, leaving) @ axis, arriving @ leaving) * contact.wrap.turning
            assert turned % (2 * np.pi) == pytest.approx(contact.wrap.angle_rad, abs=1e-9), route.cable


@given(drives())
def test_a_tension_turns_the_drum_in_the_sense_of_its_route(drive: RoutedDrive) -> None:
    """Moment of the pull about the drum's axis, by vectors, is sigma r_o T; about the input's it is r_i T."""
    routes = drive.routes
    for route in routes.cables:
        spans = ends_of_spans(routes, route)
        drum = np.cross(spans[-1][1], -np.array(route.spans[-1].direction)) @ np.array(routes.drum.axis)
        assert drum == pytest.approx(route.sense * route.drum_radius_m, rel=1e-9), route.cable
        body = routes.body(route.wraps[0].body)
        arm = spans[0][0] - np.array(body.point_m)
        driven = np.cross(arm, np.array(route.spans[0].direction)) @ np.array(body.axis)
        assert driven == pytest.approx(-route.sense * route.input_radius_m, rel=1e-9), route.cable


@given(drives(), st.floats(20.0, 200.0))
def test_body_loads_add_up_to_nothing(drive: RoutedDrive, tension: float) -> None:
    """Cables pull bodies together and nothing else, so the forces on all bodies cancel."""
    routes = drive.routes
    pull = tension * np.linspace(0.5, 1.5, len(routes.cables))
    total = sum(body_load(routes, body.name, pull).force_N for body in routes.bodies)
    assert np.abs(total).max() < 1e-9 * tension, total


@given(drives())
def test_moment_of_a_body_load_is_that_of_forces_at_the_tangent_points(drive: RoutedDrive) -> None:
    """But for the component along the axis, which is the torque that the body transmits."""
    routes = drive.routes
    pull = np.linspace(40.0, 90.0, len(routes.cables))
    for body in routes.bodies:
        axis, load = np.array(body.axis), body_load(routes, body.name, pull)
        about = np.array(body.point_m) + load.height_m * axis
        expected = np.zeros(3)
        for tension, route in zip(pull, routes.cables, strict=True):
            for (one, two), span, (begin, end) in zip(
                pairwise(route.wraps), route.spans, ends_of_spans(routes, route), strict=True
            ):
                u = np.array(span.direction)
                if one.body == body.name:
                    expected += np.cross(begin - about, tension * u)
                if two.body == body.name:
                    expected += np.cross(end - about, -tension * u)
        expected -= (expected @ axis) * axis
        assert load.moment_Nm == pytest.approx(expected, abs=1e-9), body.name


def taut_string_m(routes: DriveRoutes, route: CableRoute, moved: dict[str, Floats]) -> float:
    """Path from the input to the guide's top, the shortest over all tangent directions, with bodies displaced.

    The wraps at both ends are counted from fixed directions, so that only their change is meant.
    """
    first, guide = route.wraps[0], route.wraps[1]
    begin = np.array(routes.body(first.body).point_m)[:2] + moved.get(first.body, np.zeros(3))[:2]
    end = np.array(routes.body(guide.body).point_m)[:2] + moved.get(guide.body, np.zeros(3))[:2]
    t0 = np.array(route.spans[0].direction)[:2]
    beta = np.linspace(-0.05, 0.05, 400001)
    angle = np.arctan2(t0[1], t0[0]) + beta
    t = np.stack([np.cos(angle), np.sin(angle)])
    left = np.stack([-t[1], t[0]])
    gap = (end - begin)[:, None] - (guide.turning * guide.radius_m - first.turning * first.radius_m) * left
    best = int(np.argmin(np.abs((gap * left).sum(axis=0))))
    on_wraps = (first.turning * first.radius_m - guide.turning * guide.radius_m) * beta[best]
    along = np.array(route.spans[1].direction)[:2]
    drum = moved.get("drum", np.zeros(3))[:2] - moved.get(guide.body, np.zeros(3))[:2]
    return float((gap * t).sum(axis=0)[best] + on_wraps + along @ drum)


@pytest.mark.parametrize("cable", range(4))
@pytest.mark.parametrize("body", ["guide", "input", "drum"])
def test_large_displacement_is_the_length_of_a_taut_string(cable: int, body: str) -> None:
    routes = REFERENCE.routes
    route = routes.cables[cable]
    name = route.wraps[0].body if body == "input" else body
    e = np.array([4e-4, -7e-4, 0.0])
    expected = taut_string_m(routes, route, {name: e}) - taut_string_m(routes, route, {})
    found = float(path_change_m(routes, route, {name: e[:, None]})[0])
    assert found == pytest.approx(expected, abs=2e-8), f"{name}: {found} against {expected} m"


@settings(max_examples=40)
@given(drives(), st.floats(0.0, 2 * np.pi))
def test_path_slope_is_the_finite_difference_of_the_path(drive: RoutedDrive, angle: float) -> None:
    routes, step = drive.routes, 1e-7
    for route in routes.cables:
        for body in routes.bodies:
            e = offset_m(body, 1.0, np.array([angle]))
            ends = [float(path_change_m(routes, route, {body.name: sign * step * e})[0]) for sign in (1.0, -1.0)]
            slope = float(path_slope(route, body.name) @ e[:, 0])
            assert slope == pytest.approx((ends[0] - ends[1]) / (2 * step), abs=1e-6), f"{route.cable}, {body.name}"


def test_moving_all_bodies_together_changes_no_path() -> None:
    routes = REFERENCE.routes
    e = np.array([[2e-4], [-3e-4], [5e-4]])
    for route in routes.cables:
        moved = path_change_m(routes, route, {body.name: e for body in routes.bodies})
        assert abs(float(moved[0])) < 1e-18, f"{route.cable}: {moved}"


def test_reference_figures() -> None:
    routes = REFERENCE.routes
    assert [round(r.free_length_m * 1e3, 2) for r in routes.cables] == [31.18, 30.68, 30.14, 29.55]
    assert [round(float(np.degrees(r.passed[0].angle_rad)), 1) for r in routes.cables] == [25.7, 207.5, 29.4, 211.3]
    assert [b.name for b in routes.bodies] == ["drum", "guide", "input_left", "input_right"]
    assert [round(b.turns_per_drum, 12) for b in routes.bodies] == [1.0, -6.0, 9.0, 9.0]
    assert [r.sense for r in routes.cables] == [-1, 1, 1, -1]


def test_length_of_a_cable_with_its_wraps_set_is_that_of_sampled_points() -> None:
    """Helix on the input, tangent span, arcs on guide and drum, sampled finely."""
    route = REFERENCE.routes.cables[1]
    assert np.isinf(route.length_m), "anchored wraps are longer than any slip zone until they are set"
    turns, on_drum = 11.0, 1.1
    angles = {1: turns, len(route.pieces) - 2: on_drum}
    pieces = [replace(piece, angle_rad=angles[k]) if k in angles else piece for k, piece in enumerate(route.pieces)]  # type: ignore[arg-type]
    whole = replace(route, pieces=tuple(pieces))
    s = np.linspace(0.0, 1.0, 200001)
    helix = np.stack(
        [
            route.input_radius_m * np.cos(turns * s),
            route.input_radius_m * np.sin(turns * s),
            route.wraps[0].lead_m * turns * s / (2 * np.pi),
        ]
    )
    sampled = float(np.linalg.norm(np.diff(helix), axis=0).sum())
    sampled += float(np.hypot(34.6e-3, 0.0) ** 2 - (16.0e-3) ** 2) ** 0.5
    for wrap in whole.wraps[1:]:
        arc = wrap.radius_m * np.stack([np.cos(wrap.angle_rad * s), np.sin(wrap.angle_rad * s)])
        sampled += float(np.linalg.norm(np.diff(arc), axis=0).sum())
    assert whole.length_m == pytest.approx(sampled, rel=1e-9), f"{whole.length_m} against {sampled} m"


def test_batch_of_lengths_is_the_designs_one_by_one() -> None:
    geometry, lengths = REFERENCE.geometry, REFERENCE.parameters
    distance = np.array([34.6e-3, 40e-3, 10e-3])
    many = {k: v[:, None] if v.ndim else distance for k, v in lengths.items()}
    span, wrap = geometry.free_span_m(many), geometry.passed_wrap_rad(many)[0]
    for k, one in enumerate(distance):
        alone = geometry.routes({**lengths, "centre_distance_m": np.asarray(one)})
        for j, route in enumerate(alone.cables):
            assert span[j, k] == pytest.approx(route.free_length_m, nan_ok=True)
            assert wrap[j, k] == pytest.approx(route.passed[0].angle_rad, nan_ok=True)
    assert np.isnan(span[:, 2]).all() and "raise centre_distance_mm" in geometry.fault(many)


def test_a_chain_out_of_order_is_refused() -> None:
    span, wrap = Span(0.1, (1.0, 0.0, 0.0)), Wrap("drum", 0.05, 1.0, 0.0, 1)
    with pytest.raises(ValueError, match="its pieces are Anchor, Span, Wrap, Terminal"):
        CableRoute("c", "i", 1, (Anchor("i"), span, wrap, Terminal("drum")))


X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
PIECES: dict[str, Piece] = {
    "line": Line((1.0, 2.0, 3.0), (4.0, -2.0, 15.0)),
    "arc": Arc((1.0, -2.0, 0.5), X, Z, 7.0, 0.3, 2.9),
    "arc backwards": Arc((1.0, -2.0, 0.5), X, Z, 7.0, 2.9, 0.3),
    "helix": Helix((3.0, -1.0), 6.0, 0.4, 11.7, 2.0, -1.0),
    "helix backwards": Helix((3.0, -1.0), 6.0, 11.7, 0.4, 2.0, -1.0),
    "coil": Coil((1.0, 0.0, 5.0), Y, Z, 4.0, 0.2, 9.0, -1.0, 6.0),
    "parabola": Parabola((0.0, 0.0, 0.0), (1.0, 0.0, 0.1), (2.0, 0.3, 0.1)),
}


def chords(piece: Piece, count: int) -> float:
    points = piece.points(np.linspace(0.0, 1.0, count + 1))
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


@pytest.mark.parametrize("piece", PIECES.values(), ids=PIECES.keys())
def test_length_is_that_of_fine_chords(piece: Piece) -> None:
    """Chords fall short by a term in 1/n^2, so two counts give the limit (Richardson)."""
    coarse, fine = chords(piece, 2000), chords(piece, 4000)
    limit = fine + (fine - coarse) / 3
    assert abs(piece.length_mm / limit - 1) < 1e-11, f"{piece.length_mm} against {limit} by chords"


@pytest.mark.parametrize("piece", PIECES.values(), ids=PIECES.keys())
@pytest.mark.parametrize("fraction", [0.0, 0.37, 1.0])
def test_tangent_is_the_direction_of_travel(piece: Piece, fraction: float) -> None:
    h = 1e-6
    low, high = piece.points(np.array([fraction - h, fraction + h]))
    step = (high - low) / np.linalg.norm(high - low)
    tangent = piece.tangent(fraction)
    assert np.linalg.norm(tangent) == pytest.approx(1.0, abs=1e-14)
    assert np.abs(tangent - step).max() < 1e-8, f"{tangent} against {step}"


def test_lengths_known_by_hand() -> None:
    assert Line((0, 0, 0), (3, 4, 12)).length_mm == 13.0
    assert Arc((5, 5, 5), X, Y, 2.0, pi, 0.0).length_mm == pytest.approx(2 * pi, rel=1e-15)
    assert Helix((0, 0), 3.0, 0.0, 2 * pi, 0.0, 8 * pi).length_mm == pytest.approx(10 * pi, rel=1e-15)
    # y = x^2 from 0 to 1: sqrt(5)/2 + asinh(2)/4.
    exact = sqrt(5) / 2 + np.arcsinh(2) / 4
    assert Parabola((0, 0, 0), (0.5, 0, 0), (1, 1, 0)).length_mm == pytest.approx(exact, rel=1e-9)


@given(st.floats(-10, 10), st.floats(-10, 10), st.floats(0.5, 9), st.floats(-5, 5))
def test_a_helix_stays_on_its_cylinder_and_climbs_evenly(a0: float, a1: float, radius: float, rise: float) -> None:
    helix = Helix((2.0, -3.0), radius, a0, a1, 1.0, 1.0 + rise)
    points = helix.points(np.linspace(0, 1, 50))
    from_axis = np.hypot(points[:, 0] - 2.0, points[:, 1] + 3.0)
    assert np.abs(from_axis - radius).max() < 1e-12
    assert np.abs(np.diff(points[:, 2]) - rise / 49).max() < 1e-13


def test_a_parabola_joins_two_slopes() -> None:
    p = Parabola((0, 0, 0), (1, 0, 0), (1, 2, 0))
    assert p.tangent(0.0) == pytest.approx((1, 0, 0)) and p.tangent(1.0) == pytest.approx((0, 1, 0))


def test_the_table_of_the_quadrature_is_that_of_numpy() -> None:
    nodes, weights = np.polynomial.legendre.leggauss(12)
    found, found_weights = np.array(sorted(_GAUSS)).T
    assert np.abs(2 * found - 1 - nodes).max() < 1e-15
    assert np.abs(found_weights - weights).max() < 1e-15


@pytest.mark.parametrize("piece", PIECES.values(), ids=PIECES.keys())
@given(length_mm=st.floats(0.3, 40.0))
def test_the_parts_of_a_piece_are_the_piece(piece: Piece, length_mm: float) -> None:
    parts = cut(piece, length_mm)
    assert sum(part.length_mm for part in parts) == pytest.approx(piece.length_mm, rel=1e-12)
    ends = np.array([part.points(np.array([0.0, 0.5, 1.0])) for part in parts])
    whole = piece.points(np.linspace(0.0, 1.0, 2 * len(parts) + 1))
    off = np.abs(
        np.concatenate([ends[:, 0], ends[:, 1], ends[:, 2]]) - np.concatenate([whole[:-1:2], whole[1::2], whole[2::2]])
    )
    assert off.max() < 1e-12, f"{len(parts)} parts, off by {off.max()} mm"
    if not isinstance(piece, Parabola):
        assert max(part.length_mm for part in parts) <= length_mm * (1 + 1e-12)
