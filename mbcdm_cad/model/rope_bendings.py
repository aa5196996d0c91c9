"""Bendings on and off a pulley that a rope stands before half of all ropes have broken.

Wire rope, generic:  N50 = 3.0e4 (X/15)^3.2 (s/0.13)^-1.8 f_thin f_material f_lubrication f_groove f_fleet

with X = (D/delta)/15, D the pulley's diameter at the rope's centre line, delta the diameter of one wire, and s the
tension over the breaking load. The form, the groove's and the fleet angle's factors and the growth for thin ropes are
those of Feyrer, Wire Ropes; that D/delta is the variable follows from rope makers' least D/d of 3x7, 7x7, 7x19 and
7x49, which all mean a D/delta of 320 to 405. Base and exponents are estimates: no counts for ropes of 0.3 to 3 mm were
found. A test of one's own (an anchor) replaces all of it but the exponents.
"""

from dataclasses import dataclass

import numpy as np

from mbcdm_cad.design.bought import LifeAnchor
from mbcdm_cad.model.tensioning import WIRES
from mbcdm_cad.routes import Floats

BASE, BASE_X, BASE_LOAD = 3.0e4, 15.0, 0.13
X_EXPONENT, LOAD_EXPONENT, FIBRE_EXPONENT = 3.2, -1.8, 2.5
# Where the formula has data behind it. A crossing beyond the easy ends counts as at them, and so too much.
X_RANGE, LOAD_RANGE, MOST_BENDINGS = (8.5, 60.0), (0.02, 0.3), 1.0e6
# Below this X only the order of magnitude.
X_ROUGH = 10.0
MOST_FLEET_DEG = 4.0
# Factor over the groove's radius over the rope's diameter (Feyrer); smooth is the last.
GROOVES = (0.53, 0.55, 0.6, 0.7, 0.8, 1.0)
GROOVE_FACTORS = (1.0, 0.79, 0.66, 0.54, 0.51, 0.48)
SMOOTH_FACTOR = 0.45
MATERIAL_FACTORS = {"stainless": 0.4, "galvanised": 1.0}
LUBRICATION_FACTORS = {"oiled": 1.0, "dry": 0.2}
# Most that a thin rope gains: Feyrer's factor grows without end towards 1.385 mm, where it has no data.
MOST_THIN = 3.0
# Pulleys of more than this D/d count with it in the fleet angle's factor (estimate).
FLEET_RATIO = 40.0
# Standard deviations of the logarithm: base, thin rope, stainless, lubrication, groove, scatter of ropes, an anchor's
# own way of testing; and of both exponents.
SIGMA_BASE, SIGMA_THIN, SIGMA_MATERIAL, SIGMA_LUBRICATION, SIGMA_GROOVE, SIGMA_SCATTER = 0.6, 0.7, 0.5, 0.3, 0.3, 0.5
SIGMA_ANCHOR, SIGMA_X_EXPONENT, SIGMA_LOAD_EXPONENT, SIGMA_FIBRE_EXPONENT = 0.3, 0.4, 0.3, 0.5
# How far an anchor carries: bend ratios and load shares over its own; for fibre, q over its own.
ANCHOR_RATIOS, ANCHOR_LOADS, ANCHOR_FIBRE = (0.5, 2.0), (1.0 / 3.0, 3.0), (0.2, 2.0)


@dataclass(frozen=True)
class RopeKind:
    """What the life of a rope depends on besides pulley and tension. ``construction``: strands x wires, or braid."""

    construction: str
    diameter_mm: float
    material: str
    lubrication: str
    anchor: LifeAnchor | None = None

    @property
    def fibre(self) -> bool:
        """Whether it is a braid, without wires."""
        return self.construction not in WIRES

    @property
    def over_wire(self) -> float:
        """Its diameter over that of one wire."""
        return WIRES[self.construction][1]

    @property
    def why_unknown(self) -> str:
        """Why there is no figure for this rope at all, whatever the pulleys; empty if there is one."""
        if self.anchor is not None:
            return ""
        if self.fibre:
            return "no test of this fibre rope is known (catalogue: life_anchor), and none of another rope carries over"
        if self.material not in MATERIAL_FACTORS:
            known = " and ".join(MATERIAL_FACTORS)
            return f"wires of {self.material}: the data are those of {known} wires; a life_anchor replaces them"
        return ""


@dataclass(frozen=True, eq=False)
class Crossing:
    """Places where a rope bends; all arrays of one shape, or scalars. ``groove``: nan where the pulley is smooth."""

    bend_ratio: Floats
    load_share: Floats
    groove: Floats
    fleet_deg: Floats


