"""Figures of the exact cable paths: geometry of the layout, and its effect on the figures of the model."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.base import Layout, NoFigureError, PathFigures
from mbcdm_cad.model import DriveSI, ModelError, to_si
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.stiffness import sticking_response


def path_data(layout: Layout) -> dict[str, Any]:
    """Plain data of the paths, as in the report and in ``mbcdm analyse --json``."""
    figures = layout.path_figures
    length_m = np.array([cable.length_um for cable in figures.cables]) * 1e-6
    d = to_si(layout.drive)
    turn, pull = sticking_response(d, length_m)
    return {
        **asdict(figures),  # type: ignore[call-overload]
        "usable_deg": list(figures.usable_deg),
        "test_turn_mrad": _turns_with_real_wraps(d, figures, layout.drive.loads.test_torque_Nm),
        "drum_turn_urad": [float(v) for v in turn * 1e6],
        "tension_change_N": [[float(v) for v in row] for row in pull],
    }


def _turns_with_real_wraps(d: DriveSI, figures: PathFigures, load_Nm: float) -> dict[str, list[float]]:
    """Turn under + and - ``load_Nm`` at each drum angle, slip ending at the real anchors, mrad."""
    wraps = [np.radians([getattr(c, name) for c in figures.cables]) for name in ("input_wrap_deg", "drum_wrap_deg")]
    real = d.spread(len(figures.drum_angle_deg)).with_(input_wrap_rad=wraps[0], drum_wrap_rad=wraps[1])
    idle = solve_equilibrium(real, 0.0).drum_angle_rad
    ways = {"positive": load_Nm, "negative": -load_Nm}
    return {
        name: [float(v) for v in (solve_equilibrium(real, load).drum_angle_rad - idle) * 1e3]
        for name, load in ways.items()
    }


def path_data_or_reason(drive: Drive) -> tuple[dict[str, Any] | None, str]:
    """As :func:`path_data`; (None, reason) if the dimensions have no solution, which ``mbcdm check`` explains."""
    try:
        return path_data(drive.layout), ""
    except (NoFigureError, ValueError, ZeroDivisionError, ModelError) as error:
        return None, str(error)


def path_lines(layout: Layout, paths: dict[str, Any]) -> Iterator[str]:
    """The paths for a terminal: the configuration's lines for each cable, then the travel."""
    ends = paths["drum_angle_deg"][0], paths["drum_angle_deg"][-1]
    yield "cable paths (wraps in deg, drum centred and at both ends of travel; walk and fleet angle at the ends):"
    for c in paths["cables"]:
        yield from layout.path_lines(c)
    longest = max(max(map(abs, c["length_um"])) for c in paths["cables"])
    pull = max(max(map(abs, row)) for row in paths["tension_change_N"])
    yield (
        f"  helix and fleet angle change the lengths by up to {longest:.1f} um over the travel: the drum turns by up "
        f"to {max(map(abs, paths['drum_turn_urad'])):.1f} urad, tensions change by up to {pull:.2f} N (wraps sticking)"
    )
    turned = [abs(v) for way in paths["test_turn_mrad"].values() for v in way]
    yield (
        f"  turn at the test torque with the real wraps: {min(turned):.4f} to {max(turned):.4f} mrad over the "
        "travel (the figures above are for endless wraps)"
    )
    low, high = paths["usable_deg"]
    drive = layout.drive
    middle = f", counted from {drive.middle_deg:+g} deg of the output" if drive.middle_deg else ""
    yield (
        f"usable travel {low:.2f} to {high:+.2f} deg (design {ends[0]:+g} to {ends[1]:+g}{middle}); limits in order:"
    )
    for name in ("limits_negative", "limits_positive"):
        yield "  " + "; ".join(f"{x['angle_deg']:+.2f} {x['cause']}" for x in paths[name][:4])
