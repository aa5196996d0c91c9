"""The exact cable paths as a design's figures: the geometry of the layout, and what its errors do to the model."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layout.layout import Layout, layout
from mbcdm_cad.layout.path_figures import path_figures
from mbcdm_cad.model import ModelError, to_si
from mbcdm_cad.model.stiffness import sticking_response


def path_data(dims: Layout) -> dict[str, Any]:
    """Plain data of the paths, as the report and ``mbcdm analyse --json`` hold them."""
    figures = path_figures(dims)
    length_m = np.array([cable.length_um for cable in figures.cables]) * 1e-6
    turn, pull = sticking_response(to_si(dims.drive), length_m)
    return {
        **asdict(figures),
        "usable_deg": list(figures.usable_deg),
        "drum_turn_urad": [float(v) for v in turn * 1e6],
        "tension_change_N": [[float(v) for v in row] for row in pull],
    }


def path_data_or_reason(drive: Drive) -> tuple[dict[str, Any] | None, str]:
    """As :func:`path_data`; (None, why) where the dimensions have no solution, which ``mbcdm check`` tells in full."""
    try:
        return path_data(layout(drive)), ""
    except (ValueError, ZeroDivisionError, ModelError) as error:
        return None, str(error)


def path_lines(paths: dict[str, Any]) -> Iterator[str]:
    """The paths for a terminal: one line a cable, then the travel."""
    ends = paths["drum_angle_deg"][0], paths["drum_angle_deg"][-1]
    yield "cable paths (wraps in deg with the drum centred and at its travel's ends; walk and fleet angle there):"
    for c in paths["cables"]:
        middle = len(c["drum_wrap_deg"]) // 2
        wound, on_drum = c["input_wrap_deg"], c["drum_wrap_deg"]
        yield (
            f"  {c['name']:<10} length {c['length_mm']:.2f} mm, span {c['free_span_mm']:.2f} mm, guide "
            f"{c['guide_wrap_deg']:.1f}, input {wound[middle]:.0f} ({wound[0]:.0f}, {wound[-1]:.0f}), drum "
            f"{on_drum[middle]:.1f} ({on_drum[0]:.1f}, {on_drum[-1]:.1f}); walk {max(c['axial_walk_mm']):.3f} mm, "
            f"fleet angle {max(c['fleet_angle_deg']):.3f} deg"
        )
        points = ("input_contact_mm", "guide_landing_mm", "transfer_mm", "drum_leaving_mm")
        yield "    tangent points (x, y, z) mm: " + "; ".join(
            f"{name.removesuffix('_mm').replace('_', ' ')} ({', '.join(f'{v:.3f}' for v in c[name])})"
            for name in points
        )
    longest = max(max(map(abs, c["length_um"])) for c in paths["cables"])
    pull = max(max(map(abs, row)) for row in paths["tension_change_N"])
    yield (
        f"  helix and fleet angle change the lengths by up to {longest:.1f} um over the travel: the drum turns by up "
        f"to {max(map(abs, paths['drum_turn_urad'])):.1f} urad, tensions change by up to {pull:.2f} N (wraps sticking)"
    )
    low, high = paths["usable_deg"]
    yield f"usable travel {low:.2f} to {high:+.2f} deg (design {ends[0]:+g} to {ends[1]:+g}); limits in order:"
    for name in ("limits_negative", "limits_positive"):
        yield "  " + "; ".join(f"{x['angle_deg']:+.2f} {x['cause']}" for x in paths[name][:4])
