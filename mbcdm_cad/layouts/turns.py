"""How far a load turns the drive, and its modes: by the cables alone, as the drum's encoder sees it, at the payload.

The one place where cables and structure are put together. Cables as in
:func:`mbcdm_cad.model.stiffness.drum_backlash`, with memory of the friction; the structure
(:mod:`mbcdm_cad.layouts.structure`) in series with them, linear.
"""

from dataclasses import asdict, dataclass, replace
from math import inf
from typing import Any

import numpy as np

from mbcdm_cad.layouts.base import Layout, NoFigureError
from mbcdm_cad.layouts.structure import lash_rad, structure_of
from mbcdm_cad.model.equations import BACKLASH_RAD, BACKLASH_TORQUE_NM
from mbcdm_cad.model.stiffness import (
    RIGID,
    Reading,
    TurningInertias,
    drum_backlash,
    implied_modulus_Pa,
    sticking_stiffness_Nm_rad,
    torsional_modes_Hz,
)
from mbcdm_cad.model.structure.causes import Cause, sigma_urad_Nm, sticking, urad_Nm


@dataclass(frozen=True)
class TurnAt:
    """What one place turns by under the load, the inputs held by their encoders unless the place says otherwise.

    ``structure_urad_Nm``: turn by all but the cables over the load. ``turn_mrad``: at first loading, from no load, with
    the standard deviation that the structure's figures give it; ``swing_mrad``: at a full reversal.
    ``stiffness_Nm_rad``: the load over ``turn_mrad``; ``sticking_stiffness_Nm_rad``: for small motion, every wrap
    sticking.
    """

    structure_urad_Nm: float
    turn_mrad: float
    turn_sigma_mrad: float
    swing_mrad: float
    stiffness_Nm_rad: float
    sticking_stiffness_Nm_rad: float


@dataclass(frozen=True)
class DriveTurns:
    """DriveTurns at one load. Where ``no_structure`` gives a reason, only ``cables`` has figures.

    ``cables``: the drum with all else rigid, as in the paper; ``drum_encoder``: as an encoder on the drum's shaft sees
    it; ``payload``: at the hub's face; ``motors_held``: there, the motors' shafts held in place of the inputs.
    """

    load_Nm: float
    cables: TurnAt
    drum_encoder: TurnAt | None = None
    payload: TurnAt | None = None
    motors_held: TurnAt | None = None
    no_structure: str = ""

    @property
    def felt(self) -> TurnAt:
        """At the payload; where the structure has no figures, all of it counts as rigid."""
        return self.payload or self.cables

    def to_dict(self) -> dict[str, Any]:
        """Every place with its figures, ready for JSON."""
        places = asdict(self)
        return {name: places[name] for name in ("cables", "drum_encoder", "payload", "motors_held")}


def turns_of(layout: Layout) -> DriveTurns:
    """Turn and swing of a design at its test torque, worked out once. Raises as :func:`turns_at`."""
    return layout.once("turns", lambda one: turns_at(one, one.drive.loads.test_torque_Nm))


def turns_at(layout: Layout, load_Nm: float) -> DriveTurns:
    """The turns of a design at a load above 0. Raises ``ModelError`` where the geometry leaves no free span."""
    d = layout.si
    found = drum_backlash(d, load_Nm)
    turn, swing = float(found.first_loading_rad), float(found.reversal_swing_rad)
    held_Nm_rad = float(sticking_stiffness_Nm_rad(d))

    def place(causes: tuple[Cause, ...] = (), play_rad: float = 0.0) -> TurnAt:
        give = urad_Nm(causes) * 1e-6
        turned = turn + give * load_Nm + play_rad / 2.0
        return TurnAt(
            urad_Nm(causes),
            turned * 1e3,
            sigma_urad_Nm(causes) * load_Nm * 1e-3,
            (swing + 2.0 * give * load_Nm + play_rad) * 1e3,
            load_Nm / turned,
            1.0 / (1.0 / held_Nm_rad + urad_Nm(sticking(causes)) * 1e-6),
        )

    try:
        structure = structure_of(layout)
    except NoFigureError as missing:
        return DriveTurns(load_Nm, place(), no_structure=str(missing))
    if structure is None:
        return DriveTurns(load_Nm, place(), no_structure=f"{layout.name} has no figures of its structure")
    held, free = (lash_rad(layout.drive, motors_held) for motors_held in (False, True))
    return DriveTurns(
        load_Nm,
        cables=place(),
        drum_encoder=place(structure.at_encoder, held),
        payload=place(structure.at_payload, held),
        motors_held=place(structure.causes, free),
    )


def implied_moduli_GPa(layout: Layout, preload_N: float | None = None) -> dict[str, float]:
    """E that the paper's backlash implies at the drum's encoder, cables and structure counted, by reading of it.

    ``preload_N``: of all cables in place of the design's. Empty where the structure has no figures.
    """
    at = turns_of(layout).drum_encoder
    if at is None:
        return {}
    d = layout.si
    if preload_N is not None:
        d = d.with_(preload_N=np.full(d.n_cables, preload_N))
    measured, give = (BACKLASH_RAD, BACKLASH_TORQUE_NM), at.structure_urad_Nm * 1e-6
    readings: tuple[Reading, ...] = ("reversal", "single")
    return {reading: implied_modulus_Pa(d, *measured, reading, "all_cables", give) / 1e9 for reading in readings}


@dataclass(frozen=True)
class Modes:
    """Torsional modes, Hz, every wrap sticking: rotors, pulleys, drum and payload as rigid bodies.

    ``lowest_inputs_held_Hz``: with the inputs held by their encoders; ``cables_alone_Hz``: that of the drum without a
    payload where all but the cables is rigid, as in the paper. ``inputs_free_Hz``: all, with the rotors free.
    """

    lowest_inputs_held_Hz: float
    cables_alone_Hz: float
    inputs_free_Hz: tuple[float, ...]
    payload_kg_m2: float


def modes_of(layout: Layout) -> Modes:
    """Modes of a design with its payload; its structure counts where it has figures, bodies passed turn with the drum.

    ``NoFigureError`` where its parts have no form.
    """
    bodies, routes = layout.inertias_kg_m2, layout.routed.routes
    drum_kg_m2 = bodies[routes.drum.name] + sum(bodies[b.name] * b.turns_per_drum**2 for b in routes.passed)
    pulleys_kg_m2 = [bodies[body.name] for body in routes.inputs]
    drive, d = layout.drive, layout.si
    payload_kg_m2 = drive.loads.carried.about_axis_kg_m2
    try:
        structure = structure_of(layout)
    except NoFigureError:
        structure = None
    chain = RIGID if structure is None else structure.chain
    free = TurningInertias(drum_kg_m2, payload_kg_m2, pulleys_kg_m2, drive.rotor_at_input_kg_m2)
    by_motors = structure is not None and structure.motor_encoders
    held = replace(free, rotors=inf) if by_motors else replace(free, pulleys=inf, rotors=0.0)
    return Modes(
        lowest_inputs_held_Hz=float(torsional_modes_Hz(d, held, chain)[0]),
        cables_alone_Hz=float(torsional_modes_Hz(d, TurningInertias(drum_kg_m2))[0]),
        inputs_free_Hz=tuple(float(f) for f in torsional_modes_Hz(d, free, chain) if f > 0.0),
        payload_kg_m2=payload_kg_m2,
    )
