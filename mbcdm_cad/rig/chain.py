"""Cables as chains of elastic pieces: unilateral tension, Coulomb contact on every wrap, rope carried along.

Physics. A wrap is divided into pieces of equal angle, fixed to the pulley's surface. Each has one tension and so one
strain. Between a piece and its neighbour, or the tension T_e of the free span, friction allows at most a ratio e^(mu
s), s the angle between their middles. When T_e changes, pieces slip from the end inwards until one holds: the first
piece within this ratio keeps its tension, and so do all pieces behind it. Nothing is assumed about loading, unloading
or history.

Balance. The rope's length at preload is conserved: with delta the growth of the path since the start,

    (T_e - T_pre) L_free + sum over wraps and pieces (T - T_pre) r dphi = E A delta,   T >= 0,

which is one monotone equation for T_e, solved by Newton steps. A spring at the drum's anchor counts as rope of the same
give that bears the tension of the last piece. Where no tension above zero fits, the cable is slack
(T_e = 0).

Carrying along. When a pulley turns, the tangent point moves relative to the pieces, which are fixed to the pulley:
pieces pass it and leave with the tension they had, new ones are laid on with T_e. ``transport=False`` keeps the tangent
points fixed, as the analytic model does. The input wrap grows with sigma theta_i, the drum's with -sigma theta_o; the
wrap on a body that is passed moves with the rope. With ``passed_slip=False`` the tension passes such a body without a
wrap. With ``passed_slip=True`` the wrap has two ends, both at T_e (the body's bearing turns freely), and rope creeps on
it from both ends.

Python:  ``chains(cables, ...)`` gives fresh ``Chains`` at preload with all angles zero.
njit, j the cable, all arrays changed in place:
    ``advance(chains, j, input_rad, drum_rad, path_m) -> T_e``          all three steps below: what an integrator needs
    ``carry(chains, j, input_rad, drum_rad)``                           turn the pulleys to these angles
    ``look(chains, j, stretch_m) -> (T_e, dT_e/ddelta)``                tension at a total stretch; state unchanged
    ``settle(chains, j, tension_N)``                                    let the pieces slip as far as T_e makes them
    ``stretch(chains, j, input_rad, drum_rad, path_m)``                 delta = sigma (r_i theta_i - r_o theta_o) + path
    ``strain(chains, j, strains)``                                      give the wraps a stress-free strain
The same T_e acts at both ends of the free span: torques are sigma r_i T_e on the input and sigma r_o T_e on the drum.
The stiffest a cable can be is ``E A / L_free`` (columns ``EA`` and ``FREE`` of ``Chains.constants``).
SI throughout: m, N, rad. State of a cable: ``Chains.tension[j]`` is T_e; the pieces are in ``Chains.pieces``.

Each side is a chain of :mod:`mbcdm_cad.rig.chain` whose wrap on the input begins at an anchor. Here the common anchor
of both is a place on the pulley where the rope sticks at the moment; after each step it moves to the place with the
largest reserve of friction. The pieces between the old and the new place go over to the other side and keep their
tension. So no rope is lost, and the effect appears later: a piece that was wound on under a high tension and leaves on
the other side brings more rope there than a piece under a low tension takes away. That is the creep of a belt.

The reserve of a piece towards each end is mu a - |ln(T_end / T)|, a the angle to that end. Where no piece of a wrap has
a reserve, the whole cable slips over the input, and no drum angle balances the load.

Place of a piece on the pulley: number k on the first side is number -k - 1 on the second.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.rig.bench import RigCable
from mbcdm_cad.routes import Floats
from mbcdm_cad.storage.compiled import compiled

PIECE_RAD = 0.02
INPUT_WRAP_RAD = 16.0
DRUM_WRAP_RAD = 3.0
# Columns of the constants, one row a cable.
SIGMA, INPUT_RADIUS, DRUM_RADIUS, FREE, EA, PRELOAD, TRANSPORT = range(7)
# The wraps of a cable are that on its input, those on the bodies that it passes, and last that on the drum.
INPUT = 0
# Columns of a wrap: surface angles of its beginning and end, now and at the start, radius, friction, whether
# it begins at an anchor, sum of (T - T_pre) dphi, the factors e^(mu s) to the outer and the next piece of each end, and
# after how many pieces in a row that hold no further ones are looked at, the turns of a passed body for one of the
# drum, and the wrap whose rope stretches as the spring at the anchor gives way.
(
    LOW,
    HIGH,
    LOW_0,
    HIGH_0,
    RADIUS,
    MU,
    ANCHORED,
    SUM,
    PIECE,
    PER_PIECE,
    HIGH_OUTER,
    HIGH_NEXT,
    LOW_OUTER,
    LOW_NEXT,
    ENOUGH,
    PER_DRUM,
    SPRING,
) = range(17)
_COLUMNS = 17
# The outer piece is a mixture of old and new rope and may hold although the next one does not.
_TWO = 2.0
_NEWTON = 60


class Chains(NamedTuple):
    """State of all cables: constants (n, 7), wraps (n, w, 16), pieces' tension (n, w, m) in N, T_e (n,) in N.

    A cable that passes fewer bodies than another has empty wraps in their place.
    """

    constants: Floats
    wraps: Floats
    pieces: Floats
    tension: Floats


def chains(
    cables: tuple[RigCable, ...],
    *,
    piece_rad: float = PIECE_RAD,
    transport: bool = True,
    passed_slip: bool = False,
    input_wrap_rad: float = INPUT_WRAP_RAD,
    drum_wrap_rad: float = DRUM_WRAP_RAD,
    reach_rad: float = 0.8,
) -> Chains:
    """Fresh chains, every piece at its cable's preload.

    ``piece_rad`` is the piece length on the pulley, ``input_wrap_rad`` and ``drum_wrap_rad`` the wraps at angle zero
    (anchor to tangent point), ``reach_rad`` the largest drum angle to come. ValueError where a wrap would run out.
    """
    n = len(cables)
    turns = max(c.drum_radius_m / c.input_radius_m for c in cables)
    # A wrap without an anchor gets the rope that it winds off from its other side.
    anchored = any(c.own_wrap_rad == 0.0 for c in cables)
    if transport and (reach_rad >= drum_wrap_rad or (anchored and reach_rad * turns >= input_wrap_rad)):
        raise ValueError(
            f"a travel of {reach_rad:.4g} rad winds off more than the wraps hold ({input_wrap_rad:.4g} rad on the "
            f"inputs at {turns:.4g} turns a drum turn, {drum_wrap_rad:.4g} rad on the drum)"
        )
    through = 2.0 * max(c.own_wrap_rad for c in cables)
    longest = max(input_wrap_rad + reach_rad * turns, drum_wrap_rad + reach_rad, 2.0 * math.pi, through) + 1.0
    n_wraps, n_pieces = 2 + max(len(c.passed) for c in cables), math.ceil(longest / piece_rad) + 4
    state = Chains(np.zeros((n, 7)), np.zeros((n, n_wraps, _COLUMNS)), np.empty((n, n_wraps, n_pieces)), np.empty(n))
    for j, c in enumerate(cables):
        state.constants[j] = (
            c.sigma,
            c.input_radius_m,
            c.drum_radius_m,
            c.free_span_m,
            c.stiffness_N,
            c.preload_N,
            1.0 if transport else 0.0,
        )
        state.pieces[j] = state.tension[j] = c.preload_N
        on_input = c.own_wrap_rad or input_wrap_rad
        spans = [(INPUT, on_input, c.input_radius_m), (n_wraps - 1, drum_wrap_rad, c.drum_radius_m)]
        spans += [(w, p.angle_rad if passed_slip else 0.0, p.radius_m) for w, p in enumerate(c.passed, start=1)]
        for w, wrap_rad, radius_m in spans:
            wrap = state.wraps[j, w]
            wrap[HIGH] = wrap[HIGH_0] = wrap_rad
            wrap[RADIUS], wrap[MU], wrap[ANCHORED] = radius_m, c.friction, float(w in (INPUT, n_wraps - 1))
            wrap[PER_DRUM] = c.drum_radius_m / radius_m
            wrap[SPRING] = c.anchor_m_N * c.stiffness_N / radius_m if w == n_wraps - 1 else 0.0
            wrap[PIECE], wrap[PER_PIECE] = piece_rad, math.exp(c.friction * piece_rad)
            wrap[ENOUGH] = _TWO
            _factors(wrap)
    return state


@compiled
def _piece_after(angle: float, size: float) -> int:
    """The piece that begins at ``angle`` or holds it inside; rounding must not give the one that ends there."""
    k = math.floor(angle / size)
    return k + 1 if (k + 1) * size <= angle else k


@compiled
def _piece_before(angle: float, size: float) -> int:
    """The piece that ends at ``angle`` or holds it inside."""
    k = math.ceil(angle / size) - 1
    return k - 1 if k * size >= angle else k


@compiled
def _factors(wrap: Floats) -> None:
    """e^(mu s) from each end of the wrap to the middles of its outer piece, which is cut, and of the next."""
    size, mu = wrap[PIECE], wrap[MU]
    outer = wrap[HIGH] - _piece_before(wrap[HIGH], size) * size
    wrap[HIGH_OUTER] = math.exp(mu * outer / 2.0)
    wrap[HIGH_NEXT] = math.exp(mu * (outer + size / 2.0))
    outer = (_piece_after(wrap[LOW], size) + 1) * size - wrap[LOW]
    wrap[LOW_OUTER] = math.exp(mu * outer / 2.0)
    wrap[LOW_NEXT] = math.exp(mu * (outer + size / 2.0))


@compiled
def _slip(pieces: Floats, wrap: Floats, tension: float, write: bool) -> tuple[float, float]:
    """Change of the sum of T dphi by ``tension`` at the ends, and its slope; the pieces are updated if ``write``."""
    size, count = wrap[PIECE], pieces.size
    top, bottom = _piece_before(wrap[HIGH], size), _piece_after(wrap[LOW], size)
    change, slope = 0.0, 0.0
    # With two ends, the nearer end decides whether a piece slips.
    middle = bottom if wrap[ANCHORED] > 0.0 else (top + bottom + 1) // 2
    for end in range(1 if wrap[ANCHORED] > 0.0 else 2):
        step = -1 if end == 0 else 1
        first, last = (top, middle) if end == 0 else (bottom, middle - 1)
        factor = wrap[HIGH_OUTER] if end == 0 else wrap[LOW_OUTER]
        following = wrap[HIGH_NEXT] if end == 0 else wrap[LOW_NEXT]
        held = 0
        for k in range(first, last + step, step):
            extent = min((k + 1) * size, wrap[HIGH]) - max(k * size, wrap[LOW])
            if k == bottom:
                # The spring follows the tension at the anchor.
                extent += wrap[SPRING]
            now = pieces[k % count]
            if now > tension * factor:
                share = factor
            elif now < tension / factor:
                share = 1.0 / factor
            else:
                held += 1
                if held >= wrap[ENOUGH]:
                    break
                factor = following
                following *= wrap[PER_PIECE]
                continue
            held = 0
            change += extent * (tension * share - now)
            slope += extent * share
            if write:
                pieces[k % count] = tension * share
            factor = following
            following *= wrap[PER_PIECE]
    if write:
        wrap[SUM] += change
    return change, slope


@compiled
def _move_high(pieces: Floats, wrap: Floats, to: float, tension: float, preload: float) -> None:
    """Move the wrap's end to the surface angle ``to``: new rope arrives at ``tension``, old leaves as it is."""
    size, count = wrap[PIECE], pieces.size
    while wrap[HIGH] < to:
        k = _piece_after(wrap[HIGH], size)
        edge = (k + 1) * size
        end = min(edge, to)
        there, arriving = wrap[HIGH] - max(k * size, wrap[LOW]), end - wrap[HIGH]
        pieces[k % count] = (pieces[k % count] * there + tension * arriving) / (there + arriving)
        wrap[SUM] += (tension - preload) * arriving
        wrap[HIGH] = end
    while wrap[HIGH] > to:
        k = _piece_before(wrap[HIGH], size)
        end = max(k * size, to)
        wrap[SUM] -= (pieces[k % count] - preload) * (wrap[HIGH] - end)
        wrap[HIGH] = end


