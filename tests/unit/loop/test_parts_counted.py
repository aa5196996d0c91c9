"""A drive measured with its structure and losses: what the design computes of them is blamed on no cable.

The runs are the rig's, which takes the figures of the parts from the design and does its own mechanics."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.loader import layout_of, load_design, load_text
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.loop.as_built import applied_words, as_built_text
from mbcdm_cad.loop.effects import known_effects
from mbcdm_cad.loop.effects.load_sensor import within_prior
from mbcdm_cad.loop.effects.stiffness_error import offer
from mbcdm_cad.loop.prepare.prepared import Prepared, prepare
from mbcdm_cad.loop.prepare.samples import SEARCH_SAMPLES, Cut, search_cut, told_from_noise, whole_cut
from mbcdm_cad.loop.prepare.setup import Simulator, declared
from mbcdm_cad.loop.readable import Value
from mbcdm_cad.loop.result import Errors, LoopResult, Named
from mbcdm_cad.loop.search.engine import close_loop
from mbcdm_cad.loop.search.fit import Fitter
from mbcdm_cad.measurement.file import load_file
from mbcdm_cad.measurement.loads import parts_seen
from mbcdm_cad.measurement.run import Run, Sensors, half_sweeps
from mbcdm_cad.measurement.schema import CountedParts
from mbcdm_cad.measurement.vet import arranged
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.rig.experiment import Experiment, read_experiment, run_files
from mbcdm_cad.rig.quasistatic import simulate
from tests.support.reference import REFERENCE, ROOT

DRIVE = load_design(ROOT / "params" / "mbcdm.yaml").drive
BOTH = CountedParts()


def plan(effects: list[dict[str, Any]], **changes: Any) -> Experiment:
    """The library's run at four levels of a brake, half as long, with structure and losses."""
    experiment = read_experiment(ROOT / "params" / "experiments" / "null-short-levels.yaml")
    assert isinstance(experiment, Experiment)
    physics = experiment.physics.model_dump() | {"structure": True, "losses": True}
    shorter = {"duration_s": 80.0, "sample_rate_Hz": 50.0, "physics": physics, "effects": effects}
    return Experiment.model_validate(experiment.model_dump() | shorter | changes)


def logged(experiment: Experiment, counted: CountedParts | None) -> Run:
    seen = simulate(DRIVE, experiment)
    s = experiment.sensors
    steps = Sensors(s.input_resolution_rad, s.output_resolution_rad, s.torque_noise_Nm)
    read = seen.measured_input_rad, seen.measured_output_rad, seen.measured_load_Nm
    return Run(seen.time_s, *read, sensors=steps, counted=counted)


def test_give_and_friction_are_those_of_the_encoders_of_the_run() -> None:
    structure, losses = structure_of(layout_of(DRIVE)), layout_of(DRIVE).losses
    assert structure is not None
    drum = parts_seen(DRIVE, BOTH, motor_side=False)
    assert drum.give_rad_Nm == pytest.approx(structure.encoder_urad_Nm * 1e-6)
    payload = CountedParts(output_at="payload")
    assert parts_seen(DRIVE, payload, False).give_rad_Nm == pytest.approx(structure.payload_urad_Nm * 1e-6)
    assert parts_seen(DRIVE, payload, True).give_rad_Nm == pytest.approx(structure.motor_urad_Nm * 1e-6)
    before = parts_seen(DRIVE, BOTH, True).give_sigma_rad_Nm
    assert before > 2.0 * drum.give_sigma_rad_Nm > 0.0, "gearheads are known to a factor of two"
    # What rubs at the drum: all rows without load, but those of inputs, gearheads and motors.
    still = losses.moving(np.array([0.0]), 1).losses
    outside = ("inputs", "input pulleys", "gearheads", "motors")
    at_drum = sum(float(x.torque_Nm[0]) for x in still if not any(word in x.name for word in outside))
    assert drum.friction_Nm == pytest.approx(at_drum, rel=0.02), [(x.name, x.torque_Nm) for x in still]
    nothing = parts_seen(DRIVE, CountedParts(structure=False, losses=False), False)
    assert (nothing.give_rad_Nm, nothing.friction_Nm) == (0.0, 0.0)


