"""Torsional modes of the drive: cables by the model, structure by cause, inertias from the parts as drawn."""

from __future__ import annotations

from typing import Any

from mbcdm_cad.layouts.base import Layout
from mbcdm_cad.layouts.turns import modes_of
from mbcdm_cad.model import to_si
from mbcdm_cad.model.stiffness import sticking_stiffness_Nm_rad
from mbcdm_cad.report.masses import ReflectedInertias

_KG_M2 = 1e-9  # of a g mm^2


def torsion_data(layout: Layout, moving: ReflectedInertias) -> dict[str, Any]:
    """Frequencies (Hz) with every wrap sticking: inputs held, and inputs free with pulley and rotor.

    Bodies that cables pass are assumed to turn with the drum. The rigid rotation at 0 Hz of free inputs is left out.
    """
    drum = moving.drum_group + sum(moving.passed_at_drum.values())
    found = modes_of(layout, drum * _KG_M2, [shaft * _KG_M2 for shaft in moving.input_shafts])
    return {
        "_and_".join(["drum", *moving.passed_at_drum]) + "_g_mm2": drum,
        "input_shafts_g_mm2": list(moving.input_shafts),
        "rotor_at_input_g_mm2": layout.drive.rotor_at_input_kg_m2 / _KG_M2,
        "payload_g_mm2": found.payload_kg_m2 / _KG_M2,
        "stiffness_Nm_rad": float(sticking_stiffness_Nm_rad(to_si(layout.drive))),
        "lowest_inputs_held_Hz": found.lowest_inputs_held_Hz,
        "cables_alone_Hz": found.cables_alone_Hz,
        "inputs_free_Hz": list(found.inputs_free_Hz),
    }
