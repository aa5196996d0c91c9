"""The command check: its output at several widths, JSON, exit codes, and modules that it must not import."""

import json
import re
import subprocess
import sys
from io import StringIO
from math import inf, pi
from pathlib import Path
from time import sleep

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from mbcdm_cad import cli
from mbcdm_cad.checks.comparison import CheckResult
from mbcdm_cad.checks.size import kept_mass_g
from mbcdm_cad.cli import group
from mbcdm_cad.cli.group import coloured, progress_of_trials, sign_of_life
from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.layouts.loader import layout_of, load_design, load_text, new_design_text, short_design_text
from mbcdm_cad.layouts.miso_bevel.checks import CHECKS
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.planning.best_run import candidates, run_of
from mbcdm_cad.planning.plan import plan_of
from mbcdm_cad.report.check_report import CheckReport
from mbcdm_cad.rig.bench import BenchLimits
from mbcdm_cad.rig.experiment import Experiment, read_experiment
from tests.support.reference import REFERENCE as DESIGN
from tests.support.reference import Says

FIELDS = {"id", "title", "status", "actual", "limit", "unit", "margin", "message", "remedy", "source", "waived_reason"}
# Checks of requirements that the reference design does not state are left out.
ASKED = sum(check.asked_of(load_text(new_design_text("sound")).drive) for check in CHECKS)
LAST = f"0 fail, 0 waived, of {ASKED} checks"


def write(tmp_path: Path, text: str, name: str = "design.yaml") -> Path:
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return path


def failing_text(name: str) -> str:
    text = new_design_text(name).replace("type: FF-081 ", "type: 7x7-1.0 ").replace("modulus_GPa: 54.0 ", "")
    text = text.replace("  modulus_area: metallic ", "  ")
    return text.replace("centre_distance_mm: 34.6", "centre_distance_mm: 38.0")


def test_sound_design_exits_0_with_a_summary_and_no_passing_checks(tmp_path: Path, says: Says) -> None:
    out, err = says(["check", str(write(tmp_path, new_design_text("sound")))])
    lines = out.splitlines()
    assert err == "" and lines[-1].startswith("sound: ") and LAST in lines[-1]
    assert not [line for line in lines if line.startswith("pass")], out
    assert "\x1b" not in out


def test_all_lists_passing_checks_before_warnings(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["check", "--all", str(write(tmp_path, new_design_text("sound")))]) == 0
    words = [line.split(" ")[0] for line in capsys.readouterr().out.splitlines() if not line.startswith(" ")][:-1]
    assert words == sorted(words) and words.count("pass") + words.count("warn") == ASKED, words


def test_failures_come_last_with_what_to_do(tmp_path: Path, says: Says) -> None:
    path = write(tmp_path, failing_text("thick"))
    out, _ = says(["check", str(path)], 1)
    for remedy in (
        "choose a rope of at most 0.81 mm (such as FF-081) or lower transmission.ratios.input_to_guide from 1.5",
        "lower clearances.land_edge_mm from 0.15 to at most 0.1",
        "raise rope.helix_lead_mm from 0.87 to at least 1.07",
        "lower transmission.centre_distance_mm from 38 to at most",
    ):
        assert remedy in out, (remedy, out)
    words = [line.split(" ")[0] for line in out.splitlines() if not line.startswith(" ")][:-1]
    assert words == sorted(words, key=["warn", "fail"].index) and words[-1] == "fail", words


def test_failed_shows_failures_only(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["check", "--failed", str(write(tmp_path, failing_text("thick")))]) == 1
    words = {line.split(" ")[0] for line in capsys.readouterr().out.splitlines() if not line.startswith(" ")}
    assert words == {"fail", "thick:"}, words


