"""The order of assembly: the parts that each step adds, the tool, and the direction from which it works."""

from __future__ import annotations

from mbcdm_cad.layouts.sector import key
from mbcdm_cad.layouts.siso_bevel.layout import DirectLayout
from mbcdm_cad.layouts.siso_bevel.path_figures import plan
from mbcdm_cad.parts.bill import AssemblyStep, cable_item
from mbcdm_cad.parts.bought.train import train_items, train_words
from mbcdm_cad.parts.motor_head.dims import flange_screw
from mbcdm_cad.parts.terminal.instructions import ends_words, numbered, terminal_steps
from mbcdm_cad.parts.threads import insert_items, insert_words


def assembly_order(layout: DirectLayout) -> tuple[AssemblyStep, ...]:
    """Steps with the sizes of this design. Each item is added in one step; each screw is accessible in its step."""
    return (*_frame(layout), *_input(layout), *_head(layout), *_drum(layout))


def _frame(layout: DirectLayout) -> tuple[AssemblyStep, ...]:
    drive = layout.drive
    spring, insert = layout.preload_spring, layout.frame.flange_insert
    ring, encoder, name = drive.drum_encoder, drive.encoder, drive.input_names[0]
    return (
        AssemblyStep(ends_words(drive)),
        AssemblyStep(
            insert_words(insert, len(layout.frame.flange_screws), "the top of the frame's side walls")
            + f"Press the front drum bearing ({drive.bearings.drum.name}) into the frame's boss from the front. From "
            f"behind, lay the wave spring ({spring.force_N:g} N at {spring.height:g} mm) on the shoulder, slide the "
            "rear bearing in, push the drum shaft in until its flange rests on the rear bearing, and screw the "
            f"ring encoder on behind it ({ring.screw_count} x {ring.screw}, {key(layout, ring.screw)}).",
            (
                *("frame", "drum_bearing_front", "drum_preload_spring"),
                *("drum_bearing_rear", "drum_shaft", "drum_encoder"),
                *numbered("drum_encoder_screw", 2),
                *insert_items("flange_insert", insert, len(layout.frame.flange_screws)),
            ),
        ),
        AssemblyStep(
            f"Bolt the frame to its base with {len(layout.frame.mounts)} {layout.mounting.name} through the back "
            f"plate, from the front through the column's open pockets ({layout.mounting.key_mm:g} mm key): the encoder "
            "later covers two of them."
        ),
        AssemblyStep(
            f"Hold the encoder under its shelf and screw it on from above, through the open top of the pulley's box "
            f"({encoder.screw_count} x {encoder.screw}, {key(layout, encoder.screw)}); their heads are sunk below the "
            f"pulley. Press the bearing ({drive.bearings.input_upper.name}) into the shelf from above.",
            (f"encoder_{name}", *numbered(f"encoder_screw_{name}", 2), f"input_bearing_upper_{name}"),
        ),
    )


def _input(layout: DirectLayout) -> tuple[AssemblyStep, ...]:
    drive = layout.drive
    names = tuple(c.name for c in drive.cables)
    return (
        AssemblyStep(
            "Hook the stops of both cables into the slots in the end faces of the input pulley, wind each half a turn, "
            "in opposite senses, and hold them with tape. Lower the pulley into its box, through the bearing into the "
            "encoder, and tighten the encoder's own clamp from the front.",
            (
                f"input_pulley_{drive.input_names[0]}",
                *(f"stop_{name}" for name in names),
                *(cable_item(name) for name in names),
            ),
        ),
    )


def _head(layout: DirectLayout) -> tuple[AssemblyStep, ...]:
    drive, collar_screw, name = layout.drive, layout.collar.screw, layout.drive.input_names[0]
    flange = flange_screw(drive).name
    gear = drive.gearhead
    return (
        AssemblyStep(
            f"On the bench, screw the {train_words(drive)} on the motor head ({gear.screw_count} x {gear.screw}). "
            f"The screws go in through the open front of the coupling space; the {key(layout, gear.screw)} reaches "
            "their heads from below, through the key holes in the shoulder of the empty bearing seat. Pass the clamp "
            f"collar, its screw ({collar_screw}) loose, over the {drive.mounted}'s shaft through the open front, and "
            f"press the bearing ({drive.bearings.input_lower.name}) into the head from below.",
            (
                *("motor_head", *train_items(drive, name)),
                *numbered(f"{drive.mounted}_screw_{name}", gear.screw_count),
                *(f"collar_{name}", f"collar_screw_{name}", f"input_bearing_lower_{name}"),
            ),
        ),
        AssemblyStep(
            "Press the two dowels into the side walls. Lower the head over the pulley's journal and the dowels, "
            f"tighten four {flange} from above ({key(layout, flange)}), then the collar from the front "
            f"({key(layout, collar_screw)}).",
            (*numbered("dowel", 2), *numbered("flange_screw", len(layout.frame.flange_screws))),
        ),
    )


def _drum(layout: DirectLayout) -> tuple[AssemblyStep, ...]:
    drive, hub_screw, insert = layout.drive, layout.drum.set_screw, layout.drum.payload_insert
    places = len(layout.drum.payload_places)
    return (
        AssemblyStep(
            insert_words(insert, places, "the holes in the hub's face")
            + "Take off the tape and lead each cable out to its side, held taut: it cannot be inserted later between "
            "input and drum. Push the drum onto the shaft, its set screws over the shaft's flats, until its "
            "spigot touches the front bearing, then press the stop pin through the slot of its web into the stop "
            "shelf. To preload the bearings, draw shaft and hub together until the shaft's end is flush with the hub's "
            f"face, which presses the spring with {layout.preload_spring.force_N:g} N, and tighten the hub's two set "
            f"screws ({hub_screw}, {key(layout, hub_screw)}, radially, in front of the web).",
            ("drum", "stop_pin", *numbered("hub_set_screw", 2), *insert_items("payload_insert", insert, places)),
        ),
        *terminal_steps(drive, plan(layout)),
    )
