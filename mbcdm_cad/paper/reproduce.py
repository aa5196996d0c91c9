"""The paper's figures compared with those of the model for a design, each with a tolerance or marked unexplained.

``mbcdm reproduce`` fails if a figure is outside its tolerance. A figure without a tolerance is only shown, with the
reason: the model cannot give it, or the paper does not state what was measured.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from importlib.resources import files
from typing import TYPE_CHECKING, Any

import numpy as np
import yaml

from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.layouts.turns import implied_moduli_GPa, turns_of
from mbcdm_cad.model import capability, equations
from mbcdm_cad.model.analysis import lowest_each_way
from mbcdm_cad.model.equations import eq1_residuals
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.model.stiffness import DrumBacklash, drum_backlash, implied_modulus_Pa
from mbcdm_cad.report.table import TextReport, rendered

if TYPE_CHECKING:
    from mbcdm_cad.design.drive import Drive

WIRES_7X7, WIRES_ACROSS_7X7 = 49, 9
ENCODER_A_COUNTS = 2**15
ENCODER_B_LINES, ENCODER_B_SUBDIVISION = 18000, 256


@dataclass(frozen=True)
class PaperFigure:
    """One figure of the paper and of the model. ``tolerance`` is relative; None: shown, not judged."""

    name: str
    where: str
    unit: str
    paper: float
    computed: float
    tolerance: float | None
    remark: str

    @classmethod
    def of(cls, row: dict[str, Any], found: dict[str, float]) -> PaperFigure:
        """The figure of a row of ``figures.yaml``; ``found``: the model's figures by name."""
        paper = getattr(equations, row["paper"]) * float(row.get("factor", 1.0)) if row["paper"] else 0.0
        tolerance = None if row["tolerance"] is None else float(row["tolerance"])
        remark = row["remark"].format(**found)
        return cls(row["name"], row["where"], row["unit"], paper, found[row["computed"]], tolerance, remark)

    @property
    def difference(self) -> float:
        """(computed - paper)/paper, or computed if the paper's figure is zero."""
        return (self.computed - self.paper) / self.paper if self.paper else self.computed

    @property
    def within(self) -> bool:
        """Whether the figure is within its tolerance, or has none."""
        return self.tolerance is None or abs(self.difference) <= self.tolerance


@dataclass(frozen=True)
class PaperTable(TextReport):
    """The paper's figures and those of the model for the design ``name``."""

    name: str
    figures: tuple[PaperFigure, ...]

    @property
    def outside(self) -> tuple[PaperFigure, ...]:
        """Figures outside their tolerances."""
        return tuple(figure for figure in self.figures if not figure.within)

    def text(self) -> str:
        """What ``mbcdm reproduce`` prints: a page in Markdown. Same figures, same bytes."""
        return rendered("figures.md.j2", "mbcdm_cad.paper", figures=self.figures, name=self.name)

    def to_dict(self) -> list[dict[str, Any]]:
        """Plain data, one record a figure."""
        return [asdict(figure) | {"within": figure.within} for figure in self.figures]


def reproduce(drive: Drive) -> tuple[PaperFigure, ...]:
    """Every figure of the paper that the model can compute, for ``drive`` with the paper's equal preloads.

    ``figures.yaml`` beside this module has what is said of each, in the order of the page.
    """
    d = layout_of(drive).si
    d = d.with_(preload_N=np.full(d.n_cables, equations.BACKLASH_PRELOAD_N))
    found = {**_sizes(drive, d), **_torque(drive, d), **_backlash(drive, d)}
    rows = yaml.safe_load(files("mbcdm_cad.paper").joinpath("figures.yaml").read_text("utf-8"))
    return tuple(PaperFigure.of(row, found) for row in rows if row["computed"] in found)


def _sizes(drive: Drive, d: DriveSI) -> dict[str, float]:
    smallest = float(d.input_radius_m.min()) * 1e3
    wire = drive.cable.diameter_mm / WIRES_ACROSS_7X7
    motor_per_drum = float(d.total_ratio[0]) * drive.gearhead.ratio
    return {
        "radius_ratio": 2 * smallest / drive.cable.diameter_mm,
        "area_mm2": WIRES_7X7 * math.pi / 4 * wire**2,
        "residual": eq1_residuals(d).worst,
        "encoder_A_urad": 2 * math.pi / ENCODER_A_COUNTS * 1e6,
        "encoder_B_urad": 2 * math.pi / (ENCODER_B_LINES * ENCODER_B_SUBDIVISION) * 1e6,
        "motor_turns_per_rad": motor_per_drum / (2 * math.pi),
        "motor_turns": motor_per_drum,
    }


def _torque(drive: Drive, d: DriveSI) -> dict[str, float]:
    ratings = {capability.MOTOR: capability.input_ratings_Nm(drive)[capability.MOTOR]}
    strength = capability.tension_limit_N(drive)
    ideal = float(sum(ratings[capability.MOTOR] * d.total_ratio[d.input_of.index(i)] for i in range(d.n_inputs)))
    with_bias = min(lowest_each_way(capability.torque_limits(d, ratings, strength), capability.MOTOR))
    even = d.with_(preload_N=capability.balanced_preload_N(d))
    return {
        "ideal_Nm": ideal,
        "ideal_Nm_kg": capability.torque_to_weight_Nm_kg(ideal, equations.DESIGN_MASS_G),
        "with_bias_Nm": with_bias,
        "without_bias_Nm": min(lowest_each_way(capability.torque_limits(even, ratings, strength), capability.MOTOR)),
        "with_bias_Nm_kg": capability.torque_to_weight_Nm_kg(with_bias, equations.PROTOTYPE_MASS_G),
    }


def _with_structure(drive: Drive, drum: DrumBacklash) -> dict[str, float]:
    """Both readings of the backlash at the drum's encoder, with the parts drawn here; none where these are rigid."""
    at = turns_of(layout_of(drive)).drum_encoder
    if at is None:
        return {}
    turn = at.structure_urad_Nm * 1e-6 * equations.BACKLASH_TORQUE_NM
    needs = implied_moduli_GPa(layout_of(drive), equations.BACKLASH_PRELOAD_N)
    return {
        "swing_with_structure_mrad": (float(drum.reversal_swing_rad) + 2.0 * turn) * 1e3,
        "single_with_structure_mrad": (float(drum.first_loading_rad) + turn) * 1e3,
        "swing_needs_GPa": needs["reversal"],
        "single_needs_GPa": needs["single"],
    }


def _backlash(drive: Drive, d: DriveSI) -> dict[str, float]:
    theta, load = equations.BACKLASH_RAD, equations.BACKLASH_TORQUE_NM
    drum = drum_backlash(d, load)
    low, mid, high = (
        float(drum_backlash(d.with_(friction_coefficient=share * equations.FLAT_FRICTION), load).first_loading_rad)
        for share in (1 / 3, 1.0, 5 / 3)
    )
    return {
        "swing_mrad": float(drum.reversal_swing_rad) * 1e3,
        "single_mrad": float(drum.first_loading_rad) * 1e3,
        "modulus_GPa": float(d.modulus_Pa) / 1e9,
        "reversal_GPa": implied_modulus_Pa(d, theta, load, "reversal") / 1e9,
        "single_GPa": implied_modulus_Pa(d, theta, load, "single") / 1e9,
        **_with_structure(drive, drum),
        "difference": abs(float(drum.reversal_swing_rad) / theta - 1),
        "flattening": (mid - high) / (low - mid),
        "rmse": math.nan,
    }
