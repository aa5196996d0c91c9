"""The order of assembly: the parts that each step adds, the tool, and the direction from which it works."""

from __future__ import annotations

from dataclasses import replace
from math import pi

from mbcdm_cad.layouts.miso_bevel.cable_path import winding
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.path_figures import plan
from mbcdm_cad.layouts.miso_bevel.plate_screws import plate_screw_of
from mbcdm_cad.layouts.miso_bevel.support.dims import AXLE_SCREW
from mbcdm_cad.layouts.sector import key
from mbcdm_cad.parts.bill import AssemblyStep, cable_item
from mbcdm_cad.parts.terminal.instructions import ends_words, numbered, terminal_steps
from mbcdm_cad.parts.terminal.part import Tensioner
from mbcdm_cad.parts.threads import insert_items, insert_words


def assembly_order(layout: BevelLayout) -> tuple[AssemblyStep, ...]:
    """Steps with the sizes of this design. Each item is added in one step; each screw is accessible in its step."""
    if layout.drive.motors_above:
        return (*_bench(layout), *_encoders_below(layout), *_pulleys(layout), *_drives_above(layout), *_drum(layout))
    return (*_bench(layout), *_drives(layout), *_pulleys(layout), *_plate(layout), *_drum(layout))


def _each(stem: str, layout: BevelLayout, count: int = 0) -> tuple[str, ...]:
    """Items ``stem_<input>``, or ``stem_<input>_1`` to ``_<count>``, of both inputs."""
    ends = [f"_{n}" for n in range(1, count + 1)] or [""]
    return tuple(f"{stem}_{p.name}{end}" for p in layout.inputs for end in ends)


def _behind_the_guide(layout: BevelLayout) -> tuple[str, ...]:
    """Cables that pass between guide and back plate, where a swaged terminal finds no way through."""
    return tuple(c.name for c in layout.drive.cables if winding(layout.drive, c).guide_wrap_rad > pi)


def _bench(layout: BevelLayout) -> tuple[AssemblyStep, ...]:
    drive = layout.drive
    ring, spring = drive.drum_encoder, layout.preload_spring
    screw, printed = drive.support.mount, drive.frame_material.printed
    insert = layout.frame.plate_insert
    return (
        AssemblyStep(ends_words(drive)),
        AssemblyStep(
            insert_words(insert, len(layout.frame.plate_screws), "the top of the frame's side walls")
            + f"Press the front drum bearing ({drive.bearings.drum.name}) into the frame's boss from the front. From "
            f"behind, lay the wave spring ({spring.force_N:g} N at {spring.height:g} mm) on the shoulder, slide the "
            "rear bearing in, push the drum shaft in until its flange rests on the rear bearing, and screw the "
            f"ring encoder on behind it ({ring.screw_count} x {ring.screw}, {key(layout, ring.screw)}). "
            "The base closes this side in the next step.",
            (
                *(
                    "frame",
                    "drum_bearing_front",
                    "drum_preload_spring",
                    "drum_bearing_rear",
                    "drum_shaft",
                    "drum_encoder",
                ),
                *numbered("drum_encoder_screw", 2),
                *insert_items("plate_insert", insert, len(layout.frame.plate_screws)),
            ),
        ),
        AssemblyStep(
            f"Bolt the frame to its base with {len(layout.frame.mounts)} {screw.words(printed)} through the back "
            f"plate, from the front ({screw.key_mm:g} mm key): collars and drum will stand before their heads."
        ),
    )


def _drives(layout: BevelLayout) -> tuple[AssemblyStep, ...]:
    gear, mounted, collar_screw = layout.drive.gearhead, layout.drive.mounted, layout.collar.screw
    train = "motors" if gear.absent else "gearheads with their motors"
    return (
        AssemblyStep(
            f"Screw the {train} under the motor shelf "
            f"({gear.screw_count} x {gear.screw} each). The screws go in through the open front of the coupling space; "
            f"the {key(layout, gear.screw)} reaches their heads from above, through the key holes in the shoulder of "
            "the empty lower bearing seats.",
            (() if gear.absent else _each("gearhead", layout))
            + _each("motor", layout)
            + _each(f"{mounted}_screw", layout, gear.screw_count),
        ),
        AssemblyStep(
            f"Pass the clamp collars, their screws ({collar_screw}) loose, over the {mounted} shafts through the open "
            f"front. Press the lower bearings ({layout.drive.bearings.input_lower.name}) into the bearing shelf "
            "from above.",
            _each("collar", layout) + _each("collar_screw", layout) + _each("input_bearing_lower", layout),
        ),
    )


def _encoders_below(layout: BevelLayout) -> tuple[AssemblyStep, ...]:
    drive = layout.drive
    encoder = drive.encoder
    return (
        AssemblyStep(
            "Slide the encoders into the lower pockets from the front and screw them to the bearing shelf from above "
            f"({encoder.screw_count} x {encoder.screw} each, {key(layout, encoder.screw)}), before their bearings "
            f"({drive.bearings.input_upper.name}) are pressed into the shelf from above.",
            _each("encoder", layout) + _each("encoder_screw", layout, 2) + _each("input_bearing_upper", layout),
        ),
    )