@compiled
def _move_low(pieces: Floats, wrap: Floats, to: float, tension: float, preload: float) -> None:
    """As :func:`_move_high` for the wrap's beginning: rope arrives when ``to`` is lower."""
    size, count = wrap[PIECE], pieces.size
    while wrap[LOW] > to:
        k = _piece_before(wrap[LOW], size)
        end = max(k * size, to)
        there, arriving = min((k + 1) * size, wrap[HIGH]) - wrap[LOW], wrap[LOW] - end
        pieces[k % count] = (pieces[k % count] * there + tension * arriving) / (there + arriving)
        wrap[SUM] += (tension - preload) * arriving
        wrap[LOW] = end
    while wrap[LOW] < to:
        k = _piece_after(wrap[LOW], size)
        end = min((k + 1) * size, to)
        wrap[SUM] -= (pieces[k % count] - preload) * (end - wrap[LOW])
        wrap[LOW] = end


@compiled
def carry(chains: Chains, j: int, input_rad: float, drum_rad: float) -> None:
    """Turn the pulleys of cable ``j`` to these angles; no effect without transport."""
    c = chains.constants[j]
    if c[TRANSPORT] == 0.0:
        return
    for w in range(chains.wraps.shape[1]):
        wrap, pieces = chains.wraps[j, w], chains.pieces[j, w]
        if wrap[HIGH_0] == 0.0:
            continue
        if wrap[ANCHORED] == 0.0:
            walked = c[SIGMA] * wrap[PER_DRUM] * drum_rad
            # In this order the wrap never gets a negative length, whichever way it moves.
            low, high = wrap[LOW_0] + walked, wrap[HIGH_0] + walked
            if high > wrap[HIGH]:
                _move_high(pieces, wrap, high, chains.tension[j], c[PRELOAD])
                _move_low(pieces, wrap, low, chains.tension[j], c[PRELOAD])
            else:
                _move_low(pieces, wrap, low, chains.tension[j], c[PRELOAD])
                _move_high(pieces, wrap, high, chains.tension[j], c[PRELOAD])
        else:
            turned = c[SIGMA] * (input_rad if w == INPUT else -drum_rad)
            _move_high(pieces, wrap, wrap[HIGH_0] + turned, chains.tension[j], c[PRELOAD])
        _factors(wrap)


