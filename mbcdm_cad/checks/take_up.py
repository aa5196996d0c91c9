"""Adjustment of the terminals: take-up from slack to the highest preload, thread under both nuts, twist of the rope."""

from __future__ import annotations

from math import acos, degrees

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, at_most, worst
from mbcdm_cad.checks.design_variables import down
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.parts.terminal.take_up import take_up_of

# A nut engages with all its threads if the stud projects by this many pitches (usual rule).
THREAD_OUT_PITCHES = 1.0
# Thread run-out behind the sleeve, in pitches, on which no nut can run.
RUN_OUT_PITCHES = 2.0
# A terminal that turns further than this twists the rope while its nut is turned (estimate).
TWIST_DEG = 20.0


def take_up(s: SectorLayout) -> Comparison:
    """Adjustment length of each terminal with thread under nut and lock nut, against the length that its cable needs.

    Asked: stretch at the highest preload, bedding-in, both ends of the cut length's tolerance.
    """
    pitch, found = s.drive.tensioner.pitch_mm, []
    for c, length, t in zip(s.drive.cables, s.tensioned_lengths_mm(), s.terminals, strict=True):
        need = take_up_of(s.drive, c, length)
        # If the stud does not reach through both nuts at the start, the usable take-up begins later.
        short = max(0.0, t.nuts_end + THREAD_OUT_PITCHES * pitch - (t.tip - t.drawn_in))
        note = (
            f"stretch {need.elastic_m * 1e3:.3g} mm, bedding-in {need.bedding_m * 1e3:.3g} mm, "
            f"cut length {need.cut_m * 1e3:.3g} mm"
        ) + (f", ends that tighten {need.setting_m * 1e3:.3g} mm" if need.setting_m else "")
        found.append(at_least(f"take-up for {c.name}", t.travel - short, need.total_m * 1e3, "mm", note))
    return worst(found)


def _longer_stud(s: SectorLayout) -> str:
    """A longer stud, and a rope that beds in less where that is most of what is asked."""
    needs = [take_up_of(s.drive, c, mm) for c, mm in zip(s.drive.cables, s.tensioned_lengths_mm(), strict=True)]
    beds = any(2 * need.bedding_m > need.total_m for need in needs)
    return "choose a drum.tensioner with a longer stud" + (", or a rope that beds in less" if beds else "")


def thread_at_end(s: SectorLayout) -> Comparison:
    """Thread that is left at the lug for the nut when the terminal is drawn in completely."""
    spec = s.drive.tensioner
    return worst(
        at_least(
            f"back of the lug to the sleeve of {t.cable_name}, drawn in",
            t.lug_end - t.last_end,
            RUN_OUT_PITCHES * spec.pitch_mm,
            "mm",
        )
        for t in s.drum.tensioners
    )


def terminal_twist(s: SectorLayout) -> Comparison:
    """Angle by which a terminal turns with its nut before the flat of its sleeve touches the wall of the pocket."""
    spec, wall = s.drive.tensioner, s.drum.flat_wall
    corner, flat = spec.swage_diameter_mm / 2, spec.swage_flats_mm / 2
    # After a rotation a, the corner of the flat lies corner cos(h - a) below the axis, h its angle from the flat's
    # middle.
    middle_to_corner = acos(min(1.0, flat / corner))
    turn = 180.0 if wall >= corner else degrees(middle_to_corner - acos(wall / corner))
    return at_most("turn of a terminal until its flat is held", turn, TWIST_DEG, "deg")


CHECKS = (
    Check(
        "take_up",
        "Terminals reach the preload",
        "derived: T l / EA + bedding-in + cut length",
        take_up,
        adjust=(down("rope.preload_N"),),
        advice=_longer_stud,
    ),
    Check(
        "thread_at_end",
        "Nut stays on the thread with the terminal drawn in",
        "two pitches of run-out: usual rule",
        thread_at_end,
        advice="choose a drum.tensioner with a thicker lug",
    ),
    Check(
        "terminal_twist",
        "Terminals cannot turn with their nuts",
        "derived; 20 degrees: estimate",
        terminal_twist,
        advice="choose a drum.tensioner with deeper flats",
    ),
)
