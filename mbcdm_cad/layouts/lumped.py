"""What gives and what rubs besides the cables, lumped at the axes: figures for rigs and robot files.

The compliance of each part is that of :func:`structure_of`, the shares and torques of friction those of
``Layout.losses``. Slip on the wraps is not here.
"""

from dataclasses import dataclass
from math import inf

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.model.structure.causes import sticking, urad_Nm
from mbcdm_cad.routes import Floats

_URAD = 1e-6


@dataclass(frozen=True)
class Compliance:
    """Turn by the parts for 1 N m on the payload, rad/(N m): between the cables on the drum and the drum's encoder, and
    from there to the payload; ``before_inputs_Nm_rad``: stiffness at each input between motor and input encoder.
    """

    land_to_encoder: float = 0.0
    encoder_to_payload: float = 0.0
    before_inputs_Nm_rad: float = inf

    @property
    def land_to_payload(self) -> float:
        """Both together."""
        return self.land_to_encoder + self.encoder_to_payload


@dataclass(frozen=True, eq=False)
class PartsFriction:
    """Dry friction. Shares of its tension that each cable loses on its input, and on passed bodies and drum.

    Torques in N m: bearings at the drum, and at each input; a gearhead without load, at its output; a motor.
    """

    input_share: Floats
    drum_share: Floats
    drum_bearings_Nm: float
    input_bearings_Nm: tuple[float, ...]
    gear_idle_Nm: float
    motor_Nm: float


@dataclass(frozen=True)
class AxisFriction:
    """Friction of cables and bearings under the preload, gearheads without load included, at each axis; N m."""

    drum_Nm: float
    inputs_Nm: tuple[float, ...]


def axis_friction(drive: Drive) -> AxisFriction:
    """Dry friction at the drum, with the bodies that cables pass, and at each input up to its gearhead's output."""
    parts, names = friction_of(drive), drive.input_names
    drum, inputs = parts.drum_bearings_Nm, [bearings + parts.gear_idle_Nm for bearings in parts.input_bearings_Nm]
    for cable, at_input, at_drum in zip(drive.cables, parts.input_share, parts.drum_share, strict=True):
        drum += float(at_drum) * cable.preload_N * cable.drum_radius_mm * 1e-3
        inputs[names.index(cable.input_name)] += float(at_input) * cable.preload_N * cable.input_radius_mm * 1e-3
    return AxisFriction(drum, tuple(inputs))


def compliance_of(drive: Drive) -> Compliance:
    """The compliance of the drive's parts. A layout that states none counts as rigid.

    Raises ``NoFigureError`` or ``ValueError`` where a part has no metal that carries the load.
    """
    structure = structure_of(layout_of(drive))
    if structure is None:
        return Compliance()
    encoder, payload = (urad_Nm(sticking(causes)) * _URAD for causes in (structure.at_encoder, structure.at_payload))
    before = structure.motor_urad_Nm - structure.payload_urad_Nm
    # 1 N m at the payload loads the inputs evenly.
    turns = np.array([body.turns_per_drum for body in layout_of(drive).routed.routes.inputs])
    torques = 1.0 / (turns.size * turns)
    stiffness = float((torques**2).sum()) / (before * _URAD) if before > 0.0 else inf
    return Compliance(encoder, payload - encoder, stiffness)


def friction_of(drive: Drive) -> PartsFriction:
    """The friction of the drive's parts, that of bearings under the preload alone."""
    train = layout_of(drive).losses
    tension = np.array([cable.preload_N for cable in drive.cables])
    at_inputs, at_drum = [0.0] * len(drive.input_names), 0.0
    for pair in train.bearings:
        torque = float(pair.torque_Nm(tension))
        if pair.input_index is None:
            at_drum += abs(pair.turns) * torque
        else:
            at_inputs[pair.input_index] += torque
    shares = [np.zeros(tension.size), np.zeros(tension.size)]
    for bend in train.rope:
        shares[bend.on_input] += bend.share
    drum, inputs = shares
    return PartsFriction(inputs, drum, at_drum, tuple(at_inputs), train.gear_idle_Nm, train.motor_idle_Nm)
