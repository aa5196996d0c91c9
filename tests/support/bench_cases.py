"""Which runs are made: effects with sizes drawn by seed, and the motion that each case runs on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from bench_motion import Bench, Plan

Draw = Callable[[np.random.Generator, Plan], tuple["Effect", ...]]


@dataclass(frozen=True)
class Effect:
    """One effect as it is put into a run.

    ``name``/``stage``/``cables`` are the vocabulary's; ``kind`` is the physical cause; ``physical`` its size in SI;
    ``expected`` the parameters the loop should report, by name. ``fair`` lists names that are as good an answer.
    """

    name: str
    kind: str
    physical: dict[str, float]
    stage: str | None = None
    cables: tuple[int, ...] = ()
    expected: dict[str, float] = field(default_factory=dict)
    fair: tuple[tuple[str, str | None], ...] = ()
    in_vocabulary: bool = True

    def added(self, bench: Bench, drum: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """What it adds to the output's reading, rad; zero for effects at work inside the chain."""
        return ADDED[self.kind](self.physical, bench, drum, rng) if self.kind in ADDED else np.zeros_like(drum)

    def as_truth(self) -> dict[str, Any]:
        """For the truth file. Cables are given from 1."""
        found: dict[str, Any] = {"name": self.name, "cause": self.kind}
        if self.stage:
            found["stage"] = self.stage
        if self.cables:
            found["cables"] = [j + 1 for j in self.cables]
        found["parameters"] = {key: float(value) for key, value in {**self.physical, **self.expected}.items()}
        if not self.in_vocabulary:
            found["in_vocabulary"] = False
        return found


def _delayed(p: dict[str, float], bench: Bench, drum: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return np.interp(bench.time_s - p["delay_s"], bench.time_s, drum) - drum


ADDED: dict[str, Callable[..., np.ndarray]] = {
    "output_scale": lambda p, bench, drum, rng: p["share"] * drum,
    "output_encoder": lambda p, bench, drum, rng: (
        p["amplitude_rad"] * (np.cos(drum + p["phase_rad"]) - np.cos(p["phase_rad"]))
    ),
    "shaft_compliance": lambda p, bench, drum, rng: -p["compliance_rad_Nm"] * bench.load_Nm,
    "latency": _delayed,
}


def _sign(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def _phase(rng: np.random.Generator) -> float:
    return float(rng.uniform(-np.pi, np.pi))


def pulley(stage: str, low_um: float, high_um: float) -> Draw:
    """An eccentric pulley."""

    def draw(rng: np.random.Generator, plan: Plan) -> tuple[Effect, ...]:
        size = {"eccentricity_m": rng.uniform(low_um, high_um) * 1e-6, "phase_rad": _phase(rng)}
        return (Effect("once_per_rev", "pulley", size, stage=stage),)

    return draw


def input_encoder(stage: str, low_rad: float, high_rad: float) -> Draw:
    """An encoder that sits off centre on an input's shaft."""

    def draw(rng: np.random.Generator, plan: Plan) -> tuple[Effect, ...]:
        size = {"amplitude_rad": rng.uniform(low_rad, high_rad), "phase_rad": _phase(rng)}
        return (Effect("once_per_rev", "input_encoder", size, stage=stage),)

    return draw


def output_encoder(low_rad: float, high_rad: float) -> Draw:
    """An encoder that sits off centre on the drum's shaft. The high side lies where order one is not all ratio."""

    def draw(rng: np.random.Generator, plan: Plan) -> tuple[Effect, ...]:
        size = {"amplitude_rad": rng.uniform(low_rad, high_rad), "phase_rad": _phase(rng)}
        return (Effect("once_per_rev", "output_encoder", size, stage="drum"),)

    return draw


def shares(name: str, kind: str, low: float, high: float, cables: tuple[int, ...] = (), **more: Any) -> Draw:
    """An effect with one relative size of either sign."""

    def draw(rng: np.random.Generator, plan: Plan) -> tuple[Effect, ...]:
        return (Effect(name, kind, {"share": _sign(rng) * rng.uniform(low, high)}, cables=cables, **more),)

    return draw


def amount(name: str, kind: str, key: str, low: float, high: float, **more: Any) -> Draw:
    """An effect with one positive size."""

    def draw(rng: np.random.Generator, plan: Plan) -> tuple[Effect, ...]:
        return (Effect(name, kind, {key: rng.uniform(low, high)}, **more),)

    return draw


def nothing(rng: np.random.Generator, plan: Plan) -> tuple[Effect, ...]:
    """No effect."""
    return ()


def motion(amplitudes: tuple[float, ...], loads: tuple[str, ...]) -> Callable[[np.random.Generator], Plan]:
    """A motion drawn from a few."""

    def draw(rng: np.random.Generator) -> Plan:
        plan = Plan(amplitude_rad=float(rng.choice(amplitudes)), load=str(rng.choice(loads)))
        wave = str(rng.choice(["triangle", "sine"]))
        return replace(plan, wave=wave, frequency_hz=float(rng.choice([0.05, 0.0625, 0.1])))

    return draw


WIDE = motion((0.45, 0.6), ("levels", "bias", "steps"))
ANY = motion((0.05, 0.45, 0.6), ("brake", "levels", "bias", "steps"))
LOADED = motion((0.05, 0.45, 0.6), ("levels", "bias", "steps"))


@dataclass(frozen=True)
class Case:
    """A kind of run."""

    plan: Callable[[np.random.Generator], Plan]
    effects: Draw
    temperature: bool = False


CASES: dict[str, Case] = {
    "null": Case(ANY, nothing),
    "pulley_drum": Case(WIDE, pulley("drum", 8.0, 30.0)),
    "pulley_guide": Case(WIDE, pulley("guide", 3.0, 12.0)),
    "pulley_input_left": Case(WIDE, pulley("input_left", 3.0, 12.0)),
    "pulley_input_right": Case(WIDE, pulley("input_right", 3.0, 12.0)),
    "encoder_drum": Case(WIDE, output_encoder(2e-4, 6e-4)),
    "encoder_input_left": Case(WIDE, input_encoder("input_left", 4e-4, 1.5e-3)),
    "encoder_input_right": Case(WIDE, input_encoder("input_right", 4e-4, 1.5e-3)),
    "ratio_radii": Case(WIDE, shares("ratio_error", "radii", 1e-4, 6e-4)),
    "ratio_encoder": Case(WIDE, shares("ratio_error", "output_scale", 1e-4, 6e-4)),
    "stiffness_modulus": Case(LOADED, shares("stiffness_error", "modulus", 0.12, 0.3)),
    "stiffness_shaft": Case(LOADED, amount("stiffness_error", "shaft_compliance", "compliance_rad_Nm", 1.5e-5, 6e-5)),
    "preload_all": Case(
        LOADED, shares("preload_error", "preload", 0.2, 0.4, (0, 1, 2, 3), fair=(("cable_friction", None),))
    ),
    "friction": Case(LOADED, amount("friction", "bearing", "torque_Nm", 0.08, 0.25)),
    "delay": Case(LOADED, amount("delay", "latency", "delay_s", 2e-3, 1e-2)),
}
