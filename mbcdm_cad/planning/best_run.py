"""The best run that a bench can make: compare planned runs by the sizes from which each names an effect."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import exp, inf, log

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.loop.prepare.noise import Noise
from mbcdm_cad.measurement.run import TorqueClass
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.planning.candidates import candidates, class_of_load, experiment_text, run_of
from mbcdm_cad.planning.plan import Foreseen, RunPlan, plan_of
from mbcdm_cad.rig.bench import BenchLimits
from mbcdm_cad.rig.experiment import Experiment
from mbcdm_cad.rig.writing import RigError

# A run that needs an effect this many times larger than the best run does is as bad as one that cannot show it.
BLIND = 10.0


@dataclass(frozen=True)
class Rated:
    """Rating of a run: geometric mean over the effects of its smallest size over that of the best run; 1 is best.

    ``blind`` effects are shown by another run but not by this one, or this one never separates them from a rival.
    """

    mean_multiple: float
    blind: int


def alone_from(effect: Foreseen) -> float:
    """Size from which the effect is named and not confused with another; infinite if no size is enough."""
    if effect.smallest is None:
        return inf
    return max([effect.smallest, *(inf if rival.from_size is None else rival.from_size for rival in effect.rivals)])


def rated(plans: Sequence[RunPlan]) -> list[Rated]:
    """The rating of each plan against all others; effects that no plan shows do not count.

    A part of a friction that one run tells from a constant one, and another does not, counts as an effect.
    """
    alike = [{words.split(":")[0] for words in plan.friction_alike} for plan in plans]
    parts = set[str]().union(*alike)
    sizes = [
        {one.label: alone_from(one) for one in plan.effects} | {part: inf if part in own else 1.0 for part in parts}
        for plan, own in zip(plans, alike, strict=True)
    ]
    best = {label: min(size.get(label, inf) for size in sizes) for size in sizes for label in size}
    shown = {label: size for label, size in best.items() if size < inf}
    found = []
    for size in sizes:
        multiples = [min(size.get(label, inf) / least, BLIND) for label, least in shown.items()]
        mean = exp(sum(map(log, multiples)) / len(multiples)) if multiples else inf
        found.append(Rated(mean, sum(size.get(label, inf) == inf for label in shown)))
    return found


# Number of compared runs that are listed.
LISTED = 6


@dataclass(frozen=True)
class BestRun:
    """The compared runs, best first, and the plan of the best one at the sample rate of the bench."""

    runs: tuple[tuple[Experiment, Rated], ...]
    plan: RunPlan

    @property
    def experiment(self) -> Experiment:
        """The best run."""
        return self.runs[0][0]

    def experiment_text(self, bench: str) -> str:
        """The experiment file of the best run; ``bench`` names the file of limits in its first line."""
        return experiment_text(self.experiment, f"the best run within {bench}: {self.experiment.about}")

    def text(self) -> str:
        """The comparison and the plan as text."""
        lines = [
            f"{len(self.runs)} runs compared. 'size': smallest size of an effect that is named and separated, divided",
            "by that of the best run for this effect; mean of all effects. 'cannot': number of effects that the run",
            "does not show or cannot separate.",
            "",
            f"{'size':>6}  {'cannot':>6}  run",
        ]
        lines += [f"{one.mean_multiple:6.2f}  {one.blind:6d}  {run.about}" for run, one in self.runs[:LISTED]]
        return "\n".join([*lines, "", f"best: {self.experiment.about}", "", self.plan.text()])


def best_run(
    drive: Drive,
    limits: BenchLimits,
    noise: Noise | None,
    own: Sequence[Experiment] = (),
    progress: Callable[[str], None] = lambda name: None,
) -> BestRun:
    """The best of the runs within ``limits`` and of ``own``. Raises ``MbcdmError`` if none of them can be made."""
    found = []
    for experiment in (*own, *candidates(drive, limits)):
        progress(f"plan of {experiment.about or experiment.name}")
        plan = _plan(drive, experiment, noise, class_of_load(limits, experiment.load))
        if plan is not None:
            found.append((experiment, plan))
    if not found:
        raise MbcdmError("no run within these limits can be made on this drive; allow more torque or travel")
    ranked = sorted(
        zip((experiment for experiment, _ in found), rated([plan for _, plan in found]), strict=True),
        key=lambda pair: pair[1].mean_multiple,
    )
    ranked = [(run.model_copy(update={"sample_rate_Hz": limits.sample_rate_Hz}), one) for run, one in ranked]
    at_rate = _plan(drive, ranked[0][0], noise, class_of_load(limits, ranked[0][0].load))
    assert at_rate is not None
    return BestRun(tuple(ranked), at_rate)


def _plan(drive: Drive, experiment: Experiment, noise: Noise | None, torque_class: TorqueClass) -> RunPlan | None:
    try:
        return plan_of(drive, run_of(drive, experiment, torque_class), noise)
    except (RigError, ModelError):
        return None
