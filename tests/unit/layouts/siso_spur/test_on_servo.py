"""An input pulley on the horn of a bought servo."""

from dataclasses import replace
from math import degrees, radians, tau

import numpy as np
import pytest

from mbcdm_cad.checks.fixings import stalled_Nm
from mbcdm_cad.design.bought import Motor, Servo, ServoOutput
from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import layout_of, load_text
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive, spur
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.layouts.turns import turns_at
from mbcdm_cad.parts.bodies import HornBody, ServoBody
from mbcdm_cad.parts.milled import cylinder_z
from mbcdm_cad.report.catalogue_list import CatalogueList
from mbcdm_cad.rig.dynamic.rig import rig_of
from mbcdm_cad.rig.dynamic.train import shaft_torque
from mbcdm_cad.workshop.kernel import validate_solid
from tests.support.checked import statuses

TEXT = """\
name: served
configuration: siso_spur
travel: {half_angle_deg: 60.0}
transmission: {input_to_drum: 6.52, drum_radius_mm: 40.0}
loads: {peak_torque_Nm: 2.0}
rope: {type: uhmwpe-1}
drive: {motor: servo-35kg-25t, drum_encoder: none}
input_pulleys: {carried_by: motor}
drum: {material: pla, hub_diameter_mm: 30.0}
support: {material: pla}
"""
SERVOS = {name: Motor(name=name, **entry) for name, entry in package_entries("motors").items() if "servo" in entry}


@pytest.fixture(scope="module")
def served() -> SpurDrive:
    """A printed drive with a hobby servo."""
    return spur(load_text(TEXT).drive)


def of(drive: SpurDrive, **changes: object) -> SpurDrive:
    """The drive with values of its servo changed."""
    gear = drive.gearhead
    assert isinstance(gear, ServoOutput)
    return replace(drive, gearhead=replace(gear, servo=replace(gear.servo, **changes)))


def test_three_families_say_the_same_of_torque_and_speed_at_horn_and_motor() -> None:
    """The winding's torque at standstill through the gears is the horn's; its constant gives the horn's speed."""
    speed_deg_s = {"servo-standard-25t": 60.0 / 0.17, "servo-35kg-25t": 60.0 / 0.12, "servo-bus-horn": 46.0 * 6.0}
    assert set(SERVOS) == set(speed_deg_s)
    for name, motor in SERVOS.items():
        servo = motor.servo
        assert isinstance(servo, Servo) and motor.voltage_V and motor.resistance_ohm and motor.torque_constant_mNm_A
        stall = motor.voltage_V / motor.resistance_ohm * motor.torque_constant_mNm_A * servo.ratio * servo.efficiency
        assert stall == pytest.approx(servo.max_torque_mNm, rel=0.05), name
        speed = motor.voltage_V / (motor.torque_constant_mNm_A * 1e-3) / servo.ratio
        assert degrees(speed) == pytest.approx(speed_deg_s[name], rel=0.05), name
        rated = motor.rated_torque_mNm * servo.ratio * servo.efficiency
        assert rated == pytest.approx(servo.rated_torque_mNm, rel=0.05), name
        assert servo.hole_length_mm > servo.body_mm and servo.ears_mm > servo.hole_length_mm, name


def test_the_catalogue_prints_their_values_in_rows() -> None:
    text = CatalogueList("motors").markdown()
    assert "| servo.horn_circle_mm | 16 | 16 | 20 |" in text
    assert "{" not in text + CatalogueList("motors").text()


def test_it_passes_and_is_drawn_with_ears_horn_and_screws(served: SpurDrive) -> None:
    found = statuses(SpurLayout(served))
    assert [name for name, status in found.items() if status == "fail"] == []
    assert {"horn_screws", "horn_flange", "servo_lash", "motor_seat"} <= set(found)
    assert not {"pulley_set_screws", "motor_shaft_grip", "input_bearings", "collar_grip"} & set(found)
    names = [item.name for item in layout_of(served).bill().items]
    assert {"servo_main", "horn_main", "horn_screw_main", "servo_screw_main_4", "flange_screw_main_4"} <= set(names)
    assert sorted(item for step in layout_of(served).assembly_order for item in step.items) == sorted(names)


@pytest.mark.parametrize("part", ["frame", "input_pulley_main"])
def test_its_parts_are_one_solid_of_the_volume_that_they_say(served: SpurDrive, part: str) -> None:
    made = layout_of(served).bill().made[part]
    solid = made.solid()
    validate_solid(part, solid)
    assert made.volume_mm3() == pytest.approx(solid.Volume(), rel=0.01)


def test_a_stalled_servo_loads_the_stop_with_the_torque_at_its_horn(served: SpurDrive) -> None:
    """By hand: its 0.9 N m over the ratio; its motor times its gears, without their losses, would be 1.65 N m."""
    assert stalled_Nm(layout_of(served)) == pytest.approx(0.9 * 6.52, rel=1e-6)


