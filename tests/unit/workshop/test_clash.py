"""Distance of centre lines compared with brute force, and the definition of another turn of the same cable.

Bodies: together they contain every item, and move them as the bill does.
"""

from __future__ import annotations

import tracemalloc
from collections.abc import Mapping
from dataclasses import replace
from math import radians
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.layouts.miso_bevel.cable_path import cable_path
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.parts.bill import PartSpec
from mbcdm_cad.routes.curves import CablePath, Helix, Line
from mbcdm_cad.workshop.interference import MovingGroup, bodies, is_cable, travel_poses
from mbcdm_cad.workshop.pairs import Clash, cable_overlaps, centre_line_distance
from mbcdm_cad.workshop.store import Store, StoredPart, exported_parts


def brute(first: CablePath, second: CablePath) -> float:
    a, b = first.sample(0.05), second.sample(0.05)
    return min(float(np.linalg.norm(b - p, axis=1).min()) for p in a)


@pytest.mark.parametrize("angle_deg", [-35.0, *(pytest.param(a, marks=pytest.mark.slow) for a in (0.0, 35.0))])
def test_distances_are_those_of_brute_force(dims: BevelLayout, angle_deg: float) -> None:
    """Centre lines of different cables are never nearer than 2.7 mm."""
    paths = dims.cable_paths(radians(angle_deg))
    d = dims.drive.cable.diameter_mm
    least = np.inf
    for k, first in enumerate(paths):
        for second in paths[k + 1 :]:
            distance, place = centre_line_distance(first, second, d)
            assert distance == pytest.approx(brute(first, second), abs=8e-3), f"{first.cable.name}, {second.cable.name}"
            least = min(least, distance)
            for path in (first, second):
                gap = np.linalg.norm(path.sample(0.05) - place, axis=1).min()
                assert gap == pytest.approx(distance / 2, abs=0.03), "the place named is not half way"
    assert least > 2.7, f"{least:.3f} mm"


def test_neighbouring_turns_lie_a_lead_apart(dims: BevelLayout) -> None:
    """Two turns side by side: the lead times the cosine of the helix angle, where the span does not come nearer."""
    drive = dims.drive
    for cable in drive.cables:
        path = cable_path(drive, cable, 1.1, 3.0, radians(-35.0 * cable.drum_side)).only(("helix",))
        distance, _ = centre_line_distance(path, path, drive.cable.diameter_mm)
        around = 2 * np.pi * cable.input_radius_mm
        expected = drive.helix_lead_mm * around / np.hypot(around, drive.helix_lead_mm)
        assert distance == pytest.approx(expected, abs=2e-4), f"{cable.name}: {distance:.5f}, {expected:.5f} mm"


def test_a_long_cable_is_compared_with_itself_in_little_memory(dims: BevelLayout) -> None:
    """Nine turns of 2.5 m altogether, as on the drum of a first stage: a table of all distances took 4 GB."""
    turns, radius, lead = 9.0, 45.0, 1.2
    wound = Helix((0.0, 0.0), radius, 0.0, turns * 2 * np.pi, 0.0, turns * lead)
    path = CablePath(dims.drive.cables[0], 0.0, (("helix", wound),))
    tracemalloc.start()
    distance, _ = centre_line_distance(path, path, 1.0)
    taken_MB = tracemalloc.get_traced_memory()[1] / 1e6
    tracemalloc.stop()
    around = 2 * np.pi * radius
    assert distance == pytest.approx(lead * around / np.hypot(around, lead), abs=2e-4)
    assert taken_MB < 200.0, f"{taken_MB:.0f} MB"


def test_reference_cables_clear_each_other_and_themselves(dims: BevelLayout) -> None:
    for angle in np.linspace(-35, 35, 5):
        assert not list(cable_overlaps(dims.cable_paths(radians(angle)), dims.drive.cable.diameter_mm))


