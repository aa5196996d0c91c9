"""Realistic runs: servos that track differently, sensors with more noise than their steps, loggers with jitter.

    run = simulate_real(drive, "pulley_guide", seed=4)

The cables are those of bench_chain.py. The errors of the bench are drawn by the seed, and the measurement file declares
only the steps of the encoders, as data sheets do. ``Traits`` contains all drawn values; the loop never sees it.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from mbcdm_cad.design.drive import Drive
from tests.support import bench_effects
from tests.support.bench_cases import CASES, Case
from tests.support.bench_data import Simulated, drum_angle, stream
from tests.support.bench_motion import (
    INPUT_STEP_RAD,
    OUTPUT_STEP_RAD,
    RATE_HZ,
    TORQUE_NOISE_NM,
    Bench,
    Chain,
    Plan,
    bench_run,
    chain_of,
)

LOADS = ("brake", "levels", "bias", "steps", "pendulum", "spring", "hand", "motor")
# Loads that do not follow the motion, on which effects of the load are told from each other.
FREE_LOADS = ("bias", "steps", "hand", "motor")
# One bench in seven logs faster than 200 Hz.
RATES_HZ = (*(50.0,) * 4, *(100.0,) * 8, *(200.0,) * 6, 500.0, 1000.0, 2000.0)
# RMS that the declared steps alone put into the residual, rad at the drum, for the reference drive.
DECLARED_FLOOR_RAD = 4.37e-6


@dataclass(frozen=True)
class Traits:
    """What one bench does beside what it is told to do; angles in rad at the drum."""

    rate_hz: float
    jitter: float
    gaps: int
    tracking_rad: tuple[float, ...]
    tracking_hz: tuple[float, float]
    load_lag_rad_Nm: tuple[float, ...]
    white_rad: float
    coloured_rad: float
    memory_s: float
    drift_rad: float
    torque_noise_Nm: float

    @property
    def floor_rad(self) -> float:
        """RMS that steps and noise put into the residual."""
        return float(np.sqrt(DECLARED_FLOOR_RAD**2 + self.white_rad**2 + self.coloured_rad**2 + self.drift_rad**2 / 3))


def draw_traits(rng: np.random.Generator, inputs: int = 2) -> Traits:
    """A bench. The whole noise is 1 to 8 times what the steps make, most often 1 to 3."""

    def spread(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    whole = DECLARED_FLOOR_RAD * float(np.clip(np.exp(abs(rng.normal(0.0, 0.9))), 1.02, 8.0))
    extra = np.sqrt(whole**2 - DECLARED_FLOOR_RAD**2)
    coloured = extra * float(np.sqrt(rng.uniform(0.0, 0.5)))
    slowest = spread(0.1, 0.5)
    return Traits(
        rate_hz=float(rng.choice(RATES_HZ)),
        jitter=float(rng.choice([0.0, 0.05, 0.2])),
        gaps=int(rng.choice([0, 0, 0, 1, 3])),
        tracking_rad=tuple(spread(5e-6, 40e-6) for _ in range(inputs)),
        tracking_hz=(slowest, spread(max(1.0, 2.0 * slowest), 3.0)),
        load_lag_rad_Nm=tuple(rng.uniform(0.0, 30e-6) for _ in range(inputs)),
        white_rad=float(np.sqrt(extra**2 - coloured**2)),
        coloured_rad=coloured,
        memory_s=spread(0.05, 3.0),
        drift_rad=float(rng.choice([0.0, 0.0, 1e-6, 2e-6])),
        torque_noise_Nm=TORQUE_NOISE_NM * spread(1.0, 4.0),
    )


def tracked(bench: Bench, ratio: float, traits: Traits, rng: np.random.Generator) -> Bench:
    """The bench with servos that follow their targets each in its own way, more loosely under load."""
    t, rows = bench.time_s, []
    slow_load = _lagged(bench.load_Nm, 0.08)
    begun = 1.0 - np.exp(-t / 0.5)
    for amplitude, lag, row in zip(traits.tracking_rad, traits.load_lag_rad_Nm, bench.input_rad, strict=True):
        waves = np.zeros_like(t)
        for _ in range(4):
            low, high = np.log(traits.tracking_hz[0]), np.log(traits.tracking_hz[1])
            beat = 1.0 + 0.5 * np.sin(2.0 * np.pi * t / rng.uniform(20.0, 60.0) + rng.uniform(0.0, 6.28))
            waves += beat * np.sin(2.0 * np.pi * np.exp(rng.uniform(low, high)) * t + rng.uniform(0.0, 6.28))
        # Peaks of the sum are near the amplitude that was drawn.
        rows.append(row + ratio * begun * (0.4 * amplitude * waves - lag * slow_load))
    return replace(bench, input_rad=np.array(rows))


def _lagged(values: np.ndarray, time_s: float) -> np.ndarray:
    """First-order lag."""
    out, keep = np.empty_like(values), np.exp(-1.0 / (RATE_HZ * time_s))
    now = values[0]
    for k, value in enumerate(values):
        now = keep * now + (1.0 - keep) * value
        out[k] = now
    return out


def loaded(bench: Bench, plan: Plan, rng: np.random.Generator) -> Bench:
    """The bench with one of the loads that bench_motion.py does not have."""
    t, drum = bench.time_s, np.cumsum(bench.speed_rad_s) / RATE_HZ
    if plan.load == "pendulum":
        load = plan.load_Nm * np.sin(drum + rng.uniform(-0.5, 0.5)) / np.sin(0.7)
    elif plan.load == "spring":
        load = plan.load_Nm * (drum / max(np.ptp(drum), 0.2) * 1.5 + rng.uniform(-0.4, 0.4))
    elif plan.load == "hand":
        at = np.arange(0.0, t[-1] + 4.0, rng.uniform(1.5, 3.5))
        load = CubicSpline(at, plan.load_Nm * rng.uniform(-0.9, 0.9, at.size))(t)
    elif plan.load == "motor":
        load = plan.load_Nm * np.sin(2.0 * np.pi * t * rng.uniform(0.11, 0.37)) + 0.3 * rng.uniform(-1.0, 1.0)
    else:
        return bench
    return replace(bench, load_Nm=load - load[0] * np.exp(-t / 0.3))


def logged(run: Simulated, traits: Traits, ratio: float, rng: np.random.Generator) -> Simulated:
    """The run as the logger of the bench shows it."""
    bench = run.bench
    n = int((bench.time_s[-1]) * traits.rate_hz)
    t = (np.arange(n) + traits.jitter * rng.uniform(-0.5, 0.5, n)) / traits.rate_hz
    keep = np.ones(n, dtype=bool)
    for _ in range(traits.gaps):
        begin = rng.uniform(0.1, 0.9) * t[-1]
        keep &= (t < begin) | (t > begin + rng.uniform(0.05, 0.5))
    t = np.clip(t[keep], 0.0, bench.time_s[-1])
    inputs = np.array([CubicSpline(bench.time_s, row)(t) for row in bench.input_rad])
    drum = CubicSpline(bench.time_s, run.drum_rad)(t)
    drum = drum + rng.normal(0.0, 1.0, t.size) * traits.white_rad * 0.6 + _coloured(t, traits, rng)
    slow = traits.drift_rad * (t / t[-1] - 0.5) * rng.choice([-1.0, 1.0])
    # Part of the white noise is the inputs'.
    share = 0.8 * traits.white_rad * ratio * np.sqrt(inputs.shape[0])
    inputs = inputs + rng.normal(0.0, share, inputs.shape)

    def counts(values: np.ndarray, step: float) -> np.ndarray:
        shift = rng.uniform(0.0, 1.0)
        return (np.round(values / step + shift) - round(shift)) * step

    sensed = {
        "inputs": np.array([counts(row, INPUT_STEP_RAD) for row in inputs]),
        "output": counts(drum + slow, OUTPUT_STEP_RAD),
        "torque": np.interp(t, bench.time_s, bench.load_Nm) + rng.normal(0.0, traits.torque_noise_Nm, t.size),
        "temperature": np.interp(t, bench.time_s, bench.air_degC) + rng.normal(0.0, 0.03, t.size),
    }
    seen = Bench(t, sensed["inputs"], sensed["torque"], np.zeros(0), np.zeros(0))
    return replace(run, bench=seen, drum_rad=sensed["output"], sensed=sensed)


def _coloured(t: np.ndarray, traits: Traits, rng: np.random.Generator) -> np.ndarray:
    """Noise with a memory."""
    out, now = np.empty(t.size), rng.normal()
    keep = np.exp(-np.diff(t, prepend=t[0]) / traits.memory_s)
    kick = np.sqrt(1.0 - keep**2) * rng.normal(size=t.size)
    for k in range(t.size):
        now = keep[k] * now + kick[k]
        out[k] = now
    return traits.coloured_rad * out


def _motion(loads: tuple[str, ...], waves: tuple[str, ...] = ("triangle", "sine")) -> object:
    def draw(rng: np.random.Generator) -> Plan:
        return Plan(
            amplitude_rad=float(rng.choice([0.3, 0.45, 0.6])),
            load=str(rng.choice(loads)),
            load_Nm=float(rng.uniform(0.6, 1.0)),
            wave=str(rng.choice(waves)),
            frequency_hz=float(rng.choice([0.05, 0.0625, 0.1, 0.125])),
            duration_s=float(rng.choice([100.0, 160.0])),
        )

    return draw


ANY, FREE, SINE = _motion(LOADS), _motion(FREE_LOADS), _motion(FREE_LOADS, ("sine",))
LARGE = {
    "preload_low": Case(FREE, bench_effects.shares("preload_error", "preload", 0.35, 0.6, cables=bench_effects.ALL)),  # type: ignore[arg-type]
    "modulus_low": Case(FREE, bench_effects.shares("stiffness_error", "modulus", 0.25, 0.4)),  # type: ignore[arg-type]
    "mu_low": Case(FREE, bench_effects.shares("cable_friction", "mu", 0.35, 0.5)),  # type: ignore[arg-type]
    "lash_left": Case(FREE, bench_effects.size("lash", "input_play", "play_rad", 1e-3, 6e-3, stage="input_left")),  # type: ignore[arg-type]
    "lash_right": Case(FREE, bench_effects.size("lash", "input_play", "play_rad", 1e-3, 6e-3, stage="input_right")),  # type: ignore[arg-type]
}


def _lowered(draw: bench_effects.Draw) -> bench_effects.Draw:
    """Shares made negative: ropes and preloads lose, they do not gain."""

    def lowered(rng: np.random.Generator, plan: Plan) -> tuple[bench_effects.Effect, ...]:
        return tuple(replace(e, size={"share": -abs(e.size["share"])}) for e in draw(rng, plan))

    return lowered


for _name in ("preload_low", "modulus_low", "mu_low"):
    LARGE[_name] = replace(LARGE[_name], effects=_lowered(LARGE[_name].effects))


def _of(name: str, plan: object = FREE) -> Case:
    return replace(CASES[name], plan=plan)  # type: ignore[arg-type]


# Sizes that the noise of most benches hides.
SMALL = {
    "small_guide": Case(FREE, bench_effects.pulley("guide", 0.3, 1.5)),  # type: ignore[arg-type]
    "small_ratio": Case(ANY, bench_effects.shares("ratio_error", "output_scale", 1e-5, 5e-5)),  # type: ignore[arg-type]
    "small_modulus": Case(FREE, bench_effects.shares("stiffness_error", "modulus", 0.01, 0.04)),  # type: ignore[arg-type]
    "small_friction": Case(SINE, bench_effects.size("friction", "bearing", "torque_Nm", 0.005, 0.03)),  # type: ignore[arg-type]
    "small_delay": Case(SINE, bench_effects.size("delay", "latency", "delay_s", 2e-5, 1e-4)),  # type: ignore[arg-type]
    "small_ripple": Case(ANY, bench_effects.ripple((20.0, 500.0), 1e-6, 5e-6)),  # type: ignore[arg-type]
}
_SINGLE = {
    **{
        name: _of(name)
        for name in (
            "pulley_drum",
            "pulley_guide",
            "pulley_input_left",
            "pulley_input_right",
            "stiffness_modulus",
            "stiffness_shaft",
            "preload_all",
            "cable_friction",
            "lash_output",
            "lash_input_left",
            "slip_anchor",
            "slip_mount",
            "thermal",
            "creep",
        )
    },
    **{name: _of(name, SINE) for name in ("friction", "delay", "drag")},
    **{name: _of(name, ANY) for name in ("ratio_radii", "ratio_encoder", "ripple_slow", "ripple_fast")},
    "encoder_guide": Case(FREE, bench_effects.pulley("guide", 3.0, 12.0)),  # type: ignore[arg-type]
    "encoder_left": Case(FREE, bench_effects.input_encoder("input_left", 4e-4, 1.5e-3), "fair"),  # type: ignore[arg-type]
    "encoder_drum": Case(FREE, bench_effects.output_encoder(2e-4, 6e-4)),  # type: ignore[arg-type]
}
_PAIRS = (
    ("slip_mount", "ratio_encoder"),
    ("creep", "pulley_guide"),
    ("lash_output", "ripple_slow"),
    ("drag", "encoder_drum"),
    ("mu_low", "ratio_radii"),
    ("modulus_low", "encoder_left"),
    ("preload_all", "ripple_fast"),
    ("pulley_guide", "ratio_encoder"),
    ("ripple_fast", "friction"),
    ("stiffness_modulus", "ripple_slow"),
    ("preload_low", "pulley_guide"),
    ("lash_left", "lash_right"),
    ("thermal", "pulley_input_right"),
    ("delay", "stiffness_shaft"),
    ("friction", "ratio_radii"),
)
_THREES = (
    ("pulley_guide", "ratio_encoder", "friction"),
    ("stiffness_modulus", "ripple_fast", "delay"),
    ("ratio_radii", "ripple_slow", "slip_mount"),
    ("preload_low", "ratio_encoder", "delay"),
    ("pulley_input_left", "stiffness_shaft", "thermal"),
)


def _together(names: tuple[str, ...], group: str) -> Case:
    known = _SINGLE | LARGE
    draw = known[names[0]].effects
    for name in names[1:]:
        draw = bench_effects.both(draw, known[name].effects)
    return Case(SINE, draw, group, any(known[name].temperature for name in names))  # type: ignore[arg-type]


REAL_CASES: dict[str, Case] = {
    **{f"null_{load}": Case(_motion((load,)), bench_effects.nothing, "null") for load in LOADS},  # type: ignore[arg-type]
    "null_texture": Case(ANY, CASES["null_texture"].effects, "texture"),  # type: ignore[arg-type]
    **_SINGLE,
    **LARGE,
    **SMALL,
    **{"+".join(names): _together(names, "pair") for names in _PAIRS},
    **{"+".join(names): _together(names, "three") for names in _THREES},
    **{
        name: _of(name)
        for name in (
            "out_strand",
            "out_climbing",
            "out_worn_land",
            "out_hardening",
            "out_square",
            "out_stick_slip",
            "out_wander",
        )
    },
}


@dataclass(frozen=True)
class Truth:
    """What is true of one run: the bench, its true signals before any sensor, the effects at work."""

    plan: Plan
    traits: Traits
    chain: Chain
    bench: Bench
    effects: tuple[bench_effects.Effect, ...]
    temperature: bool

    @property
    def ratio(self) -> float:
        """Turns of the inputs for one of the drum."""
        return float(np.mean(self.chain.r_drum / self.chain.r_in))

    @property
    def columns(self) -> tuple[str, ...]:
        """What the logger writes."""
        return ("inputs", "output", "torque", *(("temperature",) if self.temperature else ()))


def truth_of(drive: Drive, name: str, seed: int) -> Truth:
    """What the seed draws for one run of a case."""
    case, key = REAL_CASES[name], f"real/{name}"
    plan = case.plan(stream(key, seed, "plan"))
    inputs = len(drive.input_names)
    traits = draw_traits(stream(key, seed, "traits"), inputs)
    chain = chain_of(drive)
    ratio = float(np.mean(chain.r_drum / chain.r_in))
    bench = loaded(bench_run(plan, ratio, inputs, stream(key, seed, "motion")), plan, stream(key, seed, "load"))
    bench = tracked(bench, ratio, traits, stream(key, seed, "tracking"))
    effects = case.effects(stream(key, seed, "effects"), plan)
    return Truth(plan, traits, chain, bench, effects, case.temperature)


def simulate_real(drive: Drive, name: str, seed: int, without_effects: bool = False) -> Simulated:
    """One run of a bench. ``without_effects``: the same bench, motion, load and noise."""
    truth, key = truth_of(drive, name, seed), f"real/{name}"
    effects = () if without_effects else truth.effects
    drum = drum_angle(truth.chain, drive.input_names, truth.bench, effects, stream(key, seed, "wander"))
    run = Simulated(truth.plan, truth.bench, drum, {}, effects, truth.columns)
    return logged(run, truth.traits, truth.ratio, stream(key, seed, "sensors"))
