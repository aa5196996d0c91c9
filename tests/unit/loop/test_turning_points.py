"""Tables by hand: turning points and creep at rest, coarse gauges, missing rows, noise nobody declared."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import mbcdm_cad as mc
from mbcdm_cad.cli import run as mbcdm
from mbcdm_cad.errors import InputError
from mbcdm_cad.loop.judge import LoopReport
from mbcdm_cad.loop.result import LoopResult
from mbcdm_cad.measurement.by_hand import loadings, path_of, written_step
from mbcdm_cad.measurement.run import Run
from tests.support.reference import ROOT

COMPLIANCE, PLAY = 5e-4, 1.2e-3
HEAD = """data: {name}.csv
kind: turning_points
decimal: comma
columns:
  output: {{column: gauge_mm, unit: mm, radius_mm: 100}}
  load_torque: {{column: load_Nm, unit: N*m}}
ratio: 10
"""


def locked(
    folder: Path,
    seed: int,
    compliance: float,
    play: float,
    missing: tuple[int, ...] = (),
    name: str = "table",
    noise: float = 4e-5,
) -> Path:
    """Input locked, a spring balance on an arm: a dial gauge with steps of 0.01 mm, read to ``noise``, rad."""
    rng = np.random.default_rng(seed)
    load = np.tile([0.5, -0.5, 1.0, -1.0, 2.0, -2.0], 3)
    drum = -compliance * load - 0.5 * play * np.sign(load) + rng.normal(0.0, noise, load.size)
    gauge = np.round((100.0 * drum + 5.32) / 0.01) * 0.01
    told = load * (1.0 + rng.normal(0.0, 0.003, load.size))
    lines = ["load_Nm;gauge_mm;note"]
    for k in range(load.size):
        cell = "-;the phone rang" if k in missing else f"{gauge[k]:.2f};"
        lines.append(f"{told[k]:.2f};{cell}".replace(".", ","))
    (folder / f"{name}.csv").write_text("\n".join(lines) + "\n")
    (folder / f"{name}.yaml").write_text(HEAD.format(name=name))
    return folder / f"{name}.yaml"


def judged(path: Path) -> LoopReport:
    return mc.close_loop(None, path)


def names(report: LoopReport) -> list[str]:
    return sorted(one.name for one in report.result.effects)


def test_play_and_stiffness_come_out_of_a_table_with_missing_rows(tmp_path: Path) -> None:
    report = judged(locked(tmp_path, 1, COMPLIANCE, PLAY, missing=(4, 9)))
    assert names(report) == ["lash", "stiffness_error"], report.result.sentence
    figures = {one.name: next(iter(one.parameters.values())) for one in report.result.effects}
    assert figures["lash"].low < PLAY < figures["lash"].high
    assert figures["stiffness_error"].low < COMPLIANCE < figures["stiffness_error"].high
    assert report.verdict == "explained"
    assert report.result.errors.after.value < 0.1 * report.result.errors.before.value
    text = report.text()
    assert "2 half cycle(s) missing, after row 4, 8" in text
    assert "a table of 16 turning points of the load, with the inputs at rest" in text
    assert b"data:image/png" in report.page()


def test_intervals_hold_the_truth_and_nothing_else_is_named(tmp_path: Path) -> None:
    inside, named, tables = 0, 0, 30
    for seed in range(tables):
        report = judged(locked(tmp_path, 100 + seed, COMPLIANCE, PLAY))
        assert set(names(report)) <= {"lash", "stiffness_error"}, report.result.sentence
        # Where the contact changes sides lies between the rows: it has no figure.
        assert "zero" not in report.result.sentence
        for one in report.result.effects:
            value = next(iter(one.parameters.values()))
            inside += value.low < (PLAY if one.name == "lash" else COMPLIANCE) < value.high
            named += 1
    assert named >= 2 * tables - 2
    assert inside >= 0.85 * named, f"{inside} of {named}"


def test_a_sound_drive_gets_no_name(tmp_path: Path) -> None:
    """The gauge is the only error: noise and steps that no file declares."""
    said = [judged(locked(tmp_path, 300 + seed, 0.0, 0.0, noise=1.5e-4)).verdict for seed in range(12)]
    assert said.count("none") >= 11, said
    assert not {"explained", "partly_explained"} & set(said), said


def test_lost_motion_without_a_load_is_a_set(tmp_path: Path) -> None:
    """A motor goes to and fro and nobody measured a torque: play, or friction through a stiffness."""
    rng = np.random.default_rng(4)
    angle = np.tile([30.0, -30.0, 50.0, -50.0, 70.0, -70.0], 3) + rng.normal(0.0, 0.3, 18)
    sense = np.sign(angle)
    output = angle / 8.0 - 0.05 * sense + rng.normal(0.0, 0.002, angle.size)
    rows = [f"{a:.2f},{b:.3f}" for a, b in zip(angle, output, strict=True)]
    (tmp_path / "lost.csv").write_text("motor_deg,arm_deg\n" + "\n".join(rows) + "\n")
    (tmp_path / "lost.yaml").write_text(
        "data: lost.csv\nkind: turning_points\ncolumns:\n  input: {column: motor_deg, unit: deg}\n"
        "  output: {column: arm_deg, unit: deg}\nratio: 8\n"
    )
    result = judged(tmp_path / "lost.yaml").result
    (group,) = result.one_of
    assert {one.name for one in group} == {"lash", "friction"}
    play = next(one for one in group if one.name == "lash").parameters["play_rad"]
    assert play.low < np.radians(0.1) < play.high


@pytest.mark.slow
def test_a_soft_rope_comes_out_of_the_rig_s_table(tmp_path: Path) -> None:
    """The rig has its own physics of rope and wraps; the drum is pushed to and fro with the inputs locked."""
    experiment = ROOT / "params/experiments/by-hand/turning-points-soft-rope.yaml"
    assert mbcdm(["simulate", str(ROOT / "params/mbcdm.yaml"), str(experiment), "--out", str(tmp_path)]) == 0
    run = tmp_path / experiment.stem / f"{experiment.stem}.yaml"
    assert "kind: turning_points" in run.read_text()
    result = mc.close_loop(mc.load(ROOT / "params/mbcdm.yaml"), run).result
    (found,) = result.effects
    assert found.name == "stiffness_error"
    share = found.parameters["share"]
    assert share.low < -0.25 < share.high
    assert share.high - share.low < 0.05


def pushed(folder: Path, loads: list[float], play: float = 6e-4) -> Path:
    """An arm behind a play at the output of the reference drive, whose inputs are locked."""
    rng = np.random.default_rng(8)
    load = np.tile(loads, 2)
    drum = -2e-4 * load - 0.5 * play * np.sign(load) + rng.normal(0.0, 1e-5, load.size)
    rows = [f"{a:.2f};{100.0 * b:.3f}".replace(".", ",") for a, b in zip(load, drum, strict=True)]
    (folder / "pushed.csv").write_text("load_Nm;gauge_mm\n" + "\n".join(rows) + "\n")
    (folder / "pushed.yaml").write_text(HEAD.format(name="pushed").replace("ratio: 10\n", ""))
    return folder / "pushed.yaml"


def simulated(folder: Path, design: str, **changed: str) -> LoopResult:
    """The result from the rig's table of a motion under a brake with a play, short and with other words."""
    text = (ROOT / "params/experiments/by-hand/turning-points-lash.yaml").read_text()
    for old, new in {"duration_s: 300.0": "duration_s: 180.0", "sample_rate_Hz: 50.0": "sample_rate_Hz: 10.0"}.items():
        assert old in text
        text = text.replace(old, new)
    for old, new in changed.items():
        text = text.replace(old, new)
    folder.mkdir(exist_ok=True)
    (folder / "short.yaml").write_text(text)
    drive = ROOT / f"params/{design}.yaml"
    assert mbcdm(["simulate", str(drive), str(folder / "short.yaml"), "--out", str(folder)]) == 0
    (run,) = (one for one in folder.glob("*/turning-points-lash.yaml"))
    return mc.close_loop(mc.load(drive), run).result


