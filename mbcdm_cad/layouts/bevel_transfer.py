"""What layouts share whose cables pass over a bevel transfer to the drum: figures of the travel, and what ends it.

The transfer point of a cable is (0, r, r_o), r its radius on the body before the drum.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from math import asin, atan2, cos, degrees, hypot, sin, tau
from typing import Any

import numpy as np

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, worst
from mbcdm_cad.checks.transfer import MORE_WRAP, SLIPS, WRAPS
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.model.tensioning import TensionedCable
from mbcdm_cad.parts.drum_sector.design import SectorRun
from mbcdm_cad.parts.terminal import Tensioner, highest_preload_N
from mbcdm_cad.routes.curves import Arc, CablePath, EndOfTravel, Line, Piece, triple


@dataclass(frozen=True)
class TravelFigures:
    """All cables over the travel. ``limits`` holds each direction's, the nearest first; it is the usable travel."""

    drum_angle_deg: tuple[float, ...]
    cables: tuple[Any, ...]
    limits_positive: tuple[EndOfTravel, ...]
    limits_negative: tuple[EndOfTravel, ...]

    @property
    def usable_deg(self) -> tuple[float, float]:
        """(lowest, highest) drum angle of the usable travel, deg."""
        return self.limits_negative[0].angle_deg, self.limits_positive[0].angle_deg


# The stretch of a cable that the drum carries.
ON_DRUM = ("drum", "tail")


def on_drum(cable: SectorRun, end_rad: float, tail_mm: float) -> Iterator[tuple[str, Piece]]:
    """The cable from the transfer point to where it leaves its land, at an angle from +Z to its side, and into the end.

    ``tail_mm``: straight length from there into the terminal.
    """
    side, y, radius = cable.drum_side, cable.land_y_mm, cable.drum_radius_mm
    yield ON_DRUM[0], Arc((0.0, y, 0.0), (0.0, 0.0, 1.0), (float(side), 0.0, 0.0), radius, 0.0, end_rad)
    leave = np.array([side * radius * sin(end_rad), y, radius * cos(end_rad)])
    along = np.array([side * cos(end_rad), 0.0, -sin(end_rad)])
    yield ON_DRUM[1], Line(triple(leave), triple(leave + tail_mm * along))


def ends_at_drum(layout: SectorLayout, run: SectorRun, body: str) -> Iterator[EndOfTravel]:
    """Where a cable's way on the drum ends the travel: ``body`` is the one before the drum."""
    terminal, off = layout.terminal_of(run), -run.drum_side
    yield EndOfTravel(off * degrees(terminal.anchor_rad), f"wrap of {run.name} on the drum ends")
    # Wrap left when the terminal comes within the running clearance of the body: A sin w + B cos w = C.
    across, along, reach = _corner(layout, terminal)
    share = (reach + layout.drive.clearances.running_mm) / hypot(across, along)
    left = asin(min(share, 1.0)) - atan2(along, across)
    yield EndOfTravel(off * degrees(terminal.anchor_rad - left), f"terminal of {run.name} meets the {body}")
    round_rad = tau - terminal.anchor_rad - atan2(terminal.last_tip, terminal.radius_mm)
    yield EndOfTravel(off * degrees(-round_rad), f"terminal of {run.name} comes round to the transfer point")


def terminal_gap_mm(layout: SectorLayout, terminal: Tensioner, wrap_rad: float) -> float:
    """Gap, mm, between a terminal and the body before the drum with its cables, with ``wrap_rad`` left on the drum."""
    across, along, keep = _corner(layout, terminal)
    return across * sin(wrap_rad) + along * cos(wrap_rad) - keep


def _corner(layout: SectorLayout, terminal: Tensioner) -> tuple[float, float, float]:
    """Nearest corner of a terminal, across and along the tangent at its anchor, and the reach of the body, mm."""
    drive, drum = layout.drive, layout.drum
    reach = max(run.land_y_mm for run in drive.cables) + drive.cable.diameter_mm / 2
    return terminal.radius_mm - max(drum.nut_pocket, drum.lug_half_width), terminal.slack_start, reach


def terminals_clear(body: str, s: SectorLayout) -> Comparison:
    """Gap between terminals and the body before the drum at the end of travel where they are nearest."""
    return worst(
        at_least(
            f"terminal of {t.cable_name} from the {body} and its cables at the end of travel",
            terminal_gap_mm(s, t, t.anchor_rad - s.half_travel_rad),
            s.drive.clearances.running_mm,
            "mm",
        )
        for t in s.drum.tensioners
    )


def wrap_checks(body: str) -> tuple[Check, ...]:
    """Wraps on the drum over the travel, and the terminals' gap to the body before it."""
    clear = Check(
        f"terminal_clears_{body}",
        f"Terminals clear the {body} at the ends of travel",
        "clearances.running_mm",
        partial(terminals_clear, body),
        adjust=MORE_WRAP,
    )
    return (*WRAPS, clear, *SLIPS)


def tensioned(
    layout: SectorLayout, path: CablePath, before_drum: tuple[tuple[float, float], ...], spans_m: tuple[float, ...] = ()
) -> TensionedCable:
    """A cable as its preload is set: from the nut its straight end, the drum, and the pieces ``before_drum``."""
    drive = layout.drive
    c = next(c for c in drive.cables if c.name == path.cable.name)
    t = layout.terminal_of(c)
    slot = next(slot for pulley in layout.inputs for slot in pulley.slots if slot.cable_name == c.name)
    return TensionedCable(
        name=c.name,
        preload_N=c.preload_N,
        highest_preload_N=highest_preload_N(drive, c),
        length_m=path.length_mm * 1e-3,
        ends_m=(slot.stop_start - slot.stop_end + t.cable_end - t.swage_start) * 1e-3,
        lever_m=c.sense * c.drum_radius_mm * 1e-3,
        pieces=((t.swage_start * 1e-3, 0.0), (c.drum_radius_mm * t.anchor_rad * 1e-3, t.anchor_rad), *before_drum),
        spans_m=spans_m,
        travel_m=t.travel * 1e-3,
    )
