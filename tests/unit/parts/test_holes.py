"""Tables of holes compared with the cylinders of the solids: every listed hole exists, every small hole is listed."""

from __future__ import annotations

from math import pi
from typing import Any

import cadquery as cq
import numpy as np
import pytest
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.GeomAbs import GeomAbs_Cylinder

from mbcdm_cad.parts.bill import Bill

PARTS = ("collar", "drum", "frame", "top_plate")
# Round holes of these that a table of another kind gives: bores that are dimensioned in a view.
BORES = {"collar": 1, "drum": 1, "frame": 4, "top_plate": 0}


def _bores(solid: cq.Solid) -> dict[tuple[float, ...], float]:
    """Radius, direction and nearest point to the origin of the axis of every hollow cylinder; how far round it goes."""
    walls: dict[tuple[float, ...], float] = {}
    for face in solid.Faces():
        surface = BRepAdaptor_Surface(face.wrapped)
        if surface.GetType() != GeomAbs_Cylinder:
            continue
        cylinder = surface.Cylinder()
        place, way = cylinder.Axis().Location(), cylinder.Axis().Direction()
        at, along = np.array([place.X(), place.Y(), place.Z()]), np.array([way.X(), way.Y(), way.Z()])
        normal = np.array(face.normalAt(cq.Vector(*face.Vertices()[0].toTuple())).toTuple())
        vertex = np.array(face.Vertices()[0].toTuple())
        outward = vertex - at - along * ((vertex - at) @ along)
        if normal @ outward > 0.0:
            continue  # a shaft, not a hole
        along = along * (1.0 if along[np.argmax(np.abs(along))] > 0 else -1.0)
        foot = at - along * (at @ along)
        key = tuple(float(v) for v in np.round([cylinder.Radius(), *along, *foot], 5) + 0.0)
        walls[key] = walls.get(key, 0.0) + abs(surface.LastUParameter() - surface.FirstUParameter())
    return walls


def _told(groups: list[dict[str, Any]]) -> list[tuple[str, float, np.ndarray]]:
    found = []
    for group in groups:
        for place in group["places_mm"]:
            found.append((group["hole"], group["diameter_mm"] / 2, np.array(place)))
            if group["counterbore"]:
                found.append((group["hole"] + " counterbore", group["counterbore"]["diameter_mm"] / 2, np.array(place)))
    return found


def _passes(bore: tuple[float, ...], radius: float, place: np.ndarray) -> bool:
    along, foot = np.array(bore[1:4]), np.array(bore[4:])
    along /= np.linalg.norm(along)  # rounded, as a key
    off = place - foot
    return abs(bore[0] - radius) < 1e-4 and float(np.linalg.norm(off - along * (off @ along))) < 1e-4


@pytest.mark.parametrize("part", PARTS)
def test_holes_told_are_the_solid_s(part: str, centred: Bill, solids: dict[str, cq.Solid]) -> None:
    bores, told = _bores(solids[part]), _told(centred.holes()[part])
    for name, radius, place in told:
        assert any(_passes(bore, radius, place) for bore in bores), f"{part} {name}: no hole of {2 * radius:g} there"
    # Other holes may cut into one; corners of pockets go a quarter round.
    whole = [bore for bore, turned in bores.items() if turned > 1.9 * pi]
    untold = [bore for bore in whole if not any(_passes(bore, radius, place) for _, radius, place in told)]
    assert len(untold) <= BORES[part], f"{part}: holes that no table gives: {untold}"


def test_each_tapped_hole_has_its_drill(centred: Bill) -> None:
    for part, groups in centred.holes().items():
        for group in groups:
            if group["thread"]:
                assert 0.6 < group["tap_drill_mm"] / group["diameter_mm"] < 0.9, (part, group)


@pytest.mark.parametrize("part", ["collar", "drum", "frame"])
def test_drilled_for_tapping_the_holes_have_the_drill_s_diameter(part: str, centred: Bill) -> None:
    spec = centred.parts[part]
    assert spec.drilled is not None
    bores = _bores(spec.drilled.solid())
    for group in centred.holes()[part]:
        if group["thread"]:
            for place in group["places_mm"]:
                drill, major = group["tap_drill_mm"] / 2, group["diameter_mm"] / 2
                assert any(_passes(bore, drill, np.array(place)) for bore in bores), (part, group["hole"])
                assert not any(_passes(bore, major, np.array(place)) for bore in bores), (part, group["hole"])


def test_every_part_with_a_tapped_hole_can_be_drilled(centred: Bill) -> None:
    tapped = {part for part, groups in centred.holes().items() if any(group["thread"] for group in groups)}
    assert tapped == {name for name, spec in centred.parts.items() if spec.drilled is not None}
