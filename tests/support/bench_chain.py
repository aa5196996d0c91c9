"""Cable on its pulleys as a chain of short pieces with Coulomb friction: the physics of simulated bench runs.

This is independent of the project's model. Each wrap is a row of nodes fixed to its pulley. A node slips if its tension
differs from that of its neighbour nearer to the free span by more than the capstan factor of the piece between them;
the slip moves it exactly to that limit. The sweep starts at the free span and ends at the first node that holds. The
stretch is the trapezoidal sum of tension over the nodes, with an error of second order in the length of a piece. A
guarded Newton iteration on the drum's angle finds its equilibrium; another one inside it finds each cable's tension.

With transport, the nodes move with the pulleys: cable that is wound on brings its tension, cable that is wound off
removes it. Play in an input's coupling is taken up by the sign of the torque in it.
"""

import math

import numpy as np
from numba import njit

from tests.support.bench_motion import Chain

PIECE_RAD = 4e-3
INPUT_WRAP_RAD = 18.0
DRUM_WRAP_RAD = 4.0
BALANCE_NM = 1e-8


def run_chain(
    chain: Chain,
    input_rad: np.ndarray,
    load_Nm: np.ndarray,
    path_m: np.ndarray,
    transport: bool = False,
    input_play_rad: np.ndarray | None = None,
    piece_rad: float = PIECE_RAD,
) -> tuple[np.ndarray, np.ndarray]:
    """Drum angle (n,) and tensions (cables, n) for input angles (inputs, n) at the couplings and load (n,).

    ``path_m`` (cables, n) lengthens each cable's path; ``input_play_rad`` is the play in each input's coupling.
    """
    n_cables, n = path_m.shape
    play = np.zeros(input_rad.shape[0]) if input_play_rad is None else np.asarray(input_play_rad, dtype=float)
    turn = float(np.abs(input_rad).max())
    wraps = np.array([INPUT_WRAP_RAD, DRUM_WRAP_RAD]) if transport else np.array([6.0, 6.0])
    longest = wraps.max() + (turn if transport else 0.0) + 1.0
    nodes = np.empty((n_cables, 2, int(longest / piece_rad) + 8))
    nodes[:] = chain.preload[:, None, None]
    radii = np.stack([chain.r_in, chain.r_drum], axis=1)
    drum, tension = np.empty(n), np.empty((n_cables, n))
    cables = (chain.sense, chain.input_of, chain.r_in, chain.r_drum, radii, chain.preload, chain.span)
    laws = (chain.friction, chain.stiffness, piece_rad, transport, wraps)
    series = [np.ascontiguousarray(one) for one in (input_rad, load_Nm, path_m)]
    missed = _march((*cables, *laws, nodes), *series, play, drum, tension)
    if missed >= 0:
        raise ValueError(f"sample {missed}: the chain finds no balance at {load_Nm[missed]:.3g} N m")
    return drum, tension


@njit(cache=True)
def _wrap_stretch(nodes, held, at, before, pull, rest, mu, piece, commit):
    """Trapezoid sum of (T - T_rest) over one wrap, its derivative by the end tension, and the node sum to store."""
    top, old = int(at / piece), int(before / piece)
    total = held
    for k in range(top + 1, old + 1):
        total -= nodes[k] - rest
    rate = 0.0
    for k in range(old + 1, top + 1):
        total += pull - rest
        rate += 1.0
        if commit:
            nodes[k] = pull
    first = at - top * piece
    factor, whole = math.exp(mu * first), math.exp(mu * piece)
    neighbour, chained = pull, 1.0
    top_tension, top_rate = pull, 1.0
    for k in range(top, -1, -1):
        mine = pull if k > old else nodes[k]
        low, high = neighbour / factor, neighbour * factor
        holds = k <= old and low <= mine <= high
        moved = mine if low <= mine <= high else (low if mine < low else high)
        if k == top:
            top_tension = moved
            top_rate = 0.0
        if holds:
            break
        if k > old:
            chained = 1.0
        else:
            chained = chained / factor if moved == low else chained * factor
            total += moved - mine
            rate += chained
            if commit:
                nodes[k] = moved
        if k == top:
            top_rate = chained
        neighbour, factor = moved, whole
    area = piece * total - 0.5 * piece * (top_tension - rest) + 0.5 * first * (top_tension + pull - 2.0 * rest)
    slope = piece * rate - 0.5 * piece * top_rate + 0.5 * first * (top_rate + 1.0)
    return area, slope, total


@njit(cache=True)
def _tension(nodes, held, at, before, radii, rest, span, mu, ea, piece, stretch, guess):
    """End tension that gives ``stretch``, and its derivative by stretch."""
    pull = guess
    slope = span / ea
    for _ in range(60):
        have, slope = (pull - rest) * span, span
        for w in range(2):
            area, rate, _s = _wrap_stretch(nodes[w], held[w], at[w], before[w], pull, rest, mu, piece, False)
            have += radii[w] * area
            slope += radii[w] * rate
        step = (stretch * ea - have) / slope
        slope /= ea
        following = pull + step
        if following < 0.3 * pull:
            following = 0.3 * pull
        done = abs(following - pull) <= 1e-11 * rest
        pull = following
        if done or pull < 1e-9 * rest:
            break
    return pull, 1.0 / slope


