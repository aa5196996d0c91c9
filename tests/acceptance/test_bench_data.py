"""The simulated bench runs: the chain of cable pieces compared with independent figures, and the scorer."""

import json
from dataclasses import replace
from math import radians
from pathlib import Path

import numpy as np
import pytest
import yaml

from mbcdm_cad import cli
from mbcdm_cad.cli import run as mbcdm
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive, spur
from mbcdm_cad.rig.experiment import read_experiment
from mbcdm_cad.rig.quasistatic import simulate
from tests.support.belt_bench import belt_of, run_belt, write_belt_run
from tests.support.bench_cases import CASES
from tests.support.bench_chain import run_chain
from tests.support.bench_data import drum_angle, simulate_case, write_case
from tests.support.bench_effects import Effect
from tests.support.bench_motion import Bench, Plan, chain_of
from tests.support.bench_score import interval, outcome_of, score_of
from tests.support.reference import DRIVE, PARAMS, ROOT
from tests.support.reference import REFERENCE as OWN_DESIGN

CHAIN_60 = replace(chain_of(DRIVE), stiffness=60e9 * 0.3117e-6)
STILL = np.zeros((2, 200))


def swing(amplitude_rad: float, transport: bool) -> float:
    """Half the peak-to-peak turn (rad) that a brake of 0.91 N m gives, after the first sweep."""
    phase = np.linspace(0.0, 8.0 * np.pi, 1600)
    drum = amplitude_rad * 2.0 / np.pi * np.arcsin(np.sin(phase))
    load = 0.91 * np.sign(np.cos(phase))
    ratio = float(np.mean(CHAIN_60.r_drum / CHAIN_60.r_in))
    angle, _ = run_chain(CHAIN_60, np.stack([ratio * drum] * 2), load, np.zeros((4, 1600)), transport=transport)
    return 0.5 * float(np.ptp((angle - drum)[400:]))


def test_the_drum_turns_as_published_under_the_test_torque() -> None:
    angle, tension = run_chain(CHAIN_60, STILL, np.linspace(0.0, 0.91, 200), np.zeros((4, 200)))
    torque = CHAIN_60.sense * CHAIN_60.r_in * tension[:, -1]
    assert -angle[-1] * 1e3 == pytest.approx(0.14595, abs=2e-5)
    assert torque[:2].sum() == pytest.approx(0.0733, abs=1e-4) and torque[2:].sum() == pytest.approx(0.0278, abs=1e-4)


def test_a_brake_swings_the_drum_by_twice_that() -> None:
    assert swing(0.05, False) * 1e6 == pytest.approx(145.9, abs=0.2)


@pytest.mark.parametrize(("amplitude_rad", "urad"), [(0.05, 163.9), (0.6, 396.0)])
def test_cable_transport_swings_it_further(amplitude_rad: float, urad: float) -> None:
    assert swing(amplitude_rad, True) * 1e6 == pytest.approx(urad, rel=0.03)


def test_spans_are_the_internal_tangents_of_the_drawing() -> None:
    assert chain_of(DRIVE).span * 1e3 == pytest.approx([31.18, 30.68, 30.14, 29.55], abs=0.005)


def test_play_at_an_input_moves_the_drum_only_when_the_torque_there_changes_sign() -> None:
    load = np.concatenate([np.linspace(0.0, 0.9, 100), np.linspace(0.9, -0.9, 100)])
    tight, _ = run_chain(CHAIN_60, STILL, load, np.zeros((4, 200)))
    loose, _ = run_chain(CHAIN_60, STILL, load, np.zeros((4, 200)), input_play_rad=np.array([1e-3, 0.0]))
    gone = np.abs(loose - tight)
    # The left input carries +28 mN m of bias and 45 % of the load over a ratio of 9: it lets go near -0.56 N m.
    assert gone[load > -0.3].max() < 1e-9 < 1e-5 < gone[-1]


