"""What a run alone shows: faults of its signals, and what its travel, loads, sweeps and columns can and cannot show."""

import math
from collections.abc import Iterator, Sequence
from itertools import permutations

import numpy as np
from scipy.linalg import LinAlgError, eigh

from mbcdm_cad.design.yamltree import FieldPath
from mbcdm_cad.measurement.loads import LEAST_TOLD
from mbcdm_cad.measurement.run import BesideSensor, Run, VettingNote, column_of, doubt, fact, refused
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.routes import Floats

# A step in time this many times the usual one is a gap.
GAP_STEPS = 5.0
# A sensor that stays at its extreme value while the drive moves by this share of the travel is saturated.
LOST_TRAVEL = 0.15
# Limits of usual sample times and half sweeps on a bench: estimates.
SLOW_STEP_S, SLOW_SWEEP_S, FAST_SWEEP_S = 1.0, 600.0, 0.1
COLDEST_C, HOTTEST_C = -60.0, 120.0
# Share of the samples in which a noisy torque may be exactly at its extreme value.
LEVEL_SHARE = 0.005

WRAPPED = "set wraps_at of this column: 360 for degrees, counts_per_turn for one turn, 65536 for 16 bits"


def signal_findings(run: Run, ratio: float) -> Iterator[VettingNote]:
    """Doubts and refusals."""
    inputs = [(column_of(name), row) for name, row in zip(run.input_names, run.input_rad, strict=True)]
    angles = [*inputs, (("columns", "output"), run.output_rad)]
    yield from _gaps(run)
    yield from _pace(run)
    low, high = (0.0, 0.0) if run.temperature_C is None else (run.temperature_C.min(), run.temperature_C.max())
    if low < COLDEST_C or high > HOTTEST_C:
        remedy = "check its unit (K or degF declared as degC?)"
        yield doubt("temperature", f"temperatures of {low:.4g} to {high:.4g} degC", remedy, "columns", "temperature")
    for field, values in angles:
        yield from _jumps(field, values, run)
    for field, values in inputs:
        yield from _stands(field, values, run.output_rad)
    yield from _stands(("columns", "output"), run.output_rad, run.input_rad.mean(axis=0) / ratio)
    if run.load_Nm is not None:
        yield from _levels(run.load_Nm)


def _gaps(run: Run) -> Iterator[VettingNote]:
    steps = np.diff(run.time_s)
    gaps = np.flatnonzero(steps > GAP_STEPS * run.step_s)
    if gaps.size:
        longest = int(gaps[np.argmax(steps[gaps])])
        text = (
            f"{gaps.size} gap(s) in time, the longest {steps[longest]:.4g} s at {run.time_s[longest]:.6g} s "
            f"(usual step {run.step_s:.4g} s); the state of the friction after them is not known"
        )
        yield doubt("gaps", text, "log without pauses", "columns", "time")