def test_the_rig_writes_what_its_run_counts_and_files_of_before_count_nothing(tmp_path: Path) -> None:
    for experiment, counted in ((plan([], duration_s=10.0), BOTH), (plan([], duration_s=10.0, physics={}), None)):
        for name, data in run_files(simulate(DRIVE, experiment), experiment, DRIVE.input_names).items():
            (tmp_path / name).write_bytes(data)
        assert load_file(tmp_path / "null-short-levels.yaml").content.parts == counted


def test_the_declared_prediction_of_a_run_with_parts_is_that_of_the_rig() -> None:
    """Without noise, the residual of the declared model stays small beside what the parts do."""
    sensors = {"input_resolution_rad": 0.0, "output_resolution_rad": 0.0, "torque_noise_Nm": 0.0}
    experiment = plan([], duration_s=40.0, sensors=sensors)
    ratio = float(layout_of(DRIVE).si.total_ratio[0])

    def spread_urad(counted: CountedParts | None) -> float:
        p = prepare(arranged(logged(experiment, counted), DRIVE), ratio)[0]
        left = p.output_rad - Simulator()(declared(layout_of(DRIVE).si, ratio, p))
        return float(np.std(left[p.used])) * 1e6

    counted, rigid = spread_urad(BOTH), spread_urad(None)
    assert rigid > 100.0 and counted < 0.05 * rigid, f"{counted:.2f} urad with the parts, {rigid:.2f} without"


def test_the_structure_may_be_softer_or_stiffer_and_its_sigma_bounds_what_is_no_effect() -> None:
    p = prepare(arranged(logged(plan([], duration_s=40.0), BOTH), DRIVE), 9.0)[0]
    assert p.run.parts is not None
    series = next(e for e in offer(layout_of(DRIVE).si, p) if e.form == "compliance in series")
    assert series.parameters[0].low == -p.run.parts.give_rad_Nm
    assert "less than computed" in series.words_of(np.array([-1e-6])).plain
    give, rubs = within_prior((p,))
    assert give.parameters[0].high == pytest.approx(2.0 * p.run.parts.give_sigma_rad_Nm)
    low, high = rubs.parameters[0].low, rubs.parameters[0].high
    m = p.run.parts.friction_Nm
    assert (m + high) / m == pytest.approx(m / (m + low)), "a factor, either way"
    bare = replace(p, run=replace(p.run, parts=None))
    assert within_prior((bare,)) == []


SOFT = {"effect": "shaft_compliance", "compliance_urad_Nm": 80.0}
WEAK = {"effect": "modulus", "share": -0.12}


def names(found: LoopResult) -> list[list[str]]:
    return [[one.name] for one in found.effects] + [[one.name for one in group] for group in found.one_of]


@pytest.mark.slow
@pytest.mark.parametrize(("effects", "form"), [([], ""), ([SOFT], "compliance in series"), ([WEAK], "modulus")])
def test_what_the_design_computes_is_named_by_nobody(effects: list[dict[str, Any]], form: str) -> None:
    found = close_loop(DRIVE, [logged(plan(effects), BOTH)])
    if not effects:
        assert found.verdict == "none" and names(found) == [], found.sentence
        return
    assert names(found) and all("stiffness_error" in group for group in names(found)), found.sentence
    members = (*found.effects, *(member for group in found.one_of for member in group))
    first = next(one for one in members if one.name == "stiffness_error")
    if not first.form.startswith(form):
        # Within the uncertainty of the structure a soft rope is not told from more give.
        assert any(other.startswith(form) for other in first.equivalent), found.sentence
        return
    value = next(iter(first.parameters.values())).value
    # The structure's compliance, within its uncertainty, takes or gives a part of a soft modulus.
    wanted, rel = (80e-6, 0.1) if form == "compliance in series" else (WEAK["share"], 0.25)
    assert value == pytest.approx(wanted, rel=rel), found.sentence


@pytest.mark.slow
def test_a_structure_softer_within_its_sigma_is_no_effect() -> None:
    found = close_loop(DRIVE, [logged(plan([SOFT | {"compliance_urad_Nm": 12.0}]), BOTH)])
    assert names(found) == [], found.sentence
    assert "figures of the design within their uncertainty: structure compliance" in found.sentence, found.sentence


@pytest.mark.slow
def test_the_same_run_on_rigid_parts_blames_the_drive() -> None:
    found = close_loop(DRIVE, [logged(plan([]), None)])
    assert any("stiffness_error" in group for group in names(found)), found.sentence


