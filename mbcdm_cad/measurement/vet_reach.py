"""Find what a run can and cannot show, from its travel, loads, sweeps and columns alone."""

from __future__ import annotations

import numpy as np
from scipy.linalg import LinAlgError, eigh

from mbcdm_cad.measurement.run import Run, VettingNote
from mbcdm_cad.measurement.sweeps import SPEED_WINDOW_S, half_sweeps, smoothed
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.routes import Floats

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


def reach_findings(run: Run, ratio: float, d: DriveSI | None) -> list[VettingNote]:
    """Facts and doubts about the experiment."""
    output = smoothed(run.output_rad, SPEED_WINDOW_S, run.step_s)
    sweeps = int(half_sweeps(output).max()) + 1
    travel = float(np.ptp(run.output_rad))
    rate = (run.time_s.size - 1) / float(run.time_s[-1] - run.time_s[0])
    speed = np.gradient(output, run.time_s)
    # Not the maximum, because the output jumps over a gap in time.
    fastest = float(np.quantile(np.abs(speed), 0.99))
    text = (
        f"{sweeps} half sweep(s) over {travel:.4g} rad ({np.degrees(travel):.3g} deg) in "
        f"{float(run.time_s[-1] - run.time_s[0]):.4g} s, speeds up to {fastest:.3g} rad/s"
    )
    found = [VettingNote("sweeps", "fact", text)]
    if sweeps < FEWEST_HALF_SWEEPS:
        text = f"{sweeps} half sweep(s): nothing repeats, so an effect cannot be distinguished from a single event"
        found.append(
            VettingNote("one_sweep", "doubt", text, f"record {FEWEST_HALF_SWEEPS} half sweeps or more, best 12")
        )
    if rate * travel / max(fastest, 1e-12) < 20.0:
        text = f"fewer than 20 samples a sweep at {rate:.3g} Hz"
        found.append(VettingNote("sampling", "doubt", text, "log faster or move slower", ("columns", "time")))
    return [*found, *_orders(run, ratio, d), *_loads(run, speed, d), *_temperature(run), *_sensors(run)]


def _orders(run: Run, ratio: float, d: DriveSI | None) -> list[VettingNote]:
    left = float(np.sqrt(order_left(run.output_rad, 1.0)))
    travel = float(np.ptp(run.output_rad))
    if left < ONE_WITH_RATIO:
        text = (
            "drum order 1 and ratio_error cannot be separated over this travel: "
            f"{left:.1g} of its amplitude differs from a ratio"
        )
        found = [VettingNote("drum_order", "fact", text, "only a longer travel separates them")]
    else:
        text = f"drum order 1 differs from a ratio error by {left:.2g} of its amplitude: that must rise above the floor"
        found = [VettingNote("drum_order", "fact", text)]
    stages = [("input", ratio)]
    if d is not None:
        stages = [(body.name, abs(body.turns_per_drum)) for body in d.routes.passed] + stages
    turns = ", ".join(f"{name} {stage * travel / (2.0 * np.pi):.3g} turn(s)" for name, stage in stages)
    short = [name for name, stage in stages if order_left(run.output_rad, stage) < ONE_WITH_RATIO**2]
    words = f"; too short for once_per_rev of {' and '.join(short)}" if short else ""
    spacing = 2.0 * np.pi / travel
    text = f"{turns}{words}; neighbouring orders of ripple are {spacing:.3g} cycles per output turn apart at least"
    return [*found, VettingNote("orders", "fact", text)]


def _loads(run: Run, speed: Floats, d: DriveSI | None) -> list[VettingNote]:
    if run.load_Nm is None:
        text = (
            "no load_torque: kinematics only, load-driven effects (stiffness, preload, friction of cables) not testable"
        )
        return [VettingNote("no_load", "fact", text, "log the torque at the output")]
    low, high = np.percentile(run.load_Nm, (2.0, 98.0))
    span, size = float(high - low), float(np.abs(run.load_Nm).max())
    noise = 5.0 * (run.sensors.torque_noise_Nm or 0.0)
    if span <= max(CONSTANT_SHARE * size, noise):
        text = f"the load is constant ({float(np.median(run.load_Nm)):.4g} N m): stiffness and preload are not testable"
        return [VettingNote("constant_load", "doubt", text, "add a load that changes, a brake or two weights")]
    levels = load_levels(run.load_Nm)
    words = ", ".join(f"{level:.3g}" for level in levels)
    text = f"load levels {words} N m" if levels else f"the load varies from {low:.3g} to {high:.3g} N m"
    found = [VettingNote("load_levels", "fact", text)]
    sense = np.sign(speed)
    moving = np.abs(speed) > 0.2 * np.quantile(np.abs(speed), 0.99)
    # About zero and not about the mean: with a bias the load does not change sign with the motion.
    along, load = sense[moving], run.load_Nm[moving]
    if abs(float(np.mean(load * along))) > FOLLOWS * float(np.sqrt(np.mean(load**2))):
        text = "the load follows the sense of motion: friction looks like lash" + (
            ", winding_history like ratio_error" if d is not None else ""
        )
        found.append(VettingNote("load_follows_speed", "fact", text, "a bias load separates them"))
    return found


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


def _temperature(run: Run) -> list[VettingNote]:
    if run.temperature_C is None:
        text = "no temperature: thermal drift and creep are found from their course over time alone"
        return [VettingNote("no_temperature", "fact", text)]
    span = float(np.ptp(run.temperature_C))
    return [VettingNote("temperature", "fact", f"temperature varies by {span:.3g} K")]


def _sensors(run: Run) -> list[VettingNote]:
    s = run.sensors
    missing = [name for name in ("input_resolution_rad", "output_resolution_rad") if getattr(s, name) is None]
    if run.load_Nm is not None and s.torque_noise_Nm is None:
        missing.append("torque_noise_Nm")
    if not missing:
        return []
    text = f"{', '.join(missing)} not given: the noise floor comes from the scatter between sweeps alone"
    return [VettingNote("sensors", "fact", text, "give it under sensors, from the data sheet", ("sensors",))]
