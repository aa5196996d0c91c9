"""The plain capstan drive as one rope with nodes that are not anchored on the input: physics of bench runs with creep.

This is independent of the project's model and rig. The nodes are marks on the rope along its path: drum, span, input,
span, drum. Between two marks the rope is a spring. A mark on a pulley moves with the surface under it, unless the
tensions on both sides differ by more than the friction on its few degrees of wrap; then it slides until they do not.
Marks leave and join a pulley as the rope moves, and only this friction holds the rope on the input. In each sample all
marks move with their surfaces, the spans are set to their lengths, and the drum turns until the tensions balance the
load.
"""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numba import njit

from mbcdm_cad.layouts.siso_spur.drive import SpurDrive
from tests.support.bench_data import Simulated, stream, write_run
from tests.support.bench_motion import Plan, bench_run, read_sensors

MARK_M = 0.25e-3
DRUM_WRAP_RAD = 2.2


@dataclass(frozen=True)
class Belt:
    """One rope round one input, SI. ``wrap_rad`` is over the input, from span to span."""

    r_in: float
    r_drum: float
    span: float
    wrap_rad: float
    preload: float
    friction: float
    stiffness: float  # E A in N


def belt_of(drive: SpurDrive, wrap_rad: float) -> Belt:
    """Radii, span and rope of a design, with another wrap over its input."""
    r_in, r_drum = drive.input_radius_mm * 1e-3, drive.drum_radius_mm * 1e-3
    span = math.sqrt((drive.centre_distance_mm * 1e-3) ** 2 - (r_in + r_drum) ** 2)
    stiffness = drive.cable.modulus_GPa * 1e9 * drive.cable.area_mm2 * 1e-6
    return Belt(r_in, r_drum, span, wrap_rad, drive.cables[0].preload_N, drive.friction_coefficient, stiffness)


