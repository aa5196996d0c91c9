"""The work of ``mbcdm simulate`` for both rigs: run the experiment, write its folder, print a summary."""

from __future__ import annotations

from pathlib import Path

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.rig.cables import routes_of
from mbcdm_cad.rig.dynamic.experiment import DynamicExperiment
from mbcdm_cad.rig.plot import run_picture, transmission_error_urad
from mbcdm_cad.rig.quasistatic.experiment import Experiment
from mbcdm_cad.rig.quasistatic.simulate import simulate
from mbcdm_cad.rig.result import SimulatedRun
from mbcdm_cad.rig.writing import run_files, write_run


def simulated(drive: Drive, experiment: Experiment | DynamicExperiment) -> SimulatedRun:
    """Run ``experiment`` on the rig that it names. Raises RigError."""
    if isinstance(experiment, DynamicExperiment):
        from mbcdm_cad.rig.dynamic.simulate import simulate as simulate_dynamic  # the quasi-static rig needs none of it

        return simulate_dynamic(drive, experiment)
    return simulate(drive, experiment)


def simulate_command(drive: Drive, experiment: Experiment | DynamicExperiment, out: Path) -> str:
    """Run the experiment, write the folder ``out``/NAME, and print a summary."""
    run = simulated(drive, experiment)
    turns = [body.turns_per_drum for body in routes_of(drive).inputs]
    files = run_files(run, experiment, drive.input_names)
    files[f"{experiment.name}.png"] = run_picture(run, experiment.about or experiment.name, turns)
    folder = out / experiment.name
    write_run(folder, files)
    error = transmission_error_urad(run, turns)
    named = ", ".join(str(entry["name"]) for entry in run.truth) or "nothing"
    ended = "" if run.time_s[-1] > 0.98 * experiment.duration_s else f", lost the drum at {run.time_s[-1]:.2f} s"
    return (
        f"{folder / (experiment.name + '.yaml')}: {run.time_s.size} samples{ended}\n"
        f"transmission error {error.min():.1f} to {error.max():.1f} urad, "
        f"tensions {run.tension_N.min():.2f} to {run.tension_N.max():.2f} N\n"
        f"beyond the declared model (in the truth file): {named}"
    )
