"""Plots of the loop's page: measured against predicted, residual against time, angle and load, spectrum of orders."""

from __future__ import annotations

from io import BytesIO
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from scipy.ndimage import uniform_filter1d

from mbcdm_cad.identification.result import Traces, size_of
from mbcdm_cad.measurement.vet_signals import GAP_STEPS
from mbcdm_cad.routes import Floats

MEASURED, BEFORE, AFTER = "#000000", "#D55E00", "#0072B2"
HELD = "#DDDDDD"
STYLE: dict[Any, Any] = {"font.size": 9.0, "axes.grid": True, "grid.alpha": 0.3, "legend.frameon": False}
WIDTH_IN = 9.6
BINS = 60
# Points over which the sense of motion is told, more than an encoder's step lasts.
SENSE_POINTS = 25


def time_png(t: Traces) -> bytes:
    """Drum angle measured and predicted, and the residual before and after, over time; held-out time is grey."""
    with mpl.rc_context(STYLE):
        figure, (above, below) = _panels(4.6, rows=2, shared=True)
        whole = _without_gaps(t.time_s)
        above.plot(t.time_s, 1e3 * t.output_rad * whole, color=MEASURED, lw=1.6, label="measured")
        above.plot(
            t.time_s,
            1e3 * (t.output_rad - t.residual_before_rad) * whole,
            color=BEFORE,
            lw=0.8,
            ls="--",
            label="predicted by the declared model",
        )
        above.set_ylabel("output (mrad)")
        factor, unit = _size(t)
        below.plot(t.time_s, t.residual_before_rad / factor * whole, color=BEFORE, lw=0.8, label="before")
        below.plot(t.time_s, t.residual_after_rad / factor * whole, color=AFTER, lw=0.8, label="after")
        below.set(xlabel="time (s)", ylabel=f"measured - predicted ({unit})")
        for axes in (above, below):
            label = "held out"
            for begin, end in _spans(t.held):
                axes.axvspan(t.time_s[begin], t.time_s[end], color=HELD, zorder=0, label=label)
                label = ""
            end = _first_used(t)
            if end:
                axes.axvspan(
                    t.time_s[0], t.time_s[end], fill=False, hatch="//", ec="#BBBBBB", lw=0.0, zorder=0, label="left out"
                )
            axes.set_xlim(t.time_s[0], t.time_s[-1])
            _legend(axes)
        return _png(figure)


def loop_png(t: Traces, ideal_rad: Floats) -> bytes:
    """Transmission error over the output: what hysteresis is seen by. ``ideal_rad`` (n,): inputs through the ratio."""
    with mpl.rc_context(STYLE):
        figure, axes = _panels(3.6)
        error = t.output_rad - ideal_rad
        error = error - np.median(error)
        factor, unit = size_of("_rad", [float(np.abs(error).max())])
        from_here = slice(_first_used(t), None)
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
        from_here = slice(_first_used(t), None)
        variables = [("output (mrad)", 1e3 * t.output_rad[from_here])]
        if t.load_Nm is not None:
            variables.append(("load torque (N m)", t.load_Nm[from_here]))
        rising = np.gradient(uniform_filter1d(t.output_rad[from_here], SENSE_POINTS)) >= 0.0
        figure, panels = _panels(3.4, columns=len(variables))
        factor, unit = _size(t)
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


def orders_png(t: Traces, chain_orders: dict[str, float]) -> bytes:
    """Amplitude of the residual over cycles a turn of the output, with what turns once in the chain marked."""
    with mpl.rc_context(STYLE):
        figure, axes = _panels(3.2)
        factor, unit = _size(t)
        axes.loglog(t.orders, t.amplitude_before_rad / factor, color=BEFORE, lw=0.8, label="before")
        axes.loglog(t.orders, t.amplitude_after_rad / factor, color=AFTER, lw=0.8, label="after")
        top = float(max(t.amplitude_before_rad.max(), t.amplitude_after_rad.max())) / factor
        axes.set_ylim(1e-4 * top, 3.0 * top)
        axes.set_xlim(0.8 * min([*chain_orders.values(), float(t.orders[0])]), float(t.orders[-1]))
        for name, order in chain_orders.items():
            axes.axvline(order, color="#444444", lw=0.8, ls=":")
            axes.annotate(name, (order, 2.0 * top), rotation=90, ha="right", va="top", fontsize=8, color="#444444")
        axes.axvspan(axes.get_xlim()[0], float(t.orders[0]), color=HELD, zorder=0)
        axes.set(
            xlabel="cycles a turn of the output (grey: too few cycles over this travel to be told)",
            ylabel=f"amplitude ({unit})",
        )
        _legend(axes)
        return _png(figure)


def _legend(axes: Any) -> None:
    """Above the axes, where it hides nothing."""
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.2)


def _panels(height_in: float, rows: int = 1, columns: int = 1, shared: bool = False) -> tuple[Figure, Any]:
    figure = Figure(figsize=(WIDTH_IN, height_in), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(rows, columns, sharex=shared)


def _size(t: Traces) -> tuple[float, str]:
    return size_of("_rad", [float(np.abs(t.residual_before_rad).max())])


def _means(values: Floats, residual: Floats) -> tuple[Floats, Floats]:
    """Means over bins of equal width that hold enough points."""
    edges = np.linspace(values.min(), values.max(), BINS + 1)
    index = np.clip(np.digitize(values, edges) - 1, 0, BINS - 1)
    count = np.bincount(index, minlength=BINS)
    busy = count >= 5
    means = np.bincount(index, residual, BINS)[busy] / count[busy]
    return (0.5 * (edges[1:] + edges[:-1]))[busy], means


def _without_gaps(time_s: Floats) -> Floats:
    """1 at each point, NaN at the first after a pause in logging, so that no line is drawn over it."""
    steps = np.diff(time_s, prepend=time_s[0])
    return np.where(steps > GAP_STEPS * np.median(steps), np.nan, 1.0)


def _first_used(t: Traces) -> int:
    """First index beyond the half sweep that is left out."""
    return int(np.argmax(t.used > 0.5))


def _spans(held: Floats) -> list[tuple[int, int]]:
    """First and last index of every stretch that is held out."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], (held > 0.5).astype(np.int8), [0]))))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _png(figure: Figure) -> bytes:
    buffer = BytesIO()
    figure.savefig(buffer, format="png", dpi=110, metadata={"Software": None})
    return buffer.getvalue()