def test_a_lead_under_the_diameter_is_a_cable_that_overlaps_itself(dims: BevelLayout) -> None:
    tight = BevelLayout(replace(dims.drive, helix_lead_mm=0.80))
    found = list(cable_overlaps(tight.cable_paths(0.0), 0.81))
    assert [(i, j) for i, j, _, _ in found] == [(k, k) for k in range(4)]
    for k, _, depth_mm, (x, y, z) in found:
        # Turn beside turn: 0.81 - 0.80 cos(helix); a bit more where the span leaves, on the side of the turn before.
        cable = dims.drive.cables[k]
        assert 0.0101 < depth_mm < 0.0125, f"{cable.name}: {depth_mm}"
        from_axis = np.hypot(x - cable.input_side * dims.drive.centre_distance_mm, y)
        assert from_axis == pytest.approx(cable.input_radius_mm, abs=0.05), f"{cable.name}: not on the pulley"
        assert abs(z - cable.drum_radius_mm) < 2.1


def test_two_cables_made_to_cross_are_named_with_depth_and_place(dims: BevelLayout) -> None:
    """Thicker than their centre lines are apart, they clash; a hair thinner, they do not."""
    first, second = dims.cable_paths(0.0)[:2]
    distance, _ = centre_line_distance(first, second, 0.81)
    assert all(i == j for i, j, _, _ in cable_overlaps([first, second], distance - 1e-3))
    ((i, j, depth_mm, _),) = [o for o in cable_overlaps([first, second], distance + 0.05) if o[0] != o[1]]
    assert (i, j) == (0, 1) and depth_mm == pytest.approx(0.05, abs=1e-4)
    clash = Clash("cable_1", "cable_2", "cables", 0.0, (0.0, 0.0, 0.0), overlap_mm=depth_mm)
    assert "cable_1 and cable_2 overlap: 0.0500 mm deep at (" in str(clash)


def test_a_solid_clash_says_volume_place_and_pose() -> None:
    clash = Clash("nut", "drum", "solids", -17.5, (1.0, 2.0, 3.0), volume_mm3=0.25)
    assert str(clash) == "nut and drum overlap: 0.2500 mm^3 at (1.00, 2.00, 3.00) mm, drum at -17.50 deg"


HEIGHTS = st.lists(st.floats(0.80, 0.83), min_size=3, max_size=8)


@settings(max_examples=60, deadline=None)
@given(HEIGHTS, st.floats(0.0, 0.2), st.floats(2.0, 3.0))
def test_no_overlap_is_missed_between_samples(
    dims: BevelLayout, heights: list[float], shift: float, pitch: float
) -> None:
    """A cable that passes another several times, a hair nearer or further: the least distance is found under d."""
    x = shift + pitch * np.arange(len(heights) + 1)
    corners = [(float(a), 1.1 if k % 2 else -1.1, 0.0) for k, a in enumerate(x)]
    pieces = tuple(
        ("span", Line((a[0], a[1], h), (b[0], b[1], h)))
        for a, b, h in zip(corners[:-1], corners[1:], heights, strict=True)
    )
    cable = dims.drive.cables[0]
    over = CablePath(cable, 0.0, pieces)
    under = CablePath(cable, 0.0, (("span", Line((-1.0, 0.0, 0.0), (float(x[-1]) + 1.0, 0.0, 0.0))),))
    distance, _ = centre_line_distance(under, over, 0.81)
    if min(heights) < 0.81:
        assert distance == pytest.approx(min(heights), abs=1e-4)
    else:
        assert distance > 0.81 - 1e-9


# Poses of the interference run.


def test_nine_poses_hold_both_ends_and_the_centre() -> None:
    poses = travel_poses(35.0, 9)
    assert poses == pytest.approx((-35, -26.25, -17.5, -8.75, 0, 8.75, 17.5, 26.25, 35), abs=1e-12)
    assert poses[0] == -35.0 and poses[-1] == 35.0 and poses[4] == 0.0


DRIVE = load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive
DIMS: Any = layout_of(DRIVE)


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
    whole = layout_of(drive).bill()
    parts = {name: cast(StoredPart, ("major", spec.part)) for name, spec in whole.parts.items()}
    store = _Asked()
    assert exported_parts(cast(Store, store), whole, parts, drive, 1) == parts and not store.specs
    asked = replace(drive, export=replace(drive.export, threads="tap_drill"))
    files = exported_parts(cast(Store, store), whole, parts, asked, 1)
    changed = {name for name in parts if files[name] != parts[name]}
    assert changed == {"frame", "drum", "collar"} and set(files) == set(parts)
    assert all(store.specs[name].part == whole.parts[name].drilled for name in changed)
