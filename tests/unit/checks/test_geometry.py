"""Plane geometry of the checks, compared with sampling and with values computed by hand."""

from dataclasses import replace
from math import hypot, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbcdm_cad.checks.geometry import Ring, corner_gap, inside_rounded_rectangle, polygon_gap, web_between
from mbcdm_cad.checks.size import envelope_check, interference_check, mass_check
from mbcdm_cad.design.blocks import Waiver
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.miso_bevel.checks.room import Upright, ring_gap

coordinate = st.floats(-10.0, 10.0)


def box(x: float, y: float, w: float, h: float, turn: float) -> np.ndarray:
    corners = np.array([(-w, -h), (w, -h), (w, h), (-w, h)]) / 2
    c, s = np.cos(turn), np.sin(turn)
    return corners @ np.array([[c, s], [-s, c]]) + (x, y)


def filled(polygon: np.ndarray, n: int = 25) -> np.ndarray:
    u, v = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n))
    a, b, c, d = polygon
    return (
        np.multiply.outer(((1 - u) * (1 - v)).ravel(), a)
        + np.multiply.outer((u * (1 - v)).ravel(), b)
        + np.multiply.outer((u * v).ravel(), c)
        + np.multiply.outer(((1 - u) * v).ravel(), d)
    )


@given(coordinate, coordinate, st.floats(0.5, 5.0), st.floats(0.5, 5.0), st.floats(0.0, 3.0))
def test_polygon_gap_against_sampling(x: float, y: float, w: float, h: float, turn: float) -> None:
    first, second = box(0.0, 0.0, 3.0, 2.0, 0.3), box(x, y, w, h, turn)
    gap = polygon_gap(first, second)
    sampled = np.linalg.norm(filled(first)[:, None] - filled(second)[None], axis=2).min()
    assert gap <= sampled + 1e-9, (gap, sampled)
    # No point of either lies further than half a diagonal of its cell from a sample.
    cell = hypot(3.0, 2.0) / 48 + hypot(w, h) / 48
    assert gap >= sampled - cell - 1e-9, (gap, sampled, cell)


def test_corner_of_a_pocket() -> None:
    assert corner_gap(0.0, 5.0, 10.0, 0.0, 2.0) == 5.0
    assert corner_gap(9.5, 5.0, 10.0, 0.0, 2.0) == 0.5
    assert corner_gap(9.0, 1.0, 10.0, 0.0, 2.0) == pytest.approx(2.0 - sqrt(2.0))
    assert corner_gap(10.0, 0.0, 10.0, 0.0, 2.0) == pytest.approx(2.0 - 2.0 * sqrt(2.0))


def test_rounded_rectangle() -> None:
    assert inside_rounded_rectangle(0.0, 0.0, 10.0, -4.0, 6.0, 2.0) == 4.0
    assert inside_rounded_rectangle(-9.0, 0.0, 10.0, -4.0, 6.0, 2.0) == 1.0
    assert inside_rounded_rectangle(9.0, 5.0, 10.0, -4.0, 6.0, 2.0) == pytest.approx(2.0 - sqrt(2.0))
    assert inside_rounded_rectangle(10.0, 6.0, 10.0, -4.0, 6.0, 2.0) < 0.0


def test_webs_leave_out_holes_on_one_axis_and_at_other_depths() -> None:
    holes = [("a", 0.0, 0.0, 1.0, 0.0, 2.0), ("b", 0.0, 0.0, 2.0, 0.0, 1.0), ("c", 5.0, 0.0, 1.0, 1.5, 3.0)]
    assert web_between(holes) == [("a to c", 3.0)]


@given(
    st.floats(20.0, 60.0),
    st.floats(-3.0, 0.0),
    st.floats(1.0, 12.0),
    st.floats(-40.0, 40.0),
    st.floats(1.0, 40.0),
    st.floats(-2.0, 12.0),
)
def test_ring_and_upright_never_meet_where_a_gap_is_promised(
    x: float, back: float, radius: float, low: float, height: float, y: float
) -> None:
    ring, body = Ring("ring", 40.0, 50.0, y, 50.0), Upright("body", x, back, radius, low, low + height)
    if ring_gap(ring, body, 0.1) < 0.1:
        return
    angle = np.linspace(0.0, 2 * np.pi, 73)
    for share in np.linspace(0.05, 1.0, 20):
        px, py = x + share * radius * np.cos(angle), back + share * radius * np.sin(angle)
        for z in np.linspace(low, low + height, 31):
            r = np.hypot(px, z)
            inside = (py > y) & (r > 40.0) & (r < 50.0)
            assert not inside.any(), (ring, body, z)


@pytest.mark.parametrize(("mass", "status"), [(340.0, "pass"), (360.0, "pass"), (339.9, "fail"), (360.1, "fail")])
def test_mass(mass: float, status: str, drive: Drive) -> None:
    found = mass_check(drive, mass, 4.0)
    assert found.status == status and found.actual == pytest.approx(abs(mass - 350.0)), found
    assert "+- 4" in found.message and "342" in found.message, found.message


@pytest.mark.parametrize(("z", "status"), [(97.5, "pass"), (96.5, "pass"), (97.51, "fail"), (96.49, "fail")])
def test_envelope(z: float, status: str, drive: Drive) -> None:
    found = envelope_check(drive, (126.02, z, 34.8))
    assert found.status == status and found.actual == pytest.approx(abs(z - 97.0)) and "Z from" in found.message, found


def test_interference(drive: Drive) -> None:
    assert interference_check(drive, ()).status == "pass"
    found = interference_check(drive, ("a and b overlap", "c and d overlap"))
    assert found.status == "fail" and found.actual == 2.0 and "a and b overlap; c and d overlap" in found.message, found
    many = interference_check(drive, ["x"] * 9)
    assert many.message.count("x;") == 3, many.message


def test_waiver_reaches_them(drive: Drive) -> None:
    waived = replace(drive, waivers=(Waiver(check="mass", reason="a steel drum on purpose"),))
    found = mass_check(waived, 400.0, 4.0)
    assert found.status == "pass" and found.waived_reason == "a steel drum on purpose", found