def untold(result: LoopResult, words: str) -> None:
    assert result.verdict == "not_testable", result.sentence
    assert words in result.sentence
    assert not result.effects
    assert not result.one_of
    assert not result.evidence
    assert result.errors.after.value == result.errors.before.value


@pytest.mark.slow
def test_a_play_under_a_load_that_changes_sign_is_not_told_with_several_inputs(tmp_path: Path) -> None:
    """Where the pulleys rest within a play at an input is not in the table: no name, also where the play is another."""
    drive = mc.load(ROOT / "params/mbcdm.yaml")
    result = mc.close_loop(drive, pushed(tmp_path, [0.3, -0.3, 0.6, -0.6, 0.9, -0.9])).result
    untold(result, "the load changes its sign between the rows")
    # With the load on one side no pulley floats.
    result = mc.close_loop(drive, pushed(tmp_path, [0.3, 0.1, 0.6, 0.3, 0.9, 0.6])).result
    assert result.verdict != "not_testable", result.sentence
    assert "lash" not in result.sentence


@pytest.mark.slow
def test_inputs_that_move_under_a_load_are_followed_while_no_extreme_of_it_is_left_out(tmp_path: Path) -> None:
    """A motion under a brake of several sizes: the rig writes a row before its torque is made smaller. Without these
    rows the friction of the cables remembers loads that the table does not have."""
    effect = "  - {effect: gearhead_lash, stage: input_left, play_urad: 1000.0}\n"
    soft = simulated(tmp_path, "mbcdm", **{effect: "  - {effect: modulus, share: -0.25}\n"})
    (found,) = soft.effects
    share = found.parameters["share"]
    assert found.name == "stiffness_error" and share.low < -0.25 < share.high < share.low + 0.05, soft.sentence
    sound = simulated(tmp_path / "sound", "siso_spur", **{effect: "", "effects:": "effects: []"})
    assert sound.verdict == "none", sound.sentence
    folder = tmp_path / "sound" / "turning-points-lash"
    (table,) = folder.glob("*.csv")
    head, *rows = table.read_text().splitlines()
    angle = np.array([float(row.split(",")[1]) for row in rows])
    ends = np.abs(angle) > 0.9 * np.abs(angle).max()
    assert 0 < (~ends).sum() < 4
    table.write_text("\n".join([head, *np.array(rows)[ends]]) + "\n")
    lost = mc.close_loop(mc.load(ROOT / "params/siso_spur.yaml"), folder / "turning-points-lash.yaml").result
    untold(lost, "made smaller before the next row")


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ([], "bad.csv:2: no rows below the header"),
        (["0,50;5,27"], "bad.csv:1: too few samples"),
        (["much;little"] * 12, "bad.csv:2: too many broken rows"),
        (["nan;nan"] * 12, "bad.csv:2: too many broken rows"),
        ([f"{0.1 * k:.1f};{5.3 - 0.01 * k:.2f}".replace(".", ",") for k in range(12)], "bad.yaml:2: kind: all rows go"),
    ],
)
def test_a_bad_table_is_refused_with_its_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], rows: list[str], said: str
) -> None:
    (tmp_path / "bad.csv").write_text("load_Nm;gauge_mm\n" + "".join(f"{row}\n" for row in rows))
    (tmp_path / "bad.yaml").write_text(HEAD.format(name="bad"))
    assert mbcdm(["loop", str(tmp_path / "bad.yaml")]) == 2
    assert said in capsys.readouterr().err