def thin_factor(diameter_mm: float) -> float:
    """Feyrer's factor of the rope's diameter, 0.52/((d/16)^0.3 - 0.48), at most :data:`MOST_THIN`."""
    above = (diameter_mm / 16.0) ** 0.3 - 0.48
    return min(0.52 / above, MOST_THIN) if above > 0.0 else MOST_THIN


def groove_factor(groove: Floats | float) -> Floats:
    """Factor of the groove's radius over the rope's diameter; nan: smooth."""
    found = np.interp(groove, GROOVES, GROOVE_FACTORS)
    return np.where(np.isnan(groove), SMOOTH_FACTOR, found)


def fleet_factor(fleet_deg: Floats | float, bend_ratio: Floats | float) -> Floats:
    """Factor of the angle between rope and pulley, 1 - (0.00863 + 0.00243 D/d) a - 0.00103 a^2, a in degrees."""
    angle, ratio = np.minimum(np.abs(fleet_deg), MOST_FLEET_DEG), np.minimum(bend_ratio, FLEET_RATIO)
    return np.asarray(1.0 - (0.00863 + 0.00243 * ratio) * angle - 0.00103 * angle**2)


def bendings(rope: RopeKind, at: Crossing) -> Floats:
    """N50 at each crossing. Easier crossings than the formula has data for count as at its border."""
    if rope.anchor is not None:
        return _scaled(rope, rope.anchor, at)
    x = np.minimum(at.bend_ratio * rope.over_wire / 15.0, X_RANGE[1])
    share = np.maximum(at.load_share, LOAD_RANGE[0])
    # At infinite wraps a slack run has no tension at all; the border above keeps the power finite.
    plain = BASE * (x / BASE_X) ** X_EXPONENT * (share / BASE_LOAD) ** LOAD_EXPONENT
    fixed = (
        thin_factor(rope.diameter_mm) * MATERIAL_FACTORS.get(rope.material, 1.0) * LUBRICATION_FACTORS[rope.lubrication]
    )
    return np.asarray(plain * fixed * groove_factor(at.groove) * fleet_factor(at.fleet_deg, at.bend_ratio))


def _scaled(rope: RopeKind, anchor: LifeAnchor, at: Crossing) -> Floats:
    if rope.fibre:
        share = np.maximum(at.load_share, 1e-9)
        over = anchor.load_share / anchor.bend_ratio * at.bend_ratio / share
        return np.asarray(anchor.bendings * np.minimum(over, 1.0 / ANCHOR_FIBRE[0]) ** FIBRE_EXPONENT)
    low, high = ANCHOR_LOADS[0] * anchor.load_share, ANCHOR_RATIOS[1] * anchor.bend_ratio
    inside = Crossing(np.minimum(at.bend_ratio, high), np.maximum(at.load_share, low), at.groove, at.fleet_deg)
    groove = np.nan if anchor.groove is None else anchor.groove
    tested = Crossing(*(np.asarray(v, float) for v in (anchor.bend_ratio, anchor.load_share, groove, 0.0)))
    return anchor.bendings * _powers(inside, rope.lubrication) / _powers(tested, anchor.lubrication)


def _powers(at: Crossing, lubrication: str) -> Floats:
    """The generic formula without its borders, for ratios."""
    plain = at.bend_ratio**X_EXPONENT * at.load_share**LOAD_EXPONENT * LUBRICATION_FACTORS[lubrication]
    return np.asarray(plain * groove_factor(at.groove) * fleet_factor(at.fleet_deg, at.bend_ratio))


def too_hard(rope: RopeKind, at: Crossing) -> str:
    """Why there is no figure for these crossings, the hardest in words; empty where all are within the data."""
    ratio, share, fleet = (
        float(np.min(at.bend_ratio)),
        float(np.max(at.load_share)),
        float(np.max(np.abs(at.fleet_deg))),
    )
    if rope.anchor is not None:
        return _beyond_anchor(rope, rope.anchor, at)
    x = ratio * rope.over_wire / 15.0
    if x < X_RANGE[0]:
        least = X_RANGE[0] * 15.0 / rope.over_wire
        return f"D/d of {ratio:.3g} is below {least:.3g}, where the data for {rope.construction} rope end"
    if share > LOAD_RANGE[1]:
        return f"a tension of {share:.0%} of the breaking load is above {LOAD_RANGE[1]:.0%}, where the data end"
    if fleet > MOST_FLEET_DEG:
        return f"a fleet angle of {fleet:.2g} degrees is above {MOST_FLEET_DEG:g}, where the data end"
    return ""


