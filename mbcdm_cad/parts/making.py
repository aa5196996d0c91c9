"""Tolerances of the parts of a drive: bands of sizes from the fits and from the design's block ``making``."""

from __future__ import annotations

from math import sqrt

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.model.tolerance import Tolerances
from mbcdm_cad.parts.fits import radius_band_mm

# Axial over radial play of a deep-groove bearing (bearing makers: 8 to 15, the closer the osculation the less).
AXIAL_OVER_RADIAL = 10.0
# Error of a preload set by hand, over the preload (estimate).
PRELOAD_SHARE = 0.05


def rope_band_mm(drive: Drive) -> float:
    """Plus or minus on the rope's diameter."""
    return drive.making.rope_diameter_share * drive.cable.diameter_mm


def land_band_mm(drive: Drive, pitch_radius_mm: float) -> float:
    """Plus or minus on the radius of the surface that carries a cable at ``pitch_radius_mm``."""
    return radius_band_mm(pitch_radius_mm - drive.cable.diameter_mm / 2, "land")


def axial_play_mm(drive: Drive) -> float:
    """Axial play of a bearing that carries no preload, from one side to the other."""
    return AXIAL_OVER_RADIAL * drive.making.bearing_play_mm


def model_tolerances(drive: Drive) -> Tolerances:
    """Standard deviations for the transmission error, of parts that lie anywhere within their tolerances.

    A point anywhere in a disc of radius e has e/2 in each component, a size anywhere in +-t has t/sqrt(3).
    """
    eccentricity = drive.making.run_out_mm / 4.0 * 1e-3
    bands = [
        max(land_band_mm(drive, radius) for radius in radii)
        for radii in ([c.drum_radius_mm for c in drive.cables], [c.input_radius_mm for c in drive.cables])
    ]
    drum, pulley = (band / sqrt(3.0) * 1e-3 for band in bands)
    preload = PRELOAD_SHARE * sum(c.preload_N for c in drive.cables) / len(drive.cables)
    return Tolerances(
        drum_eccentricity_m=eccentricity,
        passed_eccentricity_m=eccentricity,
        input_eccentricity_m=eccentricity,
        drum_radius_m=drum,
        input_radius_m=pulley,
        preload_N=preload,
    )
