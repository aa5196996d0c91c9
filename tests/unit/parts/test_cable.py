"""The volume of a cable is pi r^2 times its length (Guldin) at every pose; its ends are at stop and terminal."""

from __future__ import annotations

from math import pi, radians

import cadquery as cq
import numpy as np
import pytest

from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.parts.bill import Placement
from mbcdm_cad.parts.bodies import CableRod
from mbcdm_cad.routes.curves import Arc, Coil, Line
from mbcdm_cad.workshop.kernel import bounding_box
from mbcdm_cad.workshop.meshing import mesh_solid
from mbcdm_cad.workshop.trianglemesh import rod_mesh


@pytest.mark.parametrize("angle_deg", [-35.0, 0.0, 35.0])
def test_volume_is_section_times_length(dims: BevelLayout, angle_deg: float) -> None:
    radius = dims.drive.cable.diameter_mm / 2
    for path in dims.cable_paths(radians(angle_deg)):
        rod = CableRod(path.line, radius).solid()
        assert rod.isValid()
        error = rod.Volume() / (pi * radius**2 * path.length_mm) - 1
        assert abs(error) < 1e-5, f"{path.cable.name} at {angle_deg:+g} deg: {error:+.2e}"


def test_rod_lies_round_its_centre_line(dims: BevelLayout, solids: dict[str, cq.Solid]) -> None:
    radius = dims.drive.cable.diameter_mm / 2
    for path in dims.cable_paths(0.0):
        points = path.sample(0.05)
        low, high = bounding_box(solids[path.cable.name])
        assert np.all(np.array(low) > points.min(axis=0) - radius - 1e-3), path.cable.name
        assert np.all(np.array(high) < points.max(axis=0) + radius + 1e-3), path.cable.name


def test_ends_are_flat_discs_in_stop_and_terminal(dims: BevelLayout, solids: dict[str, cq.Solid]) -> None:
    radius = dims.drive.cable.diameter_mm / 2
    for path in dims.cable_paths(0.0):
        ends = [path.pieces[0][1].points(np.array([0.0]))[0], path.pieces[-1][1].points(np.array([1.0]))[0]]
        discs = [f for f in solids[path.cable.name].Faces() if f.geomType() == "PLANE"]
        assert len(discs) == 2, f"{path.cable.name}: {len(discs)} plane faces"
        for disc in discs:
            assert disc.Area() == pytest.approx(pi * radius**2, rel=1e-6)
            centre = np.array(disc.Center().toTuple())
            assert min(np.linalg.norm(centre - end) for end in ends) < 1e-6


def test_a_bend_tighter_than_the_rope_is_refused() -> None:
    """The kernel would sweep it into a solid that crosses itself, on which a mesh never becomes fine enough."""
    straight = Line((0.0, 0.0, -5.0), (0.0, 0.0, 0.0))
    bend = Arc((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0), 1.0, 0.0, pi / 2)
    assert CableRod((straight, bend), 0.99).solid().Volume() == pytest.approx(pi * 0.99**2 * (5.0 + pi / 2), rel=1e-6)
    with pytest.raises(ValueError, match="a bend of 1 mm is too tight for a rod of 1 mm radius"):
        CableRod((straight, bend), 1.0).solid()


def test_a_long_winding_is_drawn_in_parts_that_can_be_meshed() -> None:
    """One winding of this length, drawn as one face, kept the mesher busy without end (a drum of 104 mm radius)."""
    winding = Coil((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), 103.9, 1.609, 0.182, -3.95, -2.44)
    rod = CableRod((winding,), 0.405).solid()
    walls = [face for face in rod.Faces() if face.geomType() != "PLANE"]
    assert len(walls) == 4, f"{len(walls)} faces along {winding.length_mm:.0f} mm"
    volume = mesh_solid("cable", rod, 0.02).volume_mm3
    assert volume == pytest.approx(pi * 0.405**2 * winding.length_mm, rel=0.03)


@pytest.mark.slow
def test_the_mesh_of_a_rope_is_as_coarse_as_a_rope_is_rough(dims: BevelLayout) -> None:
    """Closed, at the kernel's solid within a twentieth of the radius, and a small share of the kernel's triangles."""
    radius, (path, *_) = dims.drive.cable.diameter_mm / 2, dims.cable_paths(0.0)
    mesh, solid = rod_mesh(path.line, radius, 0.05 * radius), CableRod(path.line, radius).solid()
    assert len(mesh.open_edges_mm()) == 0
    assert mesh.deviation_mm <= 0.05 * radius
    assert 0.95 < mesh.volume_mm3 / solid.Volume() < 1.0, "chords lie inside"
    fine = mesh_solid("cable", solid.wrapped, 0.01)
    low, high = mesh.box_mm(Placement.identity())
    for mine, others in ((low, fine.points_mm.min(axis=0)), (high, fine.points_mm.max(axis=0))):
        assert np.abs(mine - others).max() < 0.05 * radius + 0.01
    assert len(mesh.triangles) < 0.35 * len(fine.triangles), (len(mesh.triangles), len(fine.triangles))
    edges = mesh.points_mm[mesh.triangles]
    outward = np.cross(edges[:, 1] - edges[:, 0], edges[:, 2] - edges[:, 0])
    assert np.all((outward * mesh.normals[mesh.triangles].mean(axis=1)).sum(axis=1) > 0.0), "normals point outward"
