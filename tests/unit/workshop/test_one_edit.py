"""An interference run that reuses earlier results finds the same as a run without them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cadquery as cq
import pytest

from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.parallel import forks
from mbcdm_cad.storage.cache import Cache
from mbcdm_cad.workshop import store
from mbcdm_cad.workshop.interference import answers
from mbcdm_cad.workshop.pairs import Clash, Faces, Pair, PartShape, Rod
from mbcdm_cad.workshop.store import KnownTests
from tests.support.interference_of_solids import body, run_of

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
