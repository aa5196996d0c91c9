"""One valid solid or a message: each fault that the kernel can produce is made and must be found."""

from __future__ import annotations

import cadquery as cq
import numpy as np
import pytest

from mbcdm_cad.errors import GeometryError
from mbcdm_cad.workshop.kernel import validate_faces, validate_solid
from mbcdm_cad.workshop.pairs import Faces, PartShape


def test_sound_solids_pass(solids: dict[str, cq.Solid]) -> None:
    for part, solid in solids.items():
        validate_solid(part, solid)


def _solid_of(*faces: cq.Face) -> cq.Solid:
    return cq.Solid.makeSolid(cq.Shell.makeShell(faces))


def _inside_out() -> cq.Shape:
    return cq.Shape.cast(cq.Solid.makeBox(1, 1, 1).wrapped.Reversed())


def _crossing() -> cq.Solid:
    """Closed and valid to the kernel, but the hole pierces the wall of the block."""
    outer = cq.Solid.makeBox(10, 10, 10).Shells()[0]
    hole = cq.Shape.cast(cq.Solid.makeBox(4, 4, 4, cq.Vector(8, 3, 3)).Shells()[0].wrapped.Reversed())
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeSolid

    return cq.Solid(BRepBuilderAPI_MakeSolid(outer.wrapped, hole.wrapped).Solid())


FAULTS = {
    "compound": (lambda: cq.Compound.makeCompound([cq.Solid.makeBox(1, 1, 1)]), "a Compound of 1 solids, must be one"),
    "two solids": (
        lambda: cq.Workplane().box(9, 1, 1).cut(cq.Workplane().box(3, 3, 3)).val(),
        "a Compound of 2 solids, must be one Solid",
    ),
    "empty cut": (lambda: cq.Workplane().box(1, 1, 1).cut(cq.Workplane().box(2, 2, 2)).val(), "0 solids"),
    "face": (lambda: cq.Face.makePlane(1, 1), "a Face of 0 solids"),
    "open": (lambda: _solid_of(*cq.Solid.makeBox(1, 1, 1).Faces()[1:]), "open"),
    "inside out": (_inside_out, "inside out"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_faults_are_found(fault: str) -> None:
    make, message = FAULTS[fault]
    with pytest.raises(GeometryError, match=f"drum: .*({message})"):
        validate_solid("drum", make())


def test_null_shape() -> None:
    with pytest.raises(GeometryError, match="no shape at all"):
        validate_solid("drum", None)


def test_faces_that_cut_each_other_are_found_apart() -> None:
    validate_solid("drum", _crossing())
    with pytest.raises(GeometryError, match=r"drum: .*SelfIntersect"):
        validate_faces("drum", _crossing())


def test_edges_find_them_in_parts_of_many_swept_faces(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three grooves of many turns: all their faces against each other would take minutes."""
    monkeypatch.setattr("mbcdm_cad.workshop.kernel._MOST_SWEPT", -1)
    validate_faces("block", cq.Workplane().box(4, 4, 4).cut(cq.Workplane().box(1, 1, 9)).val())
    with pytest.raises(GeometryError, match=r"drum: .*SelfIntersect"):
        validate_faces("drum", _crossing())


def test_the_interference_run_looks_for_them() -> None:
    shape = _crossing()
    with pytest.raises(GeometryError, match=r"drum: .*SelfIntersect"):
        Faces("drum", PartShape("key", np.zeros((2, 3)), lambda: shape)).test()
