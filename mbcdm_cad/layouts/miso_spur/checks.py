"""The checks of this layout: those of siso_spur for each input with its cable and sector, and those of all together."""

from collections.abc import Callable, Iterator
from math import atan2, hypot, pi, tan
from typing import NamedTuple

import numpy as np

from mbcdm_cad.checks.comparison import Family, Findings, at_most, check
from mbcdm_cad.checks.design_variables import Adjustment, down, up
from mbcdm_cad.checks.geometry import HOLE_WEB_MM
from mbcdm_cad.design.paths import at
from mbcdm_cad.layouts.miso_spur.layout import RoundDrumLayout
from mbcdm_cad.layouts.siso_spur.checks import FAMILIES as OF_ONE_INPUT
from mbcdm_cad.layouts.siso_spur.checks import frame, winding
from mbcdm_cad.layouts.siso_spur.checks.frame import BOX, DOWELS, GAPS, sectors_apart
from mbcdm_cad.layouts.siso_spur.checks.winding import stacks
from mbcdm_cad.parts.drum_sector.sizes import nut_corner_radius_mm

__all__ = ["FAMILIES", "stacks"]

# Largest torque of an input over the mean (a choice: reserve of its motor compared with the others).
LARGEST_OVER_MEAN = 1.1


_OUT: tuple[Adjustment, ...] = up(at.transmission.centre_distance_mm)


def load_shares(s: RoundDrumLayout) -> np.ndarray:
    """Share (2, n_inputs) of the peak torque, each direction, that every input takes besides its bias torque."""
    idle, forward, back, *_ = s.loads.input_torque_Nm
    taken = np.stack([forward - idle, back - idle])
    return np.asarray(taken / taken.sum(axis=1, keepdims=True))


@check(
    "Shares of the inputs in the load",
    "model; 1.1: a choice",
    *up(at.rope.preload_N),
    *down(at.loads.peak_torque_Nm),
    advice="leave out preload_N of single entries of cables, so that rope.preload_N is that of all",
    warn=True,
)
def load_sharing(s: RoundDrumLayout) -> Findings:
    """Torque of the most loaded input at peak torque over the mean of all inputs."""
    shares = load_shares(s)
    listed = ", ".join(f"{name} {share:.1%}" for name, share in zip(s.drive.input_names, shares[0], strict=True))
    for way in shares:
        yield at_most(
            f"torque of the {s.drive.input_names[int(way.argmax())]} input over the mean of all at peak torque",
            float(way.max()) * len(s.units),
            LARGEST_OVER_MEAN,
            "times",
            f"shares {listed}, by the stiffness of the cables while the inputs are held",
        )


class Zone(NamedTuple):
    """Space of a part at an input: range along y, least distance from the drum's axis, half its width."""

    name: str
    from_y_mm: float
    to_y_mm: float
    inner_mm: float
    half_width_mm: float


def _shelf(s: RoundDrumLayout, index: int) -> Iterator[Zone]:
    """The encoder shelf at an input, which begins just outside the rim for any centre distance."""
    f, v = s.units[index].frame, s.units[index].levels
    name = f"encoder shelf of {s.drive.input_names[index]}"
    yield Zone(name, v.top_plate_bottom_z, v.top_plate_top_z, f.shelf_bottom_z, f.shelf_half_width)


def _on_axis(s: RoundDrumLayout, index: int) -> Iterator[Zone]:
    """Parts round the axis of an input."""
    unit, drive = s.units[index], s.drive
    pulley, f, v = unit.inputs[0], unit.frame, unit.levels
    axis, encoder = f.axis_z, drive.encoder.diameter_mm / 2
    land = max(pulley.lower_land_radius, drive.input_radius_mm + s.flank_mm)
    name = pulley.name
    yield Zone(f"neck of the {name} pulley", v.front_y, v.land_bottom_z, axis - pulley.lower_neck_radius, land)
    yield Zone(f"{name} pulley", v.land_bottom_z, v.land_top_z, axis - land, land)
    yield Zone(f"encoder of {name}", v.top_plate_top_z, v.encoder_top_z, axis - encoder, encoder)


