"""Order spectrum: a line stands where it is and as high as it is; nothing else does, however sweeps meet the angles."""

from __future__ import annotations

import numpy as np
import pytest

from mbcdm_cad.loop.prepare.lines import MOST_ORDER, order_spectrum


def swept(samples: int = 16_000) -> np.ndarray:
    """Triangles at +-0.45 rad whose sweeps meet the same angles again, with 1 mrad of smooth rounding."""
    t = np.arange(samples) * 0.01
    return 0.45 * (2.0 / np.pi) * np.arcsin(0.998 * np.sin(2.0 * np.pi * 0.0625 * t))


def test_slow_trend_makes_no_fast_line() -> None:
    angle = swept()
    orders, amplitude = order_spectrum(angle, 1e-4 * np.sin(angle + 0.3))
    ghost = float(amplitude[orders > 100.0].max())
    assert ghost < 1e-8, f"a line of {ghost:.2g} rad where there is none"


@pytest.mark.parametrize("order", [45.0, 684.0, 2100.0])
def test_line_over_a_trend(order: float) -> None:
    angle = swept()
    orders, amplitude = order_spectrum(angle, 2e-5 * np.cos(order * angle + 1.0) + 1e-4 * np.sin(angle))
    fast = orders > 30.0
    k = int(np.argmax(np.where(fast, amplitude, 0.0)))
    assert abs(orders[k] - order) < 0.5 * 2.0 * np.pi / float(np.ptp(angle)), f"{orders[k]:.1f} for {order}"
    # At high orders a bin is a good part of a wave, and bins without a sample are filled from their neighbours.
    low = 0.5 if order > 2000.0 else 0.95
    assert low * 2e-5 < amplitude[k] < 1.02 * 2e-5, amplitude[k]


def test_no_order_beyond_what_is_looked_for() -> None:
    orders, _ = order_spectrum(swept(), np.zeros(16_000))
    assert orders[-1] <= MOST_ORDER
