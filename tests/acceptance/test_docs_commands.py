"""Run the commands and scripts of the docs unchanged, page by page, in an empty folder with the params.

The word after the language of a code block states its needs: ``build`` and ``loop`` run with the slow tests,
``viewer`` needs a program that the tests do not have and is only compiled.
"""

import os
import re
import shlex
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import nbformat
import numpy as np
import pytest
import yaml
from nbclient import NotebookClient

from mbcdm_cad.checks.run import Budget, run_check
from mbcdm_cad.cli import run
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.loader import layout_of, load_text, short_design_text
from tests.support.checked import of_params
from tests.support.reference import ROOT

PAGES = ("tour.md", *(f"how-to/{path.name}" for path in sorted((ROOT / "docs/how-to").glob("*.md"))))
_BLOCK = re.compile(r"^```(sh|python)(?: (\w+))?\n(.*?)^```$", re.M | re.S)


@dataclass(frozen=True)
class Block:
    """One code block: its language, what it takes, its text."""

    language: str
    takes: str
    text: str


def blocks(page: str) -> list[Block]:
    """Those of a page that can be run, in order."""
    return [Block(m[1], m[2] or "", m[3]) for m in _BLOCK.finditer((ROOT / "docs" / page).read_text("utf-8"))]


def do(block: Block) -> None:
    """Run a block in the current folder. Fails where a command does not end with 0."""
    if block.language == "python":
        code = compile(block.text, "the docs", "exec")
        if block.takes != "viewer":
            exec(code, {})
        return
    for line in block.text.splitlines():
        words = shlex.split(line, comments=True)
        if words:
            assert words[0] == "mbcdm", f"{line}: not a command of ours"
            assert run(words[1:]) == 0, line


@pytest.fixture
def empty(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "params").symlink_to(ROOT / "params")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("page", PAGES)
def test_the_short_blocks_of_a_page_run(page: str, empty: Path) -> None:
    found = [block for block in blocks(page) if block.takes in ("", "viewer")]
    if not found:
        pytest.skip("no code block that can be run")
    for block in found:
        do(block)


@pytest.mark.slow
@pytest.mark.parametrize("page", [page for page in PAGES if any(b.takes in ("build", "loop") for b in blocks(page))])
def test_all_blocks_of_a_page_run(page: str, empty: Path) -> None:
    for block in blocks(page):
        do(block)


