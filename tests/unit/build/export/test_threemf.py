"""3MF files read back by another program: unit, name, watertight, volume, lying on the bed; the same bytes twice."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import cadquery as cq
import numpy as np
import pytest
import trimesh

from mbcdm_cad.build.export.threemf import lying, threemf_bytes
from mbcdm_cad.build.meshing import mesh_solid
from mbcdm_cad.layouts.loader import load_design

ROOT = Path(__file__).parents[4]
_DRIVE = load_design(ROOT / "params" / "mbcdm.yaml").drive
_BILL = _DRIVE.layout.bill()
MADE = tuple(dict.fromkeys(item.part for item in _BILL.items if item.kind == "made"))


@pytest.mark.parametrize("name", MADE)
def test_read_back(name: str) -> None:
    spec = _BILL.parts[name]
    solid = spec.part.solid()
    data = threemf_bytes(name, mesh_solid(name, solid.wrapped, 0.02))
    assert data == threemf_bytes(name, mesh_solid(name, solid.copy(mesh=False).wrapped, 0.02))
    scene = trimesh.load(io.BytesIO(data), file_type="3mf")
    assert isinstance(scene, trimesh.Scene)
    assert scene.units in ("mm", "millimeter", "millimeters")
    (found,) = scene.geometry.values()
    text = zipfile.ZipFile(io.BytesIO(data)).read("3D/3dmodel.model").decode()
    assert f'name="{name}"' in text
    assert 'unit="millimeter"' in text
    assert found.is_watertight
    assert found.volume == pytest.approx(solid.Volume(), rel=1e-2)  # a stop of 2 mm, meshed to 0.02 mm
    low, high = found.bounds
    assert low[2] == pytest.approx(0.0, abs=1e-4)
    assert (low + high)[:2] == pytest.approx((0.0, 0.0), abs=1e-4)


def test_lies_on_its_largest_flat_face() -> None:
    """A T of which the top is larger than the foot is turned over."""
    shape = cq.Workplane().box(4, 4, 10).faces(">Z").workplane().box(20, 20, 2, centered=(True, True, False))
    mesh = mesh_solid("t", shape.val().wrapped, 0.05)
    assert np.array_equal(lying(mesh)[2], (0.0, 0.0, -1.0))


def test_rotation_is_proper() -> None:
    for plane in ("XY", "YZ", "XZ"):
        mesh = mesh_solid("plate", cq.Workplane(plane).box(10, 8, 1).val().wrapped, 0.05)
        turn = lying(mesh)
        assert np.linalg.det(turn) == pytest.approx(1.0)
        assert np.ptp(mesh.points_mm @ turn[2]) == pytest.approx(1.0)
