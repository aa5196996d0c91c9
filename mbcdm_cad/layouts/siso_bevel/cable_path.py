"""How the cables run (Fig. 1 c): input pulley, transfer point, drum. Routes of the model, and the drawn centre line.

Nothing stands between the two. Origin: the apex, where drum axis (Y) and input axis (Z) meet. The cable of step k
leaves the input in the plane z = r_ok, changes to the drum at (0, r_mk, r_ok) along q x, q the side of the drum to
which it runs, and lies on the drum in the plane y = r_mk. It is free of both pulleys only at this point: a rope under
tension T with bending stiffness EI leaves a pulley sqrt(EI/T) before the tangent point and touches the next one as far
beyond it (a beam under tension, its curvature decaying as e^(-s sqrt(T/EI))), so that a length 2 sqrt(EI/T) touches
neither.

A cable is drawn: chord through the input pulley (swaged stop) - inward bend - arc on the input - transfer - arc on the
drum - straight into its terminal. On the input it stays in the plane z = r_o of the transfer point; on a helix it would
leave this plane.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import acos, atan2, cos, degrees, hypot, pi, radians, sin, sqrt

import numpy as np

from mbcdm_cad.layouts.bevel_transfer import ON_DRUM, on_drum
from mbcdm_cad.layouts.siso_bevel.design_file import DirectDrive, DirectRun
from mbcdm_cad.parts.drum_sector.design import SectorRun
from mbcdm_cad.parts.input_pulley.dims import SLOT_PLAY_MM, STOP_PIECES, WEDGE_MM, StopGeometry, stop_pieces
from mbcdm_cad.parts.terminal import tensioned_rope
from mbcdm_cad.routes import Floats, route
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


STRETCH = "transfer_stretch_m"
DRUM = "drum"
_MM = 1e-3
_X, _Y, _DOWN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0)


@dataclass(frozen=True)
class DirectGeometry(route.AnchoredGeometry):
    """Cables that pass from the input directly to the drum; ``drum_side`` (n_cables,): side to which each runs."""

    cable_names: tuple[str, ...]
    input_names: tuple[str, ...]
    drum_side: tuple[int, ...]
    per_cable: tuple[str, ...] = (route.INPUT_RADIUS, route.DRUM_RADIUS)
    varied: tuple[route.Varied, ...] = (
        route.Varied(STRETCH, "stretch across the transfer", (0.8e-3, 1.2e-3, 1.6e-3, 2.4e-3, 4e-3), (1e-3, 2e-3)),
    )

    @property
    def input_of(self) -> tuple[int, ...]:
        """Index of the input of each cable; all run from the only input."""
        return (0,) * len(self.cable_names)

    def free_span_m(self, parameters: Mapping[str, Floats]) -> Floats:
        """The stretch across the transfer, the same for all cables; NaN unless it is over 0."""
        stretch = np.asarray(parameters[STRETCH])
        alone = np.where(stretch > 0.0, stretch, np.nan)
        return np.asarray(np.zeros_like(parameters[route.DRUM_RADIUS]) + alone)

    def fault(self, parameters: Mapping[str, Floats]) -> str:
        """Message for a stretch across the transfer without length."""
        return (
            f"stretch across the transfer of {np.min(parameters[STRETCH]):.3g} m (limit over 0): a cable that is never "
            "free has no stiffness of its own; give the rope a diameter"
        )

    def routes(self, parameters: Mapping[str, Floats]) -> route.DriveRoutes:
        """Bodies and cables of one design."""
        name = route.input_body(self.input_names[0])
        turns = float(np.mean(parameters[route.DRUM_RADIUS] / parameters[route.INPUT_RADIUS]))
        origin = (0.0, 0.0, 0.0)
        bodies = (
            route.Body(DRUM, "drum", origin, _Y, _X, 1.0),
            # About -Z it turns in the same sense as the drum.
            route.Body(name, "input", origin, _DOWN, _X, turns),
        )
        free = self.free_span_m(parameters)
        cables = []
        for j, side in enumerate(self.drum_side):
            r_m, r_o = float(parameters[route.INPUT_RADIUS][j]), float(parameters[route.DRUM_RADIUS][j])
            pieces = (
                route.Anchor(name),
                route.Wrap(name, r_m, np.inf, -r_o, side),
                route.Span(float(free[j]), (float(side), 0.0, 0.0)),
                route.Wrap(DRUM, r_o, np.inf, r_m, side),
                route.Terminal(DRUM),
            )
            cables.append(route.CableRoute(self.cable_names[j], self.input_names[0], self.sense[j], pieces))
        return route.DriveRoutes(bodies, tuple(cables))


def transfer_stretch_mm(drive: DirectDrive) -> float:
    """2 sqrt(EI/T) at the mean preload, wires free to slide; at least one diameter, for a braid that bends freely."""
    preload = sum(run.preload_N for run in drive.cables) / len(drive.cables)
    stiff = 2.0 * sqrt(tensioned_rope(drive).loose_N_m2 / preload) / _MM
    return max(stiff, drive.cable.diameter_mm)


def routed(drive: DirectDrive, unit: float = _MM) -> route.RoutedDrive:
    """Routes of the cables of ``drive``, and the lengths that follow from its file; ``unit``: a mm, in m."""
    geometry = DirectGeometry(
        cable_names=tuple(run.name for run in drive.cables),
        input_names=tuple(drive.input_names),
        drum_side=tuple(run.drum_side for run in drive.cables),
    )
    stretch = transfer_stretch_mm(drive)
    parameters = {
        route.INPUT_RADIUS: np.array([run.input_radius_mm * unit for run in drive.cables]),
        route.DRUM_RADIUS: np.array([run.drum_radius_mm * unit for run in drive.cables]),
        STRETCH: np.asarray(stretch * unit),
    }
    return route.RoutedDrive(geometry, parameters, {"transfer_stretch_mm": stretch})
