"""Motions, loads and sensors of simulated bench runs."""

from dataclasses import dataclass

import numpy as np

INPUT_STEP_RAD = 1.9175e-4
OUTPUT_STEP_RAD = 1.3635e-6
TORQUE_NOISE_NM = 0.005
RATE_HZ = 100.0


@dataclass(frozen=True)
class Plan:
    """What the bench is told to do. Amplitude at the drum; ``load``: brake, levels, bias, steps, free or bare."""

    amplitude_rad: float = 0.45
    frequency_hz: float = 0.0625
    wave: str = "triangle"
    load: str = "levels"
    load_Nm: float = 0.91
    duration_s: float = 160.0


@dataclass(frozen=True)
class Bench:
    """True signals, before any sensor: time (n,), inputs (inputs, n), torque at the drum (n,), speed (n,), air (n,)."""

    time_s: np.ndarray
    input_rad: np.ndarray
    load_Nm: np.ndarray
    speed_rad_s: np.ndarray
    air_degC: np.ndarray


def _soft(values: np.ndarray, width_s: float) -> np.ndarray:
    """Moving average that keeps the ends."""
    half = max(1, round(width_s * RATE_HZ / 2))
    padded = np.concatenate([np.full(half, values[0]), values, np.full(half, values[-1])])
    return np.convolve(padded, np.full(2 * half + 1, 1.0 / (2 * half + 1)), mode="valid")


def bench_run(plan: Plan, ratio: float, inputs: int, rng: np.random.Generator) -> Bench:
    """The motion and the load of one run; the inputs keep slightly apart as two servos do."""
    n = round(plan.duration_s * RATE_HZ)
    t = np.arange(n) / RATE_HZ
    phase = 2.0 * np.pi * plan.frequency_hz * t
    if plan.wave == "paced":
        # Twice as fast in the second half: on one sine, speed is a function of angle.
        phase = phase + np.maximum(phase - 0.5 * phase[-1], 0.0)
    shape = np.sin(phase) if plan.wave in ("sine", "paced") else 2.0 / np.pi * np.arcsin(np.sin(phase))
    drum = plan.amplitude_rad * (_soft(shape, 0.1) - _soft(shape, 0.1)[0])
    common = ratio * drum
    pairs = [common + stray(t, rng) for _ in range(inputs)]
    speed = np.gradient(drum, t)
    forward = np.tanh(speed / (0.02 * plan.amplitude_rad * plan.frequency_hz * 4.0))
    sweep = np.floor(2.0 * plan.frequency_hz * t + 0.5).astype(int)
    if plan.load == "brake":
        load = plan.load_Nm * forward
    elif plan.load == "levels":
        levels = plan.load_Nm * np.array([1.0, 0.35, 0.7, 1.3])
        load = levels[(sweep // 4) % 4] * forward
    elif plan.load == "bias":
        load = plan.load_Nm * (0.5 * forward + 0.8 * np.where((sweep // 4) % 2 == 0, 1.0, -1.0))
    elif plan.load == "steps":
        holds = np.cumsum(rng.uniform(4.0, 11.0, size=60))
        level = rng.uniform(-1.2, 1.2, size=61) * plan.load_Nm
        load = level[np.searchsorted(holds, t)]
    else:
        load = np.zeros(n)
    load = _soft(load, 0.2)
    load = load - load[0] * np.exp(-t / 0.1)
    return Bench(t, np.array(pairs), load, speed, warming_air(t, rng))


def stray(time_s: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Slow deviation of one servo from its command, rad at the input."""
    waves = (rng.normal(0.0, 2e-5) * np.sin(2.0 * np.pi * time_s / rng.uniform(30.0, 90.0)) for _ in range(3))
    return np.asarray(sum(waves))


def warming_air(time_s: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Temperature of the air, degC."""
    return 21.0 + rng.uniform(1.5, 3.0) * (1.0 - np.exp(-time_s / rng.uniform(50.0, 90.0)))


def read_sensors(bench: Bench, drum_rad: np.ndarray, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """What the logger writes: quantised angles, noisy torque; each encoder counts from a place of its own."""

    def counts(values: np.ndarray, step: float) -> np.ndarray:
        shift = rng.uniform(0.0, 1.0)
        return (np.round(values / step + shift) - round(shift)) * step

    return {
        "inputs": np.array([counts(row, INPUT_STEP_RAD) for row in bench.input_rad]),
        "output": counts(drum_rad, OUTPUT_STEP_RAD),
        "torque": bench.load_Nm + rng.normal(0.0, TORQUE_NOISE_NM, bench.load_Nm.size),
        "temperature": bench.air_degC + rng.normal(0.0, 0.02, bench.load_Nm.size),
    }
