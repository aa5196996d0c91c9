"""Gaps of the winding with tolerances, and the wrap on the drum over the travel.

Both ends of the cable are fixed to the drum. A wrap shorter than the slip zone is therefore legal, but Eq. (5) and (6)
are no longer valid.
"""

from collections.abc import Iterator
from math import cos, hypot, inf, sin

import numpy as np

from mbcdm_cad.checks.comparison import Comparison, Family, Findings, check, noted
from mbcdm_cad.checks.design_variables import up
from mbcdm_cad.checks.geometry import CABLE_GAP_MM
from mbcdm_cad.checks.terminals import bodies_of
from mbcdm_cad.checks.transfer import MORE_WRAP, SLIPS, WRAPS, stack_check, transmission_error, wrap_under_turn
from mbcdm_cad.layouts.siso_spur.checks.winding import turn_distance_mm
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.siso_spur.pulley import without_bearings
from mbcdm_cad.model.tolerance import Contribution, StackUp, tightest
from mbcdm_cad.parts.drum_sector.dims import WHOLE_DEG
from mbcdm_cad.parts.drum_sector.sizes import pocket_end_rad
from mbcdm_cad.parts.making import axial_play_mm, body_accuracy, land_band_mm, rope_band_mm


def turn_gap(s: SpurLayout) -> list[StackUp]:
    """A span and the turn beside it on the input."""
    drive = s.drive
    gap = turn_distance_mm(drive.input_radius_mm, drive.helix_lead_mm) - drive.cable.diameter_mm
    return [
        StackUp(
            "span from the turn beside it, mm",
            gap,
            (
                # Half a rope on each side of the gap: together one diameter.
                Contribution("rope's diameter", rope_band_mm(drive)),
                Contribution("lead of the groove over a turn", body_accuracy(drive, "pulley").position_mm),
            ),
        )
    ]


def rim_edge(s: SpurLayout) -> list[StackUp]:
    """The cable on the drum and the nearer face of its rim."""
    drive = s.drive
    frame, drum = body_accuracy(drive, "frame"), body_accuracy(drive, "drum")
    plane, (low, *_, high) = drive.on_drum_mm + s.flank_mm, s.drum.lands
    return [
        StackUp(
            "flank of the cable from the rim's face, mm",
            min(-plane - low.y_start, high.y_end - plane),
            (
                Contribution("place of the input's bearings along y", frame.position_mm),
                Contribution("axial play of the input", axial_play_mm(drive), 0.5),
                Contribution("place of the drum's bearings in the frame", frame.position_mm),
                Contribution("place of the rim's face on the drum", drum.position_mm),
                Contribution("rope's diameter", rope_band_mm(drive), 0.5),
            ),
        )
    ]


def stacks(s: SpurLayout) -> Iterator[StackUp]:
    """The stack of each gap and of the ratio; of several, the one with the least reserve."""
    for of in (turn_gap, rim_edge):
        yield tightest(of(s))
    r_o, r_i = s.drive.drum_radius_mm, s.drive.input_radius_mm
    yield StackUp(
        "total ratio, relative",
        inf,
        (
            Contribution("drum radius", land_band_mm(s.drive, r_o, "drum"), 1.0 / r_o),
            Contribution("input radius", land_band_mm(s.drive, r_i, "pulley"), -1.0 / r_i),
            Contribution("rope's diameter", rope_band_mm(s.drive), (1.0 / r_o - 1.0 / r_i) / 2.0),
        ),
    )


_STACKS = (
    stack_check("turn_gap", "Turns stay apart with tolerances", turn_gap, "raise rope.helix_lead_mm"),
    stack_check(
        "rim_edge", "The cable stays within the rim with tolerances", rim_edge, "raise clearances.land_edge_mm"
    ),
    transmission_error,
)


