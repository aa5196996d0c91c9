"""Interference is found where it is and nowhere else: single bodies moved or thickened, volumes computed by hand."""

import tracemalloc
from collections.abc import Callable, Mapping
from dataclasses import replace
from math import acos, pi, radians, sqrt
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import cadquery as cq
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.layouts.miso_bevel.bill import bill
from mbcdm_cad.layouts.miso_bevel.cable_path import cable_path
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.parallel import forks
from mbcdm_cad.parts.bill import CABLE, Bill, Item, PartSpec, Placement
from mbcdm_cad.parts.bodies import ScrewBody
from mbcdm_cad.parts.turned import IdlerPulley, Nut, Pin
from mbcdm_cad.routes.curves import Arc, CablePath, Helix, Line
from mbcdm_cad.storage.cache import Cache
from mbcdm_cad.workshop import kernel, store
from mbcdm_cad.workshop.interference import InterferenceRun, MovingGroup, answers, bodies, is_cable, travel_poses
from mbcdm_cad.workshop.kernel import common, rod
from mbcdm_cad.workshop.meshing import mesh_solid
from mbcdm_cad.workshop.pairs import (
    CABLE_UNDERSIZE_MM,
    Clash,
    Faces,
    Found,
    Pair,
    PartShape,
    Rod,
    RodShape,
    cable_overlaps,
    centre_line_distance,
)
from mbcdm_cad.workshop.separation import Surface, apart
from mbcdm_cad.workshop.store import KnownTests, Store, StoredPart, exported_parts
from tests.support.interference_of_solids import body, interferences, run_of
from tests.support.reference import DRIVE

Move = Callable[[dict[str, Placement]], None]


def pairs(clashes: tuple[Clash, ...]) -> set[tuple[str, str]]:
    return {(min(c.first, c.second), max(c.first, c.second)) for c in clashes}


def on_drum(solids: dict[str, Any]) -> dict[str, Any]:
    """Drum, terminals, nuts and guide alone: what clashes there clashes without the rest."""
    return {name: solids[name] for name in ("drum", "terminal", "nut", "guide")}


def segment_area(radius: float, depth: float) -> float:
    """Area of a circle beyond a chord ``depth`` inside its rim."""
    return radius**2 * acos(1 - depth / radius) - (radius - depth) * sqrt(2 * radius * depth - depth**2)


@pytest.fixture(scope="module")
def known() -> dict[str, Found]:
    """Answers that the tests of this file share: a pair of the same shapes that lie alike is tested once.

    That a run which takes answers from earlier ones equals a run from nothing is shown in test_one_edit.py.
    """
    return {}


@pytest.fixture
def move(monkeypatch: pytest.MonkeyPatch) -> Move:
    """``move({item: extra placement in the item's own frame})`` for all runs of this test."""

    def install(moves: dict[str, Placement]) -> None:
        def moved(dims: BevelLayout, angle_deg: float = 0.0) -> Bill:
            b = bill(dims, angle_deg)
            unknown = set(moves) - {i.name for i in b.items}
            assert not unknown, f"no such items: {unknown}"
            items = tuple(replace(i, location=i.location @ moves[i.name]) if i.name in moves else i for i in b.items)
            return replace(b, items=items)

        monkeypatch.setattr(BevelLayout, "bill", moved)

    return install


@pytest.mark.slow
def test_reference_design_is_free_of_clashes_at_nine_poses(dims: BevelLayout, solids: dict[str, Any]) -> None:
    found = interferences(dims, solids, travel_poses(dims.drive.half_travel_deg, 9), jobs=2)
    assert not found, "\n".join(map(str, found))