@compiled
def stretch(chains: Chains, j: int, input_rad: float, drum_rad: float, path_m: float) -> float:
    """Growth of the cable's path since the start, m: delta = sigma (r_i theta_i - r_o theta_o) + path."""
    c = chains.constants[j]
    return float(c[SIGMA] * (c[INPUT_RADIUS] * input_rad - c[DRUM_RADIUS] * drum_rad) + path_m)


@compiled
def look(chains: Chains, j: int, stretch_m: float) -> tuple[float, float]:
    """Tension (N) that cable ``j`` would have at a total stretch, and dT/ddelta (N/m); its state does not change."""
    c = chains.constants[j]
    held = -c[EA] * stretch_m
    for w in range(chains.wraps.shape[1]):
        held += chains.wraps[j, w, RADIUS] * chains.wraps[j, w, SUM]
    tension = chains.tension[j]
    slope = c[FREE]
    # With some pieces tightening and others slackening the balance is neither convex nor concave: Newton needs a
    # bracket.
    low, high = 0.0, math.inf
    for _ in range(_NEWTON):
        miss, slope = held + (tension - c[PRELOAD]) * c[FREE], c[FREE]
        for w in range(chains.wraps.shape[1]):
            wrap = chains.wraps[j, w]
            if wrap[HIGH_0] > 0.0:
                change, rate = _slip(chains.pieces[j, w], wrap, tension, False)
                miss += wrap[RADIUS] * change
                slope += wrap[RADIUS] * rate
        if tension == 0.0 and miss >= 0.0:
            return 0.0, 0.0
        if miss > 0.0:
            high = tension
        else:
            low = tension
        following = max(tension - miss / slope, 0.0)
        if following > 0.0 and following != tension and not (low < following < high):
            following = 0.5 * (low + high)
        if abs(following - tension) <= 1e-13 * c[PRELOAD]:
            return following, c[EA] / slope
        tension = following
    return tension, c[EA] / slope


