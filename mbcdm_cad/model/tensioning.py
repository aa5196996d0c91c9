"""Setting the preload: travel of the terminal, nut turns, pitch of a plucked span, and the instructions for a drive.

SI throughout. Lengths are those of the whole cable between its two ends, along the centre line. Two cases are
distinguished: a cable *worked in* (the drum was swung a few times over its travel, so that the tension is the same
along the whole cable) and one just tightened, where friction on the wraps keeps the far part of the rope from being
tensioned.

Works on plain data of each cable; a configuration says what they are. SI throughout.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import cos, cosh, exp, pi, sin, sinh, sqrt
from typing import Any

import numpy as np

from mbcdm_cad.routes import Floats

# Wires of a rope and its diameter over theirs (ISO 2408 geometry); a braid's fibres bend freely.
WIRES = {"7x7": (49, 9.0), "7x19": (133, 15.0), "1x19": (19, 5.0)}


@dataclass(frozen=True)
class TensionedRope:
    """Properties of the rope: EA, mass, bending stiffness with wires free and bonded, and shares; SI."""

    axial_stiffness_N: float
    mass_kg_m: float
    loose_N_m2: float
    bonded_N_m2: float
    bedding_share: float
    cut_tolerance_m: float
    friction: float
    setting_m: float = 0.0  # what both ends of a cable, or the one of a side, give off at their first loads
    tails_m: float = 0.0  # rope that these ends use themselves
    anchor_m_N: float = 0.0  # give of the springs under a terminal's nut


def rope_stiffnesses(
    construction: str, diameter_m: float, axial_stiffness_N: float, wire_modulus_Pa: float
) -> tuple[float, float]:
    """Bending stiffness (N m^2) with wires that slide freely, and bonded into a round bar of the same EA: EA d^2/16."""
    bonded = axial_stiffness_N * diameter_m**2 / 16.0
    if construction not in WIRES:
        return 0.0, bonded
    count, ratio = WIRES[construction]
    return min(count * wire_modulus_Pa * pi / 64.0 * (diameter_m / ratio) ** 4, bonded), bonded


# Beyond this argument cosh and sinh are equal to machine precision, and soon overflow.
_LARGE = 30.0
# First root of cosh b cos b = 1: a beam clamped at both ends, without tension.
_CLAMPED_BEAM = 4.7300407
_HALVINGS = 60


@dataclass(frozen=True)
class TakeUp:
    """Take-up of a terminal from slack to its highest preload, m (derived).

    ``cut_m`` is the whole band of the cut length: a cable at the long end of its tolerance needs all of it, one at the
    short end none.
    """

    elastic_m: float
    bedding_m: float
    cut_m: float
    setting_m: float = 0.0

    @property
    def total_m(self) -> float:
        """Take-up that the worst cable needs."""
        return self.elastic_m + self.bedding_m + self.cut_m + self.setting_m

    @property
    def nominal_m(self) -> float:
        """Take-up used by a cable of nominal length, bedded in and at its preload."""
        return self.elastic_m + self.bedding_m + self.cut_m / 2 + self.setting_m


def take_up(
    length_m: float,
    highest_preload_N: float,
    axial_stiffness_N: float,
    bedding_share: float,
    cut_tolerance_m: float,
    setting_m: float = 0.0,
) -> TakeUp:
    """Take-up of one cable whose tension is the same all along: T L / EA + bedding share x L + both cut tolerances.

    ``length_m`` is the length under tension, without the parts inside swaged fittings; ``setting_m`` what its ends give
    off at their first loads. Raises ``ValueError`` for a figure below zero or a stiffness of zero.
    """
    figures = (length_m, highest_preload_N, bedding_share, cut_tolerance_m, setting_m)
    if min(figures) < 0.0 or axial_stiffness_N <= 0.0:
        raise ValueError(
            f"take-up of a length, tension, share and tolerance below zero: {figures}, EA {axial_stiffness_N}"
        )
    elastic = highest_preload_N * length_m / axial_stiffness_N
    return TakeUp(elastic, bedding_share * length_m, 2.0 * cut_tolerance_m, setting_m)


def untensioned_length_m(length_m: float, tension_N: float, axial_stiffness_N: float) -> float:
    """Length to cut, slack, of a cable that is ``length_m`` long at ``tension_N``: l / (1 + T/EA)."""
    return length_m / (1.0 + tension_N / axial_stiffness_N)


def reached_length_m(pieces: Sequence[tuple[float, float]], friction: float) -> float:
    """Effective length, m, of a cable with friction under a small pull: the length of a straight cable as stiff.

    ``pieces`` has (length in m, wrap angle in rad) from the pulled end: 0 rad for a straight piece or a wrap on a
    pulley that turns freely. The added tension falls by e^(-mu phi) over each (derived from the capstan equation).
    """
    reached, share = 0.0, 1.0
    for length_m, angle_rad in pieces:
        x = friction * angle_rad
        reached += share * length_m * ((1.0 - exp(-x)) / x if x > 0.0 else 1.0)
        share *= exp(-x)
    return reached


def plucked_Hz(
    tension_N: float, mass_kg_m: float, length_m: float, bending_stiffness_N_m2: float = 0.0, clamped: bool = True
) -> float:
    """Lowest frequency of a span plucked sideways: a beam under tension, clamped or pinned at both ends.

    Without bending stiffness it is the string's f = sqrt(T/m')/(2 l). Pinned: f sqrt(1 + pi^2 EI/(T l^2)). Clamped:
    the lowest root of 2 a b (1 - cosh a cos b) + (a^2 - b^2) sinh a sin b = 0 with a^2 = b^2 + T l^2/EI
    (Euler-Bernoulli beam under tension), found by bisection.
    """
    string = sqrt(tension_N / mass_kg_m) / (2.0 * length_m)
    if bending_stiffness_N_m2 <= 0.0:
        return string
    pull = tension_N * length_m**2 / bending_stiffness_N_m2
    if not clamped:
        return string * sqrt(1.0 + pi**2 / pull)

    b = _clamped_root(lambda b: sqrt(b * b + pull))
    return sqrt(b * b + pull) * b * sqrt(bending_stiffness_N_m2 / mass_kg_m) / (2.0 * pi * length_m**2)


def tension_from_pitch_N(
    frequency_Hz: float, mass_kg_m: float, length_m: float, bending_stiffness_N_m2: float = 0.0, clamped: bool = True
) -> float:
    """Tension of a span that sounds at ``frequency_Hz``; 0 where its bending stiffness alone would sound higher.

    The inverse of :func:`plucked_Hz`: a b follows from the frequency, and T l^2/EI = a^2 - b^2 from the root.
    """
    string = 4.0 * mass_kg_m * (length_m * frequency_Hz) ** 2
    if bending_stiffness_N_m2 <= 0.0:
        return string
    stiffness = bending_stiffness_N_m2 / length_m**2
    if not clamped:
        return max(0.0, string - pi**2 * stiffness)
    product = pi * sqrt(string / stiffness)
    if product <= _CLAMPED_BEAM**2:
        return 0.0
    b = _clamped_root(lambda b: product / b)
    return stiffness * ((product / b) ** 2 - b * b)


def _clamped_root(a_of: Callable[[float], float]) -> float:
    """The root b of the clamped beam under tension for a given as a function of b: between string and beam alone."""

    def balance(b: float) -> float:
        a = a_of(b)
        if a > _LARGE:
            return -2.0 * a * b * cos(b) + (a * a - b * b) * sin(b)
        return (2.0 * a * b * (1.0 - cosh(a) * cos(b)) + (a * a - b * b) * sinh(a) * sin(b)) / cosh(a)

    low, high = pi, 1.0001 * _CLAMPED_BEAM
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if balance(middle) > 0.0 else (low, middle)
    return 0.5 * (low + high)


def influence(stiffness_N_m: Any, lever_m: Any) -> Floats:
    """Change of each tension (row) when one terminal (column) is drawn in by a metre, inputs held, drum free; N/m.

    ``stiffness_N_m`` (n,) is EA/L of each cable, ``lever_m`` (n,) its signed lever at the drum, sigma r_o. The drum
    turns until the sum of sigma r_o T is unchanged: K_kj = k_k (d_kj - l_k k_j l_j / sum k l^2) (derived).
    """
    k, lever = np.asarray(stiffness_N_m, dtype=float), np.asarray(lever_m, dtype=float)
    held = k * lever
    return np.asarray(np.diag(k) - np.outer(held, held) / (held * lever).sum())


def taken_from_others(stiffness_N_m: Any, lever_m: Any) -> Floats:
    """N that each cable (row) loses for each N that another (column) gains by its own nut; (n, n), diagonal -1."""
    change = influence(stiffness_N_m, lever_m)
    return np.asarray(-change / np.diag(change)[None, :])


@dataclass(frozen=True, eq=False)
class Tightening:
    """One pull on one nut: which cable (index), and the tensions (N) of all cables after it."""

    cable: int
    drawn_in_m: float
    tension_N: Floats


def sequence(
    stiffness_N_m: Any, lever_m: Any, goal_N: Any, order: tuple[int, ...], within: float = 0.02
) -> list[Tightening]:
    """Tighten cables in ``order``, each to its goal, round after round, until all are within ``within`` of their goals.

    From slack, inputs held, drum free and unloaded, cables worked in after each pull; a cable never pushes. Raises
    ``ValueError`` if 50 rounds are not enough: goals whose torques on the drum do not balance cannot be reached.
    """
    k, lever, goal = (np.asarray(a, dtype=float) for a in (stiffness_N_m, lever_m, goal_N))
    drawn = np.zeros_like(k)
    done: list[Tightening] = []
    for _ in range(50):
        for j in order:
            before = drawn[j]
            drawn[j] = _drawn_for(k, lever, drawn, j, goal[j])
            done.append(Tightening(j, float(drawn[j] - before), balanced_tension_N(k, lever, drawn)))
        if np.all(np.abs(done[-1].tension_N - goal) <= within * goal):
            return done
    short = np.round(done[-1].tension_N, 1).tolist()
    raise ValueError(f"tensions stay at {short} N, wanted {goal.tolist()}: their torques on the drum do not balance")


def balanced_tension_N(stiffness_N_m: Floats, lever_m: Floats, drawn_in_m: Floats) -> Floats:
    """Tensions in N, drum in balance, terminals ``drawn_in_m`` beyond slack: T = k (x - l theta)+."""
    # The sum of l T falls with theta and is linear between the angles at which a cable goes slack.
    corners = np.sort(drawn_in_m / lever_m)
    pull = lever_m * stiffness_N_m
    sums = (pull * np.maximum(drawn_in_m - lever_m * corners[:, None], 0.0)).sum(axis=1)
    after = int(np.searchsorted(-sums, 0.0))
    if after == 0 or after == corners.size:
        # All cables that are still tight pull in one direction: the drum turns until they are slack.
        theta = corners[0] if after == 0 else corners[-1]
    else:
        share = sums[after - 1] / (sums[after - 1] - sums[after]) if sums[after - 1] > sums[after] else 0.0
        theta = corners[after - 1] + share * (corners[after] - corners[after - 1])
    tension = stiffness_N_m * np.maximum(drawn_in_m - lever_m * theta, 0.0)
    return np.asarray(tension)


def _drawn_for(k: Floats, lever: Floats, drawn: Floats, j: int, goal_N: float) -> float:
    """How far cable ``j`` is drawn in at its goal, m; if it cannot reach it, as far as a spring with fixed ends."""
    limit = 20.0 * goal_N / k[j] + float(drawn.max(initial=0.0))
    low, high = 0.0, limit
    trial = drawn.copy()
    for _ in range(60):
        trial[j] = 0.5 * (low + high)
        if balanced_tension_N(k, lever, trial)[j] < goal_N:
            low = trial[j]
        else:
            high = trial[j]
    if high >= limit * (1.0 - 1e-9):
        # No other cable pulls against it yet: draw it in as far as the goal needs when the others hold the drum.
        return float(max(drawn[j], goal_N / k[j]))
    return float(0.5 * (low + high))


def limits_of_pitch_Hz(
    tension_N: float, mass_kg_m: float, length_m: float, loose_N_m2: float, bonded_N_m2: float
) -> tuple[float, float]:
    """Plucked frequency from free wires with ends that turn to bonded wires with ends that do not."""
    return (
        plucked_Hz(tension_N, mass_kg_m, length_m, loose_N_m2, clamped=False),
        plucked_Hz(tension_N, mass_kg_m, length_m, bonded_N_m2, clamped=True),
    )


# If one pitch corresponds to a range of tensions wider than this, the pitch alone cannot set the preload.
USABLE_SPREAD = 0.25


@dataclass(frozen=True)
class TensionedCable:
    """One cable: ``pieces`` (m, rad) from the end that is pulled, ``lever_m`` at the drum with its sign."""

    name: str
    preload_N: float
    highest_preload_N: float
    length_m: float
    ends_m: float  # of it inside stop and sleeve
    lever_m: float
    pieces: tuple[tuple[float, float], ...]
    spans_m: tuple[float, ...]
    travel_m: float


@dataclass(frozen=True)
class CableSetting:
    """How one cable is set."""

    name: str
    preload_N: float
    cut_length_m: float
    cut_tolerance_m: float
    finished_m: float  # slack, from the stop's face to the front of the sleeve
    need: TakeUp
    travel_m: float
    turns_from_slack: float
    turns_per_N: float
    turns_per_N_first: float  # before the drum is swung: friction holds the far end back
    span_m: tuple[float, ...]
    string_Hz: tuple[float, ...]
    pitch_Hz: tuple[tuple[float, float], ...]
    tension_spread: float  # of the tension read from a pitch, for want of the bending stiffness
    bedding_loss_N: float  # by fixed ends: it must be retightened


@dataclass(frozen=True)
class Pull:
    """One pull on one nut: turns (negative: eased), and the tension of every cable after it."""

    cable: str
    turns: float
    tension_N: tuple[float, ...]


@dataclass(frozen=True)
class TensioningPlan:
    """All cables, what one takes from another (row loses per N that the column gains), and the order of pulls."""

    pitch_m: float
    cables: tuple[CableSetting, ...]
    taken: tuple[tuple[float, ...], ...]
    pulls: tuple[Pull, ...]

    @property
    def by_pitch(self) -> bool:
        """Whether the pitch of a span alone gives its tension accurately enough."""
        return all(c.span_m and c.tension_spread <= USABLE_SPREAD for c in self.cables)


def tensioning_plan(cables: Sequence[TensionedCable], rope: TensionedRope, pitch_m: float) -> TensioningPlan:
    """The plan for cables tightened one after the other in the given order; ``pitch_m`` of the nuts' thread."""
    stiffness = np.array([1.0 / (c.length_m / rope.axial_stiffness_N + rope.anchor_m_N) for c in cables])
    lever = np.array([c.lever_m for c in cables])
    # Preloads are stated with both angles zero; if their torques differ, the drum turns until the cables balance.
    goal = balanced_tension_N(stiffness, lever, np.array([c.preload_N for c in cables]) / stiffness)
    pulls = sequence(stiffness, lever, goal, tuple(range(len(cables))))
    return TensioningPlan(
        pitch_m,
        tuple(_setting(c, rope, pitch_m) for c in cables),
        tuple(tuple(float(v) for v in row) for row in taken_from_others(stiffness, lever)),
        tuple(Pull(cables[p.cable].name, p.drawn_in_m / pitch_m, tuple(float(t) for t in p.tension_N)) for p in pulls),
    )


