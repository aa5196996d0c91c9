"""One measured run in SI units, as every later step sees it."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Sensors:
    """What the sensors resolve; None where the measurement file does not say."""

    input_resolution_rad: float | None = None
    output_resolution_rad: float | None = None
    torque_noise_Nm: float | None = None


@dataclass(frozen=True, eq=False)
class Run:
    """A measured run. Arrays have one column a sample; inputs are positive when they drive the drum positive.

    Shapes: ``time_s`` (n,), ``input_rad`` (n_inputs, n), ``output_rad`` (n,), ``load_Nm`` and ``temperature_C`` (n,) or
    None. ``load_Nm`` > 0 opposes positive rotation. ``ratio`` is the total ratio of a drive of which nothing else is
    known, else None.
    """

    time_s: Floats
    input_rad: Floats
    output_rad: Floats
    load_Nm: Floats | None = None
    temperature_C: Floats | None = None
    sensors: Sensors = field(default_factory=Sensors)
    input_names: tuple[str, ...] = ("left", "right")
    source: str = ""
    sha256: str = ""
    ratio: float | None = None

    @cached_property
    def step_s(self) -> float:
        """Time between samples, s: the median."""
        return float(np.median(np.diff(self.time_s)))
