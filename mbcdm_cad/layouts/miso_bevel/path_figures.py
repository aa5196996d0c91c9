"""Exact cable paths in figures: tangent points, wraps, lengths, fleet angle and walk over the travel, usable travel.

And the plan by which the preloads are set.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import asin, atan2, cos, degrees, hypot, pi, radians, sin, tan, tau
from typing import Any

import numpy as np

from mbcdm_cad.layouts.miso_bevel.cable_path import axial_walk_mm, fleet_angle_at_deg, winding
from mbcdm_cad.layouts.miso_bevel.drive import BevelRun
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.model.tensioning_plan import TensionedCable, TensioningPlan, tensioning_plan
from mbcdm_cad.parts.terminal.part import Tensioner
from mbcdm_cad.parts.terminal.take_up import highest_preload_N, tensioned_rope
from mbcdm_cad.routes.cable_path import CablePath
from mbcdm_cad.routes.curves import Arc, Helix, Piece, Triple

STATIONS = 9


@dataclass(frozen=True)
class CablePathFigures:
    """One cable. Points (x, y, z) in mm with the drum centred; tuples over the angles of :class:`PathFigures`.

    ``free_span_mm`` is Eq. (11), in the plane of the pulleys. ``length_um`` is the change of the length between the
    anchors from the centred drum, with the pulleys turning by Eq. (2): the effect of helix and fleet angle.
    """

    name: str
    input_contact_mm: Triple
    guide_landing_mm: Triple
    transfer_mm: Triple
    drum_leaving_mm: Triple
    free_span_mm: float
    guide_wrap_deg: float
    length_mm: float
    input_wrap_deg: tuple[float, ...]
    drum_wrap_deg: tuple[float, ...]
    length_um: tuple[float, ...]
    axial_walk_mm: tuple[float, ...]
    fleet_angle_deg: tuple[float, ...]


@dataclass(frozen=True)
class TravelLimit:
    """A drum angle (deg, either sign) at which the travel ends, and the reason."""

    angle_deg: float
    cause: str


@dataclass(frozen=True)
class PathFigures:
    """All cables over the travel. ``limits`` holds each direction's, the nearest first; it is the usable travel."""

    drum_angle_deg: tuple[float, ...]
    cables: tuple[CablePathFigures, ...]
    limits_positive: tuple[TravelLimit, ...]
    limits_negative: tuple[TravelLimit, ...]

    @property
    def usable_deg(self) -> tuple[float, float]:
        """(lowest, highest) drum angle of the usable travel, deg."""
        return self.limits_negative[0].angle_deg, self.limits_positive[0].angle_deg


def path_figures(layout: BevelLayout) -> PathFigures:
    """The figures of one design at ``STATIONS`` drum angles over its travel."""
    half = layout.drive.half_travel_deg
    angles = tuple(float(v) for v in np.linspace(-half, half, STATIONS))
    posed = [layout.cable_paths(radians(angle)) for angle in angles]
    centred = layout.cable_paths(0.0)
    cables = tuple(
        _cable_figures(layout, centred[k], [paths[k] for paths in posed]) for k in range(len(layout.drive.cables))
    )
    limits = sorted(_limits(layout), key=lambda limit: abs(limit.angle_deg))
    return PathFigures(
        angles,
        cables,
        tuple(limit for limit in limits if limit.angle_deg > 0.0),
        tuple(limit for limit in limits if limit.angle_deg <= 0.0),
    )


def _cable_figures(layout: BevelLayout, centred: CablePath, posed: list[CablePath]) -> CablePathFigures:
    drive = layout.drive
    run = next(run for run in drive.cables if run.name == centred.cable.name)
    angles = [path.drum_angle_rad for path in posed]
    w = winding(drive, run)
    return CablePathFigures(
        name=run.name,
        input_contact_mm=_end(centred.piece("helix"), 1.0),
        guide_landing_mm=_end(centred.piece("guide"), 0.0),
        transfer_mm=_end(centred.piece("drum"), 0.0),
        drum_leaving_mm=_end(centred.piece("drum"), 1.0),
        free_span_mm=w.free_span_mm,
        guide_wrap_deg=degrees(w.guide_wrap_rad),
        length_mm=centred.length_mm,
        input_wrap_deg=tuple(_turned_deg(path.piece("helix")) for path in posed),
        drum_wrap_deg=tuple(_turned_deg(path.piece("drum")) for path in posed),
        length_um=tuple((path.length_mm - centred.length_mm) * 1e3 for path in posed),
        axial_walk_mm=tuple(axial_walk_mm(drive, run, angle) for angle in angles),
        fleet_angle_deg=tuple(fleet_angle_at_deg(drive, run, angle) for angle in angles),
    )


def _end(piece: Piece, fraction: float) -> Triple:
    x, y, z = piece.points(np.array([fraction]))[0]
    return float(x), float(y), float(z)


def _turned_deg(piece: Piece) -> float:
    assert isinstance(piece, Arc | Helix)
    return degrees(abs(piece.angle_end - piece.angle_start))


def terminal_to_guide_mm(layout: BevelLayout, terminal: Tensioner, wrap_rad: float) -> float:
    """Gap, mm, between a terminal and the guide with its cables, with a wrap ``wrap_rad`` left on the drum."""
    across, along, keep = _terminal(layout, terminal)
    return across * sin(wrap_rad) + along * cos(wrap_rad) - keep


