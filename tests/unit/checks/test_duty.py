"""Checks of what lasts: continuous torque, speed, windings and printed seats over the duty; sizing for them."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import pytest

from mbcdm_cad.checks.comparison import CheckResult
from mbcdm_cad.checks.motors import FAMILIES
from mbcdm_cad.checks.run import run_check
from mbcdm_cad.design.blocks import DutyBlock, DutyRow
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.life import life_of
from mbcdm_cad.layouts.loader import layout_of, load_text

BY_ID = {check.id: check for check in FAMILIES[1].checks}
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


def leg(more: str) -> str:
    return LEG.replace("MORE", more)


@cache
def sized_leg() -> Drive:
    return load_text(leg("")).drive


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
    if layout == "miso_bevel" and not geared:
        pytest.skip("its rules take a motor without gearhead only where the file asks for it")
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
        leg(", duty: {ambient_C: 120, rows: [{torque_Nm: 5, share: 1}]}").replace("5.0", "8.0").replace("5,", "8,"),
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
        load_text(leg(more))
    assert field in str(refused.value), refused.value