@pytest.mark.slow
def test_a_thicker_guide_meets_the_drum_and_its_cables(
    dims: BevelLayout, solids: dict[str, Any], known: dict[str, Found]
) -> None:
    """Step 1 grown by 0.3 mm, 0.145 mm into the drum's inner face, as high as the first land reaches; and cable 1."""
    grown = 0.3
    radii = dims.guide.surface_radii
    thick = replace(dims.guide, surface_radii=(radii[0] + grown, *radii[1:]))
    drawn = {**solids, "guide": IdlerPulley(thick).solid()}
    found = interferences(dims, drawn, (dims.drive.half_travel_deg,), known=known)
    assert pairs(found) == {("drum", "guide"), ("cable_1", "guide")}
    (clash,) = [c for c in found if "drum" in (c.first, c.second)]
    depth = grown - dims.drive.clearances.transfer_gap_mm
    # The drum's face ends at its first land, a circle about Y: a hair lower beside x = 0.
    height = dims.drum.lands[0].surface_radius_mm - dims.levels.guide_bottom_z
    expected = segment_area(radii[0] + grown, depth) * height
    assert clash.volume_mm3 == pytest.approx(expected, rel=0.02), f"{clash}; by hand {expected:.4f}"
    x, y, z = clash.place_mm
    assert abs(x) < 0.01 and dims.levels.drum_inner_y < y < radii[0] + grown
    assert dims.levels.guide_bottom_z < z < dims.drum.lands[0].surface_radius_mm


def test_a_drum_too_near_meets_the_guide(dims: BevelLayout, solids: dict[str, Any], known: dict[str, Found]) -> None:
    """Shifted by -0.3 mm along y: past the transfer gap of 0.155 and the flank gaps of 0.045 mm."""
    shifted = {**solids, "drum": solids["drum"].moved(cq.Location(cq.Vector(0, -0.3, 0)))}
    found = interferences(dims, shifted, (dims.drive.half_travel_deg,), known=known)
    assert {("drum", "guide"), ("cable_1", "drum"), ("cable_2", "drum"), ("cable_3", "drum")} <= pairs(found)
    assert ("cable_4", "drum") not in pairs(found), "nothing stands beside the outermost cable"
    assert all("drum" in (c.first, c.second) for c in found), "\n".join(map(str, found))
    (clash,) = [c for c in found if {c.first, c.second} == {"drum", "guide"}]
    r = dims.guide.surface_radii[0]
    first = segment_area(r, 0.145) * (dims.drum.lands[0].surface_radius_mm - dims.levels.guide_bottom_z)
    steps = sum(
        segment_area(radius, 0.045) * (land.surface_radius_mm - wall)
        for radius, land, wall in zip(
            dims.guide.surface_radii[1:], dims.drum.lands[1:], dims.guide.walls_z, strict=True
        )
    )
    assert clash.volume_mm3 == pytest.approx(first + steps, rel=0.03), f"{clash}; by hand {first + steps:.4f}"


@pytest.mark.slow
def test_a_thicker_rope_uses_up_the_flank_gap(dims: BevelLayout) -> None:
    """Flank gap 0.6 - 0.15 - d/2: 0.045 mm for 0.81, 0.005 for 0.89, none for 0.93, of which 0.01 is undersize."""
    for diameter, clash in ((0.89, False), (0.93, True)):
        drive = replace(
            dims.drive, cable=replace(dims.drive.cable, diameter_mm=diameter), helix_lead_mm=diameter + 0.07
        )
        thick = BevelLayout(drive)
        parts = bill(thick).parts
        only = {name: parts[name].part.solid() for name in ("drum", "guide")}
        found = interferences(thick, only, (0.0,))
        expected = {(f"cable_{k}", "drum") for k in (1, 2, 3)} if clash else set()
        assert pairs(found) == expected, f"d = {diameter}: " + "\n".join(map(str, found))
        for c in found:
            step = int(c.first[-1]) - 1
            flank = drive.cable.diameter_mm / 2 - CABLE_UNDERSIZE_MM
            depth = flank - (thick.drum.lands[step + 1].y_start - drive.cables[step].guide_radius_mm)
            wrap = thick.drum.tensioners[step].anchor_rad + np.radians(35.0)
            expected_volume = segment_area(flank, depth) * drive.cables[step].drum_radius_mm * wrap
            assert c.volume_mm3 == pytest.approx(expected_volume, rel=0.15), f"{c}; by hand {expected_volume:.4f}"


