"""Mass properties compared with closed forms, and sums over an assembly with one solid of the same material."""

from __future__ import annotations

import math
from dataclasses import replace

import cadquery as cq
import numpy as np
import pytest
from export_samples import ALUMINIUM, STEEL
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.parts.bill import Item, Placement
from mbcdm_cad.workshop.kernel import bounding_box, measure
from mbcdm_cad.workshop.mass import MassProperties, ShapeProperties, assembly_mass, combined, item_mass
from mbcdm_cad.workshop.meshing import mesh_solid

PI = math.pi
finite = st.floats(-100.0, 100.0)
placements = st.builds(
    lambda axis, angle, shift: Placement.translation(*shift) @ Placement.about(axis, angle),
    st.tuples(finite, finite, finite).filter(lambda v: math.hypot(*v) > 0.1),
    st.floats(-360.0, 360.0),
    st.tuples(finite, finite, finite),
)


def _ball(r: float) -> cq.Solid:
    return cq.Solid.makeSphere(r, cq.Vector(), cq.Vector(0, 0, 1), -90, 90, 360)


# (solid, volume, area, inertia about z through the centroid / volume, inertia about x / volume)
CLOSED_FORMS = {
    "box": (cq.Solid.makeBox(2, 3, 5), 30.0, 62.0, (4 + 9) / 12, (9 + 25) / 12),
    "cylinder": (cq.Solid.makeCylinder(3, 8), 72 * PI, 66 * PI, 9 / 2, (27 + 64) / 12),
    "ball": (_ball(4), 256 * PI / 3, 64 * PI, 2 * 16 / 5, 2 * 16 / 5),
    "torus": (cq.Solid.makeTorus(20, 3), 2 * PI**2 * 20 * 9, 4 * PI**2 * 60, 400 + 3 * 9 / 4, 400 / 2 + 5 * 9 / 8),
    "cone": (cq.Solid.makeCone(6, 0, 8), 96 * PI, 96 * PI, 3 * 36 / 10, 3 * 36 / 20 + 3 * 64 / 80),
}


@pytest.mark.parametrize("name", CLOSED_FORMS)
def test_closed_forms(name: str) -> None:
    solid, volume, area, about_z, about_x = CLOSED_FORMS[name]
    found = measure(solid)
    assert found.volume_mm3 == pytest.approx(volume, rel=1e-9)
    assert found.area_mm2 == pytest.approx(area, rel=1e-9)
    assert found.inertia_mm5[2][2] / volume == pytest.approx(about_z, rel=1e-9)
    assert found.inertia_mm5[0][0] / volume == pytest.approx(about_x, rel=1e-9)


def test_centroid_of_a_cone() -> None:
    assert measure(cq.Solid.makeCone(6, 0, 8)).centroid_mm == pytest.approx((0.0, 0.0, 2.0), abs=1e-12)


def test_swept_rod_by_pappus() -> None:
    """A rod along a helix: volume = area x length of the centre line (its radius is smaller than its curvature's)."""
    pitch, turns, radius, rod = 0.87, 2.0, 6.4, 0.405
    wire = cq.Workplane(cq.Wire.makeHelix(pitch, pitch * turns, radius))
    plane = cq.Plane((radius, 0, 0), (1, 0, 0), (0, 2 * PI * radius, pitch))
    solid = cq.Workplane(plane).circle(rod).sweep(wire, isFrenet=True).val()
    expected = PI * rod**2 * turns * math.hypot(2 * PI * radius, pitch)
    assert measure(solid).volume_mm3 == pytest.approx(expected, rel=1e-5)


def test_box_of_a_torus_is_tight() -> None:
    ring = cq.Workplane("XZ").center(20, 0).circle(0.4).revolve(90, (-20, 0, 0), (-20, 1, 0)).val()
    found = measure(ring)
    assert found.low_mm == pytest.approx((0.0, 0.0, -0.4), abs=1e-6)
    assert found.high_mm == pytest.approx((20.4, 20.4, 0.4), abs=1e-6)


def test_box_of_a_turned_torus_is_tight() -> None:
    """A torus tilted by a: half its height is R |sin a| + r."""
    tilt = Placement.about((1.0, 0.0, 0.0), 33.0)
    low, high = bounding_box(cq.Solid.makeTorus(20, 0.4), tilt)
    expected = 20 * math.sin(math.radians(33)) + 0.4
    assert (low[2], high[2]) == pytest.approx((-expected, expected), abs=1e-6)


def test_box_of_the_mesh_is_within_the_deviation(solids: dict[str, cq.Solid]) -> None:
    turn = Placement.translation(5.0, -3.0, 2.0) @ Placement.about((1.0, 2.0, 3.0), 33.0)
    for part, solid in solids.items():
        mesh = mesh_solid(part, solid, 0.02)
        low, high = mesh.box_mm(turn)
        tight_low, tight_high = bounding_box(solid, turn)
        worst = max(float(np.max(low - tight_low)), float(np.max(np.array(tight_high) - high)))
        assert -1e-6 <= worst <= 0.02, f"{part}: box of the mesh differs by {worst:.4f} mm, limit 0.02"


def test_properties_survive_storing(solids: dict[str, cq.Solid]) -> None:
    for solid in solids.values():
        found = measure(solid)
        assert ShapeProperties.from_json(found.to_json()) == found


