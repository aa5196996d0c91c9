"""A wrap without an anchor, compared with the same wrap anchored and with its mirror image."""

from __future__ import annotations

from math import pi
from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.model.profiles import simulate_profiles
from mbcdm_cad.model.si import DriveSI, to_si
from mbcdm_cad.routes import Floats

TIME = np.linspace(0.0, 3.0, 241)
TURNED = 5.9 * np.sin(2 * pi * TIME)[None]
LOAD = 0.9 * np.sin(2 * pi * 0.6 * TIME) + 0.3


@pytest.fixture(scope="module")
def drive() -> DriveSI:
    """The reference of siso_spur."""
    return to_si(load_design(Path(__file__).parents[3] / "params" / "siso_spur.yaml").drive)


def drum_rad(drive: DriveSI, turned: Floats, load: Floats, through_rad: float | None) -> Floats:
    return simulate_profiles(drive, turned, load, None, True, through_rad).drum_angle_rad


def test_a_wrap_longer_than_travel_and_slip_acts_as_if_anchored(drive: DriveSI) -> None:
    """11.8 rad of travel and at most 3.3 of slip are less than the 18.1 of the design."""
    assert drive.through_wrap_rad is not None
    found = drum_rad(drive, TURNED, LOAD, float(drive.through_wrap_rad[0]))
    assert np.abs(found - drum_rad(drive, TURNED, LOAD, None)).max() < 1e-9


def test_a_short_wrap_lets_the_drum_creep_the_way_the_load_pushes(drive: DriveSI) -> None:
    steady = np.full_like(LOAD, 0.9)
    at_rest = [60 * n + 20 for n in range(1, 4)]
    for way in (1.0, -1.0):
        found = drum_rad(drive, TURNED, way * steady, 2 * pi) - TURNED[0] / 9.9
        crept = -way * np.diff(found[[n for n in at_rest if n < found.size]])
        assert (crept > 1e-4).all(), crept


def test_motion_and_load_turned_round_turn_the_creep_round(drive: DriveSI) -> None:
    one, other = drum_rad(drive, TURNED, LOAD, 3 * pi), drum_rad(drive, -TURNED, -LOAD, 3 * pi)
    assert np.ptp(one - drum_rad(drive, TURNED, LOAD, None)) > 1e-4
    assert np.abs(one + other).max() < 1e-9