@pytest.mark.parametrize("width", [80, 200])
@pytest.mark.parametrize("option", [[], ["--all"], ["--failed"]])
def test_no_line_is_wider_than_the_terminal(
    width: int, option: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, says: Says
) -> None:
    monkeypatch.setenv("COLUMNS", str(width))
    lines = says(["check", *option, str(write(tmp_path, failing_text("thick")))], 1).out.splitlines()
    longest = max(lines, key=len)
    assert len(longest) <= width, f"{len(longest)} characters: {longest}"
    assert len(longest) > 0.8 * width or option, f"at most {len(longest)} of {width} columns used"


def test_titles_of_passing_checks_are_shown_where_there_is_room(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, says: Says
) -> None:
    path = str(write(tmp_path, new_design_text("wide")))
    for width, there in ((80, False), (200, True)):
        monkeypatch.setenv("COLUMNS", str(width))
        out = says(["check", "--all", path]).out
        assert ("Drum lands wide enough" in out) is there, out
        assert len([line for line in out.splitlines() if line.startswith("pass")]) > 90


@pytest.mark.slow
def test_several_designs_exit_with_the_worst_code(tmp_path: Path, says: Says) -> None:
    good, bad = (
        write(tmp_path, text(stem), f"{stem}.yaml") for stem, text in (("good", new_design_text), ("bad", failing_text))
    )
    broken = write(tmp_path, "a: [", "broken.yaml")
    assert says(["check", str(good), str(good)]).out.splitlines()[-1] == "2 designs: all pass"
    assert says(["check", str(bad), str(good)], 1).out.splitlines()[-1] == f"2 designs: 1 fail: {bad}"
    out, err = says(["check", str(broken), str(bad), str(good)], 2)
    assert out.splitlines()[-1] == f"3 designs: 1 fail: {bad}; 1 cannot be read: {broken}", out
    assert err.startswith(f"{broken}:2: ") and len(err.splitlines()) == 1, err


def test_json_has_all_fields(tmp_path: Path, says: Says) -> None:
    path = str(write(tmp_path, new_design_text("plain")))
    data = json.loads(says(["check", "--json", path]).out)
    assert data["design"] == "plain" and len(data["design_sha256"]) == 64
    assert all(set(check) == FIELDS for check in data["checks"])
    assert sum(data["summary"].values()) == ASKED == len(data["checks"]), data["summary"]
    assert json.loads(says(["check", "--json", path, path]).out) == [data, data]


def test_unknown_waiver_exits_2(tmp_path: Path, says: Says) -> None:
    text = new_design_text("waived").replace("waivers: []", "waivers:\n  - {check: bend_ratios, reason: haste}\n")
    path = write(tmp_path, text)
    out, err = says(["check", str(path)], 2)
    assert out == "" and err.startswith(f"{path}:") and "did you mean bend_ratio?" in err, err


def test_options_that_exclude_each_other(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["check", "--all", "--failed", str(write(tmp_path, new_design_text("both")))]) == 2
    assert "exclude each other" in capsys.readouterr().err


def test_waived_failure_exits_0_and_is_printed(tmp_path: Path, says: Says) -> None:
    text = new_design_text("waived").replace("peak_torque_Nm: 3.15", "peak_torque_Nm: 3.3 ")
    text = text.replace("waivers: []", "waivers:\n  - {check: motor_torque_back, reason: one way only}\n")
    out = says(["check", str(write(tmp_path, text))]).out
    assert "waived motor_torque_back" in out and "waived: one way only" in out and "1 waived" in out, out


