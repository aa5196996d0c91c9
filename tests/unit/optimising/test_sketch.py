"""The sketch of a design on the page of a search."""

from __future__ import annotations

import numpy as np
import pytest

import mbcdm_cad as mc
from mbcdm_cad.optimising.result import sketch


@pytest.mark.parametrize("layout", ["mbcdm", "siso_spur", "siso_bevel"])
def test_cables_lie_on_circles_of_their_radii(layout: str) -> None:
    drive = mc.load(f"params/{layout}.yaml").drive
    found = sketch(drive)
    assert len(found["cables"]) == len(drive.layout.cable_paths(0.0))
    circles = [np.array(circle) for circle in found["bodies"]]
    radii = {round(float(np.linalg.norm(c - c[:-1].mean(axis=0), axis=1).mean()), 1) for c in circles}
    drawn = {round(radius, 1) for _, _, radius in drive.layout.bends_mm()}
    assert drawn <= {r + step for r in radii for step in (-0.1, 0.0, 0.1)} | radii, (drawn, radii)
    # Where a cable ends on the drum it touches the circle of its own land.
    for line in found["cables"]:
        ends = min(np.linalg.norm(c - np.array(end), axis=1).min() for c in circles for end in (line[0], line[-1]))
        pitch = max(radii) * 2.0 * np.pi / 48
        assert ends < pitch, f"{ends:.2f} mm from the nearest circle, its points {pitch:.2f} mm apart"
