"""The simulated bench runs: the chain of cable pieces compared with independent figures, and the scorer."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import load_design
from tests.support.bench_cases import CASES
from tests.support.bench_chain import run_chain
from tests.support.bench_data import simulate_case, write_case
from tests.support.bench_effects import Effect
from tests.support.bench_geometry import chain_of
from tests.support.bench_score import interval, outcome_of, score_of

ROOT = Path(__file__).resolve().parents[2]
DRIVE = load_design(ROOT / "params" / "mbcdm.yaml").drive
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