def test_encoders_of_locked_inputs_may_flicker(tmp_path: Path) -> None:
    """A few steps of an encoder are no motion: the load is what turns round."""
    path = locked(tmp_path, 1, COMPLIANCE, PLAY)
    head, *rows = (tmp_path / "table.csv").read_text().splitlines()
    counts = np.random.default_rng(2).integers(0, 4, len(rows))
    (tmp_path / "table.csv").write_text(
        "\n".join([f"{head};count", *(f"{row};{n}" for row, n in zip(rows, counts, strict=True))]) + "\n"
    )
    declared = (
        "  input: {column: count, unit: counts, counts_per_turn: 40000}\nsensors: {input_resolution_rad: 1.5708e-4}\n"
    )
    path.write_text(path.read_text().replace("ratio:", f"{declared}ratio:"))
    assert names(judged(path)) == ["lash", "stiffness_error"]


def test_what_is_wrong_with_a_table_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = locked(tmp_path, 1, COMPLIANCE, PLAY)
    other = locked(tmp_path, 2, COMPLIANCE, PLAY, name="other")
    text = path.read_text()
    path.write_text(text.replace("unit: N*m}", "unit: N*m, scale: -1}"))
    assert mbcdm(["loop", str(path)]) == 2
    assert "with the inputs at rest the output moves against the load" in capsys.readouterr().err
    path.write_text(text.replace("kind: turning_points", "kind: motion"))
    assert mbcdm(["loop", str(path)]) == 2
    assert "columns: an input is missing" in capsys.readouterr().err
    path.write_text(text)
    assert mbcdm(["loop", str(path), "--correction", str(tmp_path / "table")]) == 2
    assert "leave --correction out; it works from runs of kind motion" in capsys.readouterr().err
    motion = text.replace("kind: turning_points", "kind: motion\nsample_rate_Hz: 1")
    other.write_text(motion.replace("load_torque:", "input:").replace("N*m", "deg"))
    with pytest.raises(InputError, match="another kind of run"):
        mc.close_loop(None, [path, other])


