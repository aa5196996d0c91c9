"""The gearhead: ratio, torsional stiffness, lash, mesh error, drag and a loss that grows with the torque carried.

With the rotor's angle reflected to the output (phi = theta_motor / ratio) and the pulley at p, the shaft carries

    s = k dz(u),  u = phi + e sin(n ratio phi) - p,  dz(u) = u less half the lash, 0 within it

and the rotor feels s du/dphi, so that an error in the mesh is a torque ripple too (virtual work). The loss is Coulomb
friction at the rotor of capacity drag + (1/efficiency - 1) |s|: driven forward the output is efficiency x input; driven
backward the motor has to hold (2 - 1/efficiency) of the load; at an efficiency of 0.5 or less it is self-locking.
"""

from __future__ import annotations

from dataclasses import dataclass

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.storage.compiled import compiled


@dataclass(frozen=True)
class GearheadSpec:
    """One gearhead, seen at its output.

    ``stiffness_Nm_rad`` is an estimate: a 3 x 10 mm shaft has 64 N m/rad, and the gear train is assumed to be as soft.
    ``mesh_per_motor_turn`` counts periods of the mesh error ``mesh_error_rad`` (at the output) in a turn of the motor.
    """

    ratio: float
    efficiency: float = 1.0
    drag_Nm: float = 0.0
    stiffness_Nm_rad: float = 30.0
    lash_rad: float = 0.0
    mesh_error_rad: float = 0.0
    mesh_per_motor_turn: float = 1.0

    def __post_init__(self) -> None:
        if not 0.0 < self.efficiency <= 1.0:
            raise ValueError(f"efficiency is {self.efficiency}; give it above 0 and not above 1")
        for name in ("ratio", "stiffness_Nm_rad"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} is {getattr(self, name)}; give it > 0")
        for name in ("drag_Nm", "lash_rad"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"{name} is {getattr(self, name)}; give it >= 0")

    @property
    def loss_share(self) -> float:
        """Friction per torque carried, 1/efficiency - 1."""
        return 1.0 / self.efficiency - 1.0


def gearhead_of(drive: Drive, ideal: bool = False) -> GearheadSpec:
    """The design's gearhead; ``ideal`` makes it lossless, as in the paper's calculation of the driving capability."""
    return GearheadSpec(drive.gearhead.ratio, 1.0 if ideal else drive.gearhead.efficiency)


@compiled
def shaft_torque(twist_rad: float, lash_rad: float, stiffness_Nm_rad: float) -> tuple[float, float]:
    """Torque carried, N m, and its slope, N m/rad: a spring with a dead zone of ``lash_rad`` in all."""
    half = 0.5 * lash_rad
    if twist_rad > half:
        return stiffness_Nm_rad * (twist_rad - half), stiffness_Nm_rad
    if twist_rad < -half:
        return stiffness_Nm_rad * (twist_rad + half), stiffness_Nm_rad
    return 0.0, 0.0
