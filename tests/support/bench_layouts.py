"""Benches of all layouts whose own sensors err, whose drive changes in mid-run, or that have causes without a name.

    drive, run, truth = made("single", "modulus", seed=90_000)

Runs of the quasi-static rig, which shares no code with the loop's model, on the four reference designs in turn. What
the rig does not have is done to its readings here: sensors of the bench that err, noise beyond the declared steps,
and causes that the loop has no name for. A run that changes is two runs of the same seed, with the effect from a time
on.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import uniform_filter1d

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.measurement.run import KNOWN_LOAD, Run, Sensors, TorqueClass
from mbcdm_cad.measurement.schema import CountedParts
from mbcdm_cad.rig.experiment import Experiment, counted_parts
from mbcdm_cad.rig.quasistatic import simulate
from tests.support.reference import ROOT

Floats = np.ndarray
Rng = np.random.Generator
DESIGNS = ("mbcdm", "siso_spur", "siso_bevel", "miso_spur")
# Largest load as a share of what the preloads would carry at the drum if all acted one way.
LOAD_SHARE = 0.1
STEPS_RAD, TORQUE_NOISE_SHARE = (1.9175e-4, 1.3635e-6), 0.005


@dataclass(frozen=True)
class Bench:
    """One drawn bench: the drive, its experiment without effects, and what its sensors do besides."""

    drive: Drive
    experiment: dict[str, Any]
    most_Nm: float
    noise: float
    stages: tuple[str, ...]  # of the inputs

    def run(self, effects: list[dict[str, Any]]) -> tuple[Run, list[dict[str, Any]]]:
        """The readings with these effects of the rig, and the truth."""
        wanted = Experiment.model_validate({**self.experiment, "effects": effects})
        made = simulate(self.drive, wanted)
        s, counted = wanted.sensors, counted_parts(wanted)
        known = TorqueClass(lag_s=0.0, what=KNOWN_LOAD)
        load = np.zeros(made.time_s.size) if wanted.load.kind == "none" else made.measured_load_Nm
        usual = known if wanted.load.kind == "none" else TorqueClass()
        sensors = Sensors(*STEPS_RAD, s.torque_noise_Nm, torque_class=usual)
        names = tuple(self.drive.input_names) if len(self.drive.input_names) > 1 else ("input",)
        parts = CountedParts.model_validate(counted) if counted else None
        temperature, angles = made.measured_temperature_C, (made.measured_input_rad, made.measured_output_rad)
        run = Run(made.time_s, *angles, load, temperature, sensors, names, "run.csv", counted=parts)
        return run, list(made.truth)


def bench_of(seed: int, loads: tuple[str, ...], parts: bool) -> tuple[Bench, Rng]:
    """A bench, and the random numbers that are left for its errors."""
    rng = np.random.default_rng([seed, 351])
    drive = load_design(ROOT / "params" / f"{DESIGNS[seed % 4]}.yaml").drive
    most = LOAD_SHARE * sum(c.preload_N * c.drum_radius_mm * 1e-3 for c in drive.cables) * float(rng.uniform(0.7, 1.0))
    sweeps, duration = int(rng.integers(14, 30)), float(rng.choice([100.0, 160.0]))
    noise = float(np.clip(np.exp(abs(rng.normal(0.0, 0.7))), 1.0, 4.0))
    kind, levels = str(rng.choice(loads)), [round(share * most, 4) for share in (0.2, 0.5, 1.0, 0.7)]
    load: dict[str, Any] = {"kind": "torque_motor", "levels_Nm": [most], "wave": "sine"}
    load["wave_period_s"] = duration / float(rng.uniform(9.0, 14.0))
    if kind == "square":
        load |= {"wave": "square"}
    elif kind == "brake":
        load = {"kind": "brake", "levels_Nm": levels, "bias_Nm": round(float(rng.uniform(0.0, 0.4)) * most, 4)}
    elif kind == "none":
        load = {"kind": "none"}
    experiment = {
        "name": f"bench-{seed}",
        "seed": seed,
        "duration_s": duration,
        "sample_rate_Hz": float(rng.choice([50.0, 100.0, 100.0, 200.0])),
        "motion": {
            "shape": str(rng.choice(["sine", "sine", "triangle"])),
            "amplitude_mrad": 1e3 * min(np.radians(drive.half_travel_deg) * float(rng.uniform(0.6, 0.9)), 1.2),
            "period_s": 2.0 * duration / sweeps,
            "stray_urad": float(rng.uniform(20.0, 150.0)),
        },
        "load": load,
        "physics": {"cable_transport": False, "structure": parts, "losses": parts},
        "sensors": {
            "input_noise_rad": float(STEPS_RAD[0] * 0.29 * (noise - 1.0)),
            "output_noise_rad": float(4.4e-6 * (noise - 1.0)),
            "torque_noise_Nm": TORQUE_NOISE_SHARE * most,
        },
    }
    return Bench(drive, experiment, most, noise, tuple(f"input_{n}" for n in drive.input_names)), rng


Done = tuple[Run, list[dict[str, Any]]]
Case = Callable[[Bench, Rng], Done]


def of_rig(*draws: Callable[[Bench, Rng], dict[str, Any]], after: Callable[..., Done] | None = None) -> Case:
    """Effects of the rig, then an error of the bench."""

    def case(bench: Bench, rng: Rng) -> Done:
        run, truth = bench.run([draw(bench, rng) for draw in draws])
        if after is None:
            return run, truth
        run, more = after(bench, rng, run)
        return run, truth + more

    return case


def effect(name: str, **sizes: Any) -> Callable[[Bench, Rng], dict[str, Any]]:
    """An effect of the rig: (low, high) is drawn, on a scale of logarithms where both have one sign."""

    def draw(bench: Bench, rng: Rng) -> dict[str, Any]:
        found: dict[str, Any] = {"effect": name}
        for key, size in sizes.items():
            if callable(size):
                found[key] = size(bench, rng)
            elif isinstance(size, tuple):
                low, high = size
                sign = -1.0 if high < 0.0 else 1.0
                same = low * high > 0.0
                found[key] = (
                    sign * float(np.exp(rng.uniform(*sorted(np.log(np.abs(size))))))
                    if same
                    else float(rng.uniform(low, high))
                )
            else:
                found[key] = size
        return found

    return draw


def an_input(bench: Bench, rng: Rng) -> str:
    """One of the inputs."""
    return str(rng.choice(bench.stages))


def _told(name: str, stage: str | None = None, **parameters: float) -> list[dict[str, Any]]:
    return [{"name": name, "in_vocabulary": True, "stage": stage, "parameters": parameters}]


def _unnamed(name: str) -> list[dict[str, Any]]:
    return [{"name": name, "in_vocabulary": False, "parameters": {}}]


def torque_within(bench: Bench, rng: Rng, run: Run) -> Done:
    """Gain, zero and filter of the torque sensor within a usual class: no effect."""
    gain, zero = rng.uniform(-0.008, 0.008), rng.uniform(-0.006, 0.006) * bench.most_Nm
    return replace(run, load_Nm=filtered((1.0 + gain) * run.load_Nm + zero, run, rng.uniform(0.0, 0.008))), []


def filtered(values: Floats, run: Run, lag_s: float) -> Floats:
    """A low-pass of first order."""
    keep = float(np.exp(-run.step_s / max(lag_s, 1e-9)))
    out = np.empty_like(values)
    now = values[0]
    for k, value in enumerate(values):
        now = keep * now + (1.0 - keep) * value
        out[k] = now
    return out


def torque_zero(bench: Bench, rng: Rng, run: Run) -> Done:
    zero = float(rng.choice([-1.0, 1.0]) * rng.uniform(0.05, 0.12)) * bench.most_Nm
    return replace(run, load_Nm=run.load_Nm + zero), _told("load_zero", zero_Nm=zero)


def torque_lag(bench: Bench, rng: Rng, run: Run) -> Done:
    lag = float(rng.uniform(0.06, 0.15))
    # A slow signal comes out later by less than the time constant, since the filter works in steps.
    late = run.step_s / (np.exp(run.step_s / lag) - 1.0)
    return replace(run, load_Nm=filtered(run.load_Nm, run, lag)), _told("load_lag", lag_s=float(late))


def late_input(bench: Bench, rng: Rng, run: Run) -> Done:
    late = float(rng.uniform(1e-3, 4e-3))
    # A chord between two samples would cut the corners of the motion: a wrong ratio, of some parts in a million.
    seen = CubicSpline(run.time_s, run.input_rad, axis=1)(np.maximum(run.time_s - late, run.time_s[0]))
    return replace(run, input_rad=seen), _told("delay", delay_s=-late)


def lost(bench: Bench, rng: Rng, run: Run) -> Done:
    share = float(rng.choice([-1.0, 1.0]) * rng.uniform(1e-5, 6e-5))
    path = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(run.input_rad[0])))]) / float(np.mean(ratios(bench)))
    return replace(run, output_rad=run.output_rad + share * path), _told("lost_counts", share=share)


def ratios(bench: Bench) -> Floats:
    """Turns of each input for one of the drum."""
    return np.atleast_1d(np.asarray(layout_of(bench.drive).si.total_ratio, dtype=float))


def twice(bench: Bench, rng: Rng, run: Run) -> Done:
    k, size, phase = int(rng.integers(run.input_rad.shape[0])), rng.uniform(4e-4, 1.2e-3), rng.uniform(0.0, 6.28)
    rows = run.input_rad.copy()
    rows[k] += size * np.cos(2.0 * rows[k] + phase)
    return replace(run, input_rad=rows), _told("twice_per_rev", bench.stages[k], encoder_error_rad=float(size))


def changes(draw: Callable[[Bench, Rng], dict[str, Any]]) -> Case:
    """An effect that begins in mid-run."""

    def case(bench: Bench, rng: Rng) -> Done:
        one = draw(bench, rng)
        (before, _), (after, truth) = bench.run([]), bench.run([one])
        at = float(rng.uniform(0.35, 0.65)) * float(before.time_s[-1])
        late = before.time_s >= at
        output = np.where(late, after.output_rad, before.output_rad)
        rows = np.where(late, after.input_rad, before.input_rad)
        told = [{**entry, "changes": True, "parameters": {**entry["parameters"], "at_s": at}} for entry in truth]
        return replace(before, output_rad=output, input_rad=rows), told

    return case


def output_adds(name: str, of: Callable[[Bench, Rng, Run, Floats], Floats]) -> Callable[..., Done]:
    """A cause without a name, of 30 to 80 urad RMS in the reading of the output."""

    def after(bench: Bench, rng: Rng, run: Run) -> Done:
        shape = of(bench, rng, run, run.input_rad.mean(axis=0) / float(np.mean(ratios(bench))))
        size = float(rng.uniform(30e-6, 80e-6)) / float(np.std(shape))
        return replace(run, output_rad=run.output_rad + size * shape), _unnamed(name)

    return after


def speed_squared(bench: Bench, rng: Rng, run: Run, drum: Floats) -> Floats:
    return np.asarray(np.convolve(np.gradient(drum, run.time_s), np.full(9, 1.0 / 9.0), "same") ** 2)


def bent_frame(bench: Bench, rng: Rng, run: Run, drum: Floats) -> Floats:
    return np.asarray(run.load_Nm**2)


def bump(bench: Bench, rng: Rng, run: Run, drum: Floats) -> Floats:
    at, width = rng.uniform(-0.5, 0.5) * np.abs(drum).max(), rng.uniform(0.03, 0.08) * np.ptp(drum)
    return np.asarray(np.exp(-0.5 * ((drum - at) / width) ** 2))


def climbing(bench: Bench, rng: Rng, run: Run, drum: Floats) -> Floats:
    at, width = rng.uniform(-0.4, 0.4) * np.abs(drum).max(), 0.02 * np.ptp(drum)
    lag = np.where(np.gradient(drum) > 0.0, 0.0, rng.uniform(0.05, 0.15) * np.ptp(drum))
    return np.asarray(np.tanh((drum - at + lag) / width))


def rubbing(bench: Bench, rng: Rng, run: Run, drum: Floats) -> Floats:
    """A cable rubs on an edge over part of the travel."""
    at, sense = rng.uniform(-0.3, 0.5) * np.abs(drum).max(), np.gradient(drum, run.time_s)
    return np.asarray(-np.tanh(sense / (0.05 * np.abs(sense).max())) * (drum > at))


def slipping(bench: Bench, rng: Rng, run: Run, drum: Floats) -> Floats:
    """A coupling slips while the load is above what it holds, more one way than the other."""
    over = np.abs(run.load_Nm) - rng.uniform(0.6, 0.85) * np.abs(run.load_Nm).max()
    way = np.where(run.load_Nm > 0.0, 1.0, rng.uniform(0.2, 0.9))
    return np.asarray(np.cumsum(np.maximum(over, 0.0) * way * np.sign(run.load_Nm)))


def joint_opens(bench: Bench, rng: Rng, run: Run, drum: Floats) -> Floats:
    """A bolted joint gives once its preload is overcome, one way."""
    return np.asarray(np.maximum(run.load_Nm - rng.uniform(0.2, 0.6) * run.load_Nm.max(), 0.0))


def rubber_mount(bench: Bench, rng: Rng, run: Run, drum: Floats) -> Floats:
    """A mount that gives to the load with some seconds of delay."""
    return filtered(run.load_Nm, run, float(rng.uniform(1.5, 6.0)))


def fan(bench: Bench, rng: Rng, run: Run, drum: Floats) -> Floats:
    """The mount of an encoder is warmed by the motor, and cooled while a fan runs."""
    on = np.sin(2.0 * np.pi * run.time_s / rng.uniform(25.0, 60.0) + rng.uniform(0.0, 6.28)) > 0.0
    return filtered(on.astype(float), run, float(rng.uniform(5.0, 20.0)))


def crosstalk(bench: Bench, rng: Rng, run: Run) -> Done:
    """The torque sensor's reading hangs on its angle too."""
    waves, size = rng.uniform(4.0, 9.0), 0.15 * bench.most_Nm
    wave = np.sin(run.output_rad * waves + rng.uniform(0.0, 6.28))
    told = _told("load_crosstalk", amplitude_Nm=size, cycles_per_output_rev=float(waves))
    return replace(run, load_Nm=run.load_Nm + size * wave), told


