"""The order of assembly: the parts that each step adds, the tool, and the direction from which it works."""

from __future__ import annotations

from collections.abc import Iterator

from mbcdm_cad.layouts.miso_spur.layout import RoundDrumLayout
from mbcdm_cad.layouts.miso_spur.path_figures import plan
from mbcdm_cad.layouts.siso_spur.assembly_order import (
    boss_step,
    encoder_step,
    ends_words,
    idler_steps,
    input_steps,
    key,
    numbered,
)
from mbcdm_cad.parts.bill import AssemblyStep
from mbcdm_cad.parts.terminal.instructions import making_words, setting_steps, spring_words, terminal_items
from mbcdm_cad.parts.threads import insert_items, insert_words


def assembly_order(layout: RoundDrumLayout) -> tuple[AssemblyStep, ...]:
    """Steps with the sizes of this design. Each item is added in one step; each screw is accessible in its step."""
    drive = layout.drive
    mounts = tuple(
        item
        for name in drive.input_names
        for item in insert_items(f"mount_insert_{name}", layout.frame.mount_insert, len(layout.frame.mounts))
    )
    flanges = tuple(
        item
        for name in drive.input_names
        for item in insert_items(f"flange_insert_{name}", layout.frame.flange_insert, len(layout.frame.flange_screws))
    )
    return (
        _cut(layout),
        boss_step(layout.units[0], drive.n_inputs, (*flanges, *mounts)),
        *(encoder_step(unit) for unit in layout.units if not drive.overhung),
        *(step for unit in layout.units for step in input_steps(unit, f"_{unit.drive.input_names[0]}")),
        *(step for unit in layout.units for step in idler_steps(unit, f"_{unit.drive.input_names[0]}")),
        AssemblyStep(
            f"Screw the frame to its base with {len(layout.frame.mounts) * drive.n_inputs} {layout.mounting.name} from "
            "behind, into the plate's threads."
        ),
        *_drum(layout),
        *setting_steps(drive, plan(layout)),
    )


def _cut(layout: RoundDrumLayout) -> AssemblyStep:
    drive, found = layout.drive, {c.name: c.cut_length_m * 1e3 for c in plan(layout).cables}
    if drive.anchored:
        return AssemblyStep(ends_words(drive))
    cuts = ", ".join(
        f"{sum(found[side.name] for side in unit.drive.cables):.1f} mm for {name}"
        for unit, name in zip(layout.units, drive.input_names, strict=True)
    )
    return AssemblyStep(
        f"Cut {drive.n_inputs} cables ({drive.cable.name}, {drive.cable.diameter_mm:g} mm), {cuts}, both halves of the "
        f"bill of materials together, and end each in a threaded terminal ({drive.tensioner.name}) on either side, "
        f"{drive.termination.name}.{making_words(drive)} Mark its middle."
    )


def _drum(layout: RoundDrumLayout) -> Iterator[AssemblyStep]:
    """The sectors are pushed onto the shaft one after the other; the terminals of each are put into its lugs before."""
    drive, d = layout.drive, layout.drum
    places, names = len(d.payload_places), drive.input_names
    each = "each of its cables" if drive.anchored else "each end of its cable"
    for k, (unit, name) in enumerate(zip(layout.units, names, strict=True)):
        first, last = k == 0, k == len(names) - 1
        text = insert_words(d.payload_insert, places, "the holes in the hub's face") if last else ""
        text += (
            f"Push the sector of {name} on to the shaft, but not to its end, take off the tape and lay {each} "
            "over the rim to its own side, the one that leaves the input in front to the front. With nut and lock nut "
            "run on to the stud's end, drop both terminals sideways into the slotted lugs from behind. "
        )
        if first:
            text += "Push the sector further until its spigot touches the front bearing, and press the stop pin "
            text += "through the slot of its web into the plate. "
        else:
            text += f"Push it further until its spigot touches the hub of {names[k - 1]}, on both dowels. "
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
            text += "Press two dowels into the face of its hub for the next one."
            items += numbered(f"hub_dowel_{name}", 2)
        yield AssemblyStep(text, tuple(items))
