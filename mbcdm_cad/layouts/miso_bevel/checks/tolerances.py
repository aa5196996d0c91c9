"""Gaps against the sum of the tolerances of the parts: a gap smaller than this sum may vanish in a built drive."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from math import ceil, floor, sqrt

import numpy as np

from mbcdm_cad.checks.comparison import Check, Comparison, at_most
from mbcdm_cad.checks.remedies import rounded
from mbcdm_cad.checks.stacks import TRANSMISSION_ERROR, Stacks, TransferStacks, ratio_contributions, stack_check
from mbcdm_cad.layouts.miso_bevel import gap_tolerances as gaps
from mbcdm_cad.layouts.miso_bevel.checks.spans import guide_wall_gaps_mm
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.model.stack_up import StackUp, tightest

_GUIDE = TransferStacks("guide", "axle in the frame")
# Least gain of the self-clearance for a longer lead: the span also leaves more steeply (derived, rounded down).
LEAD_GAIN = 0.85


def self_clearance(s: BevelLayout) -> list[StackUp]:
    """Leaving span over its own last turn."""
    s.levels  # noqa: B018 - without levels there is no winding
    return [StackUp(f"{c.name} from its own last turn, mm", *gaps.self_clearance(s.drive, c)) for c in s.steps]


def flank_gap(s: BevelLayout) -> list[StackUp]:
    """Flanks on the drum from the wall of the next land."""
    lands = s.drum.lands
    return [
        StackUp(
            f"flank of {c.name} on the drum from the next land's wall, mm",
            above.y_start - c.guide_radius_mm - s.flank_mm,
            _GUIDE.contributions(s.drive, c, 1.0),
        )
        for c, above in zip(s.steps[:-1], lands[1:], strict=True)
    ]


def guide_gap(s: BevelLayout) -> list[StackUp]:
    """Cables on the guide from the walls of their steps."""
    return [
        StackUp(f"{c.name} on the guide from its walls, mm", gap, gaps.guide_wall_contributions(s.drive, c))
        for c, gap in s.once("guide_walls", guide_wall_gaps_mm)
    ]


_STACKS: tuple[Stacks, ...] = (self_clearance, _GUIDE.gap, _GUIDE.bodies_clear, _GUIDE.land_edge, flank_gap, guide_gap)


def stacks(s: BevelLayout) -> Iterator[StackUp]:
    """The tightest stack of each gap, and that of each ratio, whose margin is the mismatch that a pair may have."""
    for of in _STACKS:
        yield tightest(of(s))
    yield tightest(
        StackUp(f"total ratio of {c.name}, relative", np.inf, ratio_contributions(s.drive, c)) for c in s.steps
    )


def pair_mismatch(s: BevelLayout) -> Comparison:
    """Tension that radii within their tolerances may cause in a pair of cables over the travel, from the model."""
    from mbcdm_cad.model.equilibrium import solve_equilibrium

    pairs = [[c for c in s.steps if c.input_name == name] for name in s.drive.input_names]
    found = [StackUp("", 0.0, gaps.pair_path_contributions(s.drive, (pair[0], pair[1]))) for pair in pairs]
    si, idle = s.loads.si, s.loads.idle
    # One pair at a time has an error: half its RSS on each of its cables, both longer or both shorter.
    path = np.array(
        [
            [stack.rss / 2e3 if c in pair else 0.0 for pair, stack in zip(pairs, found, strict=True)]
            for c in s.drive.cables
        ]
    )
    moved = solve_equilibrium(si, np.zeros(len(pairs)), path_m=path).tension_N
    change = np.abs(moved - idle[:, None]).max(axis=1)
    k = int(np.argmax(change / [c.preload_N for c in s.drive.cables]))
    cable = s.drive.cables[k]
    stack = found[s.drive.input_names.index(cable.input_name)]
    peak, left = s.drive.loads.peak_torque_Nm, []
    for angle in (s.half_travel_rad, -s.half_travel_rad):
        on_input, on_drum = s.wraps_rad(angle)
        wound = si.with_(input_wrap_rad=on_input, drum_wrap_rad=on_drum)
        left.append(solve_equilibrium(wound, np.array([peak, -peak])).tension_N.min(axis=1))
    spare = float((np.min(left, axis=0) / si.preload_N).min())
    return at_most(
        f"by radii within their tolerances (RSS {stack.rss:.3g} mm, worst case {stack.worst_case:.3g} mm) "
        f"{cable.name} changes by {change[k]:.3g} N over the travel:",
        change[k] / cable.preload_N,
        spare,
        "of T_pre",
        f"what the peak torque leaves in the loosest cable; largest share: {stack.costliest.name}",
    )


def _tighter(s: BevelLayout) -> str:
    """The preload that is larger by what the loosest cable lacks."""
    found = pair_mismatch(s)
    most = max(c.preload_N for c in s.drive.cables)
    return (
        f"raise rope.preload_N to about {rounded(most * (1.0 - found.limit + found.actual), ceil)}, or turn the "
        "lands of the input pulleys to a closer fit"
    )


def _wider_or_closer(of: Stacks, widen: str, gain: float, s: BevelLayout) -> str:
    """Advice: the increase of the gap, or the closer tolerance of the costliest part; no search, as all is linear."""
    stack = tightest(of(s))
    most = stack.costliest
    others = stack.rss**2 - most.shift**2
    room = f"{widen} by {ceil(-stack.spare / gain * 1e4) / 1e4:g} mm"
    left = stack.margin**2 - others if stack.margin > 0.0 else -1.0
    if left <= 0.0:
        return f"{room}; no single tolerance held closer is enough"
    closer = floor(sqrt(left) / abs(most.per_unit) * 1e4) / 1e4
    return f"{room} or hold the {most.name} to {closer:g} mm instead of {most.tolerance:.4g}"


def _stack_check(name: str, title: str, of: Stacks, widen: str, gain: float = 1.0) -> Check:
    return stack_check(name, title, of, partial(_wider_or_closer, of, widen, gain))


CHECKS = (
    _stack_check(
        "self_clearance",
        "Free span clears its own last turn with tolerances",
        self_clearance,
        "raise rope.helix_lead_mm",
        LEAD_GAIN,
    ),
    _stack_check(
        "transfer_gap",
        "Transfer gap stays under half a cable with tolerances",
        _GUIDE.gap,
        "lower clearances.transfer_gap_mm, or raise clearances.land_edge_mm,",
    ),
    _stack_check(
        "bodies_clear",
        "Guide and drum do not touch with tolerances",
        _GUIDE.bodies_clear,
        "raise clearances.transfer_gap_mm, or lower clearances.land_edge_mm,",
    ),
    _stack_check(
        "land_edge",
        "Contact lines stay on their lands with tolerances",
        _GUIDE.land_edge,
        "raise clearances.land_edge_mm, or lower clearances.transfer_gap_mm,",
    ),
    _stack_check(
        "flank",
        "Cables on the drum clear the next land with tolerances",
        flank_gap,
        "lower clearances.land_edge_mm, or widen the steps of the guide's radii,",
    ),
    _stack_check(
        "guide_walk",
        "Cables on the guide clear its walls with tolerances",
        guide_gap,
        "widen half the steps of the drum's radii",
    ),
    Check(
        "pair_mismatch_stack",
        "Cables of one input agree with tolerances",
        "root sum of squares of the radii's fits; no cable slack at the peak torque",
        pair_mismatch,
        "warn",
        advice=_tighter,
    ),
    TRANSMISSION_ERROR,
)