def run_belt(belt: Belt, input_rad: np.ndarray, load_Nm: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Drum angle (n,) and span tensions (2, n), that first which rises under a positive load."""
    lengths = np.cumsum([DRUM_WRAP_RAD * belt.r_drum, belt.span, belt.wrap_rad * belt.r_in, belt.span])
    marks = np.linspace(0.0, lengths[-1] + lengths[0], int((lengths[-1] + lengths[0]) / MARK_M) + 1)
    drum, pulls = np.empty(load_Nm.size), np.empty((2, load_Nm.size))
    constants = np.array([belt.r_in, belt.r_drum, belt.preload, belt.friction, belt.stiffness])
    failed = _march(constants, lengths, marks, np.ascontiguousarray(input_rad), load_Nm, drum, pulls)
    if failed >= 0:
        raise ValueError(f"sample {failed}: the belt carries no {load_Nm[failed]:.3g} N m")
    return drum, pulls


@njit(cache=True)
def _slide(rope, inner, step, edge, pull, mu_per_m, stiffness, write):
    """Lengthening of the rope on one pulley, from the last mark before the span inwards, when the span pulls ``pull``.

    ``rope`` holds the pulls and lengths of the springs and the places of the marks; ``inner`` is the spring next to
    that mark, ``step`` the sense inwards, ``edge`` where contact ends. Written, the marks move too: each by what the
    springs between it and the one that holds have lengthened. Also its slope by the pull.
    """
    pulls, springs, places = rope
    # Half the springs beside it, of the outer one what has contact.
    mark = inner + 1 if step < 0 else inner
    contact = min(abs(edge - places[mark]), 0.5 * springs[inner]) + 0.5 * springs[inner]
    beside, longer, rate, last = pull, 0.0, 0.0, inner
    while True:
        hold = math.exp(mu_per_m * contact)
        moved = min(max(pulls[last], beside / hold), beside * hold)
        if moved == pulls[last]:
            break
        longer += springs[last] * (moved - pulls[last]) / stiffness
        rate += springs[last] * moved / (pull * stiffness)
        contact = 0.5 * (springs[last] + springs[last + step])
        beside = moved
        last += step
        if last <= 0 or last >= pulls.size - 1:
            break
    if write:
        shift, k, beside = longer, inner, pull
        contact = min(abs(edge - places[mark]), 0.5 * springs[inner]) + 0.5 * springs[inner]
        while k != last:
            hold = math.exp(mu_per_m * contact)
            moved = min(max(pulls[k], beside / hold), beside * hold)
            places[k + 1 if step < 0 else k] -= step * shift
            shift -= springs[k] * (moved - pulls[k]) / stiffness
            pulls[k] = moved
            contact = 0.5 * (springs[k] + springs[k + step])
            beside = moved
            k += step
    return longer, rate


@njit(cache=True)
def _span_pull(rope, low, high, on, constants, width, guess, write):
    """Pull of a span at which its length is right, and the slope of its length by the pull.

    ``low`` and ``high`` are the last marks on the pulleys at its ends;
    ``on`` holds the edges of contact below and above and the radii there.
    """
    pulls, springs, _ = rope
    preload, mu, stiffness = constants[2], constants[3], constants[4]
    rest = 0.0
    for k in range(low, high):
        rest += springs[k]
    least, most, pull, slope = 0.0, 40.0 * preload, guess, rest / stiffness
    for _ in range(200):
        one, one_rate = _slide(rope, low - 1, -1, on[0], pull, mu / on[2], stiffness, False)
        two, two_rate = _slide(rope, high, 1, on[1], pull, mu / on[3], stiffness, False)
        longer = rest * (1.0 + (pull - preload) / stiffness) - width + one + two
        slope = rest / stiffness + one_rate + two_rate
        if longer > 0.0:
            most = pull
        else:
            least = pull
        following = pull - longer / slope
        if not (least < following < most):
            following = 0.5 * (least + most)
        done = abs(following - pull) <= 1e-12 * preload
        pull = following
        if done:
            break
    if write:
        _slide(rope, low - 1, -1, on[0], pull, mu / on[2], stiffness, True)
        _slide(rope, high, 1, on[1], pull, mu / on[3], stiffness, True)
        for k in range(low, high):
            pulls[k] = pull
    return pull, slope


@njit(cache=True)
def _march(constants, lengths, places, turned, load, drum, spans):
    """Fill ``drum`` and ``spans``; the first sample without balance, or -1."""
    r_in, r_drum, preload = constants[0], constants[1], constants[2]
    springs = places[1:] - places[:-1]
    pulls = np.full(springs.size, preload)
    rope = (pulls, springs, places)
    angle, before = 0.0, 0.0
    pull = np.full(2, preload)
    edges = np.array([[lengths[0], lengths[1], r_drum, r_in], [lengths[2], lengths[3], r_in, r_drum]])
    for n in range(turned.size):
        by_input = r_in * (turned[n] - before)
        before = turned[n]
        # Marks that are the last on a pulley before either span, where they lie now.
        inner = np.searchsorted(places, lengths)
        start, least, most = angle, angle - 1.0, angle + 1.0
        found, miss = angle + by_input / r_drum, math.inf
        for _ in range(100):
            by_drum, miss, rate = r_drum * (found - start), -load[n], 0.0
            for side in range(2):
                low, high = inner[2 * side] - 1, inner[2 * side + 1]
                # Marks have not been moved yet: the span is longer by what its far pulley moves beyond the near one.
                width = places[high] - places[low] + (by_input - by_drum if side == 0 else by_drum - by_input)
                pull[side], slope = _span_pull(rope, low, high, edges[side], constants, width, pull[side], False)
                miss += r_drum * pull[side] * (1.0 if side == 0 else -1.0)
                rate += r_drum**2 / slope
            if abs(miss) < 1e-9:
                break
            # The first span slackens as the drum goes on.
            if miss > 0.0:
                least = found
            else:
                most = found
            found += miss / rate
            if not (least < found < most):
                found = 0.5 * (least + most)
        if not abs(miss) < 1e-6:
            return n
        by_drum = r_drum * (found - start)
        for side in range(2):
            low, high = inner[2 * side] - 1, inner[2 * side + 1]
            width = places[high] - places[low] + (by_input - by_drum if side == 0 else by_drum - by_input)
            _span_pull(rope, low, high, edges[side], constants, width, pull[side], True)
            spans[side, n] = pull[side]
        # Only now everything goes with its surface; marks in a span lie anew from its first one.
        for k in range(places.size):
            if k < inner[1] and k >= inner[0]:
                continue
            if k < inner[3] and k >= inner[2]:
                continue
            places[k] += by_input if inner[1] <= k < inner[2] else by_drum
        for side in range(2):
            for k in range(inner[2 * side], inner[2 * side + 1]):
                places[k] = places[k - 1] + springs[k - 1] * (1.0 + (pull[side] - preload) / constants[4])
        angle = found
        drum[n] = angle
    return -1


def write_belt_run(folder: Path, drive: SpurDrive, wrap_rad: float, plan: Plan, seed: int) -> Path:
    """Write a run of the drive with that wrap over its input as a bench would; the path of the measurement file."""
    name = f"belt-{plan.load}-{seed}"
    bench = bench_run(plan, drive.total_ratio, 1, stream(name, seed, "motion"))
    drum, _ = run_belt(belt_of(drive, wrap_rad), bench.input_rad[0], bench.load_Nm)
    sensed = read_sensors(bench, drum, stream(name, seed, "sensors"))
    folder.mkdir(parents=True, exist_ok=True)
    write_run(folder, name, Simulated(plan, bench, drum, sensed, (), ("inputs", "output", "torque")), ("main",))
    return folder / f"{name}.yaml"