def _setting(c: TensionedCable, rope: TensionedRope, pitch_m: float) -> CableSetting:
    def slack(length_m: float) -> float:
        return untensioned_length_m(length_m, c.preload_N, rope.axial_stiffness_N) / (1.0 + rope.bedding_share)

    per_N = (c.length_m / rope.axial_stiffness_N + rope.anchor_m_N) / pitch_m
    first = (reached_length_m(c.pieces, rope.friction) / rope.axial_stiffness_N + rope.anchor_m_N) / pitch_m
    pitches = tuple(
        limits_of_pitch_Hz(c.preload_N, rope.mass_kg_m, span, rope.loose_N_m2, rope.bonded_N_m2) for span in c.spans_m
    )
    spreads = [
        1.0 - tension_from_pitch_N(low, rope.mass_kg_m, span, rope.bonded_N_m2) / c.preload_N
        for (low, _), span in zip(pitches, c.spans_m, strict=True)
    ]
    return CableSetting(
        name=c.name,
        preload_N=c.preload_N,
        cut_length_m=slack(c.length_m) + rope.tails_m,
        cut_tolerance_m=rope.cut_tolerance_m,
        finished_m=slack(c.length_m - c.ends_m),
        need=take_up(
            c.length_m,
            c.highest_preload_N,
            rope.axial_stiffness_N,
            rope.bedding_share,
            rope.cut_tolerance_m,
            rope.setting_m,
        ),
        travel_m=c.travel_m,
        turns_from_slack=per_N * c.preload_N,
        turns_per_N=per_N,
        turns_per_N_first=first,
        span_m=c.spans_m,
        string_Hz=tuple(plucked_Hz(c.preload_N, rope.mass_kg_m, span) for span in c.spans_m),
        pitch_Hz=pitches,
        tension_spread=max(spreads, default=1.0),
        bedding_loss_N=rope.bedding_share * rope.axial_stiffness_N,
    )
