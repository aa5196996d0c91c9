"""A cable's path without a gap or a kink between its pieces, and how near it comes to its own last turn."""

from math import tau
from typing import Any

import numpy as np

from mbcdm_cad.layouts.miso_bevel.cable_path import cable_path
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive, BevelRun
from mbcdm_cad.routes.curves import Helix


def assert_joined(path: Any) -> None:
    """Each piece of a cable's path begins where the one before ends, in its direction."""
    for (one, before), (two, after) in zip(path.pieces[:-1], path.pieces[1:], strict=True):
        gap = np.abs(before.points(np.array([1.0])) - after.points(np.array([0.0]))).max()
        kink = np.abs(before.tangent(1.0) - after.tangent(0.0)).max()
        assert gap < 1e-9 and kink < 1e-9, f"{path.cable.name}, {one} to {two}: {gap} mm, {kink}"


def self_clearance_mm(drive: BevelDrive, cable: BevelRun, drum_angle_rad: float) -> float:
    """Centre-line distance less d between the leaving span and the turn wound just before it (negative: they overlap).

    The fleet angle leads the span back over its own last turn, most at the fully wound end.
    """
    path = cable_path(drive, cable, 1.0, 1.0, drum_angle_rad)
    helix = path.piece("helix")
    assert isinstance(helix, Helix)
    per_turn = tau / abs(helix.angle_end - helix.angle_start)
    span = path.only(("span_in",)).sample(0.02)
    line = path.piece("span")
    span = np.concatenate([span, line.points(np.linspace(0.0, min(1.0, 8.0 / line.length_mm), 400))])
    span = np.concatenate([helix.points(np.linspace(1.0 - per_turn / 4, 1.0, 200)), span])
    turn = helix.points(np.linspace(max(0.0, 1.0 - 1.5 * per_turn), 1.0 - 0.5 * per_turn, 2000))
    best = np.inf
    for chunk in np.array_split(span, 8):
        gap = np.linalg.norm(chunk[:, None, :] - turn[None, :, :], axis=2).min()
        best = min(best, float(gap))
    return best - drive.cable.diameter_mm
