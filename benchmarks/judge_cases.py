"""The runs with truth by which the loop is judged: experiments of the rig, benches of other physics, all layouts.

Each case has a fixed seed, so that the same runs are judged every time. Seeds of the rig are those of
params/experiments; the hard runs are those that an earlier loop had wrong; no other seed was used while the loop was
developed.
"""

import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from itertools import count
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import yaml

from benchmarks.studies.plan import EFFECTS, promised
from benchmarks.study import ROOT
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.measurement.reading import load_measurement
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.rig.experiment import Experiment, RigError, read_experiment, run_files, write_run
from mbcdm_cad.rig.quasistatic import simulate
from tests.support import bench_layouts
from tests.support.bench_cases import CASES
from tests.support.bench_change import CHANGES, simulate_change
from tests.support.bench_data import drum_angle, simulate_case, stream, through_files
from tests.support.bench_effects import Effect
from tests.support.bench_real import DECLARED_FLOOR_RAD, REAL_CASES, SMALL, draw_traits, simulate_real, truth_of

LIBRARY = ROOT / "params" / "experiments"
Truth = list[dict[str, Any]]
# First seeds of the benches; the seed of a bench of all layouts has the layout as its remainder by four.
CHAIN_SEED, LAYOUTS_SEED, PLAN_SEED = 4000, 90_000, 900
# Probability with which the sizes of a plan are found.
PROMISED = 0.9
# Benches are as short as their kind allows, so that a table takes minutes: no logger above this rate, no long run.
MOST_RATE_HZ, DURATION_S = 200.0, 100.0
# An effect that changes the reading by less than this share of the noise is not to be named.
LEAST = 0.45
KINDS = {"null": "none", "texture": "none", "fair": "one", "single": "one", "pair": "several", "three": "several"}
KINDS |= {"cover": "several", "sensors": "sensors err", "outside": "outside"}
# Runs that went wrong once, each in its own way: the bench that makes them, case, seed.
HARD = (
    # The pulley does not reach the far face of its play, so that the size of the play has no scatter.
    ("chain", "lash_left", 3003),
    # 2000 samples a second: the search uses a part of the run, and the load that moves the pulley occurs only once.
    ("chain", "lash_input_left", 3100),
    # A wave of the drum stands for the ratio until the time of the slip is searched again beside the ratio.
    ("chain", "slip_mount+ratio_encoder", 3102),
    # The ripple is withdrawn together with a form that moves the cables, and is accepted again.
    ("chain", "ripple_fast+friction", 3100),
    # Runout of both inputs resembles the guide beside a wrong ratio: both names have to be exchanged at once.
    ("chain", "pulley_guide+ratio_encoder", 12008),
    # The search uses a part of the run; the half sweeps held back in it had one load only.
    ("chain", "stiffness_modulus", 12003),
    # Half sweeps of 2000 samples: half of them say too little of the ripple, all of them thinned say enough.
    ("chain", "stiffness_modulus+ripple_slow", 12008),
    # Ten half sweeps cannot support each of two large effects, but nothing above the noise is left beside both.
    ("chain", "modulus_low+encoder_left", 18000),
    # Without the ratio the friction moves so far that a fit with the ratio has to begin where the friction was.
    ("chain", "mu_low+ratio_radii", 18001),
    # The odds of the right input are some 1e3 to 1, though its errors differ by less than two standard errors.
    ("chain", "encoder_left", 17003),
    # A viscous drag is accepted before the late sensor, and beside it a wrong friction.
    ("chain", "preload_low+ratio_encoder+delay", 19004),
    # The odds are 670 to 1 for a wave of the drum in place of the ratio, but only at one phase.
    ("chain", "pulley_guide+ratio_encoder", 19004),
    # The odds are above 99 to 1 for the wrong input, but such runs confuse the two in 8 %.
    ("chain", "pulley_input_right", 19003),
    ("quiet", "null", 1),
    ("quiet", "null_texture", 0),
    ("quiet", "null_bare", 0),
    ("quiet", "stiffness_shaft", 1),
    ("quiet", "pulley_guide", 0),
    ("quiet", "pulley_input_left", 0),
    ("quiet", "ratio_encoder", 0),
    ("quiet", "winding", 0),
    ("quiet", "friction", 2),
    # A strong preload error that a linear step promises nothing of.
    ("quiet", "preload_1", 1),
    # The linear screening ranks the wrong pulley first and the right one last.
    ("quiet", "pulley_input_left", 2),
    # Each of the two leans on one place while the other is not there.
    ("quiet", "thermal+right", 0),
    # A shape of the load without a name.
    ("quiet", "out_hardening", 0),
    # A soft shaft is no soft rope with more friction.
    ("layouts", "pair: shaft + drum disc", 60252),
    # What a wrong model leaves raises its floor, beside which cross talk of the torque sensor explained the run.
    ("rig", "pair-guide-soft", 0),
)


