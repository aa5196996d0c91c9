"""Effects of simulated runs: names, sizes, and how their sizes are drawn."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from tests.support.bench_added import ADDED
from tests.support.bench_motion import Bench, Plan

ALL = (0, 1, 2, 3)


@dataclass(frozen=True)
class Effect:
    """One effect as it is put into a run.

    ``name``, ``stage`` and ``cables`` are the vocabulary's (a name of its own where the vocabulary has none); ``kind``
    is the physical cause, ``size`` its figures in SI.
    """

    name: str
    kind: str
    size: dict[str, float]
    stage: str | None = None
    cables: tuple[int, ...] = ()

    def added(self, bench: Bench, drum: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """What it adds to the output's reading, rad; zero for effects at work inside the chain."""
        return ADDED[self.kind](self.size, bench, drum, rng) if self.kind in ADDED else np.zeros_like(drum)

    @property
    def in_vocabulary(self) -> bool:
        """False for causes that the vocabulary has no name for."""
        return self.name in VOCABULARY

    def as_truth(self) -> dict[str, Any]:
        """As the rig's truth files have it: cables by name, counted from 1."""
        found: dict[str, Any] = {"name": self.name, "cause": self.kind, "in_vocabulary": self.in_vocabulary}
        if self.stage:
            found["stage"] = self.stage
        if self.cables:
            found["cables"] = [f"cable_{j + 1}" for j in self.cables]
        return found | {"parameters": {key: float(value) for key, value in self.size.items()}}


VOCABULARY = (
    "once_per_rev",
    "ripple",
    "ratio_error",
    "stiffness_error",
    "preload_error",
    "cable_friction",
    "friction",
    "delay",
    "lash",
    "bow",
    "thermal_drift",
    "creep",
    "winding_history",
    "passed_slip",
    "slip_step",
)
Draw = Callable[[np.random.Generator, Plan], tuple[Effect, ...]]


def nothing(rng: np.random.Generator, plan: Plan) -> tuple[Effect, ...]:
    """No effect."""
    return ()


def both(one: Draw, other: Draw) -> Draw:
    """Two effects in one run."""
    return lambda rng, plan: (*one(rng, plan), *other(rng, plan))


def amount(name: str, kind: str, ranges: dict[str, tuple[float, float]], **more: Any) -> Draw:
    """An effect whose sizes are each drawn from a range."""
    return lambda rng, plan: (Effect(name, kind, {key: rng.uniform(*ends) for key, ends in ranges.items()}, **more),)


def size(name: str, kind: str, key: str, low: float, high: float, **more: Any) -> Draw:
    """An effect of one positive size."""
    return amount(name, kind, {key: (low, high)}, **more)


def shares(name: str, kind: str, low: float, high: float, **more: Any) -> Draw:
    """An effect with one relative size of either sign."""
    return lambda rng, plan: (Effect(name, kind, {"share": _sign(rng) * rng.uniform(low, high)}, **more),)


def _turning(kind: str, stage: str, key: str, low: float, high: float, unit: float = 1.0) -> Draw:
    def draw(rng: np.random.Generator, plan: Plan) -> tuple[Effect, ...]:
        figures = {key: rng.uniform(low, high) * unit, "phase_rad": _phase(rng, stage)}
        return (Effect("once_per_rev", kind, figures, stage=stage),)

    return draw


def pulley(stage: str, low_um: float, high_um: float) -> Draw:
    """An eccentric pulley."""
    return _turning("pulley", stage, "eccentricity_m", low_um, high_um, 1e-6)


def input_encoder(stage: str, low_rad: float, high_rad: float) -> Draw:
    """An encoder that sits off centre on an input's shaft."""
    return _turning("input_encoder", stage, "amplitude_rad", low_rad, high_rad)


def output_encoder(low_rad: float, high_rad: float) -> Draw:
    """An encoder that sits off centre on the drum's shaft."""
    return _turning("output_encoder", "drum", "amplitude_rad", low_rad, high_rad)


def ripple(cycles: tuple[float, float], low_rad: float, high_rad: float) -> Draw:
    """A line in angle that no stage of the chain has."""
    figures = {"cycles_per_output_rev": cycles, "amplitude_rad": (low_rad, high_rad)}
    return amount("ripple", "division", figures | {"phase_rad": (-1.5 * np.pi, 0.5 * np.pi)})


def anchor(low_m: float, high_m: float) -> Draw:
    """One cable's anchor slips: its path is longer from then on, so that its tension drops."""

    def draw(rng: np.random.Generator, plan: Plan) -> tuple[Effect, ...]:
        figures = {"slip_m": rng.uniform(low_m, high_m), "at_s": rng.uniform(0.3, 0.75) * plan.duration_s}
        return (Effect("slip_step", "anchor", figures, cables=(int(rng.integers(4)),)),)

    return draw


def jump(low_rad: float, high_rad: float) -> Draw:
    """The encoder's mount slips once."""

    def draw(rng: np.random.Generator, plan: Plan) -> tuple[Effect, ...]:
        step = _sign(rng) * rng.uniform(low_rad, high_rad)
        return (
            Effect("slip_step", "mount_jump", {"step_rad": step, "at_s": rng.uniform(0.3, 0.75) * plan.duration_s}),
        )

    return draw


def _placed(name: str, kind: str, key: str, low: float, high: float, **places: tuple[float, float]) -> Draw:
    def draw(rng: np.random.Generator, plan: Plan) -> tuple[Effect, ...]:
        figures = {key: rng.uniform(low, high)}
        figures |= {place: rng.uniform(*shares) * plan.amplitude_rad for place, shares in places.items()}
        return (Effect(name, kind, figures),)

    return draw


def bump(low_rad: float, high_rad: float) -> Draw:
    """A thick place of the rope."""
    places = {"at_rad": (-0.6, 0.6), "width_rad": (0.03, 0.08)}
    return _placed("strand damage", "damaged_strand", "height_rad", low_rad, high_rad, **places)


def climb(low_rad: float, high_rad: float) -> Draw:
    """A rope that climbs a step."""
    places = {"at_rad": (0.3, 0.7), "lag_rad": (0.02, 0.1)}
    return _placed("cable climbing", "climbing", "height_rad", low_rad, high_rad, **places)


def wear(low: float, high: float) -> Draw:
    """A worn stretch of a land."""
    return _placed("worn land", "worn_land", "share", low, high, from_rad=(-0.5, 0.2), length_rad=(0.15, 0.4))


def _sign(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def _phase(rng: np.random.Generator, stage: str) -> float:
    """Any phase, but for the drum one whose error is not all proportional to angle over half a turn or less."""
    if stage == "drum":
        return float(rng.choice([0.0, np.pi]) + rng.uniform(-np.pi / 4, np.pi / 4))
    return float(rng.uniform(-np.pi, np.pi))
