"""Two cable stages beside each other: what each takes of the ratio, the turn, the losses and the life of the whole."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from math import isfinite

from mbcdm_cad.layouts.base import Layout, NoFigureError
from mbcdm_cad.layouts.structure import urad_Nm
from mbcdm_cad.model.losses.train import GEARHEAD, GEARHEAD_IDLE, MOTOR
from mbcdm_cad.report.table import ReportTable, filled

# Kinds of the losses of a first stage in a whole drive, where it stands in place of a gearhead.
_OF_FIRST = (GEARHEAD, GEARHEAD_IDLE)


@dataclass(frozen=True)
class StageFigures:
    """One stage, or both. ``torque_Nm``: what it is made for, at its own drum.

    ``urad_Nm``: turn of the payload, the motor held; ``lost_Nm``: what it loses at the peak torque of the whole, at the
    drum of the whole, motors aside. ``life_cycles``: median of the cable that breaks first, in cycles of the output;
    None where there is no figure, with the reason in ``no_life``.
    """

    stage: str
    ratio: float
    travel_deg: float
    torque_Nm: float
    urad_Nm: float | None
    lost_Nm: float
    life_cycles: float | None
    no_life: str = ""


def stage_figures(layout: Layout) -> tuple[StageFigures, ...]:
    """The first stage, the second, and both; empty for a drive of one stage."""
    first, drive = layout.first_stage_unit, layout.drive
    if first is None:
        return ()
    lost = {True: 0.0, False: 0.0}
    for loss in layout.losses.moving(drive.loads.peak_torque_Nm, 1).losses:
        if loss.kind != MOTOR:
            lost[loss.kind in _OF_FIRST] += float(loss.torque_Nm[0])
    try:
        structure = layout.structure
    except NoFigureError:
        structure = None
    own: float | None = None
    before: float | None = None
    if structure is not None:
        before = urad_Nm(c for c in structure.causes if c.name == drive.mounted)
        own = structure.cables_urad_Nm + structure.motor_urad_Nm - before
    ratios = drive.reduction.ratio, float(layout.routed.routes.inputs[0].turns_per_drum)
    lives = _life(first), _life(layout)
    known = [cycles for cycles, _ in lives if cycles is not None]
    one = StageFigures(
        "first", ratios[0], first.drive.half_travel_deg, first.drive.loads.peak_torque_Nm, before, lost[True], *lives[0]
    )
    two = StageFigures(
        "second", abs(ratios[1]), drive.half_travel_deg, drive.loads.peak_torque_Nm, own, lost[False], *lives[1]
    )
    both = StageFigures(
        "both",
        one.ratio * two.ratio,
        two.travel_deg,
        two.torque_Nm,
        None if own is None or before is None else own + before,
        one.lost_Nm + two.lost_Nm,
        min(known) if len(known) == len(lives) else None,
    )
    return one, two, both


def _life(layout: Layout) -> tuple[float | None, str]:
    """Cycles of the cable that breaks first; None with the reason where one has no figure."""
    try:
        ropes = layout.life.ropes
    except NoFigureError as error:
        return None, str(error)
    for rope in ropes:
        if not isfinite(rope.cycles):
            return None, rope.refused if rope.longer else f"{rope.refused}; it may break first"
    return min(rope.cycles for rope in ropes), ""


def stage_table(found: tuple[StageFigures, ...]) -> ReportTable:
    """The figures as a table."""
    heads = ("stage", "ratio", "travel deg", "torque N m", "turn urad/N m", "lost N m", "N50 cycles")
    return ReportTable(heads, tuple(tuple(asdict(one).values())[: len(heads)] for one in found))


def stage_lines(layout: Layout, width: int | None) -> Iterator[str]:
    """For the terminal; nothing for a drive of one stage."""
    found = stage_figures(layout)
    if found:
        yield "Both cable stages, the motor held; turn and losses as seen at the drum of the second:"
        yield from stage_table(found).text(width, "  ")
        for one in found:
            if one.no_life:
                yield from filled(f"  {one.stage} stage, life of its cable: no figure, {one.no_life}", width)
