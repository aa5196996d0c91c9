"""What the redesign has reached does not grow again: counts of the code with their limits."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.house_counts import (
    House,
    circle_members,
    counts,
    docs_lines_by_hand,
    field_path_strings,
    repeats,
    room_lines,
    search_thresholds,
    short_helpers,
    twice_declared,
)

TREE = Path(__file__).parents[2]
# Largest allowed counts. A change that reaches less lowers them; they are raised only while an old and a new way stand
# side by side. Meanings: the docstrings of tests/house_counts.py.
LIMITS: dict[str, float] = json.loads((TREE / "tests" / "house_limits.json").read_text("utf-8"))
# What the owners of the project allow; it lies beside a checkout, not in it.
BUDGET = TREE.parent / "shared" / "budget.json"


@pytest.fixture(scope="module")
def found() -> dict[str, float]:
    """The counts of this tree."""
    return counts(House(TREE))


@pytest.mark.parametrize("name", LIMITS)
def test_a_count_is_within_its_limit(found: dict[str, float], name: str) -> None:
    assert found[name] <= LIMITS[name], f"{name}: {found[name]}; list: python tests/house_counts.py --help"


def test_every_count_has_a_limit(found: dict[str, float]) -> None:
    assert set(found) == set(LIMITS)


@pytest.mark.skipif(not BUDGET.is_file(), reason="the owners' budget is not beside this checkout")
def test_no_limit_stands_above_the_ceiling() -> None:
    ceilings = json.loads(BUDGET.read_text("utf-8"))["ceiling"]
    assert {name: LIMITS[name] for name, most in ceilings.items() if LIMITS[name] > most} == {}


def _house(folder: Path, **modules: str) -> House:
    (folder / "mbcdm_cad").mkdir()
    for name, text in modules.items():
        (folder / "mbcdm_cad" / f"{name}.py").write_text(text)
    return House(folder)


def test_the_same_code_with_other_names_is_a_repeating_pair(tmp_path: Path) -> None:
    body = "\n".join(f"    {{0}}{k} = other({{0}}{', {0}' * k}) - {{0}} / 2" for k in range(8))
    one, two = (f"import os\n\ndef {name}({name}):\n" + body.format(name) + "\n" for name in ("first", "second"))
    assert [pair[:4] for pair in repeats(_house(tmp_path, one=one, two=two))] == [("one", 3, "two", 3)]


def test_texts_pages_helpers_paths_and_thresholds_are_counted(tmp_path: Path) -> None:
    helper = "def _once(x):\n    return x\n\ndef call():\n    return _once('drum.hub_mm'), 'drum', 'other.hub_mm'\n"
    (tmp_path / "mbcdm_cad" / "loop" / "search").mkdir(parents=True)
    (tmp_path / "mbcdm_cad" / "loop" / "search" / "judge.py").write_text(
        "LEAST = (0.45, 2.0)\nNAME = 'x'\ndef f(x):\n    return x > 3.5 or x > 0\n" + helper
    )
    for name, text in {
        "docs/checks.md": "a\n",
        "docs/how/to.md": "a\nb\n",
        "params/a.yaml": "drum:\n  hub_mm: 1\n",
    }.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    house = House(tmp_path)
    assert docs_lines_by_hand(house) == 2
    assert short_helpers(house) == [("loop.search.judge", "_once")]
    assert field_path_strings(house) == 1
    assert search_thresholds(house) == 2
    assert room_lines(house)["loop"] == 9


def test_a_circle_through_a_function_or_a_type_is_found(tmp_path: Path) -> None:
    one = "def call():\n    from mbcdm_cad import two\n"
    two = "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from mbcdm_cad.one import call\n"
    assert circle_members(_house(tmp_path, one=one, two=two, three="import mbcdm_cad.two\n")) == [["one", "two"]]


@pytest.mark.parametrize("base", ["BaseModel", "PlainBlock"])
def test_fields_that_are_read_and_used_by_two_classes_are_found(base: str, tmp_path: Path) -> None:
    read = f"class Block({base}):\n    a: int\n    b: int\n    c: int\n"
    used = "class Plain:\n    a: int\n    b: int\n    c: int\n    d: int\n"
    assert twice_declared(_house(tmp_path, design=read + used)) == [("design.Block", "design.Plain", 3)]
