"""Figures of a result as text: the unit that suits a value follows from the ending of the figure's name."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

# Standard deviations on both sides that hold 95 %.
INTERVAL = 1.96


@dataclass(frozen=True)
class Value:
    """A figure with its 95 % interval."""

    value: float
    low: float
    high: float

    @property
    def three(self) -> list[float]:
        """The figure and the ends of its interval."""
        return [self.value, self.low, self.high]

    def to_json(self) -> dict[str, Any]:
        """As the result file has it."""
        return {"value": self.value, "ci95": [self.low, self.high]}


def _angle_over(unit: str) -> tuple[tuple[float, str], ...]:
    return tuple((size, f"{word}/{unit}") for size, word in ((1.0, "rad"), (1e-3, "mrad"), (1e-6, "urad")))


# Units by the ending of the name, longest ending first; for each the units to choose from, largest first.
_SIZES: tuple[tuple[str, tuple[tuple[float, str], ...]], ...] = (
    ("_rad_Nm_s", _angle_over("(N m s)")),
    ("_rad_Nm", _angle_over("(N m)")),
    ("_rad_rad2", _angle_over("rad^2")),
    ("_rad_rad3", _angle_over("rad^3")),
    ("_rad_s", _angle_over("s")),
    ("_rad_K", _angle_over("K")),
    ("_Nm_s", ((1.0, "N m s"), (1e-3, "mN m s"))),
    ("_rad", ((1.0, "rad"), (1e-3, "mrad"), (1e-6, "urad"))),
    ("_Nm", ((1.0, "N m"), (1e-3, "mN m"))),
    ("_m", ((1e-3, "mm"), (1e-6, "um"))),
    ("_N", ((1.0, "N"),)),
    ("_s", ((1.0, "s"), (1e-3, "ms"))),
    ("_Hz", ((1.0, "Hz"),)),
    ("share", ((1e-2, "%"),)),
)
# Angles that are a place or a phase, not a size.
_PLACES = ("phase", "angle", "at_")


def size_of(name: str, values: Sequence[float]) -> tuple[float, str]:
    """Factor and unit that suit the largest of the values of a figure called ``name``; (1, "") where it has none."""
    for ending, sizes in _SIZES:
        if name.endswith(ending):
            if ending == "_rad" and name.startswith(_PLACES):
                sizes = ((math.pi / 180.0, "deg"),)
            most = max((abs(v) for v in values if math.isfinite(v)), default=0.0)
            return next((size for size in sizes if most >= size[0]), sizes[-1])
    return 1.0, ""


def readable(name: str, values: Sequence[float]) -> tuple[str, list[str]]:
    """A figure's name without its unit and its values with one, all in the unit that suits the largest."""
    factor, unit = size_of(name, values)
    if not unit:
        return name.replace("_", " "), ["any size" if math.isinf(v) else f"{v:.5g}" for v in values]
    ending = next(ending for ending, _ in _SIZES if name.endswith(ending))
    word = name if ending == "share" else name.removesuffix(ending)
    return word.replace("_", " ").strip(), ["any size" if math.isinf(v) else f"{v / factor:.4g} {unit}" for v in values]


def probability_text(share: float) -> str:
    """A probability in per cent; none is certain."""
    return "over 99%" if share > 0.99 else "under 1%" if share < 0.01 else f"{share:.0%}"


def share_text(share: float) -> str:
    """A share in per cent; a share slightly below 1 is not called 100 %."""
    return "over 99%" if 0.99 < share < 0.9999 else f"{share:.0%}"
