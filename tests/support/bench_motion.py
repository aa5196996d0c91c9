"""Motions, loads and sensors of simulated bench runs, and the geometry of their drives.

Pulleys, spans and levers of a drive, from the design file alone (millimetres become metres here).

Seen from +z with the guide's axis at the origin; the inputs stand at (side * L, 0). A cable that leaves the guide
towards ``drum_side`` turns the drum about +y with sense ``-drum_side``, and its free span is the internal tangent.
"""

from dataclasses import dataclass

import numpy as np

from mbcdm_cad.design.drive import Drive

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


@dataclass(frozen=True)
class Chain:
    """One row a cable: radii (m), preload (N), span (m), unit vectors; scalars: friction, EA (N)."""

    sense: np.ndarray
    input_of: np.ndarray
    r_in: np.ndarray
    r_guide: np.ndarray
    r_drum: np.ndarray
    preload: np.ndarray
    span: np.ndarray
    to_input: np.ndarray  # unit vector in the x-y plane, from the guide's tangent point to the input's
    to_drum: np.ndarray  # +-1 along x, from the guide to where the cable lies on the drum
    friction: float
    stiffness: float  # E A in N


def chain_of(drive: Drive) -> Chain:
    """The chain of a design."""
    sense, input_of, spans, units = [], [], [], []
    for run in drive.cables:
        index = drive.input_names.index(run.input_name)
        centre = np.array([run.input_side * drive.centre_distance_mm * 1e-3, 0.0])
        r_g, r_i = run.guide_radius_mm * 1e-3, run.input_radius_mm * 1e-3
        # The cable ends at the top (+y) of the guide and goes off along x: going round clockwise it leaves towards +x.
        clockwise = run.drum_side > 0
        guide_point, input_point = _internal_tangent(centre, r_g, r_i, clockwise)
        reach = input_point - guide_point
        spans.append(float(np.hypot(*reach)))
        units.append(reach / spans[-1])
        sense.append(-float(run.drum_side))
        input_of.append(index)
    metre = 1e-3
    return Chain(
        sense=np.array(sense),
        input_of=np.array(input_of, dtype=np.int64),
        r_in=np.array([run.input_radius_mm for run in drive.cables]) * metre,
        r_guide=np.array([run.guide_radius_mm for run in drive.cables]) * metre,
        r_drum=np.array([run.drum_radius_mm for run in drive.cables]) * metre,
        preload=np.array([run.preload_N for run in drive.cables]),
        span=np.array(spans),
        to_input=np.array(units),
        to_drum=np.array([float(run.drum_side) for run in drive.cables]),
        friction=drive.friction_coefficient,
        stiffness=drive.cable.modulus_GPa * 1e9 * drive.cable.area_mm2 * 1e-6,
    )


def _internal_tangent(centre: np.ndarray, r_g: float, r_i: float, clockwise: bool) -> tuple[np.ndarray, np.ndarray]:
    """Tangent points on guide and input pulley of a crossed belt on whose guide the cable goes round ``clockwise``.

    The cable comes in from the input at the guide's tangent point and moves on round the guide to its top.
    """
    distance = float(np.hypot(*centre))
    bearing = np.arctan2(centre[1], centre[0])
    half = np.arccos((r_g + r_i) / distance)
    for side in (1.0, -1.0):
        normal = np.array([np.cos(bearing + side * half), np.sin(bearing + side * half)])
        on_guide, on_input = r_g * normal, centre - r_i * normal
        towards_guide = on_guide - on_input
        turns_clockwise = (normal[0] * towards_guide[1] - normal[1] * towards_guide[0]) < 0.0
        if turns_clockwise == clockwise:
            return on_guide, on_input
    raise ValueError("no crossed tangent: centre distance is too short")


def path_of_eccentric(chain: Chain, stage: str, e_m: float, phase_rad: float, shaft_angle: np.ndarray) -> np.ndarray:
    """Change of each cable's path (m), shape (cables, n), when the pulley's centre runs round its axis.

    The centre is off by ``e_m`` at the direction ``shaft_angle + phase``, measured from +x in the plane of rotation
    (for the drum: from +x towards the transfer point's outward direction). Zero where every shaft is at zero.
    """

    def offset(angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return e_m * np.cos(angle + phase_rad), e_m * np.sin(angle + phase_rad)

    def path(angle: np.ndarray) -> np.ndarray:
        x, y = offset(angle)
        rows = np.zeros((chain.sense.size, np.size(angle)))
        for j in range(chain.sense.size):
            if stage == "drum":
                rows[j] = chain.to_drum[j] * x
            elif stage == "guide":
                # Both spans that touch it: moving away from where a span leads makes that span longer.
                rows[j] = -(chain.to_input[j, 0] * x + chain.to_input[j, 1] * y) - chain.to_drum[j] * x
            elif stage == f"input_{chain.input_of[j]}":
                rows[j] = chain.to_input[j, 0] * x + chain.to_input[j, 1] * y
        return rows

    return path(np.asarray(shaft_angle)) - path(np.zeros(1))
