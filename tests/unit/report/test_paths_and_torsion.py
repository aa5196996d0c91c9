"""Cable paths and torsional modes in the report and in `mbcdm analyse`."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from mbcdm_cad.design.blocks import Payload
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.loader import load_text, new_design_text
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.turns import plain_modes
from mbcdm_cad.model import to_si
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.report.analysis_report import analyse_design
from mbcdm_cad.report.data import torsion_data
from mbcdm_cad.report.masses import ReflectedInertias
from mbcdm_cad.report.paths import path_data, path_data_or_reason


@pytest.fixture(scope="module")
def drive() -> Drive:
    return load_text(new_design_text("mbcdm")).drive


def test_analyse_prints_paths_and_travel(drive: Drive) -> None:
    found = analyse_design(drive)
    text, data = found.text(), json.loads(json.dumps(found.to_dict(), allow_nan=False))["paths"]
    assert "usable travel -35.25 to +35.25 deg" in text
    for c in data["cables"]:
        assert f"{c['name']:<10} length {c['length_mm']:.2f} mm" in text
        assert f"input contact ({c['input_contact_mm'][0]:.3f}" in text
    assert data["limits_positive"][0]["cause"] == "hard stop"


def test_a_design_without_a_layout_still_has_its_figures(drive: Drive) -> None:
    """No dimensions to lay out: the reason stands in place of the paths."""
    overlapping = replace(drive, centre_distance_mm=12.0)
    paths, why = path_data_or_reason(overlapping)
    assert paths is None and "centre distance" in why, why


def test_no_helix_no_error_of_the_path(drive: Drive) -> None:
    """A helix of (nearly) no lead runs as the pitch circles do."""
    steep, flat = (path_data(BevelLayout(replace(drive, helix_lead_mm=lead))) for lead in (0.87, 1e-6))
    worst = [max(map(abs, data["drum_turn_urad"])) for data in (steep, flat)]
    assert worst[0] > 100 and worst[1] < 1e-3, f"{worst} urad"


def test_real_wraps_turn_the_drum_no_further_than_endless_ones(drive: Drive) -> None:
    d = to_si(drive)
    endless = abs(float(solve_equilibrium(d, 0.91).drum_angle_rad)) * 1e3
    with_wraps = path_data(BevelLayout(drive))["test_turn_mrad"]
    for way in ("positive", "negative"):
        assert len(with_wraps[way]) == 9
        for turn in with_wraps[way]:
            assert 0.8 * endless < abs(turn) <= endless * (1 + 1e-9), f"{turn} mrad, {endless} with endless wraps"
    assert with_wraps["positive"][4] * with_wraps["negative"][4] < 0


def test_torsional_modes_follow_the_inertias(drive: Drive) -> None:
    layout, moving = drive.layout, ReflectedInertias(1e5, {"guide": 2e4}, 1.0, 1.0, 1.0, 1.0, 1.0, (3e3, 3e3))
    found = torsion_data(layout, moving)
    expected = np.sqrt(found["stiffness_Nm_rad"] / 1.2e-4) / (2 * np.pi)
    assert found["cables_alone_Hz"] == pytest.approx(expected)
    # In series with the cables: all that gives between the inputs' encoders and the drum's land.
    assert layout.structure is not None
    before = 1e-6 * sum(c.urad_Nm for c in layout.structure.causes if not (c.in_drum or c.before_input))
    held = np.sqrt(1.0 / (1.0 / found["stiffness_Nm_rad"] + before) / 1.2e-4) / (2 * np.pi)
    assert found["lowest_inputs_held_Hz"] == pytest.approx(held) and held < expected
    heavier = torsion_data(layout, replace(moving, drum_group=4 * 1.2e5 - 2e4))
    assert heavier["lowest_inputs_held_Hz"] == pytest.approx(held / 2)
    assert len(found["inputs_free_Hz"]) == 4, found["inputs_free_Hz"]
    stiff = torsion_data(layout, replace(moving, input_shafts=(1e12, 1e12)))
    near = min(stiff["inputs_free_Hz"], key=lambda f: abs(f - held))
    assert near == pytest.approx(held, rel=1e-5), "inputs too heavy to move are held"


def test_a_payload_swings_on_cables_and_structure(drive: Drive) -> None:
    """So heavy that the drum counts little, it is one mass on all that gives: 0.2 kg at 150 mm, 4.5 g m2."""
    payload = Payload(mass_kg=0.2, distance_mm=150.0)
    heavy = replace(drive, loads=replace(drive.loads, payload=payload))
    modes, turns = plain_modes(heavy.layout), heavy.layout.turns
    one_mass = np.sqrt(turns.felt.sticking_stiffness_Nm_rad / 4.5e-3) / (2 * np.pi)
    assert modes.payload_kg_m2 == pytest.approx(4.5e-3)
    # The drum, with 3 % of the inertia, takes less than that off.
    assert 0.98 * one_mass < modes.lowest_inputs_held_Hz < one_mass, (modes, one_mass)
    assert modes.cables_alone_Hz == plain_modes(drive.layout).cables_alone_Hz
    assert "payload of 0.0045 kg m^2" in analyse_design(heavy).text()


def test_analyse_and_a_report_of_parts_with_the_same_inertias_have_the_same_modes(drive: Drive) -> None:
    bodies, layout = drive.layout.inertias_kg_m2, drive.layout
    passed = {b.name: bodies[b.name] * b.turns_per_drum**2 * 1e9 for b in to_si(drive).routes.passed}
    inputs = tuple(bodies[b.name] * 1e9 for b in to_si(drive).routes.inputs)
    moving = ReflectedInertias(bodies["drum"] * 1e9, passed, 1.0, 1.0, 1.0, 1.0, 1.0, inputs)
    drawn, plain = torsion_data(layout, moving), analyse_design(drive).to_dict()["modes"]
    for name in ("lowest_inputs_held_Hz", "cables_alone_Hz", "inputs_free_Hz"):
        assert drawn[name] == pytest.approx(plain[name], rel=1e-9), name
