"""Exact cable paths in figures: wraps and lengths over the travel, and the limits of the travel.

And the plan by which the preloads are set.
"""

from collections.abc import Iterator
from math import degrees, radians

from mbcdm_cad.layouts.bevel_transfer import TravelFigures, ends_at_drum, tensioned
from mbcdm_cad.layouts.sector import wraps_over_travel
from mbcdm_cad.layouts.siso_bevel.cable_path import full_input_turn_deg, input_wrap_rad
from mbcdm_cad.layouts.siso_bevel.layout import DirectLayout
from mbcdm_cad.model.tensioning import TensioningPlan, tensioning_plan
from mbcdm_cad.parts.terminal import tensioned_rope
from mbcdm_cad.routes.curves import EndOfTravel, by_sense, wrap_lines


def path_figures(layout: DirectLayout) -> TravelFigures:
    """The figures of one design at ``STATIONS`` drum angles over its travel."""
    return TravelFigures(*wraps_over_travel(layout), *by_sense(_ends(layout)))


def _ends(layout: DirectLayout) -> Iterator[EndOfTravel]:
    drive = layout.drive
    half = radians(drive.half_travel_deg)
    stop = drive.half_travel_deg + drive.stop_clearance_deg
    yield from (EndOfTravel(way * stop, "hard stop") for way in (1, -1))
    for run in drive.cables:
        ratio, off = run.drum_radius_mm / run.input_radius_mm, -run.drum_side
        yield from ends_at_drum(layout, run, "input")
        unwound = -half - radians(drive.reserve_deg) / ratio
        yield EndOfTravel(off * degrees(unwound), f"{run.name} is all off the input")
        full = radians(360.0 - full_input_turn_deg(drive, run)) / ratio
        yield EndOfTravel(off * degrees(half + full), f"the input has taken up a whole turn of {run.name}")


path_lines = wrap_lines


def plan(layout: DirectLayout) -> TensioningPlan:
    """Plan to set the preloads of this design, cables in the order of the file. No free span can be plucked."""
    drive = layout.drive
    cables = []
    for c, path in zip(drive.cables, layout.cable_paths(0.0), strict=True):
        wound = input_wrap_rad(drive, c, 0.0)
        cables.append(tensioned(layout, path, ((c.input_radius_mm * wound * 1e-3, wound),)))
    return tensioning_plan(cables, tensioned_rope(drive), drive.tensioner.pitch_mm * 1e-3)
