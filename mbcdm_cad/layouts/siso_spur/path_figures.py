"""Figures of the cable's path over the travel: wraps, lengths, walk, usable travel.

And the plan by which the preloads are set.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import atan2, degrees, pi, radians, tau

from mbcdm_cad.layouts.sector import wraps_over_travel
from mbcdm_cad.layouts.siso_spur.cable_path import side_length_mm, walked_mm
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.model.tensioning import TensionedCable, TensioningPlan, tensioning_plan
from mbcdm_cad.parts.terminal import highest_preload_N, tensioned_rope
from mbcdm_cad.routes.curves import CableWraps, EndOfTravel, by_sense, wrap_lines


@dataclass(frozen=True)
class SpurFigures:
    """Both sides over the travel.

    The limits of each direction are sorted, the nearest first; it ends the usable travel. ``wrap_deg`` is the wrap of a
    continuous cable on the input, None for anchored cables; ``walk_mm`` is the walk of the spans at each angle.
    """

    drum_angle_deg: tuple[float, ...]
    cables: tuple[CableWraps, ...]
    wrap_deg: float | None
    walk_mm: tuple[float, ...]
    limits_positive: tuple[EndOfTravel, ...]
    limits_negative: tuple[EndOfTravel, ...]

    @property
    def usable_deg(self) -> tuple[float, float]:
        """(lowest, highest) drum angle between the nearest limits."""
        return self.limits_negative[0].angle_deg, self.limits_positive[0].angle_deg


def path_figures(layout: SpurLayout) -> SpurFigures:
    """The figures of one design at ``STATIONS`` drum angles over its travel; wrap and walk are those of each input."""
    drive, units = layout.drive, layout.input_units
    (angles, *_), cables = zip(*map(wraps_over_travel, units), strict=True)
    return SpurFigures(
        angles,
        tuple(cable for of in cables for cable in of),
        None if drive.anchored else degrees(drive.wrap_rad),
        tuple(walked_mm(drive, radians(a)) for a in angles),
        *by_sense(dict.fromkeys(end for unit in units for end in _ends(unit))),
    )


def _ends(layout: SpurLayout) -> Iterator[EndOfTravel]:
    drive = layout.drive
    half = radians(drive.half_travel_deg)
    terminals = {t.cable_name: t for t in layout.terminals}
    stop = drive.half_travel_deg + drive.stop_clearance_deg
    cause = "hard stop" if drive.stopped else "something else must stop it: the drum has no stop"
    yield from (EndOfTravel(way * stop, cause) for way in (1, -1))
    for run in drive.cables:
        terminal, off = terminals[run.name], -run.drum_side

        def end(angle_rad: float, cause: str, off: int = off) -> EndOfTravel:
            return EndOfTravel(off * degrees(angle_rad), cause)

        yield end(terminal.anchor_rad - drive.landing_rad, f"wrap of {run.name} on the drum ends")
        # Beyond this angle the cable would lift off where it changes into the plane of its terminal.
        yield end(half + 0.01, f"{run.name} reaches the plane of its terminal")
        if drive.whole_drum:
            continue
        round_rad = tau - drive.landing_rad - terminal.anchor_rad - atan2(terminal.last_tip, terminal.radius_mm)
        yield end(-min(round_rad, pi), f"terminal of {run.name} comes round to the input")
        if drive.anchored:
            # The sense that unwinds it from the drum winds it on the input.
            yield end(-half - tau * drive.dead_turns / drive.total_ratio, f"{run.name} is all off the input")


path_lines = wrap_lines


def plan(layout: SpurLayout) -> TensioningPlan:
    """How the preloads of both sides are set, in the order of the drive."""
    drive, sides = layout.drive, [side for unit in layout.input_units for side in tensioned_sides(unit)]
    return tensioning_plan(sides, tensioned_rope(drive), drive.tensioner.pitch_mm * 1e-3)


def tensioned_sides(layout: SpurLayout) -> list[TensionedCable]:
    """Both sides of the cable in the order of the drive, with the length of a half each, or of one of two cables."""
    drive = layout.drive
    terminals = {t.cable_name: t for t in layout.terminals}
    stops = {slot.cable_name: slot.stop_start - slot.stop_end for pulley in layout.inputs for slot in pulley.slots}
    # Spans and, between them, wraps on idlers, which turn freely.
    led = tuple(length * drive.stretched * 1e-3 for length in drive.led_mm)
    cables = []
    for c in drive.cables:
        t = terminals[c.name]
        on_drum, wound = t.anchor_rad - drive.landing_rad, drive.wound_rad
        # Along the cable from the nut: straight end, drum, span, its wrap on the input.
        pieces = (
            (t.swage_start * 1e-3, 0.0),
            (c.drum_radius_mm * on_drum * 1e-3, on_drum),
            *((length, 0.0) for length in led[::-1]),
            (c.input_radius_mm * wound * drive.stretched * 1e-3, wound),
        )
        cables.append(
            TensionedCable(
                name=c.name,
                preload_N=c.preload_N,
                highest_preload_N=highest_preload_N(drive, c),
                length_m=side_length_mm(drive, c, *layout.anchors[c.name]) * 1e-3,
                ends_m=(t.cable_end - t.swage_start + stops.get(c.name, 0.0)) * 1e-3,
                lever_m=c.sense * c.drum_radius_mm * 1e-3,
                pieces=pieces,
                spans_m=led[::2],
                travel_m=t.travel * 1e-3,
            )
        )
    return cables
