"""Angles of the rigid transmission, Eq. (1) and (2), and what it costs when the radii do not satisfy Eq. (1).

Signs as in the project's frame: anticlockwise positive about +Y (drum) and +Z (guide, inputs). With every transfer
point on the y > 0 side, theta_g = -(r_o/r_g) theta_o and theta_i = +(r_o/r_i) theta_o.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mbcdm_cad.model.errors import ModelError
from mbcdm_cad.model.si import DriveSI, Floats

SHAFTS = ("drum", "guide", "input", "motor")


@dataclass(frozen=True, eq=False)
class ShaftAngles:
    """Angles in rad of drum, guide, input pulley and motor for one cable's chain; any common shape."""

    drum_rad: Floats
    guide_rad: Floats
    input_rad: Floats
    motor_rad: Floats


def shaft_angles(d: DriveSI, shaft: str, angle_rad: Any, cable: int = 0, gear_ratio: float = 1.0) -> ShaftAngles:
    """Every angle from any one of them, along the chain of one cable.

    ``shaft`` is one of ``SHAFTS``; the gearhead is taken to keep the sense of rotation. Where Eq. (1) holds the answer
    does not depend on ``cable``. Errors: ``ModelError`` for an unknown shaft.
    """
    to_drum = {
        "drum": 1.0,
        "guide": -d.guide_radius_m[cable] / d.drum_radius_m[cable],
        "input": d.input_radius_m[cable] / d.drum_radius_m[cable],
        "motor": d.input_radius_m[cable] / d.drum_radius_m[cable] / gear_ratio,
    }
    if shaft not in to_drum:
        raise ModelError(f"shaft {shaft!r} is unknown; use one of {', '.join(SHAFTS)}")
    drum = np.asarray(angle_rad, dtype=float) * to_drum[shaft]
    return ShaftAngles(drum, drum / to_drum["guide"], drum / to_drum["input"], drum / to_drum["motor"])


def transmission_error(theta_o_rad: Any, theta_i_rad: Any, total_ratio: Any) -> Floats:
    """Eq. (2): theta_e = theta_o - theta_i / i_c, in rad."""
    return np.asarray(np.asarray(theta_o_rad) - np.asarray(theta_i_rad) / np.asarray(total_ratio))


@dataclass(frozen=True, eq=False)
class RatioResiduals:
    """Relative deviation from Eq. (1): each entry is r/r' over the first such ratio, minus 1.

    ``guide_to_drum`` (n_cables, *batch) compares r_g/r_o with that of the first cable; ``input_to_guide`` compares
    r_i/r_g with that of the first cable of the same input; ``between_inputs`` (n_inputs, *batch) compares the mean
    total ratio r_i/r_o of an input with that of the first input (two inputs at one drum must agree).
    """

    guide_to_drum: Floats
    input_to_guide: Floats
    between_inputs: Floats

    @property
    def worst(self) -> float:
        """Largest magnitude of all residuals."""
        return float(max(np.max(np.abs(a)) for a in (self.guide_to_drum, self.input_to_guide, self.between_inputs)))


def eq1_residuals(d: DriveSI) -> RatioResiduals:
    """Residuals of Eq. (1), with its third row corrected: i_mr = r_mr1/r_g3 = r_mr2/r_g4 (printed: r_g1, r_g2)."""
    first = [d.input_of.index(i) for i in d.input_of]
    guide = d.guide_radius_m / d.drum_radius_m
    inner = d.input_radius_m / d.guide_radius_m
    total = d.input_radius_m / d.drum_radius_m
    per_input = np.stack([
        total[[j for j, k in enumerate(d.input_of) if k == i]].mean(axis=0) for i in range(d.n_inputs)
    ])  # fmt: skip
    return RatioResiduals(guide / guide[0] - 1.0, inner / inner[first] - 1.0, per_input / per_input[0] - 1.0)


def guide_wraps_rad(d: DriveSI) -> Floats:
    """Wrap of each cable on the guide, n_cables rows: beta = asin((r_g + r_i)/L), half a turn more the long way round.

    A cable that runs on the drum towards its own input's side has to go the long way.
    """
    reach = (d.guide_radius_m + d.input_radius_m) / d.centre_distance_m
    side = np.array([d.input_side[i] for i in d.input_of], dtype=float)
    return np.asarray(np.arcsin(reach) + d.column(np.where(side * -d.sigma > 0.0, np.pi, 0.0), reach.ndim))


def with_guide_slip(d: DriveSI) -> DriveSI:
    """The drive with slip on the guide's wraps: a zone creeps in from both ends of each, and they share the wrap."""
    return d.with_(guide_wrap_rad=guide_wraps_rad(d))


def pair_mismatch_m(d: DriveSI, input_angle_rad: Any) -> Floats:
    """Length by which the second cable of each input disagrees with the first, in m, shape (n_inputs, ...).

    With the drum where cable 1 of the input wants it, cable 2 is too long or too short by
    theta_i (r_i2 - r_o2 r_i1/r_o1). Zero where Eq. (1) holds.
    """
    theta = np.asarray(input_angle_rad, dtype=float)
    rows = []
    for i in range(d.n_inputs):
        one, *rest = [j for j, k in enumerate(d.input_of) if k == i]
        two = rest[0] if rest else one
        drum_per_input = d.input_radius_m[one] / d.drum_radius_m[one]
        rows.append(theta * (d.input_radius_m[two] - d.drum_radius_m[two] * drum_per_input))
    return np.stack(rows)
