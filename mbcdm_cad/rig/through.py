"""A cable that is anchored nowhere on its input: its two sides, and the rope that goes over from one to the other.

Each side is a chain of :mod:`mbcdm_cad.rig.chain` whose wrap on the input begins at an anchor. Here the anchor of both
is a place on the pulley where the rope sticks at the moment, and after each step it moves to the place that holds best.
The pieces between the old place and the new one go over to the other side with the tension that they have. So no rope
is lost, and what neither side notices at the time comes through later: a piece that was wound on under a high tension
and leaves on the other side brings more rope there than it takes away under a low one. That is the creep of a belt.

A piece holds by a reserve mu a - |ln(T_end / T)| towards each end, a the angle to it. Where no piece of a wrap has any,
the cable slips through as a whole, and no drum angle balances the load.

Place of a piece on the pulley: number k on the first side is number -k - 1 on the second.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.rig.cables import RigCable
from mbcdm_cad.rig.chain import HIGH, INPUT, LOW, MU, PIECE, Chains
from mbcdm_cad.storage.compiled import compiled

# A side without tension holds nothing; its logarithm must be finite, N.
_LEAST_N = 1e-9


def pairs_of(cables: tuple[RigCable, ...]) -> NDArray[np.int64]:
    """The two sides of each cable that friction alone holds on its input, (n, 2)."""
    inputs = sorted({c.input_index for c in cables if c.own_wrap_rad > 0.0})
    sides = [[j for j, c in enumerate(cables) if c.input_index == i] for i in inputs]
    return np.array(sides, dtype=np.int64).reshape(-1, 2)


@compiled
def _reserve(chains: Chains, one: int, other: int, k: int) -> float:
    """What the piece ``k`` of the side ``one`` has left of its hold towards the end that has less."""
    wrap, back = chains.wraps[one, INPUT], chains.wraps[other, INPUT]
    size, count = wrap[PIECE], chains.pieces.shape[2]
    owner = one if k * size >= wrap[LOW] - 0.5 * size else other
    at = k if owner == one else -k - 1
    now = max(chains.pieces[owner, INPUT, at % count], _LEAST_N)
    middle = (k + 0.5) * size
    ahead, behind = wrap[HIGH] - middle, back[HIGH] + middle
    towards = wrap[MU] * ahead - abs(math.log(max(chains.tension[one], _LEAST_N) / now))
    return float(min(towards, back[MU] * behind - abs(math.log(max(chains.tension[other], _LEAST_N) / now))))


@compiled
def go_over(chains: Chains, one: int, other: int) -> bool:
    """Move the common anchor of both sides to where the rope holds best; False where it holds nowhere."""
    wrap, back = chains.wraps[one, INPUT], chains.wraps[other, INPUT]
    size, count = wrap[PIECE], chains.pieces.shape[2]
    best, most = 0, -math.inf
    # The outer pieces of both ends are mixtures of old and new rope.
    for k in range(math.ceil(-back[HIGH] / size) + 2, math.floor(wrap[HIGH] / size) - 2):
        reserve = _reserve(chains, one, other, k)
        if reserve > most:
            best, most = k, reserve
    if most <= 0.0:
        return False
    at = round(wrap[LOW] / size)
    while at < best:
        chains.pieces[other, INPUT, (-at - 1) % count] = chains.pieces[one, INPUT, at % count]
        at += 1
    while at > best:
        at -= 1
        chains.pieces[one, INPUT, at % count] = chains.pieces[other, INPUT, (-at - 1) % count]
    # The sums stay: a piece that is gone over still counts for the side on which its rope was reckoned so far.
    wrap[LOW], back[LOW] = at * size, -at * size
    return True
