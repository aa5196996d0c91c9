"""The order of assembly: the parts that each step adds, the tool, and the direction from which it works."""

from __future__ import annotations

from collections.abc import Iterator
from math import tau

from mbcdm_cad.checks.bearings import stage_torque_Nm
from mbcdm_cad.design.bought import Servo
from mbcdm_cad.design.stage import SET_TENSION, Stage
from mbcdm_cad.layouts.sector import key
from mbcdm_cad.layouts.siso_spur.bill import first_name
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.siso_spur.overhung import set_screw
from mbcdm_cad.layouts.siso_spur.path_figures import plan
from mbcdm_cad.layouts.siso_spur.support.idlers import strap_screw
from mbcdm_cad.parts.bill import AssemblyStep, cable_item
from mbcdm_cad.parts.bought.train import train_items, train_words
from mbcdm_cad.parts.input_pulley.dims import SET_SCREWS_DEG
from mbcdm_cad.parts.motor_head.dims import flange_screw
from mbcdm_cad.parts.terminal.instructions import (
    ends_words,
    making_words,
    numbered,
    setting_steps,
    spring_words,
    terminal_items,
    terminal_steps,
)
from mbcdm_cad.parts.threads import insert_items, insert_words


def assembly_order(layout: SpurLayout) -> tuple[AssemblyStep, ...]:
    """Steps with the sizes of this design. Each item is added in one step; each screw is accessible in its step.

    A first stage comes first, as a whole; what it is screwed on holds it in place of a base.
    """
    before: tuple[AssemblyStep, ...] = ()
    drum = _drum(layout)
    if layout.drive.parallel > 1:
        drum = (*sector_steps(layout), *setting_steps(layout.drive, plan(layout)))
    if layout.first_stage_unit is not None:
        first = layout.first_stage_unit
        steps = (*_frame(first), *input_steps(first), *_drum(first))
        before = tuple(
            AssemblyStep(f"First stage: {s.text}", tuple(first_name(name) for name in s.items)) for s in steps
        )
    return (*before, *_frame(layout), *input_steps(layout), *idler_steps(layout), _base(layout), *drum)


def idler_steps(layout: SpurLayout, mark: str = "") -> tuple[AssemblyStep, ...]:
    """Each pair on its axles, the cables led between, and the strap over both; ``mark`` as in the bill."""
    drive, screw, found = layout.drive, strap_screw(layout.drive).name, []
    for n in range(len(layout.frame.stands)):
        held = [[body.removeprefix("idler_") for body in pin.bodies] for pin in layout.pins if pin.number == n]
        led = (
            "slide the idlers on; lead both ends of the cable down between the two idlers and round the one on the "
            "side of the drum where it ends. Slide the spacers on, "
            if drive.parallel == 1
            else "from the rear cable to the front one slide the two idlers of a cable on, lead both its ends down "
            "between them and round the one on the side of the drum where it ends, and slide a spacer on before each. "
            "Then "
        )
        found.append(
            AssemblyStep(
                f"Press a bearing ({drive.idler_bearing.name}) into both ends of the idlers of pair {n + 1}, counted "
                f"from the input. From the front, push the axles into the plate as far as their collars and {led}"
                "lay the strap over both axles and screw it on the posts "
                f"(2 x {screw}, {key(layout, screw)}). The idlers turn freely, with a little play along the axle.",
                (
                    *(name for tags in held for name in (f"idler_axle_{tags[0]}", *_on_axle(tags))),
                    f"idler_strap{mark}_{n + 1}",
                    *numbered(f"idler_strap_screw{mark}_{n + 1}", 2),
                ),
            )
        )
    return tuple(found)


def _on_axle(tags: list[str]) -> Iterator[str]:
    kinds = ("idler", "idler_bearing_rear", "idler_bearing_front", "idler_spacer")
    return (f"{kind}_{tag}" for tag in tags for kind in kinds)


