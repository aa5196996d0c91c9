"""Units that a logger may write, and their conversion to SI."""

from __future__ import annotations

import math
from dataclasses import dataclass

from mbcdm_cad.design.blocks import STANDARD_GRAVITY_M_S2

COUNTS = "counts"


@dataclass(frozen=True)
class Unit:
    """SI value = ``factor`` times the figure + ``shift``."""

    factor: float
    shift: float = 0.0


def _scaled(*spelt: tuple[str, float]) -> dict[str, Unit]:
    return {name: Unit(factor) for names, factor in spelt for name in names.split()}


# Dates and times as ISO 8601 writes them; the reader turns them into seconds.
ISO_CLOCK = "iso8601"
TIME = _scaled(
    (ISO_CLOCK, 1.0),
    ("s sec second seconds", 1.0),
    ("ms", 1e-3),
    ("us µs", 1e-6),
    ("ns", 1e-9),
    ("min", 60.0),
    ("h", 3600.0),
)
ANGLE = _scaled(
    ("rad", 1.0),
    ("mrad", 1e-3),
    ("urad µrad", 1e-6),
    ("deg degree degrees °", math.pi / 180.0),
    ("arcmin", math.pi / 10800.0),
    ("arcsec", math.pi / 648000.0),
    ("turn turns rev", 2.0 * math.pi),
)
_KGF = STANDARD_GRAVITY_M_S2
TORQUE = _scaled(
    ("N*m Nm N.m", 1.0),
    ("mN*m mNm mN.m N*mm Nmm N.mm", 1e-3),
    ("N*cm Ncm N.cm", 1e-2),
    ("uN*m uNm µN*m", 1e-6),
    ("kgf*m", _KGF),
    ("kgf*cm kgfcm", 1e-2 * _KGF),
    ("gf*cm gfcm", 1e-5 * _KGF),
    ("ozf*in", 28.349523125e-3 * 0.0254 * _KGF),
    ("lbf*in", 0.45359237 * 0.0254 * _KGF),
    ("lbf*ft", 0.45359237 * 0.3048 * _KGF),
)
# A force with its lever arm gives a torque.
FORCE = _scaled(("N", 1.0), ("mN", 1e-3), ("kN", 1e3), ("kgf", _KGF), ("gf", 1e-3 * _KGF), ("lbf", 0.45359237 * _KGF))
# A length at a radius gives an angle.
LENGTH = _scaled(("mm", 1e-3), ("um µm", 1e-6), ("m", 1.0), ("in", 0.0254))
# Temperatures stay in degC: the effects use only their differences.
TEMPERATURE = {
    **dict.fromkeys(("degC", "°C", "C"), Unit(1.0)),
    **dict.fromkeys(("K",), Unit(1.0, -273.15)),
    **dict.fromkeys(("degF", "°F", "F"), Unit(5.0 / 9.0, -160.0 / 9.0)),
}

CURRENT = _scaled(("A", 1.0), ("mA", 1e-3), ("uA µA", 1e-6))
MASS = _scaled(("kg", 1.0), ("g", 1e-3), ("lb", 0.45359237))
ORDER = _scaled(("cycle/rad cycles/rad 1/rad", 1.0), ("cycle/turn cycles/turn 1/turn", 0.5 / math.pi))

FREQUENCY = _scaled(("Hz 1/s", 1.0), ("kHz", 1e3), ("rad/s", 0.5 / math.pi), ("rpm", 1.0 / 60.0))
# A gain in decibels is no multiple of one; the others are ratios of angles, or angles over a torque.
DECIBEL = "dB"
RATIO = _scaled(("- rad/rad deg/deg", 1.0))
GIVE = _scaled(
    ("rad/(N*m) rad/Nm", 1.0),
    ("mrad/(N*m) mrad/Nm", 1e-3),
    ("urad/(N*m) urad/Nm", 1e-6),
    ("deg/(N*m) deg/Nm", math.pi / 180),
)

KINDS = {
    "time": TIME,
    "input": ANGLE,
    "output": ANGLE,
    "load_torque": TORQUE,
    "temperature": TEMPERATURE,
    "current": CURRENT,
    "excitation": ANGLE | TORQUE | CURRENT | {"V": Unit(1.0), "-": Unit(1.0)},
    "frequency": FREQUENCY,
    "gain": {DECIBEL: Unit(1.0)} | RATIO | GIVE,
    "phase": ANGLE,
    "coherence": _scaled(("-", 1.0), ("%", 0.01)),
    "amplitude": ANGLE | TORQUE,
    "peak_torque": TORQUE,
    "mass": MASS,
    "backlash": ANGLE,
    "ripple_amplitude": ANGLE,
    "ripple_order": ORDER,
}
ENCODERS = ("input", "output")
LOAD = "load_torque"


def unit_of(
    quantity: str,
    name: str,
    counts_per_turn: float | None = None,
    lever_arm_mm: float | None = None,
    radius_mm: float | None = None,
) -> Unit | None:
    """The unit called ``name`` of a column ``quantity``, None if there is no such unit.

    Encoder counts need ``counts_per_turn``, a force as load torque needs ``lever_arm_mm``, a length as angle needs
    ``radius_mm``: the angle is the length over the radius.
    """
    kind = kind_of(quantity)
    spelt = name.strip().replace(" ", "").replace("·", "*").replace("μ", "µ")
    if spelt in (COUNTS, "count") and kind in ENCODERS and counts_per_turn is not None:
        return Unit(2.0 * math.pi / counts_per_turn)
    if kind == LOAD and spelt in FORCE and lever_arm_mm is not None:
        return Unit(FORCE[spelt].factor * 1e-3 * lever_arm_mm)
    if kind in ENCODERS and spelt in LENGTH and radius_mm is not None:
        return Unit(LENGTH[spelt].factor / (1e-3 * radius_mm))
    return KINDS[kind].get(spelt)


def known_units(quantity: str) -> list[str]:
    """Names to offer for a column."""
    kind = kind_of(quantity)
    return [*KINDS[kind], *([COUNTS, *LENGTH] if kind in ENCODERS else []), *(FORCE if kind == LOAD else [])]


def kind_of(quantity: str) -> str:
    """The kind of quantity of a column; all inputs are of one kind, whatever their names."""
    return next((kind for kind in ("input", "current") if quantity.startswith(f"{kind}_")), quantity)
