"""Values given as ``{value: 70.0, sigma: 3.0}``: the sigma is taken out before the schema sees the file.

So the schema, its bounds and everything behind it go on reading plain numbers; the standard deviations travel beside
them, by field path, to those who ask for intervals. Only fields that the schema marks may carry one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from mbcdm_cad.design.fieldpath import FieldPath, dotted
from mbcdm_cad.design.yamltree import Tree
from mbcdm_cad.errors import InputError, Problem, shortened

VALUE, SIGMA = "value", "sigma"
# A value must stay positive within three sigma, or a normal law does not describe it.
WIDEST_SHARE = 1 / 3


def split_sigmas(
    tree: Tree, file: str, may_carry_sigma: Callable[[FieldPath], bool]
) -> tuple[Tree, dict[FieldPath, float]]:
    """The tree with plain values, and the sigma of each field that gave one. Raises InputError with all problems."""
    splitter = _Splitter(tree, file, may_carry_sigma)
    data = splitter.plain(tree.data, ())
    if splitter.problems:
        raise InputError(sorted(splitter.problems, key=lambda problem: problem.line))
    return Tree(data, tree.lines), splitter.sigmas


class _Splitter:
    def __init__(self, tree: Tree, file: str, may_carry_sigma: Callable[[FieldPath], bool]) -> None:
        self.tree, self.file, self.may_carry_sigma = tree, file, may_carry_sigma
        self.sigmas: dict[FieldPath, float] = {}
        self.problems: list[Problem] = []

    def plain(self, node: Any, path: FieldPath) -> Any:
        if isinstance(node, list):
            return [self.plain(item, (*path, k)) for k, item in enumerate(node)]
        if not isinstance(node, dict):
            return node
        if SIGMA in node or VALUE in node:
            if self.may_carry_sigma(path):
                return self._measured(node, path)
            if set(node) == {VALUE, SIGMA}:
                self._problem(path, "carries a sigma, which nothing here would use", remedy="give the bare value")
                return node
        return {key: self.plain(item, (*path, key)) for key, item in node.items()}

    def _measured(self, node: dict[str, Any], path: FieldPath) -> Any:
        for key in node:
            if key not in (VALUE, SIGMA):
                self._problem((*path, key), "unknown field", limit="value and sigma", remedy="remove it")
        for key in (VALUE, SIGMA):
            if key not in node:
                self._problem(path, f"has no {key}", limit="value and sigma", remedy="write {value: ..., sigma: ...}")
        value, sigma = node.get(VALUE), node.get(SIGMA)
        if SIGMA in node and (isinstance(sigma, bool) or not isinstance(sigma, int | float)):
            where = (*path, SIGMA)
            self._problem(where, "not a number", shortened(sigma), remedy="write one standard deviation in the unit")
        elif isinstance(sigma, int | float) and isinstance(value, int | float) and not isinstance(value, bool):
            widest = WIDEST_SHARE * abs(value)
            if 0.0 <= sigma <= widest:
                self.sigmas[path] = float(sigma)
            else:
                limit = f"0 to {widest:.4g}, a third of the value"
                self._problem((*path, SIGMA), "out of bounds", f"{sigma:g}", limit, "give one standard deviation")
        return value

    def _problem(self, path: FieldPath, what: str, value: str = "", limit: str = "", remedy: str = "") -> None:
        line = self.tree.line_of(path)
        self.problems.append(Problem(self.file, line, dotted(path), what, value, limit, remedy))
