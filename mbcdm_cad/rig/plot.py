"""A picture of a run: motion and load, transmission error over time and over angle, tensions."""

from __future__ import annotations

import io

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from mbcdm_cad.rig.result import SimulatedRun
from mbcdm_cad.routes import Floats


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