def _frame(layout: SpurLayout) -> tuple[AssemblyStep, ...]:
    drive, f = layout.drive, layout.frame
    inserts = (
        *insert_items("flange_insert", f.flange_insert, len(f.flange_screws)),
        *insert_items("mount_insert", f.mount_insert, len(f.mounts)),
    )
    return (
        AssemblyStep(ends_words(drive) if drive.anchored else _cut_words(layout)),
        boss_step(layout, 1, inserts),
        *(() if drive.overhung else (encoder_step(layout),)),
    )


def _cut_words(layout: SpurLayout) -> str:
    drive, rope = layout.drive, layout.drive.cable
    # Cables in parallel are equal.
    cut = sum(setting.cut_length_m for setting in plan(layout).cables[:2]) * 1e3
    count, it = ("one cable", "it") if drive.parallel == 1 else (f"{drive.parallel} cables", "each")
    return (
        f"Cut {count} ({rope.name}, {rope.diameter_mm:g} mm) {cut:.1f} mm long, both halves of the bill of "
        f"materials together, and end {it} in a threaded terminal ({drive.tensioner.name}) on either side, "
        f"{drive.termination.name}.{making_words(drive)} Mark its middle."
    )


def boss_step(layout: SpurLayout, heads: int, inserts: tuple[str, ...]) -> AssemblyStep:
    """Bearings, shaft and encoder of the drum in a frame with ``heads`` motor heads."""
    drive, spring, f = layout.drive, layout.preload_spring, layout.frame
    ring, flange, mount = drive.drum_encoder, f.flange_insert, f.mount_insert
    seen = (
        "."
        if ring.absent
        else (
            f", and screw the ring encoder on behind it ({ring.screw_count} x {ring.screw}, {key(layout, ring.screw)})."
        )
    )
    encoder = () if ring.absent else ("drum_encoder", *numbered("drum_encoder_screw", 2))
    for_heads = "the motor head" if heads == 1 else "the motor heads"
    return AssemblyStep(
        insert_words(flange, heads * len(f.flange_screws), f"the back of the plate, for {for_heads},")
        + insert_words(mount, heads * len(f.mounts), "the back of the plate, for its own screws,")
        + f"Press the front drum bearing ({drive.bearings.drum.name}) into the frame's boss from the front. From "
        f"behind, lay the wave spring ({spring.force_N:g} N at {spring.height:g} mm) on the shoulder, slide the "
        f"rear bearing in, push the drum shaft in until its flange rests on the rear bearing{seen}",
        (
            *("frame", "drum_bearing_front", "drum_preload_spring"),
            *("drum_bearing_rear", "drum_shaft"),
            *encoder,
            *inserts,
        ),
    )


def encoder_step(layout: SpurLayout) -> AssemblyStep:
    """Encoder, if any, and front bearing of the input on the encoder shelf."""
    drive, encoder, name = layout.drive, layout.drive.encoder, layout.drive.input_names[0]
    if encoder.absent:
        return AssemblyStep(
            "From behind, through the opening of the plate, press the bearing "
            f"({drive.bearings.input_upper.name}) into the shelf.",
            (f"input_bearing_upper_{name}",),
        )
    return AssemblyStep(
        f"Hold the encoder before its shelf and screw it on from behind, through the opening of the plate "
        f"({encoder.screw_count} x {encoder.screw}, {key(layout, encoder.screw)}); their heads are sunk below the "
        f"pulley. Through the same opening press the bearing ({drive.bearings.input_upper.name}) into the shelf.",
        (f"encoder_{name}", *numbered(f"encoder_screw_{name}", 2), f"input_bearing_upper_{name}"),
    )


