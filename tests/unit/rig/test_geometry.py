"""Tangent geometry against the figures of the mechanism and against a path measured on drawn circles."""

from __future__ import annotations

from math import degrees

import numpy as np
import pytest

from mbcdm_cad.configurations.loader import load_design
from mbcdm_cad.rig.cables import cables_of


@pytest.fixture(scope="module")
def cables(project):
    return cables_of(load_design(project / "params" / "mbcdm.yaml").drive)


def test_spans_and_guide_wraps_of_the_reference_design(cables):
    assert [round(c.path.free_span_m * 1e3, 2) for c in cables] == [31.18, 30.68, 30.14, 29.55]
    assert [round(degrees(c.path.guide_wrap_rad), 1) for c in cables] == [25.7, 207.5, 29.4, 211.3]


@pytest.mark.parametrize("which", ["guide", "input", "drum"])
def test_small_displacements_change_the_path_by_e_dot_u(cables, which):
    e = np.array([[3e-6], [-5e-6]])
    zero = np.zeros((2, 1))
    for c in cables:
        t = np.array(c.path.direction)
        u = {"guide": t - np.array([c.path.drum_side, 0.0]), "input": -t, "drum": np.array([c.path.drum_side, 0.0])}
        moved = c.path.moved_m(
            e if which == "guide" else zero, e if which == "input" else zero, e[0] if which == "drum" else np.zeros(1)
        )
        assert moved[0] == pytest.approx(u[which] @ e[:, 0], abs=2e-9), c.name


def test_large_displacement_is_the_length_of_a_taut_string(cables):
    """The shortest string round both circles, found by trying all directions of its span."""
    c = cables[1]
    r_g, r_i = c.guide_radius_m, c.input_radius_m
    e = np.array([[4e-4], [-7e-4]])

    def string(centre):
        # The span's direction t: the string leaves the input and lands on the guide where t touches each.
        beta = np.linspace(-0.2, 0.2, 400001)
        angle = np.arctan2(c.path.direction[1], c.path.direction[0]) + beta
        t = np.stack([np.cos(angle), np.sin(angle)])
        left = np.stack([-t[1], t[0]])
        gap = -c.path.rho * r_g * left - (centre[:, None] + c.path.rho * r_i * left)
        best = np.argmin(np.abs((gap * left).sum(0)))
        return (gap * t).sum(0)[best] - c.path.rho * (r_g + r_i) * beta[best]

    still = np.array(c.path.centre_m)
    expected = string(still + e[:, 0]) - string(still)
    found = c.path.moved_m(np.zeros((2, 1)), e, np.zeros(1))[0]
    assert found == pytest.approx(expected, abs=2e-8), f"{found} against {expected} m"
