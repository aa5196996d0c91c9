"""Try the remedies of all failed checks together, in the file as a user would edit it, and see whether it then passes.

Each remedy alone makes its own check pass. Here the first remedy of every failed check is written into the file at
once; the design is sized and checked again, and checks that then fail are treated in the same way, for some rounds.
Requirements of the file do not change.
"""

import copy
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from mbcdm_cad.checks.comparison import Check, failed
from mbcdm_cad.checks.run import Budget, Offer, run_all, run_check
from mbcdm_cad.design import yamltree
from mbcdm_cad.design.describe import flow
from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.design.yamltree import put
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import layout_of, load_tree

ROUNDS = 3
# Trials that the remedies of a later round may take: a failing check must not take long.
TRIALS = 120


@dataclass(frozen=True)
class Together:
    """The file changed by the remedies: values set, fields taken out, and the checks that still fail."""

    changes: Mapping[str, float]
    taken_out: tuple[str, ...]
    failing: tuple[str, ...]
    # Whether 'mbcdm solve' can look further: it needs sizing rules.
    solvable: bool = True

    @property
    def passes(self) -> bool:
        """Whether the changed file passes every check."""
        return not self.failing

    def words(self, path: str) -> str:
        """One sentence for the terminal."""
        if not self.passes:
            left = ", ".join(self.failing[:6]) + (", ..." if len(self.failing) > 6 else "")
            if not self.changes and not self.taken_out:
                what = "no value that the file leaves open makes these checks pass by itself"
                return f"{what}: 'mbcdm solve {path}' looks further" if self.solvable else what
            return (
                "tried together, the remedies that leave alone what the file asks do not end in a pass "
                f"({left} still fail)" + (f": 'mbcdm solve {path}' looks further" if self.solvable else "")
            )
        said = [f"{field}: {flow(value)}" for field, value in self.changes.items()]
        said += [f"{field} taken out" for field in self.taken_out[:6]]
        said += [f"{len(self.taken_out) - 6} more taken out"] if len(self.taken_out) > 6 else []
        return f"tried together, this passes every check: {'; '.join(said)}"


def together(
    loaded: LoadedDesign,
    checks: Sequence[Check],
    asked: Collection[str],
    offers: Mapping[str, Sequence[Offer]],
    pins: Mapping[str, Sequence[str]],
) -> Together:
    """Follow the first remedy of each failed check, ``offers`` and ``pins`` to take out; what is ``asked`` stays."""
    tree = yamltree.parse(loaded.text, str(loaded.path))
    file = layout_of(loaded.drive).design_file()
    data, changes, out = copy.deepcopy(tree.data), dict[str, float](), dict[str, None]()
    failing: tuple[str, ...] = tuple(offers)
    for _ in range(ROUNDS):
        moved = _merged(offers, pins)
        moved = {path: offer for path, offer in moved.items() if file.node_at(tuple(path.split("."))) is not None}
        new_out = [field for fields in pins.values() for field in fields if field not in out]
        if not moved and not new_out:
            break
        tried, gone = copy.deepcopy(data), out | dict.fromkeys(new_out)
        for field in new_out:
            _remove(tried, field)
        wanted = {path: float(f"{offer.value:.6g}") for path, offer in moved.items() if path not in gone}
        for path, value in wanted.items():
            put(tried, path, value)
        try:
            design = load_tree(yamltree.Tree(copy.deepcopy(tried), tree.lines), loaded.text, loaded.path)
        except InputError:
            # The remedies together give an invalid file: it stays unchanged.
            break
        data, changes, out = tried, changes | wanted, gone
        budget = Budget(TRIALS, lambda: asked, most=1, warnings=False)
        results = run_all(checks, layout_of(design.drive), budget)
        failing = tuple(result.id for result in failed(results))
        offers, pins = {name: budget.offers.get(name, ()) for name in failing}, {}
        if not failing:
            break
    return Together(changes, tuple(out), failing, bool(file.sizing))


def _merged(offers: Mapping[str, Sequence[Offer]], pins: Mapping[str, Sequence[str]]) -> dict[str, Offer]:
    """One offer for each field: the first of each check that changes no requirement, the larger change of two."""
    found: dict[str, Offer] = {}
    for name, listed in offers.items():
        offer = next((o for o in listed if not o.asked), None)
        if offer is None or name in pins:
            continue
        other = found.get(offer.path)
        if other is None or (other.sense == offer.sense and offer.sense * (offer.value - other.value) > 0):
            found[offer.path] = offer
    return found


def _remove(data: dict[str, Any], path: str) -> None:
    *blocks, last = path.split(".")
    for block in blocks:
        data = data.get(block) or {}
    data.pop(last, None)


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
        _remove(data, field)
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
