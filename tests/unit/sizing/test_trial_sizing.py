"""The search of a field's value by checks: a check that no value meets does not prevent the others."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import pytest

from mbcdm_cad.layouts.siso_bevel.sizing import DirectKnown
from tests.support.layout_bound import Asked, excluding, least_column_mm


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


# The bound on drives without a guide: what it excludes and why; it does not exclude the references.


REFERENCES = {
    "siso_bevel": Asked(4.5, 58.05, 35.0, 0.98, "FF-081"),
    "siso_spur": Asked(9.9, 59.4, 35.0, 2.15, "FF-081"),
}


@pytest.mark.parametrize("layout", REFERENCES)
def test_a_reference_is_within_the_bound(layout: str) -> None:
    assert excluding(layout, REFERENCES[layout]) == ((), "")


@pytest.mark.parametrize(
    ("layout", "changed", "names", "why"),
    [
        ("siso_bevel", {"ratio": 5.0}, ("ratio", "travel"), "360 degrees"),
        ("siso_bevel", {"radius": 30.0}, ("radius",), "higher than the drum's radius"),
        ("siso_bevel", {"rope": "uhmwpe-2"}, ("ratio", "radius", "rope"), "the rope's stop"),
        # A 4 mm bearing would fit behind the drum, but no key passes it to the gearhead's screws.
        ("siso_bevel", {"ratio": 5.6, "radius": 43.5, "travel": 20.0, "rope": None}, ("ratio", "radius"), "no bearing"),
        ("siso_spur", {"rope": "7x7-1.0", "ratio": 14.0}, ("ratio", "radius", "rope"), "too thin for the bend"),
        ("siso_spur", {"surface": "smooth", "ratio": 13.0}, ("ratio", "radius", "rope", "surface"), "slope too much"),
        ("siso_spur", {"rope": "uhmwpe-0.8", "torque": 20.0}, ("radius", "torque", "rope"), "too weak"),
    ],
)
def test_what_excludes_itself_is_named(
    layout: str, changed: dict[str, float | str], names: tuple[str, ...], why: str
) -> None:
    found = excluding(layout, replace(REFERENCES[layout], **changed))  # type: ignore[arg-type]
    assert found[0] == names and why in found[1], found


def test_the_column_s_least_height_grows_with_wall_and_rope() -> None:
    thin, thick = least_column_mm(0.8, 0.3), least_column_mm(1.2, 2.0)
    # Three walls of 0.4 mm more, 0.2 mm of the shelf (at least 3 mm), and 0.85 mm of rope.
    assert thin == pytest.approx(41.3) and thick - thin == pytest.approx(3 * 0.4 + 0.2 + 0.85), f"{thin}, {thick}"