def test_a_lead_under_the_diameter_is_a_self_overlap_at_every_pose(dims: BevelLayout) -> None:
    tight = BevelLayout(replace(dims.drive, helix_lead_mm=0.80))
    found = interferences(tight, {}, (-35.0, 0.0, 35.0))
    assert pairs(found) == {(f"cable_{k}", f"cable_{k}") for k in (1, 2, 3, 4)}
    for angle in (-35.0, 0.0, 35.0):
        assert len([c for c in found if c.drum_angle_deg == angle]) == 4
    assert all(0.0101 < c.overlap_mm < 0.02 for c in found)


@pytest.mark.slow
def test_past_the_stops_the_pin_cuts_the_slots_end(
    dims: BevelLayout, solids: dict[str, Any], known: dict[str, Found]
) -> None:
    """They engage at 35.25 deg: at 35.2 there is no clash, at 36 there is."""
    few = {name: solids[name] for name in ("drum", "stop_pin", "frame")}
    at_stop = dims.drive.half_travel_deg + dims.drive.stop_clearance_deg
    assert not pairs(interferences(dims, few, (-at_stop + 0.05, at_stop - 0.05), known=known)) & {("drum", "stop_pin")}
    found = interferences(dims, few, (-36.0, 36.0), known=known)
    assert pairs(found) == {("drum", "stop_pin")}
    for c in found:
        assert (
            np.linalg.norm(np.subtract(c.place_mm, (0.0, dims.drum.web_start_y, dims.drum.stop_radius))[[0, 2]]) < 1.6
        )
        assert c.place_mm[0] * c.drum_angle_deg < 0, "the slot's far end comes to the pin"


def test_a_thicker_stop_pin_meets_frame_and_drum(
    dims: BevelLayout, solids: dict[str, Any], known: dict[str, Found]
) -> None:
    """Radius 1.8: a ring of 0.3 mm in the frame's hole; and 0.15 mm into both sides of the slot."""
    length = dims.drum.web_end_y + 0.5 - dims.frame.stop_pin_start_y
    thick = Pin(1.8, length).solid()
    few = {name: solids[name] for name in ("drum", "frame")} | {"stop_pin": thick}
    found = interferences(dims, few, (0.0,), known=known)
    assert pairs(found) == {("frame", "stop_pin"), ("drum", "stop_pin")}
    volume = {c.first: c.volume_mm3 for c in found} | {c.second: c.volume_mm3 for c in found}
    web = dims.drum.web_end_y - dims.drum.web_start_y
    assert volume["drum"] == pytest.approx(2 * segment_area(1.8, 0.15) * web, rel=0.02)
    # The pin's chamfer of 0.3 mm lies in the hole's bottom.
    deep = dims.levels.front_y - dims.frame.stop_pin_start_y
    assert volume["frame"] == pytest.approx(pi * (1.8**2 - 1.5**2) * (deep - 0.15), rel=0.01)


def test_a_nut_run_into_its_neighbour(
    dims: BevelLayout, solids: dict[str, Any], move: Move, known: dict[str, Found]
) -> None:
    """Half a millimetre along its stud: as much of the next nut, no more and nothing else."""
    move({"nut_cable_3_1": Placement.translation(0.0, 0.0, 0.5)})
    found = interferences(dims, on_drum(solids), (0.0,), known=known)
    assert pairs(found) == {("nut_cable_3_1", "nut_cable_3_2")}
    t = dims.drive.tensioner
    expected = 0.5 * (sqrt(3) / 2 * t.nut_across_flats_mm**2 - pi * t.thread_mm**2 / 4)
    assert found[0].volume_mm3 == pytest.approx(expected, rel=1e-6)
    place = next(p for p in dims.drum.tensioners if p.cable_name == "cable_3")
    x, z = place.at(place.lug_end + t.nut_height_mm + 0.25)
    assert found[0].place_mm == pytest.approx((x, place.y_mm, z), abs=1e-6)


