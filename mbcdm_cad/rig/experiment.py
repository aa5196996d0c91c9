"""Experiment files of both rigs, whose faults become an ``InputError`` with line, and the files of a run that was made.

A result is written completely or not at all.
"""

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

import numpy as np
import yaml
from numpy.typing import NDArray
from pydantic import AliasChoices, Field, ValidationError

from mbcdm_cad.design import yamltree
from mbcdm_cad.design.yamltree import dotted, read_text
from mbcdm_cad.errors import InputError, MbcdmError, OutputError, Problem, shortened
from mbcdm_cad.rig import bench
from mbcdm_cad.rig.chain import DRUM_WRAP_RAD, INPUT_WRAP_RAD
from mbcdm_cad.rig.dynamic.train import chirp, sine, standstill
from mbcdm_cad.rig.effects import AnyEffect
from mbcdm_cad.rig.motion import WIDEST_MRAD, Load, Motion
from mbcdm_cad.routes import Floats
from mbcdm_cad.storage.folders import write_folder

MAX_SAMPLES = 2_000_000
# Wrap that is left on pulleys of many turns at the end of the motion.
LEFT_RAD = 0.1


class Physics(bench.PhysicsBlock):
    """Choices of the physics. Wraps are those of rope on pulley at the centre, from anchor to tangent point."""

    substeps: Annotated[int, Field(ge=1, le=100)] = 1
    # Left out: 16 rad and 3 rad, or what a longer travel winds off and LEFT_RAD.
    input_wrap_rad: Annotated[float, Field(gt=0.0, le=1e4)] | None = None
    drum_wrap_rad: Annotated[float, Field(gt=0.0, le=25.0)] | None = None

    def wraps_rad(self, reach_rad: float, turns: float) -> tuple[float, float]:
        """Wraps of each cable on input and drum, in a run of this largest angle of the drum and this ratio."""
        wound = reach_rad * turns if self.cable_transport else 0.0
        usual = max(INPUT_WRAP_RAD, wound + LEFT_RAD), max(DRUM_WRAP_RAD, reach_rad + LEFT_RAD)
        return self.input_wrap_rad or usual[0], self.drum_wrap_rad or usual[1]


class Experiment(bench.ExperimentBlock):
    """An experiment on the quasi-static bench. ``record``: every sample, or as by hand: a row where motion or
    load turns round, or readings at rest ever farther apart since each step of the load.
    """

    name: Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9_-]{0,79}$")]
    about: Annotated[str, Field(max_length=500)] = ""
    format: Literal["mbcdm-experiment-1"] = "mbcdm-experiment-1"
    seed: Annotated[int, Field(ge=0, le=2**31 - 1)] = 1
    duration_s: Annotated[float, Field(gt=0.0, le=bench.MOST_DURATION_S)] = 160.0
    sample_rate_Hz: Annotated[float, Field(ge=1.0, le=5000.0)] = 100.0
    motion: Motion
    load: Load = Load()
    sensors: bench.BenchSensors = bench.BenchSensors()
    physics: Physics = Physics()
    record: Literal["samples", "turning_points", "creep"] = "samples"
    effects: Annotated[tuple[AnyEffect, ...], Field(max_length=50, strict=False)] = ()

    def rows(self, time_s: Floats) -> NDArray[np.int64]:
        """The samples that are written: all, turning points of the motion or of the load at rest, or those at rest."""
        if self.record == "samples":
            return np.arange(time_s.size)
        if self.record == "creep":
            course = self.load.periods_per_level * self.motion.period_s if len(self.load.levels_Nm) > 1 else time_s[-1]
            since = np.geomspace(
                1.0 / self.sample_rate_Hz, 0.99 * course, round(6.0 * np.log10(course * self.sample_rate_Hz))
            )
            at = [begin + since for begin in np.arange(0.0, time_s[-1], course)]
            return np.unique(np.minimum(np.searchsorted(time_s, np.concatenate(at)), time_s.size - 1))
        held = self.motion.shape == "hold"
        period = self.load.wave_period_s if held else self.motion.period_s
        begins = 0.25 * self.motion.period_s if held else 0.0
        turns = 0.25 * period + 0.5 * period * np.arange(1 + int(2.0 * time_s[-1] / period))
        turns = turns[(turns >= begins) & (turns <= time_s[-1])]
        rows = np.searchsorted(time_s, turns - 1e-9)
        if held:
            return np.asarray(rows)
        # Where the load is made smaller it turns round: the sample before.
        course, levels = self.load.periods_per_level * period, np.abs(self.load.levels_Nm)
        number = np.arange(1, 1 + int(time_s[-1] / course))
        falls = levels[number % levels.size] < levels[(number - 1) % levels.size]
        before = np.searchsorted(time_s, course * number[falls] - 1e-9) - 1
        return np.unique(np.concatenate([rows, before[before > rows[0]]]))


