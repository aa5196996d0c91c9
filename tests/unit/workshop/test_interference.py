"""Interference is found where it is and nowhere else: single bodies moved or thickened, volumes computed by hand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import acos, pi, sqrt
from typing import Any

import cadquery as cq
import numpy as np
import pytest

from mbcdm_cad.layouts.miso_bevel.bill import bill
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.parallel import forks
from mbcdm_cad.parts.bill import CABLE, Bill, Item, Placement
from mbcdm_cad.parts.bodies import ScrewBody
from mbcdm_cad.parts.turned import IdlerPulley, Nut, Pin
from mbcdm_cad.workshop.interference import InterferenceRun, answers, travel_poses
from mbcdm_cad.workshop.pairs import CABLE_UNDERSIZE_MM, Clash, Found
from tests.support.interference_of_solids import body, interferences, run_of

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