@dataclass(frozen=True)
class Made:
    """One run with its truth; ``small``: entries of the truth that are too small to be named."""

    drive: Drive
    run: Run
    truth: Truth
    small: Callable[[], Truth] = list


@dataclass(frozen=True)
class Case:
    """One run to judge. ``kind``: none, one, several, change, sensors err (within their class), outside, promised."""

    source: str
    kind: str
    name: str
    seed: int

    def made(self) -> Made:
        """The run. Raises ``RigError`` where the rig cannot make it."""
        source, name = self.name.split(" ", 1) if self.source == "hard" else (self.source, self.name)
        return MAKERS[source](replace(self, source=source, name=name))


@cache
def reference() -> Drive:
    """The drive of params/mbcdm.yaml."""
    return load_design(ROOT / "params" / "mbcdm.yaml").drive


def cases() -> list[Case]:
    """All cases, by source and kind."""
    rig = [Case("rig", _kind("rig", path.stem), path.stem, 0) for path in sorted(LIBRARY.glob("*.yaml"))]
    chain = [Case("chain", _kind("chain", name), name, _seed(name)) for name in REAL_CASES if name not in SMALL]
    chain += [Case("chain", "change", f"{name} changes", _seed(name)) for name in CHANGES]
    names = [(group, name) for group, known in bench_layouts.GROUPS.items() for name in known]
    layouts = [
        Case("layouts", _kind("layouts", f"{group}: {name}"), f"{group}: {name}", LAYOUTS_SEED + k)
        for k, (group, name) in enumerate(names)
    ]
    plan = [Case("plan", "promised", label, PLAN_SEED) for label in EFFECTS]
    hard = [Case("hard", _kind(source, name), f"{source} {name}", seed) for source, name, seed in HARD]
    return sorted([*rig, *chain, *layouts, *plan, *hard], key=lambda case: (case.source, case.kind, case.name))


def _kind(source: str, name: str) -> str:
    """What kind of run a case is, by its name."""
    if source == "rig":
        known = {"null": "none", "none": "none", "out": "outside", "pair": "several", "three": "several"}
        return known.get(name.split("-")[0], "one")
    if name.endswith(" changes"):
        return "change"
    return KINDS[
        name.split(":")[0] if source == "layouts" else (REAL_CASES if source == "chain" else CASES)[name].group
    ]


def fresh(first_seed: int, runs: int) -> list[Case]:
    """Benches of the rig, the chain and all layouts with seeds of their own, mixed, so that any part of them is fair.

    ``first_seed`` times 1000 is the first seed: who asks for a seed that nobody asked for has runs that nobody saw.
    """
    known = [case for case in cases() if case.source in ("rig", "chain", "layouts")]
    random = Random(first_seed)
    found: list[Case] = []
    while len(found) < runs:
        for case in random.sample(known, len(known)):
            seed = 1000 * first_seed + 4 * len(found)
            if case.source == "chain":
                seed = _seed(case.name.removesuffix(" changes"), seed)
            # The remainder of the case's seed is its layout.
            found.append(replace(case, seed=seed + (case.seed % 4 if case.source == "layouts" else 0)))
    return found[:runs]


