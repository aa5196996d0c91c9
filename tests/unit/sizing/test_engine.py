"""Rules fill open fields, do not change stated ones, and record what they read."""

import pytest

from mbcdm_cad.design.sized import SizingError
from mbcdm_cad.sizing.known import KnownFields
from mbcdm_cad.sizing.rule import Found, Rule, constant, fill, largest, rounded_down, rounded_up

RULES = (
    constant("a.first", 2.0, "always two", "nothing"),
    Rule("a.second", "twice the first", "a", lambda given: Found(2 * given["a.first"], "b", "none")),
    Rule("b.third", "the second and what may be", "c", lambda given: given["a.second"] + given.get("b.extra", 0.0)),
    Rule("b.never", "not of this design", "d", lambda given: 1.0, applies=lambda given: False),
)


def test_rules_fill_in_order_and_say_what_they_rest_on() -> None:
    sizing = fill(KnownFields({}), RULES)
    assert sizing.data == {"a": {"first": 2.0, "second": 4.0}, "b": {"third": 4.0}}
    second, third = sizing.values[1:]
    assert (second.driver, dict(second.rests_on)) == ("b", {"a.first": 2.0})
    assert (third.driver, dict(third.rests_on)) == ("c", {"a.second": 4.0})


def test_what_is_given_is_a_pin_and_what_follows_rests_on_it() -> None:
    sizing = fill(KnownFields({"a": {"second": 7.0}, "b": {"extra": 0.5}}), RULES)
    assert sizing.of("a.second") is None
    third = sizing.of("b.third")
    assert third is not None and third.value == 7.5
    assert dict(third.rests_on) == {"a.second": 7.0, "b.extra": 0.5}


def test_a_rule_that_stands_too_early_is_found() -> None:
    with pytest.raises(KeyError, match=r"a\.second is not known"):
        fill(KnownFields({}), RULES[2:])


def test_the_need_that_sets_a_value_is_named() -> None:
    assert largest({"low": 1.0, "high": 2.01}, 0.5) == Found(2.5, "high", "up to 0.5")


@pytest.mark.parametrize(("value", "up", "down"), [(0.3, 0.3, 0.3), (0.30000001, 0.4, 0.3), (-1.05, -1.0, -1.1)])
def test_rounding_leaves_what_is_on_its_step(value: float, up: float, down: float) -> None:
    assert (rounded_up(value, 0.1), rounded_down(value, 0.1)) == (up, down)


def test_an_unknown_part_is_bad_input() -> None:
    given = KnownFields({"drive": {"motor": "none"}})
    with pytest.raises(SizingError) as refused:
        given.entry("motors", "drive.motor")
    (broken,) = refused.value.broken
    assert broken.path == ("drive", "motor") and "known here: motor-" in broken.remedy
