"""The plan to set the preloads."""

from __future__ import annotations

from mbcdm_cad.layouts.siso_bevel.cable_path import input_wrap_rad
from mbcdm_cad.layouts.siso_bevel.layout import DirectLayout
from mbcdm_cad.model.tensioning_plan import TensionedCable, TensioningPlan, tensioning_plan
from mbcdm_cad.parts.terminal.take_up import highest_preload_N, tensioned_rope


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
