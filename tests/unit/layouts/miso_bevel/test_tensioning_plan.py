"""The tensioning plan if one cable has another preload than the others."""

from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np
import pytest

from mbcdm_cad.layouts.miso_bevel.assembly_order import assembly_order
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.path_figures import plan
from mbcdm_cad.model.tensioning import balanced_tension_N

from .designs import reference


@pytest.mark.parametrize("apart", [0, 1, 2, 3])
def test_one_cable_at_50_N_is_set_where_the_drum_comes_to_rest(apart: int) -> None:
    """The last pull leaves the tensions at which the drum balances, by an equilibrium of springs solved here."""
    drive = reference()
    cables = tuple(replace(c, preload_N=50.0 if k == apart else 70.0) for k, c in enumerate(drive.cables))
    lay = BevelLayout(replace(drive, cables=cables))
    found = plan(lay)
    length = np.array([path.length_mm for path in lay.cable_paths(0.0)])
    stiffness = drive.cable.axial_stiffness_N / length * 1e3
    lever = np.array([-c.drum_side * c.drum_radius_mm * 1e-3 for c in drive.cables])
    preload = np.array([c.preload_N for c in cables])
    # T = T0 - k l theta with the sum of l T zero.
    theta = (lever * preload).sum() / (stiffness * lever**2).sum()
    expected = preload - stiffness * lever * theta
    assert found.pulls[-1].tension_N == pytest.approx(expected, rel=0.02)
    assert abs((lever * balanced_tension_N(stiffness, lever, preload / stiffness)).sum()) < 1e-9
    assert found.cables[apart].turns_from_slack < min(
        c.turns_from_slack for k, c in enumerate(found.cables) if k != apart
    )
    text = " ".join(step.text for step in assembly_order(lay))
    assert "50" in text and "nan" not in text.lower()
    assert all(np.isfinite(v) for c in found.cables for v in (c.finished_m, c.turns_per_N)), asdict(found)