def test_a_nut_turned_into_its_pockets_wall(
    dims: BevelLayout, solids: dict[str, Any], move: Move, known: dict[str, Found]
) -> None:
    """A nut may stand at any angle; one with corners 0.6 mm too far out may not."""
    move({"nut_cable_1_1": Placement.about((0.0, 0.0, 1.0), 30.0), "nut_cable_2_2": Placement.about((0, 0, 1), 15.0)})
    assert not interferences(dims, on_drum(solids), (0.0,), known=known)
    large = Nut(dims.drive.tensioner.nut_across_flats_mm + 2.2, 1.3, 1.6).solid()
    found = interferences(dims, {**on_drum(solids), "nut": large}, (0.0,), known=known)
    assert ("drum", "nut_cable_2_1") in pairs(found)


def test_a_screw_one_size_too_long(dims: BevelLayout, solids: dict[str, Any]) -> None:
    """M2x8 in holes drilled for M2x6: 1.5 mm of thread in solid frame, four times."""
    drive = dims.drive
    longer = ScrewBody(replace(drive.screw("M2x8"), name="M2x6")).solid()
    found = interferences(dims, {"screw_M2x6": longer, "frame": solids["frame"]}, (0.0,))
    plate = [c for c in found if "plate_screw" in c.first + c.second]
    assert len(plate) == 4
    for c in plate:
        assert c.volume_mm3 == pytest.approx(pi * 1.5, rel=1e-6)


