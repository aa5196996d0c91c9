"""Pictures of an assembly without a display: parallel projection, shaded, with the edges of the solids drawn.

A moving picture is a GIF of an assembly whose drum swings through its travel.
"""

import ctypes
import io
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import cos, pi, radians
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import VTK_ID_TYPE, vtkDataArray, vtkLogger, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPlane, vtkPolyData
from vtkmodules.vtkCommonMath import vtkMatrix4x4
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkCamera,
    vtkLightKit,
    vtkPolyDataMapper,
    vtkProperty,
    vtkRenderer,
    vtkRenderWindow,
    vtkTextActor,
    vtkWindowToImageFilter,
)

from mbcdm_cad.errors import OutputError
from mbcdm_cad.parts.bill import Item, Placement, Vector, sorted_items
from mbcdm_cad.routes.curves import CablePath
from mbcdm_cad.workshop.interference import MovingGroup
from mbcdm_cad.workshop.trianglemesh import FloatArray, IntArray, TriangleMesh

# Direction from the model to the camera; z points up in the picture (y in those from above and below).
VIEWS: dict[str, Vector] = {
    "output": (0.6, 1.2, 0.65),
    "iso": (1.0, -1.2, 0.8),
    "iso_rear": (-1.0, 1.2, 0.8),
    "front": (0.0, -1.0, 0.0),
    "rear": (0.0, 1.0, 0.0),
    "left": (-1.0, 0.0, 0.0),
    "right": (1.0, 0.0, 0.0),
    "top": (0.0, 0.0, 1.0),
    "bottom": (0.0, 0.0, -1.0),
}
# Cut faces are shown by the inner sides of the surfaces behind the cut, without lighting and darker than the outside.
_CUT_SHADE = 0.55
_LARGEST_PIXELS = 8192
_MARGIN = 1.06
_SAMPLES = 8
_EDGE_COLOUR = (0.08, 0.09, 0.1)
_BACKGROUND = (1.0, 1.0, 1.0)
_OSMESA = ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so")


@dataclass(frozen=True)
class CutPlane:
    """A section: everything on the side of ``normal`` is removed; the view is perpendicular to the plane.

    ``half_height_mm`` of the plane above and below ``centre`` fill the picture.
    """

    centre: Vector
    normal: Vector
    half_height_mm: float


def picture_png(
    items: Sequence[Item],
    meshes: Mapping[str, TriangleMesh],
    view: str = "iso",
    size: tuple[int, int] = (1600, 1200),
    note: str = "",
    colour_of: Callable[[Item], Vector] = lambda item: item.material.colour,
    cut: CutPlane | None = None,
) -> bytes:
    """A PNG of the assembly, ``size`` (width, height) in pixels, from one of ``VIEWS``; ``note`` is written below.

    ``meshes`` maps each part to its mesh in the part's own frame; ``colour_of`` gives an item's linear RGB, its
    material's if left out. ``cut`` takes the place of the view. Raises ``ValueError`` for an unknown view or a
    invalid size, ``OutputError`` if the machine cannot draw without a display.
    """
    if view not in VIEWS:
        raise ValueError(f"unknown view {view!r}; there are {', '.join(VIEWS)}")
    if not all(1 <= pixels <= _LARGEST_PIXELS for pixels in size):
        raise ValueError(f"picture of {size[0]} x {size[1]} pixels: each must be 1 to {_LARGEST_PIXELS}")
    items = sorted_items(items, meshes)
    renderer = vtkRenderer()
    bodies = {part: (_surface(meshes[part]), _lines(meshes[part])) for part in {item.part for item in items}}
    for item in items:
        surface, lines = bodies[item.part]
        pieces = (_body(surface, item.location, colour_of(item)), _edges(lines, item.location))
        for actor in pieces if cut is None else _cut(pieces, cut, colour_of(item)):
            renderer.AddActor(actor)
    _light(renderer)
    points = np.concatenate([item.location.apply(meshes[item.part].points_mm) for item in items])
    camera = _camera(points, VIEWS[view] if cut is None else cut.normal, size)
    if cut is not None:
        aside = np.array(camera.GetPosition()) - np.array(camera.GetFocalPoint())
        camera.SetFocalPoint(*cut.centre)
        camera.SetPosition(*(np.array(cut.centre) + aside))
        camera.SetParallelScale(cut.half_height_mm)
    renderer.SetActiveCamera(camera)
    renderer.ResetCameraClippingRange()
    if note:
        renderer.AddViewProp(_text(note, size))
    return _drawn(renderer, size)