Share = Annotated[float, Field(ge=0.0, le=1.0)]


class DynamicMotion(bench.ExperimentBlock):
    """A sine of the drum's angle that starts from rest, standstill, or a chirp: a sweep of the frequency with one size
    of the acceleration, for a frequency response."""

    shape: Literal["sine", "hold", "chirp"] = "sine"
    amplitude_mrad: Annotated[float, Field(gt=0.0, le=WIDEST_MRAD)] = 50.0
    frequency_Hz: Annotated[float, Field(ge=1e-3, le=20.0)] = 0.1
    acceleration_rad_s2: Annotated[float, Field(gt=0.0, le=1e4)] = 10.0
    from_Hz: Annotated[float, Field(ge=0.5, le=400.0)] = 5.0
    to_Hz: Annotated[float, Field(ge=0.5, le=400.0)] = 150.0

    def reference(self, duration_s: float, rate_Hz: float) -> Floats:
        """Angle, speed and acceleration of the drum at each period of the loops, (n, 3)."""
        if self.shape == "hold":
            return standstill(duration_s, rate_Hz)
        if self.shape == "chirp":
            return chirp(self.acceleration_rad_s2, self.from_Hz, self.to_Hz, duration_s, rate_Hz)
        return sine(self.amplitude_mrad * 1e-3, self.frequency_Hz, duration_s * self.frequency_Hz, rate_Hz)


class DynamicLoad(bench.ExperimentBlock):
    """Brake and torque motor may act together; a brake with a ``static_ratio`` above 1 sticks and slips."""

    brake_Nm: bench.Friction = 0.0
    static_ratio: Annotated[float, Field(ge=1.0, le=3.0)] = 1.0
    static_speed_rad_s: Annotated[float, Field(gt=0.0, le=1.0)] = 1e-3
    torque_Nm: bench.Torque = 0.0
    ramp_Nm_s: bench.Torque = 0.0
    inertia_kg_m2: bench.Inertia = 0.0
    unbalance_Nm: bench.Moment = 0.0


class Drives(bench.ExperimentBlock):
    """Motors and gearheads; defaults are those of the design. ``lossless`` switches all their friction off."""

    lossless: bool = False
    cogging_share: Share = 0.0  # of the rated torque, once a turn of the motor unless the order says otherwise
    cogging_per_turn: Annotated[float, Field(gt=0.0, le=200.0)] = 1.0
    lash_mrad: Annotated[float, Field(ge=0.0, le=100.0)] = 0.0
    mesh_error_urad: Annotated[float, Field(ge=0.0, le=1e4)] = 0.0
    mesh_per_motor_turn: Annotated[float, Field(gt=0.0, le=200.0)] = 1.0
    bandwidth_Hz: Annotated[float, Field(ge=0.5, le=25.0)] = 5.0


