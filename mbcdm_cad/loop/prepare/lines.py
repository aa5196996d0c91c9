"""Orders in angle: the part of a residual that repeats N times for a turn of the drum, and which peak is a line.

A broad hump or a local texture has peaks in the spectrum too, and a plain false-alarm probability takes them for lines.
A line caused by a rotating part is steady from sweep to sweep and present in every sector. Each sweep gives one pair
(cos, sin) of it, and Hotelling's T^2 tests whether their mean is zero, corrected for the number of orders that the
search could have chosen. Then each sector must show the line at the phase of the whole.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import f as f_distribution

from mbcdm_cad.loop.prepare.setup import Setup
from mbcdm_cad.routes import Floats

# The lowest order in the search makes this many cycles over the travel; a lower one is a trend.
LEAST_CYCLES = 2.5
MOST_ORDER = 4000.0
# A line must exceed by this factor the amplitude that the encoders' own steps can cause at its order.
STEP_LINE_MARGIN = 1.5
# Probability of a false line over all orders searched.
LINE_ALPHA = 0.01
# A sector shows the line if its part at the phase of the whole is at least this share of the whole's amplitude.
LEAST_IN_SECTOR = 0.35
# Cycles that a sector or a sweep must hold to say anything about a line.
LEAST_CYCLES_IN_PART = 1.5
LEAST_SAMPLES_IN_PART = 12
# The travel is divided into as many sectors as can hold these cycles, up to this number.
MOST_SECTORS = 8


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


def strongest_orders(setup: Setup, residual: Floats, most: int = 2) -> list[float]:
    """The orders with the highest peaks, more than two cycles a travel apart, without those of the encoders' steps."""
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
        if len(found) == most:
            break
    return found


@dataclass(frozen=True, eq=False)
class OrderVerdict:
    """Verdict on one order.

    ``probability`` of so steady a line by chance, over all orders searched (at most 1); ``sectors``: the part of the
    line in each sector of the travel, as a share of the whole; ``amplitude`` in the residual's unit.
    """

    order: float
    amplitude: float
    probability: float
    sectors: Floats

    @property
    def steady(self) -> bool:
        """Whether the line is the same in every sweep."""
        return self.probability <= LINE_ALPHA

    @property
    def everywhere(self) -> bool:
        """Whether the line is in every sector; true for a line of few cycles, which has no sectors to compare."""
        return bool(np.all(self.sectors >= LEAST_IN_SECTOR))

    @property
    def is_line(self) -> bool:
        """Whether the order is a line: steady, and in every sector."""
        return self.steady and self.everywhere


def line_of(
    order: float, angle_rad: Floats, residual: Floats, sweep: NDArray[np.int64], most_order: float = MOST_ORDER
) -> OrderVerdict:
    """Test one order (cycles a turn of the drum); arrays (n,), samples in use only.

    The search could have chosen any order up to ``most_order``: 2 x travel (in turns) x ``most_order`` trials. The wave
    is fitted together with a constant and a slope, over all samples, in each sweep and in each sector.
    """
    wave = np.stack([np.cos(order * angle_rad), np.sin(order * angle_rad)], axis=1)
    travel = float(np.ptp(angle_rad))
    trials = max(1.0, 2.0 * travel / (2.0 * np.pi) * most_order)
    whole = _amplitudes(wave, angle_rad, residual)
    amplitude = float(np.hypot(*whole))
    pairs = []
    for one in np.unique(sweep):
        chosen = sweep == one
        cycles = order * float(np.ptp(angle_rad[chosen])) / (2.0 * np.pi)
        if chosen.sum() >= LEAST_SAMPLES_IN_PART and cycles >= LEAST_CYCLES_IN_PART:
            pairs.append(_amplitudes(wave[chosen], angle_rad[chosen], residual[chosen]))
    probability = min(1.0, trials * hotelling(np.array(pairs).reshape(-1, 2)))
    shares = []
    places = int(min(order * travel / (2.0 * np.pi) / LEAST_CYCLES_IN_PART, MOST_SECTORS))
    place = np.minimum((angle_rad - angle_rad.min()) / travel * places, places - 1).astype(np.int64)
    for one in range(places):
        chosen = place == one
        if chosen.sum() < LEAST_SAMPLES_IN_PART or amplitude == 0.0:
            continue
        part = _amplitudes(wave[chosen], angle_rad[chosen], residual[chosen])
        shares.append(float(part @ whole) / amplitude**2)
    return OrderVerdict(order, amplitude, probability, np.array(shares))


def _amplitudes(wave: Floats, angle_rad: Floats, residual: Floats) -> Floats:
    """(cos, sin) of a line by least squares, together with a constant and a slope."""
    columns = np.column_stack([wave, np.ones(angle_rad.size), angle_rad - angle_rad.mean()])
    return np.asarray(np.linalg.lstsq(columns, residual, rcond=1e-10)[0][:2], dtype=float)


def hotelling(pairs: Floats) -> float:
    """Probability that the mean of ``pairs``, shape (s, 2), is off zero by chance: Hotelling's T^2; 1 if s < 4."""
    count = pairs.shape[0]
    if count < 4:
        return 1.0
    mean = pairs.mean(axis=0)
    covariance = np.cov(pairs, rowvar=False)
    determinant = float(np.linalg.det(covariance))
    if determinant <= 0.0:
        return 0.0 if mean.any() else 1.0
    t_squared = count * float(mean @ np.linalg.solve(covariance, mean))
    return float(f_distribution.sf((count - 2) / (2.0 * (count - 1)) * t_squared, 2, count - 2))