def _cut(actors: tuple[vtkActor, vtkActor], cut: CutPlane, colour: Vector) -> tuple[vtkActor, vtkActor]:
    """Surface and edges behind the plane; the surface's inner side represents the cut face."""
    plane = vtkPlane()
    plane.SetOrigin(*cut.centre)
    plane.SetNormal(*(-value for value in cut.normal))
    for actor in actors:
        actor.GetMapper().AddClippingPlane(plane)
    face = vtkProperty()
    face.SetColor(*(_CUT_SHADE * _display(channel) for channel in colour))
    face.SetAmbient(1.0)
    face.SetDiffuse(0.0)
    face.SetSpecular(0.0)
    actors[0].SetBackfaceProperty(face)
    return actors


def _camera(points: FloatArray, towards: Vector, size: tuple[int, int]) -> vtkCamera:
    """A camera with a field of view that the points just fill."""
    back = np.array(towards) / np.linalg.norm(towards)
    up_hint = np.array((0.0, 1.0, 0.0) if abs(back[2]) > 0.99 else (0.0, 0.0, 1.0))
    right = np.cross(up_hint, back)
    right /= np.linalg.norm(right)
    axes = np.array((right, np.cross(back, right), back))
    seen = points @ axes.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    width, height, depth = high - low
    middle = (low + high) / 2.0 @ axes
    camera = vtkCamera()
    camera.ParallelProjectionOn()
    camera.SetFocalPoint(*middle)
    camera.SetPosition(*(middle + back * (depth + 1.0)))
    camera.SetViewUp(*axes[1])
    camera.SetParallelScale(_MARGIN * max(height, width * size[1] / size[0]) / 2.0)
    return camera


def _surface(mesh: TriangleMesh) -> vtkPolyData:
    data = _polydata(mesh.points_mm)
    data.SetPolys(_cells(mesh.triangles))
    data.GetPointData().SetNormals(_array(mesh.normals))
    return data


def _lines(mesh: TriangleMesh) -> vtkPolyData:
    data = _polydata(mesh.points_mm)
    data.SetLines(_cells(mesh.edges))
    return data


def _polydata(points_mm: FloatArray) -> vtkPolyData:
    points = vtkPoints()
    points.SetData(_array(points_mm))
    data = vtkPolyData()
    data.SetPoints(points)
    return data


def _cells(corners: IntArray) -> vtkCellArray:
    count, each = corners.shape
    cells = vtkCellArray()
    cells.SetData(_array(np.arange(count + 1, dtype=np.int64) * each), _array(corners.ravel().astype(np.int64)))
    return cells


def _array(values: NDArray[Any]) -> vtkDataArray:
    kind = VTK_ID_TYPE if values.dtype.kind == "i" else None
    plain = np.ascontiguousarray(values)
    array: vtkDataArray = numpy_to_vtk(plain, deep=True, array_type=kind)  # type: ignore[no-untyped-call]
    return array


def _actor(data: vtkPolyData, placement: Placement) -> vtkActor:
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(data)
    mapper.SetResolveCoincidentTopologyToPolygonOffset()  # so that edges lie on the surface, not half in it
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.SetUserMatrix(_matrix(placement))
    return actor


def _body(data: vtkPolyData, placement: Placement, colour: Vector) -> vtkActor:
    actor = _actor(data, placement)
    surface = actor.GetProperty()
    surface.SetColor(*(_display(channel) for channel in colour))
    surface.SetInterpolationToPhong()
    surface.SetAmbient(0.1)
    surface.SetDiffuse(0.9)
    surface.SetSpecular(0.2)
    surface.SetSpecularPower(25.0)
    return actor


def _edges(data: vtkPolyData, placement: Placement) -> vtkActor:
    actor = _actor(data, placement)
    line = actor.GetProperty()
    line.SetColor(*_EDGE_COLOUR)
    line.SetLineWidth(1.3)
    line.LightingOff()
    return actor


