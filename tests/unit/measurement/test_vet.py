"""Vetting: wrong declarations are found and reported, a correct run gives no finding."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sound_runs import DRIVE, sound_run

from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.measurement.reading import load_measurement
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.measurement.vet import arranged, refusals, vet
from mbcdm_cad.measurement.vet_signals import load_levels, order_left
from tests.support.bench_data import CASES, simulate_case, write_run

RUN = sound_run()
RATIO = float(np.mean(layout_of(DRIVE).si.total_ratio))
FEW = ("null", "ratio_radii", "lash_input_left", "slip_anchor", "drum_short")


def kinds(run: Run, level: str | None = None) -> set[str]:
    return {finding.kind for finding in vet(run, DRIVE) if level in (None, finding.level)}


@pytest.mark.parametrize(
    ("design", "columns", "first"),
    [
        (("left", "right"), ("right", "left"), "left"),
        (("port", "star"), ("star", "port"), "port"),
        (("port", "star"), ("left", "right"), "left"),
    ],
)
def test_inputs_come_in_the_order_of_the_design(design: tuple[str, str], columns: tuple[str, str], first: str) -> None:
    cables = tuple(replace(c, input_name=design[DRIVE.input_names.index(c.input_name)]) for c in DRIVE.cables)
    drive = replace(DRIVE, input_names=design, cables=cables)
    run = replace(RUN, input_names=columns, input_rad=RUN.input_rad * np.array([[1.0], [1.001]]))
    found = arranged(run, drive)
    assert found.input_names[0] == first, found.input_names
    assert (found.input_rad[0] == run.input_rad[columns.index(first)]).all()
    assert not refusals(vet(found, drive)), refusals(vet(found, drive))
    strange = refusals(vet(replace(found, input_names=("one", "two")), drive))
    assert strange and "are not those of the design" in str(strange[0]), strange


def test_motor_turns_become_those_of_the_inputs() -> None:
    gearhead = DRIVE.gearhead.ratio
    sensors = Sensors(input_resolution_rad=gearhead * 1.9175e-4, output_resolution_rad=1.3635e-6)
    run = replace(RUN, input_rad=gearhead * RUN.input_rad, motor_side=(True, True), sensors=sensors)
    found = arranged(run, DRIVE)
    np.testing.assert_allclose(found.input_rad, RUN.input_rad, rtol=1e-12)
    assert found.sensors.input_resolution_rad == pytest.approx(1.9175e-4) and found.motor_side == ()
    assert not refusals(vet(found, DRIVE)), refusals(vet(found, DRIVE))
    said = "; ".join(str(note) for note in refusals(vet(replace(run, motor_side=()), DRIVE)))
    assert f"the gearhead's {gearhead:g}" in said and "set side: motor" in said, said


def with_inputs(factor_left: float, factor_right: float) -> Run:
    return replace(RUN, input_rad=RUN.input_rad * np.array([[factor_left], [factor_right]]))


def test_a_sound_run_is_left_in_peace() -> None:
    found = vet(RUN, DRIVE)
    assert not [str(finding) for finding in found if finding.level != "fact"]
    said = "\n".join(str(finding) for finding in found)
    assert "12 half sweep(s)" in said and "load levels 0.1, 0.9 N m" in said, said


@pytest.mark.parametrize(
    ("run", "kind", "field", "words"),
    [
        (with_inputs(-1, -1), "reversed_output", "output", "scale: -1"),
        (with_inputs(-1, 1), "reversed_input", "input_left", "left input turns against"),
        (with_inputs(1, -1), "reversed_input", "input_right", "right input turns against"),
        (with_inputs(57.29578, 57.29578), "unit", "input_left", "degrees declared as radians"),
        (with_inputs(1, 57.29578), "unit", "input_right", "degrees declared as radians"),
        (with_inputs(2, 2), "unit", "input_left", "counts_per_turn half"),
        (with_inputs(1, 0.25), "unit", "input_right", "the reverse of counts_per_turn a quarter"),
        (replace(RUN, output_rad=RUN.output_rad * 57.29578), "unit", "output", "output too large by 57.3, degrees"),
        (with_inputs(3, 3), "ratio", "input_left", "slope between inputs and output 27"),
        (
            replace(RUN, output_rad=RUN.input_rad[1], input_rad=np.stack([RUN.input_rad[0], RUN.output_rad])),
            "swapped",
            "output",
            "output and input_right look swapped",
        ),
        (
            replace(RUN, output_rad=RUN.load_Nm, load_Nm=RUN.output_rad),
            "swapped",
            "output",
            "output and load_torque look swapped",
        ),
        (
            replace(RUN, output_rad=57.29578 * RUN.output_rad, input_rad=57.29578 * RUN.input_rad),
            "travel",
            "output",
            "degrees declared as radians",
        ),
        (
            replace(RUN, input_rad=np.stack([RUN.input_rad[0], np.random.default_rng(1).normal(size=RUN.time_s.size)])),
            "unrelated",
            "input_right",
            "does not follow the right input",
        ),
        (replace(RUN, load_Nm=-RUN.load_Nm), "reversed_load", "load_torque", "scale: -1 on load_torque"),
        (replace(RUN, load_Nm=1000.0 * RUN.load_Nm), "load", "load_torque", "mN*m declared as N*m?"),
        (replace(RUN, input_rad=RUN.input_rad[:1], input_names=("input",)), "inputs", "columns", "1 input column"),
        (replace(RUN, input_rad=np.mod(RUN.input_rad, 2.0 * np.pi)), "wrapped", "input_left", "jumps by a full turn"),
    ],
)
def test_wrong_columns_are_refused_with_field_and_remedy(run: Run, kind: str, field: str, words: str) -> None:
    found = refusals(vet(run, DRIVE))
    said = [f"{finding.kind} {finding.field}: {finding}" for finding in found]
    assert any(f.kind == kind and f.field[-1] == field and words in str(f) for f in found), said
    assert all(finding.remedy for finding in found), said
    others = {"reversed_output", "reversed_input", "unit", "swapped", "travel", "reversed_load"} - {kind}
    assert not [finding.kind for finding in found if finding.kind in others], said


def test_a_late_sensor_is_not_a_load_of_the_wrong_sign() -> None:
    """A motor that helps the motion: the load is least where the late output is farthest behind."""
    speed = np.gradient(RUN.input_rad[0], RUN.time_s)
    load = 0.5 - 0.6 * speed / np.abs(speed).max()
    now = RUN.input_rad.mean(axis=0) / RATIO - 1e-4 * load
    late = np.interp(RUN.time_s - 5e-3, RUN.time_s, now)
    found = vet(replace(RUN, output_rad=late, load_Nm=load), DRIVE)
    assert not [str(f) for f in found if f.kind in ("reversed_load", "load", "unit")], [str(f) for f in found]


def clipped(run: Run) -> Run:
    return replace(run, output_rad=np.clip(run.output_rad, -0.2, 1.0))


@pytest.mark.parametrize(
    ("run", "kind", "words"),
    [
        (clipped(RUN), "saturated", "output stays at its lowest figure, -0.2 rad"),
        (
            replace(RUN, load_Nm=np.minimum(RUN.load_Nm, 0.88)),
            "saturated",
            "load torque is at its highest figure, 0.88",
        ),
        (replace(RUN, time_s=RUN.time_s + 3.0 * (RUN.time_s > 20.0)), "gaps", "the longest 3.01 s at 20 s"),
        (sound_run(half_sweeps=1), "one_sweep", "nothing repeats"),
        (sound_run(load="constant"), "constant_load", "the load is constant (0.5002 N m)"),
    ],
)
def test_doubts_are_told_and_the_run_still_judged(run: Run, kind: str, words: str) -> None:
    found = vet(run, DRIVE)
    assert not refusals(found), [str(finding) for finding in found]
    assert any(f.kind == kind and f.level == "doubt" and words in str(f) for f in found), [str(f) for f in found]


def test_what_the_run_can_tell() -> None:
    assert "load_follows_speed" in kinds(sound_run(load="brake")) and "load_follows_speed" not in kinds(RUN)
    bare = replace(RUN, load_Nm=None, sensors=Sensors())
    said = "\n".join(str(finding) for finding in vet(bare, DRIVE))
    assert "no load_torque: kinematics only" in said, said
    assert "input_resolution_rad, output_resolution_rad not given" in said and "torque_noise" not in said, said
    short = "\n".join(str(finding) for finding in vet(sound_run(0.03), DRIVE))
    assert "drum order 1 and ratio_error cannot be separated over this travel" in short, short
    long = "\n".join(str(finding) for finding in vet(sound_run(0.45), DRIVE))
    assert "drum order 1 differs from a ratio error by 0.0085" in long, long


def test_a_drive_of_which_only_the_ratio_is_known() -> None:
    one = replace(RUN, input_rad=RUN.input_rad[:1], input_names=("input",), ratio=9.0, load_Nm=None)
    assert not refusals(vet(one, None)), [str(finding) for finding in vet(one, None)]
    found = refusals(vet(replace(one, ratio=1.0 / 9.0), None))
    assert found and found[0].kind in ("swapped", "ratio"), [str(finding) for finding in found]


@pytest.mark.parametrize(("travel_deg", "share"), [(120.0, 0.0025), (300.0, 0.16)])
def test_share_of_order_one_beside_a_ratio(travel_deg: float, share: float) -> None:
    angle = np.radians(np.linspace(-0.5, 0.5, 4001) * travel_deg)
    assert order_left(angle, 1.0) == pytest.approx(share, rel=0.02)


def test_load_levels_are_found_only_where_the_load_rests() -> None:
    rng = np.random.default_rng(2)
    steps = np.repeat([-0.9, -0.3, 0.3, 0.9], 500) + rng.normal(0.0, 0.005, 2000)
    assert load_levels(steps) == pytest.approx([-0.9, -0.3, 0.3, 0.9], abs=0.01)
    assert load_levels(np.sin(np.linspace(0.0, 20.0, 2000))) == []


def test_an_angle_that_only_jumps_between_two_places_is_vetted() -> None:
    jumps = np.where(np.arange(RUN.time_s.size) > 3000, 0.4, 0.0)
    run = replace(RUN, output_rad=jumps, input_rad=np.tile(9.0 * jumps, (2, 1)))
    assert "one_sweep" in kinds(run, "doubt") and order_left(jumps, 1.0) < 1e-12


@pytest.mark.parametrize(
    "name", [name if name in FEW else pytest.param(name, marks=pytest.mark.slow) for name in CASES]
)
def test_a_sound_run_is_judged_whatever_is_wrong_with_the_drive(name: str, tmp_path: Path) -> None:
    """Runs with every effect, and with causes outside the vocabulary, are neither refused nor doubted."""
    write_run(tmp_path, "run", simulate_case(DRIVE, name, 7), DRIVE.input_names)
    found = vet(load_measurement(tmp_path / "run.yaml"), DRIVE)
    assert not [str(finding) for finding in found if finding.level != "fact"]
