"""Exact cable paths in figures: wraps and lengths over the travel, and the limits of the travel.

And the plan by which the preloads are set.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import asin, atan2, cos, degrees, hypot, radians, sin, tau
from typing import Any

import numpy as np

from mbcdm_cad.layouts.siso_bevel.cable_path import full_input_turn_deg, input_wrap_rad
from mbcdm_cad.layouts.siso_bevel.layout import DirectLayout
from mbcdm_cad.model.tensioning_plan import TensionedCable, TensioningPlan, tensioning_plan
from mbcdm_cad.parts.terminal.part import Tensioner
from mbcdm_cad.parts.terminal.take_up import highest_preload_N, tensioned_rope
from mbcdm_cad.routes.cable_path import EndOfTravel

STATIONS = 9


@dataclass(frozen=True)
class DirectCableFigures:
    """One cable. Tuples over the angles of :class:`DirectFigures`.

    ``length_um`` is the change of the length between the anchors from the centred drum: 0 except for rounding, since
    the length that leaves the input lands on the drum.
    """

    name: str
    length_mm: float
    input_wrap_deg: tuple[float, ...]
    drum_wrap_deg: tuple[float, ...]
    length_um: tuple[float, ...]


@dataclass(frozen=True)
class DirectFigures:
    """All cables over the travel. ``limits`` holds each direction's, the nearest first; it is the usable travel."""

    drum_angle_deg: tuple[float, ...]
    cables: tuple[DirectCableFigures, ...]
    limits_positive: tuple[EndOfTravel, ...]
    limits_negative: tuple[EndOfTravel, ...]

    @property
    def usable_deg(self) -> tuple[float, float]:
        """(lowest, highest) drum angle of the usable travel, deg."""
        return self.limits_negative[0].angle_deg, self.limits_positive[0].angle_deg


def path_figures(layout: DirectLayout) -> DirectFigures:
    """The figures of one design at ``STATIONS`` drum angles over its travel."""
    drive = layout.drive
    angles = np.linspace(-drive.half_travel_deg, drive.half_travel_deg, STATIONS)
    posed = [layout.cable_paths(float(angle)) for angle in np.radians(angles)]
    centred = layout.cable_paths(0.0)
    anchors = {t.cable_name: t.anchor_rad for t in layout.drum.tensioners}
    cables = tuple(
        DirectCableFigures(
            name=run.name,
            length_mm=centred[k].length_mm,
            input_wrap_deg=tuple(degrees(input_wrap_rad(drive, run, float(a))) for a in np.radians(angles)),
            drum_wrap_deg=tuple(degrees(anchors[run.name]) + run.drum_side * float(a) for a in angles),
            length_um=tuple((paths[k].length_mm - centred[k].length_mm) * 1e3 for paths in posed),
        )
        for k, run in enumerate(drive.cables)
    )
    ends = sorted(_ends(layout), key=lambda end: abs(end.angle_deg))
    return DirectFigures(
        tuple(float(a) for a in angles),
        cables,
        tuple(end for end in ends if end.angle_deg > 0.0),
        tuple(end for end in ends if end.angle_deg <= 0.0),
    )


def terminal_to_input_mm(layout: DirectLayout, terminal: Tensioner, wrap_rad: float) -> float:
    """Gap, mm, between a terminal and the input with its cables, with a wrap ``wrap_rad`` left on the drum."""
    across, along, keep = _corner(layout, terminal)
    return across * sin(wrap_rad) + along * cos(wrap_rad) - keep


def _corner(layout: DirectLayout, terminal: Tensioner) -> tuple[float, float, float]:
    """Nearest corner of a terminal, across and along the tangent at its anchor, and the reach of the input, mm."""
    drive, drum = layout.drive, layout.drum
    reach = max(run.input_radius_mm for run in drive.cables) + drive.cable.diameter_mm / 2
    return terminal.radius_mm - max(drum.nut_pocket, drum.lug_half_width), terminal.slack_start, reach


def _ends(layout: DirectLayout) -> Iterator[EndOfTravel]:
    drive = layout.drive
    half = radians(drive.half_travel_deg)
    terminals = {t.cable_name: t for t in layout.drum.tensioners}
    stop = drive.half_travel_deg + drive.stop_clearance_deg
    yield from (EndOfTravel(way * stop, "hard stop") for way in (1, -1))
    for run in drive.cables:
        terminal, ratio, off = terminals[run.name], run.drum_radius_mm / run.input_radius_mm, -run.drum_side

        def end(angle_rad: float, cause: str, off: int = off) -> EndOfTravel:
            return EndOfTravel(off * degrees(angle_rad), cause)

        yield end(terminal.anchor_rad, f"wrap of {run.name} on the drum ends")
        across, along, reach = _corner(layout, terminal)
        share = (reach + drive.clearances.running_mm) / hypot(across, along)
        left = asin(min(share, 1.0)) - atan2(along, across)
        yield end(terminal.anchor_rad - left, f"terminal of {run.name} meets the input")
        round_rad = tau - terminal.anchor_rad - atan2(terminal.last_tip, terminal.radius_mm)
        yield end(-round_rad, f"terminal of {run.name} comes round to the transfer point")
        yield end(-half - radians(drive.reserve_deg) / ratio, f"{run.name} is all off the input")
        full = radians(360.0 - full_input_turn_deg(drive, run)) / ratio
        yield end(half + full, f"the input has taken up a whole turn of {run.name}")


def path_lines(c: dict[str, Any]) -> Iterator[str]:
    """One cable's figures for a terminal."""
    middle = len(c["drum_wrap_deg"]) // 2
    wound, on_drum = c["input_wrap_deg"], c["drum_wrap_deg"]
    yield (
        f"  {c['name']:<10} length {c['length_mm']:.2f} mm; wrap on the input {wound[middle]:.0f} "
        f"({wound[0]:.0f}, {wound[-1]:.0f}), on the drum {on_drum[middle]:.1f} "
        f"({on_drum[0]:.1f}, {on_drum[-1]:.1f}) deg"
    )


def plan(layout: DirectLayout) -> TensioningPlan:
    """Plan to set the preloads of this design, cables in the order of the file. No free span can be plucked."""
    drive = layout.drive
    terminals = {t.cable_name: t for t in layout.drum.tensioners}
    slots = {slot.cable_name: slot for pulley in layout.inputs for slot in pulley.slots}
    cables = []
    for c, path in zip(drive.cables, layout.cable_paths(0.0), strict=True):
        t, slot = terminals[c.name], slots[c.name]
        wound = input_wrap_rad(drive, c, 0.0)
        # Along the cable from the nut: straight end, drum, input pulley.
        pieces = (
            (t.swage_start * 1e-3, 0.0),
            (c.drum_radius_mm * t.anchor_rad * 1e-3, t.anchor_rad),
            (c.input_radius_mm * wound * 1e-3, wound),
        )
        cables.append(
            TensionedCable(
                name=c.name,
                preload_N=c.preload_N,
                highest_preload_N=highest_preload_N(drive, c),
                length_m=path.length_mm * 1e-3,
                ends_m=(slot.stop_start - slot.stop_end + t.cable_end - t.swage_start) * 1e-3,
                lever_m=c.sense * c.drum_radius_mm * 1e-3,
                pieces=pieces,
                spans_m=(),
                travel_m=t.travel * 1e-3,
            )
        )
    return tensioning_plan(cables, tensioned_rope(drive), drive.tensioner.pitch_mm * 1e-3)
