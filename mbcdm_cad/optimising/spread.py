"""Figures over the drives that one design gives: tolerances, friction, modulus and losses differ from drive to drive.

``swing_mrad_p95`` is what 95 % of the drives stay below, ``torque_Nm_p5`` what 95 % of them reach. The draws are a
Latin hypercube (McKay, Beckman, Conover, 1979) of normal laws. Each uncertain quantity has its own column, found by its
name, so that every design sees the same draws (common random numbers) and differences between designs are not noise.
"""

import re
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.model import capability, losses
from mbcdm_cad.model.losses import BEARINGS, GEARHEAD, GEARHEAD_IDLE, MOTOR, ROPE, Train
from mbcdm_cad.model.sensitivity import by_cable, shifted
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.model.stiffness import drum_backlash
from mbcdm_cad.model.structure.causes import Structure
from mbcdm_cad.parts.making import model_tolerances
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.route import DRUM_RADIUS, INPUT_RADIUS

DRAWS, SEED = 256, 95
# Standard deviations over the values, for files that give none: those of the ranges of the sensitivity study, 45 to 65
# GPa and 0.10 to 0.20, each value equally likely.
MODULUS_SHARE, FRICTION_SHARE = 0.1, 0.2
# Figures with a spread. Mass, box and fields of the file have none.
TORQUES = ("torque_Nm", "torque_lossless_Nm", "torque_with_losses_Nm")
OVER_WEIGHT = {name.replace("torque_", "torque_to_weight_", 1).replace("_Nm", "_Nm_kg"): name for name in TORQUES}
SPREAD = ("swing_mrad", "cable_swing_mrad", "stiffness_Nm_rad", *TORQUES, *OVER_WEIGHT, "efficiency")
_NAME = re.compile(rf"({'|'.join(SPREAD)})_p(5|95)")


def percentile_of(name: str) -> tuple[str, float] | None:
    """(figure, percentile) of a name such as ``swing_mrad_p95``; None for any other name."""
    found = _NAME.fullmatch(name)
    return None if found is None else (found[1], float(found[2]))