@njit(cache=True)
def _balance(chain, state, pulls, load, theta):
    """Drum angle at which the cables carry ``load``; ``pulls`` and ``place`` are left at that state."""
    sense, _input_of, _r_in, r_drum, radii, preload, span, mu, ea, piece, transport, wraps, nodes = chain
    held, place, before, offset, turned = state
    low, high = -math.inf, math.inf
    miss = math.inf
    for _ in range(200):
        miss, grip = -load, 0.0
        for j in range(sense.size):
            if transport:
                place[j, 0] = wraps[0] + sense[j] * turned[j]
                place[j, 1] = wraps[1] - sense[j] * theta
            stretch = offset[j] - sense[j] * r_drum[j] * theta
            pulls[j], rate = _tension(
                nodes[j], held[j], place[j], before[j], radii[j], preload[j], span[j], mu, ea, piece, stretch, pulls[j]
            )
            miss += sense[j] * r_drum[j] * pulls[j]
            grip += r_drum[j] * r_drum[j] * rate
        if abs(miss) <= BALANCE_NM:
            return theta, miss
        if miss > 0.0:
            low = theta
        else:
            high = theta
        following = theta + miss / grip
        if not (low < following < high):
            following = 0.5 * (low + high)
        theta = following
    return theta, miss


@njit(cache=True)
def _march(chain, angle, load, path, play, drum, tension):
    """Fill ``drum`` and ``tension``; the first sample without balance, or -1."""
    sense, input_of, r_in, r_drum, _radii, preload, _span, mu, _ea, piece, _transport, wraps, nodes = chain
    n_cables, n = path.shape
    n_inputs = angle.shape[0]
    held = np.zeros((n_cables, 2))
    place, before = np.empty((n_cables, 2)), np.empty((n_cables, 2))
    for j in range(n_cables):
        for w in range(2):
            place[j, w] = wraps[w] + 0.5 * piece
            before[j, w] = place[j, w]
    pulls, offset, turned = preload.copy(), np.zeros(n_cables), np.zeros(n_cables)
    state = (held, place, before, offset, turned)
    side = np.zeros(n_inputs)
    for i in range(n_inputs):
        carried = 0.0
        for j in range(n_cables):
            if input_of[j] == i:
                carried += sense[j] * r_in[j] * preload[j]
        side[i] = 1.0 if carried >= 0.0 else -1.0
    start_side = side.copy()
    theta, followed = 0.0, 0.0
    for k in range(n):
        # The drum follows its inputs; what is left to find is small.
        follows = 0.0
        for j in range(n_cables):
            follows += angle[input_of[j], k] * r_in[j] / r_drum[j] / n_cables
        theta += follows - followed
        followed = follows
        settled = False
        for i in range(n_inputs):
            if play[i] == 0.0:
                continue
            # The face in contact; where neither face is pressed, the pulley floats in the gap without torque.
            for trial in range(60):
                if trial == 0:
                    at = side[i]
                elif trial == 1:
                    low, high = -1.0, 1.0
                    at = -1.0 if side[i] > 0.0 else 1.0
                    if abs(side[i]) < 1.0:
                        at = 1.0
                elif trial == 2 and abs(side[i]) < 1.0:
                    at = -1.0
                else:
                    at = 0.5 * (low + high)
                for j in range(n_cables):
                    lag = 0.0
                    for m in range(n_inputs):
                        if m == input_of[j]:
                            here = at if m == i else side[m]
                            lag = 0.5 * play[m] * (here - start_side[m])
                    turned[j] = angle[input_of[j], k] - lag
                    offset[j] = sense[j] * r_in[j] * turned[j] + path[j, k]
                theta, miss = _balance(chain, state, pulls, load[k], theta)
                carried = 0.0
                for j in range(n_cables):
                    if input_of[j] == i:
                        carried += sense[j] * r_in[j] * pulls[j]
                if (at >= 1.0 and carried >= 0.0) or (at <= -1.0 and carried <= 0.0) or abs(carried) < 1e-6:
                    break
                if trial >= 1:
                    if carried > 0.0:
                        low = at
                    else:
                        high = at
            side[i] = at
            settled = True
        if not settled:
            for j in range(n_cables):
                turned[j] = angle[input_of[j], k]
                offset[j] = sense[j] * r_in[j] * turned[j] + path[j, k]
            theta, miss = _balance(chain, state, pulls, load[k], theta)
        if not abs(miss) <= 1e-6:
            return k
        for j in range(n_cables):
            for w in range(2):
                _a, _r, held[j, w] = _wrap_stretch(
                    nodes[j, w], held[j, w], place[j, w], before[j, w], pulls[j], preload[j], mu, piece, True
                )
                before[j, w] = place[j, w]
            tension[j, k] = pulls[j]
        drum[k] = theta
    return -1
