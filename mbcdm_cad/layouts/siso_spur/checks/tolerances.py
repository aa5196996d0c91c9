"""Gaps of the winding compared with the tolerances of the parts, and the transmission error."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf

from mbcdm_cad.checks.stacks import stack_check, transmission_error
from mbcdm_cad.layouts.siso_spur.checks.winding import turn_distance_mm
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.model.stack_up import Contribution, StackUp, tightest
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


CHECKS = (
    stack_check("turn_gap", "Turns stay apart with tolerances", turn_gap, "raise rope.helix_lead_mm"),
    stack_check(
        "rim_edge", "The cable stays within the rim with tolerances", rim_edge, "raise clearances.land_edge_mm"
    ),
    transmission_error,
)
