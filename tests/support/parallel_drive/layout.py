"""Dimensions, cable paths and inertias of the parallel drive: plain arithmetic, mm."""

from __future__ import annotations

from dataclasses import dataclass
from math import acos, degrees, pi, radians, sqrt

import numpy as np

from mbcdm_cad.design.drive import CableRun, Drive
from mbcdm_cad.routes.cable_path import CablePath, Stretch
from mbcdm_cad.routes.curves import Arc, Line, Triple
from parallel_drive.design_file import ParallelDrive

# Wrap left on the drum and on the input where a cable is unwound.
RESERVE_DEG = 20.0
STATIONS = 9


@dataclass(frozen=True)
class ParallelLayout:
    """Heights along Y from the base up, mm: the two cables run in the planes y = -plane and y = +plane."""

    drive: ParallelDrive
    plane: float
    half_width: float
    input_radius: float
    drum_radius: float
    base_top: float
    base_thickness: float

    def cable_paths(self, drum_angle_rad: float) -> tuple[CablePath, ...]:
        """Arc on the input, crossed span, arc on the drum."""
        return tuple(_path(self, run, drum_angle_rad) for run in self.drive.cables)


def height_mm(run: CableRun) -> float:
    """The plane in which a cable runs: one above, one below the middle."""
    return run.sigma * 1.5


def layout(drive: Drive) -> ParallelLayout:
    """Raises ValueError where the pulleys overlap."""
    assert isinstance(drive, ParallelDrive)
    run = drive.cables[0]
    if drive.centre_distance_mm <= run.input_radius_mm + run.drum_radius_mm:
        raise ValueError(f"centre distance {drive.centre_distance_mm} mm leaves no free span")
    flank = drive.cable.diameter_mm / 2
    return ParallelLayout(
        drive=drive,
        plane=1.5,
        half_width=3.0,
        input_radius=run.input_radius_mm - flank,
        drum_radius=run.drum_radius_mm - flank,
        base_top=-4.0,
        base_thickness=3.0,
    )


def wraps_rad(drive: Drive, run: CableRun, drum_angle_rad: float) -> tuple[float, float]:
    """(input, drum) wrap of a cable at a drum angle; a cable of sense sigma leaves the drum as it turns by +sigma."""
    half, reserve = radians(drive.half_travel_deg), radians(RESERVE_DEG)
    taken = half - run.sigma * drum_angle_rad
    return reserve + run.drum_radius_mm / run.input_radius_mm * (2 * half - taken), reserve + taken


def _path(lay: ParallelLayout, run: CableRun, drum_angle_rad: float) -> CablePath:
    drive, turning, y = lay.drive, -run.sigma, height_mm(run)
    r_i, r_o, distance = run.input_radius_mm, run.drum_radius_mm, drive.centre_distance_mm
    beta = acos((r_i + r_o) / distance)
    # Contact on the drum, an angle from +X towards -Z about +Y; on the input half a turn further.
    at_drum = turning * beta
    at_input = at_drum + pi
    on_input, on_drum = wraps_rad(drive, run, drum_angle_rad)
    x, z = (1.0, 0.0, 0.0), (0.0, 0.0, -1.0)
    wound = Arc((distance, y, 0.0), x, z, r_i, at_input + turning * on_input, at_input)
    drum = Arc((0.0, y, 0.0), x, z, r_o, at_drum, at_drum + turning * on_drum)
    span = Line(_end(wound, 1.0), _end(drum, 0.0))
    pieces = (("wound", wound), ("span", span), ("drum", drum))
    stretches = (Stretch(f"input_{run.input_name}", ("wound",)), Stretch(None, ("span",)), Stretch("drum", ("drum",)))
    return CablePath(run, drum_angle_rad, pieces, stretches)


def _end(arc: Arc, fraction: float) -> Triple:
    x, y, z = arc.points(np.array([fraction]))[0]
    return float(x), float(y), float(z)


@dataclass(frozen=True)
class Limit:
    """Where the travel ends in one direction."""

    angle_deg: float
    cause: str


@dataclass(frozen=True)
class CableFigures:
    """What the report asks for of every cable."""

    name: str
    length_mm: float
    length_um: tuple[float, ...]
    input_wrap_deg: tuple[float, ...]
    drum_wrap_deg: tuple[float, ...]


@dataclass(frozen=True)
class ParallelFigures:
    """Figures of the paths over the travel."""

    drum_angle_deg: tuple[float, ...]
    cables: tuple[CableFigures, ...]
    limits_positive: tuple[Limit, ...]
    limits_negative: tuple[Limit, ...]

    @property
    def usable_deg(self) -> tuple[float, float]:
        """The nearest limits."""
        return self.limits_negative[0].angle_deg, self.limits_positive[0].angle_deg


def path_figures(lay: ParallelLayout) -> ParallelFigures:
    """Lengths and wraps at nine angles."""
    drive = lay.drive
    half, stop = drive.half_travel_deg, drive.half_travel_deg + drive.stop_clearance_deg
    angles = tuple(float(a) for a in np.linspace(-half, half, STATIONS))
    cables = []
    for k, run in enumerate(drive.cables):
        centred = lay.cable_paths(0.0)[k].length_mm
        lengths = [lay.cable_paths(radians(a))[k].length_mm for a in angles]
        wraps = [wraps_rad(drive, run, radians(a)) for a in angles]
        cables.append(
            CableFigures(
                run.name,
                centred,
                tuple((length - centred) * 1e3 for length in lengths),
                tuple(degrees(w[0]) for w in wraps),
                tuple(degrees(w[1]) for w in wraps),
            )
        )
    beyond = half + RESERVE_DEG
    return ParallelFigures(
        angles,
        tuple(cables),
        (Limit(stop, "hard stop"), Limit(beyond, "wrap on the drum ends")),
        (Limit(-stop, "hard stop"), Limit(-beyond, "wrap on the drum ends")),
    )


def free_span_mm(drive: ParallelDrive, run: CableRun) -> float:
    """Internal tangent."""
    return sqrt(drive.centre_distance_mm**2 - (run.input_radius_mm + run.drum_radius_mm) ** 2)


def inertias_kg_m2(drive: Drive) -> dict[str, float]:
    """Two solid cylinders: pi/2 rho w R^4."""
    lay, density = layout(drive), drive.material("aluminium-7075").density_g_cm3 * 1e3
    width = 2 * lay.half_width * 1e-3
    run = drive.cables[0]
    return {
        name: pi / 2 * density * width * (radius * 1e-3) ** 4
        for name, radius in ((f"input_{run.input_name}", lay.input_radius), ("drum", lay.drum_radius))
    }
