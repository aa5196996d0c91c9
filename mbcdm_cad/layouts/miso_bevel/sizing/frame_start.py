"""What the rules of the frame begin with, raised as long as the sized frame misses the checks of its mounting."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import inf

from mbcdm_cad.checks.structure import frame_windup, mounting_screws
from mbcdm_cad.design.drive import met
from mbcdm_cad.design.sized import Sizing, SizingError
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.sizing.known import BevelKnown, FrameStart
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.parts.fits import MOUNT_SCREWS

MOUNT_SCREW, WALLS = "support.mount_screw", ("support.back_plate_mm", "support.rib_mm")
SPARE = 1.02
# Factors of :class:`FrameStart` in the order in which they are raised: by this power of what is missing and a little
# more, so that the search ends; up to which multiple (more fills the frame, and the check asks for another material);
# and only where less than this is missing. Part of the frame's strain is no bending of back plate and ribs, and only
# a tenth is that of shelf and side walls.
FACTORS = (("stiffer", 0.5, 3.0, inf), ("shelves", 5.0, 3.0, 1.25))

Filled = tuple[BevelKnown, Sizing]


def with_strong_frame(filled_from: Callable[[FrameStart], Filled], *, first: bool = False) -> Sizing:
    """The sizing from the least start with which screws and walls hold, else from the one whose walls bend least.

    ``first``: from the least start with which the screws hold.
    """
    start = FrameStart()
    while True:
        given, sizing = filled_from(start)
        screw = _thicker_screw(given, sizing)
        if screw is None:
            break
        start = replace(start, mount_screw=screw)
    if first:
        return sizing
    least, best = _over_limit(given, sizing), sizing
    for name, power, most, worst in FACTORS:
        while 1.0 < least < worst and getattr(start, name) < most:
            more = replace(start, **{name: getattr(start, name) * SPARE * least**power})
            try:
                given, sizing = filled_from(more)
            except SizingError:  # such walls are out of bounds
                break
            over = _over_limit(given, sizing)
            if over >= least:  # what misses now is not these walls
                break
            start, least, best = more, over, sizing
    return best


def _thicker_screw(given: BevelKnown, sizing: Sizing) -> str | None:
    """The next screw, where the rules chose one that does not hold."""
    names = list(MOUNT_SCREWS)
    thicker = names[names.index(given.frame.mount_screw) + 1 :]
    if not thicker or not _chosen(sizing, (MOUNT_SCREW,)):
        return None
    try:
        return None if mounting_screws(_layout(given)).holds else thicker[0]
    except (NoFigureError, SizingError):
        return None  # what is wrong with the drive is said by the rules of the file and by the checks


def _over_limit(given: BevelKnown, sizing: Sizing) -> float:
    """The frame's windup over its limit; 0 where the rules chose no wall, infinite where the frame has no figure."""
    if not _chosen(sizing, WALLS):
        return 0.0
    try:
        found = frame_windup(_layout(given))
    except (NoFigureError, SizingError):
        return inf
    return found.actual / found.limit


def _chosen(sizing: Sizing, fields: tuple[str, ...]) -> bool:
    return any(value.field in fields for value in sizing.values)


def _layout(given: BevelKnown) -> BevelLayout:
    found = layout_of(met(given.trial()))
    assert isinstance(found, BevelLayout)
    return found
