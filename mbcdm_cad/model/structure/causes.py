"""Turn of the payload by cause: what a structure's figures are made of."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from math import hypot, log
from typing import Any

from mbcdm_cad.model.stiffness import Chain

# One standard deviation, as a factor: of drums and shafts, compared with closed forms and solid elements, with the
# tolerances of walls and moduli; of the frame, with its mount; of bearings, whose balls have a usual size; of
# gearheads; of springs in the terminals, which friction on the drum shields.
BY_PARTS, BY_FRAME, BY_BEARINGS, BY_GEARHEADS, BY_SPRINGS = 1.1, 1.15, 1.3, 2.0, 1.3


@dataclass(frozen=True)
class Cause:
    """Turn of the payload per N m by one part's strain.

    ``at_encoder``: whether the drum's encoder sees it too. ``before_input``: whether it lies between the motor and the
    input pulley's encoder. ``in_drum``: whether it lies between the drum's land and the payload. ``factor``: one
    standard deviation of its logarithm, as a factor. ``after_slip``: whether it gives only where slip of the cables has
    reached it, so that it is rigid for small motion; the rig's cables have it themselves. ``stiffer``: fields that make
    it give less.
    """

    name: str
    urad_Nm: float
    at_encoder: bool = True
    before_input: bool = False
    in_drum: bool = False
    factor: float = BY_PARTS
    after_slip: bool = False
    stiffer: str = "its bearings"


@dataclass(frozen=True)
class Structure:
    """Compliance of a drive by cause, and the stress of its drum.

    ``cables_urad_Nm``: turn by the cables at the test torque, over that torque. ``stress_MPa`` gives the largest
    equivalent stress of the drum's web and rim under a torque of either sense, N m, with the preload; ``yield_MPa``:
    the yield stress of its material. ``motor_encoders``: whether only the motors' own encoders hold the inputs, so that
    the gearheads give then too.
    """

    causes: tuple[Cause, ...]
    cables_urad_Nm: float
    stress_MPa: Callable[[float], float] = field(repr=False, compare=False)
    peak_torque_Nm: float
    yield_MPa: float
    motor_encoders: bool = False

    @property
    def peak_stress_MPa(self) -> float:
        """Largest stress of the drum's web and rim at the peak torque."""
        return self.stress_MPa(self.peak_torque_Nm)

    @property
    def at_payload(self) -> tuple[Cause, ...]:
        """Causes that the payload sees, the inputs held by their encoders."""
        return tuple(c for c in self.causes if self.motor_encoders or not c.before_input)

    @property
    def at_encoder(self) -> tuple[Cause, ...]:
        """As :attr:`at_payload`, those that the drum's encoder sees."""
        return tuple(c for c in self.at_payload if c.at_encoder)

    @property
    def payload_urad_Nm(self) -> float:
        """Turn of the payload besides that of the cables, the inputs held by their encoders."""
        return urad_Nm(self.at_payload)

    @property
    def encoder_urad_Nm(self) -> float:
        """As :attr:`payload_urad_Nm`, as the drum's encoder sees it."""
        return urad_Nm(self.at_encoder)

    @property
    def motor_urad_Nm(self) -> float:
        """As :attr:`payload_urad_Nm`, the motors' shafts held in place of the inputs."""
        return urad_Nm(self.causes)

    @property
    def over_cables(self) -> float:
        """Turn of the structure over that of the cables, as the payload sees it."""
        return self.payload_urad_Nm / self.cables_urad_Nm

    @property
    def stiffness_Nm_rad(self) -> float:
        """Test torque over the payload's turn by cables and structure, the inputs held by their encoders."""
        return 1e6 / (self.cables_urad_Nm + self.payload_urad_Nm)

    @property
    def chain(self) -> Chain:
        """Where the structure gives, for the torsional modes."""
        before = urad_Nm(c for c in self.causes if c.before_input)
        in_drum = urad_Nm(c for c in self.causes if c.in_drum)
        return Chain(before * 1e-6, (urad_Nm(sticking(self.causes)) - before - in_drum) * 1e-6, in_drum * 1e-6)

    def to_dict(self) -> dict[str, Any]:
        """Everything, ready for JSON."""
        return {
            "causes": [
                {
                    "name": c.name,
                    "urad_Nm": c.urad_Nm,
                    "factor": c.factor,
                    "seen_by_drum_encoder": c.at_encoder,
                    "between_motor_and_input_encoder": c not in self.at_payload,
                }
                for c in self.causes
            ],
            "cables_urad_Nm": self.cables_urad_Nm,
            "structure_at_payload_urad_Nm": self.payload_urad_Nm,
            "structure_at_drum_encoder_urad_Nm": self.encoder_urad_Nm,
            "structure_motors_held_urad_Nm": self.motor_urad_Nm,
            "structure_over_cables": self.over_cables,
            "stiffness_at_payload_Nm_rad": self.stiffness_Nm_rad,
            "drum_peak_stress_MPa": self.peak_stress_MPa,
            "drum_yield_MPa": self.yield_MPa,
        }


def urad_Nm(causes: Iterable[Cause]) -> float:
    """Turn by several causes."""
    return sum(c.urad_Nm for c in causes)


def sticking(causes: Iterable[Cause]) -> tuple[Cause, ...]:
    """Those that give for small motion too, every wrap sticking."""
    return tuple(c for c in causes if not c.after_slip)


def sigma_urad_Nm(causes: Iterable[Cause]) -> float:
    """Standard deviation of the turn by several causes: those with one factor are wrong together."""
    by_factor: dict[float, float] = {}
    for c in causes:
        by_factor[c.factor] = by_factor.get(c.factor, 0.0) + c.urad_Nm * log(c.factor)
    return hypot(*by_factor.values())
