"""Pictures: drawn without a display, filled by the model, with each part at its place."""

import io
import math
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import cadquery as cq
import numpy as np
import pytest
from export_samples import ALUMINIUM, STEEL, material
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib import image

from mbcdm_cad.errors import OutputError
from mbcdm_cad.parts.bill import Item, Placement
from mbcdm_cad.workshop.export import picture
from mbcdm_cad.workshop.export.picture import VIEWS, picture_png, tube_mesh
from mbcdm_cad.workshop.kernel import bounding_box, measure
from mbcdm_cad.workshop.mass import MassProperties, ShapeProperties, assembly_mass, combined, item_mass
from mbcdm_cad.workshop.meshing import mesh_solid
from mbcdm_cad.workshop.trianglemesh import TriangleMesh

RED, BLUE = material("red", 1.0, (1.0, 0.0, 0.0)), material("blue", 1.0, (0.0, 0.0, 1.0))
SIZE = (320, 240)


@pytest.fixture(scope="module")
def meshes() -> dict[str, TriangleMesh]:
    cube = cq.Solid.makeBox(10, 10, 10, cq.Vector(-5, -5, -5))
    return {name: mesh_solid(name, cube, 0.1) for name in ("red", "blue")}


@pytest.fixture
def pair() -> list[Item]:
    """A red cube at x = -20, a blue one at x = +20 and 8 mm higher."""
    return [
        Item("a", "red", RED, "made", Placement.translation(-20.0, 0.0, 0.0), "fixed"),
        Item("b", "blue", BLUE, "made", Placement.translation(20.0, 0.0, 8.0), "fixed"),
    ]


def draw(items: list[Item], meshes: dict[str, TriangleMesh], view: str, **options: object) -> np.ndarray:
    """Pixels (rows from the top, columns, RGB in 0..1)."""
    try:
        png = picture_png(items, meshes, view, SIZE, **options)
    except OutputError as error:
        pytest.skip(str(error))
    pixels = image.imread(io.BytesIO(png), format="png")
    assert pixels.shape == (SIZE[1], SIZE[0], 3)
    return pixels


def centre(pixels: np.ndarray, channel: int) -> tuple[float, float]:
    """Mean column and row of the pixels in which ``channel`` stands out."""
    others = [k for k in range(3) if k != channel]
    rows, columns = np.nonzero(pixels[..., channel] > pixels[..., others].max(axis=2) + 0.25)
    assert len(rows) > 50, f"only {len(rows)} pixels of the colour"
    return float(columns.mean()), float(rows.mean())


@pytest.mark.parametrize(("view", "sign"), [("front", 1), ("rear", -1), ("top", 1), ("bottom", -1)])
def test_what_is_left_and_right(pair: list[Item], meshes: dict[str, TriangleMesh], view: str, sign: int) -> None:
    pixels = draw(pair, meshes, view)
    apart = centre(pixels, 2)[0] - centre(pixels, 0)[0]
    # Width 50 mm (of which 40 apart) fills the picture but for the margin.
    expected = sign * SIZE[0] * 40 / 50 / 1.06
    assert apart == pytest.approx(expected, abs=3.0), f"{view}: blue {apart:.1f} pixels right of red"


def test_what_is_high_and_low(pair: list[Item], meshes: dict[str, TriangleMesh]) -> None:
    pixels = draw(pair, meshes, "front")
    rise = centre(pixels, 0)[1] - centre(pixels, 2)[1]
    assert rise == pytest.approx(SIZE[0] * 8 / 50 / 1.06, abs=3.0), f"blue {rise:.1f} pixels above red"


