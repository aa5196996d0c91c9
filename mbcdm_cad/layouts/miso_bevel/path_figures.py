"""Exact cable paths in figures: tangent points, wraps, lengths, fleet angle and walk over the travel, usable travel.

And the plan by which the preloads are set.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import degrees, pi, radians, tan, tau
from typing import Any

import numpy as np

from mbcdm_cad.layouts.bevel_transfer import TravelFigures, ends_at_drum, tensioned
from mbcdm_cad.layouts.miso_bevel.cable_path import axial_walk_mm, fleet_angle_at_deg, input_wrap_rad, winding
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.model.tensioning import TensioningPlan, tensioning_plan
from mbcdm_cad.parts.terminal import tensioned_rope
from mbcdm_cad.routes.curves import Arc, CablePath, EndOfTravel, Helix, Piece, Triple, by_sense, over_travel


@dataclass(frozen=True)
class CablePathFigures:
    """One cable. Points (x, y, z) in mm with the drum centred; tuples over the angles of :class:`TravelFigures`.

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


def path_figures(layout: BevelLayout) -> TravelFigures:
    """The figures of one design at ``STATIONS`` drum angles over its travel."""
    angles, posed = over_travel(layout.cable_paths, layout.drive.half_travel_deg)
    centred = layout.cable_paths(0.0)
    cables = tuple(
        _cable_figures(layout, centred[k], [paths[k] for paths in posed]) for k in range(len(layout.drive.cables))
    )
    return TravelFigures(angles, cables, *by_sense(_limits(layout)))


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


def _limits(layout: BevelLayout) -> Iterator[EndOfTravel]:
    drive = layout.drive
    half = radians(drive.half_travel_deg)
    stop = half + radians(drive.stop_clearance_deg)
    yield from (_limit(way * stop, "hard stop") for way in (1, -1))
    for run in drive.cables:
        yield from ends_at_drum(layout, run, "guide")
        w, per_rad, most = winding(drive, run), abs(axial_walk_mm(drive, run, 1.0)), drive.fleet_angle_max_deg
        used = half + tau * drive.dead_turns / w.reduction
        yield _limit(run.drum_side * used, f"dead turns of {run.name} on the input are used up")
        angle = min(tan(radians(most)) * w.free_span_mm / per_rad, pi)
        yield from (_limit(way * angle, f"fleet angle of {run.name} reaches {most:g} deg") for way in (1, -1))


def _limit(angle_rad: float, cause: str) -> EndOfTravel:
    return EndOfTravel(degrees(angle_rad), cause)


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
    cables = []
    for c, path in zip(drive.cables, layout.cable_paths(0.0), strict=True):
        w, wound = winding(drive, c), input_wrap_rad(drive, c, 0.0)
        # The guide turns freely; then the free span and the input pulley.
        pieces = (
            ((c.guide_radius_mm * w.guide_wrap_rad + w.free_span_mm) * 1e-3, 0.0),
            (c.input_radius_mm * wound * 1e-3, wound),
        )
        cables.append(tensioned(layout, path, pieces, (w.free_span_mm * 1e-3,)))
    return tensioning_plan(cables, tensioned_rope(drive), drive.tensioner.pitch_mm * 1e-3)
