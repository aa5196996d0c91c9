"""What the parts besides the cables do to a run as its encoders see it: give and friction that the design states."""

from __future__ import annotations

from math import exp, hypot

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.structure import input_play_rad, sigma_urad_Nm, urad_Nm
from mbcdm_cad.measurement.run import PartsSeen
from mbcdm_cad.measurement.schema import CountedParts
from mbcdm_cad.model.losses import friction

_URAD = 1e-6


def parts_seen(drive: Drive, counted: CountedParts, motor_side: bool) -> PartsSeen:
    """Give, friction and play of a drive's parts between the encoders of a run.

    ``motor_side``: whether the inputs' encoders sit before the gearheads. A part without a figure counts as rigid.
    """
    give, sigma = _give_urad_Nm(drive, counted.output_at == "payload", motor_side) if counted.structure else (0.0, 0.0)
    torque, spread = drum_friction_Nm(drive) if counted.losses else (0.0, 0.0)
    play = input_play_rad(drive, motors_held=True) if counted.structure and motor_side else 0.0
    return PartsSeen(give * _URAD, sigma * _URAD, torque, exp(spread / torque) if torque else 1.0, play)


def _give_urad_Nm(drive: Drive, payload: bool, motor_side: bool) -> tuple[float, float]:
    """Turn of the reading for 1 N m, with its standard deviation."""
    try:
        structure = drive.layout.structure
    except NoFigureError:
        return 0.0, 0.0
    if structure is None:
        return 0.0, 0.0
    seen = [c for c in (structure.causes if motor_side else structure.at_payload) if payload or c.at_encoder]
    return urad_Nm(seen), sigma_urad_Nm(seen)


def drum_friction_Nm(drive: Drive) -> tuple[float, float]:
    """Friction at the drum between the inputs and the load, with its standard deviation.

    Cables that bend on drum and passed bodies, and the bearings of these, under the preload. What rubs at the inputs
    their encoders do not see.
    """
    train = drive.layout.losses
    tension = np.array([cable.preload_N for cable in drive.cables])
    shares = sum((bend.share for bend in train.rope if not bend.on_input), np.zeros(tension.size))
    rope = float((shares * tension * train.d.drum_radius_m).sum())
    pairs = [pair for pair in train.bearings if pair.input_index is None]
    bearings = float(sum(abs(pair.turns) * pair.torque_Nm(tension) for pair in pairs))
    of_rope = friction.FIBRE_SIGMA if train.fibre else friction.ROPE_SIGMA
    return rope + bearings, hypot(rope * of_rope, bearings * friction.BEARING_SIGMA)