def test_a_run_and_its_twin_share_motion_and_noise(tmp_path: Path) -> None:
    run, twin = simulate_case(DRIVE, "ratio_encoder", 3), simulate_case(DRIVE, "ratio_encoder", 3, without_effects=True)
    assert np.array_equal(run.sensed["inputs"], twin.sensed["inputs"]) and run.effects and not twin.effects
    share = run.effects[0].size["share"]
    assert np.polyfit(twin.drum_rad, run.drum_rad - twin.drum_rad, 1)[0] == pytest.approx(share, rel=1e-6)
    path = write_case(tmp_path, "ratio_encoder", 3, DRIVE)
    rows = np.loadtxt(path.with_suffix(".csv"), delimiter=",", skiprows=1)
    assert rows.shape == (16_000, 5) and rows[:, 3] == pytest.approx(run.sensed["output"], abs=1e-9)


def test_every_case_has_effects_of_the_kind_its_group_says() -> None:
    for name, case in CASES.items():
        rng = np.random.default_rng(0)
        effects = case.effects(rng, case.plan(rng))
        inside = [effect.in_vocabulary for effect in effects]
        assert len(inside) == {"null": 0, "pair": 2}.get(case.group, 1), name
        assert all(inside) == (case.group not in ("outside", "texture")), name


GUIDE = Effect("once_per_rev", "pulley", {}, stage="guide")
RATIO = Effect("ratio_error", "radii", {})
BUMP = Effect("strand damage", "damaged_strand", {})


@pytest.mark.parametrize(
    ("named", "sets", "verdict", "true", "outcome"),
    [
        ([("once_per_rev", "guide")], [], "explained", (GUIDE,), "exact"),
        ([("once_per_rev", "drum")], [], "explained", (GUIDE,), "wrong"),
        ([("once_per_rev", "guide"), ("delay", None)], [], "explained", (GUIDE,), "wrong"),
        ([], [[("once_per_rev", "guide"), ("ripple", None)]], "explained", (GUIDE,), "set"),
        ([], [[("creep", None), ("ripple", None)]], "explained", (GUIDE,), "wrong set"),
        ([("once_per_rev", "guide")], [], "partly_explained", (GUIDE, RATIO), "partial"),
        ([("ratio_error", None)], [[("once_per_rev", "guide")]], "explained", (GUIDE, RATIO), "set"),
        ([], [], "unknown", (BUMP,), "unknown"),
        ([("ripple", None)], [], "explained", (BUMP,), "wrong"),
        ([], [], "none", (), "none"),
        ([("delay", None)], [], "explained", (), "wrong"),
    ],
)
def test_scoring(named: list, sets: list, verdict: str, true: tuple[Effect, ...], outcome: str) -> None:
    def entry(name: str, stage: str | None) -> dict[str, object]:
        return {"name": name, **({"stage": stage} if stage else {})}

    result = {
        "verdict": verdict,
        "effects": [entry(*one) for one in named],
        "one_of": [[entry(*one) for one in group] for group in sets],
    }
    truth = [effect.as_truth() for effect in true]
    assert outcome_of(result, truth) == outcome
    unknown = result | {"unknown": {} if verdict == "unknown" else None}
    right = {"exact": "right", "set": "set", "none": "right", "unknown": "right", "partial": "missed"}
    assert score_of(unknown, truth, []) == right.get(outcome, "false")
    # What is too small may be named or not; a wrong name stays one.
    small = {"partial": "right", "exact": "right", "set": "set", "none": "right", "unknown": "missed"}
    assert score_of(unknown, truth, truth) == small.get(outcome, "false")


def test_intervals_are_those_of_clopper_and_pearson() -> None:
    # The rule of three: none wrong of 300 leaves 1.2 % at most.
    assert interval(300, 300)[0] == pytest.approx(0.025 ** (1 / 300), rel=1e-9)
    assert interval(0, 300)[1] == pytest.approx(1.0 - 0.025 ** (1 / 300), rel=1e-9) and interval(0, 300)[0] == 0.0


CREEP_DESIGN = PARAMS / "siso_spur.yaml"
PLAN = Plan(amplitude_rad=0.6, frequency_hz=0.05, wave="sine", load="steps", duration_s=160.0)
WRAP_DEG = 540.0


@pytest.fixture(scope="module")
def drive() -> SpurDrive:
    """The reference of siso_spur."""
    return spur(load_design(CREEP_DESIGN).drive)


