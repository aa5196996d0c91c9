"""Help pages, the studies' text, the catalogue, the doctor, completion."""

import ast
import functools
import json
import os
import shlex
import subprocess
import sys
from pathlib import Path

import click
import pytest

from mbcdm_cad import cli
from mbcdm_cad.cli.commands_on_designs import CATALOGUE_KINDS
from mbcdm_cad.cli.commands_that_draw import VIEW_NAMES
from mbcdm_cad.cli.group import mbcdm
from mbcdm_cad.design.catalogue import KINDS
from tests.support.reference import ROOT, Says

PARAMS = ROOT / "params" / "mbcdm.yaml"


@pytest.fixture(autouse=True)
def own_cache(monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory) -> None:
    monkeypatch.setenv("MBCDM_CACHE_DIR", str(tmp_path_factory.mktemp("cache")))


@pytest.mark.parametrize("name", list(mbcdm.commands))
def test_each_command_has_an_example_and_a_whole_line_in_the_list(name: str, says: Says) -> None:
    page = says([name, "--help"]).out
    assert "Example" in page and f"  mbcdm {name}" in page, page
    listed = [line for line in says(["--help"]).out.splitlines() if line.split()[:1] == [name]]
    assert len(listed) == 1, listed
    first = (mbcdm.commands[name].help or "").split("\n")[0]
    assert listed[0].split(maxsplit=1)[1] == first and first.endswith("."), f"{listed[0]!r} cuts {first!r}"


@pytest.mark.parametrize("name", [None, *mbcdm.commands])
def test_help_fits_80_columns(name: str | None, says: Says) -> None:
    longest = max(says([*([name] if name else []), "--help"]).out.splitlines(), key=len)
    assert len(longest) <= 80, longest


def test_names_that_commands_repeat_are_those_of_their_rooms() -> None:
    """The names stand in commands.py too, since their rooms import the drawing library or pydantic."""
    found = [path for path in (ROOT / "mbcdm_cad").rglob("picture.py") if "VIEWS:" in path.read_text("utf-8")]
    (tree,) = (ast.parse(path.read_text("utf-8")) for path in found)
    (views,) = (n.value for n in tree.body if isinstance(n, ast.AnnAssign) and getattr(n.target, "id", "") == "VIEWS")
    assert tuple(ast.literal_eval(views)) == VIEW_NAMES  # type: ignore[arg-type]
    assert sorted(KINDS) == CATALOGUE_KINDS


@pytest.mark.parametrize("width", [80, 200])
def test_analyse_fits_the_terminal_and_names_no_infinite_load(
    width: int, monkeypatch: pytest.MonkeyPatch, says: Says
) -> None:
    monkeypatch.setenv("COLUMNS", str(width))
    out = says(["analyse", str(PARAMS)]).out
    longest = max(out.splitlines(), key=len)
    assert len(longest) <= width, f"{len(longest)}: {longest}"
    assert "inf" not in out.replace("infinite", "") and "nan" not in out, out
    assert "18.740 N m" in next(line for line in out.splitlines() if "a cable goes slack" in line)


@pytest.mark.slow
def test_sensitivity_prints_readable_units(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, says: Says) -> None:
    from mbcdm_cad.model import study

    # Of the study only a few draws are asked for: its figures are tested elsewhere.
    small = functools.partial(study.intervals, draws=200)
    monkeypatch.setattr(study, "intervals", small)
    monkeypatch.setattr(study, "global_indices", functools.partial(study.global_indices, n=8))
    out = says(["sensitivity", str(PARAMS), "--out", str(tmp_path)]).out
    swing = next(line for line in out.splitlines() if "reversal swing" in line)
    _, _, unit, *figures = swing.split()
    value, low, high = map(float, figures)
    assert unit == "mrad" and low < value < high and 0.2 < value < 0.5, swing
    assert "_rad" not in out, out


