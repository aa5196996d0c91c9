"""Measured runs that are independent of the project's model: a CSV, its measurement file, and the truth.

    write_case(folder, "pulley_guide", seed=3, drive=load_design(...).drive)
    python -m tests.support.bench_data out/story out_square 0

The physics is in bench_chain.py, the geometry, motion and sensors in bench_motion.py; of the
project only the design file is used. Sizes and phases of the effects come from the seed, within ranges that the motion
of the case can separate. ``truth.yaml`` is never read by the loop.
"""

import dataclasses
import sys
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.measurement.reading import load_measurement
from mbcdm_cad.measurement.run import Run
from tests.support import bench_motion
from tests.support.bench_cases import CASES, Case
from tests.support.bench_chain import PIECE_RAD, run_chain
from tests.support.bench_effects import Effect
from tests.support.bench_motion import Chain, chain_of, path_of_eccentric


@dataclass(frozen=True)
class Simulated:
    """One run as simulated: true signals, drum angle at the sensor, what the sensors gave, the effects in it."""

    plan: bench_motion.Plan
    bench: bench_motion.Bench
    drum_rad: np.ndarray
    sensed: dict[str, np.ndarray]
    effects: tuple[Effect, ...]
    columns: tuple[str, ...]


def stream(case: str, seed: int, purpose: str) -> np.random.Generator:
    """A random stream of its own for each purpose, so that a run and its twin without effect share their noise."""
    letters = [ord(letter) for letter in f"{case}/{purpose}"]
    return np.random.default_rng([seed, *letters])


def simulate_case(drive: Drive, name: str, seed: int, without_effects: bool = False) -> Simulated:
    """Run one case. ``without_effects`` gives its twin: same motion, load and noise, no effect."""
    case = CASES[name]
    plan = case.plan(stream(name, seed, "plan"))
    effects = () if without_effects else case.effects(stream(name, seed, "effects"), plan)
    chain = chain_of(drive)
    ratio = float(np.mean(chain.r_drum / chain.r_in))
    bench = bench_motion.bench_run(plan, ratio, len(drive.input_names), stream(name, seed, "motion"))
    drum = drum_angle(chain, drive.input_names, bench, effects, stream(name, seed, "wander"))
    sensed = bench_motion.read_sensors(bench, drum, stream(name, seed, "sensors"))
    return Simulated(plan, bench, drum, sensed, effects, _columns(plan, case))


def _columns(plan: bench_motion.Plan, case: Case) -> tuple[str, ...]:
    bare = plan.load == "bare"
    return ("inputs", "output", *(() if bare else ("torque",)), *(("temperature",) if case.temperature else ()))


def drum_angle(
    chain: Chain,
    input_names: tuple[str, ...],
    bench: bench_motion.Bench,
    effects: tuple[Effect, ...],
    rng: np.random.Generator,
    piece_rad: float = PIECE_RAD,
) -> np.ndarray:
    """Angle that the output encoder sees, with all effects at work at once."""
    by_name = {"input_" + name: index for index, name in enumerate(input_names)}
    ratio = float(np.mean(chain.r_drum / chain.r_in))
    inputs, load = bench.input_rad.copy(), bench.load_Nm.copy()
    rigid = inputs.mean(axis=0) / ratio
    path = np.zeros((chain.sense.size, load.size))
    play = np.zeros(inputs.shape[0])
    transport = False
    for effect in effects:
        p = effect.size
        kind = effect.kind
        if kind == "pulley":
            index = by_name.get(effect.stage or "")
            shaft = {"drum": rigid, "guide": -rigid * float(np.mean(chain.r_drum / chain.r_guide))}.get(
                effect.stage or "", inputs[index] if index is not None else rigid
            )
            stage = effect.stage if index is None else f"input_{index}"
            path += path_of_eccentric(chain, str(stage), p["eccentricity_m"], p["phase_rad"], shaft)
        elif kind == "input_encoder":
            # The encoder reads high by this much, so the shaft is behind what is read.
            index = by_name[str(effect.stage)]
            wave = p["amplitude_rad"] * (np.cos(inputs[index] + p["phase_rad"]) - np.cos(p["phase_rad"]))
            inputs[index] = inputs[index] - wave
        elif kind == "radii":
            chain = replace(chain, r_drum=chain.r_drum / (1.0 + p["share"]))
        elif kind == "modulus":
            chain = replace(chain, stiffness=chain.stiffness * (1.0 + p["share"]))
        elif kind == "preload":
            wanted = chain.preload.copy()
            wanted[list(effect.cables)] *= 1.0 + p["share"]
            chain = replace(chain, preload=wanted)
        elif kind == "mu":
            chain = replace(chain, friction=chain.friction * (1.0 + p["share"]))
        elif kind == "bearing":
            load = load + p["torque_Nm"] * np.tanh(bench.speed_rad_s / 1e-3)
        elif kind == "law":
            load = load + friction_law(p, bench)
        elif kind == "viscous":
            load = load + p["drag_Nm_s"] * bench.speed_rad_s
        elif kind == "input_play":
            play[by_name[str(effect.stage)]] = p["play_rad"]
        elif kind == "transport":
            transport = True
        elif kind == "anchor":
            path[list(effect.cables)] -= p["slip_m"] * (0.5 + 0.5 * np.tanh((bench.time_s - p["at_s"]) / 0.04))
    drum, _ = run_chain(chain, inputs, load, path, transport, play, piece_rad)
    for effect in effects:
        drum = drum + effect.added(bench, drum, rng)
    return drum


