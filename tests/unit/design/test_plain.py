"""The quick way of reading a design against pydantic's: the same values, and nothing read that is wrong."""

from __future__ import annotations

import copy
import random
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError

from mbcdm_cad.design import loader, plain, yamltree
from mbcdm_cad.design.plain import plain_table, read_plainly
from mbcdm_cad.design.schema import Design

ROOT = Path(__file__).parents[3]
TEXT = (ROOT / "params" / "mbcdm.yaml").read_text("utf-8")
LEAVES: tuple[Any, ...] = (
    None, True, False, 0, 1, 2, -1, 4, 0.0, 1.5, -0.0, 35, 1e300, 10**400, float("nan"), float("inf"), "", "x", " x",
    "x\n", "+x", "-x", "7x7", "nominal", "M2", "618/4", "a" * 401, [], {}, [1.0, 2.0], [1.0, 2.0, 3.0, 4.0], {"x": 1},
)  # fmt: skip
CHANGES = 3000


def data() -> Any:
    return yamltree.parse(TEXT, "mbcdm.yaml").data


def places(node: Any) -> list[tuple[Any, Any]]:
    """Every (container, key) below ``node``."""
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    return [place for key, value in items for place in ((node, key), *places(value))]


def changed(chance: random.Random) -> Any:
    """The reference with one or two places changed, taken away, or a field put beside them."""
    tree = copy.deepcopy(data())
    for _ in range(chance.choice((1, 1, 2))):
        container, key = chance.choice(places(tree))
        way = chance.random()
        if way < 0.1 and isinstance(container, dict):
            del container[key]
        elif way < 0.2 and isinstance(container, dict):
            container[chance.choice(("preload_N", "modulus_GPa", "guide_radii_mm", "inline", "unknown"))] = (
                copy.deepcopy(chance.choice(LEAVES))
            )
        elif way < 0.5 and isinstance(container[key], float):
            container[key] *= chance.uniform(0.5, 2.0)
        else:
            container[key] = copy.deepcopy(chance.choice(LEAVES))
    return tree


def test_table_is_that_of_the_schema() -> None:
    stored = plain.TABLE.read_text("utf-8")
    assert stored == plain_table(), "the schema has changed: run python -m mbcdm_cad.design.plain"


def test_reference_is_read_alike() -> None:
    block = read_plainly(data())
    assert block is not None, "the reference design is not read the quick way"
    assert block.model_dump() == Design.model_validate(data()).model_dump(mode="json")


def test_same_answers_on_changed_designs() -> None:
    chance = random.Random(3)
    read = refused = 0
    for _ in range(CHANGES):
        tree = changed(chance)
        block = read_plainly(tree)
        try:
            model = Design.model_validate(tree)
        except ValidationError:
            assert block is None, f"read, though the schema refuses it: {tree}"
            refused += 1
            continue
        if block is not None:
            assert block.model_dump() == model.model_dump(mode="json")
            read += 1
    assert read > CHANGES // 10 and refused > CHANGES // 10, f"{read} read, {refused} refused: the test shows little"


def test_same_design_either_way(monkeypatch: pytest.MonkeyPatch) -> None:
    quick = loader.load_text(TEXT)
    monkeypatch.setattr(loader, "read_plainly", lambda _: None)
    slow = loader.load_text(TEXT)
    assert (quick.drive, quick.sha256, quick.lines) == (slow.drive, slow.sha256, slow.lines)


def test_older_table_is_not_used(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plain, "_sources", lambda: "another schema")
    assert read_plainly(data()) is None