@check("Terminals clear the input at the ends of travel", "clearances.running_mm", *MORE_WRAP)
def terminal_clears_input(s: SpurLayout) -> Findings:
    """Gap of the terminals to the input and its yoke at the end of travel where they come nearest."""
    drive, f = s.drive, s.frame
    reach = max(s.inputs[0].lower_land_radius, drive.input_radius_mm + s.flank_mm)
    if drive.whole_drum:
        yield from _come_by(s, max(reach, without_bearings(drive).hub_radius_mm) if drive.overhung else reach)
        return
    for t in s.drum.tensioners:
        turn = -t.side * s.half_travel_rad
        c, sine = cos(turn), sin(turn)
        for name, outline, _, _ in bodies_of(s, t):
            gaps = []
            for x, z in outline.tolist():
                # About Y from Z towards X, as the drum turns.
                at_x, at_z = x * c + z * sine, z * c - x * sine
                pulley = hypot(at_x, at_z - drive.centre_distance_mm) - reach
                yoke = max(abs(at_x) - f.shelf_half_width, f.shelf_bottom_z - at_z)
                gaps.append(min(pulley, yoke))
            what = f"{name} of {t.cable_name} from the input and its yoke at the end of travel"
            yield what, min(gaps), drive.clearances.running_mm


def _come_by(s: SpurLayout, reach_mm: float) -> Findings:
    """The gap of terminals that come by the input, whatever their plane; that ends ``reach_mm`` from its axis."""
    drive, f = s.drive, s.frame
    end = drive.centre_distance_mm - reach_mm
    if not drive.overhung:
        end = min(end, f.shelf_bottom_z)
    for t in s.drum.tensioners:
        for name, outline, _, _ in bodies_of(s, t):
            gap = end - float(np.hypot(*outline.T).max())
            what = f"{name} of {t.cable_name} from the input and its yoke as it comes by"
            yield what, gap, drive.clearances.running_mm


@check(
    "Turns on a whole drum lie clear of each other and of the terminals",
    "derived: lead x ratio; material: min_wall_mm",
    up("rope.helix_lead_mm"),
    advice="choose a smaller drum.tensioner",
    applies=lambda drive: drive.whole_drum,
)
def turns_on_drum(s: SpurLayout) -> Findings:
    """Turns of a cable on a whole drum beside each other, and beside the pocket of its terminal.

    The helix on the drum has the slope of the turns on the input: its lead is theirs times the ratio. A terminal lies
    where the helix ends, a turn further than the cable beside it.
    """
    drive, d = s.drive, s.drum
    lead, wall = drive.helix_lead_mm * drive.total_ratio, drive.drum_material.min_wall_mm
    yield "lead of the helix on the drum over the cable", lead - 2 * s.flank_mm, CABLE_GAP_MM
    for t in d.tensioners:
        gap = drive.turn_beside_mm(pocket_end_rad(t)) - d.nut_pocket
        if gap < inf:
            yield f"pocket of {t.cable_name} from its turn beside it", gap, wall
        yield f"pocket of {t.cable_name} from the middle", abs(t.y_mm) - d.nut_pocket, wall / 2


@check("A drum without a stop", "derived: a pin stops it up to 165 deg", applies=lambda drive: not drive.stopped)
def no_stop(s: SpurLayout) -> Comparison:
    """Angle from the centre at which the drum must be stopped by something else."""
    end = s.drive.half_travel_deg + s.drive.stop_clearance_deg
    return noted("no stop on the drum: what it turns, or the stage behind it, must stop it before", end, "deg")


def _whole_drum(s: SpurLayout) -> str:
    return (
        "" if s.drive.anchored or s.drive.idlers else f"set drum.sector_half_angle_deg to {WHOLE_DEG:g}: a whole drum"
    )


_WRAPS = (
    *(
        check.but(applies=lambda drive: not drive.whole_drum, advice=_whole_drum) if check is wrap_under_turn else check
        for check in WRAPS
    ),
    turns_on_drum,
    no_stop,
    terminal_clears_input,
    *SLIPS,
)


FAMILIES = (
    Family("Gaps of the winding compared with the tolerances of the parts, and the transmission error.", _STACKS),
    Family(
        "Wrap on the drum over the travel: more than zero, less than a turn, clear of the input, compared "
        "with the slip zones.",
        _WRAPS,
    ),
)