def test_missing_turning_points_and_steps_of_figures() -> None:
    def table(load: list[float]) -> Run:
        values = np.array(load)
        return Run(
            np.arange(values.size, dtype=float), np.zeros((1, values.size)), -values, values, kind="turning_points"
        )

    whole = path_of(table([0.1, -0.1, 1.0, -1.0, 0.1, -0.1, 1.0, -1.0]))
    assert whole.read.all()
    gone = path_of(table([1.0, -1.0, 1.0, 1.02, -1.0, 1.0, -0.98, -1.0]))
    assert np.flatnonzero(~gone.read).tolist() == [3, 8]
    assert gone.load_Nm is not None
    assert gone.load_Nm[3] == pytest.approx(-1.0)
    assert gone.load_Nm[8] == pytest.approx(1.0)
    along = path_of(table([0.0, 0.5, 1.0, 0.5, 0.0, -0.5, -1.0, -0.5, 0.0, 0.5]))
    assert along.along
    assert along.read.all()
    assert written_step(np.array([5.32, 5.35, 5.31, 5.40])) == pytest.approx(0.01)
    assert written_step(np.random.default_rng(1).normal(size=30)) == 0.0


BY_HAND_S = 60.0 * np.array([0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000])
A_DECADE = 4e-5
Law = Callable[[np.ndarray], np.ndarray]


def chain(t: np.ndarray) -> np.ndarray:
    """Springs with dampers, one for each decade of time: what a printed part does, rad for 1 N m."""
    return np.asarray(sum(A_DECADE * -np.expm1(-np.maximum(t, 0.0) / T) for T in 10.0 ** np.arange(-1, 6)))


def warming(t: np.ndarray) -> np.ndarray:
    return np.asarray(1.5e-4 * -np.expm1(-np.maximum(t, 0.0) / 3000.0))


def readings(
    folder: Path, t: np.ndarray, load: np.ndarray, turned: np.ndarray, seed: int, more: str = "", noise: float = 1e-5
) -> LoopReport:
    """Judge readings with noise that no file declares, rounded to 2 urad; ``turned`` in rad."""
    rng = np.random.default_rng(seed)
    output = np.round((turned + rng.normal(0.0, noise, t.size)) / 2e-6) * 2e-6 + 0.3
    rows = [
        f"{a:.8g},{b:.3f},{c:.7g},{d:.3f}" for a, b, c, d in zip(t, load, output, 21.0 + 1e4 * warming(t), strict=True)
    ]
    (folder / "rest.csv").write_text("t,load,arm,room\n" + "\n".join(rows) + "\n")
    (folder / "rest.yaml").write_text(
        "data: rest.csv\nkind: creep\ncolumns:\n  time: {column: t, unit: s}\n  output: {column: arm, unit: rad}\n"
        f"  load_torque: {{column: load, unit: N*m}}\n{more}ratio: 10\n"
    )
    return mc.close_loop(None, folder / "rest.yaml")


def test_readings_by_hand_give_the_creep_for_each_decade(tmp_path: Path) -> None:
    held = np.full(BY_HAND_S.size, 2.0)
    logarithmic, inside = 0, 0
    for seed in range(6):
        report = readings(tmp_path, BY_HAND_S, held, -2.0 * chain(BY_HAND_S), seed)
        (found,) = report.result.effects
        assert found.name == "creep", report.result.sentence
        if "a_decade_rad_Nm" in found.parameters:
            value = found.parameters["a_decade_rad_Nm"]
            logarithmic, inside = logarithmic + 1, inside + (value.low < A_DECADE < value.high)
        assert report.result.errors.after.value < 0.6 * report.result.errors.before.value
    assert logarithmic >= 5
    assert inside >= logarithmic - 1
    assert "4 decades" in report.text()
    assert b"data:image/png" in report.page()


def test_a_drive_that_does_not_creep_gets_no_name(tmp_path: Path) -> None:
    held, still = np.full(BY_HAND_S.size, 2.0), np.zeros(BY_HAND_S.size)
    said = [readings(tmp_path, BY_HAND_S, held, still, 50 + seed).verdict for seed in range(8)]
    assert said.count("none") >= 7, said
    assert not {"explained", "partly_explained"} & set(said), said