class BearingDrag(bench.ExperimentBlock):
    """Friction of the bearings, each at its own shaft. The torque sensor does not see it.

    At the drum it is drum_Nm + viscous_Nms |w| + stribeck_Nm exp(-|w|/stribeck_rad_s), w its speed, and a share of the
    load: one while the drum moves against it, one while the load moves the drum.
    """

    input_Nm: bench.Friction = 0.0
    passed_Nm: Annotated[bench.Friction, Field(validation_alias=AliasChoices("passed_Nm", "guide_Nm"))] = 0.0
    drum_Nm: bench.Friction = 0.0
    viscous_Nms: bench.Drag = 0.0
    stribeck_Nm: bench.Friction = 0.0
    stribeck_rad_s: Annotated[float, Field(gt=0.0, le=100.0)] = 0.05
    driving_share: Share = 0.0
    driven_share: Share = 0.0


class DynamicSensors(bench.ExperimentBlock):
    """Errors of the sensors; the position loops use the input encoders too, the other sensors are only logged."""

    input_resolution_rad: bench.Resolution = 1.9175e-4
    input_noise_rad: bench.Noise = 0.0
    input_delay_s: bench.Delay = 0.0
    output_resolution_rad: bench.Resolution = 1.3635e-6
    output_noise_rad: bench.Noise = 0.0
    output_delay_s: bench.Delay = 0.0
    torque_noise_Nm: bench.Friction = 0.005

    @property
    def log_torque(self) -> bool:
        """The dynamic rig always logs the torque."""
        return True


class DynamicPhysics(bench.PhysicsBlock):
    """Choices of the physics."""

    step_us: Literal[20, 50, 100, 200, 500] = 100


class DynamicExperiment(bench.ExperimentBlock):
    """An experiment on the dynamic rig."""

    rig: Literal["dynamic"]
    name: Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9_-]{0,79}$")]
    about: Annotated[str, Field(max_length=500)] = ""
    seed: Annotated[int, Field(ge=0, le=2**31 - 1)] = 1
    duration_s: Annotated[float, Field(gt=0.0, le=2000.0)] = 160.0
    sample_rate_Hz: Literal[50, 100, 200, 500, 1000] = 100
    motion: DynamicMotion = DynamicMotion()
    load: DynamicLoad = DynamicLoad()
    drives: Drives = Drives()
    bearings: BearingDrag = BearingDrag()
    sensors: DynamicSensors = DynamicSensors()
    physics: DynamicPhysics = DynamicPhysics()
    effects: Annotated[tuple[AnyEffect, ...], Field(max_length=50, strict=False)] = ()


Block = TypeVar("Block", bound=bench.ExperimentBlock)

_KIND = ("experiment file", "; docs/experiments.md shows examples")
_BENCH_KIND = ("bench file", "; docs/measure-your-drive.md shows one")
_BOUNDS = {
    "gt": "over",
    "ge": "at least",
    "lt": "under",
    "le": "at most",
    "min_length": "at least",
    "max_length": "at most",
    "pattern": "signs",
    "expected": "one of",
    "expected_tags": "one of",
}
_FIELDS = ("not possible", "give its fields, indented below it")
_WORDS = {
    "missing": ("missing", "add it"),
    "extra_forbidden": ("unknown field", "check its spelling"),
    "union_tag_invalid": ("unknown effect", "choose one of them"),
    "union_tag_not_found": ("an effect without its name", "add 'effect: NAME'"),
    "tuple_type": ("not possible", "write a list, such as [1.0, 2.0]"),
    "model_type": _FIELDS,
    "model_attributes_type": _FIELDS,
    "dict_type": _FIELDS,
}


