"""Runs sizing rules over the data of a design file."""

from collections.abc import Iterable

from mbcdm_cad.design.rules import Broken
from mbcdm_cad.design.sized import Moved, SizedValue, Sizing, SizingError
from mbcdm_cad.sizing.known import KnownFields
from mbcdm_cad.sizing.rule import Found, Rule


def fill(given: KnownFields, rules: Iterable[Rule], moved: Moved | None = None) -> Sizing:
    """Fill every open field for which a rule applies; fields of the file do not change.

    ``moved``: by field, a function with which a search changes the value of a rule; later rules use the changed value.
    """
    moved = moved or {}
    records: list[SizedValue] = []
    for rule in rules:
        if given.has(rule.field):
            continue
        if not rule.applies(given):
            given.leave_out(rule.field)
            continue
        given.start()
        try:
            found = rule.value(given)
        except (ValueError, ArithmeticError, IndexError) as error:
            path, why = tuple(rule.field.split(".")), f"no rule can fill it here ({error})"
            raise SizingError(
                Broken(path, why, "", "", f"state it in the file; its rule gives: {rule.text}", may_move=True)
            ) from None
        if not isinstance(found, Found):
            found = Found(found)
        if rule.field in moved:
            found = Found(moved[rule.field](found.value), found.driver, "moved")
        rests_on = given.read
        given.put(rule.field, found.value)
        records.append(
            SizedValue(rule.field, found.value, rule.text, found.driver or rule.driver, rests_on, found.rounding)
        )
    return Sizing(given.data, tuple(records))