def test_the_screw_of_the_horn_has_room_in_horn_and_spline(served: SpurDrive) -> None:
    servo = served.servo
    assert servo is not None
    centre = served.screw(servo.centre_screw)
    shank = cylinder_z(centre.thread_mm / 2, 0, 0, servo.horn_face_mm - centre.length_mm, servo.horn_face_mm)
    for body in (ServoBody(served.motor, servo, 1.6, centre), HornBody(served.motor, servo, 1.5, centre)):
        assert shank.intersect(body.solid()).Volume() == pytest.approx(0.0, abs=1e-3)


def test_its_lash_enters_where_its_sensor_does_not_see_it(served: SpurDrive) -> None:
    """The drum's play is the horn's over the ratio: all of the difference between a servo with lash and one without."""
    for sensor, seen in (("output", 0.0), ("motor", 1.0)):
        loose, tight = (turns_at(layout_of(of(served, sensor=sensor, lash_deg=lash)), 0.6) for lash in (2.0, 0.0))
        play = radians(2.0) / served.total_ratio * 1e3
        assert loose.payload is not None and tight.payload is not None
        assert loose.payload.swing_mrad - tight.payload.swing_mrad == pytest.approx(seen * play), sensor
        assert loose.motors_held is not None and tight.motors_held is not None
        assert loose.motors_held.swing_mrad - tight.motors_held.swing_mrad == pytest.approx(play)
        assert loose.motors_held.turn_mrad - tight.motors_held.turn_mrad == pytest.approx(play / 2)


def test_the_rig_has_the_same_gears_and_sensor(served: SpurDrive) -> None:
    rig, servo = rig_of(served), served.servo
    assert servo is not None
    gear = rig.gearheads[0]
    torque, _ = shaft_torque(1.5 * gear.lash_rad, gear.lash_rad, gear.stiffness_Nm_rad)
    assert torque == pytest.approx(radians(servo.lash_deg) * servo.stiffness_Nm_rad), "one lash beyond half of it"
    assert rig.encoders[0].resolution_rad == pytest.approx(tau / servo.sensor_steps)


def test_a_sensor_at_the_motor_leaves_the_twist_of_the_gears(served: SpurDrive) -> None:
    seen, unseen = structure_of(layout_of(served)), structure_of(layout_of(of(served, sensor="motor")))
    assert seen is not None and unseen is not None
    gears = {cause.name: cause.urad_Nm for cause in seen.causes}["gearheads"]
    servo = served.servo
    assert servo is not None
    assert gears == pytest.approx(1e6 / servo.stiffness_Nm_rad / served.total_ratio**2, rel=1e-3)
    assert unseen.payload_urad_Nm - seen.payload_urad_Nm == pytest.approx(gears)


@pytest.mark.parametrize(
    ("check", "changes"),
    [
        ("horn_screws", {"horn_circle_mm": 0.5}),
        ("horn_flange", {"horn_circle_mm": 12.0}),
        ("servo_lash", {"sensor": "motor", "lash_deg": 5.0}),
        ("motor_seat", {"hole_length_mm": 42.0}),
        ("input_room", {"horn_face_mm": 11.0}),
    ],
)
def test_a_servo_that_does_not_fit_fails(served: SpurDrive, check: str, changes: dict[str, object]) -> None:
    assert statuses(SpurLayout(served))[check] == "pass"
    assert statuses(SpurLayout(of(served, **changes)))[check] in ("fail", "warn")


def test_plate_and_ears_lie_on_one_another(served: SpurDrive) -> None:
    """Holes of the ears as drawn are the threads of the plate as drawn, by their places alone."""
    layout, servo = SpurLayout(served), served.servo
    seat = layout.frame.motor
    assert servo is not None and seat is not None and seat.window is not None
    half, low, high = seat.window
    assert 2 * half - servo.width_mm == pytest.approx(2 * served.clearances.running_mm)
    assert high - low - servo.body_mm == pytest.approx(2 * served.clearances.running_mm)
    bill = layout.bill()
    item = next(item for item in bill.items if item.name == "servo_main")
    drawn = {
        tuple(np.round(item.location.apply(np.array([[servo.axis_mm + x, y, 0.0]]))[0][[0, 2]], 6) + 0.0)
        for x in (-servo.hole_length_mm / 2, servo.hole_length_mm / 2)
        for y in (-servo.hole_width_mm / 2, servo.hole_width_mm / 2)
    }
    assert drawn == {tuple(np.round(place, 6) + 0.0) for place in seat.screws}


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("input_pulleys: {carried_by: motor}\n", "", "drive.motor: the horn of a servo carries the input pulley"),
        (
            "motor: servo-35kg-25t,",
            "motor: servo-35kg-25t, gearhead: gearhead-19-16,",
            "is a servo with gears of its own",
        ),
    ],
)
def test_what_does_not_go_with_a_servo_is_refused(old: str, new: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        load_text(TEXT.replace(old, new))