def test_report_of_a_handful() -> None:
    def result(status: str, **more: object) -> CheckResult:
        fields = {"actual": 1.0, "limit": 2.0, "margin": -1.0, "unit": "mm", "remedy": "turn it", **more}
        return CheckResult(id="x", title="T", status=status, message="m", source="s", **fields)  # type: ignore[arg-type]

    none = {"actual": None, "limit": None, "margin": None}
    results = (
        result("fail"),
        result("pass", margin=1.0, remedy=""),
        result("fail", **none),
        result("pass", waived_reason="why"),
        result("pass", limit=None, margin=None, remedy=""),
    )
    report = CheckReport("d", "", results)
    lines = report.text(colour=True, show="all").splitlines()
    assert lines[0] == "\x1b[32mpass  \x1b[0m x 1 <= 2 mm                    T", lines
    assert lines[2:5] == ["\x1b[33mwaived\x1b[0m x: T", "       m", "       waived: why"], lines
    assert lines[5:8] == ["\x1b[31mfail  \x1b[0m x: T", "       m", "       -> turn it"], lines
    assert lines[-1] == "d: 2 pass, 0 warn, 2 fail, 1 waived, of 5 checks"
    assert report.counts == {"pass": 2, "warn": 0, "fail": 2, "waived": 1}
    assert not report.passed and report["x"] is results[0] and str(report) == report.text()


def test_checks_without_a_figure_for_one_reason_are_told_once(tmp_path: Path, says: Says) -> None:
    """A frame below the drum's axis leaves eighty checks without a figure."""
    text = new_design_text("low").replace("coupling_space_mm: 9.6", "coupling_space_mm: 60.0")
    assert text != new_design_text("low"), "the reference file no longer holds this coupling space"
    out = says(["check", "--failed", str(write(tmp_path, text))], 1).out
    assert out.count("below the drum's axis") == 1, out
    listed = out.split("checks, for one reason")[1].split("tried together")[0]
    assert "stop_slot" in listed and "walls" in listed and len(out.splitlines()) < 60, out


def test_check_imports_neither_the_kernel_nor_what_draws(tmp_path: Path) -> None:
    path = write(tmp_path, new_design_text("light"))
    code = (
        "import sys; from mbcdm_cad import cli; cli.run(sys.argv[1:]);"
        "print(sorted({'cadquery', 'OCP', 'matplotlib', 'vtk', 'rich'} & set(sys.modules)), file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, "check", str(path)], capture_output=True, text=True, timeout=600, check=False
    )
    assert done.stderr.strip() == "[]", done.stderr