# What moves the cables to and fro, or slips on the guide, is not taken for less friction; nor is a load for a name.


def judged(name: str, duration_s: float, seed: int = 77, judge: Drive = DRIVE) -> LoopResult:
    experiment = read_experiment(ROOT / "params" / "experiments" / f"{name}.yaml")
    assert isinstance(experiment, Experiment)
    seen = simulate(DRIVE, experiment.model_copy(update={"seed": seed, "duration_s": duration_s}))
    sensors = experiment.sensors
    steps = Sensors(sensors.input_resolution_rad, sensors.output_resolution_rad, sensors.torque_noise_Nm)
    run = Run(seen.time_s, seen.measured_input_rad, seen.measured_output_rad, seen.measured_load_Nm, sensors=steps)
    return close_loop(judge, [run])


def test_a_fast_motion_of_one_input_is_no_noise() -> None:
    rng = np.random.default_rng(3)
    t = np.arange(0.0, 60.0, 0.01)
    noise = 5e-5
    cogging = 3e-4 * np.sin(2.0 * np.pi * 7.3 * t)
    kept, _ = told_from_noise(cogging + noise * rng.standard_normal(t.size), noise, 0.01)
    assert np.std(kept - cogging) < 0.5 * noise, np.std(kept - cogging)
    faint, _ = told_from_noise(0.05 * cogging + noise * rng.standard_normal(t.size), noise, 0.01)
    assert np.std(faint) < 0.2 * noise, np.std(faint)


def test_a_load_that_was_not_measured_is_no_name() -> None:
    found = judged("null-no-torque", 100.0)
    assert found.verdict == "not_testable" and not found.effects and not found.one_of, found.sentence
    assert "No torque was measured" in found.sentence, found.sentence
    assert any("no torque was measured" in doubt for doubt in found.doubts), found.doubts


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "duration_s", "named"),
    [("ripple-mesh", 96.0, ["ripple"]), ("out-guide-slip", 80.0, ["passed_slip"]), ("none-cogging", 80.0, [])],
)
def test_what_eases_the_cables_is_not_taken_for_less_friction(name: str, duration_s: float, named: list[str]) -> None:
    found = judged(name, duration_s)
    assert [one.name for one in found.effects] == named and not found.one_of, found.sentence


@pytest.mark.slow
def test_slip_on_the_guide_that_the_design_counts_is_no_effect() -> None:
    """The run of a drive with slip on the guide, judged by a design that declares it."""
    assert isinstance(DRIVE, BevelDrive)
    found = judged("out-guide-slip", 80.0, judge=replace(DRIVE, guide_slips=True))
    assert found.verdict == "none" and not found.effects and not found.one_of, found.sentence


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


D = layout_of(load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive).si
RATIO = float(np.mean(D.total_ratio))
STEP_S = 0.01


def triangle(periods: int, period: int) -> np.ndarray:
    t = np.arange(periods * period) / period
    return np.asarray(0.45 * 2.0 / np.pi * np.arcsin(np.sin(2.0 * np.pi * t)))


def test_half_sweeps_begin_where_the_output_turns() -> None:
    period, rng = 800, np.random.default_rng(1)
    output = triangle(30, period) + rng.normal(0.0, 1e-3, 30 * period)
    sweep = half_sweeps(output)
    turns = np.flatnonzero(np.diff(sweep)) + 1
    true = period / 4 + period / 2 * np.arange(60)
    off = np.abs(turns - true[: turns.size])
    assert turns.size == 60, turns
    assert off.max() <= 8, off


@pytest.mark.parametrize("half_sweep", [40, 400, 4000])
@pytest.mark.parametrize("samples", [30_000, 300_000, 1_000_000])
def test_cuts_cover_the_run_in_order_and_keep_whole_half_sweeps(half_sweep: int, samples: int) -> None:
    sweep = np.arange(samples) // half_sweep
    load = np.cos(np.arange(samples) * 0.37)

    def check(cut: Cut, most: int) -> None:
        dense = cut.index[~cut.lead]
        figures = (
            f"{cut.index.size} samples, {cut.lead.sum()} of them lead in, stride {cut.stride}, starts {cut.starts}"
        )
        assert (np.diff(cut.index) > 0).all(), figures
        assert dense.size <= 1.3 * most, figures
        assert dense[0] == 0, figures
        assert dense[-1] >= samples - 2 * half_sweep - cut.stride, figures
        judged = cut.index[~cut.unknown]
        assert np.unique(sweep[judged]).size >= 0.6 * np.unique(sweep[dense]).size, figures
        for start in cut.starts[1:]:
            assert cut.index[start] % half_sweep == 0, f"a stretch begins where the drive does not turn: {figures}"

    part = search_cut(sweep, load)
    assert part is not None
    check(part, SEARCH_SAMPLES)
    check(whole_cut(sweep, load, STEP_S), 250_000)


