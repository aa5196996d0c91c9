"""The rig's figures as the tables that the compiled loops read."""

from __future__ import annotations

from math import exp, pi

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.rig.dynamic import plant as columns
from mbcdm_cad.rig.dynamic.inertias import inertias
from mbcdm_cad.rig.dynamic.rig import DynamicRig, input_turns
from mbcdm_cad.routes import Floats

# Half the step of the difference quotient for an extra path's slope, rad.
SLOPE_RAD = 1e-5


def input_of(rig: DynamicRig) -> NDArray[np.int64]:
    """For each cable the number of its input."""
    return np.array([c.input_index for c in rig.cables], dtype=np.int64)


def load_row(rig: DynamicRig) -> Floats:
    """The load's constants, in the order of :mod:`mbcdm_cad.rig.dynamic.kernel`."""
    load = rig.load
    return np.array(
        [load.inertia_kg_m2, load.static_ratio, load.static_speed_rad_s, load.unbalance_Nm, load.unbalance_angle_rad]
    )


def current_share(rig: DynamicRig) -> Floats:
    """Share of its error that each current loop removes in a step."""
    return np.array([1.0 - exp(-2.0 * pi * motor.current_bandwidth_Hz * rig.step_s) for motor in rig.motors])


def loop_gains(rig: DynamicRig) -> Floats:
    """A row of gains for each input."""
    return np.array([loop.gains() for loop in rig.loops])


def turns(rig: DynamicRig) -> Floats:
    """Turns of each input for one of the drum."""
    return np.array(input_turns(rig.drive))


def encoder_table(rig: DynamicRig) -> Floats:
    """Resolution and noise in rad, delay in periods of the loops."""
    rate = rig.loops[0].rate_Hz
    return np.array([[e.resolution_rad, e.noise_rad, round(e.delay_s * rate)] for e in rig.encoders])


def input_table(rig: DynamicRig) -> Floats:
    """Rotor, gearhead and pulley of each input, in the order of :mod:`mbcdm_cad.rig.dynamic.plant`."""
    moved = inertias(rig.drive)
    table = np.zeros((len(rig.motors), columns.INPUT_COLUMNS))
    for i, (motor, gear) in enumerate(zip(rig.motors, rig.gearheads, strict=True)):
        N = gear.ratio
        table[i, columns.ROTOR] = motor.rotor_inertia_kg_m2 * N**2
        table[i, columns.DRAG] = motor.coulomb_Nm * N + gear.drag_Nm
        table[i, columns.LOSS] = gear.loss_share
        table[i, columns.VISCOUS] = motor.viscous_Nms * N**2
        table[i, columns.STIFFNESS] = gear.stiffness_Nm_rad
        table[i, columns.LASH] = gear.lash_rad
        table[i, columns.MESH] = gear.mesh_error_rad
        table[i, columns.MESH_ORDER] = gear.mesh_per_motor_turn * N
        table[i, columns.COGGING] = motor.cogging_Nm * N
        table[i, columns.COGGING_ORDER] = motor.cogging_per_turn * N
        table[i, columns.COGGING_PHASE] = motor.cogging_phase_rad
        table[i, columns.PULLEY_DRAG] = rig.input_drag_Nm
        if rig.friction is not None:
            table[i, columns.PULLEY_DRAG] += rig.friction.input_bearings_Nm[i]
        table[i, columns.PULLEY] = moved.inputs_kg_m2[i]
    return table


def cable_table(rig: DynamicRig) -> Floats:
    """Sense, radii in m, stiffness of the free span in N/m and shares of friction of each cable."""
    table = np.zeros((len(rig.cables), columns.DRUM_SHARE + 1))
    for row, c in zip(table, rig.cables, strict=True):
        row[: columns.INPUT_SHARE] = c.sigma, c.input_radius_m, c.drum_radius_m, c.stiffness_N / c.free_span_m
    if rig.friction is not None:
        table[:, columns.INPUT_SHARE], table[:, columns.DRUM_SHARE] = rig.friction.input_share, rig.friction.drum_share
    return table


def drum_row(rig: DynamicRig) -> Floats:
    """Inertia, drag and viscous friction at drum and passed bodies; inertia of the load; stiffness of the parts; the
    friction of the bearings by speed and load."""
    moved = inertias(rig.drive)
    turns = sum(abs(body.turns_per_drum) for body in moved.routes.passed)
    drag = rig.load.bearing_drag_Nm + rig.passed_drag_Nm * turns
    drag += rig.friction.drum_bearings_Nm if rig.friction is not None else 0.0
    give = rig.compliance.land_to_payload
    stiffness = 1.0 / give if give > 0.0 else 0.0
    drum = moved.drum_and_passed_kg_m2
    load = rig.load
    laws = (
        load.bearing_stribeck_Nm,
        load.bearing_stribeck_rad_s,
        load.bearing_driving_share,
        load.bearing_driven_share,
    )
    return np.array([drum, drag, load.bearing_viscous_Nms, load.inertia_kg_m2, stiffness, *laws])


def path_table(rig: DynamicRig, reference: Floats) -> Floats:
    """Extra path of each cable at the reference and its slopes over drum and input, (n, n_cables, 3) or (0, ...)."""
    n, n_cables = (reference.shape[0] if rig.paths else 0), len(rig.cables)
    table = np.zeros((n, n_cables, 3))
    if not rig.paths:
        return table
    drum = reference[:, 0]
    inputs = turns(rig)[:, None] * drum
    for of in rig.paths:
        table[:, :, 0] += of(inputs, drum).T
        table[:, :, 1] += (of(inputs, drum + SLOPE_RAD) - of(inputs, drum - SLOPE_RAD)).T / (2.0 * SLOPE_RAD)
        # Each cable's path depends on its own input only, so all inputs may be moved together.
        table[:, :, 2] += (of(inputs + SLOPE_RAD, drum) - of(inputs - SLOPE_RAD, drum)).T / (2.0 * SLOPE_RAD)
    return table


def plant(rig: DynamicRig) -> columns.Plant:
    """All tables of the plant."""
    return columns.Plant(input_table(rig), cable_table(rig), input_of(rig), drum_row(rig))
