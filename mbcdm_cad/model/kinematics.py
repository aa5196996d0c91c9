"""Angles of the rigid transmission, Eq. (1) and (2), and the mismatch of radii that do not satisfy Eq. (1).

Signs as in :mod:`mbcdm_cad.routes.route`: right-handed about each body's axis; an input's axis points so that
theta_i = +(r_o/r_i) theta_o; a body that the cable passes turns by +-(r_o/r) theta_o, depending on the route.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.routes import Floats


def shaft_angles(d: DriveSI, shaft: str, angle_rad: Any, cable: int = 0, gear_ratio: float = 1.0) -> dict[str, Floats]:
    """Angles of all shafts in rad from that of one of them, along the chain of one cable of a single design.

    Shafts are the drum, the bodies that the cable passes, ``input`` and ``motor``, in this order; the gearhead is
    assumed to keep the sense of rotation. Where Eq. (1) holds the result does not depend on ``cable``. Raises
    ``ModelError`` for an unknown shaft.
    """
    drum = d.drum_radius_m[cable]
    last = d.routes.cables[cable].wraps[-1].turning
    to_drum = {d.routes.drum.name: 1.0}
    for wrap in reversed(d.routes.cables[cable].passed):
        to_drum[wrap.body] = wrap.turning * last * wrap.radius_m / drum
    to_drum["input"] = d.input_radius_m[cable] / drum
    to_drum["motor"] = d.input_radius_m[cable] / drum / gear_ratio
    if shaft not in to_drum:
        raise ModelError(f"shaft {shaft!r} is unknown; use one of {', '.join(to_drum)}")
    turned = np.asarray(angle_rad, dtype=float) * to_drum[shaft]
    return {name: np.asarray(turned / ratio) for name, ratio in to_drum.items()}


def transmission_error(theta_o_rad: Any, theta_i_rad: Any, total_ratio: Any) -> Floats:
    """Eq. (2): theta_e = theta_o - theta_i / i_c, in rad."""
    return np.asarray(np.asarray(theta_o_rad) - np.asarray(theta_i_rad) / np.asarray(total_ratio))


@dataclass(frozen=True, eq=False)
class RatioResiduals:
    """Relative deviation from Eq. (1): each entry is r/r' over the first such ratio, minus 1.

    ``passed`` (n_cables, *batch) compares, for each passed body from the drum on, its radius over that of the body
    before with that of the first cable; ``inputs`` the input's radius over that of the last body before it with that of
    the first cable of the same input; ``between_inputs`` (n_inputs, *batch) the mean total ratio r_i/r_o of an input
    with that of the first input (inputs at one drum must agree).
    """

    passed: tuple[Floats, ...]
    inputs: Floats
    between_inputs: Floats

    @property
    def by_design(self) -> Floats:
        """Largest magnitude of the residuals of each design, (*batch)."""
        worst = [np.abs(a).max(axis=0) for a in (*self.passed, self.inputs, self.between_inputs)]
        return np.asarray(np.max(worst, axis=0))

    @property
    def worst(self) -> float:
        """Largest magnitude of all residuals."""
        return float(np.max(self.by_design))


def eq1_residuals(d: DriveSI) -> RatioResiduals:
    """Residuals of Eq. (1), with its third row corrected: i_mr = r_mr1/r_g3 = r_mr2/r_g4 (printed: r_g1, r_g2)."""
    before, passed = d.drum_radius_m, []
    for radius in d.passed_radii_m:
        ratio = radius / before
        passed.append(ratio / ratio[0] - 1.0)
        before = radius
    inner, total = d.input_radius_m / before, d.input_radius_m / d.drum_radius_m
    first = [d.input_of.index(i) for i in d.input_of]
    cables_of = [[j for j, k in enumerate(d.input_of) if k == i] for i in range(d.n_inputs)]
    per_input = np.stack([total[own].mean(axis=0) for own in cables_of])
    return RatioResiduals(tuple(passed), inner / inner[first] - 1.0, per_input / per_input[0] - 1.0)


def pair_mismatch_m(d: DriveSI, input_angle_rad: Any) -> Floats:
    """Largest mismatch in length between the first cable of each input and its others, in m, shape (n_inputs, ...).

    With the drum at the angle that cable 1 of the input gives, cable k is too long or too short by theta_i (r_ik - r_ok
    r_i1/r_o1). Zero where Eq. (1) holds.
    """
    theta = np.asarray(input_angle_rad, dtype=float)
    rows = []
    for i in range(d.n_inputs):
        own = [j for j, k in enumerate(d.input_of) if k == i]
        drum_per_input = d.input_radius_m[own[0]] / d.drum_radius_m[own[0]]
        apart = [d.input_radius_m[j] - d.drum_radius_m[j] * drum_per_input for j in own]
        rows.append(theta * max(apart, key=lambda length: float(np.max(np.abs(length)))))
    return np.stack(rows)
