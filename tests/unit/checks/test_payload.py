"""A payload on the hub's face: its weight, what it does to bearings, shaft and screws, and the rules that follow it."""

from dataclasses import replace
from functools import cache
from math import pi
from typing import Any

import pytest

from mbcdm_cad.checks import motors
from mbcdm_cad.checks.bearings import drum_bearings, drum_reactions_N
from mbcdm_cad.checks.comparison import CheckResult, families
from mbcdm_cad.checks.fixings import shaft_stress
from mbcdm_cad.checks.run import run_check
from mbcdm_cad.checks.structure import payload_screws
from mbcdm_cad.design.blocks import DutyBlock, DutyRow, Payload
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.life import life_of
from mbcdm_cad.layouts.loader import design_file, layout_of, load_text
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.parts.drum_sector.dims import SLIP_SAFETY, JointLoad, PayloadJoint
from mbcdm_cad.report.analysis_report import analyse_design
from tests.support.checked import failing, results
from tests.unit.checks.designs import put, reference

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
    found = motors.continuous_torque(s)
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


HANDLE = """name: handle
configuration: siso_spur
travel: {half_angle_deg: 45}
transmission: {input_to_drum: 10, drum_radius_mm: 60}
loads: {peak_torque_Nm: 0.5, backdrive_Nm: 0.05}
"""


def test_a_design_that_asks_for_none_is_told_the_torque() -> None:
    found = motors.backdrive(layout_of(reference()))
    back = layout_of(reference()).losses.backdrive
    assert back is not None
    assert found.sense == 0 and found.actual == pytest.approx(back.start_Nm)


def test_gearheads_that_lock_fail_only_where_back_driving_is_asked() -> None:
    locked = put(reference(), "gearhead.efficiency", 0.5)
    assert run_check(motors.backdrive, layout_of(locked)).status == "pass"
    asked = run_check(motors.backdrive, layout_of(put(locked, "loads.backdrive_Nm", 1.0)))
    assert asked.status == "fail" and "0.5 or below" in asked.message, asked


GEARED = HANDLE + "drive: {motor: motor-4.5mNm-17, gearhead: gearhead-76-22}\n"


def test_a_handle_learns_what_resists_most() -> None:
    found = run_check(motors.backdrive, layout_of(load_text(GEARED).drive))
    assert found.status == "fail" and found.actual is not None and found.actual > 0.05, found
    assert "gearhead" in found.remedy, found.remedy


@pytest.mark.parametrize(
    ("layout", "share", "geared"),
    [
        ("siso_spur", 0.9, True),
        ("siso_spur", 0.4, False),
        ("miso_spur", 0.9, True),
        ("siso_bevel", 0.5, False),
        ("miso_bevel", 0.9, True),
        ("miso_bevel", 0.4, False),
    ],
)
def test_rules_choose_a_train_that_the_drum_turns(layout: str, share: float, geared: bool) -> None:
    """Motor, gearhead and preload hold a wish that the drive without it does not, and still move its torque."""
    text = str(design_file(layout).starting).format(name="started")
    back = layout_of(load_text(text).drive).losses.backdrive
    assert back is not None
    wanted = share * back.start_Nm
    asked = load_text(text.replace("loads:\n", f"loads:\n  backdrive_Nm: {wanted:.4g}\n", 1)).drive
    found = {c.id: c for c in results(asked)}
    assert found["backdrive"].status == "pass" and found["backdrive"].limit == pytest.approx(wanted, rel=1e-3)
    assert found["motor_torque_forward"].status == found["motor_torque_back"].status == "pass", found
    assert asked.gearhead.absent is not geared, asked.gearhead.name


def test_what_no_train_of_the_catalogue_does_comes_near() -> None:
    """The drive that turns most easily, with the one failed check that says by how much it misses."""
    text = str(design_file("siso_spur").starting).format(name="started")
    drive = load_text(text.replace("loads:\n", "loads:\n  backdrive_Nm: 0.02\n", 1)).drive
    assert drive.gearhead.absent
    assert list(failing(drive)) == ["backdrive"]


def test_a_lower_preload_turns_more_easily_where_motor_and_ratio_are_stated() -> None:
    text = HANDLE + "drive: {motor: maxon-ec45flat-70W, gearhead: none, encoder: none}\n"
    usual = load_text(text.replace("0.05}", "1.0}")).drive
    back = layout_of(usual).losses.backdrive
    assert back is not None
    asked = load_text(text.replace("0.05}", f"{0.99 * back.start_Nm:.4g}}}")).drive
    assert asked.cables[0].preload_N < usual.cables[0].preload_N
    assert run_check(motors.backdrive, layout_of(asked)).status == "pass"