def item(name: str, place: Placement, mass_g: float | None = None) -> Item:
    return Item(name, name, STEEL, "made", place, "fixed", mass_g)


def test_mass_from_density_and_from_the_catalogue() -> None:
    shape = measure(cq.Solid.makeBox(10, 10, 10))
    made = item_mass(item("cube", Placement.identity()), shape)
    bought = item_mass(item("cube", Placement.identity(), mass_g=5.0), shape)
    assert made.mass_g == pytest.approx(7.85)
    assert bought.mass_g == 5.0
    assert np.array(bought.inertia_g_mm2) == pytest.approx(np.array(made.inertia_g_mm2) * 5.0 / 7.85, abs=1e-9)
    # A cube of side a: m a^2 / 6 about any axis through its centre; 7.85 g, 10 mm: 1.3083e-7 kg m^2.
    assert np.diag(made.inertia_kg_m2) == pytest.approx([7.85e-3 * 1e-4 / 6] * 3, rel=1e-12)
    # About an edge: 2/3 m a^2.
    assert made.about_axis((0.0, 0.0, 2.0)) == pytest.approx(7.85 * 100 * 2 / 3, rel=1e-12)


@settings(max_examples=30, deadline=None)
@given(placements, placements)
def test_two_halves_are_the_whole(outer: Placement, inner: Placement) -> None:
    """A bar of 4 x 6 x 20 put together from two pieces, anywhere and any way round, weighs and turns as one bar."""
    piece = measure(cq.Solid.makeBox(4, 6, 10))
    shapes = {"lower": piece, "upper": piece}
    place = outer @ inner
    parts = [item("lower", place), item("upper", place @ Placement.translation(0.0, 0.0, 10.0))]
    found = assembly_mass(parts, shapes)
    whole = item_mass(item("bar", place), measure(cq.Solid.makeBox(4, 6, 20)))
    assert found.mass_g == pytest.approx(whole.mass_g, rel=1e-12)
    assert found.cog_mm == pytest.approx(whole.cog_mm, abs=1e-9)
    assert np.array(found.inertia_g_mm2) == pytest.approx(np.array(whole.inertia_g_mm2), abs=1e-6)


@settings(max_examples=30, deadline=None)
@given(placements)
def test_moving_numbers_is_moving_the_solid(place: Placement) -> None:
    """Placed properties of a lopsided body agree with the kernel's for the moved solid."""
    from mbcdm_cad.workshop.kernel import location

    solid = cq.Workplane().box(3, 4, 5).union(cq.Workplane().box(2, 2, 9, centered=False)).val().Solids()[0]
    moved = measure(solid.wrapped.Moved(location(place)))
    expected = item_mass(item("body", Placement.identity()), moved)
    found = item_mass(item("body", place), measure(solid))
    assert found.cog_mm == pytest.approx(expected.cog_mm, abs=1e-8)
    assert np.array(found.inertia_g_mm2) == pytest.approx(np.array(expected.inertia_g_mm2), abs=1e-6)


@given(placements)
def test_axis_that_moves_along_keeps_its_inertia(place: Placement) -> None:
    body = MassProperties(3.0, (1.0, 2.0, 3.0), ((5.0, 0.5, 0.1), (0.5, 6.0, 0.2), (0.1, 0.2, 7.0)))
    point, axis = np.array((4.0, -1.0, 2.0)), np.array((0.3, -0.5, 0.7))
    here = body.about_axis(tuple(axis), tuple(point))
    there = body.placed(place).about_axis(tuple(place.rotation @ axis), tuple(place.apply(point)))
    assert there == pytest.approx(here, rel=1e-9)


def test_nothing_has_no_centre_of_gravity() -> None:
    with pytest.raises(ValueError, match="0 bodies"):
        combined([])


def test_density_counts(solids: dict[str, cq.Solid]) -> None:
    shape = measure(solids["plate"])
    light = replace(item("plate", Placement.identity()), material=ALUMINIUM)
    ratio = item_mass(light, shape).mass_g / item_mass(item("plate", Placement.identity()), shape).mass_g
    assert ratio == pytest.approx(2.81 / 7.85, rel=1e-12)


@given(placements, placements)
def test_placements_compose(first: Placement, second: Placement) -> None:
    point = np.array([[1.0, -2.0, 3.0]])
    assert (first @ second).apply(point) == pytest.approx(first.apply(second.apply(point)), abs=1e-9)
    assert first.inverse.apply(first.apply(point)) == pytest.approx(point, abs=1e-9)


def test_quarter_turns_are_exact() -> None:
    turn = Placement.about((0.0, 0.0, 5.0), -270.0, (1.0, 0.0, 0.0))
    assert turn.rows == ((0.0, -1.0, 0.0, 1.0), (1.0, 0.0, 0.0, -1.0), (0.0, 0.0, 1.0, 0.0))


@pytest.mark.parametrize(
    "rows",
    [
        ((-1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)),
        ((2.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)),
        ((1.0, 0.1, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)),
        ((1.0, 0.0, 0.0, math.nan), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)),
    ],
)
def test_what_is_no_rigid_motion_is_refused(rows: tuple) -> None:
    with pytest.raises(ValueError, match="placement"):
        Placement(rows)
