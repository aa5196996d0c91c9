"""The check command: table, JSON, exit codes, and what it must not import."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from mbcdm_cad import cli
from mbcdm_cad.checks.registry import CHECKS
from mbcdm_cad.checks.result import CheckResult
from mbcdm_cad.design.template import new_design_text
from mbcdm_cad.report.check_text import counts, table

FIELDS = {
    "id", "title", "status", "actual", "limit", "unit", "margin", "message", "remedy", "source", "waived_reason",
}  # fmt: skip


def write(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "design.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_sound_design_exits_0_with_a_summary(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["check", str(write(tmp_path, new_design_text("sound")))]) == 0
    out, err = capsys.readouterr()
    lines = out.splitlines()
    assert err == "" and lines[-1].startswith("sound: ") and f"0 fail, 0 waived, of {len(CHECKS)} checks" in lines[-1]
    assert any(line.startswith("pass   land_width") and "0.6 >= 0.555 mm" in line for line in lines), out
    assert "\x1b" not in out


def test_failing_design_exits_1_and_says_what_to_do(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = new_design_text("thick").replace("type: FF-081 ", "type: 7x7-1.0 ").replace("modulus_GPa: 54.0 ", "")
    text = text.replace("  modulus_area: metallic ", "  ")
    text = text.replace("centre_distance_mm: 34.6", "centre_distance_mm: 38.0")
    path = write(tmp_path, text)
    assert cli.run(["check", str(path)]) == 1
    out, _ = capsys.readouterr()
    for remedy in (
        "choose a rope of at most 0.81 mm (such as FF-081) or lower transmission.ratios.input_to_guide from 1.5",
        "lower clearances.land_edge_mm from 0.15 to at most 0.1",
        "raise rope.helix_lead_mm from 0.87 to at least 1.07",
        "lower transmission.centre_distance_mm from 38 to at most",
    ):
        assert remedy in out, (remedy, out)


def test_json_has_all_fields(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["check", "--json", str(write(tmp_path, new_design_text("plain")))]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["design"] == "plain" and len(data["design_sha256"]) == 64
    assert all(set(check) == FIELDS for check in data["checks"])
    assert sum(data["summary"].values()) == len(CHECKS) == len(data["checks"]), data["summary"]


def test_unknown_waiver_exits_2(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = new_design_text("waived").replace("waivers: []", "waivers:\n  - {check: bend_ratios, reason: haste}\n")
    path = write(tmp_path, text)
    assert cli.run(["check", str(path)]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.startswith(f"{path}:") and "did you mean bend_ratio?" in err, err


def test_waived_failure_exits_0_and_is_printed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = new_design_text("waived").replace("peak_torque_Nm: 3.15", "peak_torque_Nm: 3.3 ")
    text = text.replace("waivers: []", "waivers:\n  - {check: motor_torque_back, reason: one way only}\n")
    assert cli.run(["check", str(write(tmp_path, text))]) == 0
    out = capsys.readouterr().out
    assert "waived motor_torque_back" in out and "waived: one way only" in out and "1 waived" in out, out


def test_table_of_a_handful() -> None:
    def result(status: str, **more: object) -> CheckResult:
        fields = {"actual": 1.0, "limit": 2.0, "margin": -1.0, "unit": "mm", "remedy": "turn it", **more}
        return CheckResult(id="x", title="T", status=status, message="m", source="s", **fields)  # type: ignore[arg-type]

    none = {"actual": None, "limit": None, "margin": None}
    results = [
        result("pass", margin=1.0, remedy=""),
        result("fail"),
        result("fail", **none),
        result("pass", waived_reason="why"),
        result("pass", limit=None, margin=None, remedy=""),
    ]
    lines = list(table("d", results, colour=True))
    assert lines[0].startswith("\x1b[32mpass") and "1 <= 2 mm" in lines[0], lines
    assert "1 >= 2 mm" in lines[1] and lines[3].strip() == "-> turn it", lines
    assert "not evaluated" in lines[4], lines
    assert any(line.strip() == "waived: why" for line in lines), lines
    assert lines[-1] == "d: 2 pass, 0 warn, 2 fail, 1 waived, of 5 checks"
    assert counts(results) == {"pass": 2, "warn": 0, "fail": 2, "waived": 1}


def test_check_imports_neither_the_kernel_nor_scipy(tmp_path: Path) -> None:
    path = write(tmp_path, new_design_text("light"))
    code = (
        "import sys; from mbcdm_cad import cli; cli.run(sys.argv[1:]);"
        "print(sorted({'cadquery', 'OCP', 'scipy', 'matplotlib', 'vtk', 'rich'} & set(sys.modules)), file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, "check", str(path)], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.stderr.strip() == "[]", done.stderr