@compiled
def settle(chains: Chains, j: int, tension_N: float) -> None:
    """Set the cable's tension to ``tension_N`` and let the pieces slip that this tension makes slip."""
    chains.tension[j] = tension_N
    for w in range(chains.wraps.shape[1]):
        if chains.wraps[j, w, HIGH_0] > 0.0:
            _slip(chains.pieces[j, w], chains.wraps[j, w], tension_N, True)


@compiled
def advance(chains: Chains, j: int, input_rad: float, drum_rad: float, path_m: float) -> float:
    """Bring cable ``j`` to these angles and this extra path; returns its tension, N."""
    carry(chains, j, input_rad, drum_rad)
    tension = look(chains, j, stretch(chains, j, input_rad, drum_rad, path_m))[0]
    settle(chains, j, tension)
    return float(tension)


@compiled
def strain(chains: Chains, j: int, strains: Floats) -> None:
    """Add a stress-free strain of the rope relative to the pulley to each wrap; it lowers the tension of stuck rope.

    ``strains`` (w,), by wrap: strain of the rope minus that of the pulley under it. The strain of the free span belongs
    in the path.
    """
    c = chains.constants[j]
    for w in range(chains.wraps.shape[1]):
        wrap, pieces = chains.wraps[j, w], chains.pieces[j, w]
        if wrap[HIGH_0] == 0.0 or strains[w] == 0.0:
            continue
        # After a strain the tension need not be monotone along the wrap: from now on all pieces must be tested.
        size, wrap[ENOUGH] = wrap[PIECE], math.inf
        for k in range(_piece_after(wrap[LOW], size), _piece_before(wrap[HIGH], size) + 1):
            extent = min((k + 1) * size, wrap[HIGH]) - max(k * size, wrap[LOW])
            now = pieces[k % pieces.size]
            then = max(now - c[EA] * strains[w], 0.0)
            pieces[k % pieces.size] = then
            # The length on the pulley is constant: the lower tension shortens the rope as much as the strain lengthens
            # it.
            wrap[SUM] += extent * (then - now + c[EA] * strains[w])


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
