"""Exact Eq. (14): a root for every load, in its bracket, with the right limits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mbcdm_cad.model import equations as eq
from mbcdm_cad.model.si import ModelError

shares = st.floats(1e-6, 50.0)
kappas = st.floats(0.0, 20.0)


@given(shares, kappas)
def test_eq14_root_satisfies_the_equation(share: float, kappa: float) -> None:
    assume(share * (1.0 + kappa) < 600.0)  # beyond, T_l underflows to zero
    preload, radius = 70.0, 0.054
    load = share * 2 * preload * radius
    low, high = eq.eq14_tensions(load, preload, radius, kappa)
    residual = float(eq.eq14_residual(low, load, preload, radius, kappa)) / preload
    assert abs(residual) < 1e-14 * (1 + share) * (1 + kappa), f"x {share}, kappa {kappa}: residual {residual:.3g} T_pre"
    assert float(high - low) * 2 * radius == pytest.approx(load, rel=1e-9)
    assert 0.0 <= low < preload < high, f"T_l {low}, T_h {high}"


@given(shares)
def test_eq14_tends_to_the_simplified_form(share: float) -> None:
    load = share * 2 * 70.0 * 0.054
    low, _ = eq.eq14_tensions(load, 70.0, 0.054, 0.0)
    assert float(low) == pytest.approx(float(eq.eq17_low_tension(load, 70.0, 0.054)), rel=1e-12)


@given(st.floats(1e-3, 1.9))
def test_eq14_tends_to_a_frictionless_span_for_large_kappa(share: float) -> None:
    """kappa -> inf: all stretch is in the free span, so both sides change by half of the difference."""
    low, _ = eq.eq14_tensions(share * 2 * 70.0 * 0.054, 70.0, 0.054, 1e9)
    assert float(low) == pytest.approx(70.0 * (1 - share / 2), rel=1e-6)


def test_eq14_at_no_load_and_in_bulk() -> None:
    low, high = eq.eq14_tensions(np.zeros(3), 70.0, 0.054, 0.08)
    assert (low == 70.0).all() and (high == 70.0).all()
    loads = np.linspace(0.0, 30.0, 50)[:, None]
    kappa = np.array([0.0, 0.06, 0.4])
    bulk, _ = eq.eq14_tensions(loads, 70.0, 0.054, kappa)
    one_by_one = [[float(eq.eq14_tensions(float(m[0]), 70.0, 0.054, k)[0]) for k in kappa] for m in loads]
    worst = np.abs(bulk / np.array(one_by_one) - 1).max()
    assert worst < 1e-12, f"bulk differs from one by one by {worst:.3g}"


def test_eq14_refuses_a_negative_load() -> None:
    with pytest.raises(ModelError, match="load_Nm: -1 is negative"):
        eq.eq14_tensions(-1.0, 70.0, 0.054, 0.08)


def test_kappa_of_the_paper() -> None:
    assert eq.eq15_kappa(0.15, 31.18e-3, 54e-3, 6e-3) == pytest.approx(0.07795, abs=5e-6)