@pytest.mark.parametrize("lowest", range(3, 57, 6))
def test_the_extremes_of_the_load_are_searched(lowest: int) -> None:
    """The lowest load occurs in one half sweep of sixty, the highest in another."""
    sweep = np.arange(60_000) // 1000
    highest = (lowest + 20) % 54 + 3
    load = np.where(sweep == lowest, -1.0, np.where(sweep == highest, 0.9, 0.1 * np.cos(sweep)))
    cut = search_cut(sweep, load)
    assert cut is not None
    judged = set(sweep[cut.index[~cut.unknown]].tolist())
    assert {lowest, highest} <= judged, f"half sweeps {lowest} and {highest} are wanted, {sorted(judged)} are searched"


def test_short_runs_are_not_cut() -> None:
    sweep = np.arange(16_000) // 500
    assert search_cut(sweep, None) is None
    cut = whole_cut(sweep, None, STEP_S)
    assert np.array_equal(cut.index, np.arange(16_000))
    assert not cut.unknown.any()


def test_stretches_remember_what_the_whole_remembers() -> None:
    """Loads change sign from sweep to sweep: a stretch that began from nothing would be tens of microradians off."""
    period = 1600
    output = triangle(60, period)
    n = output.size
    half = np.maximum(0, half_sweeps(output) - 1)
    load = np.array([1.2, 0.3, 1.2, 0.3, -0.3, -1.2, -0.3, -1.2])[half % 8]
    kernel = np.full(21, 1.0 / 21.0)
    load = np.asarray(np.convolve(np.pad(load, 10, mode="edge"), kernel, mode="valid"))
    inputs = RATIO * np.stack([output, output])
    time_s = np.arange(n, dtype=float) * STEP_S
    run = Run(time_s, inputs, output, load, sensors=Sensors(1e-4, 1e-6))
    part, whole = prepare(run, RATIO)
    assert part.cut.starts.size == 4
    at_all = Fitter(D, RATIO, [whole]).predict((), (), np.zeros(1))
    at_part = Fitter(D, RATIO, [part]).predict((), (), np.zeros(1))
    everywhere = np.interp(part.cut.index, whole.cut.index, at_all)
    off = 1e6 * np.abs(at_part - everywhere)
    # On the load's flanks, where the drive turns, the two interpolate between other samples.
    level = part.used & (np.abs(part.cut.index % (period // 2) - period // 4) > 30)
    typical, worst = float(np.sqrt(np.mean(off[part.used] ** 2))), float(off[level].max())
    assert typical < 0.3, typical
    assert worst < 1.0, worst


@pytest.mark.parametrize("seed", range(6))
def test_the_searched_part_holds_back_its_own_share_of_loads_and_directions(seed: int) -> None:
    """Each half sweep has a load of its own, in no rhythm; the search sees a part of them."""
    rng = np.random.default_rng(seed)
    output = triangle(30, 1600)
    sweep = np.maximum(0, half_sweeps(output) - 1)
    load = rng.uniform(-1.0, 1.0, 64)[sweep]
    time_s = np.arange(output.size) * STEP_S
    part, whole = prepare(Run(time_s, RATIO * np.stack([output, output]), output, load), RATIO)
    assert part is not whole
    for one in (part, whole):
        share = one.test.sum() / one.used.sum()
        ups = {bool(v) for v in np.sign(one.speed_rad_s[one.test]) > 0.0}
        spread = float(np.std(one.load_Nm[one.test]) / np.std(one.load_Nm[one.used]))  # type: ignore[index]
        assert 0.12 <= share <= 0.38, f"{share:.2f} of the samples are held back"
        assert ups == {True, False}
        assert spread >= 0.5, f"the spread of the held back loads is {spread:.2f} of that of all"
    assert set(np.unique(part.sweep[part.test])) <= set(np.unique(whole.sweep[whole.test]))