def read_experiment(path: str | Path) -> Experiment | DynamicExperiment:
    """The experiment in a YAML file, on the dynamic rig if it has a field ``rig``. InputError lists all problems."""
    path = Path(path)
    tree = yamltree.parse(read_text(path, *_KIND), str(path), *_KIND)
    dynamic = isinstance(tree.data, dict) and "rig" in tree.data
    if dynamic:
        return _validated(DynamicExperiment, tree, str(path))
    experiment = _validated(Experiment, tree, str(path))
    samples = experiment.duration_s * experiment.sample_rate_Hz * experiment.physics.substeps
    if not 8 <= samples <= MAX_SAMPLES:
        raise InputError(
            [
                Problem(
                    str(path),
                    tree.line_of(("duration_s",)),
                    "duration_s",
                    "a run of that many steps cannot be made",
                    f"{samples:.0f} steps",
                    f"8 to {MAX_SAMPLES}",
                    "change duration_s or sample_rate_Hz",
                )
            ]
        )
    return experiment


def read_bench(path: str | Path) -> bench.BenchLimits:
    """The limits of the bench in a YAML file. InputError lists all problems."""
    path = Path(path)
    tree = yamltree.parse(read_text(path, *_BENCH_KIND), str(path), *_BENCH_KIND)
    limits = _validated(bench.BenchLimits, tree, str(path))
    if bool(limits.loads) != (limits.torque_Nm is not None):
        missing, beside = ("torque_Nm", "loads") if limits.loads else ("loads", "torque_Nm")
        remedy = "add torque_Nm, the most it makes, N m" if limits.loads else "add loads: [brake, weight, torque_motor]"
        problem = Problem(str(path), tree.line_of((beside,)), missing, "missing beside " + beside, remedy=remedy)
        raise InputError([problem])
    return limits


def _validated(model: type[Block], tree: yamltree.Tree, file: str) -> Block:
    try:
        return model.model_validate(tree.data)
    except ValidationError as error:
        found = [_problem(item, tree, file) for item in error.errors(include_url=False)]
        raise InputError(sorted(found, key=lambda problem: problem.line)[:50]) from None


def _problem(item: Any, tree: yamltree.Tree, file: str) -> Problem:
    context = item.get("ctx", {})
    # Pydantic adds the branch of a union to the path; the file does not contain it.
    where = tuple(part for k, part in enumerate(item["loc"]) if not (k == 2 and item["loc"][0] == "effects"))
    limit = ", ".join(f"{word} {context[key]}" for key, word in _BOUNDS.items() if key in context)
    # Of the others, pydantic's sentence in the words of a YAML file.
    said = item["msg"][0].lower() + item["msg"][1:]
    what, remedy = _WORDS.get(item["type"], ("not possible", said))
    shown = item["input"].get("effect") if item["type"] == "union_tag_invalid" else item["input"]
    value = "" if item["type"] == "missing" else shortened(shown)
    return Problem(file, tree.line_of(where), dotted(where), what, value, limit, remedy)


class RigError(MbcdmError):
    """An experiment that cannot be run, though its file is well formed."""


@dataclass(frozen=True, eq=False)
class SimulatedRun:
    """Truth and readings of a run, SI, arrays over n samples.

    ``input_rad`` (n_inputs, n) are the pulleys, ``tension_N`` (n_cables, n); ``load_Nm`` is the torque at the sensor.
    ``drum_rad`` is the drum's angle at its encoder, ``payload_rad`` that of the payload; ``excitation_rad`` (n,) the
    command, on the dynamic rig.
    """

    time_s: Floats
    input_rad: Floats
    drum_rad: Floats
    payload_rad: Floats
    load_Nm: Floats
    tension_N: Floats
    measured_input_rad: Floats
    measured_output_rad: Floats
    measured_load_Nm: Floats | None
    measured_temperature_C: Floats | None
    truth: list[dict[str, Any]]
    excitation_rad: Floats | None = None


