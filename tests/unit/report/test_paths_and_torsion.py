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
from mbcdm_cad.layouts.turns import Modes, modes_of
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.si import to_si
from mbcdm_cad.model.stiffness import sticking_stiffness_Nm_rad
from mbcdm_cad.report.analysis_report import analyse_design
from mbcdm_cad.report.structure import path_data, path_data_or_reason


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
    layout = BevelLayout(drive)
    stiffness = float(sticking_stiffness_Nm_rad(to_si(drive)))
    turns = {body.name: body.turns_per_drum for body in to_si(drive).routes.passed}

    def modes(drum_kg_m2: float, inputs_kg_m2: float = 3e-6) -> Modes:
        inputs = dict.fromkeys((body.name for body in to_si(drive).routes.inputs), inputs_kg_m2)
        own = BevelLayout(drive)
        own.__dict__["inertias_kg_m2"] = {"drum": drum_kg_m2, "guide": 2e-5 / turns["guide"] ** 2} | inputs
        return modes_of(own)

    found = modes(1e-4)
    expected = np.sqrt(stiffness / 1.2e-4) / (2 * np.pi)
    assert found.cables_alone_Hz == pytest.approx(expected)
    # In series with the cables: all that gives between the inputs' encoders and the drum's land.
    assert layout.structure is not None
    before = 1e-6 * sum(c.urad_Nm for c in layout.structure.causes if not (c.in_drum or c.before_input))
    held = np.sqrt(1.0 / (1.0 / stiffness + before) / 1.2e-4) / (2 * np.pi)
    assert found.lowest_inputs_held_Hz == pytest.approx(held) and held < expected
    assert modes(4 * 1.2e-4 - 2e-5).lowest_inputs_held_Hz == pytest.approx(held / 2)
    assert len(found.inputs_free_Hz) == 4, found.inputs_free_Hz
    near = min(modes(1e-4, 1e3).inputs_free_Hz, key=lambda f: abs(f - held))
    assert near == pytest.approx(held, rel=1e-5), "inputs too heavy to move are held"


def test_a_payload_swings_on_cables_and_structure(drive: Drive) -> None:
    """So heavy that the drum counts little, it is one mass on all that gives: 0.2 kg at 150 mm, 4.5 g m2."""
    payload = Payload(mass_kg=0.2, distance_mm=150.0)
    heavy = replace(drive, loads=replace(drive.loads, payload=payload))
    modes, turns = modes_of(heavy.layout), heavy.layout.turns
    one_mass = np.sqrt(turns.felt.sticking_stiffness_Nm_rad / 4.5e-3) / (2 * np.pi)
    assert modes.payload_kg_m2 == pytest.approx(4.5e-3)
    # The drum, with 3 % of the inertia, takes less than that off.
    assert 0.98 * one_mass < modes.lowest_inputs_held_Hz < one_mass, (modes, one_mass)
    assert modes.cables_alone_Hz == modes_of(drive.layout).cables_alone_Hz
    assert "payload of 0.0045 kg m^2" in analyse_design(heavy).text()


def test_a_design_without_parts_has_no_modes_and_says_why(drive: Drive, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mbcdm_cad.parts.drum_sector.part.DrumSector._terms", lambda self: 1 / 0)
    found = analyse_design(replace(drive, name="without"))
    assert found.modes is None and "No modes: the dimensions have no solution: division by zero" in found.text()
    assert found.to_dict()["modes"] is None
