"""Angles of the rigid chain and Eq. (1), (2)."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from paper_case import paper_drive

from mbcdm_cad.model.analysis import pair_mismatch
from mbcdm_cad.model.kinematics import eq1_residuals, shaft_angles, transmission_error
from mbcdm_cad.model.si import ModelError


def test_one_radian_of_the_drum() -> None:
    angles = shaft_angles(paper_drive(), "drum", 1.0, gear_ratio=76.0)
    assert float(angles["guide"]) == pytest.approx(-6.0)
    assert float(angles["input"]) == pytest.approx(9.0)
    assert float(angles["motor"]) == pytest.approx(684.0)


SHAFTS = ("drum", "guide", "input", "motor")


@given(st.sampled_from(SHAFTS), st.floats(-50, 50), st.integers(0, 3))
def test_every_angle_from_any(shaft: str, angle: float, cable: int) -> None:
    d = paper_drive()
    there = shaft_angles(d, shaft, angle, cable, 76.0)
    assert float(there[shaft]) == pytest.approx(angle, rel=1e-12, abs=1e-15)
    for other in SHAFTS:
        back = shaft_angles(d, other, there[other], cable, 76.0)
        assert float(back["drum"]) == pytest.approx(float(there["drum"]), rel=1e-12, abs=1e-15)


def test_unknown_shaft_is_refused() -> None:
    with pytest.raises(ModelError, match="use one of drum, guide, input, motor"):
        shaft_angles(paper_drive(), "wheel", 1.0)


def test_transmission_error_of_a_perfect_drive_is_zero() -> None:
    assert transmission_error(0.1, 0.9, 9.0) == pytest.approx(0.0, abs=1e-17)
    assert transmission_error(0.1002, 0.9, 9.0) == pytest.approx(2e-4)


@pytest.mark.parametrize("field", ["input_radius_m", "guide_radius_m", "drum_radius_m"])
@pytest.mark.parametrize("cable", [0, 1, 2, 3])
def test_eq1_residual_shows_a_wrong_radius(field: str, cable: int) -> None:
    d = paper_drive()
    radii = d.value(field).copy()
    radii[cable] *= 1.001
    residuals = eq1_residuals(d.with_(**{field: radii}))
    assert 4e-4 < residuals.worst < 1.1e-3, f"{field}[{cable}] + 0.1 %: worst residual {residuals.worst:.3g}"


def test_mismatch_in_newtons() -> None:
    """0.19 mm between two cables of one input is shared with the rest of the drive, and costs tens of newtons."""
    d = paper_drive()
    half = 0.405e-3
    wrong = d.with_(input_radius_m=d.input_radius_m + half, drum_radius_m=d.drum_radius_m + half)
    millimetres, newtons = pair_mismatch(wrong, np.radians(50.0))
    assert millimetres[0] == pytest.approx(0.176, abs=0.01)
    assert newtons > 20.0, f"largest change of tension {newtons:.3g} N"
    right_mm, right_N = pair_mismatch(d, np.radians(50.0))
    assert max(right_mm) < 1e-12 and right_N < 1e-9, f"{right_mm} mm, {right_N} N where Eq. (1) holds"