def run_files(
    run: SimulatedRun, experiment: Experiment | DynamicExperiment, input_names: tuple[str, ...]
) -> dict[str, bytes]:
    """The CSV, the measurement file and the truth file, by name. The same run gives the same bytes."""
    name = experiment.name
    one = len(input_names) == 1
    keys = ["input"] if one else [f"input_{side}" for side in input_names]
    names = ["q_in"] if one else [f"q_{side}" for side in input_names]
    columns: dict[str, Any] = {"time": {"column": "t", "unit": "s"}}
    columns |= {key: {"column": column, "unit": "rad"} for key, column in zip(keys, names, strict=True)}
    columns["output"] = {"column": "q_out", "unit": "rad"}
    table, header = [run.time_s, *run.measured_input_rad, run.measured_output_rad], ["t", *names, "q_out"]
    if run.measured_load_Nm is not None:
        columns["load_torque"] = {"column": "tau", "unit": "N*m"}
        table, header = [*table, run.measured_load_Nm], [*header, "tau"]
    if run.measured_temperature_C is not None:
        columns["temperature"] = {"column": "temp", "unit": "degC"}
        table, header = [*table, run.measured_temperature_C], [*header, "temp"]
    sensors = experiment.sensors
    kind: dict[str, Any] = {}
    if isinstance(experiment, Experiment) and experiment.record != "samples":
        rows, kind = experiment.rows(run.time_s), {"kind": experiment.record}
        table = [column[rows] for column in table]
    if isinstance(experiment, DynamicExperiment) and experiment.motion.shape == "chirp":
        kind = {"kind": "frequency_response", "inertia_plate": {"inertia_kg_m2": experiment.load.inertia_kg_m2}}
        columns["excitation"] = {"column": "command", "unit": "rad"}
        table, header = [*table, run.excitation_rad], [*header, "command"]
    measurement: dict[str, Any] = {
        "data": f"{name}.csv",
        **kind,
        "columns": columns,
        "sensors": {
            key: value
            for key, value in (
                ("input_resolution_rad", sensors.input_resolution_rad),
                ("output_resolution_rad", sensors.output_resolution_rad),
                ("torque_noise_Nm", sensors.torque_noise_Nm if sensors.log_torque else 0.0),
            )
            if value > 0.0
        },
    }
    if counted := counted_parts(experiment):
        measurement["parts"] = counted
    if not measurement["sensors"]:
        del measurement["sensors"]
    truth = {"experiment": name, "effects": run.truth}
    return {f"{name}.csv": _csv(header, table), f"{name}.yaml": _yaml(measurement), f"{name}.truth.yaml": _yaml(truth)}


def counted_parts(experiment: Experiment | DynamicExperiment) -> dict[str, Any]:
    """The block ``parts`` of a run's measurement file: what it has besides the cables; empty for nothing."""
    physics = experiment.physics
    if not (physics.structure or physics.losses):
        return {}
    found: dict[str, Any] = {"structure": physics.structure, "losses": physics.losses}
    motors = isinstance(experiment, Experiment) and experiment.sensors.input_at == "motor"
    return found | ({"inputs_at": "motors"} if motors else {})


def _csv(header: list[str], columns: list[Any]) -> bytes:
    text = io.StringIO()
    # Time to a microsecond, all else to ten digits: far finer than any sensor.
    formats = ["%.6f", *["%.10g"] * (len(columns) - 1)]
    np.savetxt(text, np.stack(columns, axis=1), fmt=formats, delimiter=",", header=",".join(header), comments="")
    return text.getvalue().encode()


def _yaml(content: dict[str, Any]) -> bytes:
    return yaml.safe_dump(content, sort_keys=False, default_flow_style=False).encode()


def write_run(folder: Path, files: dict[str, bytes]) -> None:
    """Make ``folder`` contain exactly these files. An existing folder is replaced only if it has files of a run alone.

    Raises ``OutputError`` if it contains other files, or if the system refuses to write.
    """
    ours = {"".join(Path(name).suffixes) for name in files} | {".png"}

    def refuse(target: Path) -> None:
        if target.exists() and (not target.is_dir() or any("".join(p.suffixes) not in ours for p in target.iterdir())):
            raise OutputError(
                f"{target}: contains something other than a simulated run; choose another folder with --out"
            )

    write_folder(folder, files, refuse)
