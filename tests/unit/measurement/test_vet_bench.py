"""Correct runs with every effect, and with causes outside the vocabulary, are neither refused nor doubted."""

from __future__ import annotations

from pathlib import Path

import pytest

from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.measurement.reading import load_measurement
from mbcdm_cad.measurement.vet import vet
from tests.support.bench_data import CASES, simulate_case, write_run

ROOT = Path(__file__).parents[3]
FEW = ("null", "ratio_radii", "lash_input_left", "slip_anchor", "drum_short")


@pytest.mark.parametrize(
    "name", [name if name in FEW else pytest.param(name, marks=pytest.mark.slow) for name in CASES]
)
def test_a_sound_run_is_judged_whatever_is_wrong_with_the_drive(name: str, tmp_path: Path) -> None:
    drive = load_design(ROOT / "params" / "mbcdm.yaml").drive
    write_run(tmp_path, "run", simulate_case(drive, name, 7), drive.input_names)
    found = vet(load_measurement(tmp_path / "run.yaml"), drive)
    assert not [str(finding) for finding in found if finding.level != "fact"]