@pytest.mark.parametrize(
    ("layout", "cables", "share"),
    [("miso_bevel", "", 0.94), ("siso_bevel", "", 0.987), ("siso_spur", "  cables: two_anchored\n", 0.935)],
)
def test_anchored_cables_get_less_preload_until_one_would_go_slack(layout: str, cables: str, share: float) -> None:
    text = str(design_file(layout).starting).format(name="started").rstrip() + "\n"
    text = text.replace("transmission:\n", f"transmission:\n{cables}", 1)
    text += "drive: {motor: mjbots-mj5208, gearhead: none}\n"

    def asked(wanted_Nm: float | None) -> tuple[float, dict[str, str], str, float]:
        line = "" if wanted_Nm is None else f"  backdrive_Nm: {wanted_Nm:.4g}\n"
        found = load_text(text.replace("loads:\n", f"loads:\n{line}", 1))
        preload = next(value for value in found.sized if value.field == "rope.preload_N")
        back = layout_of(found.drive).losses.backdrive
        assert back is not None
        return preload.value, failing(found.drive), preload.driver, back.start_Nm

    usual, failed, driver, turned = asked(None)
    assert not failed and driver != "backdrive"
    less, failed, driver, _ = asked(share * turned)
    assert not failed and driver == "backdrive" and 0.5 * usual <= less < usual, (usual, less)
    least, failed, _, easiest = asked(0.1 * turned)
    assert set(failed) == {"backdrive"} and least < less and easiest < share * turned, (least, failed)


BY_ID = {check.id: check for check in families(motors)[1].checks}
# Motor without a gearhead, printed.
LEG = """name: leg
configuration: siso_spur
travel: {half_angle_deg: 40}
transmission: {input_to_drum: 9, drum_radius_mm: 72}
loads: {peak_torque_Nm: 5.0MORE}
rope: {type: uhmwpe-2}
drive: {motor: eaglepower-8308-90kv}
drum: {material: pla}
support: {material: pla}
"""
WRIST = """name: wrist
configuration: LAYOUT
travel: {half_angle_deg: 35}
transmission: {SIZES}
loads: {peak_torque_Nm: 0.8MORE}
"""
SIZES = {
    "siso_spur": "input_to_drum: 10, drum_radius_mm: 60",
    "miso_spur": "input_to_drum: 10, drum_radius_mm: 60",
    "siso_bevel": "drum_radius_mm: 58",
    "miso_bevel": "ratio: 9, drum_radius_mm: 54",
}


def check(text: str, name: str) -> CheckResult:
    return run_check(BY_ID[name], layout_of(load_text(text).drive))


def duty_leg(more: str) -> str:
    return LEG.replace("MORE", more)


@cache
def sized_leg() -> Drive:
    return load_text(duty_leg("")).drive


def check_leg(name: str, **loads: Any) -> CheckResult:
    """A check on the leg as it is sized without them, under other loads."""
    return run_check(BY_ID[name], layout_of(replace(sized_leg(), loads=replace(sized_leg().loads, **loads))))


def wrist(layout: str, more: str) -> str:
    return WRIST.replace("LAYOUT", layout).replace("SIZES", SIZES[layout]).replace("MORE", more)


@pytest.mark.parametrize("layout", SIZES)
def test_sizing_chooses_a_gearhead_that_lasts_in_every_layout(layout: str) -> None:
    """Continuously as much as at the peak: the check of the peak alone does not tell whether the gearhead lasts."""
    peak = load_text(wrist(layout, "")).drive
    lasting = load_text(wrist(layout, ", continuous_torque_Nm: 0.8")).drive
    found = run_check(BY_ID["continuous_torque"], layout_of(lasting))
    assert found.status == "pass", found
    assert lasting.gearhead.rated_torque_mNm >= peak.gearhead.rated_torque_mNm, (lasting.gearhead, peak.gearhead)
    asked = {c.id for c in checks_of(lasting)}
    assert "continuous_torque" in asked and "gearhead_continuous" not in asked


def test_a_gearhead_that_does_not_last_learns_what_one_needs() -> None:
    text = (
        wrist("siso_spur", ", continuous_torque_Nm: 0.8")
        + "drive: {motor: motor-2.9mNm-15, gearhead: gearhead-76-16}\n"
    )
    found = check(text.replace("0.8", "1.9"), "continuous_torque")
    assert found.status == "fail" and "gearhead of about" in found.remedy, found


@pytest.mark.parametrize("asked", [300.0, 1300.0, 1600.0])
def test_speed_is_that_of_the_curve(asked: float) -> None:
    """By hand: (24 V - R I)/K over 9 to 1, at the motor's torque under the load with losses."""
    found = check_leg("speed", speed_deg_s=asked)
    train = layout_of(sized_leg()).losses
    torque = max(float(train.moving(load, 1).motor_Nm.max()) for load in (5.0, -5.0)) - train.motor_idle_Nm
    expected = (24.0 - 0.17 * torque / 0.106) / 0.106 * 57.29578 / 9.0
    assert found.actual == pytest.approx(expected, rel=1e-3)
    assert (found.status == "pass") is (asked < expected), found


def test_a_motor_without_electrical_values_cannot_show_a_speed() -> None:
    drive = load_text(wrist("siso_spur", ", speed_deg_s: 100")).drive
    bare = replace(drive, motor=replace(drive.motor, torque_constant_mNm_A=None))
    found = run_check(BY_ID["speed"], layout_of(bare))
    assert found.status == "fail" and "torque constant" in found.message, found