def torque_hysteresis(bench: Bench, rng: Rng, run: Run) -> Done:
    """The torque sensor lags behind the load by a width, as one with play in its clamps."""
    width = 0.06 * bench.most_Nm
    return replace(run, load_Nm=played(run, width)), _told("load_hysteresis", half_width_Nm=width)


def played(run: Run, width: float) -> Floats:
    """The reading of the load behind a play of half a width ``width``, N m."""
    out, now = np.empty(run.time_s.size), 0.0
    # The noise of the reading comes after the play, which it would make narrower.
    quiet = uniform_filter1d(run.load_Nm, 15)
    for k, load in enumerate(quiet):
        now = min(max(now, load - width), load + width)
        out[k] = now
    return np.asarray(out + run.load_Nm - quiet)


def all_within(bench: Bench, rng: Rng, run: Run) -> Done:
    """A torque sensor wrong in all it can be wrong by, each within a usual class: no effect."""
    wave = np.sin(run.output_rad * rng.uniform(1.0, 9.0) + rng.uniform(0.0, 6.28))
    load = run.load_Nm + float(rng.uniform(0.002, 0.005)) * bench.most_Nm * wave
    load = played(replace(run, load_Nm=load), float(rng.uniform(0.001, 0.004)) * bench.most_Nm)
    return torque_within(bench, rng, replace(run, load_Nm=load))


