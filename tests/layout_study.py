"""How often the loop is right on benches of all layouts whose own sensors err, or whose drive changes in mid-run.

    python tests/layout_study.py --store out/layouts.jsonl --runs 120 --first-seed 71000
    python tests/layout_study.py --store out/layouts.jsonl      # what it has so far

Runs of the quasi-static rig, which shares no code with the loop's model, on the four reference designs in turn. What
the rig does not have is done to its readings here: sensors of the bench that err, noise beyond the declared steps,
and causes that the loop has no name for. A run that changes is two runs of the same seed, with the effect from a time
on. "exact": all that is true is named and nothing else; "set": it is named or in sets; "not seen": one effect, the
declared model leaves no more than ``SEEN`` times the floor, and nothing is named: the run does not show it.

The file of rows can be continued; a study that was stopped is a smaller study of the same kind.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import uniform_filter1d
from scipy.stats import chi2

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests" / "support"), str(ROOT)]

from bench_page import SHARES_HEAD, share_row  # noqa: E402

from mbcdm_cad.design.drive import Drive  # noqa: E402
from mbcdm_cad.layouts.loader import load_design  # noqa: E402
from mbcdm_cad.measurement.run import KNOWN_LOAD, Run, Sensors, TorqueClass  # noqa: E402
from mbcdm_cad.measurement.schema import CountedParts  # noqa: E402
from mbcdm_cad.model.si import to_si  # noqa: E402
from mbcdm_cad.rig.quasistatic.experiment import Experiment  # noqa: E402
from mbcdm_cad.rig.quasistatic.simulate import simulate  # noqa: E402
from mbcdm_cad.rig.result import RigError  # noqa: E402
from mbcdm_cad.rig.writing import counted_parts  # noqa: E402

Floats = np.ndarray
Rng = np.random.Generator
DESIGNS = ("mbcdm", "siso_spur", "siso_bevel", "miso_spur")
# Largest load as a share of what the preloads would carry at the drum if all acted one way.
LOAD_SHARE = 0.1
STEPS_RAD, TORQUE_NOISE_SHARE = (1.9175e-4, 1.3635e-6), 0.005
SEEN = 1.1
# Hysteresis and cross talk of the torque sensor have names, the other causes of their group none.
OUTSIDE = ("none", "unknown", "partly_explained", "exact", "set")
# What an effect is taken for rightly: to second order only mu T_pre counts.
ALIKE = {"cable_friction": {"preload_error"}, "preload_error": {"cable_friction"}}


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
    return np.atleast_1d(np.asarray(to_si(bench.drive).total_ratio, dtype=float))


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
    width, out, now = 0.06 * bench.most_Nm, np.empty(run.time_s.size), 0.0
    # The noise of the reading comes after the play, which it would make narrower.
    quiet = uniform_filter1d(run.load_Nm, 15)
    for k, load in enumerate(quiet):
        now = min(max(now, load - width), load + width)
        out[k] = now
    return replace(run, load_Nm=out + run.load_Nm - quiet), _told("load_hysteresis", half_width_Nm=width)


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
    },
}
# Of 16 runs 4 without an effect, 6 with one, 4 with two, 2 with a cause that has no name.
TURN = ("null", "single", "pair", "single", "outside", "single", "null", "pair")


def tasks(runs: int, first_seed: int, turns: tuple[str, ...] = TURN) -> list[tuple[str, str, int]]:
    """(group, case, seed); each seed's remainder by four is the layout, so that all meet."""
    found, turn = [], Counter[str]()
    for k in range(runs):
        group = turns[k % len(turns)]
        names = list(GROUPS[group])
        # Within a group the layouts go round with every other step, so that each case meets each of them.
        n = turn[group]
        turn[group] += 1
        layout = (n + n // len(names)) % 4 if len(names) % 2 == 0 else n % 4
        found.append((group, names[n % len(names)], first_seed - first_seed % 4 + 4 * k + layout))
    return found


def judge(group: str, case: str, seed: int, given: bool = False) -> dict[str, Any]:
    """Make the run, give it to the loop, compare. ``given``: the loop has no other effects than the true ones."""
    from mbcdm_cad.loop.search import engine

    free = ("motor", "square") if group in ("single", "pair") else ("motor", "square", "brake")
    bench, rng = bench_of(seed, ("none",) if "no load" in case else free, "structure" in case)
    row: dict[str, Any] = {"group": group, "case": case, "seed": seed, "layout": DESIGNS[seed % 4]}
    row |= {"noise": bench.noise, "load": bench.experiment["load"]["kind"]}
    if case == "lash":  # behind the encoders it would be in the readings
        bench.experiment["sensors"]["input_at"] = "motor"
    try:
        run, truth = GROUPS[group][case](bench, rng)
    except RigError as fault:
        return row | {"outcome": "not made", "said": str(fault)[:200]}
    start = time.process_time()
    try:
        names = {entry["name"] for entry in truth}
        offered = engine.library
        engine.library = lambda d, p: [e for e in offered(d, p) if not given or (e.name in names and not e.base)]
        try:
            result = engine.close_loop(bench.drive, [run])
        finally:
            engine.library = offered
    except Exception as fault:  # a study goes on and reports the fault
        return row | {"outcome": "error", "said": f"{type(fault).__name__}: {fault}"[:300]}
    row["cpu_s"] = time.process_time() - start
    seen = [entry for entry in truth if entry.get("seen", True)]
    groups = [[one] for one in result.effects] + [list(one) for one in result.one_of]
    left, odd = [entry for entry in seen if entry["in_vocabulary"]], []
    for members in groups:
        hit = next((entry for entry in left if any(_same(one, entry) for one in members)), None)
        if hit is None:
            odd.append(" or ".join(one.words for one in members))
        else:
            left.remove(hit)
    known = [entry for entry in seen if entry["in_vocabulary"]]
    if odd:
        outcome = "wrong"
    elif known and not left:
        outcome = "exact" if not result.one_of else "set"
    else:
        outcome = "partial" if groups else result.verdict
    error = result.errors
    if len(known) == 1 and outcome == "none" and error.before.value < SEEN * error.floor_rad:
        outcome = "not seen"
    row |= {"outcome": outcome, "odd": odd, "verdict": result.verdict, "true": [_words(entry) for entry in seen]}
    row |= {"said": " + ".join(" or ".join(one.words for one in members) for members in groups)}
    row |= {"sentence": result.sentence[:400], "values": _values(result, known), "joint": _joint(result, known)}
    return row | {"urad": [1e6 * v for v in (error.before.value, error.after.value, error.floor_rad)]}


def _words(entry: dict[str, Any]) -> str:
    stage = entry.get("stage")
    sizes = ", ".join(f"{key} {value:.3g}" for key, value in entry["parameters"].items())
    return f"{entry['name']}{f' {stage}' if stage else ''} ({sizes})"


def _same(said: Any, entry: dict[str, Any]) -> bool:
    name = said.name
    if entry.get("changes"):
        return name == "change" and (said.stage == entry["name"] or said.stage in ALIKE.get(entry["name"], ()))
    if name in ALIKE.get(entry["name"], ()):
        return True
    if name != entry["name"]:
        return False
    return name not in ("once_per_rev", "twice_per_rev", "lash") or said.stage in (entry.get("stage"), None, "input")


def _values(result: Any, known: list[dict[str, Any]]) -> list[tuple[str, float, float, float | None, float | None]]:
    """What, true, found, ends of the 95 % interval: of the figures of effects named outright that the truth states."""
    found = []
    for one in result.effects:
        entry = next((entry for entry in known if _same(one, entry) and one.name == entry["name"]), None)
        for key, true in (entry or {"parameters": {}})["parameters"].items():
            value = one.parameters.get(key)
            # The amplitude of an input's encoder is found at the drum.
            at_input = key == "amplitude_rad" and str(one.stage).startswith("input")
            if value is not None and not at_input:
                found.append((f"{one.words}.{key}", float(true), value.value, value.low, value.high))
    return found


def _joint(result: Any, known: list[dict[str, Any]]) -> tuple[float, int] | None:
    """Square of the distance of the truth, in standard deviations of the joint covariance, and its number of figures.

    Of the effects named outright one figure each; None for fewer than two.
    """
    found: list[tuple[Any, int, float]] = []
    for one in result.effects:
        entry = next((entry for entry in known if _same(one, entry) and one.name == entry["name"]), None)
        for key, true in (entry or {"parameters": {}})["parameters"].items():
            value, names = one.parameters.get(key), list(one.fitted)
            if key in names and value is not None and np.isfinite(value.high):
                found.append(
                    (one, names.index(key), (float(true) - value.value) * 2.0 * 1.96 / (value.high - value.low))
                )
                break
    if len(found) < 2:
        return None
    table = np.eye(len(found))
    for k, (one, i, _) in enumerate(found):
        for m, (other, j, _) in enumerate(found):
            if m != k:
                table[k, m] = one.correlated[other.words][i, j]
    away = np.array([z for *_, z in found])
    return float(away @ np.linalg.pinv(table, hermitian=True) @ away), len(found)


def summary(rows: list[dict[str, Any]]) -> str:
    """Each aim with its share and 95 % interval, and every run that missed."""
    lines = list(SHARES_HEAD)

    def share(what: str, aim: str, hits: list[bool]) -> None:
        lines.extend(share_row(what, aim, hits))

    made = [row for row in rows if row["outcome"] not in ("not made", "not seen")]
    lines += [
        f"| of {len(rows)} runs not made by the rig, or not seen | - | {len(rows) - len(made)} | {len(rows)} | | |"
    ]
    for group, words, aim, good in (
        ("null", "effect-free: no name", "98 %", ("none", "not_testable", "unknown")),
        ("single", "single: named outright", "-", ("exact",)),
        ("single", "single: named or in a set", "95 %", ("exact", "set")),
        ("pair", "pair: both named or in sets", "90 %", ("exact", "set")),
        ("outside", "cause outside the library: no false name", "95 %", OUTSIDE),
    ):
        share(words, aim, [row["outcome"] in good for row in made if row["group"] == group])
    share("any run: no wrong name or set", "98 %", [row["outcome"] not in ("wrong", "error") for row in made])
    for layout in DESIGNS:
        mine = [row for row in made if row["layout"] == layout and row["group"] != "outside"]
        right = [
            row["outcome"] in (("none", "not_testable") if row["group"] == "null" else ("exact", "set")) for row in mine
        ]
        share(f"{layout}: right, or in a set that holds the truth", "-", right)
    inside = [
        low <= true <= high for r in made for _, true, _, low, high in r.get("values", []) if None not in (low, high)
    ]
    share("95 % intervals that hold the truth", "85 to 99 %", inside)
    joint = [chi2.cdf(*row["joint"]) <= 0.95 for row in made if row.get("joint")]
    share("joint 95 % regions that hold the truth", "85 to 99 %", joint)
    seconds = [row["cpu_s"] for row in made if "cpu_s" in row]
    if seconds:
        lines += [
            "",
            f"CPU time of the loop: median {np.median(seconds):.1f} s, 95 % below {np.quantile(seconds, 0.95):.1f} s.",
        ]
    lines += ["", "| case | layout | seed | true | said |", "| --- | --- | --- | --- | --- |"]
    for row in made:
        good = {"null": ("none", "not_testable"), "outside": OUTSIDE}
        if row["outcome"] not in good.get(row["group"], ("exact", "set")):
            told = row["said"] or row["outcome"]
            true = "; ".join(row.get("true", []))
            lines.append(f"| {row['case']} | {row['layout']} | {row['seed']} | {true} | {told} |")
    return "\n".join(lines)


def main() -> None:
    """Judge the runs that the file does not have yet; print what is in it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--store", type=Path, default=ROOT / "out" / "layouts.jsonl")
    parser.add_argument("--runs", type=int, default=0)
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--only", default="", help="beginnings of cases, with commas")
    parser.add_argument("--given", action="store_true", help="the loop's library has the true effects alone")
    parser.add_argument("--groups", default=",".join(TURN), help="groups in turn, with commas")
    options = parser.parse_args()
    options.store.parent.mkdir(parents=True, exist_ok=True)
    rows = [json.loads(line) for line in options.store.read_text().splitlines()] if options.store.exists() else []
    done = {(row["case"], row["seed"]) for row in rows}
    for group, case, seed in tasks(options.runs, options.first_seed, tuple(options.groups.split(","))):
        if (case, seed) in done or not case.startswith(tuple(options.only.split(","))):
            continue
        rows.append(judge(group, case, seed, options.given))
        with options.store.open("a", encoding="utf-8") as file:
            file.write(json.dumps(rows[-1]) + "\n")
        row = rows[-1]
        print(
            row["case"],
            row["layout"],
            seed,
            row["outcome"],
            row.get("true"),
            "->",
            row["said"],
            row.get("urad"),
            flush=True,
        )
    print(summary(rows))


if __name__ == "__main__":
    main()
