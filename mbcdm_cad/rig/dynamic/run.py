"""A run of the dynamic rig: motors under position loops drive the cables, the drum turns a load, sensors record.

Equations are in :mod:`mbcdm_cad.rig.dynamic.plant`, the loop over time in :mod:`mbcdm_cad.rig.dynamic.kernel`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbcdm_cad.rig.chain import chains
from mbcdm_cad.rig.dynamic import kernel, plant, tables
from mbcdm_cad.rig.dynamic.rig import DynamicRig, EncoderSpec
from mbcdm_cad.routes import Floats

LOG_RATE_HZ = 100.0
# Far more than elasticity explains: the position loops no longer control the drum.
GIVE_UP_RAD = 0.05
_ACCOUNTS = ("motor", "load", "rotor_friction", "pulley_friction", "drum_friction", "viscous", "cables")


@dataclass(frozen=True, eq=False)
class DynamicRun:
    """A run at the log's samples: truth and readings of the sensors. Arrays (n,) or (n_inputs or n_cables, n).

    ``motor_Nm`` and ``rotor_rad`` are reflected to the gearhead's output; ``torque_Nm`` is the torque between drum and
    load, averaged over a period of the loops; ``energy_J`` the energy balance of the whole run. ``drum_rad`` is the
    drum's angle at its encoder.
    """

    time_s: Floats
    reference_rad: Floats
    drum_rad: Floats
    payload_rad: Floats
    input_rad: Floats
    torque_Nm: Floats
    motor_Nm: Floats
    rotor_rad: Floats
    tension_N: Floats
    measured_drum_rad: Floats
    measured_input_rad: Floats
    measured_torque_Nm: Floats
    energy_J: dict[str, float]


def run_dynamic(
    rig: DynamicRig,
    reference: Floats,
    torque_Nm: Floats | float = 0.0,
    brake_Nm: Floats | float = 0.0,
    seed: int = 0,
    log_rate_Hz: float = LOG_RATE_HZ,
    give_up_rad: float = GIVE_UP_RAD,
) -> DynamicRun:
    """Run ``reference`` (n, 3), the drum's angle, speed and acceleration at each period of the loops.

    ``torque_Nm`` is what a torque motor applies and ``brake_Nm`` the level of a brake, one value or one a period. The
    same seed gives the same run. It ends early when the drum is off its reference by ``give_up_rad``. ValueError where
    rates do not divide each other.
    """
    n_inputs, n = len(rig.motors), reference.shape[0]
    rate = rig.loops[0].rate_Hz
    steps = _whole(1.0 / rate / rig.step_s, "step_s", "rate_Hz")
    log_every = _whole(rate / log_rate_Hz, "rate_Hz", "log_rate_Hz")
    rng = np.random.default_rng(seed)
    rows = -(-n // log_every)
    log = np.zeros((rows, kernel.LOG_FIRST + 4 * n_inputs + len(rig.cables)))
    account = np.zeros(plant.ACCOUNTS)
    state = chains(
        rig.cables,
        piece_rad=rig.piece_rad,
        transport=rig.transport,
        passed_slip=rig.passed_slip,
        reach_rad=float(np.abs(reference[:, 0]).max()) + 2.0 * give_up_rad,
    )
    noise = rng.standard_normal((n, n_inputs))
    loops = kernel.Loops(
        tables.loop_gains(rig), tables.turns(rig), tables.current_share(rig), tables.encoder_table(rig), noise
    )
    course = kernel.DynamicCourse(
        np.ascontiguousarray(reference, dtype=float),
        _series(torque_Nm, n),
        _series(brake_Nm, n),
        tables.load_row(rig),
        tables.path_table(rig, reference),
    )
    change, done = kernel.run(
        tables.plant(rig),
        state,
        loops,
        course,
        kernel.Clock(rig.step_s, steps, log_every, give_up_rad),
        kernel.Record(log, account),
    )
    rows = -(-done // log_every)
    log = log[:rows]
    time = np.arange(rows) * log_every / rate
    ends = [kernel.LOG_FIRST + k * n_inputs for k in range(5)]
    _, pulley, counts, motor, rotor, tension = np.split(log.T, ends)
    land, payload, torque = log[:, kernel.DRUM], log[:, kernel.PAYLOAD], log[:, kernel.TORQUE]
    # The encoder sits between the cables on the drum and the payload.
    give = rig.compliance
    drum = (
        land if give.land_to_payload == 0.0 else land - give.land_to_encoder / give.land_to_payload * (land - payload)
    )
    return DynamicRun(
        time_s=time,
        reference_rad=reference[:done:log_every, 0],
        drum_rad=drum,
        payload_rad=payload,
        input_rad=pulley,
        torque_Nm=torque,
        motor_Nm=motor,
        rotor_rad=rotor,
        tension_N=tension,
        measured_drum_rad=_read(rig.drum_encoder, time, drum, rng),
        measured_input_rad=counts,
        measured_torque_Nm=torque + rig.torque_noise_Nm * rng.standard_normal(rows),
        energy_J={**dict(zip(_ACCOUNTS, account.tolist(), strict=True)), "stored": float(change)},
    )


def _whole(ratio: float, divisor: str, dividend: str) -> int:
    if ratio < 0.999 or abs(ratio - round(ratio)) > 1e-6 * ratio:
        raise ValueError(f"{divisor} and {dividend} do not divide: their ratio is {ratio:.6g}; choose a whole number")
    return round(ratio)


def _series(value: Floats | float, n: int) -> Floats:
    return np.ascontiguousarray(np.broadcast_to(np.asarray(value, dtype=float), (n,)))


def _read(encoder: EncoderSpec, time: Floats, angle: Floats, rng: np.random.Generator) -> Floats:
    """Readings of an encoder outside the loops: delayed, with noise, in whole counts."""
    seen = np.interp(time - encoder.delay_s, time, angle) + encoder.noise_rad * rng.standard_normal(angle.size)
    step = encoder.resolution_rad
    return seen if step == 0.0 else np.floor(seen / step + 0.5) * step
