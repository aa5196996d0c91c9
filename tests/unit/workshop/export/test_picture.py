"""Pictures: drawn without a display, filled by the model, with each part at its place."""

from __future__ import annotations

import io
import subprocess
import sys
from pathlib import Path

import cadquery as cq
import numpy as np
import pytest
from export_samples import material
from matplotlib import image

from mbcdm_cad.errors import OutputError
from mbcdm_cad.parts.bill import Item, Placement
from mbcdm_cad.workshop.export import picture
from mbcdm_cad.workshop.export.picture import VIEWS, picture_png, tube_mesh
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
