"""The table of the effect of a lower preload, compared with figures of the model."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.model import analyse
from mbcdm_cad.model.bulk import preload_table
from mbcdm_cad.model.capability import SLACK_SHARE, torque_at_slack_Nm
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.si import to_si

DRIVE = load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive


def test_the_row_of_the_design_is_its_analysis() -> None:
    (row,) = preload_table(DRIVE, (1.0,))
    analysis = analyse(DRIVE)
    assert row.preload_N == pytest.approx([c.preload_N for c in DRIVE.cables])
    assert row.at_inputs_Nm == pytest.approx(analysis.peak_torque_Nm)
    assert row.reversal_swing_mrad == pytest.approx(analysis.reversal_swing_mrad)


def test_less_preload_costs_lost_motion_and_gives_torque_at_the_inputs() -> None:
    """Sticking length grows as 1/T (Eq. 14), the bias on the inputs falls with T."""
    full, half = preload_table(DRIVE, (1.0, 0.6))
    assert half.turn_mrad > full.turn_mrad and half.reversal_swing_mrad > full.reversal_swing_mrad
    assert min(half.at_inputs_Nm) > min(full.at_inputs_Nm)
    assert half.slack_Nm[0] == pytest.approx(0.6 * full.slack_Nm[0], rel=1e-3), "all in proportion"


@pytest.mark.parametrize("ends", [(), DRIVE.layout.wraps_at_ends_rad])
def test_the_first_slack_is_where_a_cable_has_a_hundredth_left(ends: tuple[Mapping[str, Any], ...]) -> None:
    """With endless wraps, and with those that are there at both ends of the travel."""
    si = to_si(DRIVE)
    for direction in (1, -1):
        torque = float(torque_at_slack_Nm(si, direction, ends).min())
        poses = [si.with_(**wraps) for wraps in ends] or [si]
        left = [solve_equilibrium(pose, direction * torque).tension_N / si.preload_N for pose in poses]
        assert float(np.min(left)) == pytest.approx(SLACK_SHARE, abs=1e-4)
