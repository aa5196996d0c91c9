"""Reading an experiment file: text, YAML, schema; every fault becomes an ``InputError`` with its line."""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from mbcdm_cad.design import yamltree
from mbcdm_cad.design.fieldpath import dotted
from mbcdm_cad.design.source import read_text
from mbcdm_cad.errors import InputError, Problem, shortened
from mbcdm_cad.rig.block import ExperimentBlock
from mbcdm_cad.rig.dynamic.experiment import DynamicExperiment
from mbcdm_cad.rig.quasistatic.experiment import MAX_SAMPLES, Experiment
from mbcdm_cad.rig.sensors import BenchLimits

Block = TypeVar("Block", bound=ExperimentBlock)

_KIND = ("experiment file", "; docs/experiments.md shows examples")
_BENCH_KIND = ("bench file", "; docs/measure-your-drive.md shows one")
_BOUNDS = {
    "gt": "over",
    "ge": "at least",
    "lt": "under",
    "le": "at most",
    "min_length": "at least",
    "max_length": "at most",
    "pattern": "signs",
    "expected": "one of",
    "expected_tags": "one of",
}


def read_experiment(path: str | Path) -> Experiment | DynamicExperiment:
    """The experiment in a YAML file, on the dynamic rig if it has a field ``rig``. InputError lists all problems."""
    path = Path(path)
    tree = yamltree.parse(read_text(path, *_KIND), str(path), *_KIND)
    dynamic = isinstance(tree.data, dict) and "rig" in tree.data
    if dynamic:
        return _validated(DynamicExperiment, tree, str(path))
    experiment = _validated(Experiment, tree, str(path))
    samples = experiment.duration_s * experiment.sample_rate_Hz * experiment.physics.substeps
    if not 8 <= samples <= MAX_SAMPLES:
        raise InputError(
            [
                Problem(
                    str(path),
                    tree.line_of(("duration_s",)),
                    "duration_s",
                    "a run of that many steps cannot be made",
                    f"{samples:.0f} steps",
                    f"8 to {MAX_SAMPLES}",
                    "change duration_s or sample_rate_Hz",
                )
            ]
        )
    return experiment


def read_bench(path: str | Path) -> BenchLimits:
    """The limits of the bench in a YAML file. InputError lists all problems."""
    path = Path(path)
    tree = yamltree.parse(read_text(path, *_BENCH_KIND), str(path), *_BENCH_KIND)
    limits = _validated(BenchLimits, tree, str(path))
    if bool(limits.loads) != (limits.torque_Nm is not None):
        missing, beside = ("torque_Nm", "loads") if limits.loads else ("loads", "torque_Nm")
        remedy = "add torque_Nm, the most it makes, N m" if limits.loads else "add loads: [brake, weight, torque_motor]"
        problem = Problem(str(path), tree.line_of((beside,)), missing, "missing beside " + beside, remedy=remedy)
        raise InputError([problem])
    return limits


def _validated(model: type[Block], tree: yamltree.Tree, file: str) -> Block:
    try:
        return model.model_validate(tree.data)
    except ValidationError as error:
        found = [_problem(item, tree, file) for item in error.errors(include_url=False)]
        raise InputError(sorted(found, key=lambda problem: problem.line)[:50]) from None


def _problem(item: Any, tree: yamltree.Tree, file: str) -> Problem:
    context = item.get("ctx", {})
    # Pydantic adds the branch of a union to the path; the file does not contain it.
    where = tuple(part for k, part in enumerate(item["loc"]) if not (k == 2 and item["loc"][0] == "effects"))
    limit = ", ".join(f"{word} {context[key]}" for key, word in _BOUNDS.items() if key in context)
    what = {
        "missing": "missing",
        "extra_forbidden": "unknown field",
        "union_tag_invalid": "unknown effect",
        "union_tag_not_found": "an effect without its name",
    }.get(item["type"], "not possible")
    remedy = {
        "missing": "add it",
        "extra_forbidden": "check its spelling",
        "union_tag_invalid": "choose one of them",
        "union_tag_not_found": "add 'effect: NAME'",
    }.get(item["type"], _remedy(item))
    shown = item["input"].get("effect") if item["type"] == "union_tag_invalid" else item["input"]
    value = "" if item["type"] == "missing" else shortened(shown)
    return Problem(file, tree.line_of(where), dotted(where), what, value, limit, remedy)


def _remedy(item: Any) -> str:
    """Pydantic's sentence in the words of a YAML file."""
    kind, words = str(item["type"]), str(item["msg"])
    if kind == "tuple_type":
        return "write a list, such as [1.0, 2.0]"
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        return "give its fields, indented below it"
    return words[0].lower() + words[1:]
