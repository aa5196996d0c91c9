"""Figures over tolerances against closed forms, single drives, first-order theory and draws of another generator."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mbcdm_cad as mc
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.model.capability import requirements
from mbcdm_cad.model.sensitivity import intervals
from mbcdm_cad.optimising import spread as spreading
from mbcdm_cad.optimising.evaluate import Facts, facts_of, figure, unit_of
from mbcdm_cad.optimising.spread import DRAWS, SPREAD, Spread, sigmas_of, unit_draws
from mbcdm_cad.optimising.wishes import over_tolerances, wishes_of
from mbcdm_cad.solving.question import read_question

PARAMS = Path(__file__).parents[3] / "params"
# Points of the normal law.
Z95, Z975 = 1.6449, 1.9600


def facts(layout: str) -> Facts:
    question = read_question(PARAMS / f"{layout}.yaml")
    return facts_of(question.resolve(*question.trial({})))


@pytest.fixture(scope="module")
def spur() -> Facts:
    """A drive whose file gives no sigma."""
    return facts("siso_spur")


@pytest.fixture(scope="module")
def bevel() -> Facts:
    """The reference drive with two inputs."""
    return facts("mbcdm")


def alone(facts: Facts, monkeypatch: pytest.MonkeyPatch, **sigmas: Any) -> Spread:
    monkeypatch.setattr(spreading, "sigmas_of", lambda d, drive: dict(sigmas))
    return Spread(facts.drive, lambda: facts.mass_g)


def test_where_only_the_modulus_varies_the_swing_follows_one_over_it(
    spur: Facts, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = alone(spur, monkeypatch, modulus_Pa=0.1 * float(layout_of(spur.drive).si.modulus_Pa))
    nominal = figure(spur, "cable_swing_mrad")
    expected = [nominal / (1.0 + z * 0.1) for z in (Z95, -Z95)]
    assert [found.percentile("cable_swing_mrad", q) for q in (5.0, 95.0)] == pytest.approx(expected, rel=2e-3)
    assert found.percentile("torque_lossless_Nm", 5.0) == pytest.approx(figure(spur, "torque_lossless_Nm"), rel=1e-9)


def test_where_only_the_motor_varies_the_lossless_torque_of_balanced_cables_follows_it(
    spur: Facts, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = alone(spur, monkeypatch, input_rating_Nm=0.05 * requirements(layout_of(spur.drive)).input_rating_Nm)
    nominal = figure(spur, "torque_lossless_Nm")
    assert found.percentile("torque_lossless_Nm", 5.0) == pytest.approx(nominal * (1.0 - 0.05 * Z95), rel=2e-3)
    assert found.percentile("cable_swing_mrad", 95.0) == pytest.approx(figure(spur, "cable_swing_mrad"), rel=1e-9)


def test_the_swing_agrees_with_the_intervals_of_many_plain_draws(bevel: Facts) -> None:
    d = layout_of(bevel.drive).si
    sigmas = sigmas_of(d, bevel.drive)
    plain = intervals(d, requirements(layout_of(bevel.drive)), sigmas)["reversal_swing_rad"]
    found = [bevel.spread.percentile("cable_swing_mrad", q) * 1e-3 for q in (2.5, 97.5)]
    assert found == pytest.approx([plain.low, plain.high], abs=0.25 * plain.sigma)
    assert float(bevel.spread.cable_swing_mrad.std()) * 1e-3 == pytest.approx(plain.sigma, rel=0.1)


def test_each_drive_of_the_batch_has_the_torque_that_it_has_alone(bevel: Facts) -> None:
    found = bevel.spread
    train, motor = found.train, bevel.drive.motor.rated_torque_mNm * 1e-3 * found.motor_factor
    for k in (0, 100, DRAWS - 1):
        one = replace(
            train,
            d=train.d.mapped(lambda v, k=k: v[:, k], lambda v, k=k: v[k]),
            rope=tuple(replace(bend, share=bend.share[:, k]) for bend in train.rope),
            bearings=tuple(replace(pair, factor=pair.factor[k]) for pair in train.bearings),
            gear_share=train.gear_share[k],
            gear_idle_Nm=train.gear_idle_Nm[k],
            motor_idle_Nm=train.motor_idle_Nm[k],
        )
        torque = min(float(one.raised_Nm(one.output_Nm(motor[k]), way).min()) for way in (1, -1))
        assert found.torque_with_losses_Nm[k] == pytest.approx(torque, rel=1e-9), k
        load = bevel.drive.loads.peak_torque_Nm
        assert found.efficiency[k] == pytest.approx(float(one.moving(load, 1).efficiency[0]), rel=1e-9), k


@pytest.mark.parametrize("layout", ["siso_spur", "siso_bevel"])
def test_the_efficiency_spreads_as_first_order_theory_has_it(layout: str) -> None:
    found = facts(layout)
    load = np.array([found.drive.loads.peak_torque_Nm])
    first_order = float(found.layout.losses.moving(load, 1).efficiency_sigma[0])
    low, high = (figure(found, f"efficiency_{q}") for q in ("p5", "p95"))
    assert (high - low) / (2.0 * Z95) == pytest.approx(first_order, rel=0.12)


def test_draws_are_the_same_for_all_designs_and_independent_between_quantities() -> None:
    names = ("modulus_Pa 0", "friction_coefficient 0", "preload_N 0", "preload_N 1", "rope", "gearhead")
    columns = np.stack([unit_draws(name) for name in names])
    assert np.array_equal(columns, np.stack([unit_draws(name) for name in names]))
    assert columns.mean(axis=1) == pytest.approx(0.0, abs=1e-12) and columns.std(axis=1) == pytest.approx(1.0, abs=0.01)
    others = np.abs(np.corrcoef(columns) - np.eye(len(names))).max()
    assert others < 0.2, others


def test_every_spread_figure_has_its_percentiles_around_its_value(spur: Facts) -> None:
    for name in SPREAD:
        low, value, high = (figure(spur, one) for one in (f"{name}_p5", name, f"{name}_p95"))
        assert low < high and low <= value * 1.01 and value <= high * 1.01, (name, low, value, high)
        assert unit_of(f"{name}_p5") == unit_of(name)


def test_over_tolerances_takes_the_worse_side_of_each_aim_and_keep() -> None:
    aims = over_tolerances(["mass_g:min", "swing_mrad:min", "efficiency:max", "drum.width_mm:min"])
    assert aims == ("mass_g:min", "swing_mrad_p95:min", "efficiency_p5:max", "drum.width_mm:min")
    keeps = over_tolerances(["torque_Nm:>=2.1234567", "stiffness_Nm_rad: <= 4000", "torque_Nm"])
    assert keeps == ("torque_Nm_p5:>=2.1234567", "stiffness_Nm_rad_p95: <= 4000", "torque_Nm_p5")
    assert [keep.limit for keep in wishes_of(aims, keeps[:2]).keeps] == [2.1234567, 4000.0]


def test_over_tolerances_is_asked_for_from_python_too(tmp_path: Path) -> None:
    found = mc.optimise(
        mc.new_design("spur", "siso_spur"),
        ["swing_mrad:min"],
        tmp_path,
        keeps=["torque_Nm:>=0.1"],
        over="tolerances",
        effort=mc.Effort(1, workers=1),
    )
    assert [str(wish) for wish in (*found.wishes.aims, *found.wishes.keeps)] == [
        "swing_mrad_p95:min",
        "torque_Nm_p5:>=0.1",
    ]
    assert found[0].figures["swing_mrad_p95"] > found[0].figures["swing_mrad"]
    with pytest.raises(MbcdmError, match="value corners, limit tolerances"):
        mc.optimise([], ["swing_mrad:min"], tmp_path, over="corners")  # type: ignore[arg-type]
