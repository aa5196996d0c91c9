"""A moving picture (GIF) of an assembly whose drum swings through its travel; needs no display."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping, Sequence
from math import cos, pi, radians

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkLogger
from vtkmodules.vtkCommonMath import vtkMatrix4x4
from vtkmodules.vtkRenderingCore import vtkActor, vtkCamera, vtkRenderer, vtkRenderWindow, vtkWindowToImageFilter

from mbcdm_cad.parts.bill import Item, Placement, Vector
from mbcdm_cad.routes.cable_path import CablePath
from mbcdm_cad.workshop.export import picture
from mbcdm_cad.workshop.interference import MovingGroup
from mbcdm_cad.workshop.trianglemesh import TriangleMesh

_SIDES = 8
_CHORD_MM = 0.6
_COLOURS = 48
_FRAME_MS = 60
_SAMPLES = 8


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
        surface = picture._body(picture._surface(mesh), item.location, item.material.colour)
        edges = picture._edges(picture._lines(mesh), item.location)
        actors[item.name] = [surface, edges]
        for actor in actors[item.name]:
            renderer.AddActor(actor)
    renderer.AutomaticLightCreationOff()
    picture._lights().AddLightsToRenderer(renderer)
    renderer.SetBackground(*picture._BACKGROUND)
    renderer.SetActiveCamera(_still_camera(items, meshes, moving, half_travel_deg, view, size))
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    window = vtkRenderWindow()
    window.OffScreenRenderingOn()
    window.SetMultiSamples(_SAMPLES)
    window.SetSize(*size)
    window.AddRenderer(renderer)
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
        ropes = [picture._body(picture._surface(line), Placement.identity(), colour) for line in lines]
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
    return picture._camera(np.concatenate(points), picture.VIEWS[view], size)


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
