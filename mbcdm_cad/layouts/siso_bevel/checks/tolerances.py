"""Gaps at the transfer compared with the tolerances of the parts, and the transmission error."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mbcdm_cad.checks.stacks import TRANSMISSION_ERROR, stack_check
from mbcdm_cad.checks.transfer import EDGE_BREAK_MM, body_gaps_mm
from mbcdm_cad.layouts.siso_bevel.drive import DirectDrive, DirectRun
from mbcdm_cad.layouts.siso_bevel.layout import DirectLayout
from mbcdm_cad.model.stack_up import Contribution, StackUp, tightest
from mbcdm_cad.parts.making import land_band_mm, rope_band_mm


def _input_to_drum(drive: DirectDrive, cable: DirectRun) -> tuple[Contribution, ...]:
    """Distance along y between the input's surface and the wall of a drum land, at the transfer."""
    making = drive.making
    return (
        Contribution("radius of the input's step", land_band_mm(drive, cable.input_radius_mm)),
        Contribution("run-out of the input", making.run_out_mm, 0.5),
        Contribution("play of the input's bearings", making.bearing_play_mm, 0.5),
        Contribution("place of the input's bearings in frame and motor head", making.position_mm),
        Contribution("place of the drum's bearings in the frame", making.position_mm),
        Contribution("place of the land's wall on the drum", making.position_mm),
        Contribution("run-out of the drum's faces", making.run_out_mm, 0.5),
    )


def _with_rope(drive: DirectDrive, cable: DirectRun, per_rope: float) -> tuple[Contribution, ...]:
    return (*_input_to_drum(drive, cable), Contribution("rope's diameter", rope_band_mm(drive), per_rope))


def transfer_gap(s: DirectLayout) -> list[StackUp]:
    """Half a cable minus the gap at each transfer point."""
    return [
        StackUp(
            f"half a cable over the gap at the transfer of step {c.step}, mm",
            s.flank_mm - (land.y_start - surface),
            _with_rope(s.drive, c, 0.5),
        )
        for c, land, (surface, _) in zip(s.steps, s.drum.lands, s.steps_before_drum, strict=True)
    ]


def bodies_clear(s: DirectLayout) -> list[StackUp]:
    """Gap between input and drum."""
    return [StackUp(f"{what}, mm", gap, _input_to_drum(s.drive, s.steps[step])) for what, step, gap in body_gaps_mm(s)]


def land_edge(s: DirectLayout) -> list[StackUp]:
    """Distance of the contact lines from the broken edges of their lands."""
    return [
        StackUp(
            f"contact line of {c.name} from its land's broken edge, mm",
            c.land_y_mm - land.y_start - EDGE_BREAK_MM,
            _with_rope(s.drive, c, 0.5),
        )
        for c, land in zip(s.steps, s.drum.lands, strict=True)
    ]


def stacks(s: DirectLayout) -> Iterator[StackUp]:
    """The stack of each gap and of each ratio; of several, the one with the least reserve."""
    for of in (transfer_gap, bodies_clear, land_edge):
        yield tightest(of(s))
    for c in s.steps:
        r_o, r_m = c.drum_radius_mm, c.input_radius_mm
        yield StackUp(
            f"total ratio of {c.name}, relative",
            np.inf,
            (
                Contribution("drum radius", land_band_mm(s.drive, r_o), 1.0 / r_o),
                Contribution("input radius", land_band_mm(s.drive, r_m), -1.0 / r_m),
                Contribution("rope's diameter", rope_band_mm(s.drive), (1.0 / r_o - 1.0 / r_m) / 2.0),
            ),
        )


_CLOSER = "lower clearances.transfer_gap_mm, or raise clearances.land_edge_mm"
_WIDER = "raise clearances.transfer_gap_mm, or lower clearances.land_edge_mm"
CHECKS = (
    stack_check("transfer_gap", "Transfer gap stays under half a cable with tolerances", transfer_gap, _CLOSER),
    stack_check("bodies_clear", "Input and drum do not touch with tolerances", bodies_clear, _WIDER),
    stack_check(
        "land_edge",
        "Contact lines stay on their lands with tolerances",
        land_edge,
        "raise clearances.land_edge_mm, or lower clearances.transfer_gap_mm",
    ),
    TRANSMISSION_ERROR,
)
