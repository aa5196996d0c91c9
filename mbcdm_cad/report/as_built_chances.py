"""The probability that each check passes on the drive as built, from what the loop found and how well it knows it.

The values that were found (modulus, preload, friction) are normal with their intervals and correlations. The margin of
each check is taken as straight over one standard deviation to either side of each value. Source: derived; the test
draws the values at random instead.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import erf, sqrt

import numpy as np

from mbcdm_cad.design.as_built import CHANGE_VALUES, HALF_95, with_as_built
from mbcdm_cad.design.blocks import AsBuilt, AsBuiltValue
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.routes import Floats

# Probabilities beyond these are told as certain, and only counted.
UNSURE = (0.001, 0.999)


@dataclass(frozen=True)
class Chance:
    """The probability that one check passes."""

    check: str
    title: str
    probability: float


def chances_of(drive: Drive, found: Sequence[AsBuilt]) -> tuple[Chance, ...]:
    """Probabilities of all checks; empty where no value with an interval was found. ``drive`` is as built already."""
    known = [(k, entry) for k, entry in enumerate(found) if _deviation(entry) > 0.0]
    if not known:
        return ()
    middle = _margins(drive)
    slopes: dict[str, list[float]] = {name: [] for name in middle}
    for _, entry in known:
        step = _deviation(entry) / (1.0 + _share(entry).value)
        up, down = (_margins(_moved(drive, entry, sign * step)) for sign in (1.0, -1.0))
        for name in slopes:
            slopes[name].append(0.5 * (up.get(name, np.nan) - down.get(name, np.nan)))
    correlation = _correlations(known)
    chances = []
    for check in checks_of(drive):
        slope = np.array(slopes.get(check.id, [np.nan]))
        if check.id not in middle or not np.isfinite(slope).all():
            continue
        deviation = float(np.sqrt(max(0.0, slope @ correlation @ slope)))
        margin = middle[check.id]
        # The normal distribution by its error function: SciPy would make every check of a design slow to start.
        passes = float(margin >= 0.0) if deviation == 0.0 else 0.5 * (1.0 + erf(margin / deviation / sqrt(2.0)))
        chances.append(Chance(check.id, check.title, passes))
    return tuple(chances)


def chance_lines(chances: Sequence[Chance]) -> Iterator[str]:
    """For a terminal: the checks that neither pass nor fail for certain, and how many do."""
    if not chances:
        return
    low, high = UNSURE
    unsure = [one for one in chances if low < one.probability < high]
    passing, failing = (sum(one.probability >= high for one in chances), sum(one.probability <= low for one in chances))
    yield (
        f"as built, within what the loop knows: {passing} checks pass and {failing} fail with a probability over "
        f"{high:.1%}" + ("; of the others:" if unsure else "")
    )
    for one in sorted(unsure, key=lambda one: one.probability):
        yield f"  {one.check} passes with {one.probability:.1%} ({one.title})"


def _margins(drive: Drive) -> dict[str, float]:
    """The margin of each check that has a figure and a limit."""
    found = {}
    with np.errstate(all="ignore"):
        for check in checks_of(drive):
            try:
                compared = check.measure(drive.layout)
            except (NoFigureError, ModelError):
                continue
            if compared.sense and np.isfinite(compared.actual) and np.isfinite(compared.limit):
                found[check.id] = float(compared.margin)
    return found


def _share(entry: AsBuilt) -> AsBuiltValue:
    return next(value for value in entry.values if value.name == "share")


def _deviation(entry: AsBuilt) -> float:
    """Standard deviation of the share that an entry changes a value of the design by; 0 for other entries."""
    if entry.form not in CHANGE_VALUES.get(entry.name, ()):
        return 0.0
    share = _share(entry)
    return 0.0 if share.low is None or share.high is None else (share.high - share.low) / (2.0 * HALF_95)


def _moved(drive: Drive, entry: AsBuilt, share: float) -> Drive:
    """The drive with the value of an entry changed by a further share."""
    return with_as_built(drive, (replace(entry, values=(AsBuiltValue(name="share", value=share),)),))


def _correlations(known: Sequence[tuple[int, AsBuilt]]) -> Floats:
    """Correlations of the shares of the entries, given by their number in the file."""
    found = np.eye(len(known))
    at = {number: k for k, (number, _) in enumerate(known)}
    for k, (_, entry) in enumerate(known):
        for one in entry.correlated:
            if one.own == one.other == "share" and one.entry in at:
                found[k, at[one.entry]] = found[at[one.entry], k] = one.correlation
    return found