def friction_law(p: dict[str, float], bench: bench_motion.Bench) -> np.ndarray:
    """Friction by speed and load, built up over a Dahl-like presliding of ``presliding_rad`` of drum angle, N m (n,).

    Its limit is torque + drag |w| + stribeck exp(-|w/fades|^exponent) + a share of the load, one where it opposes the
    motion and one where it drives.
    """
    w, load = bench.speed_rad_s, bench.load_Nm
    drum = np.cumsum(w) * (bench.time_s[1] - bench.time_s[0])
    slow = np.exp(-(np.abs(w / p.get("fades_rad_s", 1.0)) ** p.get("exponent", 2.0)))
    share = np.where(load * w > 0.0, p.get("driving_share", 0.0), p.get("driven_share", 0.0))
    limit = p.get("torque_Nm", 0.0) + p.get("stribeck_Nm", 0.0) * slow + share * np.abs(load)
    limit = limit + p.get("drag_Nm_s", 0.0) * np.abs(w)
    bent, z = p.get("presliding_rad", 1e-4), np.zeros_like(w)
    for k in range(1, w.size):
        step = drum[k] - drum[k - 1]
        # Exact over a step: z goes to the sense of motion with the path travelled.
        z[k] = np.sign(step) + (z[k - 1] - np.sign(step)) * np.exp(-abs(step) / bent)
    return np.asarray(limit * z)


def friction_run(
    drive: Drive, law: dict[str, float] | None, seed: int, noise_rad: float = 0.0, **plan: Any
) -> Simulated:
    """A bench with a friction law, None for none, and a noise of the output encoder that no file declares."""
    streams = [np.random.default_rng([seed, k]) for k in range(4)]
    run = bench_motion.Plan(**{"amplitude_rad": 0.5, "load": "steps", "wave": "sine", **plan})
    effects = (Effect("friction", "law", law),) if law else ()
    chain = chain_of(drive)
    bench = bench_motion.bench_run(run, float(np.mean(chain.r_drum / chain.r_in)), len(drive.input_names), streams[0])
    drum = drum_angle(chain, drive.input_names, bench, effects, streams[1])
    sensed = bench_motion.read_sensors(bench, drum, streams[2])
    sensed["output"] = sensed["output"] + streams[3].normal(0.0, noise_rad, drum.size)
    return Simulated(run, bench, drum, sensed, effects, ("inputs", "output", "torque"))


def write_case(folder: Path, name: str, seed: int, drive: Drive, without_effects: bool = False) -> Path:
    """Write NAME-SEED.csv, .yaml and .truth.yaml into ``folder``; the path of the measurement file."""
    run = simulate_case(drive, name, seed, without_effects)
    stem = f"{name}-{seed}" + ("-twin" if without_effects else "")
    folder.mkdir(parents=True, exist_ok=True)
    write_run(folder, stem, run, drive.input_names)
    (folder / f"{stem}.truth.yaml").write_text(yaml.safe_dump(truth(run), sort_keys=False))
    return folder / f"{stem}.yaml"


def write_run(folder: Path, stem: str, run: Simulated, input_names: tuple[str, ...]) -> None:
    """The CSV and the measurement file of one run."""
    two = len(input_names) > 1
    labels = [f"input_{name}" for name in input_names] if two else ["input"]
    table = [run.bench.time_s, *run.sensed["inputs"], run.sensed["output"]]
    header = ["t", *(f"q_{name}" for name in input_names), "q_out"]
    units = {"time": ("t", "s")}
    units |= {label: (f"q_{name}", "rad") for label, name in zip(labels, input_names, strict=True)}
    units["output"] = ("q_out", "rad")
    if "torque" in run.columns:
        table.append(run.sensed["torque"])
        header.append("tau")
        units["load_torque"] = ("tau", "N*m")
    if "temperature" in run.columns:
        table.append(run.sensed["temperature"])
        header.append("temp")
        units["temperature"] = ("temp", "degC")
    np.savetxt(
        folder / f"{stem}.csv", np.array(table).T, delimiter=",", header=",".join(header), comments="", fmt="%.9g"
    )
    sensors: dict[str, Any] = {
        "input_resolution_rad": bench_motion.INPUT_STEP_RAD,
        "output_resolution_rad": bench_motion.OUTPUT_STEP_RAD,
    }
    if "torque" in run.columns:
        sensors["torque_noise_Nm"] = bench_motion.TORQUE_NOISE_NM
    document = {
        "data": f"{stem}.csv",
        "columns": {name: {"column": column, "unit": unit} for name, (column, unit) in units.items()},
        "sensors": sensors,
    }
    (folder / f"{stem}.yaml").write_text(yaml.safe_dump(document, sort_keys=False))


def through_files(run: Simulated, input_names: tuple[str, ...]) -> Run:
    """A run by way of its files, as the loop gets it."""
    with tempfile.TemporaryDirectory() as folder:
        write_run(Path(folder), "run", run, input_names)
        return load_measurement(Path(folder) / "run.yaml")


def truth(run: Simulated) -> dict[str, Any]:
    """The truth file's content."""
    plan = dataclasses.asdict(run.plan)
    return {"plan": plan, "effects": [effect.as_truth() for effect in run.effects]}


def main() -> None:
    """Write the run of a case and a seed of the reference design into a folder."""
    folder, name, seed = sys.argv[1:]
    design = Path(__file__).resolve().parents[2] / "params" / "mbcdm.yaml"
    print(write_case(Path(folder), name, int(seed), load_design(design).drive))


if __name__ == "__main__":
    main()
