"""The library of effects: each file of this folder that has a function ``offer`` is found without being listed."""

from __future__ import annotations

import pkgutil
from functools import cache
from importlib import import_module

from mbcdm_cad.loop.effect import Effect, Offer
from mbcdm_cad.loop.prepare.prepared import Prepared
from mbcdm_cad.model.si import DriveSI


@cache
def offers() -> tuple[Offer, ...]:
    """What each file of this folder offers, in the order of the files' names."""
    names = sorted(module.name for module in pkgutil.iter_modules(__path__))
    return tuple(import_module(f"{__name__}.{name}").offer for name in names)


def library(d: DriveSI | None, p: Prepared) -> list[Effect]:
    """Every effect that a drive (None: only the ratio is known) and a run allow."""
    return [effect for offer in offers() for effect in offer(d, p)]