def _pulleys(layout: BevelLayout) -> tuple[AssemblyStep, ...]:
    drive, bearings, collar_screw = layout.drive, layout.drive.bearings, layout.collar.screw
    names = tuple(c.name for c in drive.cables)
    behind = " and ".join(_behind_the_guide(layout))
    loop = f"Lay the free ends of {behind} behind the axle. " if behind else ""
    lower = (
        "Lower the pulleys through the bearings into the bores of the encoders."
        if drive.motors_above
        else f"Lower the pulleys through bearing and collar onto the {drive.mounted} shafts and close the collars from "
        f"the front ({key(layout, collar_screw)})."
    )
    return (
        AssemblyStep(
            "Hook the stops of each cable into the slots in the end faces of its input pulley, wind the dead turns and "
            f"half of the live turns and hold them with tape. {lower}",
            _each("input_pulley", layout)
            + tuple(f"stop_{name}" for name in names)
            + tuple(cable_item(name) for name in names),
        ),
        AssemblyStep(
            f"Set the guide axle into the bearing shelf and fix it with its set screw ({AXLE_SCREW}, "
            f"{key(layout, AXLE_SCREW)}, from the front). {loop}"
            f"Slide on the guide with its two bearings ({bearings.guide.name}), then the spacer.",
            ("guide_axle", "axle_set_screw", "guide", "guide_bearing_lower", "guide_bearing_upper", "guide_spacer"),
        ),
    )


def _plate(layout: BevelLayout) -> tuple[AssemblyStep, ...]:
    drive, bearings = layout.drive, layout.drive.bearings
    encoder, screw = drive.encoder, plate_screw_of(drive).name
    return (
        AssemblyStep(
            "Press the two dowels into the side walls. On the bench, press the upper bearings "
            f"({bearings.input_upper.name}) into the top plate from below and screw the encoders to it from below "
            f"({encoder.screw_count} x {encoder.screw} each, {key(layout, encoder.screw)}). Lower the "
            f"plate over journals, axle and dowels, tighten four {screw} ({key(layout, screw)}), then "
            "the encoders' own clamps.",
            (
                *numbered("dowel", 2),
                "top_plate",
                *_each("input_bearing_upper", layout),
                *_each("encoder", layout),
                *_each("encoder_screw", layout, 2),
                *numbered("plate_screw", len(layout.frame.plate_screws)),
            ),
        ),
    )


def _drives_above(layout: BevelLayout) -> tuple[AssemblyStep, ...]:
    drive, gear, mounted = layout.drive, layout.drive.gearhead, layout.drive.mounted
    train = "motors" if gear.absent else "gearheads with their motors"
    screw, collar_screw = plate_screw_of(drive).name, layout.collar.screw
    return (
        AssemblyStep(
            f"On the bench, screw the {train} onto the top plate's boxes ({gear.screw_count} x {gear.screw} each). The "
            f"screws go in through the open front of the boxes; the {key(layout, gear.screw)} reaches their heads "
            "from below, through the key holes in the shoulder of the empty bearing seats. Pass the clamp collars, "
            f"their screws ({collar_screw}) loose, over the {mounted} shafts through the open front, and press the "
            f"bearings ({drive.bearings.input_lower.name}) into the plate from below.",
            ("top_plate",)
            + (() if gear.absent else _each("gearhead", layout))
            + _each("motor", layout)
            + _each(f"{mounted}_screw", layout, gear.screw_count)
            + _each("collar", layout)
            + _each("collar_screw", layout)
            + _each("input_bearing_lower", layout),
        ),
        AssemblyStep(
            "Press the two dowels into the side walls. Lower the plate with its motors over axle and dowels, the "
            f"pulleys' journals through bearings and collars onto the {mounted} shafts. Tighten four {screw} "
            f"({key(layout, screw)}, beside the motors), then from the front the collars "
            f"({key(layout, collar_screw)}) and the encoders' own clamps.",
            (*numbered("dowel", 2), *numbered("plate_screw", len(layout.frame.plate_screws))),
        ),
    )


def _drum(layout: BevelLayout) -> tuple[AssemblyStep, ...]:
    hub_screw, insert = layout.drum.set_screw, layout.drum.payload_insert
    places = len(layout.drum.payload_places)
    return (
        AssemblyStep(
            insert_words(insert, places, "the holes in the hub's face")
            + "Lead each cable round the guide on its own step and out to its side, and hold it taut there: between "
            "guide and drum there will be no room to lay it in. Push the drum onto the shaft, its set screws over the "
            "shaft's flats, until its spigot touches the front bearing, then press the stop pin through the slot into "
            "the web between the shelves. To preload the bearings, draw shaft and hub together until the shaft's end "
            f"is flush with the hub's face, which presses the spring with {layout.preload_spring.force_N:g} N, and "
            f"tighten the hub's two set screws ({hub_screw}, {key(layout, hub_screw)}, radially, in front of the "
            "web). The drum then has no play along its axis.",
            ("drum", "stop_pin", *numbered("hub_set_screw", 2), *insert_items("payload_insert", insert, places)),
        ),
        *_terminals(layout),
    )


def _terminals(layout: BevelLayout) -> tuple[AssemblyStep, ...]:
    """The last steps; with motors above, the lowest shelf may be behind a lug of the centred drum."""
    first, *others = terminal_steps(layout.drive, plan(layout))
    hidden = [t.cable_name for t in layout.drum.tensioners if layout.drive.motors_above and _before_frame(layout, t)]
    if hidden:
        names = " and ".join(hidden)
        first = replace(first, text=f"{first.text} For {names}, turn the drum until the lug is beside the frame.")
    return (first, *others)


def _before_frame(layout: BevelLayout, t: Tensioner) -> bool:
    """Whether a part of the terminal, drum centred, has the frame behind it."""
    v, half = layout.levels, layout.drive.tensioner.swage_diameter_mm / 2
    ends = [t.at(along, out) for along in (t.swage_start, t.tip) for out in (-half, half)]
    return any(abs(x) < v.side_outer_x and z > v.shelf_bottom_z for x, z in ends)
