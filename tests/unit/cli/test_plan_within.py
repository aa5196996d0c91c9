"""``mbcdm plan --within``: runs stay within the limits of the bench; the best is an experiment that the rig reads."""

from __future__ import annotations

from math import inf, pi
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbcdm_cad.cli import run as mbcdm
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.planning.best_run import candidates, run_of
from mbcdm_cad.planning.plan import plan_of
from mbcdm_cad.rig.bench import BenchLimits
from mbcdm_cad.rig.experiment import Experiment, read_experiment

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
def test_the_best_run_is_written_as_an_experiment(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bench, planned = tmp_path / "bench.yaml", tmp_path / "planned.yaml"
    bench.write_text("half_travel_deg: 20.0\nduration_s: 60.0\nsample_rate_Hz: 20.0\nloads: [weight]\ntorque_Nm: 0.4\n")
    assert mbcdm(["plan", str(DESIGN), "--within", str(bench), "--write", str(planned)]) == 0
    said = capsys.readouterr().out
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
