"""What the redesign has reached does not grow again: counts of the code with their limits."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.house_counts import House, circle_members, counts, repeats, twice_declared

TREE = Path(__file__).parents[2]
# Largest allowed counts; lower them when a change reaches less. Meanings: the docstrings of tests/house_counts.py.
LIMITS = {
    "class families a layout": 6,
    "registry calls": 2,
    "maker strings": 0,
    "fields declared twice": 3,
    "files of miso_bevel": 40,
    "files of siso_bevel": 22,
    "files of siso_spur": 38,
    "files of miso_spur": 13,
    "files": 603,
    "imports, share of lines in %": 7.5,
    "circles": 1,
    "arrows back": 0,
    "repeating pairs": 95,
    "lines": 100173,
}


@pytest.fixture(scope="module")
def found() -> dict[str, float]:
    """The counts of this tree."""
    return counts(House(TREE))


@pytest.mark.parametrize("name", LIMITS)
def test_a_count_is_within_its_limit(found: dict[str, float], name: str) -> None:
    assert found[name] <= LIMITS[name], f"{name}: {found[name]}; list: python tests/house_counts.py --help"


def test_every_count_has_a_limit(found: dict[str, float]) -> None:
    assert set(found) == set(LIMITS)


def _house(folder: Path, **modules: str) -> House:
    (folder / "mbcdm_cad").mkdir()
    for name, text in modules.items():
        (folder / "mbcdm_cad" / f"{name}.py").write_text(text)
    return House(folder)


def test_the_same_code_with_other_names_is_a_repeating_pair(tmp_path: Path) -> None:
    body = "\n".join(f"    {{0}}{k} = other({{0}}{', {0}' * k}) - {{0}} / 2" for k in range(8))
    one, two = (f"import os\n\ndef {name}({name}):\n" + body.format(name) + "\n" for name in ("first", "second"))
    assert [pair[:4] for pair in repeats(_house(tmp_path, one=one, two=two))] == [("one", 3, "two", 3)]


def test_a_circle_through_a_function_or_a_type_is_found(tmp_path: Path) -> None:
    one = "def call():\n    from mbcdm_cad import two\n"
    two = "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from mbcdm_cad.one import call\n"
    assert circle_members(_house(tmp_path, one=one, two=two, three="import mbcdm_cad.two\n")) == [["one", "two"]]


@pytest.mark.parametrize("base", ["BaseModel", "PlainBlock"])
def test_fields_that_are_read_and_used_by_two_classes_are_found(base: str, tmp_path: Path) -> None:
    read = f"class Block({base}):\n    a: int\n    b: int\n    c: int\n"
    used = "class Plain:\n    a: int\n    b: int\n    c: int\n    d: int\n"
    assert twice_declared(_house(tmp_path, design=read + used)) == [("design.Block", "design.Plain", 3)]
