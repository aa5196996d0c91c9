"""Torsional modes of the drive: stiffness of the cables by the model, inertias from the parts as drawn."""

from __future__ import annotations

from typing import Any

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.model import to_si
from mbcdm_cad.model.stiffness import sticking_stiffness_Nm_rad, torsional_modes_Hz
from mbcdm_cad.report.masses import ReflectedInertias

_KG_M2 = 1e-9  # of a g mm^2


def torsion_data(drive: Drive, moving: ReflectedInertias) -> dict[str, Any]:
    """Frequencies (Hz) with every wrap sticking: inputs held, and inputs free with pulley and rotor.

    Bodies that cables pass are assumed to turn with the drum. The rigid rotation at 0 Hz of free inputs is left out.
    """
    d = to_si(drive)
    drum = (moving.drum_group + sum(moving.passed_at_drum.values())) * _KG_M2
    inputs = np.array(moving.input_shafts) * _KG_M2
    free = torsional_modes_Hz(d, drum, inputs)
    return {
        "_and_".join(["drum", *moving.passed_at_drum]) + "_g_mm2": drum / _KG_M2,
        "input_shafts_g_mm2": list(moving.input_shafts),
        "stiffness_Nm_rad": float(sticking_stiffness_Nm_rad(d)),
        "lowest_inputs_held_Hz": float(torsional_modes_Hz(d, drum)[0]),
        "inputs_free_Hz": [float(f) for f in free if f > 0.0],
    }