def test_result_and_order_do_not_depend_on_jobs(
    dims: BevelLayout, solids: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The drum 0.3 mm too near, alone with the guide; on two processes the tests are really forked."""
    monkeypatch.setattr(forks, "_allowed", True)
    few = {"guide": solids["guide"], "drum": solids["drum"].moved(cq.Location(cq.Vector(0, -0.3, 0)))}
    one, two = (interferences(dims, few, (5.0,), jobs) for jobs in (1, 2))
    assert len(one) > 3 and one == two, (one, two)


@pytest.mark.slow
def test_every_item_of_the_bill_takes_part(
    dims: BevelLayout, solids: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A small ball put inside every single item, and into every stretch of every cable, is found there."""
    inside = {name: _inner_point(solid) for name, solid in solids.items()}
    radius = 0.25
    ball = cq.Solid.makeSphere(radius, angleDegrees1=-90, angleDegrees2=90)
    paths = dims.cable_paths(0.0)
    rods = {
        f"{p.cable.name}_{n}": p.piece(n).points(np.array([0.5]))[0] for p in paths for n in ("helix", "span", "drum")
    }

    def probed(layout_: BevelLayout, angle_deg: float = 0.0) -> Bill:
        b = bill(layout_, angle_deg)
        probes: list[Item] = []
        for item in b.items:
            if not item.name.startswith(CABLE):
                at = Placement.translation(*inside[item.part])
                probes.append(
                    replace(item, name=f"probe_{item.name}", part="ball", group="probe", location=item.location @ at)
                )
        for name, at in rods.items():
            probes.append(
                replace(
                    b.items[0],
                    name=f"probe_{name}",
                    part="ball",
                    group="probe",
                    location=Placement.translation(*map(float, at)),
                )
            )
        return replace(b, items=(*b.items, *probes))

    monkeypatch.setattr(BevelLayout, "bill", probed)
    bodies = {name: body(name, solid) for name, solid in {**solids, "ball": ball}.items()}
    run = run_of(dims, bodies, (0.0,))
    # What does not touch a probe is left out: other tests look at it.
    looks = [look for look in run.looks if look.kind == "cables" or any(n.startswith("probe_") for n in look.names)]
    run = InterferenceRun(looks, {look.key: run.tests[look.key] for look in looks})
    found = run.clashes(answers(run, {}, 1))
    rigid = [i.name for i in bill(dims).items if not i.name.startswith(CABLE)]
    expected = {(min(name, f"probe_{name}"), max(name, f"probe_{name}")) for name in rigid}
    assert len(expected) + 4 == len(bill(dims).items)
    assert expected <= pairs(found), f"left out: {sorted(expected - pairs(found))}"
    for name in rods:
        assert (name.rsplit("_", 1)[0], f"probe_{name}") in pairs(found), f"{name} is not looked at"
    full = 4 / 3 * pi * radius**3
    assert all(c.volume_mm3 <= full * 1.001 for c in found)


def _inner_point(solid: cq.Solid) -> tuple[float, float, float]:
    """A point well inside a solid: from a face's middle inwards as far as there is metal round it."""
    best, room = (0.0, 0.0, 0.0), 0.0
    box = solid.BoundingBox()
    rng = np.random.default_rng(3)
    low, high = np.array([box.xmin, box.ymin, box.zmin]), np.array([box.xmax, box.ymax, box.zmax])
    tried = 0
    while tried < 4000 and room < 0.3:
        tried += 1
        p = low + rng.random(3) * (high - low)
        if solid.isInside(cq.Vector(*p)):
            wall = min(f.distance(cq.Vertex.makeVertex(*p)) for f in solid.Faces())
            if wall > room:
                best, room = (float(p[0]), float(p[1]), float(p[2])), wall
    return best


# Distance of centre lines compared with brute force, and the definition of another turn of the same cable.


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
    for moving in found:
        for name in moving.items:
            error = np.abs(np.array((moving.at(angle) @ centred[name]).rows) - np.array(moved[name].rows)).max()
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


TOLERANCE_MM = 0.01
ANGLE, SHIFT = st.floats(-180.0, 180.0), st.floats(-14.0, 14.0)


def surface(solid: Any) -> Surface:
    return Surface.of_mesh(mesh_solid("solid", solid, TOLERANCE_MM))


SOLIDS: dict[str, Callable[[], cq.Solid]] = {
    "box": lambda: cq.Solid.makeBox(12, 5, 3),
    "cylinder": lambda: cq.Solid.makeCylinder(4, 9),
    "ring": lambda: cq.Workplane().circle(8).circle(6).extrude(4).val(),
    "cone": lambda: cq.Solid.makeCone(5, 1, 7),
}
MADE = {name: make() for name, make in SOLIDS.items()}
SURFACES = {name: surface(solid) for name, solid in MADE.items()}


@pytest.mark.parametrize("gap_mm", [0.03, 0.5, 20.0])
def test_a_cylinder_in_a_bore_with_play_is_apart_and_one_that_touches_is_not(gap_mm: float) -> None:
    """Far inside the ring's bore, off its wall by the gap; by nothing, it touches along a line."""
    ring = surface(cq.Workplane().circle(40).circle(25).extrude(10).val())
    pin = surface(cq.Solid.makeCylinder(4, 8))
    assert apart(ring, pin, Placement.translation(25.0 - 4.0 - gap_mm, 0.0, 1.0))
    assert not apart(ring, pin, Placement.translation(25.0 - 4.0, 0.0, 1.0))
    assert not apart(ring, pin, Placement.translation(25.0 - 4.0 + gap_mm, 0.0, 1.0))


def test_a_body_wholly_inside_another_is_not_apart() -> None:
    """Their surfaces are 3 mm apart at least; what is between them is metal."""
    large, small = surface(cq.Solid.makeBox(20, 20, 20)), surface(cq.Solid.makeCylinder(2, 4))
    assert not apart(large, small, Placement.translation(10.0, 10.0, 8.0))
    assert not apart(small, large, Placement.translation(-10.0, -10.0, -8.0))
    inner = Surface.of_rod((Line((5.0, 10.0, 10.0), (15.0, 10.0, 10.0)),), 0.4)
    assert not apart(inner, large, Placement.identity())
    assert apart(inner, large, Placement.translation(0.0, 0.0, 10.5))


@settings(max_examples=150, deadline=None)
@given(st.sampled_from(sorted(SOLIDS)), st.sampled_from(sorted(SOLIDS)), st.tuples(ANGLE, ANGLE, SHIFT, SHIFT, SHIFT))
@example("cylinder", "cylinder", (0.0, 1e-201, 4.0, 7.0, 0.0))
def test_nothing_that_overlaps_is_proven_apart(one: str, other: str, motion: tuple[float, ...]) -> None:
    """Two solids thrown together: where the proof says apart, the kernel finds no common volume, however placed."""
    turn, tilt, x, y, z = motion
    placement = Placement.translation(x, y, z) @ Placement.about((0, 0, 1), turn) @ Placement.about((1, 0, 0), tilt)
    if apart(SURFACES[one], SURFACES[other], placement):
        assert common(MADE[one], MADE[other], placement)[0] == 0.0
        assert apart(SURFACES[other], SURFACES[one], placement.inverse), "the proof must not depend on the order"
    else:
        gap = MADE[one].distance(MADE[other].moved(_location(placement)))
        assert gap < 3 * TOLERANCE_MM, f"{gap:.4f} mm apart and not seen"


@settings(max_examples=25, deadline=None)
@given(st.sampled_from(sorted(SOLIDS)), st.tuples(ANGLE, ANGLE, SHIFT, SHIFT, SHIFT), st.floats(0.2, 2.0))
def test_no_rod_that_overlaps_is_proven_apart(name: str, motion: tuple[float, ...], radius_mm: float) -> None:
    """A rod about a helix, an arc and a line; the nearest point of its centre line is sampled."""
    turn, tilt, x, y, z = motion
    placement = Placement.translation(x, y, z) @ Placement.about((0, 0, 1), turn) @ Placement.about((1, 0, 0), tilt)
    line = (Line((-9.0, 0.0, 0.0), (9.0, 0.0, 0.0)),)
    arc = (Arc((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), 7.0, 0.0, 2.5),)
    helix = (Helix((0.0, 0.0), 7.0, 0.0, 11.0, 0.0, 8.0),)
    moved = MADE[name].moved(_location(placement))
    for pieces in (line, arc, helix):
        points = pieces[0].points(np.linspace(0.0, 1.0, 120))
        inside = any(moved.isInside(cq.Vector(*p)) for p in points[::8])
        gap = min(moved.distance(cq.Vertex.makeVertex(*p)) for p in points)
        if apart(Surface.of_rod(pieces, radius_mm), SURFACES[name], placement):
            assert gap > radius_mm - 1e-6 and not inside, f"{gap:.4f} mm from the line of a rod of {radius_mm:.4f} mm"
        else:
            assert inside or gap < radius_mm + 0.2, f"{gap:.4f} mm from the line of a rod of {radius_mm:.4f} mm"


def test_a_line_of_chords_is_within_the_sagitta_of_its_curve() -> None:
    """A rod's surface accounts for the radius and for the curve's distance from its chords."""
    bend = Arc((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), 2.0, 0.0, 3.0)
    rod_ = Surface.of_rod((bend,), 0.4)
    step = bend.length_mm / len(rod_.corners_mm)
    assert rod_.within_mm == pytest.approx(0.4 + 2.0 * (1.0 - np.cos(step / 4.0)) + 1e-4, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("angle_deg", [-35.0])
def test_a_run_with_meshes_finds_what_one_without_finds(
    dims: BevelLayout, solids: dict[str, Any], angle_deg: float
) -> None:
    """The drum 0.3 mm too near: all clashes of the plain run, to the last figure."""
    shifted = {**solids, "drum": solids["drum"].moved(cq.Location(cq.Vector(0, -0.3, 0)))}
    runs = [
        run_of(dims, {name: body(name, solid, tolerance) for name, solid in shifted.items()}, (angle_deg,))
        for tolerance in (None, TOLERANCE_MM)
    ]
    plain, culled = (run.clashes(answers(run, {}, 2)) for run in runs)
    assert plain and plain == culled


def test_a_cable_wound_on_a_pulley_is_left_to_the_kernel(dims: BevelLayout, solids: dict[str, Any]) -> None:
    """0.005 mm off its land: nearer than the mesh is to the pulley, so nothing may be proven."""
    path = dims.cable_paths(0.0)[0].only(("helix",))
    radius = dims.drive.cable.diameter_mm / 2 - 0.005
    pulley = next(p for p in dims.inputs if p.name == path.cable.input_name)
    place = Placement.translation(pulley.x, 0.0, 0.0)
    solid = solids[f"input_pulley_{pulley.name}"]
    assert not apart(Surface.of_rod(path.line, radius), surface(solid), place)
    assert apart(Surface.of_rod(path.line, radius - 0.02), surface(solid), place)
    assert common(rod(path.line, radius), solid, place)[0] == 0.0


@pytest.mark.parametrize("off_mm", [0.0, 0.03])
def test_a_wound_cable_is_proven_off_its_land_and_what_overlaps_is_found_as_without_meshes(
    dims: BevelLayout, solids: dict[str, Any], monkeypatch: pytest.MonkeyPatch, off_mm: float
) -> None:
    """The rod along the helix is drawn only where the pulley, moved towards the cable, is really in its way."""
    path = dims.cable_paths(0.0)[0]
    stretch = next(s for s in path.stretches if "helix" in s.pieces)
    pulley = next(p for p in dims.inputs if p.name == path.cable.input_name)
    name, place = f"input_pulley_{pulley.name}", Placement.translation(pulley.x + off_mm, 0.0, 0.0)
    drawn: list[str] = []
    monkeypatch.setattr(
        kernel, "rod", lambda pieces, r: drawn.extend(type(p).__name__ for p in pieces) or rod(pieces, r)
    )
    shape = RodShape(path.only(stretch.pieces), dims.drive.cable.diameter_mm)
    with_mesh = Rod(shape, body(name, solids[name], TOLERANCE_MM), place).test()
    assert ("Helix" in drawn) == (off_mm > 0.0), drawn
    assert with_mesh == Rod(shape, body(name, solids[name], None), place).test()
    assert bool(with_mesh) == (off_mm > 0.0)


@pytest.mark.parametrize(("shift_mm", "inside_mm"), [(0.0, 20.0), (20.0, 5.0), (26.0, 0.0)])
def test_a_rod_inside_a_body_or_partly_inside_is_found(shift_mm: float, inside_mm: float) -> None:
    """No short part of a rod wholly inside is near the surface; where it enters, some are."""
    line = Line((-10.0, 0.0, 0.0), (10.0, 0.0, 0.0))
    path = SimpleNamespace(line=(line,), length_mm=20.0, sample=lambda step: line.points(np.linspace(0.0, 1.0, 41)))
    shape = RodShape(cast(CablePath, path), 1.02)
    block = body("block", cq.Workplane().box(30.0, 30.0, 30.0).val(), TOLERANCE_MM)
    found = Rod(shape, block, Placement.translation(shift_mm, 0.0, 0.0)).test()
    assert sum(volume for _, _, volume, *_ in found) == pytest.approx(np.pi * shape.radius_mm**2 * inside_mm, rel=1e-4)


def _location(placement: Placement) -> cq.Location:
    from mbcdm_cad.workshop.kernel import location

    return cq.Location(location(placement))


# An interference run that reuses earlier results finds the same as a run without them.


POSES = (-35.0, 4.0)
PARTS = ("drum", "guide", "drum_shaft", "terminal", "nut", "frame")


@pytest.fixture(scope="module")
def two_bodies(solids: dict[str, Any]) -> dict[str, PartShape]:
    return {name: body(name, solids[name], 0.01) for name in PARTS}


def edited(solids: dict[str, Any], part: str, shift_mm: tuple[float, float, float]) -> PartShape:
    return body(part, solids[part].moved(cq.Location(cq.Vector(*shift_mm))), 0.01)


def look(
    dims: BevelLayout, two_bodies: dict[str, PartShape], cache: Cache, jobs: int = 1
) -> tuple[tuple[Clash, ...], list[str]]:
    """Result of a run that may use and fills the cache, and the keys of the tests it had to make."""
    run, stored = run_of(dims, two_bodies, POSES), KnownTests(cache)
    missing = run.missing(stored)
    found = answers(run, stored, jobs)
    stored.add({key: found[key] for key in missing}, run.tests)
    return run.clashes(found), missing


@pytest.mark.slow
def test_edits_one_after_the_other_equal_runs_from_nothing(
    dims: BevelLayout,
    solids: dict[str, Any],
    two_bodies: dict[str, PartShape],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A harmless edit, one that makes clashes, one of another part, and the way back: each as if nothing was known."""
    monkeypatch.setattr(forks, "_allowed", True)
    cache = Cache(tmp_path)
    steps = {
        "as drawn": two_bodies,
        "drum 0.02 mm out": {**two_bodies, "drum": edited(solids, "drum", (0.0, 0.02, 0.0))},
        "drum 0.3 mm in": {**two_bodies, "drum": edited(solids, "drum", (0.0, -0.3, 0.0))},
        "and the guide 0.2 mm up": {
            **two_bodies,
            "drum": edited(solids, "drum", (0.0, -0.3, 0.0)),
            "guide": edited(solids, "guide", (0.0, 0.0, 0.2)),
        },
        "drum back": {**two_bodies, "guide": edited(solids, "guide", (0.0, 0.0, 0.2))},
        "as drawn again": two_bodies,
    }
    clashes = {}
    for jobs, (name, step) in enumerate(steps.items(), 1):
        clashes[name], made = look(dims, step, cache, 1 + jobs % 2)
        plain = run_of(dims, step, POSES)
        assert clashes[name] == plain.clashes(answers(plain, {}, 1)), f"{name}: {len(made)} tests made"
        if name == "as drawn again":
            assert not made, f"{len(made)} tests were forgotten"
    assert not clashes["as drawn"] and not clashes["drum 0.02 mm out"]
    assert any({c.first, c.second} == {"drum", "guide"} for c in clashes["drum 0.3 mm in"])
    assert not any("drum" in (c.first, c.second) for c in clashes["drum back"] if "guide" not in (c.first, c.second))


def test_only_pairs_of_the_edited_part_are_tested_again(
    dims: BevelLayout, solids: dict[str, Any], two_bodies: dict[str, PartShape], tmp_path: Path
) -> None:
    cache = Cache(tmp_path)
    _, all_tests = look(dims, two_bodies, cache)
    run = run_of(dims, {**two_bodies, "nut": edited(solids, "nut", (0.0, 0.0, 0.01))}, POSES)
    missing = run.missing(KnownTests(cache))
    assert 0 < len(missing) < len(all_tests) / 2, f"{len(missing)} of {len(all_tests)}"
    for key in missing:
        test = run.tests[key]
        if isinstance(test, Faces):
            assert test.part == "nut"
            continue
        assert isinstance(test, Pair | Rod)
        looked_at = {name for look_ in run.looks if look_.key == key for name in look_.names}
        assert any(name.startswith("nut_") for name in looked_at), f"tested again: {looked_at}"


def test_bodies_that_move_together_are_one_test_however_often_they_are_looked_at(
    dims: BevelLayout, two_bodies: Any
) -> None:
    """The four nuts' two pairs a terminal lie alike, whatever the drum's angle."""
    run = run_of(dims, two_bodies, (-20.0, -3.0, 11.0))
    looks = [look_.key for look_ in run.looks if all(name.startswith("nut_") for name in look_.names)]
    assert len(looks) == 4 and len(set(looks)) == 1, f"{len(looks)} looks, {len(set(looks))} tests"


def test_a_long_used_store_is_pruned_of_what_was_not_used_longest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(store, "MOST_ANSWERS", 3)
    cache = Cache(tmp_path)
    a, b, c, d = (f"{k:032x}" for k in range(4))
    hit = [(0, 1, 0.5, 1.0, 2.0, 3.0)]
    KnownTests(cache).add({a: [], b: hit, c: []}, [a, b, c])
    again = KnownTests(cache)
    again.add({d: []}, [a, d])
    kept = KnownTests(cache)
    assert set(kept) == {c, a, d}, "b was used longest ago"
    KnownTests(cache).add({b: hit}, [b, c])
    kept = KnownTests(cache)
    assert set(kept) == {b, c, d} and [tuple(row) for row in kept[b]] == hit


def test_answers_of_two_runs_at_once_are_both_kept(tmp_path: Path) -> None:
    cache = Cache(tmp_path)
    one, other = KnownTests(cache), KnownTests(cache)
    one.add({"0" * 32: []}, ["0" * 32])
    other.add({"1" * 32: []}, ["1" * 32])
    assert len(KnownTests(cache)) == 2
    assert sum(1 for path in tmp_path.rglob("*") if path.is_file()) == 1, "one entry for all answers"
