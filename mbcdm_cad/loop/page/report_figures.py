"""Pictures of the loop's page, with too many points for a chart: transmission error; residual over angle and load."""

from __future__ import annotations

from io import BytesIO
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from scipy.ndimage import uniform_filter1d

from mbcdm_cad.loop.result import Traces, size_of
from mbcdm_cad.routes import Floats

MEASURED, BEFORE, AFTER = "#000000", "#D55E00", "#0072B2"
STYLE: dict[Any, Any] = {"font.size": 9.0, "axes.grid": True, "grid.alpha": 0.3, "legend.frameon": False}
WIDTH_IN = 9.6
BINS = 60
# Points over which the sense of motion is computed: they must take longer than a step of the encoder.
SENSE_POINTS = 25


def loop_png(t: Traces, ideal_rad: Floats) -> bytes:
    """Transmission error over output angle, which shows the hysteresis. ``ideal_rad`` (n,): inputs over the ratio."""
    with mpl.rc_context(STYLE):
        figure, axes = _panels(3.6)
        error = t.output_rad - ideal_rad
        error = error - np.median(error)
        factor, unit = size_of("_rad", [float(np.abs(error).max())])
        from_here = slice(first_used(t), None)
        angle = 1e3 * t.output_rad[from_here]
        axes.plot(
            angle, error[from_here] / factor, ls="", marker=".", ms=2.0, alpha=0.5, color=MEASURED, label="measured"
        )
        for residual, colour, word in (
            (t.residual_before_rad, BEFORE, "declared model"),
            (t.residual_after_rad, AFTER, "with what was found"),
        ):
            axes.plot(angle, (error - residual)[from_here] / factor, lw=0.8, color=colour, label=word)
        axes.set(xlabel="output (mrad)", ylabel=f"output - inputs/ratio ({unit})")
        _legend(axes)
        return _png(figure)


def scatter_png(t: Traces) -> bytes:
    """Residual against output angle, and against load where it was measured.

    Means over bins: against angle for each sense of motion, solid with rising and dashed with falling angle.
    """
    with mpl.rc_context(STYLE):
        from_here = slice(first_used(t), None)
        variables = [("output (mrad)", 1e3 * t.output_rad[from_here])]
        if t.load_Nm is not None:
            variables.append(("load torque (N m)", t.load_Nm[from_here]))
        rising = np.gradient(uniform_filter1d(t.output_rad[from_here], SENSE_POINTS)) >= 0.0
        figure, panels = _panels(3.4, columns=len(variables))
        factor, unit = residual_size(t)
        first = np.atleast_1d(panels)[0]
        for axes, (label, values) in zip(np.atleast_1d(panels), variables, strict=True):
            for residual, colour, word in (
                (t.residual_before_rad[from_here], BEFORE, "before"),
                (t.residual_after_rad[from_here], AFTER, "after"),
            ):
                axes.plot(values, residual / factor, ls="", marker=".", ms=1.5, alpha=0.25, color=colour)
                if axes is first:
                    axes.plot(*_means(values[rising], residual[rising] / factor), color=colour, lw=1.6, label=word)
                    axes.plot(*_means(values[~rising], residual[~rising] / factor), color=colour, lw=1.6, ls="--")
                else:
                    axes.plot(*_means(values, residual / factor), ls="", marker="o", ms=3.0, color=colour, label=word)
            axes.set(xlabel=label, ylabel=f"measured - predicted ({unit})")
            _legend(axes)
        return _png(figure)


def _legend(axes: Any) -> None:
    """The legend above the axes, where it hides no data."""
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.2)


def _panels(height_in: float, columns: int = 1) -> tuple[Figure, Any]:
    figure = Figure(figsize=(WIDTH_IN, height_in), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(1, columns)


def residual_size(t: Traces) -> tuple[float, str]:
    """Factor and unit that suit the residual of the declared model."""
    return size_of("_rad", [float(np.abs(t.residual_before_rad).max())])


def _means(values: Floats, residual: Floats) -> tuple[Floats, Floats]:
    """Means over bins of equal width that hold enough points."""
    edges = np.linspace(values.min(), values.max(), BINS + 1)
    index = np.clip(np.digitize(values, edges) - 1, 0, BINS - 1)
    count = np.bincount(index, minlength=BINS)
    busy = count >= 5
    means = np.bincount(index, residual, BINS)[busy] / count[busy]
    return (0.5 * (edges[1:] + edges[:-1]))[busy], means


def first_used(t: Traces) -> int:
    """First index after the half sweep that is left out."""
    return int(np.argmax(t.used > 0.5))


def _png(figure: Figure) -> bytes:
    buffer = BytesIO()
    figure.savefig(buffer, format="png", dpi=110, metadata={"Software": None})
    return buffer.getvalue()
