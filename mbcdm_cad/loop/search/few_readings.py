"""Few readings: their noise (what those that repeat each other scatter by, or what a line or a curve leaves), what is
left and on what it hangs, what they cannot test, their pictures."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.loop.prepare.prepared import Prepared
from mbcdm_cad.loop.readable import readable
from mbcdm_cad.loop.result import Noise, ReadingsPicture
from mbcdm_cad.loop.search.fit import Fit, FitRows, Fitter
from mbcdm_cad.loop.search.unknown import Unknown
from mbcdm_cad.measurement.by_hand import inputs_move, loadings
from mbcdm_cad.routes import Floats

# Readings repeat each other if inputs and load differ by less than this share of their range. So many degrees of
# freedom tell their scatter; with fewer it is taken from what lines over load and angle leave.
REPEATS_SHARE, FEWEST_REPEATS = 0.05, 4
# Degree of the curve over the logarithm of time beside which readings at rest scatter.
CURVE = 3
LOST_TRACK = (
    "the inputs turn round under a load that is made smaller before the next row: until then it had its old size, "
    "which no row says and the friction of the cables remembers; write a row before the load is made smaller, go from "
    "small loads to large ones, or log the motion"
)
HIDDEN_PLAY = (
    "its errors look like a play, but the load changes its sign between the rows, and where the pulleys of several "
    "inputs then come to rest within a play does not show in them: neither its place and size nor a stiffness beside "
    "it is told; log the motion instead, or keep the load on one side with a weight to read a stiffness alone"
)


def noise_of(fitter: Fitter, residual_rad: Floats, at_rest: bool) -> Noise:
    """Scatter of readings that repeat each other; never below the figures' steps.

    ``residual_rad``: what the declared model leaves of all readings.
    """
    f, declared = fitter, max(p.floor_rad for p in fitter.runs)
    squares, freedom = 0.0, 0
    for part, p in [] if at_rest else zip(f.parts, f.runs, strict=True):
        at = np.flatnonzero(p.used)
        residual, alike = residual_rad[part][at], _groups(p, at)
        for group in np.unique(alike):
            mine = residual[alike == group]
            squares, freedom = squares + float(np.sum((mine - mine.mean()) ** 2)), freedom + mine.size - 1
    source = f"{freedom} repeated readings"
    if freedom < FEWEST_REPEATS:
        left = _curve if at_rest else _lines
        rows = [left(residual_rad[part], p) for part, p in zip(f.parts, f.runs, strict=True)]
        squares, freedom = sum(one[0] for one in rows), sum(one[1] for one in rows)
        source = (
            "what a smooth curve over the logarithm of time leaves"
            if at_rest
            else "what lines over load, angle and direction leave, as too few readings repeat"
        )
    scatter = float(np.sqrt(squares / freedom)) if freedom > 0 else 0.0
    if scatter < declared:
        return Noise(declared, declared, 0.0, 0.0, declared, "the steps of the figures")
    return Noise(scatter, scatter, 0.0, 0.0, declared, source)


def _lines(residual_rad: Floats, p: Prepared) -> tuple[float, int]:
    """Sum of squares that lines over load, angle and direction leave, and its degrees of freedom."""
    at = np.flatnonzero(p.used)
    columns = [np.ones(at.size), p.mean_rad[at], p.sense[at], *([] if p.load_Nm is None else [p.load_Nm[at]])]
    x, y = np.stack(columns, axis=1), residual_rad[at]
    solved, _, rank, _ = np.linalg.lstsq(x, y, rcond=1e-9)
    return float(np.sum((y - x @ solved) ** 2)), max(0, at.size - int(rank))


def _curve(residual_rad: Floats, p: Prepared) -> tuple[float, int]:
    """The same for a cubic over the logarithm of the time since each step of the load."""
    squares, freedom, x, course = 0.0, 0, since(p), _course(p)
    for one in np.unique(course[p.used]):
        at = p.used & (course == one)
        degree = min(CURVE, int(at.sum()) - 3)
        if degree > 0:
            y = residual_rad[at]
            curve = np.polynomial.Polynomial.fit(x[at], y, degree)
            squares, freedom = squares + float(np.sum((y - curve(x[at])) ** 2)), freedom + y.size - degree - 1
    return squares, freedom


def since(p: Prepared) -> Floats:
    """Logarithm of the time since the last step of the load, (n,)."""
    times = np.array([at for at, _ in loadings(p.run)])
    since = p.time_s - times[np.maximum(_course(p) - 1, 0)]
    return np.asarray(np.log10(np.maximum(since, 1e-9)))


def _course(p: Prepared) -> NDArray[np.int64]:
    """Number of steps of the load before each sample, (n,)."""
    return np.searchsorted([at for at, _ in loadings(p.run)], p.time_s, side="left")


def _groups(p: Prepared, at: NDArray[np.int64]) -> NDArray[np.int64]:
    """A number for each of the samples ``at``, the same for readings that repeat each other."""
    columns = [p.mean_rad[at], p.sense[at], *([] if p.load_Nm is None else [p.load_Nm[at]])]
    groups = np.zeros(at.size, dtype=np.int64)
    for values in columns:
        order = np.argsort(values)
        apart = np.diff(values[order], prepend=values[order][0]) > REPEATS_SHARE * float(np.ptp(values))
        level = np.empty(at.size, dtype=np.int64)
        level[order] = np.cumsum(apart)
        groups = groups * (at.size + 1) + level
    return groups


@dataclass(frozen=True, eq=False)
class LeftOver(Unknown):
    """What no effect explains in few readings; ``hangs_on`` says on what it hangs, in words."""

    hangs_on: str = ""
    repeat: ClassVar[str] = "do it again, with other loads too, and see whether it repeats"

    def sentence(self) -> str:
        """For people."""
        _, (rms, peak) = readable("_rad", [self.rms_rad, self.peak_rad])
        return f"{rms} RMS, {peak} at most; {self.hangs_on}"


def not_testable(fitter: Fitter, declared: bool, at_rest: bool) -> tuple[str, ...]:
    """What such readings cannot show; ``declared``: a design is known, not only a ratio."""
    if at_rest:
        words = ["the inputs rest: errors of angle, friction, and all that needs motion"]
        loads = [p.run for p in fitter.runs if p.run.load_Nm is not None and p.run.load_Nm.any()]
        if loads and all(len(loadings(run)) < 2 for run in loads):
            words.append("the load stays on: whether the creep goes back")
        return tuple(words)
    words = ["one value a half cycle: ripple, delays, and what happens within a half cycle"]
    if not fitter.test.any():
        words.append("too few half cycles: none can be held back to judge a fit on the others")
    if any(p.load_Nm is None for p in fitter.runs):
        words.append("no load: stiffness, preload and friction of the cables; a play and a friction look alike")
    if not declared:
        words.append("only the ratio is known: pulleys, preload and ropes")
    return tuple(words)


def pictures_of(fitter: Fitter, ratio: float, whole: Fit, at_rest: bool) -> tuple[ReadingsPicture, ...]:
    """Each run's readings over the load, or over the angle where none was read."""
    found, bare = [], fitter.fit(rows=FitRows(fitter.used))
    for part, p in zip(fitter.parts, fitter.runs, strict=True):
        if at_rest:
            at = np.maximum(p.time_s - min(0.0, float(p.run.time_s[0])), 0.0)[p.used]
            read = (p.output_rad - p.mean_rad / ratio)[p.used]
            read = read - read[0]
            words = "Dots are the readings, of a logger their means; lines the model at their times."
            found.append(
                ReadingsPicture(
                    p.run.source,
                    "output - inputs / ratio",
                    words,
                    "time since loading (s)",
                    at,
                    read,
                    p.held[p.used].astype(float),
                    at,
                    read - bare.residual[part][p.used],
                    read - whole.residual[part][p.used],
                    True,
                )
            )
            continue
        moves = inputs_move(p.run)
        base = p.mean_rad / ratio if moves else np.zeros_like(p.output_rad)
        at, axis = (1e3 * base, "inputs / ratio (mrad)") if p.load_Nm is None else (p.load_Nm, "load torque (N m)")
        title = "output - inputs / ratio" if moves else "output"
        read = p.output_rad - base
        read = read - np.median(read[p.used])
        words = "Dots are the rows of the table, lines the model on its way from row to row."
        before, after = (read - one.residual[part] for one in (bare, whole))
        used = p.used
        held = p.held[used].astype(float)
        shown = at[used], read[used], held, at, before, after
        found.append(ReadingsPicture(p.run.source, title, words, axis, *shown))
    return tuple(found)
