"""The result of a rig (truth and readings, or why there are none) and its files, written completely or not at all."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from mbcdm_cad.errors import MbcdmError, OutputError
from mbcdm_cad.rig.experiment import DynamicExperiment, Experiment
from mbcdm_cad.routes import Floats
from mbcdm_cad.storage.folders import write_folder


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
