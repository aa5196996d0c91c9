"""The finding in plain words: every effect has a clause, figures are rounded to their intervals, no identifiers."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.effects import library
from mbcdm_cad.loop.page.plain import certainty, described, finding, rounded, steps
from mbcdm_cad.loop.prepare.prepared import prepare
from mbcdm_cad.loop.readable import Value
from mbcdm_cad.loop.result import Errors, LoopResult, Named
from mbcdm_cad.loop.search.unknown import Unknown
from mbcdm_cad.measurement.run import Run

D = layout_of(load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive).si


def effects() -> list[Effect]:
    """Every effect: of a drive that is known, with temperature and without, and of a ratio alone."""
    t = np.arange(0.0, 80.0, 0.05)
    angle = 0.4 * np.sin(t)
    full = Run(t, np.stack([9.0 * angle, 9.0 * angle]), angle, np.cos(t), 20.0 + t / 80.0)
    ready, cold = prepare(full, 9.0)[0], prepare(replace(full, temperature_C=None), 9.0)[0]
    offered = [*library(D, ready), *library(D, cold), *library(None, ready)]
    return list({effect.label: effect for effect in offered}.values())


EFFECTS = {effect.label: effect for effect in effects()}


def named(label: str, share: float | None = None) -> Named:
    effect = EFFECTS[label]
    figures = {figure.name: Value(0.25, 0.24, 0.26) for figure in effect.reported()}
    if share is not None:
        figures["share"] = Value(share, 1.05 * share, 0.95 * share)
    where = effect.where_to_look, effect.separate_by, effect.physics
    key = effect.name, effect.form, effect.stage, effect.cables
    return Named(*key, figures, {}, (), *where, 0.0, {}, {}, effect.plain)


@pytest.mark.parametrize("label", EFFECTS)
def test_every_effect_has_a_clause_without_identifiers(label: str) -> None:
    words = described(named(label))
    print(words)
    assert EFFECTS[label].plain and words != EFFECTS[label].plain, words
    assert not set("_{}") & set(words) and "  " not in words, words


@pytest.mark.parametrize(
    ("name", "value", "shown"),
    [
        ("share", Value(-0.39963, -0.40134, -0.39785), "40.0 %"),
        ("play_rad", Value(1.2344e-3, 1.1e-3, 1.4e-3), "1.2 mrad"),
        ("play_rad", Value(3.014e-3, 3.014e-3, float("inf")), "at least 3 mrad"),
        ("eccentricity_m", Value(9.948e-6, 9.878e-6, 10.02e-6), "9.95 um"),
        ("torque_Nm", Value(0.1203, 0.1203, 0.1203), "120 mN m"),
    ],
)
def test_figures_are_rounded_to_their_intervals(name: str, value: Value, shown: str) -> None:
    assert rounded(name, value) == shown


def result(verdict: str, effects: tuple[Named, ...] = (), sets: tuple[tuple[Named, ...], ...] = ()) -> LoopResult:
    errors = Errors(Value(2e-4, 1e-4, 3e-4), Value(5e-6, 4e-6, 6e-6), 3e-4, 1e-5, 5e-6, 1.0, "half sweeps 2, 3")
    return LoopResult(verdict, effects, sets, None, errors, (), (), (), (), {})


def test_the_finding_says_what_how_sure_and_what_to_do() -> None:
    one, other = named("preload_error cable_4 (one cable)", -0.4), named("cable_friction (rope on pulley)", -0.4)
    nothing, single, either = result("none"), result("explained", (one,)), result("explained", (), ((one, other),))
    assert finding(nothing).startswith("Nothing is missing") and certainty(nothing) == "" and steps(nothing) == []
    assert finding(single) == "The tension of cable 4 is 40 % lower than the design file says."
    assert "38 to 42 %" in certainty(single) and "plucking" in steps(single)[0], (certainty(single), steps(single))
    assert finding(either).startswith("Either the tension of cable 4") and " or the friction" in finding(either)
    assert "cannot show" in certainty(either) and "re-tension" in steps(either)[0], (certainty(either), steps(either))
    left = Unknown(8e-6, 2e-5, 5e-6, (), (), 0.1, (), (7e-6, 9e-6))
    assert finding(replace(result("unknown"), unknown=left)) == "Something unknown is left, 8 urad RMS."
    partly = replace(single, unknown=left, verdict="partly_explained")
    assert finding(partly).endswith("the design file says; something unknown is left, 8 urad RMS.")


def test_a_size_without_bounds_is_not_told_as_at_least_nothing() -> None:
    open_ = Value(1e-4, 0.0, np.inf)
    assert rounded("compliance_rad_Nm", open_) == "a size that these runs leave open"