def _display(linear: float) -> float:
    """A linear colour channel converted to sRGB."""
    return 12.92 * linear if linear <= 0.0031308 else 1.055 * math.pow(linear, 1.0 / 2.4) - 0.055


def _light(renderer: vtkRenderer) -> None:
    """A bright light above the camera, and a weaker one at the camera for the faces that it sees directly."""
    renderer.AutomaticLightCreationOff()
    renderer.SetBackground(*_BACKGROUND)
    lights = vtkLightKit()
    lights.SetKeyLightIntensity(0.85)
    lights.SetKeyToFillRatio(2.5)
    lights.SetKeyToHeadRatio(1.8)
    lights.SetKeyToBackRatio(3.0)
    lights.AddLightsToRenderer(renderer)


def _text(note: str, size: tuple[int, int]) -> vtkTextActor:
    text = vtkTextActor()
    text.SetInput(note)
    text.SetPosition(0.02 * size[0], 0.02 * size[1])
    text.GetTextProperty().SetFontSize(max(10, size[1] // 40))
    text.GetTextProperty().SetColor(0.7, 0.05, 0.05)
    return text


def _drawn(renderer: vtkRenderer, size: tuple[int, int]) -> bytes:
    window = _window(renderer, size)
    window.Render()
    image = vtkWindowToImageFilter()
    image.SetInput(window)
    image.ReadFrontBufferOff()
    image.ShouldRerenderOff()  # otherwise VTK draws the whole scene again before it reads the image
    image.Update()
    writer = vtkPNGWriter()
    writer.SetInputConnection(image.GetOutputPort())
    writer.WriteToMemoryOn()
    writer.Write()
    return bytes(memoryview(writer.GetResult()))


def _window(renderer: vtkRenderer, size: tuple[int, int]) -> vtkRenderWindow:
    """A window that needs no display. Raises ``OutputError`` if the machine has no library for one."""
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)  # it warns of every way to draw that it tries in vain
    window = vtkRenderWindow()
    if window.GetClassName() == "vtkOSOpenGLRenderWindow" and not any(map(_loadable, _OSMESA)):
        raise OutputError(
            "cannot draw a picture: there is no display, and neither EGL nor OSMesa to do without one; install one "
            "of them (Debian: apt-get install libegl1, or libosmesa6)"
        )
    window.OffScreenRenderingOn()
    window.SetMultiSamples(_SAMPLES)
    window.SetSize(*size)
    window.AddRenderer(renderer)
    return window


def _loadable(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


_SIDES = 8
_CHORD_MM = 0.6
_COLOURS = 48
_FRAME_MS = 60


def tube_mesh(centre_line_mm: NDArray[np.float64], radius_mm: float) -> TriangleMesh:
    """A round tube along a centre line (n, 3), open at its ends; for pictures only."""
    points = centre_line_mm[np.r_[True, np.linalg.norm(np.diff(centre_line_mm, axis=0), axis=1) > 1e-6]]
    tangents = np.gradient(points, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    across = np.empty_like(points)
    last = np.eye(3)[np.argmin(np.abs(tangents[0]))]
    for k, tangent in enumerate(tangents):
        last = last - (last @ tangent) * tangent
        last /= np.linalg.norm(last)
        across[k] = last
    third = np.cross(tangents, across)
    angles = np.arange(_SIDES) * (2 * pi / _SIDES)
    normals = np.cos(angles)[:, None] * across[:, None, :] + np.sin(angles)[:, None] * third[:, None, :]
    ring = np.arange(len(points) - 1)[:, None] * _SIDES + np.arange(_SIDES)
    after = np.arange(len(points) - 1)[:, None] * _SIDES + (np.arange(_SIDES) + 1) % _SIDES
    quads = np.stack([ring, after, after + _SIDES, ring, after + _SIDES, ring + _SIDES], axis=-1)
    return TriangleMesh(
        (points[:, None, :] + radius_mm * normals).reshape(-1, 3),
        normals.reshape(-1, 3),
        quads.reshape(-1, 3).astype(np.int32),
        np.empty((0, 2), np.int32),
        0.0,
    )


def travel_gif(
    items: Sequence[Item],
    meshes: Mapping[str, TriangleMesh],
    moving: Sequence[MovingGroup],
    cables: tuple[Callable[[float], Sequence[CablePath]], float, Vector],
    half_travel_deg: float,
    *,
    view: str = "output",
    size: tuple[int, int] = (640, 520),
    frames: int = 32,
) -> bytes:
    """A GIF of the drum's swing from the centre to both ends and back, as an endless loop of ``frames`` pictures.

    ``items`` without cables at the centred drum, ``meshes`` of their parts in mm. ``cables``: the paths at an angle in
    rad, the cables' diameter in mm and their colour (linear RGB).
    """
    renderer = vtkRenderer()
    actors: dict[str, list[vtkActor]] = {}
    places = {item.name: item.location for item in items}
    for item in items:
        mesh = meshes[item.part]
        surface = _body(_surface(mesh), item.location, item.material.colour)
        actors[item.name] = [surface, _edges(_lines(mesh), item.location)]
        for actor in actors[item.name]:
            renderer.AddActor(actor)
    _light(renderer)
    renderer.SetActiveCamera(_still_camera(items, meshes, moving, half_travel_deg, view, size))
    window = _window(renderer, size)
    paths_at, diameter_mm, colour = cables
    pictures: list[Image.Image] = []
    ropes: list[vtkActor] = []
    for k in range(frames):
        angle = half_travel_deg * cos(2 * pi * k / frames)
        for body in moving:
            motion = body.at(angle)
            for name in body.items:
                for actor in actors[name]:
                    actor.SetUserMatrix(_matrix(motion @ places[name]))
        for rope in ropes:
            renderer.RemoveActor(rope)
        paths = paths_at(radians(angle))
        lines = [tube_mesh(path.sample(_CHORD_MM), (path.diameter_mm or diameter_mm) / 2) for path in paths]
        ropes = [_body(_surface(line), Placement.identity(), colour) for line in lines]
        for rope in ropes:
            renderer.AddActor(rope)
        renderer.ResetCameraClippingRange()
        pictures.append(_frame(window))
    return _gif(pictures)


def _still_camera(
    items: Sequence[Item],
    meshes: Mapping[str, TriangleMesh],
    moving: Sequence[MovingGroup],
    half_travel_deg: float,
    view: str,
    size: tuple[int, int],
) -> vtkCamera:
    """One camera that sees the whole travel."""
    body_of = {name: body for body in moving for name in body.items}
    points = [
        (body_of[item.name].at(angle) @ item.location).apply(meshes[item.part].points_mm)
        for angle in (-half_travel_deg, 0.0, half_travel_deg)
        for item in items
    ]
    return _camera(np.concatenate(points), VIEWS[view], size)


def _matrix(placement: Placement) -> vtkMatrix4x4:
    matrix = vtkMatrix4x4()
    for row, values in enumerate(placement.rows):
        for column, value in enumerate(values):
            matrix.SetElement(row, column, value)
    return matrix


def _frame(window: vtkRenderWindow) -> Image.Image:
    window.Render()
    reader = vtkWindowToImageFilter()
    reader.SetInput(window)
    reader.ReadFrontBufferOff()
    reader.Update()
    seen = reader.GetOutput()
    width, height, _ = seen.GetDimensions()
    pixels = vtk_to_numpy(seen.GetPointData().GetScalars()).reshape(height, width, -1)  # type: ignore[no-untyped-call]
    return Image.fromarray(np.ascontiguousarray(pixels[::-1, :, :3]))


def _gif(pictures: Sequence[Image.Image]) -> bytes:
    """The GIF, all frames with the palette of the first, so that fixed areas are stored once."""
    first = pictures[0].quantize(_COLOURS, dither=Image.Dither.NONE)
    frames = [p.quantize(palette=first, dither=Image.Dither.NONE) for p in pictures]
    buffer = io.BytesIO()
    frames[0].save(
        buffer, "GIF", save_all=True, append_images=frames[1:], duration=_FRAME_MS, loop=0, optimize=False, disposal=1
    )
    return buffer.getvalue()
