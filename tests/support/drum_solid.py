"""A drum sector by solid finite elements: its turn under its cables, and the stress in its web."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mbcdm_cad.design.bought import Material
from mbcdm_cad.parts.drum_sector.dims import DrumDims
from tests.support.solid_fe import Pull, Solid, drum_load, tetrahedra

# Longest tetrahedra, over the drum's radius.
SIZE = 1.0 / 24.0


@dataclass(frozen=True)
class DrumBySolids:
    """Turn of the cables against the payload in urad per N m with the bore free to turn on the shaft, and with the bore
    held there; greatest von Mises stress of the web in MPa per N m, and the one that 0.1 % of its volume exceeds."""

    turn_urad_Nm: float
    bore_held_urad_Nm: float
    peak_MPa_Nm: float
    high_MPa_Nm: float


def pulls(d: DrumDims, share: dict[str, float]) -> list[Pull]:
    """The cables on their lands."""
    found = []
    for t in d.tensioners:
        land = min(d.lands, key=lambda k, t=t: (abs(k.surface_radius_mm - t.radius_mm), abs(k.y_start - t.y_mm)))
        # Lands of one radius side by side are one face, whose facets may reach across both.
        face = [k for k in d.lands if abs(k.surface_radius_mm - land.surface_radius_mm) < 1e-6]
        ends = (min(k.y_start for k in face), max(k.y_end for k in face))
        found.append(Pull(t.side, land.surface_radius_mm, ends, t.y_mm, t.anchor_rad, share[t.cable_name]))
    return found


def drum_by_solids(
    d: DrumDims, material: Material, set_screw_thread_mm: float, share: dict[str, float], folder: Path
) -> DrumBySolids:
    """Draw the drum, write it as STEP, mesh that and solve."""
    from mbcdm_cad.parts.drum_sector.part import DrumSector

    step = folder / "drum.step"
    DrumSector(d, set_screw_thread_mm).solid().exportStep(str(step))
    solid = Solid(
        tetrahedra(step, SIZE * d.lands[-1].surface_radius_mm),
        material.youngs_modulus_GPa * 1e3,
        material.poisson_ratio,
    )
    load = drum_load(solid, pulls(d, share))
    radius = np.hypot(solid.place[0], solid.place[2])
    face = np.flatnonzero((np.abs(solid.place[1] - d.hub_face_y) < 1e-3) & (radius < d.hub_radius + 1e-3))
    bore = np.flatnonzero(np.abs(radius - d.bore_radius) < 0.02)
    free = solid.moved(load, face, solid.guided(bore))
    held = solid.moved(load, np.union1d(face, bore[solid.direction[bore] != 1]))
    stress, place = solid.von_mises_MPa(free)
    r = np.hypot(place[0], place[2])
    web = (r > d.hub_radius + 0.5) & (r < d.lands[-1].surface_radius_mm)
    inside = np.sort(stress[web])
    return DrumBySolids(
        float(load @ free) * 1e3, float(load @ held) * 1e3, float(inside[-1]), float(inside[int(0.999 * len(inside))])
    )
