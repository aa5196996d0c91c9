"""The figures that `analyse` returns: frozen, plain numbers only, ready for JSON.

Units are in the names. Angles of backlash are in mrad, torques on inputs in mN m, as a designer reads them.
"""

import math
from dataclasses import asdict, dataclass
from typing import Any

from mbcdm_cad.model.capability import MotorFigures, TorqueLimit
from mbcdm_cad.model.creep import PreloadLeft
from mbcdm_cad.storage.cache import with_floats

# Readable unit and factor of an SI figure, by the end of its name.
_READABLE = {"_rad": ("mrad", 1e3), "_Nm": ("N m", 1.0), "_N": ("N", 1.0), "_m": ("mm", 1e3)}


def readable_figure(name: str) -> tuple[str, str, float]:
    """(name without unit, unit, factor): for ``reversal_swing_rad`` these are ``reversal_swing``, mrad, 1000."""
    for suffix, (unit, factor) in _READABLE.items():
        if name.endswith(suffix):
            return name.removesuffix(suffix), unit, factor
    return name, "-", 1.0


@dataclass(frozen=True)
class CableFigures:
    """One cable at the test torque. ``*_simplified`` are the paper's (16) to (20), the others use Eq. (14) exactly."""

    name: str
    input_name: str
    sigma: int
    total_ratio: float
    free_span_mm: float
    preload_N: float
    kappa: float
    high_tension_N: float
    low_tension_N: float
    high_tension_simplified_N: float
    low_tension_simplified_N: float
    backlash_mrad: float
    backlash_simplified_mrad: float


@dataclass(frozen=True)
class LoadCase:
    """All cables at once, inputs locked, first loading to ``load_Nm`` (> 0 opposes positive rotation).

    ``turn_mrad`` is the drum's turn from no load; ``slip_angle_deg`` that of the free span's tension on each wrap;
    tuples follow the drive's cables and inputs.
    """

    load_Nm: float
    turn_mrad: float
    tension_N: tuple[float, ...]
    slip_angle_deg: tuple[float, ...]
    slack: tuple[bool, ...]
    input_torque_mNm: tuple[float, ...]
    load_share: tuple[float, ...]
    tangent_stiffness_Nm_rad: float
    secant_stiffness_Nm_rad: float


@dataclass(frozen=True)
class PassedLoad:
    """Radial load (N) and moment (N m) about the middle of its steps on a body that the cables pass."""

    body: str
    radial_N: float
    moment_Nm: float


@dataclass(frozen=True)
class BearingFigures:
    """Radial loads (N) at one load; those of passed bodies with their moments; the drum's is the pull across its axis.

    In JSON a passed body's figures are ``NAME_radial_N`` and ``NAME_moment_Nm``.
    """

    load_Nm: float
    input_radial_N: tuple[float, ...]
    passed: tuple[PassedLoad, ...]
    drum_radial_N: float


@dataclass(frozen=True)
class ModulusReading:
    """E that the paper's measured backlash implies under one reading of it and one route of the model."""

    reading: str
    route: str
    modulus_GPa: float


@dataclass(frozen=True)
class ShaftTurns:
    """How far each shaft of one cable's chain turns, in degrees with its sense: drum, passed bodies, input, motor.

    In JSON each is ``NAME_deg``.
    """

    cable_name: str
    turned_deg: dict[str, float]


@dataclass(frozen=True)
class UncertainFigure:
    """A figure with its 95 % interval, from the sigmas that the design file gives."""

    name: str
    unit: str
    value: float
    low: float
    high: float
    sigma: float


@dataclass(frozen=True)
class Analysis:
    """All figures of the model for one design, for the report and for ``mbcdm analyse``.

    ``peak_torque_lossless_Nm`` and ``peak_torque_with_losses_Nm`` are (for +, for -): the lowest limit in each
    direction without losses, as in the paper, and with all of them; ``peak_torque_Nm`` is that which
    ``limits.losses`` puts in force (``losses_counted``). ``balanced_*`` repeat it with preloads T ~ 1/r. ``lengths``
    are those of the whole design by their names in its file. ``intervals`` is empty where no value of the design file
    carries a sigma.
    """

    name: str
    friction_coefficient: float
    modulus_GPa: float
    modulus_area: str
    area_mm2: float
    axial_stiffness_kN: float
    lengths: dict[str, float]
    shaft_turns: tuple[ShaftTurns, ...]
    eq1_worst_residual: float
    pair_mismatch_mm: tuple[float, ...]
    pair_mismatch_N: float
    cables: tuple[CableFigures, ...]
    test: tuple[LoadCase, LoadCase]
    peak: tuple[LoadCase, LoadCase]
    reversal_swing_mrad: float
    sticking_stiffness_Nm_rad: float
    input_bias_mNm: tuple[float, ...]
    limits: tuple[TorqueLimit, ...]
    losses_counted: bool
    peak_torque_Nm: tuple[float, float]
    peak_torque_lossless_Nm: tuple[float, float]
    peak_torque_with_losses_Nm: tuple[float, float]
    balanced_preload_N: tuple[float, ...]
    balanced_peak_torque_Nm: tuple[float, float]
    torque_to_weight_Nm_kg: float | None  # at the mass that the design requires; None if it requires none
    bearings: tuple[BearingFigures, ...]
    creep: tuple[PreloadLeft, ...]  # preload left over time by temperature; empty for a rope that does not creep
    motor: MotorFigures | None  # None where the catalogue has no electrical values of it
    measured_backlash_mrad: float
    implied_modulus: tuple[ModulusReading, ...]
    intervals: tuple[UncertainFigure, ...]
    notes: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """Nested dicts and lists for JSON; infinite figures (no such limit) become None."""
        found: dict[str, Any] = {}
        for name, value in asdict(self).items():
            found |= value if name == "lengths" else {name: value}
        for turns in found["shaft_turns"]:
            turns |= {f"{shaft}_deg": angle for shaft, angle in turns.pop("turned_deg").items()}
        for bearing in found["bearings"]:
            # Figures of passed bodies under names of their own, before the drum's.
            drum = bearing.pop("drum_radial_N")
            for passed in bearing.pop("passed"):
                body = passed["body"]
                bearing |= {f"{body}_radial_N": passed["radial_N"], f"{body}_moment_Nm": passed["moment_Nm"]}
            bearing["drum_radial_N"] = drum
        plain = with_floats(found, lambda number: number if math.isfinite(number) else None)
        assert isinstance(plain, dict)
        return plain