def test_init_prints_a_command_that_can_be_pasted(tmp_path: Path, says: Says) -> None:
    path = tmp_path / "My Drive's.yaml"
    hint = says(["init", str(path)]).out.partition("check it with: ")[2]
    assert shlex.split(hint) == ["mbcdm", "check", str(path)], hint


@pytest.mark.parametrize("command", [["init"], ["picture", str(PARAMS)]])
def test_a_missing_parent_folder_is_one_sentence(command: list[str], tmp_path: Path, says: Says) -> None:
    path = tmp_path / "no" / "such.png"
    err = says([*command, str(path)], 2).err
    assert err == f"{path}:1: there is no folder {path.parent}; make it first, or choose another path\n", err
    assert list(tmp_path.iterdir()) == []


def test_a_picture_of_another_kind_or_view_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["picture", str(PARAMS), str(tmp_path / "a.jpg")]) == 2
    assert "pictures are PNG files (value .jpg, limit .png); name it a.png" in capsys.readouterr().err
    assert cli.run(["picture", str(PARAMS), str(tmp_path / "a.png"), "--view", "side"]) == 2
    assert "'side' is not one of 'output', 'iso'" in capsys.readouterr().err


@pytest.mark.parametrize("width", [80, 200])
@pytest.mark.parametrize("kind", [None, *CATALOGUE_KINDS])
def test_catalogue_fits_the_terminal(kind: str | None, width: int, monkeypatch: pytest.MonkeyPatch, says: Says) -> None:
    monkeypatch.setenv("COLUMNS", str(width))
    out = says(["catalogue", *([kind] if kind else [])]).out
    longest = max(out.splitlines(), key=len)
    assert len(longest) <= width, longest
    assert kind != "ropes" or ("FF-081" in out and "0.3117" in out), out


def test_catalogue_page_is_up_to_date(says: Says) -> None:
    """Write it anew with: mbcdm catalogue --markdown > docs/catalogue.md."""
    assert says(["catalogue", "--markdown"]).out == (ROOT / "docs" / "catalogue.md").read_text("utf-8")


def test_doctor_says_what_is_missing_and_what_it_is_for(monkeypatch: pytest.MonkeyPatch, says: Says) -> None:
    from mbcdm_cad.report import catalogue_list

    monkeypatch.setattr(
        catalogue_list, "_imported", lambda name, *_: catalogue_list.Dependency(name, False, True, "no", "x", "do y")
    )
    monkeypatch.setenv("PATH", "/nowhere")
    monkeypatch.setenv("COLUMNS", "80")
    out = says(["doctor"], 1).out
    assert "CAD kernel: do y" in out and "missing: CAD kernel, drawing library" in out, out
    assert "absent   browser" in out and max(map(len, out.splitlines())) <= 80, out
    found = {item["name"]: item for item in json.loads(says(["doctor", "--json"], 1).out)}
    assert {"libGL", "CAD kernel", "FreeCAD", "browser", "cache", "pandas"} <= set(found)


def test_the_shell_can_complete_commands_and_views() -> None:
    for words, at, expected in (("mbcdm che", 1, "check"), ("mbcdm picture a.yaml a.png --view f", 5, "front")):
        environment = {**os.environ, "_MBCDM_COMPLETE": "bash_complete", "COMP_WORDS": words, "COMP_CWORD": str(at)}
        done = subprocess.run(
            [sys.executable, "-m", "mbcdm_cad"],
            env=environment,
            capture_output=True,
            text=True,
            timeout=600,
            check=False,
        )
        assert expected in done.stdout.replace("plain,", "").split(), done.stdout + done.stderr


def test_every_command_is_in_the_docs() -> None:
    page = (ROOT / "docs" / "command-line.md").read_text("utf-8")
    for name, command in mbcdm.commands.items():
        assert f"`mbcdm {name}" in page, name
        options = {max(o.opts, key=len) for o in command.params if isinstance(o, click.Option)}
        missing = [option for option in sorted(options) if option not in page]
        assert not missing, f"mbcdm {name}: {missing} not in docs/command-line.md"
