"""Pictures for the assembly: the section is where cables reach the drum, the exploded view separates the parts."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import cadquery as cq
import numpy as np
import pytest

from mbcdm_cad.design.bought import Material
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.parts.bill import Item, Placement, Vector
from mbcdm_cad.workshop import pictures
from mbcdm_cad.workshop.meshing import mesh_solid
from mbcdm_cad.workshop.pictures import EXPLODED, exploded, transfer_section

DRIVE = load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive
METAL = Material(
    name="metal",
    density_g_cm3=1.0,
    youngs_modulus_GPa=70.0,
    poisson_ratio=0.3,
    yield_MPa=100.0,
    process="milled",
    min_wall_mm=0.5,
    min_internal_radius_mm=0.5,
    colour=(0.5, 0.5, 0.5),
    source="test",
)


def test_the_section_shows_the_plane_through_the_drum_s_axis_and_the_transfer_points() -> None:
    """Of miso_bevel: the plane x = 0, the points at (0, r_g, r_o)."""
    found = transfer_section(layout_of(DRIVE))
    assert found is not None
    centre, normal, half = found
    guide = [c.guide_radius_mm for c in DRIVE.cables]  # type: ignore[attr-defined]
    drum = [c.drum_radius_mm for c in DRIVE.cables]
    assert np.abs(normal) == pytest.approx([1.0, 0.0, 0.0], abs=1e-9)
    assert centre == pytest.approx([0.0, (min(guide) + max(guide)) / 2, (min(drum) + max(drum)) / 2], abs=1e-6)
    assert half > (max(drum) - min(drum)) / 2


def test_the_exploded_view_keeps_directions_and_multiplies_distances() -> None:
    cube = mesh_solid("cube", cq.Solid.makeBox(2, 2, 2, cq.Vector(-1, -1, -1)), 0.1)
    places = np.array([[-4.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 1.0, 3.0]])
    items = [
        Item(f"cube_{n}", "cube", METAL, "made", Placement.translation(*place), "fixed")
        for n, place in enumerate(places.tolist())
    ]
    moved = np.array([item.location.apply(np.zeros((1, 3)))[0] for item in exploded(items, {"cube": cube})])
    middle = (places.min(axis=0) + places.max(axis=0)) / 2
    assert moved - middle == pytest.approx((1.0 + EXPLODED) * (places - middle))


def test_each_cable_has_a_colour_of_its_own() -> None:
    items = layout_of(DRIVE).bill().items
    colours = [item.material.colour for item in items if item.name.startswith("cable_")]
    assert len(set(colours)) == len(colours) == 4


def test_cables_keep_their_colours_in_every_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """What stood before is grey, what joins is blue, each cable stays as its own."""
    items = [
        Item(name, "cube", METAL, "made", Placement.identity(), "fixed") for name in ("cable_1", "cable_2", "a", "b")
    ]
    seen: dict[str, Vector] = {}

    def fake(shown: list[Item], *_: object, colour_of: Callable[[Item], Vector], cut: object) -> bytes:
        seen.update({item.name: colour_of(item) for item in shown})
        return b"png"

    monkeypatch.setattr("mbcdm_cad.workshop.export.picture.picture_png", fake)
    made = {"cube": SimpleNamespace(files=SimpleNamespace(mesh=None))}
    assert pictures._png(made, items, {"new": frozenset({"cable_2", "b"})}) == b"png"  # type: ignore[arg-type]
    assert seen == {"cable_1": METAL.colour, "cable_2": METAL.colour, "a": pictures.BEFORE, "b": pictures.NEW}
