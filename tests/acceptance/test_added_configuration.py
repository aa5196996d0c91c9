"""A layout is added by one folder of six files: the small one of tests/support runs through all commands.

It has two cables, one input, no guide, a drum on a parallel axis, and boxes and cylinders as parts.
"""

import importlib
import json
import sys
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from mbcdm_cad import cli
from mbcdm_cad.layouts import registry

SUPPORT = Path(__file__).parents[1] / "support"
# A rope a fifth softer than declared, turned through most of the travel.
EXPERIMENT = {
    "name": "soft",
    "about": "rope 20 percent softer than declared",
    "seed": 6,
    "duration_s": 160.0,
    "motion": {"shape": "sine", "amplitude_mrad": 300.0, "period_s": 20.0},
    "load": {"kind": "brake", "levels_Nm": [0.15, 0.3, 0.45]},
    "physics": {"cable_transport": False},
    "effects": [{"effect": "modulus", "share": -0.2}],
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder with the design, while the layout is known."""
    patch = pytest.MonkeyPatch()
    patch.syspath_prepend(str(SUPPORT))
    added = dict(registry._added)
    registry.add(importlib.import_module("parallel_drive.layout").LAYOUT)
    work = tmp_path_factory.mktemp("added")
    patch.setenv("MBCDM_CACHE_DIR", str(work / "cache"))
    patch.chdir(work)
    (work / "parallel.yaml").write_bytes((SUPPORT / "parallel_drive" / "design.yaml").read_bytes())
    yield work
    patch.undo()
    registry._added.clear()
    registry._added.update(added)
    for name in [name for name in sys.modules if name.partition(".")[0] == "parallel_drive"]:
        del sys.modules[name]


def run(*arguments: str, code: int = 0) -> str:
    """Standard output of a command of the program, run in this process, where the layout is known."""
    with redirect_stdout(StringIO()) as stdout, redirect_stderr(StringIO()) as stderr:
        ended = cli.run(list(arguments))
    text = stdout.getvalue()
    assert ended == code, f"{arguments}: exit {ended}\n{text}\n{stderr.getvalue()}"
    return text


def output(*arguments: str) -> Any:
    """What a command prints as JSON."""
    return json.loads(run(*arguments, "--json"))


def test_the_folder_has_at_most_six_files() -> None:
    files = [path.name for path in (SUPPORT / "parallel_drive").iterdir() if path.is_file()]
    assert len(files) <= 6, files


def test_check_passes_and_names_its_own_checks(folder: Path) -> None:
    found = {c["id"]: c for c in output("check", "parallel.yaml")["checks"]}
    failed = {name: c["message"] for name, c in found.items() if c["status"] == "fail"}
    assert not failed, failed
    # 20 deg reserve and 4 times the whole travel of 60 deg.
    assert found["input_wrap"]["actual"] == pytest.approx(260.0)
    # D/d of the input pulley, the smallest.
    assert found["bend_ratio"]["actual"] == pytest.approx(15.0 / 0.81)


def test_analyse_gives_what_two_equal_cables_give(folder: Path) -> None:
    found = output("analyse", "parallel.yaml")
    span = np.sqrt(50.0**2 - 37.5**2)
    for cable in found["cables"]:
        assert cable["free_span_mm"] == pytest.approx(span)
        assert cable["total_ratio"] == pytest.approx(4.0)
    # Both cables turn by the same torque, so neither direction is the stronger one.
    assert found["peak_torque_Nm"][0] == pytest.approx(found["peak_torque_Nm"][1])
    assert "cable" in run("analyse", "parallel.yaml")


def test_simulate_and_loop_find_the_soft_rope(folder: Path) -> None:
    (folder / "soft.yaml").write_text(yaml.safe_dump(EXPERIMENT))
    run("simulate", "parallel.yaml", "soft.yaml")
    run("loop", "parallel.yaml", "out/soft/soft.yaml", "--json", "soft.json")
    found = json.loads((folder / "soft.json").read_text())
    names = [effect["name"] for effect in found["effects"]]
    assert names == ["stiffness_error"], found["sentence"]
    share = found["effects"][0]["parameters"]["share"]
    assert share["ci95"][0] < -0.2 < share["ci95"][1], share


def test_build_draws_it_and_finds_no_clash(folder: Path) -> None:
    run("build", "parallel.yaml", "--jobs", "1")
    report = json.loads((folder / "out" / "parallel" / "report.json").read_text())
    assert report["interference"]["clashes"] == []
    assert {"base", "drum", "input_pulley_main", "motor_main", "cable_up", "cable_down"} == set(report["items"])
    drum = report["parts"]["drum"]["volume_mm3"]
    assert drum == pytest.approx(np.pi * (30.0 - 0.405) ** 2 * 6.0, rel=1e-6)
    assert report["frame"] is None
    # Drum and input turn in one sense; the input's share is its own inertia times 16.
    moving = report["inertia_moving_g_mm2"]
    assert moving["inputs_at_drum"] > 0.0 and moving["at_drum"] > moving["drum_group"]
    text = (folder / "out" / "parallel" / "report.md").read_text()
    assert "the input stands at x = +L" in text and "| up |" in text
