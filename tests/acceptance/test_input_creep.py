"""A cable that creeps over the input of the plain capstan drive: rig and loop compared with marks on a rope.

The runs for the loop are made by tests/support/belt_bench.py, which is independent of model and rig.
"""

from __future__ import annotations

import json
from math import radians
from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad import cli
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive, spur
from mbcdm_cad.rig.experiment import read_experiment
from mbcdm_cad.rig.quasistatic import simulate
from tests.support.belt_bench import belt_of, run_belt, write_belt_run
from tests.support.bench_motion import Plan

PARAMS = Path(__file__).parents[2] / "params"
DESIGN = PARAMS / "siso_spur.yaml"
PLAN = Plan(amplitude_rad=0.6, frequency_hz=0.05, wave="sine", load="steps", duration_s=160.0)
WRAP_DEG = 540.0


@pytest.fixture(scope="module")
def drive() -> SpurDrive:
    """The reference of siso_spur."""
    return spur(load_design(DESIGN).drive)


@pytest.mark.slow
def test_rig_creeps_as_marks_on_a_rope_do(drive: SpurDrive) -> None:
    experiment = read_experiment(PARAMS / "experiments" / "siso_spur" / "input-creep.yaml")
    run = simulate(drive, experiment)
    plain = simulate(drive, experiment.model_copy(update={"effects": ()}))
    drum, _ = run_belt(belt_of(drive, radians(WRAP_DEG)), run.input_rad[0], run.load_Nm)
    crept = np.ptp(run.drum_rad - plain.drum_rad)
    missed = np.abs(run.drum_rad - drum).max()
    assert crept > 2e-4
    assert missed < 0.06 * crept, f"rig and rope differ by {missed * 1e6:.1f} of {crept * 1e6:.1f} urad"


@pytest.mark.slow
def test_loop_finds_the_wrap_that_is_there_and_no_creep_where_it_is_enough(drive: SpurDrive, tmp_path: Path) -> None:
    named = {}
    for wrap_deg in (WRAP_DEG, 1400.0):
        file = write_belt_run(tmp_path / f"{wrap_deg:g}", drive, radians(wrap_deg), PLAN, 3)
        assert cli.run(["loop", str(DESIGN), str(file), "--json", str(tmp_path / "found.json")]) == 0
        result = json.loads((tmp_path / "found.json").read_text())
        named[wrap_deg] = {e["name"]: e for e in result["effects"]}
    assert set(named[WRAP_DEG]) == {"winding_history", "input_creep"}, named[WRAP_DEG].keys()
    found = named[WRAP_DEG]["input_creep"]["parameters"]["wrap_deg"]
    assert found["value"] == pytest.approx(WRAP_DEG, rel=0.03), found
    assert set(named[1400.0]) == {"winding_history"}, named[1400.0].keys()
