"""``mbcdm loop``: exit codes, printed text, and which files are written or not."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from logger_samples import Write, mapping, signals, table

from mbcdm_cad.cli import run as mbcdm
from mbcdm_cad.errors import InputError
from mbcdm_cad.measurement.file import load_file
from mbcdm_cad.measurement.reference import measurement_page
from mbcdm_cad.measurement.schema import Measurement, json_schema, node_at
from mbcdm_cad.model.si import ModelError

DESIGN = Path(__file__).parents[3] / "params" / "mbcdm.yaml"
BARE = {key: value for key, value in mapping()["columns"].items() if key != "load_torque"}


@pytest.fixture
def bare(write: Write) -> Path:
    """A run without torque, so that only kinematics are judged."""
    return write(table(signals(4000)), mapping(columns=BARE))


def test_a_run_is_judged_and_the_result_written(bare: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = bare.with_name("result.json")
    assert mbcdm(["loop", str(DESIGN), str(bare), "--json", str(target)]) == 0
    said = capsys.readouterr().out
    found = json.loads(target.read_text())
    assert said.startswith(found["sentence"]) and "no load_torque: kinematics only" in said, said
    assert found["verdict"] == "none" and found["effects"] == [], found
    assert found["runs"][0]["samples"] == 4000 and len(found["runs"][0]["sha256"]) == 64, found["runs"]
    assert [path.name for path in bare.parent.iterdir() if path.name.startswith(".")] == []


@pytest.fixture
def short(write: Write) -> Path:
    """As ``bare``, of a drive whose ratio is 1 % off what the design says."""
    off = signals(4000)
    off["drum"] = off["drum"] * 1.01
    return write(table(off), mapping(columns=BARE))


def test_what_was_found_is_applied_and_reported_on_a_page(short: Path, capsys: pytest.CaptureFixture[str]) -> None:
    built, folder = short.with_name("built.yaml"), short.with_name("page")
    assert mbcdm(["loop", str(DESIGN), str(short), "--apply", str(built), "--report", str(folder)]) == 0
    said = capsys.readouterr().out
    assert "ratio_error" in said.splitlines()[0], said
    assert sorted(path.name for path in folder.iterdir()) == ["report.html", "result.json"]
    page = (folder / "report.html").read_text()
    assert "ratio_error" in page and page.count("data:image/png;base64,") == 2
    assert "ratio_error" in built.read_text() and mbcdm(["analyse", str(built)]) == 0


def test_a_run_that_the_model_cannot_follow_is_told_by_its_file(
    bare: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(*_: object) -> None:
        raise ModelError("sample 7: no drum angle balances a load of 1 N m; check its unit and sign")

    monkeypatch.setattr("mbcdm_cad.loop.search.engine.close_loop", refuse)
    assert mbcdm(["loop", str(DESIGN), str(bare)]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"{bare}: the declared model cannot follow the run: sample 7") and "check" in said, said


def test_nothing_is_applied_to_the_design_from_a_drive_of_its_own(
    short: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    short.write_text(short.read_text() + "ratio: 9.0\n")
    built = short.with_name("built.yaml")
    assert mbcdm(["loop", str(DESIGN), str(short), "--apply", str(built)]) == 2
    assert "leave --apply out" in capsys.readouterr().err and not built.exists()


def test_refusals_name_file_line_and_remedy_and_write_nothing(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    wrong = signals(4000)
    wrong["left"] = wrong["left"] * 57.29578
    path = write(table(wrong))
    target = path.with_name("result.json")
    assert mbcdm(["loop", str(DESIGN), str(path), "--json", str(target)]) == 2
    said = capsys.readouterr().err
    line = 1 + path.read_text().splitlines().index("  input_left:")
    assert f"run.yaml:{line}: columns.input_left: " in said and "degrees declared as radians" in said, said
    assert not target.exists()


CLASHES = {
    "design": (["--json", "design.yaml"], "would overwrite the design file, "),
    "design applied to itself": (["--apply", "design.yaml"], "would overwrite the design file, "),
    "measurement": (["--json", "run.yaml"], "would overwrite the measurement file, "),
    "data": (["--json", "run.csv"], "would overwrite the data of run.yaml, "),
    "data by --apply": (["--apply", "run.csv"], "would overwrite the data of run.yaml, "),
    "another spelling": (["--json", "page/../run.csv"], "would overwrite the data of run.yaml, "),
    "link to a file": (["--json", "link.csv"], "would overwrite the data of run.yaml, "),
    "through a linked folder": (["--apply", "linked/run.yaml"], "would overwrite the measurement file, "),
    "hard link": (["--json", "hard.csv"], "would overwrite the data of run.yaml, "),
    "report over the data": (
        ["--report", "page"],
        "page/result.json:1: --report: would overwrite the data of run.yaml",
    ),
    "report is a file": (["--report", "run.csv"], "--report: a file; the report needs a folder"),
    "two outputs": (["--json", "new.yaml", "--apply", "page/../new.yaml"], "would overwrite the output of --json, "),
    "json of the report": (["--json", "page/report.html", "--report", "page"], "the output of --json, "),
    "no folder": (["--json", "none/x.json"], "there is no folder "),
    "a folder": (["--json", "page"], "is a folder, but a file is to be written; "),
    "report below a file": (["--report", "run.csv/page"], "run.csv is no folder; "),
}


@pytest.mark.parametrize("which", CLASHES)
def test_an_output_that_cannot_be_is_refused_before_any_work(
    which: str, bare: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = bare.parent
    (folder / "design.yaml").write_text(DESIGN.read_text())
    (folder / "page").mkdir()
    (folder / "link.csv").symlink_to("run.csv")
    (folder / "hard.csv").hardlink_to(folder / "run.csv")
    (folder / "linked").symlink_to(folder)
    if which == "report over the data":
        (folder / "page" / "result.json").symlink_to(folder / "run.csv")
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}

    def never(*_: object) -> None:
        raise AssertionError("the data were read although an output cannot be written")

    monkeypatch.setattr("mbcdm_cad.measurement.vet.read_run", never)
    options, words = CLASHES[which]
    paths = [part if part.startswith("--") else str(folder / part) for part in options]
    assert mbcdm(["loop", str(folder / "design.yaml"), str(bare), *paths]) == 2
    said = capsys.readouterr()
    assert words in said.err and "; " in said.err and not said.out, said
    assert all(line.count(f":1: {options[-2]}: ") for line in said.err.splitlines()), said.err
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before


def test_inputs_given_through_links_are_kept(bare: Path, capsys: pytest.CaptureFixture[str]) -> None:
    given = bare.parent / "given"
    given.mkdir()
    for name in ("run.yaml", "run.csv"):
        (given / name).symlink_to(bare.parent / name)
    for name in ("run.yaml", "run.csv"):
        assert mbcdm(["loop", str(DESIGN), str(given / "run.yaml"), "--json", str(bare.parent / name)]) == 2
        assert "would overwrite the " in capsys.readouterr().err


def test_runs_of_different_drives_are_not_judged_together(
    write: Write, bare: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = bare.with_name("other.yaml")
    other.write_text(bare.read_text() + "ratio: 9.0\n")
    assert mbcdm(["loop", str(DESIGN), str(bare), str(other)]) == 2
    said = capsys.readouterr().err
    assert "other.yaml:" in said and "another ratio" in said and "value 9.0, limit none" in said, said


def test_no_file_is_touched_unless_all_can_be_written(tmp_path: Path) -> None:
    from mbcdm_cad.storage.folders import write_whole

    kept = tmp_path / "kept.json"
    kept.write_text("before")
    (tmp_path / "folder").mkdir()
    with pytest.raises(OSError, match="is a folder"):
        write_whole({kept: b"after", tmp_path / "folder": b"x"})
    assert kept.read_text() == "before"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["folder", "kept.json"]


# The reference page of the measurement file, and the files that it shows.


ROOT = Path(__file__).parents[3]


def test_page_in_docs_is_what_the_schema_writes() -> None:
    # To write it anew: mbcdm schema --measurement --reference > docs/measurement-file.md
    assert (ROOT / "docs" / "measurement-file.md").read_text("utf-8") == measurement_page()


def test_examples_on_the_page_are_measurement_files(tmp_path: Path) -> None:
    examples = re.findall(r"```yaml\n(.*?)```", measurement_page(), re.DOTALL)
    assert len(examples) == 2
    for text in examples:
        (tmp_path / "m.yaml").write_text(text)
        assert load_file(tmp_path / "m.yaml").content.data


def test_every_field_is_on_the_page() -> None:
    page = measurement_page()
    for name in (*Measurement.model_fields, *node_at(("columns", "time"))["properties"]):  # type: ignore[index]
        assert f"`{name}`" in page or f"## {name}" in page, name


def test_schema_has_no_reference_left() -> None:
    assert "$ref" not in str(json_schema()) and "$defs" not in json_schema()


def test_messages_show_the_example_of_this_schema(tmp_path: Path) -> None:
    (tmp_path / "m.yaml").write_text("data: run.csv\ncolumns: {time: {column: t}}\n")
    with pytest.raises(InputError) as caught:
        load_file(tmp_path / "m.yaml")
    text = str(caught.value)
    assert "m.yaml:2: columns.time.unit: missing; add it, for example unit: rad" in text, text
    assert "columns.output: missing" in text, text
