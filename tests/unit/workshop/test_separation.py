"""Pairs proven apart are apart: compared with distances in closed form, and with the kernel's booleans."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import cadquery as cq
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.parallel import forks
from mbcdm_cad.parts.bill import Placement
from mbcdm_cad.routes.curves import Arc, CablePath, Helix, Line
from mbcdm_cad.storage.cache import Cache
from mbcdm_cad.workshop import kernel, store
from mbcdm_cad.workshop.interference import answers
from mbcdm_cad.workshop.kernel import common, rod
from mbcdm_cad.workshop.meshing import mesh_solid
from mbcdm_cad.workshop.pairs import Clash, Faces, Pair, PartShape, Rod, RodShape
from mbcdm_cad.workshop.separation import Surface, apart
from mbcdm_cad.workshop.store import KnownTests
from tests.support.interference_of_solids import body, run_of

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
def bodies(solids: dict[str, Any]) -> dict[str, PartShape]:
    return {name: body(name, solids[name], 0.01) for name in PARTS}


def edited(solids: dict[str, Any], part: str, shift_mm: tuple[float, float, float]) -> PartShape:
    return body(part, solids[part].moved(cq.Location(cq.Vector(*shift_mm))), 0.01)


def look(
    dims: BevelLayout, bodies: dict[str, PartShape], cache: Cache, jobs: int = 1
) -> tuple[tuple[Clash, ...], list[str]]:
    """Result of a run that may use and fills the cache, and the keys of the tests it had to make."""
    run, stored = run_of(dims, bodies, POSES), KnownTests(cache)
    missing = run.missing(stored)
    found = answers(run, stored, jobs)
    stored.add({key: found[key] for key in missing}, run.tests)
    return run.clashes(found), missing


@pytest.mark.slow
def test_edits_one_after_the_other_equal_runs_from_nothing(
    dims: BevelLayout,
    solids: dict[str, Any],
    bodies: dict[str, PartShape],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A harmless edit, one that makes clashes, one of another part, and the way back: each as if nothing was known."""
    monkeypatch.setattr(forks, "_allowed", True)
    cache = Cache(tmp_path)
    steps = {
        "as drawn": bodies,
        "drum 0.02 mm out": {**bodies, "drum": edited(solids, "drum", (0.0, 0.02, 0.0))},
        "drum 0.3 mm in": {**bodies, "drum": edited(solids, "drum", (0.0, -0.3, 0.0))},
        "and the guide 0.2 mm up": {
            **bodies,
            "drum": edited(solids, "drum", (0.0, -0.3, 0.0)),
            "guide": edited(solids, "guide", (0.0, 0.0, 0.2)),
        },
        "drum back": {**bodies, "guide": edited(solids, "guide", (0.0, 0.0, 0.2))},
        "as drawn again": bodies,
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
    dims: BevelLayout, solids: dict[str, Any], bodies: dict[str, PartShape], tmp_path: Path
) -> None:
    cache = Cache(tmp_path)
    _, all_tests = look(dims, bodies, cache)
    run = run_of(dims, {**bodies, "nut": edited(solids, "nut", (0.0, 0.0, 0.01))}, POSES)
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
    dims: BevelLayout, bodies: Any
) -> None:
    """The four nuts' two pairs a terminal lie alike, whatever the drum's angle."""
    run = run_of(dims, bodies, (-20.0, -3.0, 11.0))
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
