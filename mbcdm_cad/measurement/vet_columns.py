"""Test whether the columns contain what is declared: ratio, unit, sign and order of the columns, by robust slopes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import permutations

import numpy as np

from mbcdm_cad.measurement.run import SPEED_WINDOW_S, Run, VettingNote, column_of, doubt, refused, smoothed
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.routes import Floats

# A slope this near the declared ratio gives no finding; beyond FARTHEST it is another drive or another unit.
NEAR = 0.1
FARTHEST = 1.5
# Share of the samples' pairs that must agree on the sense of motion, for a slope to mean anything.
LEAST_AGREEMENT = 0.8
# No encoder has fewer counts a turn than this.
LEAST_COUNTS = 90.0
# Pairs of samples this share of the record apart give the slopes.
LAGS = (0.005, 0.02, 0.08)
# A lag at which the samples moved by less than this share of the most at any lag shows noise.
LEAST_MOVED = 0.02
# A load of this many times the load at which the cables go slack has a wrong unit.
MOST_LOAD = 3.0
# Limits of the drum's deflection over the least possible one; simulated runs of all effects have 1.3 to 3.
LEAST_GIVE, MOST_GIVE, FARTHEST_GIVE = 0.25, 25.0, 250.0
# Known mistakes in units: the factor by which an angle is too large, and the words for it.
SLIPS = (
    (180.0 / math.pi, "degrees declared as radians"),
    (2.0 * math.pi, "radians declared as turns"),
    (10800.0 / math.pi, "arc minutes declared as radians"),
    (360.0, "degrees declared as turns"),
    (1000.0, "mrad declared as rad"),
    (2.0, "counts_per_turn half of what it is"),
    (4.0, "counts_per_turn a quarter of what it is, as with edges counted"),
)
SLIP_WIDTH = 0.03


def robust_slope(x: Floats, y: Floats) -> tuple[float, float]:
    """Median of dy/dx over pairs of samples that are far apart in ``x``, and the share of pairs with its sign.

    Lost motion and noise affect only pairs around a reversal. Returns (0, 0) if ``x`` does not change.
    """
    slopes, steps = [], [max(1, int(lag * x.size)) for lag in LAGS]
    moved = [float(np.abs(x[step:] - x[:-step]).max(initial=0.0)) for step in steps]
    for step, most in zip(steps, moved, strict=True):
        dx, dy = x[step:] - x[:-step], y[step:] - y[:-step]
        # After whole periods of the motion, as in a run of 100 of them, there is noise alone.
        wide = np.abs(dx) > max(0.5 * most, LEAST_MOVED * max(moved))
        slopes.append(dy[wide] / dx[wide])
    slope = np.concatenate(slopes)
    if slope.size == 0:
        return 0.0, 0.0
    middle = float(np.median(slope))
    return middle, float(np.mean(np.sign(slope) == np.sign(middle))) if middle else 0.0


def column_findings(run: Run, ratio: float, travel_rad: float | None, d: DriveSI | None) -> Iterator[VettingNote]:
    """Refusals and doubts about the content of the columns."""
    factors = [_factor(run.output_rad, row, ratio) for row in run.input_rad]
    if all(factor is not None and abs(factor - 1.0) <= NEAR for factor in factors):
        size = _travel(run, travel_rad) or _load_size(run, d)
        # Of angles or a load in another unit the sign of the load says nothing.
        sign = None if size and size.level == "refused" else _load_sign(run, ratio, d)
        yield from (one for one in (size, sign) if one)
        return
    # At a ratio of 1 the exchange of the columns gives the same slope, and would not help.
    as_declared = all(factor is not None and abs(abs(factor) - 1.0) <= NEAR for factor in factors)
    if not as_declared and (swapped := _swapped(run, ratio)):
        yield swapped
        return
    if all(factor is not None and factor < 0.0 for factor in factors) and len(factors) > 1:
        # One wrong output is more likely than two wrong inputs.
        text = "the output turns against both inputs: its sign is reversed"
        yield refused("reversed_output", text, _TURN_ROUND, "columns", "output")
        factors = [None if factor is None else -factor for factor in factors]
    off = [factor for factor in factors if factor is not None and abs(abs(factor) - 1.0) > NEAR]
    if len(off) == len(factors) and max(off) < min(off) * (1.0 + NEAR):
        yield _off(off[0], run, ratio, travel_rad, None)
    else:
        for name, factor in zip(run.input_names, factors, strict=True):
            if factor is None:
                text = f"the output does not follow the {_shaft(name)}: no steady slope between the two"
                remedy = "check that both columns are of this drive and of one run, and their units"
                yield refused("unrelated", text, remedy, *column_of(name))
            elif abs(abs(factor) - 1.0) > NEAR:
                yield _off(abs(factor), run, ratio, travel_rad, name)
    for name, factor in zip(run.input_names, factors, strict=True):
        if factor is not None and factor < 0.0:
            text = f"the {_shaft(name)} turns against the output: the sign of one of the two is reversed"
            yield refused("reversed_input", text, _TURN_ROUND, *column_of(name))


REVERSED_LOAD = "set scale: -1 on load_torque (it is positive where it opposes positive rotation)"
_TURN_ROUND = "set scale: -1 on it (inputs are positive when they drive the drum positive)"


def _factor(output: Floats, shaft: Floats, ratio: float) -> float | None:
    """Slope of the input against the output over the declared ratio; None where there is no steady slope."""
    slope, agreement = robust_slope(output, shaft)
    return slope / ratio if slope and agreement >= LEAST_AGREEMENT else None


def _swapped(run: Run, ratio: float) -> VettingNote | None:
    """Whether two columns are exchanged: the exchange then gives the declared ratio for all slopes."""
    inputs, output = [column_of(name) for name in run.input_names], ("columns", "output")
    others = {"load_torque": run.load_Nm, "temperature": run.temperature_C}
    columns = {output: run.output_rad} | dict(zip(inputs, run.input_rad, strict=True))
    columns |= {("columns", name): row for name, row in others.items() if row is not None}
    for first, second in permutations(columns, 2):
        if first not in (output, *inputs) or (first in inputs and second in inputs):
            continue
        trial = {**columns, first: columns[second], second: columns[first]}
        factors = [_factor(trial[output], trial[field], ratio) for field in inputs]
        if all(factor is not None and abs(abs(factor) - 1.0) <= NEAR for factor in factors):
            text = f"columns of {first[1]} and {second[1]} look swapped: exchanged they give the declared ratio"
            remedy = "exchange the two column entries, or correct the ratio if the drive was driven from its output"
            return refused("swapped", text, remedy, *first)
    return None


def _off(factor: float, run: Run, ratio: float, travel_rad: float | None, name: str | None) -> VettingNote:
    """The finding for a slope of ``factor`` times the declared ratio; ``name`` is the input concerned."""
    fields = column_of(name if name is not None else run.input_names[0])
    shafts = "inputs" if name is None and len(run.input_names) > 1 else _shaft(name or run.input_names[0])
    figures = f"slope between {shafts} and output {factor * ratio:.5g}, declared ratio {ratio:.5g}"
    for size, slip in SLIPS:
        if abs(factor / size - 1.0) < SLIP_WIDTH or abs(factor * size - 1.0) < SLIP_WIDTH:
            large = factor > 1.0
            travel = float(np.ptp(run.output_rad))
            # A low factor means that the output is too large, unless its travel shows that the inputs are too small.
            at_output = not large and not (travel_rad is not None and travel <= travel_rad)
            where = "output" if at_output else shafts
            if not large and not at_output:
                slip = f"the reverse of {slip}"
            field = ("columns", "output") if at_output else fields
            text = f"{figures}: {where} too {'small' if not large and not at_output else 'large'} by {size:.4g}, {slip}"
            remedy = "correct unit, scale or counts_per_turn of that column"
            if run.ratio is not None:
                remedy += ", or ratio in this file"
            return refused("unit", text, remedy, *field)
    remedy = "check counts_per_turn, scale and unit, and that this is the drive of the design"
    turn = 2.0 * math.pi * max(factor, 1.0 / factor)
    if turn > LEAST_COUNTS:
        fields = fields if factor > 1.0 else ("columns", "output")
        remedy = f"are these counts, some {turn:.5g} a turn? Give unit: counts with counts_per_turn; or " + remedy
    if 1.0 / FARTHEST < factor < FARTHEST:
        return doubt("ratio", figures, remedy, *fields)
    return refused("ratio", figures, remedy, *fields)


def _travel(run: Run, travel_rad: float | None) -> VettingNote | None:
    """A finding for an output that turns farther than the stops allow: all angles may be in the wrong unit."""
    travel = float(np.ptp(run.output_rad))
    if travel_rad is None or travel <= 1.1 * travel_rad:
        return None
    text = f"the output turns by {travel:.4g} rad, the design by {travel_rad:.4g} rad between its stops"
    degrees = travel * math.pi / 180.0 <= 1.1 * travel_rad and travel > 10.0 * travel_rad
    in_degrees = "all angles look like degrees declared as radians: correct the units"
    return refused("travel", text, in_degrees if degrees else "check the units of all angles", "columns", "output")


def _load_size(run: Run, d: DriveSI | None) -> VettingNote | None:
    """A finding for a load far above the one at which the cables go slack: it may be in another unit."""
    if d is None or run.load_Nm is None:
        return None
    most = float(np.abs(run.load_Nm).max())
    # All cables of one sense at twice their preload, the others slack.
    holds = float(np.sum(d.preload_N * d.drum_radius_m))
    if most <= holds:
        return None
    text = f"loads up to {most:.4g} N m, but the preload of the cables holds only about {holds:.3g} N m"
    if most <= MOST_LOAD * holds:
        remedy = "cables go slack, or load_torque is in another unit or another column"
        return doubt("load", text, remedy, "columns", "load_torque")
    remedy = "check the unit of load_torque (mN*m declared as N*m?) and its scale"
    return refused("load", text, remedy, "columns", "load_torque")


def _load_sign(run: Run, ratio: float, d: DriveSI | None) -> VettingNote | None:
    """A finding for a drum that moves against its load: the sign of the torque is reversed."""
    if d is None or run.load_Nm is None or np.ptp(run.load_Nm) == 0.0:
        return None
    # The smallest compliance at the drum, nothing slipping: rad per N m.
    compliance = 1.0 / float(np.sum(d.axial_stiffness_N * d.drum_radius_m**2 / d.free_span_m))
    turned = run.input_rad.mean(axis=0) / ratio
    away = run.output_rad - turned
    # A late sensor adds a share of the speed, which may follow the load as closely as the deflection does.
    speed = smoothed(np.gradient(turned, run.time_s), SPEED_WINDOW_S, float(np.median(np.diff(run.time_s))))
    known = np.stack([np.ones_like(away), run.output_rad, speed], axis=1)
    basis = np.linalg.qr(known)[0]
    give, load = away - basis @ (basis.T @ away), run.load_Nm - basis @ (basis.T @ run.load_Nm)
    together = float(np.corrcoef(give, load)[0, 1]) if np.ptp(give) > 0.0 else 0.0
    share = float(give @ load / (load @ load)) / compliance
    if together < -0.7 and not LEAST_GIVE < -share < MOST_GIVE:
        return _wrong_give(-share)
    if together < 0.7 or share < 0.5:
        return None
    text = f"load_torque has the wrong sign: the drum moves against the load, {share:.2g} times its expected deflection"
    return refused("reversed_load", text, REVERSED_LOAD, "columns", "load_torque")


def _wrong_give(share: float) -> VettingNote:
    """The finding for a deflection of ``share`` times the expected one: all angles or the load in another unit."""
    text = f"the drum's deflection under load is {share:.2g} times that from the stretch of its cables"
    if share > 1.0:
        remedy = "check the unit of load_torque (N*m declared as mN*m?); or a coupling is very soft"
        level = doubt if share < FARTHEST_GIVE else refused
        return level("load", text, remedy, "columns", "load_torque")
    remedy = (
        "check the units of all angles (radians declared as degrees?), of load_torque, and modulus_GPa of the design"
    )
    return refused("unit", text, remedy, "columns", "output")


def _shaft(name: str) -> str:
    return "input" if name == "input" else f"{name} input"
