"""Setting of the preload: the terminals at both ends of one cable stretch a half each, or each its own cable."""

from __future__ import annotations

from mbcdm_cad.layouts.siso_spur.cable_path import side_length_mm
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.model.tensioning_plan import TensionedCable, TensioningPlan, tensioning_plan
from mbcdm_cad.parts.terminal.take_up import highest_preload_N, tensioned_rope


def plan(layout: SpurLayout) -> TensioningPlan:
    """How the preloads of both sides are set, in the order of the drive."""
    drive = layout.drive
    return tensioning_plan(tensioned_sides(layout), tensioned_rope(drive), drive.tensioner.pitch_mm * 1e-3)


def tensioned_sides(layout: SpurLayout) -> list[TensionedCable]:
    """Both sides of the cable in the order of the drive, with the length of a half each, or of one of two cables."""
    drive = layout.drive
    terminals = {t.cable_name: t for t in layout.drum.tensioners}
    stops = {slot.cable_name: slot.stop_start - slot.stop_end for pulley in layout.inputs for slot in pulley.slots}
    cables = []
    for c in drive.cables:
        t = terminals[c.name]
        on_drum, wound = t.anchor_rad - drive.landing_rad, drive.wound_rad
        # Along the cable from the nut: straight end, drum, span, its wrap on the input.
        pieces = (
            (t.swage_start * 1e-3, 0.0),
            (c.drum_radius_mm * on_drum * 1e-3, on_drum),
            (drive.free_span_mm * drive.stretched * 1e-3, 0.0),
            (c.input_radius_mm * wound * drive.stretched * 1e-3, wound),
        )
        cables.append(
            TensionedCable(
                name=c.name,
                preload_N=c.preload_N,
                highest_preload_N=highest_preload_N(drive, c),
                length_m=side_length_mm(drive, c, *layout.anchors[c.name]) * 1e-3,
                ends_m=(t.cable_end - t.swage_start + stops.get(c.name, 0.0)) * 1e-3,
                lever_m=c.sense * c.drum_radius_mm * 1e-3,
                pieces=pieces,
                spans_m=(drive.free_span_mm * drive.stretched * 1e-3,),
                travel_m=t.travel * 1e-3,
            )
        )
    return cables