def test_readings_that_no_law_can_be_told_from_are_refused(tmp_path: Path) -> None:
    """One decade of time; a load that changes at each row; one that is put on at the end."""
    decade, half = np.linspace(60.0, 600.0, 10), BY_HAND_S.size // 2
    flips = 2.0 * (-1.0) ** np.arange(BY_HAND_S.size)
    late = np.where(np.arange(BY_HAND_S.size) > 2 * half - 1, 2.0, 0.0)
    for t, load in ((decade, np.full(10, 2.0)), (BY_HAND_S, flips), (BY_HAND_S, late)):
        with pytest.raises(InputError, match=r"rest.yaml:4: columns.time: .* of the 2 decades of time"):
            readings(tmp_path, t, load, -2.0 * chain(t), 1)


def test_readings_without_a_load_say_so(tmp_path: Path) -> None:
    report = readings(tmp_path, BY_HAND_S, np.zeros(BY_HAND_S.size), -chain(BY_HAND_S), 1)
    text = report.text()
    assert "doubt: no load" in text
    assert "under 1 N m" not in text
    assert "the load stays on" not in text


def test_recovery_tells_a_warming_from_a_creep(tmp_path: Path) -> None:
    """One delay in the sense of the load: a set while the load stays on, a warming once it was taken off."""
    t = np.geomspace(5.0, 2e4, 40)
    stays = readings(tmp_path, t, np.full(t.size, 2.0), -warming(t), 3, noise=4e-6).result
    assert [{one.name for one in group} for group in stays.one_of] == [{"creep", "thermal_drift"}], stays.sentence
    both = np.concatenate([t, 2e4 + t])
    load = np.repeat([2.0, 0.0], t.size)
    off = readings(tmp_path, both, load, -warming(both), 3, noise=4e-6).result
    assert [one.name for one in off.effects] == ["thermal_drift"], off.sentence
    crept = readings(tmp_path, both, load, -2.0 * (chain(both) - np.where(load > 0, 0.0, chain(both - 2e4))), 3).result
    assert [one.name for one in crept.effects] == ["creep"], crept.sentence


def test_a_temperature_that_was_logged_is_told_from_creep(tmp_path: Path) -> None:
    t = np.geomspace(5.0, 2e4, 40)
    more = "  temperature: {column: room, unit: degC}\n"
    result = readings(tmp_path, t, np.full(t.size, 2.0), -2.0 * chain(t) + 2.0 * warming(t), 4, more, noise=4e-6).result
    assert sorted(one.name for one in result.effects) == ["creep", "thermal_drift"], result.sentence
    found = {one.name: one for one in result.effects}
    turn = found["thermal_drift"].parameters["turn_rad_K"]
    assert turn.low < 2e-4 < turn.high


def test_a_logger_at_uneven_times_with_a_coarse_encoder(tmp_path: Path) -> None:
    """20 000 samples, noise of an encoder of 100 urad a step, load put on after 40 s of log."""
    rng = np.random.default_rng(7)
    t = 0.2 * np.arange(20_000) + rng.uniform(0.0, 0.15, 20_000)
    load = np.where(t > 40.0, 2.0, 0.0) + rng.normal(0.0, 0.005, t.size)
    turned = -2.0 * (np.where(t > 40.0, 3e-4, 0.0) + chain(t - 40.0))
    report = readings(tmp_path, t, load, np.round(turned / 1e-4 + rng.uniform(-0.5, 0.5, t.size)) * 1e-4, 8)
    (found,) = report.result.effects
    assert found.name == "creep"
    if "a_decade_rad_Nm" in found.parameters:
        value = found.parameters["a_decade_rad_Nm"]
        assert value.low < A_DECADE < value.high
    (step,) = loadings(report.runs[0].run)
    assert step[0] == pytest.approx(40.0, abs=1.0)
    assert step[1] == pytest.approx(2.0, rel=0.01)


@pytest.mark.slow
def test_a_printed_hub_of_the_rig_creeps_and_goes_back(tmp_path: Path) -> None:
    experiment = ROOT / "params/experiments/by-hand/creep-printed-hub.yaml"
    assert mbcdm(["simulate", str(ROOT / "params/mbcdm.yaml"), str(experiment), "--out", str(tmp_path)]) == 0
    result = mc.close_loop(
        mc.load(ROOT / "params/mbcdm.yaml"), tmp_path / experiment.stem / f"{experiment.stem}.yaml"
    ).result
    (found,) = result.effects
    assert found.name == "creep"
    # The rig has 15 to 40 urad/(N m) for each decade.
    value = found.parameters["a_decade_rad_Nm"]
    assert 1.5e-5 < value.low < value.high < 4e-5