@pytest.mark.slow
def test_rig_creeps_as_marks_on_a_rope_do(drive: SpurDrive) -> None:
    experiment = read_experiment(PARAMS / "experiments" / "siso_spur" / "input-creep.yaml")
    run = simulate(drive, experiment)
    plain = simulate(drive, experiment.model_copy(update={"effects": ()}))
    drum, _ = run_belt(belt_of(drive, radians(WRAP_DEG)), run.input_rad[0], run.load_Nm)
    crept = np.ptp(run.drum_rad - plain.drum_rad)
    missed = np.abs(run.drum_rad - drum).max()
    assert crept > 2e-4
    assert missed < 0.06 * crept, f"rig and rope differ by {missed * 1e6:.1f} of {crept * 1e6:.1f} urad"


@pytest.mark.slow
def test_loop_finds_the_wrap_that_is_there_and_no_creep_where_it_is_enough(drive: SpurDrive, tmp_path: Path) -> None:
    named = {}
    for wrap_deg in (WRAP_DEG, 1400.0):
        file = write_belt_run(tmp_path / f"{wrap_deg:g}", drive, radians(wrap_deg), PLAN, 3)
        assert cli.run(["loop", str(CREEP_DESIGN), str(file), "--json", str(tmp_path / "found.json")]) == 0
        result = json.loads((tmp_path / "found.json").read_text())
        named[wrap_deg] = {e["name"]: e for e in result["effects"]}
    assert set(named[WRAP_DEG]) == {"winding_history", "input_creep"}, named[WRAP_DEG].keys()
    found = named[WRAP_DEG]["input_creep"]["parameters"]["wrap_deg"]
    assert found["value"] == pytest.approx(WRAP_DEG, rel=0.03), found
    assert set(named[1400.0]) == {"winding_history"}, named[1400.0].keys()


OWN_DRIVE = load_design(OWN_DESIGN).drive
COUNTS, DRUM_STEP_DEG, ARM_M, TARE_N = 4096, 7.8e-5, 0.080, 1.9
RUNOUT = Effect("once_per_rev", "output_encoder", {"amplitude_rad": 80e-6, "phase_rad": 0.7}, stage="drum")
LASH = Effect("lash", "input_play", {"play_rad": float(np.radians(0.3))}, stage="input_left")


