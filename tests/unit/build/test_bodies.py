"""Bodies: together they contain every item, and move them as the bill does."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.build.scene import MovingGroup, bodies, is_cable
from mbcdm_cad.layouts.loader import load_design

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
