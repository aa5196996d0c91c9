"""Centre line of each cable at a given drum angle, and its end in the input pulley.

A cable runs: chord through the input pulley (swaged stop) - inward bend - arc on the input - transfer - arc on the drum
- straight into its terminal. On the input it stays in the plane z = r_o of the transfer point; on a helix it would
leave this plane.
"""

from math import acos, atan2, cos, degrees, hypot, pi, radians, sin

import numpy as np

from mbcdm_cad.layouts.bevel_transfer import ON_DRUM, on_drum
from mbcdm_cad.layouts.siso_bevel.drive import DirectDrive, DirectRun
from mbcdm_cad.parts.drum_sector.design import SectorRun
from mbcdm_cad.parts.input_pulley.dims import SLOT_PLAY_MM, STOP_PIECES, WEDGE_MM, StopGeometry, stop_pieces
from mbcdm_cad.routes.curves import Arc, CablePath, Piece, Stretch

# The bend before the stop, D/d: the sharpest usual static bend, so that the slot uses a small angle of the turn.
STOP_BEND_RATIO = 8.0
# Straight cable before the swaged stop on its end.
STOP_LEAD_MM = 0.3
# Gap between the cable that leaves a full pulley and its own end that enters the slot (estimate).
DIP_GAP_MM = 0.1
# Angle about Z of the point of the input at which all cables change to the drum.
TRANSFER_RAD = pi / 2


def stop_of(drive: DirectDrive, cable: DirectRun) -> StopGeometry:
    """The cable's end in the input pulley, in the plane of its step; the chord counts from the pulley's middle plane.

    Raises ValueError if the pulley is too small for the bend.
    """
    d, r = drive.cable.diameter_mm, cable.input_radius_mm
    rho = STOP_BEND_RATIO * d / 2
    start = r - rho - STOP_LEAD_MM
    end = start - drive.termination.stop_length_ratio * d
    if end <= 0.0:
        raise ValueError(
            f"input radius {r:g} mm of {cable.name} leaves no room for the bend of {rho:.4g} mm and the stop behind it"
        )
    wound_to, stop = TRANSFER_RAD + cable.drum_side * input_wrap_rad(drive, cable, 0.0), drive.termination
    return StopGeometry(wound_to, cable.drum_side, rho, rho, 0.0, stop.stop_radius_ratio * d, start, end)


def taken_rad(drive: DirectDrive, cable: DirectRun) -> float:
    """Angle by which a cable's winding must end before a whole turn.

    The cable that leaves there then clears the end, and still lies on land. Raises as :func:`stop_of` does.
    """
    d, r, rho = drive.cable.diameter_mm, cable.input_radius_mm, stop_of(drive, cable).bend_radius_mm
    # The cable that leaves a full pulley is straight after the transfer. The end of the winding, this angle before a
    # full turn, comes near to that line where it bends inward; the least distance is (r - rho)(1 - cos angle)
    # (derived).
    centre = r - rho
    passing = acos(max(-1.0, 1.0 - (d + DIP_GAP_MM) / centre))
    outer = rho + (d + SLOT_PLAY_MM) / 2
    cosine = ((r - d / 2 - WEDGE_MM) ** 2 - centre**2 - outer**2) / (2 * centre * outer)
    turned = acos(min(1.0, max(-1.0, cosine)))
    return max(passing, atan2(outer * sin(turned), centre + outer * cos(turned)))


def input_wrap_rad(drive: DirectDrive, cable: SectorRun, drum_angle_rad: float) -> float:
    """Wrap on the input: reserve + i (half travel - q theta); a cable that runs to +x leaves it as the drum turns."""
    half = radians(drive.half_travel_deg)
    ratio = cable.drum_radius_mm / cable.input_radius_mm
    return radians(drive.reserve_deg) + ratio * (half - cable.drum_side * drum_angle_rad)


def full_input_turn_deg(drive: DirectDrive, cable: DirectRun) -> float:
    """i x full travel + reserve + angle of the stop's slot, deg: together they must fit on one turn of the input."""
    wound = input_wrap_rad(drive, cable, -cable.drum_side * radians(drive.half_travel_deg))
    return degrees(wound) + degrees(taken_rad(drive, cable))


# The stretches of a cable by the body that carries them.
WOUND = (*STOP_PIECES, "wound")


def cable_path(
    drive: DirectDrive, cable: DirectRun, anchor_rad: float, tail_mm: float, drum_angle_rad: float
) -> CablePath:
    """Centre line at ``drum_angle_rad``.

    ``anchor_rad``: angle on the drum, from +Z towards the cable's side, where the cable leaves its land with the drum
    centred; ``tail_mm``: straight length from there into the terminal.
    """
    side, r_m, r_o = cable.drum_side, cable.input_radius_mm, cable.drum_radius_mm
    end = TRANSFER_RAD + side * input_wrap_rad(drive, cable, drum_angle_rad)
    radial = np.array([cos(end), sin(end), 0.0])
    onward = side * np.array([-sin(end), cos(end), 0.0])
    inside = stop_pieces(r_m * radial + np.array([0.0, 0.0, r_o]), radial, onward, r_m, stop_of(drive, cable))
    pieces: tuple[tuple[str, Piece], ...] = (
        *zip(STOP_PIECES, inside, strict=True),
        ("wound", Arc((0.0, 0.0, r_o), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), r_m, end, TRANSFER_RAD)),
        *on_drum(cable, anchor_rad + side * drum_angle_rad, tail_mm),
    )
    stretches = (Stretch(f"input_{cable.input_name}", WOUND), Stretch("drum", ON_DRUM))
    return CablePath(cable, drum_angle_rad, pieces, stretches)


def longest_mm(drive: DirectDrive, cable: DirectRun, anchor_rad: float) -> float:
    """Length of a cable that leaves its land at ``anchor_rad``, by its pieces; slightly more than the drawn path."""
    ends = pi / 2 * stop_of(drive, cable).bend_radius_mm + hypot(STOP_LEAD_MM, 6.0 * drive.cable.diameter_mm)
    wound = cable.input_radius_mm * input_wrap_rad(drive, cable, 0.0)
    return wound + cable.drum_radius_mm * anchor_rad + ends
