"""A cable that is anchored nowhere on its input: its two sides, and the rope that goes over from one to the other.

Each side is a chain of :mod:`mbcdm_cad.rig.chain` whose wrap on the input begins at an anchor. Here the common anchor
of both is a place on the pulley where the rope sticks at the moment; after each step it moves to the place with the
largest reserve of friction. The pieces between the old and the new place go over to the other side and keep their
tension. So no rope is lost, and the effect appears later: a piece that was wound on under a high tension and leaves on
the other side brings more rope there than a piece under a low tension takes away. That is the creep of a belt.

The reserve of a piece towards each end is mu a - |ln(T_end / T)|, a the angle to that end. Where no piece of a wrap has
a reserve, the whole cable slips over the input, and no drum angle balances the load.

Place of a piece on the pulley: number k on the first side is number -k - 1 on the second.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.rig.cables import RigCable
from mbcdm_cad.rig.chain import HIGH, INPUT, LOW, MU, PIECE, Chains
from mbcdm_cad.storage.compiled import compiled

# Lower bound of a tension, N, so that its logarithm is finite; a slack side has no reserve.
_LEAST_N = 1e-9


def pairs_of(cables: tuple[RigCable, ...]) -> NDArray[np.int64]:
    """The two sides of each cable that friction alone holds on its input, (n, 2); they are neighbours."""
    return np.array([j for j, c in enumerate(cables) if c.own_wrap_rad > 0.0], dtype=np.int64).reshape(-1, 2)


@compiled
def _reserve(chains: Chains, one: int, other: int, k: int) -> float:
    """Reserve of the piece ``k`` of the side ``one`` towards the end with the smaller reserve."""
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
    """Move the common anchor of both sides to the piece with the largest reserve; False if no piece has one."""
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
    # The sums do not change: a piece that went over still counts for the side that its rope belonged to.
    wrap[LOW], back[LOW] = at * size, -at * size
    return True
