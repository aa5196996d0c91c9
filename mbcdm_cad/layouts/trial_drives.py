"""Drives of trial data under test, each computed once: sizing runs many checks on drives that differ in one field.

Successive trials share most blocks, which are validated once. Many trials are the same drive: in the last pass, where
no value changes, the last trial of each field is the whole drive again.
"""

import marshal
from collections.abc import Callable, Iterable, Mapping
from math import inf
from typing import Any, NamedTuple

from pydantic import ValidationError

from mbcdm_cad.checks.comparison import Check
from mbcdm_cad.design.blocks import Design
from mbcdm_cad.design.fields import Block, PlainBlock, is_block, validated
from mbcdm_cad.layouts.base import Layout, NoFigureError

# A margin and its unit.
Margin = tuple[float, str]
NO_MARGIN: Margin = (-inf, "")


class Way(NamedTuple):
    """How a value of a field is searched: start, step with its sign, checks that it must pass."""

    field: str
    start: float
    step: float
    checks: tuple[str, ...]


class At(NamedTuple):
    """A trial of this search, with the next step in case no missing margin is a length."""

    value: float
    pace: float


class End(NamedTuple):
    """How a search ended: the checks that the value passes, and the last trial that failed, if there was one."""

    checks: tuple[str, ...]
    failing: At | None


class TrialDrives:
    """Makes drives under test from the data of whole files, and keeps them with the margins of their checks.

    ``schema``: schema of the configuration's files; ``of_design`` makes the design under test.
    """

    def __init__(self, schema: type[Design], of_design: Callable[[Any], Layout]) -> None:
        self._schema, self._of_design = schema, of_design
        self.ends: dict[Way, End] = {}
        # Parts that did not carry their load in a pass, in the design that followed from them; checks that were missed.
        self.refused: set[str] = set()
        # Numbers that went up and down in turn, with the larger of both values, from which they are searched upwards;
        # and whether the drum's web has no windows, as weighed once.
        self.held: dict[str, float] = {}
        # Passes of the sizing so far: before the first, values that are guessed say nothing about the drive.
        self.passes = 0
        self._kept: dict[bytes, tuple[Layout | None, dict[str, Margin]]] = {}
        self._last: tuple[Mapping[str, Any], Design] | None = None
        self._loaded: Layout | None = None

    def margins(
        self, data: dict[str, Any], checks: Iterable[str], known: Mapping[str, Check], to_first_miss: bool = False
    ) -> dict[str, Margin]:
        """Margin by check; minus infinity if a check has no figure there, or if the data describe no drive.

        ``to_first_miss``: the checks after the first that does not hold are left out. Raises ``SizingError`` if the
        file breaks a rule.
        """
        try:
            under_test, margins = self._looked_up(data)
        except NoFigureError:
            return dict.fromkeys(checks, NO_MARGIN)
        found = {}
        for name in checks:
            if name not in margins:
                margins[name] = _margin(known[name], under_test)
            found[name] = margins[name]
            if to_first_miss and found[name][0] < 0.0:
                break
        if under_test.has_loads:
            self._loaded = under_test
        return found

    def under_test(self, data: dict[str, Any]) -> Layout:
        """The drive of a file's whole data, under test.

        Raises ``NoFigureError`` if the data describe no drive, ``SizingError`` if the file breaks a rule.
        """
        return self._looked_up(data)[0]

    def _looked_up(self, data: dict[str, Any]) -> tuple[Layout, dict[str, Margin]]:
        # ``repr`` takes several times as long. In version 2, equal data give equal bytes.
        key = marshal.dumps(data, 2)
        if key not in self._kept:
            self._kept[key] = self._made(data), {}
        under_test, margins = self._kept[key]
        if under_test is None:
            raise NoFigureError("the values known so far describe no drive")
        return under_test, margins

    def _made(self, data: dict[str, Any]) -> Layout | None:
        try:
            found = self._of_design(self._design(data))
        except (NoFigureError, ValidationError):
            return None
        found.before = self._loaded
        return found

    def _design(self, data: dict[str, Any]) -> Design:
        """The design of a file's data; unchanged blocks are those of the design before."""
        changed = None if self._last is None else self._changed(self._last[0], data)
        if self._last is None or changed is None:
            design = self._schema.model_validate(data)
        else:
            design = self._last[1].model_copy(update=changed)
        self._last = data, design
        return design

    def _changed(self, before: Mapping[str, Any], now: Mapping[str, Any]) -> dict[str, Block | PlainBlock] | None:
        """The blocks that differ, validated; None if other content differs too."""
        if before.keys() != now.keys():
            return None
        found: dict[str, Block | PlainBlock] = {}
        for name, value in now.items():
            if value != before[name]:
                kind: Any = self._schema.model_fields[name].annotation
                if not is_block(kind):
                    return None
                found[name] = validated(kind, value)
        return found


def _margin(check: Check, under_test: Layout) -> Margin:
    """Infinite for a check that is not run on such a drive."""
    if not check.asked_of(under_test.drive):
        return inf, ""
    try:
        found = check.measure(under_test)
    except (NoFigureError, ValueError, ZeroDivisionError):
        return NO_MARGIN
    return max(found.margin, 0.0) if found.holds else min(found.margin, -1e-9), found.unit
