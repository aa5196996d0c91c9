"""Bodies: together they contain every item, and move them as the bill does."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.parts.bill import PartSpec
from mbcdm_cad.workshop.interference import MovingGroup, bodies, is_cable
from mbcdm_cad.workshop.store import Store, StoredPart, exported_parts

DRIVE = load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive
DIMS: Any = DRIVE.layout


@pytest.fixture(scope="module")
def found() -> tuple[MovingGroup, ...]:
    return bodies(DIMS.moving_bodies, DIMS.bill())


def test_every_item_but_the_cables_is_in_one_body(found: tuple[MovingGroup, ...]) -> None:
    items = [name for body in found for name in body.items]
    assert len(items) == len(set(items))
    assert set(items) == {item.name for item in DIMS.bill().items if not is_cable(item)}


def test_one_body_stands_still_and_one_is_the_drum(found: tuple[MovingGroup, ...]) -> None:
    assert [body.kind for body in found if body.ratio == 0.0] == ["fixed"]
    assert [body.ratio for body in found if body.kind == "drum"] == [1.0]


@settings(max_examples=20, deadline=None)
@given(angle=st.floats(-DRIVE.half_travel_deg, DRIVE.half_travel_deg))
def test_bodies_move_their_items_as_the_bill_does(angle: float) -> None:
    found = bodies(DIMS.moving_bodies, DIMS.bill())
    centred = {item.name: item.location for item in DIMS.bill().items}
    moved = {item.name: item.location for item in DIMS.bill(angle).items}
    for body in found:
        for name in body.items:
            error = np.abs(np.array((body.at(angle) @ centred[name]).rows) - np.array(moved[name].rows)).max()
            assert error < 1e-9, (name, angle, error)


# Tapped holes in the files of single parts: at the major diameter, or drawn again at the tap drill on request.


class _Asked:
    """Stands for the store: remembers what it is asked to make."""

    def __init__(self) -> None:
        self.specs: dict[str, PartSpec] = {}

    def parts(self, specs: Mapping[str, PartSpec], *rest: Any) -> dict[str, StoredPart]:
        self.specs = dict(specs)
        return {name: cast(StoredPart, ("drilled", spec.part)) for name, spec in specs.items()}


def test_only_parts_with_tapped_holes_are_drawn_anew_and_only_where_asked() -> None:
    drive = load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive
    whole = drive.layout.bill()
    parts = {name: cast(StoredPart, ("major", spec.part)) for name, spec in whole.parts.items()}
    store = _Asked()
    assert exported_parts(cast(Store, store), whole, parts, drive, 1) == parts and not store.specs
    asked = replace(drive, export=replace(drive.export, threads="tap_drill"))
    files = exported_parts(cast(Store, store), whole, parts, asked, 1)
    changed = {name for name in parts if files[name] != parts[name]}
    assert changed == {"frame", "drum", "collar"} and set(files) == set(parts)
    assert all(store.specs[name].part == whole.parts[name].drilled for name in changed)
