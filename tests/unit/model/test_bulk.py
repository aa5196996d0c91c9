"""Figures of many designs at once equal those of single designs. Their speed: benchmarks/model.py."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from paper_case import paper_drive, turned_round

from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.model.analysis import analyse
from mbcdm_cad.model.bulk import analyse_many, preload_table, stack_designs
from mbcdm_cad.model.capability import SLACK_SHARE, Requirements, torque_at_slack_Nm, torque_limits
from mbcdm_cad.model.equations import eq1_residuals
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.model.stiffness import cable_backlash, drum_backlash

NEED = Requirements(
    load_Nm=0.91,
    half_travel_rad=np.radians(35.0),
    input_rating_Nm=0.2204,
    rope_diameter_m=0.81e-3,
    tension_limit_N=106.0,
    helix_lead_m=0.87e-3,
)


def designs(n: int, seed: int = 0, unequal: float = 0.03) -> DriveSI:
    """Random drives about the paper's, Eq. (1) missed by up to ``unequal``."""
    rng = np.random.default_rng(seed)
    radii = np.array([6.0, 6.4, 6.8, 7.2])[:, None] * 1e-3 * rng.uniform(0.8, 1.5, n)
    return paper_drive(
        input_radius_m=radii * rng.uniform(1 - unequal, 1 + unequal, (4, n)),
        guide_radius_m=1.5 * radii,
        drum_radius_m=rng.uniform(6, 12, n) * radii,
        preload_N=rng.uniform(40, 120, (4, n)),
        centre_distance_m=rng.uniform(18e-3, 48e-3, n),
        friction_coefficient=rng.uniform(0.05, 0.4, n),
        modulus_Pa=rng.uniform(30e9, 90e9, n),
    )


def single(batch: DriveSI, k: int) -> DriveSI:
    columns = ("input_radius_m", "guide_radius_m", "drum_radius_m", "preload_N")
    scalars = ("centre_distance_m", "friction_coefficient", "modulus_Pa")
    return paper_drive(**{c: batch.value(c)[:, k] for c in columns}, **{c: batch.value(c)[k] for c in scalars})


@pytest.mark.slow
def test_equal_to_one_by_one() -> None:
    n = 300
    batch = designs(n)
    bulk = analyse_many(batch, NEED)
    assert 0.5 * n < bulk.valid.sum() < n, f"{bulk.valid.sum()} of {n} valid: the sample shows only one kind"
    for k in np.flatnonzero(bulk.valid):
        d = single(batch, k)
        limits = torque_limits(d, {"motor": 0.2204}, 106.0)
        idle = float(solve_equilibrium(d, 0.0).drum_angle_rad)
        expected = {
            "turn_rad": solve_equilibrium(d, np.array([0.91, -0.91])).drum_angle_rad - idle,
            "reversal_swing_rad": float(drum_backlash(d, 0.91).reversal_swing_rad),
            "cable_backlash_rad": cable_backlash(d, 0.91).backlash_rad,
            "peak_torque_Nm": [min(x.torque_Nm for x in limits if x.direction == way) for way in (1, -1)],
            "free_span_m": d.free_span_m,
        }
        for name, value in expected.items():
            got = getattr(bulk, name)[..., k]
            worst = float(np.max(np.abs(np.asarray(got) / np.maximum(np.abs(value), 1e-30) - np.sign(value))))
            assert worst < 1e-9, f"design {k}, {name}: {got} in bulk, {value} alone ({worst:.3g})"
        assert bulk.eq1_residual[k] == pytest.approx(eq1_residuals(d).worst, rel=1e-12)


def test_designs_without_a_free_span_are_marked_not_fatal() -> None:
    batch = designs(50)
    short = batch.value("centre_distance_m").copy()
    short[::2] = 10e-3
    bulk = analyse_many(batch.with_(centre_distance_m=short), NEED)
    assert not bulk.valid[::2].any()
    assert np.isnan(bulk.turn_rad[:, ::2]).all() and np.isnan(bulk.bend_ratio[::2]).all()
    good = bulk.valid
    assert np.isfinite(bulk.peak_torque_Nm[:, good]).all()
    nothing = analyse_many(batch.with_(centre_distance_m=np.full(50, 5e-3)), NEED)
    assert not nothing.valid.any()


def test_reference_design_in_a_batch_of_one() -> None:
    bulk = analyse_many(stack_designs([paper_drive()]), NEED)
    assert bulk.peak_torque_Nm[:, 0] == pytest.approx([3.747, 3.194], abs=1e-3)
    assert np.degrees(bulk.passed_wrap_rad[:, 0]) == pytest.approx([25.7, 207.5, 29.4, 211.3], abs=0.06)
    assert np.degrees(bulk.input_wrap_needed_rad[:, 0]) == pytest.approx([630.0] * 4)
    assert np.degrees(bulk.fleet_angle_rad[:, 0]) == pytest.approx([1.399, 1.421, 1.447, 1.476], abs=1e-3)
    assert bulk.bend_ratio[0] == pytest.approx(14.8, abs=0.02)


def test_designs_of_different_kinds_are_not_stacked() -> None:
    d = paper_drive()
    with pytest.raises(ModelError, match="stack them by kind"):
        stack_designs([d, turned_round(d)])
    with pytest.raises(ModelError, match="at least one"):
        stack_designs([])
    with pytest.raises(ModelError, match="one axis of designs"):
        analyse_many(d, NEED)


# The table of the effect of a lower preload, compared with figures of the model.


DRIVE = load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive


def test_the_row_of_the_design_is_its_analysis() -> None:
    (row,) = preload_table(layout_of(DRIVE), (1.0,))
    analysis = analyse(layout_of(DRIVE))
    assert row.preload_N == pytest.approx([c.preload_N for c in DRIVE.cables])
    assert row.at_inputs_Nm == pytest.approx(analysis.peak_torque_Nm)
    assert row.reversal_swing_mrad == pytest.approx(analysis.reversal_swing_mrad)


def test_less_preload_costs_lost_motion_and_gives_torque_at_the_inputs() -> None:
    """Sticking length grows as 1/T (Eq. 14), the bias on the inputs falls with T."""
    full, half = preload_table(layout_of(DRIVE), (1.0, 0.6))
    assert half.turn_mrad > full.turn_mrad and half.reversal_swing_mrad > full.reversal_swing_mrad
    assert min(half.at_inputs_Nm) > min(full.at_inputs_Nm)
    assert half.slack_Nm[0] == pytest.approx(0.6 * full.slack_Nm[0], rel=1e-3), "all in proportion"


@pytest.mark.parametrize("ends", [(), layout_of(DRIVE).wraps_at_ends_rad])
def test_the_first_slack_is_where_a_cable_has_a_hundredth_left(ends: tuple[Mapping[str, Any], ...]) -> None:
    """With endless wraps, and with those that are there at both ends of the travel."""
    si = layout_of(DRIVE).si
    for direction in (1, -1):
        torque = float(torque_at_slack_Nm(si, direction, ends).min())
        poses = [si.with_(**wraps) for wraps in ends] or [si]
        left = [solve_equilibrium(pose, direction * torque).tension_N / si.preload_N for pose in poses]
        assert float(np.min(left)) == pytest.approx(SLACK_SHARE, abs=1e-4)