@pytest.mark.parametrize("layout", SIZES)
@pytest.mark.parametrize(("speed", "geared"), [(60, True), (500, False)])
def test_sizing_for_a_speed_takes_a_motor_that_reaches_it(layout: str, speed: int, geared: bool) -> None:
    """A slow joint keeps its gearhead: small motors have electrical values too."""
    drive = load_text(wrist(layout, f", speed_deg_s: {speed}")).drive
    assert run_check(BY_ID["speed"], layout_of(drive)).status == "pass"
    assert not geared or not drive.gearhead.absent, drive.motor.name


@pytest.mark.parametrize("layout", SIZES)
def test_sizing_takes_a_motor_that_stands_the_stated_duty(layout: str) -> None:
    """In hot air a motor that holds the peak torque at 25 C burns; sizing takes one that does not."""
    rows = "[{torque_Nm: 0.8, share: 0.7, speed_deg_s: 20}, {torque_Nm: 0.3, share: 0.3}]"
    plain = load_text(wrist(layout, "")).drive
    asked = load_text(wrist(layout, f", duty: {{ambient_C: 115, period_s: 30, rows: {rows}}}")).drive
    duty = replace(plain, loads=asked.loads)
    assert run_check(BY_ID["duty"], layout_of(duty)).status == "fail"
    found = run_check(BY_ID["duty"], layout_of(asked))
    assert found.status == "pass", found
    assert asked.motor.rated_torque_mNm * asked.gearhead.ratio > plain.motor.rated_torque_mNm * plain.gearhead.ratio


def test_a_wanted_life_takes_a_rope_of_thinner_wires_and_larger_pulleys() -> None:
    text = wrist("siso_spur", "").replace(", drum_radius_mm: 60", "").replace("0.8", "4.0")
    plain, lasting = (
        layout_of(load_text(text).drive),
        layout_of(load_text(text + "targets: {life_cycles: 1000}\n").drive),
    )
    assert (plain.drive.cable.construction, lasting.drive.cable.construction) == ("7x7", "7x19")
    assert lasting.smallest_bend_ratio >= lasting.drive.cable.bend_ratio_desired
    assert plain.smallest_bend_ratio < plain.drive.cable.bend_ratio_minimum
    assert life_of(lasting).first is not None and life_of(lasting).first.cycles > 1000.0


def test_a_duty_at_its_border() -> None:
    """The share of the time for which the peak load may be held at 60 C: just below it passes, just above it fails."""

    def of(share: float) -> CheckResult:
        rows = (DutyRow(torque_Nm=5.0, share=share), DutyRow(torque_Nm=0.0, share=1.0 - share))
        return check_leg("duty", duty=DutyBlock(ambient_C=60.0, period_s=20.0, rows=rows))

    low, high = 0.05, 0.95
    assert of(low).status == "pass" and of(high).status == "fail", (of(low), of(high))
    for _ in range(12):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if of(middle).status == "pass" else (low, middle)
    good, bad = of(low), of(high)
    assert good.margin is not None and bad.margin is not None and good.margin - bad.margin < 0.2
    assert "mN m or more" in bad.remedy, bad.remedy
    assert "% of what they are" in bad.remedy


def test_a_duty_that_never_settles_is_told_in_torque() -> None:
    found = check(
        duty_leg(", duty: {ambient_C: 120, rows: [{torque_Nm: 5, share: 1}]}")
        .replace("5.0", "8.0")
        .replace("5,", "8,"),
        "duty",
    )
    assert found.status == "fail" and "would pass 400 C" in found.message and found.unit == "mN m", found


def test_a_printed_seat_gets_warm_by_the_duty() -> None:
    light, heavy = DutyRow(torque_Nm=1.0, share=1.0, range_deg=60.0), DutyRow(torque_Nm=3.5, share=1.0)
    cool = check_leg("seat_temperature", duty=DutyBlock(rows=(light,)))
    assert cool.status == "pass" and cool.limit == 45.0, cool
    hot = check_leg("seat_temperature", duty=DutyBlock(ambient_C=35.0, rows=(heavy,)))
    assert hot.status == "fail" and hot.actual is not None and hot.actual > 45.0, hot
    told = check_leg("seat_temperature")
    assert told.status == "pass" and told.limit is None and "assumed" in told.message, told


@pytest.mark.parametrize(
    ("more", "field"),
    [
        (", continuous_torque_Nm: 6", "loads.continuous_torque_Nm"),
        (", duty: {rows: [{torque_Nm: 6, share: 1}]}", "loads.duty.rows"),
        (", duty: {rows: [{torque_Nm: 1, share: 1, range_deg: 90}]}", "range_deg"),
        (", duty: {ambient_C: 30}", "loads.duty"),
    ],
)
def test_a_load_that_contradicts_the_file_is_refused(more: str, field: str) -> None:
    with pytest.raises(InputError) as refused:
        load_text(duty_leg(more))
    assert field in str(refused.value), refused.value
