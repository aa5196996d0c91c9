"""Advice on pins: derived fields that the file gives although a rule could, and that a requirement contradicts.

Each piece of advice is tried before it is given: the field is taken out, its rule fills it, and the check runs again.
"""

import copy
from collections.abc import Iterable, Sequence
from typing import Any

from mbcdm_cad.checks.comparison import Check
from mbcdm_cad.checks.run import Budget, run_check
from mbcdm_cad.design import yamltree
from mbcdm_cad.design.describe import flow
from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import layout_of, load_tree

# A file with more pins than this is a complete file: its pins are tried together.
FEW = 8


def pin_advice(loaded: LoadedDesign, failed: Sequence[Check]) -> tuple[dict[str, str], dict[str, list[str]]]:
    """For each failed check that passes without certain pins, by its id: the advice in words, and these pins."""
    tree = yamltree.parse(loaded.text, str(loaded.path))
    derived = layout_of(loaded.drive).design_file().derived()
    pins = [field for field in derived if _stands(tree.data, field)]
    if not pins or not failed:
        return {}, {}
    if len(pins) > FEW:
        return _together(loaded, tree, pins, failed)
    advice: dict[str, str] = {}
    taken: dict[str, list[str]] = {}
    for pin in pins:
        freed = _without(loaded, tree, [pin])
        value = next((v.value for v in freed.sized if v.field == pin), None) if freed else None
        if freed is None or value is None:
            continue
        line = loaded.line_of(*pin.split("."))
        for check in _mended(freed, failed):
            advice.setdefault(check.id, f"take {pin} out: its rule gives {flow(value)} (given on line {line})")
            taken.setdefault(check.id, [pin])
    return advice, taken


def _together(
    loaded: LoadedDesign, tree: yamltree.Tree, pins: Sequence[str], failed: Sequence[Check]
) -> tuple[dict[str, str], dict[str, list[str]]]:
    freed = _without(loaded, tree, pins)
    if freed is None:
        return {}, {}
    mended = _mended(freed, failed)
    left = [check.id for check in failed if check not in mended]
    rest = "every check that fails now then passes" if not left else f"{', '.join(left)} would still fail"
    text = f"take the {len(pins)} derived fields out, so that they follow from rules (such as {pins[0]}): {rest}"
    return {check.id: text for check in mended}, {check.id: list(pins) for check in mended}


def _mended(freed: LoadedDesign, failed: Sequence[Check]) -> list[Check]:
    return [check for check in failed if run_check(check, layout_of(freed.drive), Budget(0)).status != "fail"]


def _without(loaded: LoadedDesign, tree: yamltree.Tree, fields: Iterable[str]) -> LoadedDesign | None:
    data = copy.deepcopy(tree.data)
    for field in fields:
        *blocks, last = field.split(".")
        at = data
        for block in blocks:
            at = at[block]
        del at[last]
    try:
        return load_tree(yamltree.Tree(data, tree.lines), loaded.text, loaded.path)
    except InputError:
        return None


def _stands(data: Any, field: str) -> bool:
    for part in field.split("."):
        if not isinstance(data, dict) or part not in data:
            return False
        data = data[part]
    return True
