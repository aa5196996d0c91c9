"""Friction of bearings and seals, and of a brake that holds and lets go."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import AliasChoices, Field

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.block import Drag, FrictionMilli, Stiffness
from mbcdm_cad.rig.effects.base import RigEffect
from mbcdm_cad.rig.quasistatic.load import brake

PASSED = AliasChoices("passed_mNm", "guide_mNm")


class BearingFriction(RigEffect):
    """Friction torque of bearings.

    Friction in bearings of the drum and of passed bodies: the cables carry it, the torque sensor does not see it.

    Coulomb torque against the motion, with a short elastic start (``presliding_urad`` of drum angle from side to side).
    A passed body turns r_o/r times as fast as the drum, so its drag counts that many times at the drum. Near standstill
    there is ``stribeck_mNm`` more, which falls as exp(-|w|/``stribeck_mrad_s``) with the drum's speed w.
    """

    effect: Literal["bearing_friction"]
    drum_mNm: FrictionMilli = 0.0
    passed_mNm: Annotated[FrictionMilli, Field(validation_alias=PASSED)] = 0.0
    presliding_urad: Annotated[float, Field(gt=0.0, le=1e4)] = 100.0
    stribeck_mNm: FrictionMilli = 0.0
    stribeck_mrad_s: Annotated[float, Field(gt=0.0, le=1e5)] = 50.0

    def apply(self, bench: Bench) -> None:
        turns = sum(abs(body.turns_per_drum) for body in bench.routes.passed)
        torque = (self.drum_mNm + self.passed_mNm * turns) * 1e-3
        speed = np.gradient(bench.drum_rad, bench.time_s)
        more = self.stribeck_mNm * 1e-3
        limit = torque + more * np.exp(-np.abs(speed) / (self.stribeck_mrad_s * 1e-3))
        bench.hidden_Nm.append(brake(bench.drum_rad, limit, self.presliding_urad * 1e-6))
        bench.tell("friction", parameters={"torque_Nm": torque} | ({"stribeck_Nm": more} if more else {}))


class ViscousDrag(RigEffect):
    """Viscous drag at the drum.

    Grease and eddy currents between drum and torque sensor: a torque proportional to the drum's speed.
    """

    effect: Literal["viscous_drag"]
    drag_Nms: Drag

    def apply(self, bench: Bench) -> None:
        bench.hidden_Nm.append(self.drag_Nms * np.gradient(bench.drum_rad, bench.time_s))
        bench.tell("delay", cause="viscous_drag", parameters={"drag_Nms": self.drag_Nms})


class BrakeStickSlip(RigEffect):
    """Stick-slip of the brake.

    A brake that sticks: it winds up through its own stiffness to a static torque, then drops (rig/load.py).

    The torque sensor measures all of it, so nothing is left to explain; but it drives the friction of the cables.
    """

    effect: Literal["brake_stick_slip"]
    static_share: Annotated[float, Field(gt=1.0, lt=2.0)] = 1.2
    scatter: Annotated[float, Field(ge=0.0, le=0.2)] = 0.03
    stiffness_Nm_rad: Stiffness = 500.0

    def apply(self, bench: Bench) -> None:
        n = bench.time_s.size
        share = self.static_share * (1.0 + self.scatter * bench.rng.uniform(-1.0, 1.0, n))
        bench.stick_slip = np.stack([np.maximum(share, 1.0), np.full(n, self.stiffness_Nm_rad)], axis=1)
        bench.tell("brake_stick_slip", in_vocabulary=False, seen=False, parameters={"static_share": self.static_share})
