"""Interactive charts of the loop's page as plain data: signals over time, spectrum of orders."""

from __future__ import annotations

from typing import Any

import numpy as np

from mbcdm_cad.loop.page.report_figures import first_used, residual_size
from mbcdm_cad.loop.result import Traces
from mbcdm_cad.measurement.vet_signals import GAP_STEPS
from mbcdm_cad.routes import Floats

# Colours of the page's palette: measured, predicted by the declared model, predicted with the effects found.
MEASURED, BEFORE, AFTER = 0, 2, 1
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
        line("measured", 1e3 * t.output_rad, MEASURED),
        line("predicted by the declared model", 1e3 * (t.output_rad - t.residual_before_rad), BEFORE),
    ]
    residual = [
        line("before", t.residual_before_rad / factor, BEFORE),
        line("after", t.residual_after_rad / factor, AFTER),
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
                ("before", t.amplitude_before_rad, BEFORE),
                ("after", t.amplitude_after_rad, AFTER),
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
