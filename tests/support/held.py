"""The rig with inputs that all but hold the drive under a load of both signs."""

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.rig.experiment import Experiment
from mbcdm_cad.rig.quasistatic import simulate
from mbcdm_cad.routes import Floats


def held_rad(drive: Drive, load_Nm: float, structure: bool = True) -> Floats:
    """Angle of the drum in a run without cable transport.

    ``structure``: with what gives besides the cables, the motors being held, in place of the input pulleys.
    """
    data = {
        "name": "held",
        "seed": 1,
        "duration_s": 4.0,
        "sample_rate_Hz": 50.0,
        "motion": {"shape": "triangle", "amplitude_mrad": 0.1, "period_s": 4.0},
        "load": {"kind": "torque_motor", "wave": "sine", "levels_Nm": [load_Nm], "wave_period_s": 4.0},
        "sensors": {"input_at": "motor" if structure else "pulley"},
        "physics": {"cable_transport": False, "structure": structure},
    }
    return np.asarray(simulate(drive, Experiment.model_validate(data)).drum_rad)
