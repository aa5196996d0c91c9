"""The work of ``mbcdm simulate`` for both rigs: run the experiment, write its folder and picture, print a summary."""

import io
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.rig.bench import routes_of
from mbcdm_cad.rig.experiment import DynamicExperiment, Experiment, SimulatedRun, run_files, write_run
from mbcdm_cad.rig.quasistatic import simulate
from mbcdm_cad.routes import Floats


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
    most, made_for = float(np.abs(run.load_Nm).max()), drive.loads.peak_torque_Nm
    over = f"\nnote: the load reaches {most:.3g} N m, the design is made for loads.peak_torque_Nm: {made_for:.3g}"
    return (
        f"{folder / (experiment.name + '.yaml')}: {run.time_s.size} samples{ended}\n"
        f"transmission error {error.min():.1f} to {error.max():.1f} urad, "
        f"tensions {run.tension_N.min():.2f} to {run.tension_N.max():.2f} N\n"
        f"beyond the declared model (in the truth file): {named}{over if most > 1.001 * made_for else ''}"
    )


def transmission_error_urad(run: SimulatedRun, turns: list[float]) -> Floats:
    """Mean of the inputs over their ratio minus the output, from the readings: Eq. (2) of the paper; (n,) in urad."""
    ideal = np.mean([angle / turn for angle, turn in zip(run.measured_input_rad, turns, strict=True)], axis=0)
    return np.asarray((ideal - run.measured_output_rad) * 1e6)


def run_picture(run: SimulatedRun, title: str, turns: list[float]) -> bytes:
    """The run as a PNG; no display needed, the same run gives the same bytes."""
    figure = Figure(figsize=(10, 7), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(2, 2)
    error = transmission_error_urad(run, turns)
    axes[0, 0].plot(run.time_s, run.drum_rad * 1e3, lw=0.8)
    axes[0, 0].set(xlabel="time (s)", ylabel="drum angle (mrad)")
    twin = axes[0, 0].twinx()
    twin.plot(run.time_s, run.load_Nm, color="tab:red", lw=0.6)
    twin.set_ylabel("load torque (N m)", color="tab:red")
    axes[0, 1].plot(run.time_s, error, lw=0.5)
    axes[0, 1].set(xlabel="time (s)", ylabel="transmission error (µrad)")
    axes[1, 0].plot(run.drum_rad * 1e3, error, lw=0.5)
    axes[1, 0].set(xlabel="drum angle (mrad)", ylabel="transmission error (µrad)")
    for j, tension in enumerate(run.tension_N):
        axes[1, 1].plot(run.time_s, tension, lw=0.7, label=f"cable {j + 1}")
    axes[1, 1].set(xlabel="time (s)", ylabel="tension (N)")
    axes[1, 1].legend(fontsize=8)
    figure.suptitle(title)
    target = io.BytesIO()
    figure.savefig(target, format="png", dpi=100, metadata={"Software": None})
    return target.getvalue()
