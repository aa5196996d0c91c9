"""The order in which the mechanism goes together, with the tool for each step and why it reaches."""

from __future__ import annotations

from mbcdm_cad.layout.layout import Layout
from mbcdm_cad.layout.support import AXLE_SCREW, PLATE_SCREW


def assembly_order(layout: Layout) -> tuple[str, ...]:
    """Steps as sentences, with the sizes of this design."""
    drive = layout.drive
    bearings, gear, rope, terminal = drive.bearings, drive.gearhead, drive.cable, drive.tensioner
    hub_screw, collar_screw = layout.drum.set_screw, layout.collar.screw

    def key(screw: str) -> str:
        return f"{drive.screw(screw).key_mm:g} mm key"

    preloads = ", ".join(f"{c.preload_N:g}" for c in drive.cables)
    return (
        f"Swage the stops on one end of each cable ({rope.name}, {rope.diameter_mm:g} mm) and the threaded terminals "
        f"({terminal.name}) on the other, to the cut lengths of the bill of materials.",
        f"Screw the gearheads with their motors under the motor shelf ({gear.screw_count} x {gear.screw} each). "
        f"The {key(gear.screw)} reaches the heads from above, through the key holes in the shoulder of the empty lower "
        "bearing seats; the screws go in through the open front of the coupling space.",
        f"Press the lower bearings ({bearings.input_lower.name}) into the bearing shelf from above. "
        "Lay the clamp collars over the gearhead shafts.",
        "Hook the stops of each cable into the slots in the end faces of its input pulley, wind the dead turns and "
        "half of the live turns and hold them with tape. Lower the pulleys through bearing and collar onto the "
        f"gearhead shafts and close the collars from the front ({collar_screw}, {key(collar_screw)}).",
        f"Set the guide axle into the bearing shelf and fix it with its set screw ({AXLE_SCREW}, {key(AXLE_SCREW)}, "
        f"from the front). Slide on the guide with its two bearings ({bearings.guide.name}) and the spacer.",
        f"Press the upper bearings ({bearings.input_upper.name}) into the top plate from below and screw the encoders "
        f"to it from below ({drive.encoder.screw_count} x {drive.encoder.screw} each). Lower the plate over the "
        f"journals onto the two dowels, tighten four {PLATE_SCREW} ({key(PLATE_SCREW)}), then the encoders' "
        "own clamps.",
        f"Press the drum bearings ({bearings.drum.name}) into the boss from both sides, push the drum shaft in from "
        "behind until its flange rests on the rear bearing, and screw the ring encoder on behind it "
        f"({drive.drum_encoder.screw_count} x {drive.drum_encoder.screw}).",
        "Bolt the frame to its base through the holes in the back plate, from the front, while the drum is still off.",
        "Push the drum onto the shaft until its spigot touches the front bearing, then press the stop pin through the "
        f"slot into the web between the shelves. Tighten the hub's two set screws ({hub_screw}, {key(hub_screw)}, "
        "radially, in front of the web).",
        "Lead each cable round the guide and over its transfer point onto its land, drop the terminal sideways into "
        "the slotted lug from the drum's inner side, run on nut and lock nut.",
        f"With the drum centred and the motors holding, tension the cables in turn to {preloads} N with a "
        f"{terminal.nut_across_flats_mm:g} mm spanner, holding the swage; lock the nuts.",
    )
