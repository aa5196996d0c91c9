"""``mbcdm plan --within``: runs stay within the limits of the bench; the best is an experiment that the rig reads."""

from __future__ import annotations

from math import pi
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbcdm_cad.cli import run as mbcdm
from mbcdm_cad.cli.bench_runs import candidates
from mbcdm_cad.configurations.loader import load_design
from mbcdm_cad.rig.bench_limits import BenchLimits
from mbcdm_cad.rig.quasistatic.experiment import Experiment
from mbcdm_cad.rig.reading import read_experiment

DESIGN = Path(__file__).parents[3] / "params" / "mbcdm.yaml"
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


@pytest.mark.slow
def test_the_best_run_is_written_as_an_experiment(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bench, planned = tmp_path / "bench.yaml", tmp_path / "planned.yaml"
    bench.write_text("half_travel_deg: 20.0\nduration_s: 60.0\nsample_rate_Hz: 20.0\nloads: [weight]\ntorque_Nm: 0.4\n")
    assert mbcdm(["plan", str(DESIGN), "--within", str(bench), "--write", str(planned)]) == 0
    said = capsys.readouterr().out
    assert "4 runs compared" in said and "named from (power 0.9)" in said, said
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
def test_a_faulty_bench_file_is_told_with_its_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, said: str
) -> None:
    bench = tmp_path / "bench.yaml"
    bench.write_text(text)
    assert mbcdm(["plan", str(DESIGN), "--within", str(bench)]) == 2
    assert said in capsys.readouterr().err


def test_neither_experiment_nor_bench_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert mbcdm(["plan", str(DESIGN)]) == 2
    assert "give an experiment file, --within BENCH.yaml, or both" in capsys.readouterr().err