def write_csv(path: Path, effects: tuple[Effect, ...], pendulum_Nm: float, brake_Nm: float) -> None:
    """160 s at 200 Hz under a pendulum and a brake; the two servos follow unlike and give way under load."""
    rng, chain = np.random.default_rng(1), chain_of(OWN_DRIVE)
    ratio = float(np.mean(chain.r_drum / chain.r_in))
    t = np.arange(0.0, 160.0, 0.005)
    target = 0.55 * np.sin(2.0 * np.pi * 0.05 * t)
    speed = np.gradient(target, t)
    load = pendulum_Nm * np.sin(target + 0.3) + brake_Nm * np.tanh(speed / 0.01)
    load -= load[0] * np.exp(-t / 0.3)
    servos = zip((12e-6, 22e-6), (0.7, 1.3), strict=True)
    inputs = np.array([ratio * (target - k * load + 8e-6 * np.sin(2.0 * np.pi * f * t + f)) for k, f in servos])
    bench = Bench(t, inputs, load, speed, np.full(t.size, 21.0))
    drum = drum_angle(chain, OWN_DRIVE.input_names, bench, effects, rng)
    turns = (inputs + rng.normal(0.0, 3e-5, inputs.shape)) * OWN_DRIVE.gearhead.ratio / (2.0 * np.pi)
    counts = np.round(turns * COUNTS) + np.array([[151234.0], [-88321.0]])
    degrees = np.round(np.degrees(drum + rng.normal(0.0, 4e-6, t.size) + 0.0123) / DRUM_STEP_DEG) * DRUM_STEP_DEG
    cell_N = load / ARM_M + TARE_N + rng.normal(0.0, 0.06, t.size)
    stamp = 1000.0 + t + rng.uniform(-2e-4, 2e-4, t.size)
    table = np.column_stack([stamp, *counts, degrees, cell_N, np.arange(t.size) % 7])
    header = "t_s,enc_left,enc_right,drum_deg,cell_N,state"
    forms = ["%.5f", "%d", "%d", "%.6f", "%.3f", "%d"]
    np.savetxt(path, table, fmt=forms, delimiter=",", header=header, comments="")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("effects", "loads_Nm", "name"),
    [((), (0.45, 0.35), None), ((RUNOUT,), (0.45, 0.35), "once_per_rev"), ((LASH,), (1.5, 0.5), "lash")],
    ids=["no effect", "80 urad of runout", "0.3 degrees of play"],
)
def test_from_the_csv_to_the_finding(
    effects: tuple[Effect, ...], loads_Nm: tuple[float, float], name: str | None, tmp_path: Path
) -> None:
    write_csv(tmp_path / "run.csv", effects, *loads_Nm)
    assert mbcdm(["measurement-init", str(tmp_path / "run.csv"), str(OWN_DESIGN)]) == 0
    draft = (tmp_path / "run.yaml").read_text()
    assert draft.count("side: motor") == 2 and draft.count("unit: deg") == 1 and "?" in draft, draft
    (tmp_path / "run.yaml").write_text(draft.replace("lever_arm_mm: '?'", f"lever_arm_mm: {1e3 * ARM_M}"))
    assert mbcdm(["loop", str(OWN_DESIGN), str(tmp_path / "run.yaml"), "--json", str(tmp_path / "found.json")]) == 0
    found = json.loads((tmp_path / "found.json").read_text())
    assert [one["name"] for one in found["effects"]] == ([name] if name else []), found["sentence"]
    assert not found["one_of"], found["sentence"]
    left, floor = (found["error"][key] for key in ("after_rad", "floor_rad"))
    assert left < 1.05 * floor, f"{1e6 * left:.2f} urad left, floor {1e6 * floor:.2f} urad"
    if name == "once_per_rev":
        size = found["effects"][0]["parameters"]["amplitude_rad"]
        assert size["ci95"][0] < 80e-6 < size["ci95"][1], size
        assert found["effects"][0]["stage"] == "drum", found["sentence"]
    if name == "lash":
        assert found["effects"][0]["stage"] == "input_left", found["sentence"]
        # The pulley does not reach the far face: a lower bound.
        assert found["effects"][0]["parameters"]["play_rad"]["value"] < np.radians(0.3), found["sentence"]


DESIGN = str(ROOT / "params" / "mbcdm.yaml")


def command(capsys: pytest.CaptureFixture[str], *words: str | Path) -> str:
    code = mbcdm([str(word) for word in words])
    shown = capsys.readouterr()
    assert code == 0, shown.err
    return shown.out


def names(result: Path) -> tuple[list[str], list[set[str]]]:
    content = yaml.safe_load(result.read_text())

    def label(one: dict[str, str]) -> str:
        return " ".join(filter(None, [one["name"], one.get("stage")]))

    return [label(one) for one in content["effects"]], [{label(one) for one in group} for group in content["one_of"]]


@pytest.mark.slow
def test_the_proposed_run_settles_the_set(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    truth = ROOT / "params" / "experiments" / "eccentric-guide-short.yaml"
    command(capsys, "simulate", DESIGN, truth, "--out", tmp_path / "short")
    run = next((tmp_path / "short").rglob("eccentric-guide-short.yaml"))
    said = command(capsys, "loop", DESIGN, run, "--json", tmp_path / "first.json", "--next", tmp_path / "next.yaml")
    named, sets = names(tmp_path / "first.json")
    assert not named and sets and "once_per_rev guide" in sets[0], said
    assert "expected odds" in said and str(tmp_path / "next.yaml") in said, said
    experiment = yaml.safe_load((tmp_path / "next.yaml").read_text())
    experiment["effects"] = yaml.safe_load(truth.read_text())["effects"]
    (tmp_path / "made.yaml").write_text(yaml.safe_dump(experiment))
    command(capsys, "simulate", DESIGN, tmp_path / "made.yaml", "--out", tmp_path / "made")
    made = next((tmp_path / "made").rglob("next-run.yaml"))
    said = command(
        capsys, "loop", DESIGN, run, made, "--json", tmp_path / "second.json", "--next", tmp_path / "none.yaml"
    )
    assert names(tmp_path / "second.json") == (["once_per_rev guide"], []), said
    assert "no set of possible effects is left" in said and not (tmp_path / "none.yaml").exists(), said