def _beyond_anchor(rope: RopeKind, anchor: LifeAnchor, at: Crossing) -> str:
    ratio, share = float(np.min(at.bend_ratio)), float(np.max(at.load_share))
    if rope.fibre:
        over = float(np.max(at.load_share / at.bend_ratio)) / (anchor.load_share / anchor.bend_ratio)
        if over > ANCHOR_FIBRE[1]:
            return (
                f"load share over D/d is {over:.3g} times that of the life_anchor, which carries to {ANCHOR_FIBRE[1]:g}"
            )
        return ""
    if ratio < ANCHOR_RATIOS[0] * anchor.bend_ratio:
        return f"D/d of {ratio:.3g} is below half the life_anchor's {anchor.bend_ratio:.3g}"
    if share > ANCHOR_LOADS[1] * anchor.load_share:
        return f"a tension of {share:.0%} of the breaking load is above three times the life_anchor's"
    return ""


def at_border(rope: RopeKind, at: Crossing) -> Floats:
    """Where a crossing is easier than the data, so that its bendings count as at their border; bool."""
    anchor = rope.anchor
    if anchor is None:
        return np.asarray((at.bend_ratio * rope.over_wire / 15.0 > X_RANGE[1]) | (at.load_share < LOAD_RANGE[0]))
    if rope.fibre:
        over = (at.load_share / at.bend_ratio) / (anchor.load_share / anchor.bend_ratio)
        return np.asarray(over < ANCHOR_FIBRE[0])
    return np.asarray(
        (at.bend_ratio > ANCHOR_RATIOS[1] * anchor.bend_ratio) | (at.load_share < ANCHOR_LOADS[0] * anchor.load_share)
    )


def is_rough(rope: RopeKind, at: Crossing, weight: Floats) -> bool:
    """Whether most of the damage is done where the formula gives only the order of magnitude."""
    if rope.anchor is not None:
        return False
    return float(np.sum(weight * (at.bend_ratio * rope.over_wire / 15.0 < X_ROUGH))) > 0.5


def sigmas(rope: RopeKind, at: Crossing, weight: Floats) -> dict[str, float]:
    """Standard deviations of ln N by cause, for crossings that cause ``weight`` of the damage (adding up to 1)."""
    anchor, share = rope.anchor, np.maximum(at.load_share, LOAD_RANGE[0])

    def mean(values: Floats) -> float:
        return float(np.sum(weight * values))

    if anchor is None:
        x = np.minimum(at.bend_ratio * rope.over_wire / 15.0, X_RANGE[1])
        return {
            "base": SIGMA_BASE,
            "thin rope": SIGMA_THIN * float(np.log(thin_factor(rope.diameter_mm)) / np.log(MOST_THIN)),
            "material": 0.0 if rope.material == "galvanised" else SIGMA_MATERIAL,
            "lubrication": SIGMA_LUBRICATION,
            "groove": SIGMA_GROOVE,
            "scatter of ropes": SIGMA_SCATTER,
            "exponent of D": SIGMA_X_EXPONENT * abs(mean(np.log(x / BASE_X))),
            "exponent of the tension": SIGMA_LOAD_EXPONENT * abs(mean(np.log(share / BASE_LOAD))),
        }
    found = {
        "scatter of ropes": SIGMA_SCATTER,
        "number of ropes tested": SIGMA_SCATTER / float(np.sqrt(anchor.count)),
        "the test's way": SIGMA_ANCHOR,
    }
    ratio, load = mean(np.log(at.bend_ratio / anchor.bend_ratio)), mean(np.log(share / anchor.load_share))
    if rope.fibre:
        return found | {"exponent": SIGMA_FIBRE_EXPONENT * abs(load - ratio)}
    own = np.nan if anchor.groove is None else anchor.groove
    apart = np.abs(np.log(groove_factor(at.groove) / groove_factor(own))) > 1e-9
    return found | {
        "groove": SIGMA_GROOVE * mean(np.where(apart, 1.0, 0.0)),
        "lubrication": SIGMA_LUBRICATION if anchor.lubrication != rope.lubrication else 0.0,
        "exponent of D": SIGMA_X_EXPONENT * abs(ratio),
        "exponent of the tension": SIGMA_LOAD_EXPONENT * abs(load),
    }
