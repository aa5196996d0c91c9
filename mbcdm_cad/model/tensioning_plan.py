"""Instructions to set the preloads of a drive: lengths to cut, nut turns, pitch of the spans, order, bedding-in loss.

Works on plain data of each cable; a configuration says what they are. SI throughout.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mbcdm_cad.model.tensioning import (
    TakeUp,
    TensionedRope,
    balanced_tension_N,
    bedding_loss_N,
    limits_of_pitch_Hz,
    plucked_Hz,
    reached_length_m,
    sequence,
    take_up,
    taken_from_others,
    tension_from_pitch_N,
    untensioned_length_m,
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
    bedding_loss_N: float


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
        bedding_loss_N=bedding_loss_N(rope.bedding_share, rope.axial_stiffness_N),
    )
