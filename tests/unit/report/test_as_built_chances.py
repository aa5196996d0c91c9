"""Probabilities of the checks on a drive as built, against draws of the values; and the correlations in the file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mbcdm_cad as mc
from mbcdm_cad.design.as_built import with_as_built
from mbcdm_cad.design.blocks import AsBuilt, AsBuiltCorrelation, AsBuiltValue
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.loop.as_built import as_built_text
from mbcdm_cad.loop.search.engine import close_loop
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.report.check_report import chance_lines, chances_of

DESIGN = Path(__file__).parents[3] / "params" / "mbcdm.yaml"
MIDDLE, DEVIATION, CORRELATION = np.array([-0.3, -0.2]), np.array([0.03, 0.025]), -0.8


def entries(correlation: float = CORRELATION) -> tuple[AsBuilt, ...]:
    forms = (("preload_error", "all cables"), ("stiffness_error", "modulus of the rope"))
    found = []
    for (name, form), middle, deviation in zip(forms, MIDDLE, DEVIATION, strict=True):
        low, high = middle - 1.96 * deviation, middle + 1.96 * deviation
        value = AsBuiltValue(name="share", value=float(middle), low=float(low), high=float(high))
        found.append(AsBuilt(name=name, form=form, values=(value,)))
    goes_with = AsBuiltCorrelation(own="share", entry=0, other="share", correlation=correlation)
    return found[0], replace(found[1], correlated=(goes_with,))


def test_the_probabilities_are_those_of_draws() -> None:
    base, found = load_design(DESIGN).drive, entries()
    chances = {one.check: one.probability for one in chances_of(with_as_built(base, found), found)}
    spread = np.outer(DEVIATION, DEVIATION) * np.array([[1.0, CORRELATION], [CORRELATION, 1.0]])
    draws = np.random.default_rng(3).multivariate_normal(MIDDLE, spread, 120)
    unsure = [name for name, chance in chances.items() if 0.05 < chance < 0.95]
    assert unsure, chances
    checks = [check for check in checks_of(base) if check.id in unsure]
    passed = dict.fromkeys(unsure, 0)
    for draw in draws:
        moved = [
            replace(entry, values=(AsBuiltValue(name="share", value=float(share)),), correlated=())
            for entry, share in zip(found, draw, strict=True)
        ]
        layout = with_as_built(base, tuple(moved)).layout
        for check in checks:
            passed[check.id] += check.measure(layout).holds
    for name in unsure:
        # Three standard deviations of a share of 120 draws.
        assert passed[name] / 120 == pytest.approx(chances[name], abs=0.14), (name, passed[name], chances[name])


def test_a_design_that_was_not_measured_has_no_probabilities() -> None:
    drive = load_design(DESIGN).drive
    assert chances_of(drive, ()) == () and list(chance_lines(())) == []


def test_check_and_analyse_of_a_file_as_built_tell_them(tmp_path: Path) -> None:
    path = tmp_path / "built.yaml"
    text = DESIGN.read_text().replace(
        "as_built: []",
        "as_built:\n  - name: preload_error\n    form: all cables\n"
        "    values: [{name: share, value: -0.3, low: -0.36, high: -0.24}]",
    )
    path.write_text(text)
    design = mc.load(path)
    report = design.check()
    assert "as built, within what the loop knows" in report.text() and len(report.to_dict()["as_built"]) > 50
    assert "as built, within what the loop knows" in design.analyse().text()


def test_the_loop_writes_the_correlations_of_what_it_found() -> None:
    t = np.arange(0.0, 100.0, 0.02)
    angle = 0.6 * np.sin(2.0 * np.pi * t / 9.0)
    speed = np.gradient(angle, t)
    noise = 3e-5 * np.random.default_rng(0).normal(size=t.size)
    read = angle * 1.002 - 0.003 * speed + noise
    run = Run(t, 8.0 * angle[None], read, sensors=Sensors(2e-5, 2e-5), input_names=("input",), ratio=8.0)
    result = close_loop(None, [run])
    assert {one.name for one in result.effects} == {"ratio_error", "delay"}, result.sentence
    one, two = result.effects
    table, other = one.correlated[two.words], two.correlated[one.words]
    assert one.correlated[one.words] == pytest.approx(1.0) and two.correlated[two.words] == pytest.approx(1.0)
    assert table.shape == (1, 1) and table == pytest.approx(other.T) and abs(table[0, 0]) <= 1.0
    # What is too small to be named may stand in the figures: 0.03 of the floor along each.
    share = next(named for named in result.effects if named.name == "ratio_error").parameters["share"]
    least = 1.96 * 0.03 * result.errors.floor_rad / float(np.std(angle))
    assert least < 0.5 * (share.high - share.low) < 3.0 * least
    text = as_built_text(load_design(DESIGN), result)
    assert ("correlated:" in text) == (abs(table[0, 0]) >= 0.01), (table, text)
