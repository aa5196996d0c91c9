"""What layouts share whose cables pass over a bevel transfer to the drum: figures of the travel, and what ends it.

The transfer point of a cable is (0, r, r_o), r its radius on the body before the drum.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from math import asin, atan2, ceil, cos, degrees, floor, hypot, sin, sqrt, tau
from typing import Any

import numpy as np

from mbcdm_cad.checks.comparison import Check, Comparison, Findings, at_least, at_most, check, worst
from mbcdm_cad.checks.geometry import rim_points, wrap_points
from mbcdm_cad.checks.ratios import SURFACE_TOLERANCE_MM
from mbcdm_cad.checks.terminals import bodies_of
from mbcdm_cad.checks.transfer import MORE_WRAP, SLIPS, WRAPS, Stacks, TransferStacks, stack_check
from mbcdm_cad.design.paths import at
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.model.tensioning import TensionedCable
from mbcdm_cad.model.tolerance import tightest
from mbcdm_cad.parts.bodies import RING_ENCODER_FLATS
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


@check(
    "Surfaces are cut half a cable inside the pitch radii",
    "derived from paper Table 2, which gives pitch radii",
    advice="the layout cuts at r - d/2; this fails only if that is changed",
)
def cut_at_pitch(s: SectorLayout) -> Findings:
    """The layout cuts every surface at the pitch radius less d/2, so that all cables keep one ratio."""
    on_input = {
        slot.cable_name: surface
        for pulley in s.inputs
        for slot, surface in zip(pulley.slots, (pulley.lower_surface_radius, pulley.upper_surface_radius), strict=True)
    }
    cut, ratios = list[tuple[str, float, float]](), list[str]()
    for c, (before, _), land in zip(s.steps, s.steps_before_drum, s.drum.lands, strict=True):
        cut.append((f"{s.before_drum}, {c.name}", before, c.land_y_mm))
        cut.append((f"drum, {c.name}", land.surface_radius_mm, c.drum_radius_mm))
        cut.append((f"input pulley, {c.name}", on_input[c.name], c.input_radius_mm))
        ratios.append(f"{(land.surface_radius_mm + s.flank_mm) / (on_input[c.name] + s.flank_mm):.6g}")
    for name, surface, pitch in cut:
        what, off = f"surface of {name} from pitch radius less d/2", abs(surface + s.flank_mm - pitch)
        note = f"total ratios at the cables' centre lines {', '.join(ratios)}"
        yield at_most(what, off, SURFACE_TOLERANCE_MM, "mm", note)


def _wider_or_closer(of: Stacks, widen: str, gain: float, s: Any) -> str:
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


def toleranced(name: str, title: str, of: Stacks, widen: str, gain: float = 1.0) -> Check:
    """The check of a gap against the tolerances that change it; ``gain``: of the gap for each mm of ``widen``."""
    return stack_check(name, f"{title} with tolerances", of, partial(_wider_or_closer, of, widen, gain))


def transfer_stacks(of: TransferStacks) -> tuple[Check, ...]:
    """Those of the gap between drum and body before it."""
    edge, gap = at.clearances.land_edge_mm, at.clearances.transfer_gap_mm
    return (
        toleranced("transfer_gap", "Transfer gap stays under half a cable", of.gap, f"lower {gap}, or raise {edge},"),
        toleranced(
            "bodies_clear",
            f"{of.body.capitalize()} and drum do not touch",
            of.bodies_clear,
            f"raise {gap}, or lower {edge},",
        ),
        toleranced("land_edge", "Contact lines stay on their lands", of.land_edge, f"raise {edge}, or lower {gap},"),
    )


def bevel_box_mm(
    s: SectorLayout, half_x: float, heights: tuple[float, float], depths: Iterable[float]
) -> tuple[float, float, float]:
    """Box (X, Z, Y) of the drum centred with its terminals, of boss and walls, and of the rest by what it reaches; mm.

    ``half_x``: to both sides, ``heights``: lowest and highest, ``depths``: along y.
    """
    d, v, boss, encoder = s.drum, s.levels, s.frame.boss, s.drive.drum_encoder.diameter_mm / 2
    points, ys = [rim_points(d), wrap_points(d, s.flank_mm)], [*depths, v.back_y, v.hub_face_y]
    ys += [d.lands[-1].y_end, d.web_end_y + 0.5]
    for t in d.tensioners:
        for _, outline, _, high in bodies_of(s, t, moved=False):
            points.append(outline)
            ys.append(high)
    (left, low), (right, top) = (of(np.concatenate(points), axis=0).tolist() for of in (np.min, np.max))
    wide = max(half_x, s.frame.levels.side_outer_x, boss.ear_reach, encoder)
    bottom = min(low, heights[0], -boss.radius, -d.hub_radius, -encoder * RING_ENCODER_FLATS)
    highest = max(top, heights[1], s.steps[-1].drum_radius_mm + s.flank_mm)
    return max(right, wide) - min(left, -wide), highest - bottom, max(ys) - min(ys)
