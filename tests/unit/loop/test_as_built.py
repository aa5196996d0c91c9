"""The design file as built: written beside what stands there, read again, and put into the declared model."""

from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import layout_of, load_design, load_text
from mbcdm_cad.loop.as_built import applied_words, as_built_text
from mbcdm_cad.loop.effects import known_effects
from mbcdm_cad.loop.prepare.prepared import Prepared, prepare
from mbcdm_cad.loop.prepare.setup import Simulator, declared
from mbcdm_cad.loop.readable import Value
from mbcdm_cad.loop.result import Errors, LoopResult, Named
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.model.si import ModelError

REFERENCE = Path(__file__).parents[3] / "params" / "mbcdm.yaml"
WITHOUT = "\n".join(line for line in REFERENCE.read_text("utf-8").split("\n") if not line.startswith("as_built"))


def named(name: str, form: str, stage: str | None = None, cables: tuple[str, ...] = (), **fitted: float) -> Named:
    figures = (
        {"share": Value(fitted["share"], fitted["share"] - 0.01, fitted["share"] + 0.01)} if "share" in fitted else {}
    )
    return Named(name, form, stage, cables, figures, {}, (), "", "", "", 1e-5, fitted)


MODULUS = named("stiffness_error", "modulus of the rope", share=0.1)
GUIDE = named("once_per_rev", "eccentric pulley", "guide", cosine_m=1e-05, sine_m=-2e-06)
LEFT = named("once_per_rev", "eccentric encoder", "input_left", cosine_rad=1e-4, sine_rad=0.0)
RIGHT = named("once_per_rev", "eccentric encoder", "input_right", cosine_rad=1e-4, sine_rad=0.0)
SERIES = named("stiffness_error", "compliance in series", compliance_rad_Nm=1e-5)


def result(effects: tuple[Named, ...], one_of: tuple[tuple[Named, ...], ...] = ()) -> LoopResult:
    errors = Errors(Value(1e-5, 1e-5, 1e-5), Value(4e-6, 4e-6, 4e-6), 0.0, 0.0, 4e-6, 1.0, "half sweep 3")
    return LoopResult("explained", effects, one_of, None, errors, (), (), (), (), {})


def run() -> Prepared:
    t = np.arange(0.0, 40.0, 0.02)
    angle = 0.45 * np.sin(2.0 * np.pi * t / 8.0)
    load = 0.5 * np.cos(2.0 * np.pi * t / 11.0)
    return prepare(Run(t, np.stack([9.0 * angle, 9.0 * angle]), angle, load), 9.0)[1]


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
    drive = load_text(as_built_text(load_text(WITHOUT, REFERENCE), result((GUIDE,))), REFERENCE).drive
    assert len(drive.as_built) == 1


SETS = ((LEFT, RIGHT), (MODULUS, SERIES))


def uncommented(text: str, chosen: Named) -> str:
    """The text with the marks taken off one member, as an editor does it: mark and one blank, on each of its lines."""
    lines = text.split("\n")
    first = next(k for k, line in enumerate(lines) if line.startswith("  ## ") and f". {chosen.words} (" in line) + 1
    last = first
    while lines[last].startswith("  # "):
        lines[last] = lines[last].replace("# ", "", 1)
        last += 1
    assert last > first, text
    return "\n".join(lines)


@pytest.mark.parametrize("effects", [(), (GUIDE,)], ids=["nothing else", "beside a named one"])
@pytest.mark.parametrize("before", [REFERENCE.read_text("utf-8"), WITHOUT], ids=["empty list", "no list"])
def test_a_set_is_undecided_until_one_member_is_uncommented(before: str, effects: tuple[Named, ...]) -> None:
    text = as_built_text(load_text(before, REFERENCE), result(effects, (SETS[0],)), source="run.csv")
    assert "UNDECIDED, the runs cannot tell which one of these 2 it is. None is in force." in text, text[-1500:]
    undecided = load_text(text, REFERENCE).drive
    assert [e.stage for e in undecided.as_built] == [e.stage for e in effects]
    for chosen in SETS[0]:
        decided = load_text(uncommented(text, chosen), REFERENCE).drive
        assert [e.stage for e in decided.as_built] == [*(e.stage for e in effects), chosen.stage]
        ((effect, values),) = known_effects(layout_of(decided).si, run(), decided.as_built[-1:])
        assert (effect.name, effect.stage, list(values)) == (chosen.name, chosen.stage, [1e-4, 0.0])


def test_each_of_two_sets_is_decided_by_itself() -> None:
    text = as_built_text(load_design(REFERENCE), result((), SETS))
    assert "set 1 of 2" in text and "set 2 of 2" in text
    modulus = load_design(REFERENCE).drive.cable.modulus_GPa
    second = load_text(uncommented(text, MODULUS), REFERENCE).drive
    assert second.as_built == () and second.cable.modulus_GPa == pytest.approx(1.1 * modulus)
    both = load_text(uncommented(uncommented(text, MODULUS), RIGHT), REFERENCE).drive
    assert [e.stage for e in both.as_built] == ["input_right"] and both.cable.modulus_GPa == pytest.approx(
        1.1 * modulus
    )


@pytest.mark.parametrize("effects", [(), (GUIDE,)], ids=["nothing else", "beside a named one"])
def test_what_was_undecided_is_written_anew_by_the_next_run(effects: tuple[Named, ...]) -> None:
    loaded = load_design(REFERENCE)
    undecided = load_text(as_built_text(loaded, result(effects, SETS)), REFERENCE)
    plain = as_built_text(loaded, result(effects)).split("\n")
    assert as_built_text(undecided, result(())).split("\n") == plain
    decided = load_text(as_built_text(undecided, result((LEFT,))), REFERENCE)
    assert "UNDECIDED" not in decided.text and decided.drive.as_built[-1].stage == "input_left"


def test_the_terminal_is_told_what_is_in_force() -> None:
    assert applied_words(result((GUIDE,), (SETS[0],))) == (
        "once_per_rev guide in force; undecided, as comments: once_per_rev input_left or once_per_rev input_right "
        "(remove the comment marks of the one that the bench confirms)"
    )
    assert "no effect was named" in applied_words(result(()))


def test_known_effects_change_the_prediction_as_the_effect_does() -> None:
    drive = load_text(as_built_text(load_design(REFERENCE), result((GUIDE,))), REFERENCE).drive
    d, p = layout_of(drive).si, run()
    ((effect, values),) = known_effects(d, p, drive.as_built)
    simulate = Simulator()
    base = declared(d, 9.0, p)
    change = simulate(effect.apply(base, values, simulate)) - simulate(base)
    assert 100e-6 < np.ptp(change) < 1000e-6, f"guide 10 um off centre: {1e6 * np.ptp(change):.1f} urad"


def test_a_form_or_figure_that_the_loop_lacks_is_said() -> None:
    wrong = named("once_per_rev", "oval pulley", "guide", cosine_m=1e-5, sine_m=0.0)
    lacking = named("once_per_rev", "eccentric pulley", "guide", cosine_m=1e-5)
    for entry, words in ((wrong, "eccentric pulley, stage guide"), (lacking, "lacks sine_m")):
        drive = load_text(as_built_text(load_design(REFERENCE), result((entry,))), REFERENCE).drive
        with pytest.raises(ModelError, match=words):
            known_effects(layout_of(drive).si, run(), drive.as_built)