def test_a_file_that_states_every_value_gets_a_hint_beside_its_report(
    tmp_path: Path, says: Says, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.setattr(group, "_PATIENCE_S", 3600.0)  # a slow machine says that it is at work
    whole = write(tmp_path, new_design_text("whole"))
    said = says(["check", str(whole)])
    assert "states every value" in said.err and "states every value" not in said.out
    assert says(["check", str(Path(__file__).parents[3] / "params/mbcdm-short.yaml")]).err == ""


# Text follows the terminal: its width, and whether it has colours.


SHORT = Path(__file__).parents[3] / "params" / "mbcdm-short.yaml"


class Terminal:
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        """Always."""
        return True


@pytest.mark.parametrize(("term", "expected"), [("xterm-256color", True), ("dumb", False)])
def test_a_terminal_without_colours_gets_none(monkeypatch: pytest.MonkeyPatch, term: str, expected: bool) -> None:
    monkeypatch.setattr(sys, "stdout", Terminal())
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("TERM", term)
    assert coloured() is expected


class Paper(StringIO, Terminal):  # type: ignore[misc]
    """A terminal that keeps what it shows."""

    isatty = Terminal.isatty


def test_what_takes_long_says_so_on_a_terminal_and_nowhere_else(monkeypatch: pytest.MonkeyPatch) -> None:
    """The line comes after the patience, and goes with the answer; what is quick or piped shows nothing."""
    monkeypatch.setattr(group, "_PATIENCE_S", 0.0)
    for stream, shows in ((Paper(), True), (StringIO(), False)):
        monkeypatch.setattr(sys, "stderr", stream)
        with sign_of_life("leg.yaml: sizing"):
            for _ in range(1000):
                if not shows or stream.getvalue():
                    break
                sleep(0.01)
        assert ("leg.yaml: sizing ..." in stream.getvalue()) is shows
        assert stream.getvalue().endswith("\x1b[K" if shows else "")
    monkeypatch.setattr(group, "_PATIENCE_S", 1000.0)
    monkeypatch.setattr(sys, "stderr", quick := Paper())
    with sign_of_life("leg.yaml: sizing"):
        pass
    assert quick.getvalue() == ""


def test_a_search_that_is_piped_says_its_stages_and_how_far_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stderr", piped := StringIO())
    with progress_of_trials() as told:
        for stage, count in (("searching", 1), ("searching", 13), ("searching", 21), ("reducing", 22)):
            told(stage, count)
    assert piped.getvalue().splitlines() == ["1 trials: searching", "21 trials: searching", "22 trials: reducing"]


@pytest.mark.parametrize("field", [(), ("support.back_y_mm",)])
@pytest.mark.parametrize("width", [60, 80, 120, 160])
def test_explain_keeps_to_the_width(
    monkeypatch: pytest.MonkeyPatch, says: Says, width: int, field: tuple[str, ...]
) -> None:
    words = {}
    for columns in (None, width):
        if columns is not None:
            monkeypatch.setenv("COLUMNS", str(columns))
        words[columns] = says(["explain", str(SHORT), *field]).out
    longest = max(words[width].splitlines(), key=len)
    assert len(longest) <= width, f"{len(longest)} characters: {longest}"
    assert words[None].split() == words[width].split(), "wrapping loses words"


@pytest.fixture
def short(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Path:
    path = tmp_path / "drive.yaml"
    assert cli.run(["init", str(path)]) == 0
    capsys.readouterr()
    return path


def test_a_short_file_is_a_whole_design(short: Path) -> None:
    lines = [line for line in short.read_text().splitlines() if line.strip() and not line.strip().startswith("#")]
    # Five requirements, and that losses count.
    assert len(lines) <= 11, lines
    assert len(load_design(short).sized) > 45


def test_derived_values_stand_as_comments_and_give_the_same_design(short: Path, tmp_path: Path) -> None:
    path = tmp_path / "more" / "drive.yaml"
    path.parent.mkdir()
    assert cli.run(["init", str(path), "--full"]) == 0
    assert load_design(path).sha256 == load_design(short).sha256
    for value in load_design(short).sized:
        assert f"{value.field.split('.')[-1]}: " in path.read_text(), value.field


@pytest.mark.parametrize(
    "layout",
    ["siso_bevel", *(pytest.param(n, marks=pytest.mark.slow) for n in ("miso_bevel", "siso_spur", "miso_spur"))],
)
def test_a_derived_line_without_its_comment_mark_pins_its_field(layout: str) -> None:
    lines = short_design_text("drive", layout, derived=True).splitlines()
    whole = load_text("\n".join(lines), "drive.yaml")
    derived = [n for n, line in enumerate(lines) if re.match(r" *# \w+: .*  # .*: ", line) and "left out" not in line]
    assert len(derived) > 40, len(derived)
    others = []
    for n in derived:
        pinned = [*lines[:n], lines[n].replace("# ", "", 1), *lines[n + 1 :]]
        found = load_text("\n".join(pinned), "drive.yaml")
        if found.design != whole.design:
            # Values that were weighed with it are weighed anew; a choice that is made may let others choose better.
            assert _mass_times_turn(found) <= 1.01 * _mass_times_turn(whole), lines[n]
            others += [] if "# stiffness: " in lines[n] else [lines[n]]
    assert len(others) <= 1, others


def _mass_times_turn(loaded: LoadedDesign) -> float:
    layout = layout_of(loaded.drive)
    assert structure_of(layout) is not None
    return kept_mass_g(layout) / structure_of(layout).stiffness_Nm_rad


def test_every_sized_field_is_listed_with_its_driver(short: Path, says: Says) -> None:
    out = says(["explain", str(short)]).out
    for value in load_design(short).sized:
        assert any(line.startswith(value.field) and value.driver in line for line in out.splitlines()), value.field


def test_one_field_is_told_down_to_what_the_file_gives(short: Path, says: Says) -> None:
    out = says(["explain", str(short), "support.back_y_mm"]).out
    assert "set by: " in out and "loads.peak_torque_Nm = 3.15  (given)" in out, out
    found = json.loads(says(["explain", str(short), "support.back_y_mm", "--json"]).out)
    assert found["value"] == load_design(short).design.model_dump()["support"]["back_y_mm"], found
    assert found["given"] is False and "drive.gearhead" in found["rests_on"], found


def test_a_pin_is_told_beside_what_its_rule_gives(short: Path, says: Says) -> None:
    data = yaml.safe_load(short.read_text())
    data["drum"] = {"outer_face_y_mm": 30.0}
    short.write_text(yaml.safe_dump(data))
    out = says(["explain", str(short), "drum.outer_face_y_mm"]).out
    assert "drum.outer_face_y_mm = 30.0" in out and "given in the file" in out and "its rule gives 1" in out, out


def test_a_pulley_on_the_motors_shaft_beside_a_stiffness_is_told(says: Says) -> None:
    """Its rules are tried without ``carried_by`` too, where bearings called none are no drive."""
    path = Path(__file__).parents[3] / "params" / "built-by-others" / "wooden-haptics.yaml"
    out = says(["explain", str(path)]).out
    assert re.search(r"^transmission.input_to_drum +16.0 +given; its rule gives ", out, re.M)
    # A rule that had nothing to choose is not told.
    assert re.search(r"^drive.encoder +none +not used: the motor's shaft carries the pulley$", out, re.M)


@pytest.mark.parametrize(("more", "said"), [("", "lightest of"), (", speed_deg_s: 172.0", "the torque at the speed")])
def test_no_gearhead_is_told_with_the_speed_that_refused_it(more: str, said: str) -> None:
    text = (
        "configuration: siso_spur\ntravel: {half_angle_deg: 45.0}\ntransmission: {input_to_drum: 11.12}\n"
        f"loads: {{peak_torque_Nm: 15.0{more}}}\n"
    )
    found = next(value for value in load_text(text, "drive.yaml").sized if value.field == "drive.gearhead")
    assert (found.value == "none") is bool(more) and said in f"{found.driver} {found.rounding}", found


def test_an_unknown_field_is_one_sentence(short: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["explain", str(short), "drum.outer_face"]) == cli.run(["explain", str(short), "stage.kind"]) == 2
    assert "did you mean drum.outer_face_y_mm?" in (told := capsys.readouterr().err) and "no block stage: belt" in told


def test_a_complete_file_is_told_beside_what_the_rules_give(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["explain", str(Path(__file__).parents[3] / "params" / "mbcdm.yaml")]) == 0
    lines = {line.split()[0]: line for line in capsys.readouterr().out.splitlines()}
    assert len(lines) > 45
    assert "34.6" in lines["transmission.centre_distance_mm"]
    assert "given; its rule gives 34.5 (fleet_angle" in lines["transmission.centre_distance_mm"]


DRIVE = load_design(DESIGN).drive


@given(
    st.floats(1.0, 35.0),
    st.floats(60.0, 2000.0),
    st.floats(0.5, 100.0),
    st.sets(st.sampled_from(["brake", "weight", "torque_motor"])),
    st.floats(0.01, 5.0),
)
def test_every_run_stays_within_the_bench(
    travel: float, duration: float, speed: float, loads: set[str], torque: float
) -> None:
    limits = BenchLimits.model_validate(
        {
            "half_travel_deg": travel,
            "duration_s": duration,
            "drum_speed_max_deg_s": speed,
            "loads": tuple(sorted(loads)),
            "torque_Nm": torque if loads else None,
        }
    )
    found = candidates(DRIVE, limits)
    assert found
    for one in found:
        amplitude = one.motion.amplitude_mrad * 180e-3 / pi
        assert amplitude <= travel + 0.01, one.about
        assert 2.0 * pi * amplitude / one.motion.period_s <= speed * 1.01, one.about
        assert one.duration_s <= duration + 1e-3
        most = max(abs(level) for level in one.load.levels_Nm) + abs(one.load.bias_Nm)
        assert most <= (torque if loads else 0.0) + 2e-3, (one.about, most)
        assert one.load.kind in {"none", *loads}, one.about


@pytest.mark.parametrize("loads", [(), ("brake", "weight", "torque_motor")])
def test_each_run_is_offered_as_a_triangle_and_as_a_sine(loads: tuple[str, ...]) -> None:
    limits = BenchLimits.model_validate({"loads": loads, "torque_Nm": 1.0 if loads else None})
    found = candidates(DRIVE, limits)

    def of(shape: str) -> list[tuple[object, ...]]:
        chosen = [one for one in found if one.motion.shape == shape]
        return [(one.motion.amplitude_mrad, one.motion.period_s, one.load) for one in chosen]

    assert of("triangle") == of("sine") and 2 * len(of("sine")) == len(found)
    assert all(one.motion.shape in one.about for one in found)


def test_a_sine_tells_friction_from_delay_and_a_triangle_hardly() -> None:
    limits = BenchLimits.model_validate({"duration_s": 60.0, "loads": ("weight",), "torque_Nm": 0.5})
    runs = {one.motion.shape: one for one in reversed(candidates(DRIVE, limits)) if one.motion.amplitude_mrad > 300.0}
    multiples = {}
    for shape, one in runs.items():
        plan = plan_of(DRIVE, run_of(DRIVE, one))
        friction = next(seen for seen in plan.effects if seen.label.startswith("friction"))
        assert friction.smallest is not None
        told = [rival.from_size or inf for rival in friction.rivals if rival.label.startswith("delay (late")]
        multiples[shape] = max([friction.smallest, *told]) / friction.smallest
    print(f"friction is told from delay from so many times its smallest size: {multiples}")
    assert multiples["triangle"] > 2.0 * multiples["sine"], multiples


@pytest.mark.slow
def test_the_best_run_is_written_as_an_experiment(tmp_path: Path, says: Says) -> None:
    bench, planned = tmp_path / "bench.yaml", tmp_path / "planned.yaml"
    bench.write_text("half_travel_deg: 20.0\nduration_s: 60.0\nsample_rate_Hz: 20.0\nloads: [weight]\ntorque_Nm: 0.4\n")
    said = says(["plan", str(DESIGN), "--within", str(bench), "--write", str(planned)]).out
    assert "8 runs compared" in said and "named from (power 0.9)" in said, said
    found = read_experiment(planned)
    assert isinstance(found, Experiment) and found.sample_rate_Hz == 20.0 and found.load.bias_Nm == 0.4
    assert f"best: {found.about}" in said, said


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("loads: [brake]\n", "bench.yaml:1: torque_Nm: missing beside loads; add torque_Nm"),
        ("torque_Nm: 1.0\n", "bench.yaml:1: loads: missing beside torque_Nm; add loads"),
        ("loads: [hand]\ntorque_Nm: 1.0\n", "bench.yaml:1: loads[0]: not possible (value 'hand'"),
        ("duration_s: 1.0\n", "bench.yaml:1: duration_s: not possible (value 1.0, limit at least 60.0)"),
        ("speed: 1.0\n", "bench.yaml:1: speed: unknown field"),
    ],
)
def test_a_faulty_bench_file_is_told_with_its_line(tmp_path: Path, says: Says, text: str, said: str) -> None:
    bench = tmp_path / "bench.yaml"
    bench.write_text(text)
    assert said in says(["plan", str(DESIGN), "--within", str(bench)], 2).err


def test_neither_experiment_nor_bench_is_told(says: Says) -> None:
    assert "give an experiment file, --within BENCH.yaml, or both" in says(["plan", str(DESIGN)], 2).err
