"""A payload on the hub's face: its weight, what it does to bearings, shaft and screws, and the rules that follow it."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import pytest
from designs import reference

from mbcdm_cad.checks.bearings import drum_bearings, drum_reactions_N
from mbcdm_cad.checks.fixings import shaft_stress
from mbcdm_cad.checks.motors import continuous_torque
from mbcdm_cad.checks.structure import payload_screws
from mbcdm_cad.design.blocks import Payload
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.life import life_of
from mbcdm_cad.layouts.loader import layout_of, load_text
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.parts.drum_sector.dims import SLIP_SAFETY, JointLoad, PayloadJoint
from mbcdm_cad.report.analysis_report import analyse_design
from tests.support.checked import results

G = 9.80665
LEGS = {
    "siso_spur": "travel: {half_angle_deg: 50}\ntransmission: {input_to_drum: 8.0}\n",
    "miso_spur": "travel: {half_angle_deg: 30}\ntransmission: {input_to_drum: 8.0}\n",
    "siso_bevel": "travel: {half_angle_deg: 20}\ntransmission: {drum_radius_mm: 80.0, input_to_drum: 6.0}\n",
    "miso_bevel": "travel: {half_angle_deg: 35}\ntransmission: {drum_radius_mm: 60.0, ratio: 9.0}\n",
}
# A foot that is hit from the side.
FOOT = "mass_kg: 0.5, distance_mm: 100.0, ahead_mm: 40.0, radial_N: 300.0"


def carrying(payload: Payload | None, drive: Drive | None = None) -> SectorLayout:
    drive = drive or reference()
    layout = layout_of(replace(drive, loads=replace(drive.loads, payload=payload)))
    assert isinstance(layout, SectorLayout)
    return layout


def leg(configuration: str, loads: str) -> SectorLayout:
    text = f"name: leg\nconfiguration: {configuration}\n{LEGS[configuration]}loads: {{{loads}}}\n"
    layout = layout_of(load_text(text).drive)
    assert isinstance(layout, SectorLayout)
    return layout


def test_weight_and_inertia_are_those_of_a_point() -> None:
    arm = Payload(mass_kg=2.0, distance_mm=150.0, ahead_mm=20.0, radial_N=10.0, moment_Nm=1.0)
    assert arm.weight_torque_Nm == pytest.approx(2.0 * G * 0.15)
    assert arm.about_axis_kg_m2 == pytest.approx(2.0 * 0.15**2)
    assert replace(arm, inertia_kg_m2=0.1).about_axis_kg_m2 == 0.1
    assert arm.across_N == pytest.approx(2.0 * G + 10.0)
    assert arm.tilt_Nm == pytest.approx((2.0 * G + 10.0) * 0.02 + 1.0)


def test_bearings_balance_the_payload() -> None:
    """Moments about the front bearing and forces across add up to nothing, with the bearings' loads by it alone."""
    free, payload = carrying(None), Payload(mass_kg=1.0, ahead_mm=30.0, radial_N=50.0, moment_Nm=0.7)
    rear, front = (a - b for a, b in zip(drum_reactions_N(carrying(payload)), drum_reactions_N(free), strict=True))
    y_rear, y_front = free.drum_bearings_mm
    force, at = G + 50.0, free.levels.hub_face_y + 30.0
    assert front - rear == pytest.approx(force)
    assert rear * (y_front - y_rear) == pytest.approx(force * (at - y_front) + 700.0)


def test_the_shaft_bends_at_its_front_bearing() -> None:
    free, tilted = (shaft_stress(carrying(Payload(moment_Nm=moment))) for moment in (0.0, 3.0))
    shaft = carrying(None).drum_shaft
    modulus = pi * (shaft.radius**4 - shaft.bore_radius**4) / (4 * shaft.radius)
    strength = reference().shaft_material.yield_MPa
    assert strength / tilted.actual - strength / free.actual == pytest.approx(3000.0 / modulus), (free, tilted)


