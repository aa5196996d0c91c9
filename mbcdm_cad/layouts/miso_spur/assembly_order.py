"""The order of assembly: the parts that each step adds, the tool, and the direction from which it works."""

from __future__ import annotations

from mbcdm_cad.layouts.miso_spur.layout import RoundDrumLayout
from mbcdm_cad.layouts.miso_spur.path_figures import plan
from mbcdm_cad.layouts.siso_spur.assembly_order import boss_step, encoder_step, idler_steps, input_steps, sector_steps
from mbcdm_cad.parts.bill import AssemblyStep
from mbcdm_cad.parts.terminal.instructions import ends_words, making_words, setting_steps
from mbcdm_cad.parts.threads import insert_items


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
        *sector_steps(layout),
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