def input_steps(layout: SpurLayout, mark: str = "") -> tuple[AssemblyStep, ...]:
    """Pulley, motor head and cable of the input; ``mark`` as in the bill."""
    if layout.drive.overhung:
        return _on_shaft_steps(layout)
    drive, collar_screw, name = layout.drive, layout.collar.screw, layout.drive.input_names[0]
    flange = flange_screw(drive).name
    gear = drive.gearhead
    if drive.stage is not None:
        return _pulley_step(drive), *_stage_steps(layout, drive.stage, mark), _winding_step(drive)
    return (
        _pulley_step(drive),
        AssemblyStep(
            f"On the bench, screw the {train_words(drive)} on the motor head ({gear.screw_count} x {gear.screw}). "
            f"The screws go in through the open side of the coupling space; the {key(layout, gear.screw)} reaches "
            "their heads from the flange, through the key holes in the shoulder of the empty bearing seat. Pass the "
            f"clamp collar, its screw ({collar_screw}) loose, over the {drive.mounted}'s shaft through the open side, "
            f"and press the bearing ({drive.bearings.input_lower.name}) into the flange.",
            (
                *(f"motor_head{mark}", *train_items(drive, name)),
                *numbered(f"{drive.mounted_stem}_screw_{name}", gear.screw_count),
                *(f"collar_{name}", f"collar_screw_{name}", f"input_bearing_lower_{name}"),
            ),
        ),
        AssemblyStep(
            "Press the two dowels into the plate. Slide the head from behind over the pulley's journal and the dowels, "
            f"its open side away from the drum, tighten four {flange} from behind "
            f"({key(layout, flange)}), then the collar through the open side ({key(layout, collar_screw)}).",
            (*numbered(f"dowel{mark}", 2), *numbered(f"flange_screw{mark}", len(layout.frame.flange_screws))),
        ),
        _winding_step(drive),
    )


def _stage_steps(layout: SpurLayout, stage: Stage, mark: str) -> tuple[AssemblyStep, ...]:
    """Motor head with belt or gears: the motor beside the input, its wheel bonded, the other clamped on the journal."""
    drive, name, gear = layout.drive, layout.drive.input_names[0], layout.drive.gearhead
    flange, collar_screw = flange_screw(drive).name, layout.collar.screw
    wheel = "pulley" if stage.is_belt else "gear"
    loose = ", its screws loose" * stage.is_belt
    bench = AssemblyStep(
        f"On the bench, press the bearing ({drive.bearings.input_lower.name}) into the motor head's flange, and screw "
        f"the {train_words(drive)} on the motor shelf ({gear.screw_count} x {gear.screw}, {key(layout, gear.screw)}, "
        f"from the open side before the flange){loose}. Then bond the driving {wheel} ({stage.driver_teeth} teeth) on "
        f"the {drive.mounted}'s shaft with retaining compound, {layout.stage_clear_mm:.1f} mm from its face.",
        (
            *(f"motor_head{mark}", f"input_bearing_lower_{name}", *train_items(drive, name)),
            *(*numbered(f"{drive.mounted_stem}_screw_{name}", gear.screw_count), f"stage_driver_{name}"),
        ),
    )
    laid = tight = ""
    if stage.is_belt:
        spans = SET_TENSION * stage.force_N(stage_torque_Nm(layout))
        laid = f" Lay the belt ({stage.belt}, {stage.belt_teeth} teeth, {stage.width_mm:g} mm) round both."
        tight = f" Push the motor along its slots until each span pulls with {spans:.3g} N, and tighten its screws."
    held = AssemblyStep(
        f"Pass the driven {wheel} ({stage.driven_teeth} teeth), the collar with its screw ({collar_screw}) loose on "
        f"its hub, into the box through its open side.{laid} Press the two dowels into the plate. Slide the head from "
        f"behind over the dowels, the journal through its bearing and the {wheel}, until their ends are flush. "
        f"Tighten four {flange} from behind ({key(layout, flange)}), then the collar through the open side "
        f"({key(layout, collar_screw)}).{tight}",
        (
            *(f"stage_driven_{name}", f"collar_{name}", f"collar_screw_{name}"),
            *((f"stage_belt_{name}",) if stage.is_belt else ()),
            *numbered(f"dowel{mark}", 2),
            *numbered(f"flange_screw{mark}", len(layout.frame.flange_screws)),
        ),
    )
    return bench, held