def _pace(run: Run) -> Iterator[VettingNote]:
    """A finding for sweeps too fast or too slow for a bench: time may be in another unit."""
    thin = run.output_rad[:: max(1, run.time_s.size // 1000)]
    sweeps = max(float(np.abs(np.diff(thin)).sum()) / max(float(np.ptp(thin)), 1e-300), 1.0)
    half_s = float(run.time_s[-1] - run.time_s[0]) / sweeps
    text = f"a half sweep takes some {half_s:.3g} s, a sample {run.step_s:.3g} s"
    if run.step_s >= SLOW_STEP_S or half_s > SLOW_SWEEP_S:
        remedy = "is the time in ms or in sample numbers but declared as s?"
        yield doubt("pace", text, remedy, "columns", "time")
    elif half_s < FAST_SWEEP_S:
        remedy = "is the time in s but declared as ms? If not, move slower: the model has no inertia"
        yield doubt("pace", text, remedy, "columns", "time")


def _jumps(field: FieldPath, values: Floats, run: Run) -> Iterator[VettingNote]:
    """Findings for an encoder that starts again after a turn, or a counter that overflows."""
    steps = np.diff(values)
    usual = float(np.median(np.abs(steps)))
    turns = np.flatnonzero(np.abs(np.abs(steps) - 2.0 * math.pi) < 0.2)
    if turns.size and usual <= 0.2:
        text = f"{field[1]} jumps by a full turn {turns.size} time(s), first after sample {int(turns[0]) + 1}"
        yield refused("wrapped", text, WRAPPED, *field)
        return
    size = float(np.abs(steps).max())
    # Jumps of one size, far larger than all other steps, over most of the range; a pause in logging is not a jump.
    at = np.flatnonzero((np.abs(steps) > 0.5 * size) & (np.diff(run.time_s) < GAP_STEPS * run.step_s))
    others = float(np.quantile(np.abs(steps), 1.0 - min(2.0 * at.size / steps.size, 0.5))) if at.size else size
    if at.size < 2 or size < 0.5 * float(np.ptp(values)) or others > 0.05 * size:
        return
    if float(np.ptp(np.abs(steps[at]))) > 0.1 * size:
        return
    when = f"{at.size} time(s), first after sample {int(at[0]) + 1}"
    text = f"{field[1]} jumps by {size:.4g} rad {when}: a counter overflows"
    yield refused("wrapped", text, WRAPPED, *field)


def _stands(field: FieldPath, values: Floats, other: Floats) -> Iterator[VettingNote]:
    """Findings for an angle that stays exactly at its extreme value while the other side of the drive moves."""
    for end, word in ((float(values.max()), "highest"), (float(values.min()), "lowest")):
        at = values == end
        edges = np.flatnonzero(np.diff(np.concatenate(([0], at.view(np.int8), [0]))))
        begins, ends = edges[::2], edges[1::2]
        longest = int(np.argmax(ends - begins))
        moved = float(np.ptp(other[begins[longest] : ends[longest]]))
        if moved > LOST_TRAVEL * float(np.ptp(other)):
            samples = int(ends[longest] - begins[longest])
            text = (
                f"{field[1]} stays at its {word} figure, {end:.6g} rad, for {samples} samples "
                f"while the drive goes on by {moved:.4g} rad: the sensor is at its end"
            )
            yield doubt("saturated", text, "cut these samples out, or set the sensor's range", *field)
            return


def _levels(load_Nm: Floats) -> Iterator[VettingNote]:
    """Findings for a noisy torque that is often exactly at its extreme value."""
    still = float(np.mean(np.diff(load_Nm) == 0.0))
    for end, word in ((float(load_Nm.max()), "highest"), (float(load_Nm.min()), "lowest")):
        share = float(np.mean(load_Nm == end))
        if share > LEVEL_SHARE and still < 0.5 and load_Nm.size * share > 10:
            text = f"load torque is at its {word} figure, {end:.5g} N m, in {share:.1%} of the samples: it is cut off"
            remedy = "set the sensor's range higher; load-driven effects are off where it is cut"
            yield doubt("saturated", text, remedy, "columns", "load_torque")
            return


# Fewest half sweeps for a fit and held-back data: the first is discarded, one is held back.
FEWEST_HALF_SWEEPS = 4
# A load that varies by less than this share of its size, or by less than its noise, is constant.
CONSTANT_SHARE = 0.05
# Share of its size that a load must change with the direction of motion to count as following it.
FOLLOWS = 0.85
# An order of which ratio and offset leave less than this share of its amplitude cannot be separated from them
# (estimate).
ONE_WITH_RATIO = 0.003


def order_left(angle_rad: Floats, order: float) -> float:
    """Least share, over all phases, of the power of a wave of ``order`` that offset and ratio do not explain; 0 to 1.

    The worst phase is odd about the middle of the travel, and so most similar to a ratio error.
    """
    waves = np.stack([np.cos(order * angle_rad), np.sin(order * angle_rad)], axis=1)
    waves = waves - waves.mean(axis=0)
    line = angle_rad - angle_rad.mean()
    left = waves - np.outer(line, line @ waves) / float(line @ line)
    # The smallest ratio of two quadratic forms in (cos, sin) of the phase.
    try:
        return float(max(eigh(left.T @ left, waves.T @ waves, eigvals_only=True)[0], 0.0))
    except LinAlgError:
        # An angle with only two values: offset and ratio explain any wave.
        return 0.0


def reach_findings(run: Run, ratio: float, d: DriveSI | None) -> Iterator[VettingNote]:
    """Facts and doubts about the experiment."""
    output, sweeps = run.quiet(run.output_rad), int(run.half_sweep.max()) + 1
    travel = float(np.ptp(run.output_rad))
    rate = (run.time_s.size - 1) / float(run.time_s[-1] - run.time_s[0])
    speed = np.gradient(output, run.time_s)
    # Not the maximum, because the output jumps over a gap in time.
    fastest = float(np.quantile(np.abs(speed), 0.99))
    text = (
        f"{sweeps} half sweep(s) over {travel:.4g} rad ({np.degrees(travel):.3g} deg) in "
        f"{float(run.time_s[-1] - run.time_s[0]):.4g} s, speeds up to {fastest:.3g} rad/s"
    )
    yield fact("sweeps", text)
    if sweeps < FEWEST_HALF_SWEEPS:
        text = f"{sweeps} half sweep(s): nothing repeats, so an effect cannot be distinguished from a single event"
        yield doubt("one_sweep", text, f"record {FEWEST_HALF_SWEEPS} half sweeps or more, best 12")
    if rate * travel / max(fastest, 1e-12) < 20.0:
        text = f"fewer than 20 samples a sweep at {rate:.3g} Hz"
        yield doubt("sampling", text, "log faster or move slower", "columns", "time")
    yield from _orders(run, ratio, d)
    yield from _loads(run, speed, d)
    if run.temperature_C is None:
        text = "no temperature: thermal drift and creep are found from their course over time alone"
        yield fact("no_temperature", text)
    else:
        yield fact("temperature", f"temperature varies by {float(np.ptp(run.temperature_C)):.3g} K")
    s = run.sensors
    missing = [name for name in ("input_resolution_rad", "output_resolution_rad") if getattr(s, name) is None]
    if run.load_Nm is not None and run.load_Nm.any() and s.torque_noise_Nm is None:
        missing.append("torque_noise_Nm")
    if missing:
        text = f"{', '.join(missing)} not given: the noise floor comes from the scatter between sweeps alone"
        yield fact("sensors", text, "give it under sensors, from the data sheet", "sensors")


def _orders(run: Run, ratio: float, d: DriveSI | None) -> Iterator[VettingNote]:
    left = float(np.sqrt(order_left(run.output_rad, 1.0)))
    travel = float(np.ptp(run.output_rad))
    if left < ONE_WITH_RATIO:
        text = (
            "drum order 1 and ratio_error cannot be separated over this travel: "
            f"{left:.1g} of its amplitude differs from a ratio"
        )
        yield fact("drum_order", text, "only a longer travel separates them")
    else:
        text = f"drum order 1 differs from a ratio error by {left:.2g} of its amplitude: that must rise above the floor"
        yield fact("drum_order", text)
    stages = [] if d is None else [(body.name, abs(body.turns_per_drum)) for body in d.routes.passed]
    stages.append(("input", ratio))
    turns = ", ".join(f"{name} {stage * travel / (2.0 * np.pi):.3g} turn(s)" for name, stage in stages)
    short = [name for name, stage in stages if order_left(run.output_rad, stage) < ONE_WITH_RATIO**2]
    words = f"; too short for once_per_rev of {' and '.join(short)}" if short else ""
    spacing = 2.0 * np.pi / travel
    text = f"{turns}{words}; neighbouring orders of ripple are {spacing:.3g} cycles per output turn apart at least"
    yield fact("orders", text)


def _loads(run: Run, speed: Floats, d: DriveSI | None) -> Iterator[VettingNote]:
    if run.load_Nm is None:
        text = (
            "no load_torque: kinematics only, load-driven effects (stiffness, preload, friction of cables) not testable"
        )
        yield fact("no_load", text, "log the torque at the output; if there was no load, say load: none")
        return
    if not run.load_Nm.any():
        text = "no load: stiffness, preload and friction of the cables are not testable"
        yield fact("unloaded", text, "run under a load too")
        return
    low, high = np.percentile(run.load_Nm, (2.0, 98.0))
    span, size = float(high - low), float(np.abs(run.load_Nm).max())
    noise = 5.0 * (run.sensors.torque_noise_Nm or 0.0)
    if span <= max(CONSTANT_SHARE * size, noise):
        text = f"the load is constant ({float(np.median(run.load_Nm)):.4g} N m): stiffness and preload are not testable"
        yield doubt("constant_load", text, "add a load that changes, a brake or two weights")
        return
    levels = load_levels(run.load_Nm)
    words = ", ".join(f"{level:.3g}" for level in levels)
    yield fact(
        "load_levels", f"load levels {words} N m" if levels else f"the load varies from {low:.3g} to {high:.3g} N m"
    )
    yield from _source_of_load(run)
    alike = friction_alike(speed, run.load_Nm)
    remedy = "two speeds that differ threefold and two loads, one a weight, tell them" if alike else ""
    yield fact("friction_forms", friction_words(alike), remedy)
    sense = np.sign(speed)
    moving = np.abs(speed) > 0.2 * np.quantile(np.abs(speed), 0.99)
    # About zero and not about the mean: with a bias the load does not change sign with the motion.
    along, load = sense[moving], run.load_Nm[moving]
    if abs(float(np.mean(load * along))) > FOLLOWS * float(np.sqrt(np.mean(load**2))):
        more = ", winding_history like ratio_error" if d is not None else ""
        text = f"the load follows the sense of motion: friction looks like lash{more}"
        yield fact("load_follows_speed", text, "a bias load separates them")


# Speeds, or sizes of the load, count as one if the largest usual one is less than so many times the smallest. A sense
# of power that less than this share of the motion has is not there.
ONE_SIZE, LEAST_OF_MOTION = 1.5, 0.05


def friction_alike(speed_rad_s: Floats, load_Nm: Floats | None) -> list[str]:
    """Parts of a friction that a run of these speeds and loads, (n,) each, does not tell from a constant one."""
    size = np.abs(speed_rad_s)
    moving = size > 0.2 * np.quantile(size, 0.99)
    slow, fast = np.quantile(size[moving], (0.25, 0.9))
    found = []
    if fast < ONE_SIZE * slow:
        found.append(f"a viscous or Stribeck part: there is one speed, {float(fast):.2g} rad/s")
    if load_Nm is None or not load_Nm.any():
        return [*found, "a part in proportion to the load: there is no load"]
    power = np.sign(speed_rad_s[moving]) * load_Nm[moving]
    low, high = np.quantile(np.abs(power), (0.25, 0.9))
    if high < ONE_SIZE * low:
        found.append(f"a part in proportion to the load: there is one size of load, {float(high):.2g} N m")
    driving = float(np.mean(power > 0.2 * high))
    if driving < LEAST_OF_MOTION or float(np.mean(power < -0.2 * high)) < LEAST_OF_MOTION:
        found.append(f"a part by the sense of power: the load always {'opposes' if driving else 'drives'} the motion")
    return found


def friction_words(alike: Sequence[str]) -> str:
    """A sentence on what :func:`friction_alike` found."""
    if alike:
        return f"a constant friction looks like one with {'; or '.join(alike)}"
    return "friction by speed, by load and by the sense of power can be told apart"


def _source_of_load(run: Run) -> Iterator[VettingNote]:
    """What a load that no sensor measured leaves open."""
    allowed = run.sensors.torque_class
    if allowed.of_known:
        text = (
            "the load of a weight on an arm is a wave of the output's angle, once a turn: a compliance in series looks "
            "like once_per_rev drum"
        )
        yield fact("weight", text, "judge it together with a run with another weight, or none")
    elif allowed.of_currents and run.load_Nm is not None:
        # A second difference of white noise has six times its square.
        noise = float(np.std(np.diff(run.load_Nm, 2))) / np.sqrt(6.0)
        text = (
            f"the load is that of the motors' currents, to {allowed.share:.2g} of its gain and with a noise of "
            f"{noise:.2g} N m a sample: a modulus that is wrong by less than this share is not told from the torque "
            "constant, and friction between motor and drum is in the load"
        )
        weighed = run.motor is not None and (allowed.gain_sigma or 1.0) < run.motor.torque_constant_share
        remedy = "turn a known weight on an arm and state it as load, pendulum: it gives the torque constant"
        yield fact("motors_current", text, "" if weighed else remedy)
    elif run.beside is not None:
        yield _beside(run, run.beside)


# Standard deviation of the gain of currents over a sensor from which they say nothing.
MOST_SCATTER = 0.3


def _beside(run: Run, found: BesideSensor) -> VettingNote:
    """What the motors' currents say beside a torque sensor, and what the loop uses of them."""
    allowed = run.sensors.torque_class
    if found.told < LEAST_TOLD:
        text = (
            "motors' currents beside the torque sensor: the load goes with the motion, so that a gain and losses look "
            "alike, and the currents are not used"
        )
        return fact("currents_beside", text, "add a load that does not, as a weight on an arm")
    if found.gain_sigma > MOST_SCATTER:
        text = "motors' currents do not follow the torque sensor: no loss is told, and they are not used"
        remedy = "check the signs of currents and torque, and that the columns belong together"
        return doubt("currents_beside", text, remedy)
    design = "" if found.of_design_Nm is None else f" (by the design {found.of_design_Nm:.2g})"
    text = (
        f"the motors' currents carry {found.gain:.3g} times (sigma {found.gain_sigma:.2g}) what the torque sensor "
        f"shows, and with the sense of the motion {found.dry_Nm:.2g} N m{design}, {100.0 * found.share:.2g} % of the "
        f"load and {found.viscous_Nm:.2g} N m that grow with the speed: losses between motors and sensor, told from a "
        "gain, which is the same in both senses of power"
    )
    if found.used:
        text += f"; the load is the sensor's with its gain moved by {found.used:.0%} of the way to the currents'"
    else:
        text += f"; the load is the sensor's alone, whose gain is known to {0.5 * allowed.share:.2g}"
    bound = 2.0 * math.hypot(found.gain_sigma, 0.5 * allowed.share)
    if not found.used and abs(found.gain - 1.0) > bound:
        remedy = "check the gain of the sensor, the torque constant (phase or bus current?) and the gear ratio"
        return doubt("currents_beside", f"{text}; they differ by more than {bound:.2g}", remedy)
    return fact("currents_beside", text)


def load_levels(load_Nm: Floats) -> list[float]:
    """Constant levels of the load, N m, lowest first; empty if the load varies continuously."""
    counts, edges = np.histogram(load_Nm, bins=60)
    busy = counts >= 0.05 * load_Nm.size
    # A level with its noise is a group of bins with many samples between bins with few.
    borders = np.flatnonzero(np.diff(np.concatenate(([0], busy.view(np.int8), [0]))))
    groups = list(zip(borders[::2], borders[1::2], strict=True))
    held = sum(int(counts[a:b].sum()) for a, b in groups)
    if not groups or held < 0.8 * load_Nm.size or max(b - a for a, b in groups) > 15:
        return []
    return [float(np.median(load_Nm[(load_Nm >= edges[a]) & (load_Nm <= edges[b])])) for a, b in groups]


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
    speed = run.quiet(np.gradient(turned, run.time_s))
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
