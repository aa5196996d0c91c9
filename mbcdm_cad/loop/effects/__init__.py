"""The library of effects: each file of this folder that has a function ``offer`` is found without being listed."""

import pkgutil
from collections.abc import Sequence
from functools import cache
from importlib import import_module

import numpy as np

from mbcdm_cad.design.blocks import AsBuilt
from mbcdm_cad.loop.effect import Effect, Offer
from mbcdm_cad.loop.effects.creep_at_rest import AT_REST
from mbcdm_cad.loop.prepare.setup import Floats, Prepared
from mbcdm_cad.measurement.schema import MOTION
from mbcdm_cad.model.si import DriveSI, ModelError


@cache
def offers() -> tuple[Offer, ...]:
    """What each file of this folder offers, in the order of the files' names."""
    names = sorted(module.name for module in pkgutil.iter_modules(__path__))
    return tuple(import_module(f"{__name__}.{name}").offer for name in names)


def library(d: DriveSI | None, p: Prepared) -> list[Effect]:
    """Every effect that a drive (None: only the ratio is known) and a run allow."""
    return [effect for offer in offers() for effect in offer(d, p)]


def known_effects(d: DriveSI, p: Prepared, found: Sequence[AsBuilt]) -> list[tuple[Effect, Floats]]:
    """The effects of ``Drive.as_built`` as the loop has them, with their values, for one run.

    An effect that the run cannot show (no torque column, a run of another kind) is left out. Raises ModelError for a
    form or figure that the loop does not have for this drive.
    """
    if not found:
        return []
    offered = library(d, p)
    offered += [form for effect in offered if effect.richer for form in effect.richer() if form.form != effect.form]
    known = []
    for k, entry in enumerate(found):
        same = [e for e in offered if (e.name, e.stage) == (entry.name, entry.stage) and e.form == entry.form]
        same = [e for e in same if not entry.cables or e.cables == entry.cables]
        if not same and (p.load_Nm is None or p.run.kind != MOTION or entry.form.endswith(AT_REST)):
            continue
        if not same:
            # Of sums of terms the shortest stands for all.
            forms = sorted({f"{e.name}: {e.form}" + (f", stage {e.stage}" if e.stage else "") for e in library(d, p)})
            raise ModelError(
                f"as_built[{k}]: no effect {entry.name!r} of form {entry.form!r}, stage {entry.stage or 'none'}; "
                f"there are {'; '.join(forms)}"
            )
        values = {p.name: p.default for p in same[0].parameters if p.default is not None}
        values |= {value.name: value.value for value in entry.values}
        wanted = [parameter.name for parameter in same[0].parameters]
        if missing := [name for name in wanted if name not in values]:
            raise ModelError(f"as_built[{k}]: {entry.name} lacks {', '.join(missing)}; give {', '.join(wanted)}")
        known.append((same[0], np.array([values[name] for name in wanted])))
    return known