def _terminal(layout: BevelLayout, terminal: Tensioner) -> tuple[float, float, float]:
    """Nearest corner of a terminal, across and along the tangent at its anchor, and the reach of the guide, mm."""
    drive, drum = layout.drive, layout.drum
    reach = max(run.guide_radius_mm for run in drive.cables) + drive.cable.diameter_mm / 2
    return terminal.radius_mm - max(drum.nut_pocket, drum.lug_half_width), terminal.slack_start, reach


def _limits(layout: BevelLayout) -> Iterator[TravelLimit]:
    drive = layout.drive
    half = radians(drive.half_travel_deg)
    terminals = {t.cable_name: t for t in layout.drum.tensioners}
    stop = half + radians(drive.stop_clearance_deg)
    yield from (_limit(way * stop, "hard stop") for way in (1, -1))
    for run in drive.cables:
        terminal, w = terminals[run.name], winding(drive, run)
        off = -run.drum_side
        yield _limit(off * terminal.anchor_rad, f"wrap of {run.name} on the drum ends")
        left = _wrap_at_guide(layout, terminal)
        yield _limit(off * (terminal.anchor_rad - left), f"terminal of {run.name} meets the guide")
        round_rad = tau - terminal.anchor_rad - atan2(terminal.last_tip, terminal.radius_mm)
        yield _limit(-off * round_rad, f"terminal of {run.name} comes round to the transfer point")
        used = half + tau * drive.dead_turns / w.reduction
        yield _limit(-off * used, f"dead turns of {run.name} on the input are used up")
        yield from _fleet_limits(layout, run)


def _limit(angle_rad: float, cause: str) -> TravelLimit:
    return TravelLimit(degrees(angle_rad), cause)


def _wrap_at_guide(layout: BevelLayout, terminal: Tensioner) -> float:
    """Wrap left when the terminal comes within the running clearance of the guide: A sin w + B cos w = C."""
    across, along, reach = _terminal(layout, terminal)
    share = (reach + layout.drive.clearances.running_mm) / hypot(across, along)
    return asin(min(share, 1.0)) - atan2(along, across)


def _fleet_limits(layout: BevelLayout, run: BevelRun) -> Iterator[TravelLimit]:
    drive = layout.drive
    w = winding(drive, run)
    per_rad = abs(axial_walk_mm(drive, run, 1.0))
    most = drive.fleet_angle_max_deg
    angle = min(tan(radians(most)) * w.free_span_mm / per_rad, pi)
    yield from (_limit(way * angle, f"fleet angle of {run.name} reaches {most:g} deg") for way in (1, -1))


def path_lines(c: dict[str, Any]) -> Iterator[str]:
    """One cable's figures for a terminal."""
    middle = len(c["drum_wrap_deg"]) // 2
    wound, on_drum = c["input_wrap_deg"], c["drum_wrap_deg"]
    yield (
        f"  {c['name']:<10} length {c['length_mm']:.2f} mm, span {c['free_span_mm']:.2f} mm, guide "
        f"{c['guide_wrap_deg']:.1f}, input {wound[middle]:.0f} ({wound[0]:.0f}, {wound[-1]:.0f}), drum "
        f"{on_drum[middle]:.1f} ({on_drum[0]:.1f}, {on_drum[-1]:.1f}); walk {max(c['axial_walk_mm']):.3f} mm, "
        f"fleet angle {max(c['fleet_angle_deg']):.3f} deg"
    )
    points = ("input_contact_mm", "guide_landing_mm", "transfer_mm", "drum_leaving_mm")
    yield "    tangent points (x, y, z) mm: " + "; ".join(
        f"{name.removesuffix('_mm').replace('_', ' ')} ({', '.join(f'{v:.3f}' for v in c[name])})" for name in points
    )


def plan(layout: BevelLayout) -> TensioningPlan:
    """Plan to set the preloads of this design, cables in the order of the file."""
    drive = layout.drive
    terminals = {t.cable_name: t for t in layout.drum.tensioners}
    slots = {slot.cable_name: slot for pulley in layout.inputs for slot in pulley.slots}
    cables = []
    for c, path in zip(drive.cables, layout.cable_paths(0.0), strict=True):
        w = winding(drive, c)
        t, slot = terminals[c.name], slots[c.name]
        turned = tau * drive.dead_turns + w.reduction * radians(drive.half_travel_deg)
        # Along the cable from the nut: straight end, drum, guide (it turns freely), free span, input pulley.
        pieces = (
            (t.swage_start * 1e-3, 0.0),
            (c.drum_radius_mm * t.anchor_rad * 1e-3, t.anchor_rad),
            ((c.guide_radius_mm * w.guide_wrap_rad + w.free_span_mm) * 1e-3, 0.0),
            (c.input_radius_mm * turned * 1e-3, turned),
        )
        ends = slot.stop_start - slot.stop_end + t.cable_end - t.swage_start
        cables.append(
            TensionedCable(
                name=c.name,
                preload_N=c.preload_N,
                highest_preload_N=highest_preload_N(drive, c),
                length_m=path.length_mm * 1e-3,
                ends_m=ends * 1e-3,
                lever_m=-c.drum_side * c.drum_radius_mm * 1e-3,
                pieces=pieces,
                spans_m=(w.free_span_mm * 1e-3,),
                travel_m=t.travel * 1e-3,
            )
        )
    return tensioning_plan(cables, tensioned_rope(drive), drive.tensioner.pitch_mm * 1e-3)
