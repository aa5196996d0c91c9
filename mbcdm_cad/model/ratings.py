"""Ratings and requirements of a design in SI: torque ratings of an input, test load, travel, rope."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mbcdm_cad.model.bulk import Requirements
from mbcdm_cad.model.si import GPA, MM, MM2, routed

if TYPE_CHECKING:
    from mbcdm_cad.design.drive import Drive

# Names of the ratings in `Analysis.limits`.
MOTOR, MOTOR_LOSSY, GEARHEAD, GEARHEAD_PEAK = "motor", "motor_with_efficiency", "gearhead_rated", "gearhead_maximum"
MOTOR_ALONE, MOTOR_ALONE_PEAK = "motor_alone", "motor_alone_peak"


def input_ratings_Nm(drive: Drive) -> dict[str, float]:
    """Torque limits of one input, N m: motor through the gearhead, without and with losses; the gearhead's own.

    Without a gearhead: the motor's continuous torque, and that at its peak current.
    """
    if drive.gearhead.absent:
        return {
            MOTOR_ALONE: drive.motor.rated_torque_mNm * 1e-3,
            MOTOR_ALONE_PEAK: drive.motor.peak_torque_mNm * 1e-3,
        }
    lossless = drive.motor.rated_torque_mNm * 1e-3 * drive.gearhead.ratio
    return {
        MOTOR: lossless,
        MOTOR_LOSSY: lossless * drive.gearhead.efficiency,
        GEARHEAD: drive.gearhead.rated_torque_mNm * 1e-3,
        GEARHEAD_PEAK: drive.gearhead.max_torque_mNm * 1e-3,
    }


def motor_ratings(drive: Drive) -> tuple[str, str]:
    """Names of the motor's own rating, with a lossless gearhead and with its losses; the same without a gearhead."""
    return (MOTOR_ALONE, MOTOR_ALONE) if drive.gearhead.absent else (MOTOR, MOTOR_LOSSY)


def tension_limit_N(drive: Drive) -> float:
    """Largest tension allowed: breaking load over the safety factor."""
    return drive.cable.breaking_load_N / drive.limits.tension_safety_factor


def requirements(drive: Drive) -> Requirements:
    """Requirements of the design in SI: test torque, travel, lossless rating of an input, rope."""
    return Requirements(
        load_Nm=drive.loads.test_torque_Nm,
        half_travel_rad=np.radians(drive.half_travel_deg),
        input_rating_Nm=input_ratings_Nm(drive)[motor_ratings(drive)[0]],
        rope_diameter_m=drive.cable.diameter_mm * MM,
        tension_limit_N=tension_limit_N(drive),
        helix_lead_m=drive.helix_lead_mm * MM,
    )


def sigmas_si(drive: Drive) -> dict[str, Any]:
    """Standard deviations that the design file gives, in SI, named as :mod:`mbcdm_cad.model.uncertainty` wants them.

    Those that are 0 throughout are left out: an empty dict means that no value of the file carries a sigma.
    """
    s = drive.sigmas
    given: dict[str, Any] = {"preload_N": np.array(s.preload_N)}
    geometry = routed(drive).geometry
    for name in (*geometry.per_cable, *(v.name for v in geometry.varied)):
        # A length without a sigma in the design file counts as exact.
        given[name] = np.array(getattr(s, name.removesuffix("_m") + "_mm", 0.0)) * MM
    given |= {
        "friction_coefficient": s.friction_coefficient,
        "modulus_Pa": s.modulus_GPa * GPA,
        "area_m2": s.area_mm2 * MM2,
        "load_Nm": s.test_torque_Nm,
        "input_rating_Nm": s.motor_torque_mNm * 1e-3 * drive.gearhead.ratio,
    }
    return {name: size for name, size in given.items() if np.any(np.asarray(size))}