def _of_rig(case: Case) -> Made:
    drive = reference()
    experiment = read_experiment(LIBRARY / f"{case.name}.yaml")
    if case.seed:
        experiment = experiment.model_copy(update={"seed": case.seed})
    assert isinstance(experiment, Experiment), "the library holds quasi-static experiments"
    simulated = simulate(drive, experiment)
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / case.name
        write_run(target, run_files(simulated, experiment, drive.input_names))
        truth = yaml.safe_load((target / f"{case.name}.truth.yaml").read_text())["effects"]
        run = load_measurement(target / f"{case.name}.yaml")

    def small() -> Truth:
        found: Truth = []
        for left_out in experiment.effects:
            rest = [effect for effect in experiment.effects if effect is not left_out]
            less = simulate(drive, experiment.model_copy(update={"effects": rest}))
            if np.std(simulated.measured_output_rad - less.measured_output_rad) < LEAST * DECLARED_FLOOR_RAD:
                found += [entry for entry in truth if entry not in less.truth]
        return found

    return Made(drive, run, [entry for entry in truth if entry.get("seen", True)], small)


def _of_chain(case: Case) -> Made:
    drive, name = reference(), case.name.removesuffix(" changes")
    truth = truth_of(drive, name, case.seed)
    entries = _entries(case, truth.effects)
    if case.kind == "change":
        simulated, at_s = simulate_change(drive, name, case.seed)
        entries = [{**one, "changes": True, "parameters": {**one["parameters"], "at_s": at_s}} for one in entries]
        return Made(drive, through_files(simulated, drive.input_names), entries)
    simulated = simulate_real(drive, name, case.seed)

    def small() -> Truth:
        def drum(effects: tuple[Any, ...]) -> np.ndarray:
            wander = stream(f"real/{name}", case.seed, "wander")
            return drum_angle(truth.chain, drive.input_names, truth.bench, effects, wander)

        whole = drum(truth.effects)
        rest = [whole - drum(tuple(one for one in truth.effects if one is not out)) for out in truth.effects]
        least = LEAST * truth.traits.floor_rad
        return [entry for entry, change in zip(entries, rest, strict=True) if np.std(change) < least]

    return Made(drive, through_files(simulated, drive.input_names), entries, small)


def _of_layouts(case: Case) -> Made:
    group, name = case.name.split(": ", 1)
    drive, run, truth = bench_layouts.made(group, name, case.seed)
    return Made(drive, run, [entry for entry in truth if entry.get("seen", True)])


def _of_quiet(case: Case) -> Made:
    drive = reference()
    simulated = simulate_case(drive, case.name, case.seed)
    return Made(drive, through_files(simulated, drive.input_names), _entries(case, simulated.effects))


def _entries(case: Case, effects: tuple[Effect, ...]) -> Truth:
    """The effects as a truth; the texture of a run without an effect is there to be left alone."""
    return [] if case.kind == "none" else [effect.as_truth() for effect in effects]


def _of_plan(case: Case) -> Made:
    made = promised((case.seed, case.name, PROMISED))
    if made is None:
        raise RigError(f"{case.name}: the planned motion cannot show it")
    return Made(reference(), made[0], [made[1].as_truth()])


MAKERS = {"rig": _of_rig, "chain": _of_chain, "quiet": _of_quiet, "layouts": _of_layouts, "plan": _of_plan}


def _seed(name: str, first: int = CHAIN_SEED) -> int:
    """The first seed whose bench is short and logs slowly."""
    key = f"real/{name}"
    for seed in count(first):
        plan = REAL_CASES[name].plan(stream(key, seed, "plan"))
        if plan.duration_s <= DURATION_S and draw_traits(stream(key, seed, "traits")).rate_hz <= MOST_RATE_HZ:
            return seed
    raise AssertionError("the seeds have no end")