def test_nearer_hides_farther(pair: list[Item], meshes: dict[str, TriangleMesh]) -> None:
    level = [pair[0], Item("b", "blue", BLUE, "made", Placement.translation(20.0, 0.0, 0.0), "fixed")]
    from_right, from_left = draw(level, meshes, "right"), draw(level, meshes, "left")
    middle = (SIZE[1] // 2, SIZE[0] // 2)
    assert np.argmax(from_right[middle]) == 2
    assert np.argmax(from_left[middle]) == 0


@pytest.mark.parametrize("view", VIEWS)
def test_model_fills_the_picture_and_stays_inside(pair: list[Item], meshes: dict[str, TriangleMesh], view: str) -> None:
    drawn = np.nonzero((draw(pair, meshes, view) < 0.98).any(axis=2))
    spans = [np.ptp(drawn[axis]) + 1 for axis in (0, 1)]
    share = max(spans[0] / SIZE[1], spans[1] / SIZE[0])
    assert 0.9 < share < 0.99, f"{view}: the model takes {share:.0%} of the picture"


def test_edges_are_drawn(pair: list[Item], meshes: dict[str, TriangleMesh]) -> None:
    dark = (draw(pair, meshes, "iso") < 0.3).all(axis=2).sum()
    assert dark > 100, f"{dark} dark pixels: no edges"


def test_note_and_colours(pair: list[Item], meshes: dict[str, TriangleMesh]) -> None:
    plain = draw(pair, meshes, "front")
    noted = draw(pair, meshes, "front", note="FORCED: mass")
    changed = np.nonzero((plain != noted).any(axis=2))[0]
    assert changed.min() > 0.9 * SIZE[1], "the note is not at the foot of the picture"
    green = draw(pair, meshes, "front", colour_of=lambda item: (0.0, 1.0, 0.0))
    assert centre(green, 1)[0] == pytest.approx(SIZE[0] / 2, abs=3.0)


def test_senseless_wishes_are_refused(pair: list[Item], meshes: dict[str, TriangleMesh]) -> None:
    with pytest.raises(ValueError, match=r"unknown view 'askew'; there are .*iso,"):
        picture_png(pair, meshes, "askew")
    with pytest.raises(ValueError, match="picture of 0 x 9 pixels"):
        picture_png(pair, meshes, "iso", (0, 9))


def test_machine_without_any_way_to_draw(
    pair: list[Item], meshes: dict[str, TriangleMesh], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(picture, "_OSMESA", ("libNoSuchThing.so.0",))
    monkeypatch.setenv("VTK_DEFAULT_OPENGL_WINDOW", "vtkOSOpenGLRenderWindow")
    with pytest.raises(OutputError, match="no display, and neither EGL nor OSMesa"):
        picture_png(pair, meshes)


@pytest.mark.slow
def test_same_picture_in_another_process_without_display(pair: list[Item], meshes: dict[str, TriangleMesh]) -> None:
    here = draw(pair, meshes, "iso")
    code = """
import sys
sys.path[:0] = sys.argv[1:]
import test_picture as t
import cadquery as cq
from mbcdm_cad.workshop.meshing import mesh_solid
cube = cq.Solid.makeBox(10, 10, 10, cq.Vector(-5, -5, -5))
meshes = {name: mesh_solid(name, cube, 0.1) for name in ("red", "blue")}
items = [
    t.Item("b", "blue", t.BLUE, "made", t.Placement.translation(20.0, 0.0, 8.0), "fixed"),
    t.Item("a", "red", t.RED, "made", t.Placement.translation(-20.0, 0.0, 0.0), "fixed"),
]
sys.stdout.buffer.write(t.picture_png(items, meshes, "iso", t.SIZE))
"""
    paths = [str(Path(__file__).parents[4]), str(Path(__file__).parent)]
    done = subprocess.run([sys.executable, "-c", code, *paths], capture_output=True, check=True, env={"DISPLAY": ""})
    there = image.imread(io.BytesIO(done.stdout), format="png")
    worst = float(np.abs(here - there).max())
    assert worst <= 2 / 255, f"pictures differ by {worst:.3f}"


def test_a_cut_takes_away_what_stands_before_it_and_shows_the_face(
    pair: list[Item], meshes: dict[str, TriangleMesh]
) -> None:
    """The cut through the red cube's middle, seen along x: a flat square 10 mm high, the blue one gone."""
    pixels = draw(pair, meshes, "iso", cut=picture.CutPlane((-20.0, 0.0, 0.0), (1.0, 0.0, 0.0), 10.0))
    middle = pixels[SIZE[1] // 2, SIZE[0] // 2]
    assert middle[0] > 0.3 and max(middle[1:]) < 0.1, f"the cut face is red, not {middle}"
    inner = pixels[SIZE[1] // 2 - 40 : SIZE[1] // 2 + 40, SIZE[0] // 2 - 40 : SIZE[0] // 2 + 40]
    assert np.ptp(inner, axis=(0, 1)).max() < 0.02, "the face is flat"
    assert not ((pixels[..., 2] > 0.5) & (pixels[..., 0] < 0.3)).any(), "blue stands before the cut"
    rows = np.flatnonzero((pixels[..., 1] < 0.2).any(axis=1))
    assert (rows[-1] - rows[0]) / SIZE[1] == pytest.approx(0.5, abs=0.03)


# Cables of the moving picture: round tubes about their centre lines.


@pytest.mark.parametrize("radius", [0.2, 0.4])
def test_a_tube_keeps_its_radius_about_a_helix(radius: float) -> None:
    angle = np.linspace(0.0, 12.0, 400)
    line = np.column_stack([6.0 * np.cos(angle), 6.0 * np.sin(angle), 0.14 * angle])
    mesh = tube_mesh(line, radius)
    rings = mesh.points_mm.reshape(len(line), -1, 3)
    far = np.linalg.norm(rings - line[:, None, :], axis=2)
    assert np.abs(far - radius).max() < 1e-9, np.abs(far - radius).max()
    steps = np.gradient(line, axis=0)
    slant = np.abs(np.einsum("kij,kj->ki", mesh.normals.reshape(rings.shape), steps)).max()
    assert slant < 1e-6, slant


def test_a_line_with_a_double_point_gives_no_broken_ring() -> None:
    line = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 1.0, 0.0]])
    mesh = tube_mesh(line, 0.3)
    assert np.isfinite(mesh.points_mm).all() and np.isfinite(mesh.normals).all()


# Mass properties compared with closed forms, and sums over an assembly with one solid of the same material.


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
