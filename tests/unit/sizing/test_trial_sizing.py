"""The search of a field's value by checks: a check that no value meets does not prevent the others."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest

from mbcdm_cad.layouts.siso_bevel.sizing import DirectKnown


class Margins(DirectKnown):
    """Margins of a field by formula: ``near`` from 3 mm on, ``far`` from 5, ``never`` at no value."""

    def margins(
        self, field: str, value: Any, checks: Iterable[str], to_first_miss: bool = False
    ) -> dict[str, tuple[float, str]]:
        known = {"near": value - 3.0, "far": value - 5.0, "never": -20.0 - value, "below": 4.0 - value}
        return {name: (known[name], "mm") for name in checks}


@pytest.mark.parametrize(
    ("checks", "value", "words"),
    [
        (("near", "far"), 5.0, "up to 0.1"),
        (("near", "never"), 3.0, "no value meets never"),
        # Each holds somewhere, both nowhere: the value that misses least.
        (("far", "below"), 5.0, "no value passes"),
    ],
)
def test_moved(checks: tuple[str, ...], value: float, words: str) -> None:
    found = Margins({}, {}).moved("drum.hub_diameter_mm", 1.0, 0.1, checks)
    assert found.value == pytest.approx(value) and words in found.rounding, found


def test_a_check_left_out_in_a_pass_before_is_not_named_when_it_holds() -> None:
    """What no value met in the first pass may hold once the fields it depends on are known."""
    known = Margins({}, {})
    assert "no value meets never" in known.moved("drum.hub_diameter_mm", 1.0, 0.1, ("near", "never")).rounding
    known.margins = lambda field, value, checks, to_first_miss=False: dict.fromkeys(checks, (value - 3.0, "mm"))  # type: ignore[method-assign,misc]
    found = known.moved("drum.hub_diameter_mm", 1.0, 0.1, ("near", "never"))
    assert found.value == pytest.approx(3.0) and "never" not in found.rounding, found


@pytest.mark.parametrize(
    ("checks", "value", "words"),
    [
        (("near", "far"), 6.0, "first that does"),
        (("near", "never"), 4.0, "no candidate meets never"),
        (("never",), 1.0, "no candidate does"),
    ],
)
def test_first(checks: tuple[str, ...], value: float, words: str) -> None:
    found = Margins({}, {}).first("drum.bearing", (1.0, 2.0, 4.0, 6.0), checks)
    assert found.value == value and words in found.rounding, found


def test_first_of_nothing_is_told() -> None:
    with pytest.raises(ValueError, match="no entry that fits"):
        Margins({}, {}).first("drum.bearing", (), ("near",))