def _passes(s: RoundDrumLayout, sector: int, index: int, half_width: float) -> list[tuple[str, float, float, float]]:
    """(name, lowest y, highest y, outermost radius) of the parts of a sector that pass an input over the travel."""
    drive, d = s.drive, s.drum
    level, flank = drive.levels_mm[sector], s.flank_mm
    found = [
        (
            f"rim of {drive.input_names[sector]}",
            level + d.lands[0].y_start,
            level + d.lands[-1].y_end,
            drive.drum_radius_mm + flank,
        )
    ]
    nut = nut_corner_radius_mm(drive)
    between = (drive.angles_rad[index] - drive.angles_rad[sector]) % (2 * pi)
    for t in s.units[sector].drum.tensioners:
        # Angle from the sector's own line of centres to the other input, on the side of this terminal.
        away = between if t.side > 0 else 2 * pi - between
        margin = s.half_travel_rad + half_width / drive.centre_distance_mm
        if t.anchor_rad - margin < away < t.anchor_rad + atan2(t.last_tip, t.radius_mm) + margin:
            outer = hypot(t.radius_mm + nut, t.last_tip)
            found.append((f"terminal of {t.cable_name}", level + t.y_mm - nut, level + t.y_mm + nut, outer))
    return found


def _gaps(s: RoundDrumLayout, zones: Callable[[RoundDrumLayout, int], Iterator[Zone]]) -> Findings:
    """Gaps between each sector and zones at the other inputs."""
    for index in range(len(s.units)):
        for zone in zones(s, index):
            for sector in range(len(s.units)):
                if sector == index:
                    continue
                for name, low, high, outer in _passes(s, sector, index, zone.half_width_mm):
                    along = max(low - zone.to_y_mm, zone.from_y_mm - high)
                    gap = max(along, zone.inner_mm - outer)
                    yield f"{name} from {zone.name}", gap, s.drive.clearances.running_mm


@check("Sectors clear the other inputs", at.clearances.running_mm, *_OUT)
def sectors_clear_inputs(s: RoundDrumLayout) -> Findings:
    """Gap between each sector and the pulleys and encoders of the other inputs."""
    return _gaps(s, _on_axis)


@check(
    "Sectors clear the encoder shelves of the other inputs", at.clearances.running_mm, *up(at.drum.hub_face_y_mm), *_OUT
)
def sectors_clear_shelves(s: RoundDrumLayout) -> Findings:
    """Gap between each sector and the encoder shelves of the other inputs."""
    return _gaps(s, _shelf)


@check("Gap between motor heads", "derived", *_OUT)
def heads_apart(s: RoundDrumLayout) -> Findings:
    """Gaps between motor heads of neighbouring inputs, and between the mounting threads near the frame's middle."""
    f, half = s.frame, pi / len(s.units)
    flange_low = f.axis_z + s.head.flange.back_y
    # Two opposite heads have the drum's axis between them.
    heads = flange_low if half >= pi / 2 else flange_low * tan(half) - f.half_width
    yield "motor heads of neighbours, half the way between them", heads, 0.0
    if half < pi / 2:
        what, running = "idlers from those of the next arm, half the way between them", s.drive.clearances.running_mm
        for stand in f.stands:
            yield what, stand.low_z * tan(half) - stand.half_width, running / 2
    for x, z in f.mounts:
        room = hypot(x, z) if half >= pi / 2 else z * tan(half) - abs(x)
        yield "mounting thread from that of the next arm, half way", room - f.mount_radius, HOLE_WEB_MM / 2


SECTORS = (sectors_apart, sectors_clear_inputs, sectors_clear_shelves, heads_apart, *DOWELS)


# The checks of several inputs stand before or after those of one: the shares behind the winding, the sectors before
# the support, the room of all in place of the room of one.
_PLACES = {
    winding.FAMILIES[1]: (
        winding.FAMILIES[1],
        Family(
            "Shares of the inputs in the load of the drum, which follow from the stiffness of their cables.",
            (load_sharing,),
        ),
    ),
    frame.SUPPORT: (
        Family(
            "Sectors side by side on one shaft: apart from each other, past the inputs of the others, "
            "and pinned hub to hub.",
            SECTORS,
        ),
        frame.SUPPORT,
    ),
    frame.ROOM: (
        Family(
            "Gaps between turning and fixed parts, and the box of all inputs compared with its target.", (*GAPS, *BOX)
        ),
    ),
}
FAMILIES = tuple(family for one in OF_ONE_INPUT for family in _PLACES.get(one, (one,)))
