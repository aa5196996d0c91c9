"""What ``mbcdm simulate`` does with an experiment file: one of the paper's experiments, or a run of a rig."""

from __future__ import annotations

from pathlib import Path

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.rig.command import simulate_command
from mbcdm_cad.rig.experiment import DynamicExperiment, Experiment
from mbcdm_cad.rig.writing import RigError, run_files, write_run


def experiment_command(drive: Drive, experiment: Experiment | DynamicExperiment, out: Path) -> str:
    """Run the experiment, write the folder ``out``/NAME, and print a summary."""
    if isinstance(experiment, DynamicExperiment) and experiment.paper is not None:
        return paper_command(drive, experiment, out / experiment.name)
    return simulate_command(drive, experiment, out)


def paper_command(drive: Drive, experiment: DynamicExperiment, folder: Path) -> str:
    """Run the experiment of the paper that ``experiment`` names and write its results with the paper's figures."""
    # The kernel of the dynamic rig takes long to load, and a run of the quasi-static rig does not need it.
    from mbcdm_cad.paper.experiments import EXPERIMENTS
    from mbcdm_cad.paper.experiments_plots import result_files, result_text
    from mbcdm_cad.rig.dynamic.simulate import as_logged

    try:
        result = EXPERIMENTS[str(experiment.paper)](drive, experiment.seed)
    except ValueError as error:
        raise RigError(
            f"{experiment.name}: {drive.name} cannot complete the paper's experiment: {error}; "
            "check the torque of motor and gearhead, and the wraps"
        ) from None
    files = result_files(result, drive)
    if len(result.runs) == 1:
        (run,) = result.runs.values()
        truth = [{"name": "winding_history", "in_vocabulary": True, "parameters": {}}]
        files |= run_files(as_logged(run, truth), experiment, drive.input_names)
    write_run(folder, files)
    return f"{folder}: {', '.join(sorted(files))}\n\n{result_text(result)}"
