"""The drive of Fig. 1 (a), params/siso_spur.yaml, through the commands: check, analyse, simulate, loop, build."""

from __future__ import annotations

import json
import re
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from mbcdm_cad import cli

DESIGN = Path(__file__).parents[2] / "params" / "siso_spur.yaml"

# A rope two fifths softer than declared, turned through most of the travel.
EXPERIMENT = {
    "name": "soft",
    "about": "rope 40 percent softer than declared",
    "seed": 6,
    "duration_s": 80.0,
    "motion": {"shape": "sine", "amplitude_mrad": 300.0, "period_s": 20.0},
    "load": {"kind": "brake", "levels_Nm": [0.2, 0.5, 0.9]},
    "physics": {"cable_transport": False},
    "effects": [{"effect": "modulus", "share": -0.4}],
}


def run(*arguments: str) -> str:
    """Standard output of a command that must end well, run in this process."""
    with redirect_stdout(StringIO()) as stdout, redirect_stderr(StringIO()) as stderr:
        code = cli.run(list(arguments))
    assert code == 0, f"{arguments}: exit {code}\n{stdout.getvalue()}\n{stderr.getvalue()}"
    return stdout.getvalue()


def output(*arguments: str) -> Any:
    """What a command prints as JSON."""
    return json.loads(run(*arguments, "--json"))


def test_check_passes_and_shows_what_friction_holds() -> None:
    found = {c["id"]: c for c in output("check", str(DESIGN))["checks"]}
    failed = {name: c["message"] for name, c in found.items() if c["status"] == "fail"}
    assert not failed, failed
    assert found["input_slip"]["actual"] > 3.0
    assert found["input_sticks"]["actual"] > 100.0


def test_analyse_gives_the_motors_torque_times_the_ratio_and_the_slip() -> None:
    found = output("analyse", str(DESIGN))
    assert found["peak_torque_Nm"] == pytest.approx([2.9e-3 * 76.0 * 9.9] * 2, rel=1e-6)
    assert {limit["cause"] for limit in found["limits"]} >= {"motor", "strength", "slip"}
    assert "the cable slips on its input" in run("analyse", str(DESIGN))


@pytest.mark.slow
def test_loop_finds_the_soft_rope(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each side counts as a cable; with a free span of 25 mm modulus and friction can be told apart."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "soft.yaml").write_text(yaml.safe_dump(EXPERIMENT))
    run("simulate", str(DESIGN), "soft.yaml")
    run("loop", str(DESIGN), "out/soft/soft.yaml", "--json", "soft.json")
    named = json.loads((tmp_path / "soft.json").read_text())["sentence"]
    share = re.search(r"modulus of the rope: share (-?[\d.]+) %", named)
    assert share and float(share.group(1)) == pytest.approx(-40.0, abs=1.5), named


@pytest.mark.slow
def test_build_draws_all_parts_and_finds_no_clash(tmp_path: Path) -> None:
    run("build", str(DESIGN), "--jobs", "1", "--out", str(tmp_path))
    report = json.loads((tmp_path / "siso_spur" / "report.json").read_text())
    assert report["interference"]["clashes"] == []
    assert not [c for c in report["checks"] if c["status"] == "fail"]
    assert {"frame", "motor_head", "drum", "input_pulley_main", "cable_main", "stop_pin"} <= set(report["items"])
    moving = report["inertia_moving_g_mm2"]
    assert moving["inputs_at_drum"] > 0.0 and np.isfinite(moving["at_drum"])
