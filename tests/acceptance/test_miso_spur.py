"""The drive of Fig. 1 (b), params/miso_spur.yaml, through the commands: check, analyse, simulate, loop, build."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
import yaml

from tests.acceptance.test_siso_spur import output, run

DESIGN = Path(__file__).parents[2] / "params" / "miso_spur.yaml"

# A rope two fifths softer than declared, turned through a tenth of the travel.
EXPERIMENT = {
    "name": "soft",
    "about": "rope 40 percent softer than declared",
    "seed": 6,
    "duration_s": 40.0,
    "motion": {"shape": "sine", "amplitude_mrad": 300.0, "period_s": 20.0},
    "load": {"kind": "brake", "levels_Nm": [0.6, 1.8]},
    "physics": {"cable_transport": False},
    "effects": [{"effect": "modulus", "share": -0.4}],
}


def test_check_passes_and_shows_how_the_inputs_share_the_load() -> None:
    found = {c["id"]: c for c in output("check", str(DESIGN))["checks"]}
    failed = {name: c["message"] for name, c in found.items() if c["status"] == "fail"}
    assert not failed, failed
    assert found["load_sharing"]["actual"] == pytest.approx(1.0)
    assert found["input_slip"]["actual"] > 3.0


def test_analyse_gives_twice_what_the_plain_drive_turns() -> None:
    found = output("analyse", str(DESIGN))
    assert found["peak_torque_Nm"] == pytest.approx([2 * 2.9e-3 * 76.0 * 9.9] * 2, rel=1e-6)
    assert {limit["cause"] for limit in found["limits"]} >= {"motor", "strength", "slip"}


@pytest.mark.slow
def test_loop_finds_the_soft_rope(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "soft.yaml").write_text(yaml.safe_dump(EXPERIMENT))
    run("simulate", str(DESIGN), "soft.yaml")
    run("loop", str(DESIGN), "out/soft/soft.yaml", "--json", "soft.json")
    named = json.loads((tmp_path / "soft.json").read_text())["sentence"]
    share = re.search(r"modulus of the rope: share (-?[\d.]+) %", named)
    assert share and float(share.group(1)) == pytest.approx(-40.0, abs=2.0), named
