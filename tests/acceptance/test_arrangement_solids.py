"""Choices of arrangement, tested on solids: setback of the inputs, grooved pulleys, gearheads with three screws."""

from __future__ import annotations

from dataclasses import replace

import pytest

from mbcdm_cad.checks.size import estimated_mass_g
from mbcdm_cad.layouts.loader import load_text, new_design_text
from mbcdm_cad.layouts.miso_bevel.bill import bill
from mbcdm_cad.layouts.miso_bevel.checks.room import box_mm
from mbcdm_cad.layouts.miso_bevel.drive import bevel
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.parts.bill import CABLE
from mbcdm_cad.workshop.interference import answers
from mbcdm_cad.workshop.kernel import validate_faces, validate_solid
from tests.support.interference_of_solids import body, run_of

MESH_MM = 0.05


@pytest.mark.slow
def test_all_choices_together_clash_nowhere_and_weigh_what_was_estimated() -> None:
    drive = bevel(load_text(new_design_text("arranged")).drive)
    drive = replace(
        drive,
        centre_distance_mm=42.0,
        input_setback_mm=1.2,
        helix_lead_mm=0.89,
        input_pulleys=replace(drive.input_pulleys, surface="grooved"),
        gearhead=replace(drive.gearhead, screw_count=3),
        support=replace(drive.support, back_y_mm=drive.support.back_y_mm - 1.2),
    )
    dims = BevelLayout(drive)
    centred = bill(dims)
    solids = {name: spec.part.solid() for name, spec in centred.parts.items() if not name.startswith(CABLE)}
    for name in ("frame", "top_plate", "gearhead", "input_pulley_left", "input_pulley_right"):
        validate_solid(name, solids[name])
        validate_faces(name, solids[name])
    mass = sum(
        solids[item.part].Volume() * item.material.density_g_cm3 * 1e-3 if item.mass_g is None else item.mass_g
        for item in centred.items
    )
    design = BevelLayout(drive)
    assert estimated_mass_g(centred) == pytest.approx(mass, rel=0.01)
    assert box_mm(design)[2] == pytest.approx(drive.drum.hub_face_y_mm - drive.support.back_y_mm)
    run = run_of(dims, {name: body(name, solid, MESH_MM) for name, solid in solids.items()}, (-35.0, 35.0))
    clashes = run.clashes(answers(run, {}, 1))
    assert not clashes, "\n".join(map(str, clashes))