def test_the_readme_shows_what_check_prints(empty: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """But for the places where the lines are broken."""
    assert run(["init", "mine.yaml", "--reference"]) == 0
    text = Path("mine.yaml").read_text()
    assert "type: FF-081" in text
    Path("mine.yaml").write_text(text.replace("type: FF-081", "type: 7x7-1.0"))
    capsys.readouterr()
    assert run(["check", "mine.yaml", "--failed"]) == 1
    shown = re.search(r"^```\n(fail .*?)^```$", (ROOT / "README.md").read_text("utf-8"), re.M | re.S)
    assert shown is not None
    assert shown[1].split() == capsys.readouterr().out.split()


def test_a_command_that_fails_fails_this_test(empty: Path) -> None:
    with pytest.raises(AssertionError, match=r"check none\.yaml"):
        do(Block("sh", "", "mbcdm check none.yaml\n"))


NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_runs_and_shows_something_in_its_last_cell(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "params").symlink_to(ROOT / "params")
    # The command stands beside the interpreter; a shell need not have that folder on its path.
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    notebook = nbformat.read(path, as_version=4)
    NotebookClient(notebook, timeout=600, resources={"metadata": {"path": str(tmp_path)}}).execute()
    assert notebook.cells[-1].outputs, f"{path.name}: nothing is shown at its end"


def test_is_kept_without_outputs() -> None:
    assert len(NOTEBOOKS) >= 3
    for path in NOTEBOOKS:
        cells = nbformat.read(path, as_version=4).cells
        kept = [
            k for k, cell in enumerate(cells) if cell.cell_type == "code" and (cell.outputs or cell.execution_count)
        ]
        assert not kept, f"{path.name}: cells {kept} hold outputs; clear them before committing"


GALLERY = sorted((Path(__file__).parents[2] / "params" / "gallery").glob("*.yaml"))


# Two by default: half of the gallery has one or none. "twice" names its rope, too thick for its radii. A
# printer holds 0.1 mm, more than four gaps of a bevel drive allow: "printed" needs its parts selected or turned.
MOST_WARNINGS = {"twice": 3, "printed": 4}


def test_there_is_a_gallery() -> None:
    assert len(GALLERY) >= 12


@pytest.mark.parametrize("path", GALLERY, ids=lambda path: path.stem)
def test_a_short_file_gives_a_drive_that_passes(path: Path) -> None:
    lines = [line for line in path.read_text("utf-8").splitlines() if line and not line.startswith("#")]
    assert len(lines) <= 10, lines
    drive = of_params(f"gallery/{path.stem}").drive
    subject = layout_of(drive)
    with np.errstate(all="ignore"):
        found = [run_check(check, subject, Budget(0)) for check in checks_of(drive)]
    assert {check.id: check.message for check in found if check.status == "fail"} == {}
    # Warnings that a file's own fixed values cause are left; none is about torque, which sizing chooses motors for.
    warned = {check.id: check.remedy for check in found if check.status == "warn"}
    assert len(warned) <= MOST_WARNINGS.get(path.stem, 2), warned
    assert not {"gearhead_continuous", "motor_losses", "life_shown"} & set(warned), warned
    assert all(warned.values()), warned
    # Below the maker's least D/d only where the file itself names the rope.
    assert "bend_ratio_minimum" not in warned or "rope: {type:" in path.read_text("utf-8"), warned


@pytest.mark.parametrize("layout", ["miso_bevel", "siso_spur", "miso_spur", "siso_bevel"])
def test_the_starting_file_gives_a_drive_with_at_most_one_warning(layout: str) -> None:
    drive = load_text(short_design_text("new", layout)).drive
    found = [run_check(check, layout_of(drive), Budget(0)) for check in checks_of(drive)]
    told = {check.id: check.message for check in found if check.status in ("fail", "warn")}
    # A small bearing of the guide may be heard: neither torque nor life.
    assert set(told) <= {"quiet_running"}, told


Edit = Callable[[dict[str, Any]], None]


def requirements() -> dict[str, Any]:
    """Tables 1 and 2 of the paper, its parts, and what is asked here."""
    return {
        "name": "edited",
        "configuration": "miso_bevel",
        "travel": {"half_angle_deg": 35.0},
        "transmission": {
            "centre_distance_mm": 34.6,
            "drum_radii_mm": [54.0, 57.6, 61.2, 64.8],
            "ratios": {"input_to_guide": 1.5, "guide_to_drum": 6.0},
        },
        "rope": {
            "type": "FF-081",
            "modulus_GPa": 54.0,
            "modulus_area": "metallic",
            "friction_coefficient": 0.15,
            "preload_N": 70.0,
        },
        "drive": {
            "motor": "motor-2.9mNm-15",
            "gearhead": "gearhead-76-16",
            "encoder": "encoder-17",
            "drum_encoder": "encoder-24-ring",
        },
        "loads": {"test_torque_Nm": 0.91, "peak_torque_Nm": 1.0},
        "limits": {"bend_ratio_min": 10.0, "losses": "paper"},
    }


def distance(length_mm: float) -> Edit:
    return lambda data: data["transmission"].update(centre_distance_mm=length_mm)


def ratio(name: str, value: float) -> Edit:
    return lambda data: data["transmission"]["ratios"].update({name: value})


def travel(half_deg: float) -> Edit:
    return lambda data: data["travel"].update(half_angle_deg=half_deg)


def scaled(factor: float) -> Edit:
    def edit(data: dict[str, Any]) -> None:
        block = data["transmission"]
        block["centre_distance_mm"] *= factor
        block["drum_radii_mm"] = [radius * factor for radius in block["drum_radii_mm"]]

    return edit


EDITS: dict[str, Edit] = {
    **{f"L {length:g}": distance(length) for length in (30.0, 32.0, 36.5, 38.0, 42.0, 48.0, 55.0, 62.0)},
    **{f"guide_to_drum {i:g}": ratio("guide_to_drum", i) for i in (4.0, 5.0, 5.5, 6.5, 7.0, 8.0)},
    **{f"input_to_guide {i:g}": ratio("input_to_guide", i) for i in (1.2, 1.35, 1.7, 2.0)},
    **{f"travel {half:g}": travel(half) for half in (20.0, 45.0, 60.0)},
    **{f"scale {factor:g}": scaled(factor) for factor in (0.9, 1.05, 1.5, 2.0)},
}
# Requirements that exclude each other, and the check that shows it.
EXCLUDED = {
    "guide_to_drum 8": "land_width",  # the guide rises by 0.45 mm a step; half a rope and a broken edge need 0.505
    "input_to_guide 2": "bearing_shoulders",  # 4.5 mm hold no stop of a 0.81 mm rope round a journal for a 3 mm shaft
    "travel 60": "input_walk",  # steps of 3.6 mm have no room for the walk at a lead that clears itself
}


def failing(data: dict[str, Any]) -> dict[str, str]:
    """Checks that fail, with their messages; remedies are not looked for."""
    drive = load_text(yaml.safe_dump(data)).drive
    subject = layout_of(drive)
    with np.errstate(all="ignore"):
        found = [run_check(check, subject, Budget(0)) for check in checks_of(drive)]
    return {check.id: check.message for check in found if check.status == "fail"}


@pytest.mark.parametrize("name", [name for name in EDITS if name not in EXCLUDED])
def test_one_edit_passes_without_a_second(name: str) -> None:
    data = requirements()
    EDITS[name](data)
    assert failing(data) == {}


@pytest.mark.parametrize("name", EXCLUDED)
def test_what_cannot_pass_fails_where_the_requirements_meet(name: str) -> None:
    data = requirements()
    EDITS[name](data)
    assert EXCLUDED[name] in failing(data)
