"""The losses in `analyse`: text and JSON carry the same figures, within 80 columns, for every kind of layout."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from mbcdm_cad.api.design import DriveDesign
from mbcdm_cad.report.losses import losses_shown
from tests.support.checked import of_params


@cache
def report_of(name: str):  # type: ignore[no-untyped-def]
    return DriveDesign(of_params(name)).analyse()


@pytest.mark.parametrize("name", ["mbcdm", "siso_spur", "gallery/capstan"])
def test_json_and_text_carry_the_same_figures(name: str) -> None:
    report = report_of(name)
    block, lines = report.to_dict()["losses"], report.text(80).splitlines()
    against, along = block["motions"][0], block["motions"][2]
    assert (against["way"], along["way"]) == ("against the load", "with the load")
    start = next(k for k, line in enumerate(lines) if line.startswith("Losses while"))
    own = lines[start : lines.index("", start)]
    for cause, torque in against["by_cause_Nm"].items():
        line = next(line for line in own if line.strip().startswith(cause + "  "))
        assert f"{torque[-1]:.4f}" in line
    line = next(line for line in own if line.split()[:1] == [f"{against['load_Nm'][-1]:.3g}"] and "%" in line)
    assert f"{against['efficiency'][-1]:.1%}" in line
    assert f"{along['efficiency'][-1]:.1%}" in line
    assert max(len(line) for line in own) <= 80
    assert f"{block['backdrive']['running_Nm']:.3g} +-" in " ".join(own)


def test_the_copper_lowers_the_efficiency_most_at_low_speed() -> None:
    report = report_of("gallery/capstan")
    block = report.to_dict()["losses"]
    rows = block["electrical"]["efficiency"]
    at_peak = [row[-1] for row in rows]
    assert at_peak == sorted(at_peak)
    assert all(value < block["motions"][0]["efficiency"][-1] for value in at_peak)


def test_a_motor_without_electrical_values_has_no_electrical_efficiency() -> None:
    report = report_of("gallery/capstan")
    bare = replace(report.losses, motor=replace(report.losses.motor, torque_constant_mNm_A=None))
    found = bare.to_dict()
    assert found["electrical"] is None and losses_shown(found)["over_speed"] is None


@pytest.mark.parametrize("name", ["mbcdm", "gallery/capstan"])
def test_bus_power_is_what_payload_friction_and_copper_take(name: str) -> None:
    """The efficiencies by the motors' own torque and speed: V I of each motor against load times speed."""
    losses = report_of(name).losses
    found, constant, ohms = (
        losses.to_dict()["electrical"],
        losses.motor.torque_constant_mNm_A,
        losses.motor.resistance_ohm,
    )
    assert found is not None and constant is not None and ohms is not None
    turns = float(np.max(losses.train.d.input_turns)) * losses.train.gear_ratio
    for block, motion, way in ((found, losses.motions[0], 1), (found["back"], losses.motions[2], -1)):
        current = way * motion.motor_Nm / (constant * 1e-3)
        for speed, row in zip(np.radians(found["drum_speed_deg_s"]), block["efficiency"], strict=True):
            volts = way * (constant * 1e-3) * turns * speed + ohms * current
            bus, given = (volts * current).sum(axis=0), motion.load_Nm * speed
            for k, efficiency in enumerate(row):
                expected = given[k] / bus[k] if way > 0 else max(-bus[k] / given[k], 0.0)
                assert efficiency is None or efficiency == pytest.approx(expected, abs=1e-9), (way, speed, k)


def test_page_and_report_show_every_cause_and_their_sum() -> None:
    block = report_of("mbcdm").to_dict()["losses"]
    shown = losses_shown(block)
    for column, key in enumerate(("unloaded", "against", "along")):
        assert sum(row[key] for row in shown["rows"]) == pytest.approx(shown["all"][column])
    assert shown["peak_Nm"] == pytest.approx(3.15)
    forward, back = (line["y"] for line in shown["chart"]["lines"])
    assert all(f > b for f, b in zip(forward, back, strict=True))


@pytest.mark.parametrize("name", ["mbcdm", "siso_spur"])
def test_the_motors_tell_a_load_to_half_of_what_they_give_more_on_the_way_against_it(name: str) -> None:
    report = report_of(name).to_dict()
    found, (against, _, along, _) = report["losses"]["transparency"], report["losses"]["motions"]
    drive = of_params(name).drive
    turns = drive.layout.losses.d.input_turns * drive.gearhead.ratio
    # Each in the direction of motion, and the two move in opposite ones.
    more = np.array([*against["motor_mNm"].values()]) + np.array([*along["motor_mNm"].values()])
    at_drum = 0.5e-3 * (turns.reshape(-1, 1) * more).sum(axis=0)
    assert found["load_known_to_Nm"] == pytest.approx(at_drum.tolist(), rel=1e-6)
    assert found["rotors_kg_m2"] == pytest.approx(report["motor"]["reflected_inertia_kg_m2"])
    assert "transparency: a hand" in report_of(name).text(80)