def broken_strand(bench: Bench, rng: Rng, run: Run, drum: Floats) -> Floats:
    """A strand breaks half way through the run: a thick place of the cable from then on."""
    return np.asarray(bump(bench, rng, run, drum) * (run.time_s > rng.uniform(0.4, 0.6) * run.time_s[-1]))


def wear(bench: Bench, rng: Rng, run: Run, drum: Floats) -> Floats:
    """A stretch of a land wears while the drive runs: the drum turns further there with every pass."""
    at, length = rng.uniform(-0.5, 0.1) * np.abs(drum).max(), rng.uniform(0.1, 0.3) * np.ptp(drum)
    return np.asarray(np.clip(drum - at, 0.0, length) * run.time_s)


def one_soft_mount(bench: Bench, rng: Rng, run: Run, drum: Floats) -> Floats:
    """One of three rubber mounts is soft: what the frame gives to the load depends on where the payload stands."""
    return np.asarray(filtered(run.load_Nm * np.cos(drum + rng.uniform(0.0, 6.28)), run, 1.0))


MODULUS, PRELOAD = effect("modulus", share=(-0.3, -0.15)), effect("preload", share=(-0.6, -0.4))
FRICTION = effect("bearing_friction", drum_mNm=lambda b, r: 1e3 * float(r.uniform(0.1, 0.25)) * b.most_Nm)
SCALE = effect("encoder_scale", stage="drum", share_ppm=(200.0, 800.0))
DRUM_DISC = effect("eccentric_encoder", stage="drum", amplitude_urad=(200.0, 600.0), phase_deg=(20.0, 160.0))
INPUT_DISC = effect("eccentric_encoder", stage=an_input, amplitude_urad=(600.0, 2000.0), phase_deg=(-180.0, 180.0))
LINES = effect("encoder_subdivision", stage="drum", amplitude_urad=(20.0, 60.0), cycles_per_rev=(40.0, 300.0))
DELAY = effect("sensor_delay", sensor="output", delay_ms=(1.0, 4.0))
PULLEY = effect("eccentric_pulley", stage="drum", eccentricity_um=(15.0, 50.0), phase_deg=(20.0, 160.0))
SHAFT = effect("shaft_compliance", compliance_urad_Nm=lambda b, r: float(r.uniform(50.0, 150.0)) / b.most_Nm)
SLIP = effect("anchor_slip", cable=lambda b, r: b.drive.cables[0].name, at_s=(30.0, 70.0), slip_um=(15.0, 40.0))
LASH = effect("gearhead_lash", stage=an_input, play_urad=(2500.0, 6000.0))

