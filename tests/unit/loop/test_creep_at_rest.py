"""Creep at rest: readings by hand and logs of benches made here, whose creep follows no law of the loop's."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import mbcdm_cad as mc
from mbcdm_cad.cli import run as mbcdm
from mbcdm_cad.errors import InputError
from mbcdm_cad.loop.judge import LoopReport
from mbcdm_cad.measurement.by_hand import loadings

ROOT = Path(__file__).parents[3]
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
