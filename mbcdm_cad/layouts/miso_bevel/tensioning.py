"""The plan to set the preloads."""

from __future__ import annotations

from math import radians, tau

from mbcdm_cad.layouts.miso_bevel.cable_path import winding
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.model.tensioning_plan import TensionedCable, TensioningPlan, tensioning_plan
from mbcdm_cad.parts.terminal.take_up import highest_preload_N, tensioned_rope


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
