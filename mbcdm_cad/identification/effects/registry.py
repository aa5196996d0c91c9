"""All effects that the loop knows. A new one is a file of this folder with an ``offer``, and its line here."""

from __future__ import annotations

from mbcdm_cad.identification.effects import (
    cable_state,
    drift,
    lash,
    once_per_rev,
    ratio_error,
    ripple,
    slip_step,
    speed,
    stiffness_error,
    winding_history,
)
from mbcdm_cad.identification.effects.base import Effect
from mbcdm_cad.identification.prepared import Prepared
from mbcdm_cad.model.si import DriveSI

OFFERS = (
    once_per_rev.offer, ratio_error.offer, stiffness_error.offer, cable_state.offer, speed.offer, lash.offer,
    drift.offer, winding_history.offer, slip_step.offer, ripple.offer,
)  # fmt: skip


def library(d: DriveSI | None, p: Prepared) -> list[Effect]:
    """Every effect that a drive and a run allow."""
    return [effect for offer in OFFERS for effect in offer(d, p)]
