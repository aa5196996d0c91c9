"""Checks on measured values of a build."""

from __future__ import annotations

from dataclasses import replace

import pytest

from mbcdm_cad.checks.size import envelope_check, interference_check, mass_check
from mbcdm_cad.design.blocks import Waiver
from mbcdm_cad.design.drive import Drive


@pytest.mark.parametrize(("mass", "status"), [(340.0, "pass"), (360.0, "pass"), (339.9, "fail"), (360.1, "fail")])
def test_mass(mass: float, status: str, drive: Drive) -> None:
    found = mass_check(drive, mass, 4.0)
    assert found.status == status and found.actual == pytest.approx(abs(mass - 350.0)), found
    assert "+- 4" in found.message and "342" in found.message, found.message


@pytest.mark.parametrize(("z", "status"), [(97.5, "pass"), (96.5, "pass"), (97.51, "fail"), (96.49, "fail")])
def test_envelope(z: float, status: str, drive: Drive) -> None:
    found = envelope_check(drive, (126.02, z, 34.8))
    assert found.status == status and found.actual == pytest.approx(abs(z - 97.0)) and "Z from" in found.message, found


def test_interference(drive: Drive) -> None:
    assert interference_check(drive, ()).status == "pass"
    found = interference_check(drive, ("a and b overlap", "c and d overlap"))
    assert found.status == "fail" and found.actual == 2.0 and "a and b overlap; c and d overlap" in found.message, found
    many = interference_check(drive, ["x"] * 9)
    assert many.message.count("x;") == 3, many.message


def test_waiver_reaches_them(drive: Drive) -> None:
    waived = replace(drive, waivers=(Waiver(check="mass", reason="a steel drum on purpose"),))
    found = mass_check(waived, 400.0, 4.0)
    assert found.status == "pass" and found.waived_reason == "a steel drum on purpose", found
