"""The design file as built: written beside what stands there, read again, and put into the declared model."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.design import load_design
from mbcdm_cad.design.loader import load_text
from mbcdm_cad.loop.as_built import as_built_text, known_effects
from mbcdm_cad.loop.prepared import Prepared, prepare
from mbcdm_cad.loop.result import Errors, LoopResult, Named, Value
from mbcdm_cad.loop.run import Run
from mbcdm_cad.loop.setup import Simulator, declared
from mbcdm_cad.model.errors import ModelError
from mbcdm_cad.model.si import to_si

REFERENCE = Path(__file__).parents[3] / "params" / "mbcdm.yaml"


def named(name: str, form: str, stage: str | None = None, cables: tuple[str, ...] = (), **fitted: float) -> Named:
    figures = (
        {"share": Value(fitted["share"], fitted["share"] - 0.01, fitted["share"] + 0.01)} if "share" in fitted else {}
    )
    return Named(name, form, stage, cables, figures, {}, (), "", "", "", 1e-5, fitted)


MODULUS = named("stiffness_error", "modulus of the rope", share=0.1)
GUIDE = named("once_per_rev", "eccentric pulley", "guide", cosine_m=1e-05, sine_m=-2e-06)
LEFT = named("once_per_rev", "eccentric encoder", "input_left", cosine_rad=1e-4, sine_rad=0.0)
RIGHT = named("once_per_rev", "eccentric encoder", "input_right", cosine_rad=1e-4, sine_rad=0.0)


def result(effects: tuple[Named, ...], one_of: tuple[tuple[Named, ...], ...] = ()) -> LoopResult:
    errors = Errors(Value(1e-5, 1e-5, 1e-5), Value(4e-6, 4e-6, 4e-6), 0.0, 0.0, 4e-6, 1.0, "half sweep 3")
    return LoopResult("explained", effects, one_of, None, errors, (), (), (), (), {})


def run() -> Prepared:
    t = np.arange(0.0, 40.0, 0.02)
    angle = 0.45 * np.sin(2.0 * np.pi * t / 8.0)
    load = 0.5 * np.cos(2.0 * np.pi * t / 11.0)
    return prepare(Run(t, np.stack([9.0 * angle, 9.0 * angle]), angle, load), 9.0)


def test_written_and_read_again() -> None:
    loaded = load_design(REFERENCE)
    text = as_built_text(loaded, result((MODULUS, GUIDE)), source="run.csv")
    again = load_text(text, REFERENCE)
    assert again.drive.cable.modulus_GPa == pytest.approx(1.1 * loaded.drive.cable.modulus_GPa)
    (entry,) = again.drive.as_built
    assert (entry.name, entry.stage, entry.source) == ("once_per_rev", "guide", "run.csv")
    assert {v.name: v.value for v in entry.values} == {"cosine_m": 1e-05, "sine_m": -2e-06}


def test_all_else_stays_as_written_and_a_second_time_adds() -> None:
    loaded = load_design(REFERENCE)
    once = as_built_text(loaded, result((MODULUS,)))
    kept = [line for line in loaded.text.split("\n") if not line.startswith("as_built")]
    assert [line for line in once.split("\n") if line in kept] == kept
    twice = as_built_text(load_text(once, REFERENCE), result((MODULUS, GUIDE)))
    drive = load_text(twice, REFERENCE).drive
    assert drive.cable.modulus_GPa == pytest.approx(1.1**2 * loaded.drive.cable.modulus_GPa)
    assert len(drive.as_built) == 1
    assert twice.count("as_built:") == 1


def test_a_file_without_the_list_gets_one() -> None:
    text = "\n".join(line for line in REFERENCE.read_text("utf-8").split("\n") if not line.startswith("as_built"))
    drive = load_text(as_built_text(load_text(text, REFERENCE), result((GUIDE,))), REFERENCE).drive
    assert len(drive.as_built) == 1


def test_sets_are_comments() -> None:
    loaded = load_design(REFERENCE)
    text = as_built_text(loaded, result((GUIDE,), ((LEFT, RIGHT),)))
    assert "  #  - name: once_per_rev" in text or "  # - name: once_per_rev" in text, text[-900:]
    again = load_text(text, REFERENCE)
    assert [e.stage for e in again.drive.as_built] == ["guide"]
    third = load_text(as_built_text(again, result(())), REFERENCE)
    assert [e.stage for e in third.drive.as_built] == ["guide"]


def test_known_effects_change_the_prediction_as_the_effect_does() -> None:
    drive = load_text(as_built_text(load_design(REFERENCE), result((GUIDE,))), REFERENCE).drive
    d, p = to_si(drive), run()
    ((effect, values),) = known_effects(d, p, drive.as_built)
    simulate = Simulator()
    base = declared(d, 9.0, p)
    change = simulate(effect.apply(base, values, simulate)) - simulate(base)
    print(f"guide 10 um off centre: {1e6 * np.ptp(change):.1f} urad from end to end")
    assert 100e-6 < np.ptp(change) < 1000e-6


def test_a_form_or_figure_that_the_loop_lacks_is_said() -> None:
    wrong = named("once_per_rev", "oval pulley", "guide", cosine_m=1e-5, sine_m=0.0)
    lacking = named("once_per_rev", "eccentric pulley", "guide", cosine_m=1e-5)
    for entry, words in ((wrong, "eccentric pulley, stage guide"), (lacking, "lacks sine_m")):
        drive = load_text(as_built_text(load_design(REFERENCE), result((entry,))), REFERENCE).drive
        with pytest.raises(ModelError, match=words):
            known_effects(to_si(drive), run(), drive.as_built)
