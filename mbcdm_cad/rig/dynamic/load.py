"""The load of the dynamic rig: an inertia, a brake that can stick, a torque motor without a control loop."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class LoadSpec:
    """The load's constants, SI, about the drum's axis.

    A brake of level c holds c (1 + (static_ratio - 1) exp(-(speed/static_speed)^2)): with a ratio above 1 it can stick
    and slip. ``unbalance_Nm`` is the moment of the weight of an inertia plate,
    M = unbalance sin(angle + unbalance_angle). ``bearing_drag_Nm`` is friction that the torque sensor does not see.
    """

    inertia_kg_m2: float = 0.0
    static_ratio: float = 1.0
    static_speed_rad_s: float = 1e-3
    unbalance_Nm: float = 0.0
    unbalance_angle_rad: float = 0.0
    bearing_drag_Nm: float = 0.0
    bearing_viscous_Nms: float = 0.0

    def __post_init__(self) -> None:
        for name in ("inertia_kg_m2", "bearing_drag_Nm", "bearing_viscous_Nms"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"{name} is {getattr(self, name)}; give it >= 0")
        if not self.static_ratio >= 1.0:
            raise ValueError(f"static_ratio is {self.static_ratio}; give it >= 1")
        if not self.static_speed_rad_s > 0.0:
            raise ValueError(f"static_speed_rad_s is {self.static_speed_rad_s}; give it > 0")
