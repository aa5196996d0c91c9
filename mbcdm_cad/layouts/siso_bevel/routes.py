"""How the cables run: input pulley, transfer point, drum (Fig. 1 c). Nothing stands between the two.

Origin: the apex, where drum axis (Y) and input axis (Z) meet. The cable of step k leaves the input in the plane
z = r_ok, changes to the drum at (0, r_mk, r_ok) along q x, q the side of the drum to which it runs, and lies on the
drum in the plane y = r_mk. It is free of both pulleys only at this point: a rope under tension T with bending stiffness
EI leaves a pulley sqrt(EI/T) before the tangent point and touches the next one as far beyond it (a beam under tension,
its curvature decaying as e^(-s sqrt(T/EI))), so that a length 2 sqrt(EI/T) touches neither.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import sqrt

import numpy as np

from mbcdm_cad.layouts.siso_bevel.drive import DirectDrive
from mbcdm_cad.parts.terminal import tensioned_rope
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.geometry import DRUM_RADIUS, INPUT_RADIUS, AnchoredGeometry, RoutedDrive, Varied
from mbcdm_cad.routes.route import Anchor, Body, CableRoute, DriveRoutes, Span, Terminal, Wrap, input_body

STRETCH = "transfer_stretch_m"
DRUM = "drum"
_MM = 1e-3
_X, _Y, _DOWN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0)


@dataclass(frozen=True)
class DirectGeometry(AnchoredGeometry):
    """Cables that pass from the input directly to the drum; ``drum_side`` (n_cables,): side to which each runs."""

    cable_names: tuple[str, ...]
    input_names: tuple[str, ...]
    drum_side: tuple[int, ...]
    per_cable: tuple[str, ...] = (INPUT_RADIUS, DRUM_RADIUS)
    varied: tuple[Varied, ...] = (
        Varied(STRETCH, "stretch across the transfer", (0.8e-3, 1.2e-3, 1.6e-3, 2.4e-3, 4e-3), (1e-3, 2e-3)),
    )

    @property
    def input_of(self) -> tuple[int, ...]:
        """Index of the input of each cable; all run from the only input."""
        return (0,) * len(self.cable_names)

    def free_span_m(self, parameters: Mapping[str, Floats]) -> Floats:
        """The stretch across the transfer, the same for all cables; NaN unless it is over 0."""
        stretch = np.asarray(parameters[STRETCH])
        alone = np.where(stretch > 0.0, stretch, np.nan)
        return np.asarray(np.zeros_like(parameters[DRUM_RADIUS]) + alone)

    def fault(self, parameters: Mapping[str, Floats]) -> str:
        """Message for a stretch across the transfer without length."""
        return (
            f"stretch across the transfer of {np.min(parameters[STRETCH]):.3g} m (limit over 0): a cable that is never "
            "free has no stiffness of its own; give the rope a diameter"
        )

    def routes(self, parameters: Mapping[str, Floats]) -> DriveRoutes:
        """Bodies and cables of one design."""
        name = input_body(self.input_names[0])
        turns = float(np.mean(parameters[DRUM_RADIUS] / parameters[INPUT_RADIUS]))
        origin = (0.0, 0.0, 0.0)
        bodies = (
            Body(DRUM, "drum", origin, _Y, _X, 1.0),
            # About -Z it turns in the same sense as the drum.
            Body(name, "input", origin, _DOWN, _X, turns),
        )
        free = self.free_span_m(parameters)
        cables = []
        for j, side in enumerate(self.drum_side):
            r_m, r_o = float(parameters[INPUT_RADIUS][j]), float(parameters[DRUM_RADIUS][j])
            pieces = (
                Anchor(name),
                Wrap(name, r_m, np.inf, -r_o, side),
                Span(float(free[j]), (float(side), 0.0, 0.0)),
                Wrap(DRUM, r_o, np.inf, r_m, side),
                Terminal(DRUM),
            )
            cables.append(CableRoute(self.cable_names[j], self.input_names[0], self.sense[j], pieces))
        return DriveRoutes(bodies, tuple(cables))


def transfer_stretch_mm(drive: DirectDrive) -> float:
    """2 sqrt(EI/T) at the mean preload, wires free to slide; at least one diameter, for a braid that bends freely."""
    preload = sum(run.preload_N for run in drive.cables) / len(drive.cables)
    stiff = 2.0 * sqrt(tensioned_rope(drive).loose_N_m2 / preload) / _MM
    return max(stiff, drive.cable.diameter_mm)


def routed(drive: DirectDrive, unit: float = _MM) -> RoutedDrive:
    """Routes of the cables of ``drive``, and the lengths that follow from its file; ``unit``: a mm, in m."""
    geometry = DirectGeometry(
        cable_names=tuple(run.name for run in drive.cables),
        input_names=tuple(drive.input_names),
        drum_side=tuple(run.drum_side for run in drive.cables),
    )
    stretch = transfer_stretch_mm(drive)
    parameters = {
        INPUT_RADIUS: np.array([run.input_radius_mm * unit for run in drive.cables]),
        DRUM_RADIUS: np.array([run.drum_radius_mm * unit for run in drive.cables]),
        STRETCH: np.asarray(stretch * unit),
    }
    return RoutedDrive(geometry, parameters, {"transfer_stretch_mm": stretch})
