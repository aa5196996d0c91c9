"""Take-up of the terminals of the drum, from slack to the highest preload, and the plan to set the preloads."""

from __future__ import annotations

from math import hypot, pi, radians, tau
from typing import TYPE_CHECKING

from mbcdm_cad.layouts.miso_bevel.cable_path import winding
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive, BevelRun
from mbcdm_cad.model.tensioning_plan import TensionedCable, TensioningPlan, tensioning_plan
from mbcdm_cad.parts.drum_sector.sizes import TerminalWay, furthest_anchor_rad
from mbcdm_cad.parts.terminal.take_up import highest_preload_N, tensioned_rope, terminal_travel_mm

if TYPE_CHECKING:  # the layout asks this module for the terminals' travel
    from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout


def longest_mm(drive: BevelDrive, cable: BevelRun, anchor_rad: float) -> float:
    """Length of a cable that leaves its land at ``anchor_rad``, by its pieces; slightly more than the drawn path."""
    w = winding(drive, cable)
    turns = tau * drive.dead_turns + w.reduction * radians(drive.half_travel_deg)
    helix = turns * hypot(cable.input_radius_mm, drive.helix_lead_mm / tau)
    # The bend inward to the stop and the straight end in the terminal: a quarter turn and three diameters each.
    ends = pi / 2 * cable.input_radius_mm + 6.0 * drive.cable.diameter_mm
    return helix + w.free_span_mm + cable.guide_radius_mm * w.guide_wrap_rad + cable.drum_radius_mm * anchor_rad + ends


def terminal_way(drive: BevelDrive) -> TerminalWay:
    """Take-up of all terminals, and the part of it that each uses, mm, for cables anchored as far out as possible."""
    furthest = furthest_anchor_rad(drive)
    return terminal_travel_mm(drive, {c.name: longest_mm(drive, c, furthest) for c in drive.cables})


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
