"""``mbcdm loop``: exit codes, printed text, and which files are written or not."""

import json
import re
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

import mbcdm_cad as mc
from mbcdm_cad.cli import run as mbcdm
from mbcdm_cad.errors import InputError
from mbcdm_cad.measurement.draft import measurement_page
from mbcdm_cad.measurement.file import load_file
from mbcdm_cad.measurement.schema import Measurement, json_schema, node_at
from mbcdm_cad.model.si import ModelError
from tests.support.reference import REFERENCE as DESIGN
from tests.support.reference import ROOT, Says
from tests.unit.measurement.sound_runs import Write, mapping, signals, table

BARE = {key: value for key, value in mapping()["columns"].items() if key != "load_torque"}


@pytest.fixture
def bare(write: Write) -> Path:
    """A run without torque, so that only kinematics are judged."""
    return write(table(signals(4000)), mapping(columns=BARE))


def test_a_run_is_judged_and_the_result_written(bare: Path, says: Says) -> None:
    target = bare.with_name("result.json")
    said = says(["loop", str(DESIGN), str(bare), "--json", str(target)]).out
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


def test_what_was_found_is_applied_and_reported_on_a_page(short: Path, says: Says) -> None:
    built, folder = short.with_name("built.yaml"), short.with_name("page")
    said = says(["loop", str(DESIGN), str(short), "--apply", str(built), "--report", str(folder)]).out
    assert "ratio_error" in said.splitlines()[0], said
    assert sorted(path.name for path in folder.iterdir()) == ["report.html", "result.json"]
    page = (folder / "report.html").read_text()
    assert "ratio_error" in page and page.count("data:image/png;base64,") == 2
    assert "ratio_error" in built.read_text() and mbcdm(["analyse", str(built)]) == 0


def test_a_run_that_the_model_cannot_follow_is_told_by_its_file(
    bare: Path, monkeypatch: pytest.MonkeyPatch, says: Says
) -> None:
    def refuse(*_: object) -> None:
        raise ModelError("sample 7: no drum angle balances a load of 1 N m; check its unit and sign")

    monkeypatch.setattr("mbcdm_cad.loop.search.engine.close_loop", refuse)
    said = says(["loop", str(DESIGN), str(bare)], 2).err
    assert said.startswith(f"{bare}: the declared model cannot follow the run: sample 7") and "check" in said, said


