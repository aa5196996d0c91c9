"""What ``mbcdm simulate`` does, beside parsing its command line."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.rig.bench import bench_of
from mbcdm_cad.rig.dynamic.experiment import DynamicExperiment
from mbcdm_cad.rig.plot import run_picture, transmission_error_urad
from mbcdm_cad.rig.quasistatic.experiment import Experiment
from mbcdm_cad.rig.quasistatic.simulate import simulate
from mbcdm_cad.rig.writing import run_files, write_run


def simulate_command(drive: Drive, experiment: Experiment | DynamicExperiment, out: Path) -> str:
    """Run, write the folder ``out``/NAME, and say in a few lines what came of it."""
    if isinstance(experiment, DynamicExperiment):
        from mbcdm_cad.rig.dynamic.simulate import dynamic_command  # the quasi-static rig needs none of it

        return dynamic_command(drive, experiment, out)
    run = simulate(drive, experiment)
    zero = np.zeros(2)
    still = bench_of(drive, zero, zero, np.zeros((len(drive.input_names), 2)), np.random.default_rng(0), "pulley")
    turns = [still.turns(i) for i in range(len(drive.input_names))]
    files = run_files(run, experiment, drive.input_names)
    files[f"{experiment.name}.png"] = run_picture(run, experiment.about or experiment.name, turns)
    folder = out / experiment.name
    write_run(folder, files)
    error = transmission_error_urad(run, turns)
    named = ", ".join(str(entry["name"]) for entry in run.truth) or "nothing"
    return (
        f"{folder / (experiment.name + '.yaml')}: {run.time_s.size} samples\n"
        f"transmission error {error.min():.1f} to {error.max():.1f} urad, "
        f"tensions {run.tension_N.min():.2f} to {run.tension_N.max():.2f} N\n"
        f"beyond the declared model (in the truth file): {named}"
    )
