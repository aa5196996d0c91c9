"""Every part of the reference design: one valid solid, a watertight mesh, the reviewed volume, and its box."""

from __future__ import annotations

from collections.abc import Callable

import cadquery as cq
import numpy as np
import pytest
import trimesh

from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.parts.bill import CABLE, Bill
from mbcdm_cad.workshop.kernel import bounding_box, validate_faces, validate_solid

from .golden import golden_volumes

GOLDEN = golden_volumes()
TOLERANCE = 1e-6


def test_the_table_of_volumes_holds_every_part_and_no_other(centred: Bill) -> None:
    assert set(GOLDEN) == set(centred.parts), "regenerate: python tests/unit/parts/golden.py"


@pytest.mark.parametrize("name", GOLDEN)
def test_volume_is_what_it_was(solids: dict[str, cq.Solid], name: str) -> None:
    """A golden figure: it proves nothing but that geometry has not changed unnoticed."""
    volume = solids[name].Volume()
    error = volume / GOLDEN[name] - 1
    assert abs(error) < TOLERANCE, f"{name}: {volume:.6f} mm^3, was {GOLDEN[name]:.6f} ({error:+.2e})"


@pytest.mark.parametrize("name", GOLDEN)
def test_is_one_sound_solid(solids: dict[str, cq.Solid], name: str) -> None:
    validate_solid(name, solids[name])
    validate_faces(name, solids[name])


@pytest.mark.parametrize("name", GOLDEN)
def test_mesh_is_watertight_and_of_nearly_the_same_volume(solids: dict[str, cq.Solid], name: str) -> None:
    # A cable wound at 0.02 mm has a quarter of a million triangles; its chords may be longer.
    vertices, faces = (
        solids[name].copy(mesh=False).tessellate(*((0.05, 0.3) if name.startswith(CABLE) else (0.02, 0.1)))
    )
    mesh = trimesh.Trimesh([v.toTuple() for v in vertices], faces)
    mesh.merge_vertices(digits_vertex=7)
    assert mesh.is_watertight and mesh.is_winding_consistent, f"{name}: open mesh"
    assert mesh.body_count == 1, f"{name}: {mesh.body_count} bodies"
    error = mesh.volume / solids[name].Volume() - 1
    assert abs(error) < 0.02, f"{name}: mesh volume off by {error:+.2%}"


def boxes(dims: BevelLayout) -> dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]]:
    """Low and high corners by the drawing, part's own frame."""
    v, drive, d, f = dims.levels, dims.drive, dims.drum, dims.frame
    side, gear, nut = v.side_outer_x, drive.gearhead, drive.tensioner
    motor, encoder, ring = drive.motor, drive.encoder, drive.drum_encoder
    left = dims.inputs[0]
    reach = d.lands[-1].surface_radius_mm
    half = np.radians(d.half_angle_deg)
    outermost = max(t.y_mm for t in d.tensioners if t.cut_through)
    lugs_inner = min(t.y_mm for t in d.tensioners) - d.lug_half_width
    corner = nut.nut_across_flats_mm / 3**0.5
    assert outermost < d.lands[-1].y_end
    return {
        "frame": ((-side, v.back_y, -f.boss.radius), (side, v.boss_front_y, v.top_plate_bottom_z)),
        "top_plate": ((-side, v.back_y, v.top_plate_bottom_z), (side, v.front_y, v.top_plate_top_z)),
        "guide": (
            (-dims.guide.surface_radii[-1], -dims.guide.surface_radii[-1], v.guide_bottom_z),
            (dims.guide.surface_radii[-1], dims.guide.surface_radii[-1], v.guide_top_z),
        ),
        "drum": (
            (-reach * np.sin(half), min(d.spigot_y, lugs_inner), -d.hub_radius),
            (reach * np.sin(half), d.hub_face_y, reach),
        ),
        "drum_shaft": (
            (-dims.drum_shaft.flange_radius, v.back_y, -dims.drum_shaft.flange_radius),
            (dims.drum_shaft.flange_radius, v.hub_face_y, dims.drum_shaft.flange_radius),
        ),
        "input_pulley_left": (
            (-left.upper_surface_radius, -left.upper_surface_radius, left.journal_bottom_z),
            (left.upper_surface_radius, left.upper_surface_radius, left.journal_top_z),
        ),
        "motor": (
            (-motor.diameter_mm / 2, -motor.diameter_mm / 2, -motor.length_mm),
            (motor.diameter_mm / 2, motor.diameter_mm / 2, 0.0),
        ),
        "gearhead": (
            (-gear.diameter_mm / 2, -gear.diameter_mm / 2, -gear.length_mm),
            (gear.diameter_mm / 2, gear.diameter_mm / 2, gear.shaft_length_mm),
        ),
        "encoder": (
            (-encoder.diameter_mm / 2, -encoder.diameter_mm / 2, 0.0),
            (encoder.diameter_mm / 2, encoder.diameter_mm / 2, encoder.length_mm),
        ),
        "drum_encoder": ((-ring.diameter_mm / 2, -11.0, 0.0), (ring.diameter_mm / 2, 11.0, ring.length_mm)),
        "nut": ((-corner, -nut.nut_across_flats_mm / 2, 0.0), (corner, nut.nut_across_flats_mm / 2, nut.nut_height_mm)),
    }


Boxes = Callable[[BevelLayout], dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]]]


def test_boxes_are_those_of_the_drawing(dims: BevelLayout, solids: dict[str, cq.Solid]) -> None:
    for name, (low, high) in boxes(dims).items():
        found = bounding_box(solids[name])
        assert np.abs(np.subtract(found, (low, high))).max() < 1e-4, f"{name}: {found}, drawn {low} to {high}"


@pytest.mark.parametrize("name", [n for n in GOLDEN if n.startswith(("screw_", "bearing_"))])
def test_bought_parts_stand_on_their_seat(solids: dict[str, cq.Solid], name: str) -> None:
    """Screws hang below their head's seat at z = 0; bearings stand on it."""
    low, high = bounding_box(solids[name])
    if name.startswith("bearing_"):
        assert low[2] == pytest.approx(0.0, abs=1e-6)
    else:
        assert low[2] < 0.0 <= high[2] + 1e-6