def test_nothing_is_applied_to_the_design_from_a_drive_of_its_own(
    short: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    short.write_text(short.read_text() + "ratio: 9.0\n")
    built = short.with_name("built.yaml")
    assert mbcdm(["loop", str(DESIGN), str(short), "--apply", str(built)]) == 2
    assert "leave --apply out" in capsys.readouterr().err and not built.exists()


def test_refusals_name_file_line_and_remedy_and_write_nothing(write: Write, says: Says) -> None:
    wrong = signals(4000)
    wrong["left"] = wrong["left"] * 57.29578
    path = write(table(wrong))
    target = path.with_name("result.json")
    said = says(["loop", str(DESIGN), str(path), "--json", str(target)], 2).err
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
    which: str, bare: Path, says: Says, monkeypatch: pytest.MonkeyPatch
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
    said = says(["loop", str(folder / "design.yaml"), str(bare), *paths], 2)
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


def test_runs_of_different_drives_are_not_judged_together(write: Write, bare: Path, says: Says) -> None:
    other = bare.with_name("other.yaml")
    other.write_text(bare.read_text() + "ratio: 9.0\n")
    said = says(["loop", str(DESIGN), str(bare), str(other)], 2).err
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


RATIO, MASS_KG, ARM_M = 4.0, 0.5, 0.2
PLAY, COMPLIANCE, MAGNET = 6e-3, 4e-3, 14e-3
ZERO = 1.2  # rad: what the arm's encoder shows where the weight hangs straight down


def bench(mass_kg: float = MASS_KG, seed: int = 5) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Time, steps, counts of motor and arm."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 120.0, 0.02) + rng.normal(0.0, 2e-4, 6000)
    arm = np.radians(150.0) * np.sin(2.0 * np.pi * t / 12.0)
    torque = mass_kg * 9.80665 * ARM_M * np.sin(arm)
    true = arm - COMPLIANCE * torque - 0.5 * PLAY * (np.sign(torque) if mass_kg else 0.0)
    read = true + MAGNET * np.sin(true + 1.0) + ZERO
    motor = RATIO * arm + 5e-3 * np.sin(RATIO * arm + 0.4) + 2.0

    def counts(angle: np.ndarray) -> np.ndarray:
        return np.asarray(np.round(angle / (2.0 * np.pi) * 4096 + rng.normal(0.0, 0.4, t.size)) % 4096)

    return t, np.round(RATIO * arm / (2.0 * np.pi) * 3200), counts(motor), counts(read)


def csv(folder: Path, rows: tuple[np.ndarray, ...]) -> Path:
    lines = ["time_s,steps,motor_as5600,arm_as5600"]
    lines += [f"{t:.5f},{steps:.0f},{motor:.0f},{arm:.0f}" for t, steps, motor, arm in zip(*rows, strict=True)]
    (folder / "run.csv").write_text("\n".join(lines) + "\n")
    return folder / "run.csv"


def monitor(folder: Path, rows: tuple[np.ndarray, ...]) -> Path:
    """A serial monitor with time stamps, of a sketch that writes labels for the plotter."""
    lines = ["AS5600 x2, stepper bench v2", "homing... done"]
    for t, steps, motor, arm in zip(*rows, strict=True):
        at = datetime(2026, 3, 1, 14) + timedelta(milliseconds=round(1e3 * float(t) + 10.0))
        stamp = f"{at:%H:%M:%S}.{at.microsecond // 1000:03d}"
        lines.append(f"{stamp} -> steps:{steps:.0f}\tmotor:{motor:.0f}\tarm:{arm:.0f}")
    (folder / "monitor.txt").write_bytes("\r\n".join(lines).encode() + b"\r\n")
    return folder / "monitor.txt"


def csv_table(folder: Path, rows: tuple[np.ndarray, ...]) -> Path:
    """German settings: semicolons, decimal commas, degrees without counts of turns."""
    t, _, motor, arm = rows
    degrees = [np.degrees(np.unwrap(counts, period=4096) * 2.0 * np.pi / 4096) for counts in (motor, arm)]
    lines = ["Zeit [ms];Motorwinkel [°];Armwinkel [°]"]
    lines += [f"{1e3 * a:.2f};{b:.3f};{c:.3f}".replace(".", ",") for a, b, c in zip(t, *degrees, strict=True)]
    (folder / "labor.csv").write_text("\n".join(lines) + "\n")
    return folder / "labor.csv"


def load(mass_kg: float = MASS_KG) -> str:
    """What the user adds to the draft."""
    return f"load: {{pendulum: {{mass_kg: {mass_kg}, arm_mm: {1e3 * ARM_M}, vertical_deg: {np.degrees(ZERO):.3f}}}}}\n"


@pytest.mark.parametrize("write", [csv, monitor, csv_table], ids=lambda write: write.__name__)
def test_the_draft_of_each_logger_gives_the_same_finding(
    write: object, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = write(tmp_path, bench())  # type: ignore[operator]
    assert mbcdm(["measurement-init", str(data), "--ratio", str(RATIO)]) == 0
    file = data.with_suffix(".yaml")
    assert capsys.readouterr().out.endswith(f"then: mbcdm loop {file}\n")
    text = file.read_text()
    assert "counts_per_turn: 4096" in text or write is csv_table, text
    file.write_text(text + load())
    found = mc.close_loop(None, file).result
    play = next(one for one in found.effects if one.name == "lash").parameters["play_rad"]
    assert play.low < PLAY < play.high and play.high - play.low < 1e-3, found.sentence
    assert {one.name for one in found.effects} <= {"lash", "once_per_rev"}, found.sentence
    assert found.verdict == "explained" and found.errors.explained_share > 0.98, found.sentence


def test_another_weight_tells_the_compliance_from_the_magnet(tmp_path: Path) -> None:
    """With one weight alone a compliance and an encoder off centre are the same wave, as vetting says."""
    files = []
    for mass_kg in (MASS_KG, 2.0 * MASS_KG):
        folder = tmp_path / f"{mass_kg}"
        folder.mkdir()
        data = csv(folder, bench(mass_kg, seed=9))
        files.append(data.with_suffix(".yaml"))
        files[-1].write_text(mc.draft_measurement(data, ratio=RATIO) + load(mass_kg))
    alone = mc.close_loop(None, files[0])
    assert "a compliance in series looks like once_per_rev drum" in alone.text()
    # The wave is named for both, with the figure of both.
    assert "once_per_rev" in {one.name for one in alone.result.effects}, alone.result.sentence
    assert "stiffness_error" not in {one.name for one in alone.result.effects}, alone.result.sentence
    both = mc.close_loop(None, files).result
    named = {(one.name, one.stage): one for one in both.effects}
    magnet = named["once_per_rev", "drum"].parameters["amplitude_rad"]
    soft = named["stiffness_error", None].parameters["compliance_rad_Nm"]
    assert magnet.value == pytest.approx(MAGNET, abs=2e-4), both.sentence
    assert soft.value == pytest.approx(COMPLIANCE, rel=0.05), both.sentence


def test_what_is_soft_and_wound_up_by_friction_is_not_named_a_play(tmp_path: Path) -> None:
    """Without a sensor of the torque the two differ in nothing that a run of one bench shows."""
    rng = np.random.default_rng(2)
    t = np.arange(0.0, 100.0, 0.03)
    arm = np.radians(60.0) * np.sin(2.0 * np.pi * t / 12.0)
    held, half = np.zeros(t.size), 1.5e-3
    for k in range(1, t.size):  # the output waits until the spring has turned to the friction's torque
        held[k] = min(max(held[k - 1], arm[k] - half), arm[k] + half)
    step = 2.0 * np.pi / 16384
    read = np.round((held + step * rng.normal(0.0, 0.4, t.size)) / step) * step
    rows = [f"{a:.3f},{RATIO * b:.6f},{c:.6f}" for a, b, c in zip(t, arm, read, strict=True)]
    (tmp_path / "run.csv").write_text("\n".join(["t_s,motor_rad,arm_rad", *rows]) + "\n")
    file = tmp_path / "run.yaml"
    file.write_text(mc.draft_measurement(tmp_path / "run.csv", ratio=RATIO) + load().replace("68.755", "0.0"))
    result = mc.close_loop(None, file).result
    ((first, second),) = result.one_of
    assert {first.name, second.name} == {"friction", "lash"} and not result.effects, result.sentence
    friction = next(one for one in (first, second) if one.name == "friction").parameters["half_width_rad"]
    assert friction.low < half < friction.high, friction


def test_a_ratio_in_place_of_the_design(tmp_path: Path, says: Says) -> None:
    data = csv(tmp_path, bench())
    file = tmp_path / "run.yaml"
    text = mc.draft_measurement(data, ratio=RATIO).replace("ratio: 4\n", "")
    file.write_text(text)
    assert "run.yaml:1: ratio: neither a design nor a ratio" in says(["loop", str(file)], 2).err
    said = says(["loop", str(file), "--ratio", "4", "--json", str(tmp_path / "found.json")]).out
    assert "only the ratio is known: pulleys, preload and ropes" in said
    assert (
        "leave --apply out" in says(["loop", str(file), "--ratio", "4", "--apply", str(tmp_path / "built.yaml")], 2).err
    )
    file.write_text(text + "ratio: 4\n")
    assert says(["loop", str(file)]).out == said.replace(f"{tmp_path / 'found.json'} written\n", "")
    with pytest.raises(InputError, match="another ratio than --ratio"):
        mc.close_loop(None, file, ratio=5.0)
    # A design alone is not enough.
    assert mbcdm(["loop", str(tmp_path / "drive.yaml")]) == 2
