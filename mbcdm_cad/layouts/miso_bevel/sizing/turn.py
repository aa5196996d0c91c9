"""Rule of the gearheads' turn about their axes."""

from __future__ import annotations

from dataclasses import replace

from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.miso_bevel.checks.support_fits import head_seats, key_access
from mbcdm_cad.layouts.miso_bevel.checks.support_walls import front_wall
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.sizing.known import LATER, BevelKnown
from mbcdm_cad.sizing.rule import Found, Rule

STEP_DEG = 15.0
FIELD = "drive.gearhead_angle_deg"


def _drive(given: BevelKnown) -> BevelDrive | None:
    """The drive so far; None where it is none yet."""
    try:
        return given.trial(**LATER)
    except NoFigureError:
        return None


def _failing(drive: BevelDrive | None, turn_deg: float) -> str:
    """The check of the gearheads' screws that fails with gearheads turned by this angle; empty if none does."""
    if drive is None:
        return ""
    try:
        design = BevelLayout(replace(drive, gearhead_angle_deg=turn_deg))
        found = {check.__name__: check(design) for check in (head_seats, key_access, front_wall)}
    except NoFigureError:
        return ""
    return next((name for name, comparison in found.items() if not comparison.holds), "")


def _turn(given: BevelKnown) -> float | None:
    """The least turn, deg, with which the screws have their places; None where no turn is better than none."""
    drive = _drive(given)
    if not _failing(drive, 0.0):
        return None
    steps = int(180.0 / given.gearhead.screw_count / STEP_DEG)
    turns = (sense * k * STEP_DEG for k in range(1, steps + 1) for sense in (1, -1))
    return next((turn for turn in turns if not _failing(drive, turn)), None)


def _helps(given: BevelKnown) -> bool:
    return _turn(given) is not None


def _value(given: BevelKnown) -> Found:
    return Found(_turn(given), _failing(_drive(given), 0.0), f"to {STEP_DEG:g}")


# Where it does not apply, the schema's own value stays.
TURN = (
    Rule(
        FIELD,
        "the least turn with which the heads of the gearheads' screws and their key clear the walls",
        "head_seats",
        _value,
        applies=_helps,
    ),
)
