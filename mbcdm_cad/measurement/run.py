"""One measured run in SI units, as every later step uses it, and one note of its vetting."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from dataclasses import field as with_default
from functools import cached_property
from typing import Literal

import numpy as np

from mbcdm_cad.design.fieldpath import FieldPath
from mbcdm_cad.routes import Floats

Level = Literal["refused", "doubt", "fact"]


@dataclass(frozen=True)
class Sensors:
    """Resolution and noise of the sensors; None where the measurement file does not state them."""

    input_resolution_rad: float | None = None
    output_resolution_rad: float | None = None
    torque_noise_Nm: float | None = None
    input_noise_rad: float | None = None
    output_noise_rad: float | None = None


@dataclass(frozen=True)
class ZerosFound:
    """Zeros of the inputs that were taken from the data, rad: largest difference between two inputs that was removed,
    how wrong that may be, and the angle of all inputs that was removed."""

    apart_rad: float
    apart_unsure_rad: float
    centre_rad: float


@dataclass(frozen=True, eq=False)
class Run:
    """A measured run. Arrays have one column a sample; inputs are positive when they drive the drum positive.

    Shapes: ``time_s`` (n,), ``input_rad`` (n_inputs, n), ``output_rad`` (n,), ``load_Nm`` and ``temperature_C`` (n,) or
    None. ``load_Nm`` > 0 opposes positive rotation. ``ratio`` is the total ratio of a drive of which nothing else is
    known, else None. ``motor_side`` says of each input whether its encoder sits on the motor, before the gearhead:
    then its angle is the motor's until the run is compared with a design (:func:`mbcdm_cad.measurement.vet.arranged`).
    ``zeros``: those of the inputs that the file does not give (:mod:`mbcdm_cad.measurement.zeros`).
    """

    time_s: Floats
    input_rad: Floats
    output_rad: Floats
    load_Nm: Floats | None = None
    temperature_C: Floats | None = None
    sensors: Sensors = with_default(default_factory=Sensors)
    input_names: tuple[str, ...] = ("left", "right")
    source: str = ""
    sha256: str = ""
    ratio: float | None = None
    motor_side: tuple[bool, ...] = ()
    zeros: ZerosFound | None = None

    @cached_property
    def step_s(self) -> float:
        """Time between samples, s: the median."""
        return float(np.median(np.diff(self.time_s)))


@dataclass(frozen=True)
class VettingNote:
    """One sentence about a run, found before any residual is computed.

    ``kind`` identifies it for programs; ``field`` is the field of the measurement file that it concerns.

    ``refused``: the run cannot be judged as it is declared. ``doubt``: it is judged, but the result may be wrong.
    ``fact``: what the experiment can and cannot show.
    """

    kind: str
    level: Level
    text: str
    remedy: str = ""
    field: FieldPath = ()

    def __str__(self) -> str:
        """Sentence and remedy on one line."""
        return self.text + (f"; {self.remedy}" if self.remedy else "")


def doubts(notes: Sequence[str], findings: Sequence[VettingNote]) -> list[str]:
    """Reasons to doubt a result: notes of the reading and doubts of the vetting."""
    return [*notes, *(str(finding) for finding in findings if finding.level == "doubt")]


def column_of(input_name: str) -> FieldPath:
    """Field of the measurement file that describes one input."""
    return ("columns", "input" if input_name == "input" else f"input_{input_name}")
