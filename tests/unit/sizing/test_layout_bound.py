"""The bound on drives without a guide: what it excludes and why; it does not exclude the references."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.support.layout_bound import Asked, excluding, least_column_mm

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
