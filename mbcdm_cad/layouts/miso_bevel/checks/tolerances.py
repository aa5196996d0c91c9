"""Gaps against the sum of the tolerances of the parts: a gap smaller than this sum may vanish in a built drive."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from math import ceil, floor, sqrt

import numpy as np

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, at_most, noted
from mbcdm_cad.checks.remedies import rounded
from mbcdm_cad.checks.transfer import EDGE_BREAK_MM, body_gaps_mm
from mbcdm_cad.layouts.miso_bevel import gap_tolerances as gaps
from mbcdm_cad.layouts.miso_bevel.checks.spans import guide_wall_gaps_mm
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.model.stack_up import StackUp, tightest
from mbcdm_cad.parts.making import model_tolerances

Stacks = Callable[[BevelLayout], list[StackUp]]
# Standard deviations on either side that hold 95 % of all drives.
MOST_DRIVES = 1.96
# Least gain of the self-clearance for a longer lead: the span also leaves more steeply (derived, rounded down).
LEAD_GAIN = 0.85


def self_clearance(s: BevelLayout) -> list[StackUp]:
    """Leaving span over its own last turn."""
    s.levels  # noqa: B018 - without levels there is no winding
    return [StackUp(f"{c.name} from its own last turn, mm", *gaps.self_clearance(s.drive, c)) for c in s.steps]


def transfer_gap(s: BevelLayout) -> list[StackUp]:
    """Half a cable over the gap at each transfer point."""
    lands, guide = s.drum.lands, s.guide
    return [
        StackUp(
            f"half a cable over the gap at the transfer of step {c.step}, mm",
            s.flank_mm - (land.y_start - surface),
            gaps.transfer_contributions(s.drive, c),
        )
        for c, land, surface in zip(s.steps, lands, guide.surface_radii, strict=True)
    ]


def bodies_clear(s: BevelLayout) -> list[StackUp]:
    """Guide and drum before they touch."""
    return [
        StackUp(f"{what}, mm", gap, gaps.bodies_contributions(s.drive, s.steps[step]))
        for what, step, gap in body_gaps_mm(s)
    ]


def land_edge(s: BevelLayout) -> list[StackUp]:
    """Contact lines from the broken edges of their lands."""
    return [
        StackUp(
            f"contact line of {c.name} from its land's broken edge, mm",
            c.guide_radius_mm - land.y_start - EDGE_BREAK_MM,
            gaps.land_edge_contributions(s.drive, c),
        )
        for c, land in zip(s.steps, s.drum.lands, strict=True)
    ]


def flank_gap(s: BevelLayout) -> list[StackUp]:
    """Flanks on the drum from the wall of the next land."""
    lands = s.drum.lands
    return [
        StackUp(
            f"flank of {c.name} on the drum from the next land's wall, mm",
            above.y_start - c.guide_radius_mm - s.flank_mm,
            gaps.flank_contributions(s.drive, c),
        )
        for c, above in zip(s.steps[:-1], lands[1:], strict=True)
    ]


def guide_gap(s: BevelLayout) -> list[StackUp]:
    """Cables on the guide from the walls of their steps."""
    return [
        StackUp(f"{c.name} on the guide from its walls, mm", gap, gaps.guide_wall_contributions(s.drive, c))
        for c, gap in s.once("guide_walls", guide_wall_gaps_mm)
    ]


_STACKS: tuple[Stacks, ...] = (self_clearance, transfer_gap, bodies_clear, land_edge, flank_gap, guide_gap)


def stacks(s: BevelLayout) -> Iterator[StackUp]:
    """The tightest stack of each gap, and that of each ratio, whose margin is the mismatch that a pair may have."""
    for of in _STACKS:
        yield tightest(of(s))
    yield tightest(
        StackUp(f"total ratio of {c.name}, relative", np.inf, gaps.ratio_contributions(s.drive, c)) for c in s.steps
    )


def _against_stack(of: Stacks, s: BevelLayout) -> Comparison:
    """The smallest gap is compared with the root sum of squares of the tolerances that change it."""
    stack = tightest(of(s))
    figure = stack.figure.removesuffix(", mm")
    note = f"sum of the tolerances (RSS); worst case {stack.worst_case:.3g} mm; largest share: {stack.costliest.name}"
    return at_least(figure, stack.margin, stack.rss, "mm", note)


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


def transmission_error(s: BevelLayout) -> Comparison:
    """Largest error of the drum's angle over the travel that the tolerances cause: linear theory, two sigma."""
    from mbcdm_cad.model.tolerance import linear_error

    names, error = linear_error(s.loads.si, s.half_travel_rad, model_tolerances(s.drive))
    whole = np.sqrt((error**2).sum(axis=0))
    pose = int(np.argmax(whole))
    most = names[int(np.argmax(np.abs(error[:, pose])))]
    return noted(
        "drum off by at most, over the travel, in 95 % of drives",
        MOST_DRIVES * float(whole[pose]) * 1e3,
        "mrad",
        f"zero at the centred drum; most by the {most}",
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


def _stack_check(check_id: str, title: str, of: Stacks, widen: str, gain: float = 1.0) -> Check:
    return Check(
        check_id,
        title,
        "root sum of squares of the tolerances in parts/fits.py and making",
        partial(_against_stack, of),
        "warn",
        advice=partial(_wider_or_closer, of, widen, gain),
    )


CHECKS = (
    _stack_check(
        "self_clearance_stack",
        "Free span clears its own last turn with tolerances",
        self_clearance,
        "raise rope.helix_lead_mm",
        LEAD_GAIN,
    ),
    _stack_check(
        "transfer_gap_stack",
        "Transfer gap stays under half a cable with tolerances",
        transfer_gap,
        "lower clearances.transfer_gap_mm, or raise clearances.land_edge_mm,",
    ),
    _stack_check(
        "bodies_clear_stack",
        "Guide and drum do not touch with tolerances",
        bodies_clear,
        "raise clearances.transfer_gap_mm, or lower clearances.land_edge_mm,",
    ),
    _stack_check(
        "land_edge_stack",
        "Contact lines stay on their lands with tolerances",
        land_edge,
        "raise clearances.land_edge_mm, or lower clearances.transfer_gap_mm,",
    ),
    _stack_check(
        "flank_stack",
        "Cables on the drum clear the next land with tolerances",
        flank_gap,
        "lower clearances.land_edge_mm, or widen the steps of the guide's radii,",
    ),
    _stack_check(
        "guide_walk_stack",
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
    Check("transmission_error", "Transmission error by the tolerances", "linear theory, two sigma", transmission_error),
)
