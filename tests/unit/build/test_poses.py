"""Poses of the interference run."""

from __future__ import annotations

import pytest

from mbcdm_cad.build.scene import travel_poses


def test_nine_poses_hold_both_ends_and_the_centre() -> None:
    poses = travel_poses(35.0, 9)
    assert poses == pytest.approx((-35, -26.25, -17.5, -8.75, 0, 8.75, 17.5, 26.25, 35), abs=1e-12)
    assert poses[0] == -35.0 and poses[-1] == 35.0 and poses[4] == 0.0