def _on_shaft_steps(layout: SpurLayout) -> tuple[AssemblyStep, ...]:
    """Motor on the plate, then the pulley on its shaft, then the cable."""
    drive, gear, name = layout.drive, layout.drive.gearhead, layout.drive.input_names[0]
    screw, pulley = set_screw(drive).name, layout.inputs[0]
    if drive.servo is not None:
        return _on_horn_steps(layout, drive.servo)
    return (
        AssemblyStep(
            f"Hold the {train_words(drive)} on the back of the plate, its pilot in the bore, and screw it on from the "
            f"front, the screws' heads in the pocket ({gear.screw_count} x {gear.screw}, {key(layout, gear.screw)}).",
            (*train_items(drive, name), *numbered(f"{drive.mounted_stem}_screw_{name}", gear.screw_count)),
        ),
        AssemblyStep(
            f"Push the input pulley, hub first, on the {drive.mounted}'s shaft until its land begins "
            f"{pulley.land_bottom_z - layout.levels.front_y:.2f} mm in front of the plate; turn it so that a set screw "
            f"is over the shaft's flat, if it has one, and tighten both ({screw}, {key(layout, screw)}, radially, "
            "between plate and land).",
            (f"input_pulley_{name}", *numbered(f"pulley_set_screw_{name}", len(SET_SCREWS_DEG))),
        ),
        _winding_step(drive),
    )


def _on_horn_steps(layout: SpurLayout, servo: Servo) -> tuple[AssemblyStep, ...]:
    """Servo on the plate, its horn centred, the pulley on the horn, then the cable."""
    drive, gear, name = layout.drive, layout.drive.gearhead, layout.drive.input_names[0]
    return (
        AssemblyStep(
            f"Push the servo ({drive.motor.name}) from behind into the window of the plate and screw its ears on from "
            f"behind ({gear.screw_count} x {gear.screw}, {key(layout, gear.screw)}). Turn it to the middle of its "
            f"travel by its controller, push the horn ({servo.spline}) on the spline and tighten its screw "
            f"({servo.centre_screw}, {key(layout, servo.centre_screw)}).",
            (*train_items(drive, name), *numbered(f"servo_screw_{name}", gear.screw_count)),
        ),
        AssemblyStep(
            "Lay the input pulley's flange on the horn, its recess over the horn's screw, and screw it on from the "
            f"front ({servo.horn_screws} x {servo.horn_screw}, {key(layout, servo.horn_screw)}, beside the land).",
            (f"input_pulley_{name}", *numbered(f"flange_screw_{name}", servo.horn_screws)),
        ),
        _winding_step(drive),
    )


def _pulley_step(drive: SpurDrive) -> AssemblyStep:
    """The pulley into its front bearing, with the stops of anchored cables, which cannot be reached later."""
    name = drive.input_names[0]
    hook = "Hook the stops of both cables into the slots in the end faces of the input pulley. " * drive.anchored
    led = ", their free ends before it," if drive.anchored else ""
    stops = tuple(f"stop_{c.name}" for c in drive.cables) if drive.anchored else ()
    into = "into the bearing." if drive.encoder.absent else "through the bearing into the encoder, and tighten the "
    into += "encoder's own clamp." * (not drive.encoder.absent)
    return AssemblyStep(
        f"{hook}Push the input pulley{led} through the opening from behind, {into}", (f"input_pulley_{name}", *stops)
    )


def _winding_step(drive: SpurDrive) -> AssemblyStep:
    if not drive.anchored:
        how = "in the groove" if drive.input_pulleys.grooved else "side by side"
        under = "" if drive.overhung else "under the bridge, "
        way = "not crossed" if drive.open_spans else "crossed"
        the = "the cable" if drive.parallel == 1 else "each cable in its own length of the land"
        return AssemblyStep(
            f"Lead {the} round the input from its middle out, {drive.turns} turns {how}, "
            f"{under}and hold it with tape; its ends lie on both sides of the plate, {way}.",
            tuple(cable_item(name) for name in drive.cable_names),
        )
    how = "in its groove" if drive.input_pulleys.grooved else "side by side"
    return AssemblyStep(
        f"Wind each cable on to the input from its stop towards the middle, {drive.wound_rad / tau:.1f} turns {how}, "
        "in opposite senses, and hold both with tape; their ends lie on both sides of the plate, crossed.",
        tuple(cable_item(c.name) for c in drive.cables),
    )


