"""Wrap on the drum over the travel: more than zero, less than a turn, clear of the input, compared with the slip zones.

Both ends of the cable are fixed to the drum. A wrap shorter than the slip zone is therefore legal, but Eq. (5) and (6)
are no longer valid.
"""

from __future__ import annotations

from math import cos, hypot, inf, sin

import numpy as np

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, noted, worst
from mbcdm_cad.checks.design_variables import up
from mbcdm_cad.checks.geometry import CABLE_GAP_MM
from mbcdm_cad.checks.terminals import bodies_of
from mbcdm_cad.checks.transfer import MORE_WRAP, SLIPS, WRAPS, wrap_under_turn
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.siso_spur.overhung import hub_radius_mm
from mbcdm_cad.parts.drum_sector.dims import WHOLE_DEG
from mbcdm_cad.parts.drum_sector.sizes import pocket_end_rad


def terminal_clears_input(s: SpurLayout) -> Comparison:
    """Gap of the terminals to the input and its yoke at the end of travel where they come nearest."""
    drive, f = s.drive, s.frame
    reach = max(s.inputs[0].lower_land_radius, drive.input_radius_mm + s.flank_mm)
    found = []
    if drive.whole_drum:
        return _come_by(s, max(reach, hub_radius_mm(drive)) if drive.overhung else reach)
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
            found.append(at_least(what, min(gaps), drive.clearances.running_mm, "mm"))
    return worst(found)


def _come_by(s: SpurLayout, reach_mm: float) -> Comparison:
    """The gap of terminals that come by the input, whatever their plane; that ends ``reach_mm`` from its axis."""
    drive, f = s.drive, s.frame
    end = drive.centre_distance_mm - reach_mm
    if not drive.overhung:
        end = min(end, f.shelf_bottom_z)
    found = []
    for t in s.drum.tensioners:
        for name, outline, _, _ in bodies_of(s, t):
            gap = end - float(np.hypot(*outline.T).max())
            what = f"{name} of {t.cable_name} from the input and its yoke as it comes by"
            found.append(at_least(what, gap, drive.clearances.running_mm, "mm"))
    return worst(found)


def turns_on_drum(s: SpurLayout) -> Comparison:
    """Turns of a cable on a whole drum beside each other, and beside the pocket of its terminal.

    The helix on the drum has the slope of the turns on the input: its lead is theirs times the ratio. A terminal lies
    where the helix ends, a turn further than the cable beside it.
    """
    drive, d = s.drive, s.drum
    lead, wall = drive.helix_lead_mm * drive.total_ratio, drive.drum_material.min_wall_mm
    found = [at_least("lead of the helix on the drum over the cable", lead - 2 * s.flank_mm, CABLE_GAP_MM, "mm")]
    for t in d.tensioners:
        gap = drive.turn_beside_mm(pocket_end_rad(t)) - d.nut_pocket
        if gap < inf:
            found.append(at_least(f"pocket of {t.cable_name} from its turn beside it", gap, wall, "mm"))
        found.append(at_least(f"pocket of {t.cable_name} from the middle", abs(t.y_mm) - d.nut_pocket, wall / 2, "mm"))
    return worst(found)


def no_stop(s: SpurLayout) -> Comparison:
    """Angle from the centre at which the drum must be stopped by something else."""
    end = s.drive.half_travel_deg + s.drive.stop_clearance_deg
    return noted("no stop on the drum: what it turns, or the stage behind it, must stop it before", end, "deg")


def is_whole(drive: SpurDrive) -> bool:
    """Whether the drum is closed all round."""
    return drive.whole_drum


def _whole_drum(s: SpurLayout) -> str:
    return (
        "" if s.drive.anchored or s.drive.idlers else f"set drum.sector_half_angle_deg to {WHOLE_DEG:g}: a whole drum"
    )


CHECKS = (
    *(
        check.but(applies=lambda drive: not drive.whole_drum, advice=_whole_drum) if check is wrap_under_turn else check
        for check in WRAPS
    ),
    Check(
        "turns_on_drum",
        "Turns on a whole drum lie clear of each other and of the terminals",
        "derived: lead x ratio; material: min_wall_mm",
        turns_on_drum,
        adjust=(up("rope.helix_lead_mm"),),
        advice="choose a smaller drum.tensioner",
        applies=is_whole,
    ),
    Check(
        "no_stop",
        "A drum without a stop",
        "derived: a pin stops it up to 165 deg",
        no_stop,
        applies=lambda drive: not drive.stopped,
    ),
    Check(
        "terminal_clears_input",
        "Terminals clear the input at the ends of travel",
        "clearances.running_mm",
        terminal_clears_input,
        adjust=MORE_WRAP,
    ),
    *SLIPS,
)