GROUPS: dict[str, dict[str, Case]] = {
    "null": {
        "clean": of_rig(),
        "torque sensor within its class": of_rig(after=torque_within),
        "no load": of_rig(),
        "structure and losses": of_rig(),
    },
    "single": {
        "modulus": of_rig(MODULUS),
        "torque zero": of_rig(after=torque_zero),
        "preload": of_rig(PRELOAD),
        "late input": of_rig(after=late_input),
        "friction": of_rig(FRICTION),
        "lost counts": of_rig(after=lost),
        "input disc": of_rig(INPUT_DISC),
        "torque lag": of_rig(after=torque_lag),
        "scale": of_rig(SCALE),
        "modulus changes": changes(MODULUS),
        "lines": of_rig(LINES),
        "twice a turn": of_rig(after=twice),
        "drum disc": of_rig(DRUM_DISC),
        "friction changes": changes(FRICTION),
        "shaft": of_rig(SHAFT),
        "delay": of_rig(DELAY),
        "lash": of_rig(LASH),
        "pulley": of_rig(PULLEY),
        "slip": of_rig(SLIP),
        "modulus, torque sensor within its class": of_rig(MODULUS, after=torque_within),
        "friction, no load": of_rig(DRUM_DISC),
        "modulus, structure and losses": of_rig(MODULUS),
    },
    "pair": {
        "late input + friction": of_rig(FRICTION, after=late_input),
        "lost counts + lines": of_rig(LINES, after=lost),
        "input disc + modulus": of_rig(INPUT_DISC, MODULUS),
        "torque lag + scale": of_rig(SCALE, after=torque_lag),
        "preload + lines": of_rig(PRELOAD, LINES),
        "pulley + delay": of_rig(PULLEY, DELAY),
        "twice a turn + friction": of_rig(FRICTION, after=twice),
        "shaft + drum disc": of_rig(SHAFT, DRUM_DISC),
    },
    # Effects of one figure each, for how often the intervals and the joint region of the figures hold the truth.
    "cover": {
        "friction + scale": of_rig(FRICTION, SCALE),
        "modulus + delay": of_rig(MODULUS, DELAY),
        "shaft + friction": of_rig(SHAFT, FRICTION),
        "modulus + friction + late input": of_rig(MODULUS, FRICTION, after=late_input),
        "late input + scale": of_rig(SCALE, after=late_input),
        "shaft + delay": of_rig(SHAFT, DELAY),
        "modulus + friction": of_rig(MODULUS, FRICTION),
        "friction + lines": of_rig(FRICTION, LINES),
    },
    "outside": {
        "torque crosstalk": of_rig(after=crosstalk),
        "speed squared": of_rig(after=output_adds("speed squared", speed_squared)),
        "bump": of_rig(after=output_adds("bump", bump)),
        "torque hysteresis": of_rig(after=torque_hysteresis),
        "bent frame": of_rig(after=output_adds("bent frame", bent_frame)),
        "climbing": of_rig(after=output_adds("climbing", climbing)),
        "rubbing": of_rig(after=output_adds("rubbing", rubbing)),
        "slipping": of_rig(after=output_adds("slipping", slipping)),
        "joint opens": of_rig(after=output_adds("joint opens", joint_opens)),
        "rubber mount": of_rig(after=output_adds("rubber mount", rubber_mount)),
        "fan": of_rig(after=output_adds("fan", fan)),
        "broken strand": of_rig(after=output_adds("broken strand", broken_strand)),
        "wear": of_rig(after=output_adds("wear", wear)),
        "one soft mount": of_rig(after=output_adds("one soft mount", one_soft_mount)),
    },
    "sensors": {
        "nothing": of_rig(after=all_within),
        "modulus": of_rig(MODULUS, after=all_within),
        "scale": of_rig(SCALE, after=all_within),
        "friction": of_rig(FRICTION, after=all_within),
        "shaft": of_rig(SHAFT, after=all_within),
        "drum disc": of_rig(DRUM_DISC, after=all_within),
        "delay": of_rig(DELAY, after=all_within),
        "preload": of_rig(PRELOAD, after=all_within),
        "lines": of_rig(LINES, after=all_within),
    },
}


def made(group: str, case: str, seed: int) -> tuple[Drive, Run, list[dict[str, Any]]]:
    """Drive, readings and truth of one case; the seed's remainder by four is the layout. Raises ``RigError``."""
    free = ("motor", "square") if group in ("single", "pair") else ("motor", "square", "brake")
    bench, rng = bench_of(seed, ("none",) if "no load" in case else free, "structure" in case)
    if case == "lash":  # behind the encoders it would be in the readings
        bench.experiment["sensors"]["input_at"] = "motor"
    return bench.drive, *GROUPS[group][case](bench, rng)
