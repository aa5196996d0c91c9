"""The command line is a thin shell: each command is a function of the package, and prints what the function gives."""

from __future__ import annotations

import inspect
import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import mbcdm_cad as mc
from mbcdm_cad import cli
from mbcdm_cad.cli.group import mbcdm
from tests.unit.solving.test_solve import PINNED

ROOT = Path(__file__).parents[3]
EXPERIMENT = ROOT / "params" / "experiments" / "null-short-brake.yaml"
# The functions of each command, in the package or of a design.
FUNCTIONS = {
    "analyse": ["DriveDesign.analyse"],
    "build": ["DriveDesign.build"],
    "catalogue": ["catalogue"],
    "check": ["DriveDesign.check"],
    "compare": ["compare"],
    "doctor": ["doctor"],
    "drawings": ["DriveDesign.drawings"],
    "explain": ["DriveDesign.explain", "DriveDesign.explain_graph"],
    "export": ["DriveDesign.export"],
    "init": ["new_design_text", "new_design"],
    "loop": ["close_loop", "next_run", "judge_published"],
    "measurement-init": ["draft_measurement"],
    "optimise": ["optimise"],
    "page": ["DriveDesign.page"],
    "picture": ["DriveDesign.picture", "DriveDesign.moving_picture"],
    "pictures": ["DriveDesign.pictures"],
    "plan": ["DriveDesign.plan", "DriveDesign.best_run"],
    "preload": ["DriveDesign.preload"],
    "prices": ["prices"],
    "prints": ["DriveDesign.prints"],
    "reproduce": ["reproduce"],
    "schema": ["schema", "schema_page"],
    "sensitivity": ["DriveDesign.sensitivity"],
    "simulate": ["DriveDesign.simulate"],
    "solve": ["solve"],
    "trend": ["trend"],
}
# Commands without a function, and why.
ONLY_COMMANDS = {"watch": "runs until it is interrupted, and gives nothing back"}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty current folder with a design file."""
    shutil.copy(ROOT / "params" / "mbcdm-short.yaml", tmp_path / "drive.yaml")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def said(capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """Runs a command and gives what it prints on standard output."""

    def run(*arguments: str, code: int = 0) -> str:
        capsys.readouterr()
        assert cli.run(list(arguments)) == code, capsys.readouterr().err
        return capsys.readouterr().out

    return run


def function(name: str) -> Any:
    owner, _, method = name.rpartition(".")
    return getattr(getattr(mc, owner) if owner else mc, method)


def test_each_command_has_its_functions() -> None:
    assert set(FUNCTIONS) | set(ONLY_COMMANDS) == set(mbcdm.commands)
    for command, names in FUNCTIONS.items():
        for name in names:
            words = inspect.getdoc(function(name)) or ""
            assert len(words) > 60, f"{name} is not documented"
        assert any(f"mbcdm {command}" in (inspect.getdoc(function(name)) or "") or name == "schema" for name in names)


def test_what_a_command_writes_is_what_its_function_gives(folder: Path, said: Callable[..., str]) -> None:
    design = mc.load("drive.yaml")
    assert said("explain", "drive.yaml") == f"{design.explain()}\n"
    assert said("explain", "drive.yaml", "support.back_y_mm") == f"{design.explain('support.back_y_mm')}\n"
    assert json.loads(said("explain", "drive.yaml", "--json")) == design.explain().to_dict()
    said("explain", "drive.yaml", "--graph", "command.svg")
    assert design.explain_graph("function.svg").files == (Path("function.svg"),)
    assert Path("command.svg").read_text() == Path("function.svg").read_text()

    for form in ("short", "full", "reference"):
        said("init", f"new-{form}.yaml", *([] if form == "short" else [f"--{form}"]))
        assert Path(f"new-{form}.yaml").read_text() == mc.new_design_text(f"new-{form}", form=form)  # type: ignore[arg-type]
        assert mc.load(f"new-{form}.yaml").drive == mc.new_design(f"new-{form}", form=form).drive  # type: ignore[arg-type]
    for measurement in (False, True):
        words = ["schema", *(["--measurement"] if measurement else [])]
        assert json.loads(said(*words)) == mc.schema(measurement=measurement)
        assert said(*words, "--reference") == mc.schema_page(measurement=measurement)
    for kind in (None, "ropes"):
        words = ["catalogue", *([kind] if kind else [])]
        assert said(*words) == f"{mc.catalogue(kind)}\n"
        assert said(*words, "--markdown") == mc.catalogue(kind).markdown()
    assert mc.catalogue("ropes").to_dict()["ropes"]["FF-081"]["diameter_mm"] == pytest.approx(0.81)
    assert said("reproduce") == str(mc.reproduce())
    with pytest.raises(mc.MbcdmError, match="catalogue: no such kind"):
        mc.catalogue("rope")


def test_the_search_gives_the_same_design_and_patch(folder: Path, said: Callable[..., str]) -> None:
    Path("pinned.yaml").write_text(PINNED)
    found = mc.solve("pinned.yaml")
    assert said("solve", "pinned.yaml", "--apply", "solved.yaml") == f"{found}\nsolved.yaml written\n"
    found.save("saved.yaml")
    assert Path("saved.yaml").read_text() == Path("solved.yaml").read_text() == found.design_text
    assert json.loads(said("solve", "pinned.yaml", "--json")) == json.loads(json.dumps(found.to_dict()))
    assert mc.load("saved.yaml").check().passed and [one.field for one in found.changes] == ["drum.outer_face_y_mm"]


def test_runs_are_simulated_judged_and_planned_alike(folder: Path, said: Callable[..., str]) -> None:
    design = mc.load("drive.yaml")
    printed = said("simulate", "drive.yaml", str(EXPERIMENT), "--out", "command")
    run = design.simulate(EXPERIMENT, "function")
    assert printed.replace("command", "function") == f"{run}\n"
    for path in run.files:
        assert path.read_bytes() == (folder / "command" / path.parent.name / path.name).read_bytes(), path
    measured = run.folder / f"{EXPERIMENT.stem}.yaml"
    judged = mc.close_loop(design, measured)
    outputs = ["--json", "result.json", "--apply", "built.yaml", "--report", "page", "--correction", "table"]
    printed = said("loop", "drive.yaml", str(measured), *outputs, "--next", "next.yaml")
    assert printed.startswith(f"{judged}\n")
    assert json.loads(Path("result.json").read_text()) == json.loads(json.dumps(judged.to_dict()))
    assert Path("built.yaml").read_text() == judged.as_built_text()
    assert (folder / "page" / "report.html").read_bytes() == judged.page()
    assert {path.name: path.read_bytes() for path in (folder / "table").iterdir()} == judged.correction_files()
    assert (mc.next_run(judged) is None) == ("no set of possible effects is left" in printed)

    assert said("plan", "drive.yaml", str(EXPERIMENT)) == f"{design.plan(EXPERIMENT).text()}\n"
    data = next(path for path in run.files if path.suffix == ".csv")
    printed = said("measurement-init", str(data), "drive.yaml", "--out", str(data.with_name("draft.yaml")))
    assert printed.startswith(mc.draft_measurement(data, design))


@pytest.mark.slow
def test_what_is_drawn_is_the_same_file_by_file(folder: Path, said: Callable[..., str]) -> None:
    """Each command into one folder and its function into another."""
    design = mc.load("drive.yaml")
    pairs: list[tuple[list[str], Callable[[str], Any]]] = [
        (["build"], lambda out: design.build(out)),
        (["page"], lambda out: design.page(out)),
        (["drawings", "--part", "drum"], lambda out: design.drawings(out, part="drum")),
        (["prints", "--all"], lambda out: design.prints(out, every_made_part=True)),
        (["pictures"], lambda out: design.pictures(out)),
        (["export", "--format", "mjcf", "--elastic"], lambda out: design.export("mjcf", out, elastic=True)),
        (["sensitivity"], lambda out: design.sensitivity(out)),
    ]
    for (command, *options), call in pairs:
        printed = said(command, "drive.yaml", *options, "--out", "command")
        result = call("function")
        # The first of both draws the parts, the second takes them from the cache.
        first, second = (re.sub(r"\d+ made", "made", text) for text in (printed, f"{result}\n"))
        assert first.replace("command", "function").startswith(second), command
    files = {
        path.relative_to(out): path.read_bytes()
        for out in ("command", "function")
        for path in Path(out).rglob("*")
        if path.is_file()
    }
    for name, content in files.items():
        for out in ("command", "function"):
            assert (Path(out) / name).read_bytes() == content, f"{out}/{name}"
    said("picture", "drive.yaml", "command.png", "--view", "iso", "--angle", "10")
    design.picture("function.png", view="iso", angle_deg=10.0)
    said("picture", "drive.yaml", "command.gif", "--travel")
    design.moving_picture("function.gif")
    for kind in ("png", "gif"):
        assert Path(f"command.{kind}").read_bytes() == Path(f"function.{kind}").read_bytes(), kind
    with pytest.raises(mc.MbcdmError, match="no such view"):
        design.picture("side.png", view="side")
    with pytest.raises(mc.MbcdmError, match="URDF has no springs"):
        design.export("urdf", elastic=True)
    with pytest.raises(mc.MbcdmError, match="they belong to ROS"):
        design.export("mjcf", xacro=True)


@pytest.mark.slow
def test_designs_of_one_name_are_compared_by_their_files(folder: Path, said: Callable[..., str]) -> None:
    design = mc.new_design("drive", "siso_spur")
    for name, half_angle in (("left", 40), ("right", 30)):
        design.with_(travel__half_angle_deg=half_angle).save(f"{name}.yaml")
    found = mc.compare(["left.yaml", "right.yaml"])
    assert [design.name for design in found.designs] == ["left.yaml", "right.yaml"]
    assert said("compare", "left.yaml", "right.yaml") == f"{found}\n"
    assert json.loads(said("compare", "left.yaml", "right.yaml", "--json")) == json.loads(json.dumps(found.to_dict()))
    assert found.designs[0].travel_deg == 80.0 and found.designs[1].travel_deg == 60.0
    mc.load("left.yaml").build()
    with pytest.raises(mc.MbcdmError, match="another design file with the same name"):
        mc.load("right.yaml").build()
