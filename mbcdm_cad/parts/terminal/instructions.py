"""Instructions for setting the preload, for the order of assembly and the report."""

from __future__ import annotations

from mbcdm_cad.model.tensioning_plan import TensioningPlan
from mbcdm_cad.parts.bill import AssemblyStep
from mbcdm_cad.parts.drum_sector.design import SectorDrive

# Times the drum is swung over its travel to let the tension even out along a cable (estimate).
SWINGS = 10


def terminal_steps(drive: SectorDrive, plan: TensioningPlan) -> tuple[AssemblyStep, ...]:
    """The last steps of an order of assembly: terminals into their lugs, then the preloads."""
    return (
        AssemblyStep(
            "Lay each cable onto its land. With nut and lock nut run on to the stud's end, drop its terminal sideways "
            f"into the slotted lug from the drum's inner side.{spring_words(drive)}",
            terminal_items(drive),
        ),
        *setting_steps(drive, plan),
    )


def ends_words(drive: SectorDrive) -> str:
    """The first step: ends of cables that each lead from a stop to a terminal."""
    rope = drive.cable
    return (
        f"End each cable ({rope.name}, {rope.diameter_mm:g} mm) in a stop on one side and a threaded terminal "
        f"({drive.tensioner.name}) on the other, both {drive.termination.name}, to the cut lengths of the bill of "
        f"materials.{making_words(drive)}"
    )


def numbered(stem: str, count: int) -> tuple[str, ...]:
    """Names of items of one kind."""
    return tuple(f"{stem}_{n}" for n in range(1, count + 1))


def making_words(drive: SectorDrive) -> str:
    """How the ends are made, after the sentence that names them; nothing for ends whose entry does not say it."""
    making = drive.termination.making
    return "" if making is None else f" {making}"


def terminal_items(drive: SectorDrive) -> tuple[str, ...]:
    """The terminals of all cables with springs and nuts."""
    return tuple(
        item
        for c in drive.cables
        for item in (f"terminal_{c.name}", *spring_items(drive, c.name), f"nut_{c.name}_1", f"nut_{c.name}_2")
    )


def spring_items(drive: SectorDrive, cable_name: str) -> tuple[str, ...]:
    """Washer and springs on the stud of one cable."""
    if drive.spring is None:
        return ()
    springs = (f"spring_{cable_name}_{n + 1}" for n in range(drive.drum.spring_count))
    return (f"spring_washer_{cable_name}_1", *springs, f"spring_washer_{cable_name}_2")


def spring_words(drive: SectorDrive) -> str:
    """What is put on the studs before the nuts, as a sentence; nothing without springs."""
    spring, count = drive.spring, drive.drum.spring_count
    if spring is None:
        return ""
    discs = f", discs in pairs against each other, rim on rim and bore on bore, {spring.name}" if count > 1 else ""
    what = f"{count} springs{discs}" if count > 1 else f"one spring {spring.name}"
    return f" On each stud lie, from the lug: a hardened washer, {what}, a washer, the nuts; grease them."


def spring_heights(drive: SectorDrive) -> str:
    """Height of the springs at each preload, by which it can be set; nothing without springs."""
    if drive.spring is None:
        return ""
    heights = ", ".join(f"{c.name} {drive.spring_height_mm(c.preload_N):.2f}" for c in drive.cables)
    return (
        f" The springs show the preload: with their washers they are {drive.spring_free_mm:.2f} mm high without load "
        f"and, once the drum was swung, in mm: {heights}."
    )


def setting_steps(drive: SectorDrive, plan: TensioningPlan) -> tuple[AssemblyStep, ...]:
    """The step that sets the preloads, with the terminals in their lugs."""
    preloads = ", ".join(f"{c.preload_N:g}" for c in drive.cables)
    return (
        AssemblyStep(
            f"Set the preloads, {preloads} N, with the drum centred, turning each nut with a "
            f"{drive.tensioner.nut_across_flats_mm:g} mm spanner: the flat of the sleeve lies against its pocket and "
            f"keeps the rope from twisting.{spring_heights(drive)}"
        ),
        *(AssemblyStep(words) for words in tensioning_words(plan)),
    )


def tensioning_words(plan: TensioningPlan) -> tuple[str, ...]:
    """Steps on the bench, drum centred, inputs held: measure a tension, tighten in order, bed in, repeat."""
    first_round = plan.pulls[: len(plan.cables)]
    highest = max(max(pull.tension_N) for pull in plan.pulls)
    return (
        _calibration(plan),
        "Hold the inputs and leave the drum free. Tighten the cables in this order, each to its reading, and swing the "
        f"drum {SWINGS} times over its travel after each, since friction on the wraps keeps the far end slack: "
        + ", ".join(
            f"{p.cable} to {p.tension_N[[c.name for c in plan.cables].index(p.cable)]:.0f} N ({p.turns:.1f} turns)"
            for p in first_round
        )
        + f". What is tightened first changes as the others follow, up to {highest:.0f} N on the way.",
        "Repeat the round until all readings stay: "
        + "; ".join(f"{p.cable} {p.turns:+.2f} turns" for p in plan.pulls[len(first_round) :])
        + f" if all goes as computed. {_turns(plan)}",
        f"Lock the nuts, run the drive for some hundred sweeps, wait a day and tighten again: bedding-in takes up to "
        f"{max(c.bedding_loss_N for c in plan.cables):.0f} N from a new rope. Repeat until a day costs less than 2 %.",
    )


def _turns(plan: TensioningPlan) -> str:
    by_name = ", ".join(f"{c.name} {1.0 / c.turns_per_N:.0f}" for c in plan.cables)
    first = ", ".join(f"{1.0 / c.turns_per_N_first:.0f}" for c in plan.cables)
    return (
        f"One turn of a nut ({plan.pitch_m * 1e3:g} mm) is worth, in N: {by_name} with the drum held and the cable "
        f"worked in; {first} before the drum is swung."
    )


def _calibration(plan: TensioningPlan) -> str:
    if not all(c.span_m for c in plan.cables):
        return (
            "No span of these cables is free to be plucked: hang a known weight on each cable before its terminal goes "
            "into the lug, mark where the terminal stands, and count turns of the nut from there."
        )
    ranges = ", ".join(f"{c.name} {c.pitch_Hz[0][0]:.0f} to {c.pitch_Hz[0][1]:.0f} Hz" for c in plan.cables)
    spread = max(c.tension_spread for c in plan.cables)
    if plan.by_pitch:
        return f"Pluck the free span of each cable and read its pitch: {ranges} at its preload."
    return (
        f"Calibrate first: the pitch of a plucked span at its preload lies anywhere in {ranges}, by how firmly the "
        f"wires stick to each other, so a pitch alone leaves {spread:.0%} of the tension open. Clamp a length of the "
        "same rope over two edges as far apart as the span, hang the preload on it as a weight, pluck it and note the "
        "pitch; tensions near it go with the square of the pitch and of the span."
    )