def test_the_joint_slips_by_torque_and_force_and_opens_by_tilt() -> None:
    joint, circle = PayloadJoint(4.0, reference().drum_material, None), 12.0
    load = JointLoad(8.0, 200.0, 6.0)
    friction = 4 * 0.15 * joint.clamp_N
    assert joint.slips_times(load, circle) == pytest.approx(friction / (8.0 / 0.012 + 200.0))
    # The screws' pulls k r sin(a) balance the moment: sum k r^2 sin^2(a) = 2 k r^2, most is k r.
    assert joint.opens_times(load, circle) == pytest.approx(joint.clamp_N / (6.0 / (2 * 0.012)))
    least = joint.least_circle_mm(load)
    assert min(joint.slips_times(load, least), joint.opens_times(load, least)) == pytest.approx(SLIP_SAFETY)


def test_weight_must_be_held_without_end() -> None:
    arm = Payload(mass_kg=2.0, distance_mm=120.0)
    s = carrying(arm)
    found = continuous_torque(s)
    assert found.limit == pytest.approx(arm.weight_torque_Nm) and found.note == "the payload's weight beside the axis"
    # The duty stays: a drive that carries something does no less all day than one that carries nothing.
    asked = [r.id for r in results(s) if r.id in ("continuous_torque", "gearhead_continuous")]
    assert sorted(asked) == ["continuous_torque", "gearhead_continuous"]
    assert s.drive.loads.lasting_Nm == pytest.approx(arm.weight_torque_Nm)
    assert carrying(None).drive.loads.lasting_Nm is None


def test_a_light_payload_does_not_take_the_duty_from_the_gearhead() -> None:
    """The gearhead is chosen for the stated duty whether the drive carries 0.1 kg or nothing."""
    loads = (
        "peak_torque_Nm: 25, duty: {rows: [{torque_Nm: 22.5, share: 0.8, range_deg: 60}, {torque_Nm: 1, share: 0.2}]}"
    )
    text = f"name: leg\nconfiguration: siso_spur\n{LEGS['siso_spur'].replace('8.0', '6.0')}loads: {{{loads}}}\n"
    free = load_text(text).drive
    light = load_text(text.replace("}]}}", "}]}, payload: {mass_kg: 0.1, distance_mm: 50}}")).drive
    assert light.loads.payload is not None and light.gearhead == free.gearhead, f"{light.gearhead} {free.gearhead}"


def test_weight_warms_motors_and_bends_cables_where_the_file_states_no_duty() -> None:
    """The assumed duty of motors and cables is under the weight, and each report says so."""
    weight = 0.6 * reference().loads.peak_torque_Nm
    s = carrying(Payload(mass_kg=weight / G, distance_mm=1000.0))
    without = carrying(None)
    assert s.motor_days[0].rms_Nm > 1.3 * without.motor_days[0].rms_Nm
    assert f"the payload's weight, {weight:.4g} N m" in s.duty.assumed[0], s.duty.assumed
    assert "the payload's weight" in life_of(s).duty, life_of(s).duty
    report = analyse_design(s.drive).to_dict()
    assert any("the payload's weight" in words for words in report["duty"]["assumed"]), report["duty"]


def test_a_weight_above_the_peak_torque_is_refused() -> None:
    with pytest.raises(InputError, match=r"payload\.mass_kg: its weight turns the drum by more than the peak torque"):
        leg("siso_spur", "peak_torque_Nm: 2.0, payload: {mass_kg: 2.0, distance_mm: 150.0}")


def test_a_payload_that_is_no_block_is_an_error_of_the_file() -> None:
    with pytest.raises(InputError, match="payload"):
        leg("siso_spur", "peak_torque_Nm: 2.0, payload: {mass: 2.0}")


@pytest.mark.parametrize("configuration", LEGS)
def test_rules_follow_the_payload(configuration: str) -> None:
    """Bearings, shaft and screws chosen without it would fail; those chosen for it hold."""
    free = leg(configuration, "peak_torque_Nm: 2.0")
    hit = leg(configuration, f"peak_torque_Nm: 2.0, payload: {{{FOOT}}}")
    payload = hit.drive.loads.payload
    kept = carrying(payload, free.drive)
    found = {check.id: (check(kept), check(hit)) for check in (drum_bearings, shaft_stress, payload_screws)}
    assert not found["drum_bearings"][0].holds, found
    assert all(sized.holds for _, sized in found.values()), found
