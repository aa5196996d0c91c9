"""docs/loop-effects.md: every effect, form and figure that the library of the loop offers.

python -m tests.effects_page > docs/loop-effects.md
"""

import re
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.loop.effect import Effect
from mbcdm_cad.loop.effects import library
from mbcdm_cad.loop.prepare.prepared import prepare
from mbcdm_cad.measurement.run import Run
from tests.support.reference import ROOT

HEAD = """# Effects that the loop knows

Written by `make docs` from `mbcdm_cad/loop/effects`; do not edit by hand. An effect has a name, where it needs one a
stage of the chain, and one or more forms: physical causes with the same or nearly the same signature. The
[loop](loop-method.md) reports the form that fits best and lists those that fit as well under `equivalent`. A new effect
is one file ([worked example](worked-example-new-effect.md)).

| name | stages | forms | figures | where to look | what separates it |
| --- | --- | --- | --- | --- | --- |"""
# What stands for one of several alike, so that a row names it once.
ALIKE = (
    (r"\bcable_\d\b", "a cable"),
    (r"\b(the )?input[_ ](left|right)\b", "an input"),
    (r"in (the \w+ direction|both directions)", "in both directions or in one"),
)


def offered() -> list[Effect]:
    """What is tried on runs with a load, with and without a temperature, and of drives of which the ratio is known."""
    t = np.arange(0.0, 40.0, 0.05)
    angle = 0.45 * np.sin(2.0 * np.pi * t / 8.0)
    run = Run(t, np.stack([9.0 * angle, 9.0 * angle]), angle, 0.5 * np.cos(t), 20.0 + 0.1 * t)
    one = replace(run, input_rad=run.input_rad[:1], input_names=("input",))
    d, spur = (layout_of(load_design(ROOT / "params" / f"{name}.yaml").drive).si for name in ("mbcdm", "siso_spur"))
    ways = [(d, run), (d, replace(run, temperature_C=None)), (spur, one), (None, one)]
    found: list[Effect] = []
    for drive, each in [*ways, (None, replace(one, load_Nm=None))]:
        # Of the other layout only what the first does not have: its cables and inputs have other names.
        known = {effect.name for effect in found} if drive is spur else ()
        found += [effect for effect in library(drive, prepare(each, 9.0)[1]) if effect.name not in known]
    return found


def page() -> str:
    """The page, one row a name."""
    groups: dict[str, list[Effect]] = {}
    for effect in offered():
        groups.setdefault(effect.name, []).append(effect)
    return "\n".join([HEAD, *(_row(name, some) for name, some in sorted(groups.items())), ""])


def _row(name: str, effects: list[Effect]) -> str:
    # A change has as many forms and places to look at as what changes: those of the first say enough.
    few = effects[:1] if name == "change" else effects
    forms: dict[str, list[str]] = {}
    for effect in few:
        forms.setdefault(effect.physics, []).append(effect.form)
    every = [*effects, *(form for effect in effects if effect.richer for form in effect.richer())]
    cells = [", ".join(dict.fromkeys(e.stage for e in effects if e.stage))]
    cells += ["; ".join(f"{_once(some)}: {_once([physics])}" for physics, some in forms.items())]
    cells += [_once(f"`{figure.name}`" for effect in every for figure in effect.reported())]
    cells += [_once(e.where_to_look for e in few), _once(e.separate_by for e in few)]
    return f"| `{name}` | " + " | ".join(cells) + " |"


def _once(words: Iterable[str]) -> str:
    """The words, each once."""
    found = [word.replace("|", "or") for word in words]
    for one, shared in ALIKE:
        found = [re.sub(one, shared, word) for word in found]
    return "; ".join(dict.fromkeys(found))


if __name__ == "__main__":
    print(page(), end="")
