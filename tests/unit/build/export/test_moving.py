"""Cables of the moving picture: round tubes about their centre lines."""

from __future__ import annotations

import numpy as np
import pytest

from mbcdm_cad.build.export.moving import tube_mesh


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
