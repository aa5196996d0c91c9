"""A cable as the bench knows it: what is really built, in SI, which may differ from the design file."""

from __future__ import annotations

from dataclasses import dataclass

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.rig.geometry import CablePath, cable_path


@dataclass(frozen=True)
class RigCable:
    """One cable, SI. ``sigma`` is the sense in which its tension turns the drum, ``input_index`` the input it is on."""

    name: str
    sigma: int
    input_index: int
    input_radius_m: float
    guide_radius_m: float
    drum_radius_m: float
    stiffness_N: float  # E A
    preload_N: float
    friction: float
    path: CablePath


def cables_of(drive: Drive) -> tuple[RigCable, ...]:
    """The cables as the design file has them. A drive without a guide (r_g = 0) has none to wrap."""
    return tuple(
        RigCable(
            name=c.name,
            sigma=c.sigma,
            input_index=drive.input_names.index(c.input_name),
            input_radius_m=c.input_radius_mm * 1e-3,
            guide_radius_m=c.guide_radius_mm * 1e-3,
            drum_radius_m=c.drum_radius_mm * 1e-3,
            stiffness_N=drive.cable.axial_stiffness_N,
            preload_N=c.preload_N,
            friction=drive.friction_coefficient,
            path=cable_path(drive, c),
        )
        for c in drive.cables
    )