def _base(layout: SpurLayout) -> AssemblyStep:
    count = len(layout.frame.mounts)
    return AssemblyStep(
        f"Screw the frame to its base with {count} {layout.mounting.name} from behind, into the plate's threads."
    )


def _drum(layout: SpurLayout) -> tuple[AssemblyStep, ...]:
    drive, hub_screw, insert = layout.drive, layout.drum.set_screw, layout.drum.payload_insert
    places = len(layout.drum.payload_places)
    bonded = "Wet the shaft with retaining compound. " * (drive.drum.shaft_end_mm > 0.0)
    pin = ("stop_pin",) if drive.stopped else ()
    pressed = ", then press the stop pin through the slot of its web into the plate" if pin else ""
    each = "each cable" if drive.anchored else "each end of the cable"
    return (
        AssemblyStep(
            insert_words(insert, places, "the holes in the hub's face")
            + bonded
            + "Push the drum onto the shaft, its set screws over the shaft's flats, until its spigot touches the front "
            f"bearing{pressed}. To preload the bearings, "
            "draw shaft and hub together until the shaft's end is flush with the hub's face, which presses the spring "
            f"with {layout.preload_spring.force_N:g} N, and tighten the hub's two set screws ({hub_screw}, "
            f"{key(layout, hub_screw)}, radially, in front of the web). Take off the tape and lay "
            f"{each} over the rim to its own side, the one that leaves the input in front to the front.",
            ("drum", *pin, *numbered("hub_set_screw", 2), *insert_items("payload_insert", insert, places)),
        ),
        *terminal_steps(drive, plan(layout)),
    )


def sector_steps(layout: SpurLayout) -> Iterator[AssemblyStep]:
    """Several sectors are pushed onto the shaft one by one; the terminals of each are put into its lugs before."""
    drive, d = layout.drive, layout.drum
    places, names = len(d.payload_places), drive.sector_names
    each = "each of its cables" if drive.anchored else "each end of its cable"
    faces = "their open side" if drive.whole_drum else "behind"
    for k, (unit, name) in enumerate(zip(layout.units, names, strict=True)):
        first, last = k == 0, k == len(names) - 1
        before = f"sector {names[k - 1]}" if drive.parallel > 1 else names[k - 1]
        sector = f"sector {name}, counted from the back," if drive.parallel > 1 else f"the sector of {name}"
        text = insert_words(d.payload_insert, places, "the holes in the hub's face") if last else ""
        text += (
            f"Push {sector} on to the shaft, but not to its end, take off the tape and lay {each} "
            "over the rim to its own side, the one that leaves the input in front to the front. With nut and lock nut "
            f"run on to the stud's end, drop both terminals sideways into the slotted lugs from {faces}. "
        )
        if first:
            text += "Push the sector further until its spigot touches the front bearing, and press the stop pin "
            text += "through the slot of its web into the plate. "
        else:
            text += f"Push it further until its spigot touches the hub of {before}, on both dowels. "
        text += spring_words(drive).strip() + " " if drive.spring else ""
        items = [f"drum_{name}", *terminal_items(unit.drive)]
        if first:
            items.append("stop_pin")
        if last:
            screw = d.set_screw
            text += (
                "To preload the bearings, draw shaft and hubs together until the shaft's end is flush with the face of "
                f"the last hub, which presses the spring with {layout.preload_spring.force_N:g} N, and tighten its two "
                f"set screws ({screw}, {key(unit, screw)}, radially, in front of the web)."
            )
            items += [*numbered("hub_set_screw", 2), *insert_items("payload_insert", d.payload_insert, places)]
        else:
            text += "Press two dowels into the face of its hub for the next one. "
            text += "Wet face and dowels with retaining compound."
            items += numbered(f"hub_dowel_{name}", 2)
        yield AssemblyStep(text, tuple(items))