class Spread:
    """Figures of one design over :data:`DRAWS` drives, arrays (DRAWS,) in the units of their names."""

    def __init__(self, drive: Drive, mass_g: Callable[[], float]) -> None:
        """``mass_g`` gives the mass, which is asked for only where a figure needs it."""
        self.drive, self._mass_g = drive, mass_g
        d = layout_of(drive).si
        sigmas = sigmas_of(d, drive)
        # The torque of the motor is no field of the model's drive: it varies by a factor.
        rating = sigmas.pop("input_rating_Nm", 0.0) / capability.requirements(layout_of(self.drive)).input_rating_Nm
        self.motor_factor = 1.0 + rating * unit_draws("motor torque")
        drawn = {
            name: np.atleast_1d(size)[:, None] * np.stack([unit_draws(f"{name} {k}") for k in range(np.size(size))])
            for name, size in sigmas.items()
        }
        self.d, need = shifted(d, capability.requirements(layout_of(self.drive)), drawn, DRAWS)
        self.load_Nm = np.broadcast_to(np.asarray(need.load_Nm, float), (DRAWS,))

    def percentile(self, figure: str, percent: float) -> float:
        """The value of a figure that ``percent`` of the drives stay below."""
        return float(np.percentile(self.of(figure), percent))

    def of(self, figure: str) -> Floats:
        """One figure of all drives. Raises ``NoFigureError`` where the design has no such figure."""
        if figure in TORQUES:
            counted = self.drive.limits.counts_losses if figure == "torque_Nm" else figure == "torque_with_losses_Nm"
            return self.torque_with_losses_Nm if counted else self.torque_lossless_Nm
        if figure in OVER_WEIGHT:
            return self.of(OVER_WEIGHT[figure]) / (self._mass_g() * 1e-3)
        found: Floats = getattr(self, figure)
        return found

    @cached_property
    def cable_swing_mrad(self) -> Floats:
        """Swing of the drum by its cables."""
        return np.asarray(self._backlash.reversal_swing_rad * 1e3)

    @property
    def swing_mrad(self) -> Floats:
        """Swing of the payload, cables and structure."""
        return self.cable_swing_mrad + 2e-3 * self.load_Nm * self._structure_urad_Nm

    @property
    def stiffness_Nm_rad(self) -> Floats:
        """Stiffness at the payload; the cables' part follows their turn at first loading."""
        nominal = self._structure.cables_urad_Nm
        turn = drum_backlash(layout_of(self.drive).si, self.drive.loads.test_torque_Nm).first_loading_rad
        each = self._backlash.first_loading_rad / self.load_Nm * self.drive.loads.test_torque_Nm
        return np.asarray(1e6 / (nominal * each / turn + self._structure_urad_Nm))

    @cached_property
    def torque_lossless_Nm(self) -> Floats:
        """Peak torque in the weaker direction without losses."""
        rating = capability.input_ratings_Nm(self.drive)[capability.motor_rating(self.drive)] * self.motor_factor
        return self._least([capability.torque_at_input_limit_Nm(self.d, rating, way) for way in (1, -1)])

    @cached_property
    def torque_with_losses_Nm(self) -> Floats:
        """Peak torque in the weaker direction with all losses."""
        motor = self.drive.motor.rated_torque_mNm * 1e-3 * self.motor_factor
        output = self.train.output_Nm(motor)
        return self._least([self.train.raised_Nm(output, way) for way in (1, -1)])

    @property
    def efficiency(self) -> Floats:
        """At the peak torque, motors moving the load."""
        return self.train.moving(np.full(DRAWS, self.drive.loads.peak_torque_Nm), 1).efficiency

    @cached_property
    def train(self) -> Train:
        """The train of all drives, each with its own losses."""
        own = layout_of(self.drive).losses
        sigma = losses.FIBRE_SIGMA if own.fibre else losses.ROPE_SIGMA
        rope, bearings = _factor(ROPE, sigma), _factor(BEARINGS, losses.BEARING_SIGMA)
        return replace(
            own,
            d=self.d,
            rope=tuple(replace(bend, share=bend.share[:, None] * rope) for bend in own.rope),
            bearings=tuple(replace(pair, factor=pair.factor * bearings) for pair in own.bearings),
            gear_share=own.gear_share * _factor(GEARHEAD, losses.GEARHEAD_SIGMA),
            gear_idle_Nm=own.gear_idle_Nm * _factor(GEARHEAD_IDLE, losses.GEARHEAD_IDLE_SIGMA),
            motor_idle_Nm=own.motor_idle_Nm * _factor(MOTOR, own.motor_sigma),
        )

    @cached_property
    def _backlash(self) -> Any:
        return drum_backlash(self.d, self.load_Nm)

    @property
    def _structure(self) -> Structure:
        found = structure_of(layout_of(self.drive))
        if found is None:
            raise NoFigureError(f"{layout_of(self.drive).name} has no figures of its structure")
        return found

    @cached_property
    def _structure_urad_Nm(self) -> Floats:
        """Turn of the payload besides that of the cables; causes with one factor are wrong together."""
        causes = self._structure.at_payload
        return np.asarray(sum(c.urad_Nm * _factor(f"structure {c.factor:g}", np.log(c.factor)) for c in causes))

    def _least(self, at_inputs: list[Floats]) -> Floats:
        """The lowest of the inputs' limits, the cables' strength and slip, in both directions."""
        strength = np.full(DRAWS, capability.tension_limit_N(self.drive))
        limits = [*at_inputs, *(capability.torque_at_tension_limit_Nm(self.d, strength, way) for way in (1, -1))]
        if self.d.through_wrap_rad is not None:
            wraps = layout_of(self.drive).wraps_at_ends_rad
            ends = [{name: wrap[:, None] for name, wrap in end.items()} for end in wraps]
            limits += [capability.torque_at_slip_Nm(self.d, way, ends) for way in (1, -1)]
        return np.asarray(np.concatenate(limits).min(axis=0))


def sigmas_of(d: DriveSI, drive: Drive) -> dict[str, Any]:
    """Standard deviations in SI: the file's own, else those of its tolerances and this module's shares.

    Named as :mod:`mbcdm_cad.model.sensitivity` has them; those of each cable are arrays (n_cables,).
    """
    parts, own = model_tolerances(drive), by_cable(d)
    found: dict[str, Any] = {
        "modulus_Pa": MODULUS_SHARE * float(d.modulus_Pa),
        "friction_coefficient": FRICTION_SHARE * float(d.friction_coefficient),
        "preload_N": parts.preload_N,
        DRUM_RADIUS: parts.drum_radius_m,
        INPUT_RADIUS: parts.input_radius_m,
    } | capability.sigmas_si(layout_of(drive))
    return {name: np.broadcast_to(size, (d.n_cables,)) if name in own else size for name, size in found.items()}


@lru_cache(maxsize=256)
def unit_draws(name: str) -> Floats:
    """Draws (DRAWS,) of the uncertain quantity ``name``, normal with a standard deviation of one."""
    from scipy.special import ndtri  # takes longer to import than most commands run

    ranks = np.random.default_rng([SEED, *name.encode()]).permutation(DRAWS)
    return np.asarray(ndtri((ranks + 0.5) / DRAWS))


def _factor(name: str, sigma: float) -> Floats:
    """Factors of a quantity that is known up to a factor; ``sigma`` of its logarithm."""
    return np.asarray(np.exp(sigma * unit_draws(name)))
