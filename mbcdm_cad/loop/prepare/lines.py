"""Orders in angle: the part of a residual that repeats N times for a turn of the drum."""

from functools import lru_cache
from typing import Any

import numpy as np

from mbcdm_cad.loop.prepare.setup import Setup
from mbcdm_cad.routes import Floats

# The lowest order in the search makes this many cycles over the travel; a lower one is a trend.
LEAST_CYCLES = 2.5
MOST_ORDER = 4000.0
# A line must exceed by this factor the amplitude that the encoders' own steps can cause at its order.
STEP_LINE_MARGIN = 1.5


def order_spectrum(angle_rad: Floats, residual: Any) -> tuple[Floats, Floats]:
    """(cycles a turn, amplitude in the residual's unit) over the travel covered; binned in angle, then an FFT.

    Shapes (m,). The bins are a quarter of the shortest wave in the search, or wider where the samples are too few. Bins
    hold means, since samples are spaced unevenly (sweeps dwell at some angles, and pass the same ones again), and a
    Hann window keeps a slow trend from leaking into every order. Empty if the angle does not change.
    """
    low, span = float(angle_rad.min()), float(np.ptp(angle_rad))
    if span == 0.0:
        return np.empty(0), np.empty(0)
    bins = int(min(4.0 * MOST_ORDER * span / (2.0 * np.pi), angle_rad.size / 4.0)) + 8
    index = np.minimum(((angle_rad - low) / span * bins).astype(np.int64), bins - 1)
    count = np.bincount(index, minlength=bins)
    full = np.flatnonzero(count)
    window = np.hanning(bins)
    # Zero padding makes the grid of orders four times finer than one cycle a travel.
    length = 4 * bins
    half = length // 2 + 1

    def lines(values: Floats) -> Any:
        mean = np.interp(np.arange(bins), full, np.bincount(index, values, bins)[full] / count[full])
        mean = (mean - float((window * mean).sum() / window.sum())) * window
        return np.fft.fft(mean, length) / window.sum()

    if np.iscomplexobj(residual):
        both = np.abs(lines(residual.real) + 1j * lines(residual.imag))
        amplitude = np.maximum(both[:half], both[-np.arange(half)])
    else:
        amplitude = 2.0 * np.abs(lines(residual)[:half])
    orders = np.arange(amplitude.size) * bins / length * 2.0 * np.pi / span
    keep = (orders * span / (2.0 * np.pi) >= LEAST_CYCLES) & (orders <= min(MOST_ORDER, bins * np.pi / span))
    return orders[keep], amplitude[keep]


@lru_cache(maxsize=4)
def step_lines(setup: Setup) -> Floats:
    """Amplitude (rad) that the inputs' encoder steps can cause at each order of the spectrum; shape of its orders.

    The sawtooth of the steps has far more cycles a turn than any order in the search, but at steady speed the sampling
    aliases it to a lower order, where it is as steady as a true line.
    """
    p, used = setup.p, setup.p.used
    total: Floats | float = 0.0
    for index in range(setup.p.angle_rad.shape[0]):
        turns = 2.0 * np.pi * setup.input_shaft_rad(index)[used] / p.input_step_rad
        for harmonic in (1, 2, 3):
            height = p.input_step_rad / (np.pi * harmonic) / setup.ratio / setup.p.angle_rad.shape[0]
            total = total + height * order_spectrum(setup.drum_rad[used], np.exp(1j * harmonic * turns))[1]
    return np.asarray(total)


def strongest_orders(setup: Setup, residual: Floats) -> list[float]:
    """The two orders with the highest peaks, more than two cycles a travel apart; steps of encoders do not count."""
    used = setup.p.used
    angle, values = setup.drum_rad[used], residual[used]
    orders, amplitude = order_spectrum(angle, values - values.mean())
    if orders.size == 0:
        return []
    if setup.p.input_step_rad > 0.0:
        amplitude = np.where(amplitude > STEP_LINE_MARGIN * step_lines(setup), amplitude, 0.0)
    found: list[float] = []
    near = 2.0 * 2.0 * np.pi / float(np.ptp(angle))
    for k in np.argsort(amplitude)[::-1][:200]:
        if amplitude[k] > 0.0 and all(abs(orders[k] - other) > near for other in found):
            found.append(float(orders[k]))
        if len(found) == 2:
            break
    return found
