"""The drive of Fig. 1 (a) with two anchored cables, from a short file: check, analyse, simulate, loop, build."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
import yaml

from mbcdm_cad.layouts.loader import new_design_text
from tests.acceptance.test_siso_spur import DESIGN, output, run

# One of both preloads 15 percent low, turned through most of the travel.
EXPERIMENT = {
    "name": "low",
    "about": "one preload 15 percent lower than declared",
    "seed": 6,
    "duration_s": 40.0,
    "motion": {"shape": "sine", "amplitude_mrad": 300.0, "period_s": 20.0},
    "load": {"kind": "brake", "levels_Nm": [0.2, 0.9]},
    "physics": {"cable_transport": False},
    "effects": [{"effect": "preload", "cables": ["side_2"], "share": -0.15}],
}


@pytest.fixture(scope="module")
def design(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The short file that ``mbcdm init`` writes, with the one line that it names taken in."""
    path = tmp_path_factory.mktemp("anchored") / "two_cables.yaml"
    run("init", str(path), "--configuration", "siso_spur")
    path.write_text(path.read_text().replace("# cables: two_anchored", "cables: two_anchored"))
    assert yaml.safe_load(path.read_text())["transmission"]["cables"] == "two_anchored"
    return path


@pytest.fixture(scope="module")
def reference(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """params/siso_spur.yaml but for the cables, and for the box that follows: most of its parts are drawn already."""
    text = new_design_text("two", "siso_spur").replace("cables: continuous", "cables: two_anchored")
    path = tmp_path_factory.mktemp("anchored") / "two.yaml"
    path.write_text(text.replace("envelope_mm: [124.0, 98.2, 93.3]", "envelope_mm: [124.0, 98.2, 94.6]"))
    return path


def test_one_line_gives_a_whole_drive_that_passes(design: Path) -> None:
    found = {c["id"]: c for c in output("check", str(design))["checks"]}
    failed = {name: c["message"] for name, c in found.items() if c["status"] == "fail"}
    assert not failed, failed
    assert found["dead_turns"]["actual"] >= 0.5 and "input_slip" not in found


def test_stiffness_is_that_of_the_continuous_form(reference: Path) -> None:
    """All else alike the turn at the test torque is the same; only the slip is gone from the limits of torque."""
    one, two = output("analyse", str(DESIGN)), output("analyse", str(reference))
    assert two["peak_torque_Nm"] == pytest.approx(one["peak_torque_Nm"], rel=1e-12)
    assert {c["cause"] for c in one["limits"]} - {c["cause"] for c in two["limits"]} == {"slip"}
    for figure in ("reversal_swing_mrad", "sticking_stiffness_Nm_rad"):
        assert two[figure] == pytest.approx(one[figure], rel=1e-9), figure


@pytest.mark.slow
def test_loop_finds_the_low_preload(reference: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(reference.parent)
    Path("low.yaml").write_text(yaml.safe_dump(EXPERIMENT))
    run("simulate", str(reference), "low.yaml")
    run("loop", str(reference), "out/low/low.yaml", "--json", "low.json")
    named = json.loads(Path("low.json").read_text())["sentence"]
    share = re.search(r"preload_error side_2 \[one cable: share (-?[\d.]+) %", named)
    assert share and float(share.group(1)) == pytest.approx(-15.0, abs=0.6), named


@pytest.mark.slow
def test_build_draws_all_parts_and_finds_no_clash(reference: Path, tmp_path: Path) -> None:
    run("build", str(reference), "--jobs", "1", "--out", str(tmp_path))
    report = json.loads((tmp_path / "two" / "report.json").read_text())
    assert report["interference"]["clashes"] == []
    assert not [c for c in report["checks"] if c["status"] == "fail"]
    assert {"input_pulley_main", "stop_side_1", "stop_side_2", "cable_side_1", "cable_side_2"} <= set(report["items"])
    assert report["paths"]["wrap_deg"] is None
