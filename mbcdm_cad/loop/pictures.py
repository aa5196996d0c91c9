"""Pictures of the loop's page, for too many points, and its interactive charts as plain data."""

from io import BytesIO
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator
from scipy.ndimage import uniform_filter1d

from mbcdm_cad.loop.readable import size_of
from mbcdm_cad.loop.result import BodePicture, ReadingsPicture, Traces
from mbcdm_cad.measurement.vet_signals import GAP_STEPS
from mbcdm_cad.routes import Floats

MEASURED, BEFORE, AFTER = "#000000", "#D55E00", "#0072B2"
PREDICTED: list[dict[str, Any]] = [
    {"color": BEFORE, "label": "declared model"},
    {"color": AFTER, "label": "with what was found"},
]
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
        for residual, how in zip((t.residual_before_rad, t.residual_after_rad), PREDICTED, strict=True):
            axes.plot(angle, (error - residual)[from_here] / factor, lw=0.8, **how)
        axes.set(xlabel="output (mrad)", ylabel=f"output - inputs/ratio ({unit})")
        _legend(axes)
        return _png(figure)


def readings_png(p: ReadingsPicture) -> bytes:
    """Few readings, and what the model predicts between them."""
    with mpl.rc_context(STYLE):
        figure, axes = _panels(4.2)
        factor, unit = size_of("_rad", [float(np.abs(p.read_rad).max())])
        for line, how in zip((p.before_rad, p.after_rad), PREDICTED, strict=True):
            axes.plot(p.line_at, line / factor, lw=1.0, **how)
        for kept, face, word in ((p.held < 0.5, MEASURED, "read"), (p.held > 0.5, "white", "held back")):
            axes.plot(
                p.at[kept], p.read_rad[kept] / factor, ls="", marker="o", ms=5.0, mec=MEASURED, mfc=face, label=word
            )
        axes.set(xlabel=p.axis, ylabel=f"{p.title} ({unit})", xscale="log" if p.logarithmic else "linear")
        _legend(axes)
        return _png(figure)


def bode_png(p: BodePicture) -> bytes:
    """Gain, phase and coherence over frequency, measured and predicted."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH_IN, 6.4), layout="constrained")
        FigureCanvasAgg(figure)
        gain, phase, coherence = figure.subplots(3, 1, sharex=True, height_ratios=(3, 2, 1))
        for axes, of in ((gain, np.abs), (phase, lambda row: np.degrees(np.unwrap(np.angle(row))))):
            axes.plot(p.frequency_Hz, of(p.measured), ls="", marker=".", ms=3.0, color=MEASURED, label="measured")
            for response, how in zip((p.before, p.after), PREDICTED, strict=True):
                axes.plot(p.frequency_Hz, of(response), lw=1.0, **how)
        coherence.plot(p.frequency_Hz, p.coherence, color=MEASURED, lw=0.8)
        gain.set(ylabel="rad/(N m)" if p.over_torque else "gain", xscale="log", yscale="log")
        for axis in (gain.yaxis, coherence.xaxis):
            axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axis.set_major_formatter("{x:g}")
            axis.set_minor_formatter("")
        phase.set(ylabel="phase (deg)")
        coherence.set(xlabel="frequency (Hz)", ylabel="coherence", ylim=(0.0, 1.05))
        _legend(gain)
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


# Colours of the page's palette: measured, predicted by the declared model, predicted with the effects found.
CHART_MEASURED, CHART_BEFORE, CHART_AFTER = 0, 2, 1
_DIGITS = 5


def time_charts(t: Traces) -> dict[str, dict[str, Any]]:
    """Output measured and predicted, mrad, and the residual before and after, both over time in s."""
    factor, unit = residual_size(t)
    time = _plain(t.time_s)
    bands = [{"kind": "held", "from": time[a], "to": time[b]} for a, b in _spans(t.held)]
    end = first_used(t)
    if end:
        bands.append({"kind": "out", "from": time[0], "to": time[end]})
    gaps = _gaps(t.time_s)

    def line(label: str, values: Floats, colour: int) -> dict[str, Any]:
        return {"label": label, "x": time, "y": _plain(values, gaps), "colour": colour}

    output = [
        line("measured", 1e3 * t.output_rad, CHART_MEASURED),
        line("predicted by the declared model", 1e3 * (t.output_rad - t.residual_before_rad), CHART_BEFORE),
    ]
    residual = [
        line("before", t.residual_before_rad / factor, CHART_BEFORE),
        line("after", t.residual_after_rad / factor, CHART_AFTER),
    ]
    x = {"label": "time", "unit": "s"}
    return {
        "output": {
            "title": "Measured against predicted, over time",
            "x": x,
            "y": {"label": "output", "unit": "mrad"},
            "lines": output,
            "bands": bands,
        },
        "residual": {
            "title": "What is left over time, before and after",
            "x": x,
            "y": {"label": "measured - predicted", "unit": _micro(unit)},
            "lines": residual,
            "bands": bands,
        },
    }


def orders_chart(t: Traces, chain_orders: dict[str, float]) -> dict[str, Any]:
    """Amplitude of the residual over cycles a turn of the output, with what turns once in the chain marked."""
    factor, unit = residual_size(t)
    orders = _plain(t.orders)
    begin = 0.8 * min([*chain_orders.values(), float(t.orders[0])])
    return {
        "title": "Orders of what is left",
        "x": {"label": "cycles a turn of the output", "unit": "", "log": True, "from": begin},
        "y": {"label": "amplitude", "unit": _micro(unit), "log": True},
        "lines": [
            {"label": label, "x": orders, "y": _plain(values / factor, values <= 0.0), "colour": colour}
            for label, values, colour in (
                ("before", t.amplitude_before_rad, CHART_BEFORE),
                ("after", t.amplitude_after_rad, CHART_AFTER),
            )
        ],
        "marks": [{"at": at, "label": name} for name, at in chain_orders.items()],
        "bands": [{"kind": "held", "from": begin, "to": orders[0]}],
    }


def _plain(values: Floats, left_out: Any = None) -> list[float | None]:
    found: list[float | None] = [float(f"{value:.{_DIGITS}g}") for value in values]
    if left_out is not None:
        found = [None if gone else value for value, gone in zip(found, left_out, strict=True)]
    return found


def _gaps(time_s: Floats) -> Any:
    """True at the first point after a pause in logging, so that no line is drawn over it."""
    steps = np.diff(time_s, prepend=time_s[0])
    return steps > GAP_STEPS * np.median(steps)


def _spans(held: Floats) -> list[tuple[int, int]]:
    """First and last index of every stretch that is held out."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], (held > 0.5).astype(np.int8), [0]))))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _micro(unit: str) -> str:
    return unit.replace("urad", "\N{MICRO SIGN}rad").replace("um", "\N{MICRO SIGN}m")
