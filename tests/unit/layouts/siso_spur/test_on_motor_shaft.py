"""An input pulley on the motor's own shaft or on a servo's horn, and drives without encoders."""

from dataclasses import replace
from math import degrees, pi, radians, tau

import cadquery as cq
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbcdm_cad.checks.comparison import families
from mbcdm_cad.checks.fixings import stalled_Nm
from mbcdm_cad.design.bought import MOTOR_SPAN, Motor, Servo, ServoOutput
from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.base import Layout
from mbcdm_cad.layouts.loader import layout_of, load_text, new_design_text
from mbcdm_cad.layouts.siso_spur.cable_path import side_pieces
from mbcdm_cad.layouts.siso_spur.checks import overhung
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive, spur
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.siso_spur.support.parts import round_end_mm2
from mbcdm_cad.layouts.structure import overhung_sag_mm, structure_of
from mbcdm_cad.layouts.turns import turns_at
from mbcdm_cad.model.structure.causes import Acting, Section, bending_urad_Nm
from mbcdm_cad.model.structure.drum_sector import Isotropic
from mbcdm_cad.parts.bodies import HornBody, ServoBody
from mbcdm_cad.parts.milled import cylinder_z
from mbcdm_cad.report.catalogue_list import CatalogueList
from mbcdm_cad.rig.dynamic.train import rig_of, shaft_torque
from mbcdm_cad.routes.curves import Line
from mbcdm_cad.workshop.kernel import location, validate_solid
from tests.support.checked import failing, statuses

TEXT = """\
name: direct
configuration: siso_spur
travel: {half_angle_deg: 60.0}
transmission: {input_to_drum: 16.0}
loads: {peak_torque_Nm: 1.24}
drive: {gearhead: none, drum_encoder: none}
input_pulleys: {carried_by: motor}
"""


@pytest.fixture(scope="module")
def direct() -> SpurDrive:
    """A drive whose capstan sits on the shaft of a flat motor."""
    return spur(load_text(TEXT).drive)


def test_it_passes_and_has_neither_bearings_nor_encoder_at_its_input(direct: SpurDrive) -> None:
    found = statuses(SpurLayout(direct))
    assert [name for name, status in found.items() if status == "fail"] == []
    of_servo = {"horn_screws", "horn_flange", "servo_lash"}
    assert {check.id for check in families(overhung)[0].checks} - set(found) == of_servo
    assert not {"input_bearings", "collar_grip", "coupling_height", "bearing_seats", "flange"} & set(found)
    names = [item.name for item in layout_of(direct).bill().items]
    assert [name for name in names if name.startswith(("input_bearing", "encoder", "collar", "motor_head"))] == []
    assert sorted(item for step in layout_of(direct).assembly_order for item in step.items) == sorted(names)


@pytest.mark.parametrize("name", ["direct", "served"])
@pytest.mark.parametrize("part", ["frame", "input_pulley_main"])
def test_its_parts_are_one_solid_of_the_volume_that_they_say(
    request: pytest.FixtureRequest, name: str, part: str
) -> None:
    made = layout_of(request.getfixturevalue(name)).bill().made[part]
    solid = made.solid()
    validate_solid(part, solid)
    assert made.volume_mm3() == pytest.approx(solid.Volume(), rel=0.01)


def test_pulley_and_motor_lie_on_one_another_where_the_levels_say(direct: SpurDrive) -> None:
    layout = layout_of(direct)
    assert isinstance(layout, SpurLayout)
    bill = layout.bill()
    boxes = {
        item.name: bill.parts[item.part].part.solid().moved(cq.Location(location(item.location))).BoundingBox()
        for item in bill.items
        if item.name in ("motor_main", "input_pulley_main", "frame", "pulley_set_screw_main_1")
    }
    face = layout.levels.motor_shelf_bottom_z
    shaft = boxes["motor_main"].ymax
    assert shaft == pytest.approx(face + direct.gearhead.shaft_length_mm)
    assert boxes["input_pulley_main"].ymin < shaft < boxes["input_pulley_main"].ymax
    assert boxes["pulley_set_screw_main_1"].ymin > layout.levels.front_y, "a key reaches it in front of the plate"
    assert boxes["pulley_set_screw_main_1"].ymax < shaft, "it presses on the shaft"


@given(at=st.floats(0.0, 100.0))
def test_the_permitted_load_falls_with_the_lever_about_the_rear_bearing(direct: SpurDrive, at: float) -> None:
    """Moments about the rear bearing: the front one carries F (a + b) / b, the same as at the catalogue's distance."""
    gear = direct.gearhead
    stated = gear.shaft_length_mm / 2 if gear.radial_load_at_mm is None else gear.radial_load_at_mm
    span = MOTOR_SPAN * direct.motor.length_mm
    assert gear.permitted_N(at) * (at + span) == pytest.approx(gear.radial_load_N * (stated + span))
    assert gear.permitted_N(stated) == pytest.approx(gear.radial_load_N)


def test_the_load_of_the_front_bearing_is_that_of_statics(direct: SpurDrive) -> None:
    """Moments of both spans' pulls about the rear bearing, from where the drawn cables leave the pulley."""
    layout, span = SpurLayout(direct), direct.gearhead.span_mm
    rear, most = layout.levels.motor_shelf_bottom_z - span, 0.0
    for angle in (-layout.half_travel_rad, layout.half_travel_rad):
        for _, tensions in layout.loads.states:
            about = np.zeros(2)
            for cable, tension in zip(direct.cables, tensions, strict=True):
                pieces = side_pieces(direct, cable, *layout.anchors[cable.name], angle)
                start, end = next(piece for piece in pieces if isinstance(piece, Line)).points(np.array([0.0, 1.0]))
                way = (end - start) / np.linalg.norm(end - start)
                about += tension * way[[0, 2]] * (start[1] - rear)
            most = max(most, float(np.linalg.norm(about)) / span)
    _, _, said = overhung._pull(layout)
    assert most == pytest.approx(said, rel=0.01)


def test_a_shaft_bends_as_an_overhanging_beam() -> None:
    """F a^2 (a + b) / (3 E I), any handbook of beams."""
    a, b, r, force, modulus = 23.0, 17.0, 3.0, 1.0, 2.1e5
    z, x = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    loads = [
        Acting(a, force * x, 0 * x),
        Acting(0.0, -force * (a + b) / b * x, 0 * x),
        Acting(-b, force * a / b * x, 0 * x),
    ]
    found = bending_urad_Nm(z, loads, [Section(-b, a, r)], Isotropic(modulus, 0.3)) * 1e-3
    beam = force * a**2 * (a + b) / (3 * modulus * pi * r**4 / 4)
    # Shear of a round section adds F (a + a^2 / b) / (0.886 G A).
    shear = force * (a + a**2 / b) * 2.6 / (0.886 * modulus * pi * r**2)
    assert found == pytest.approx(beam + shear, rel=1e-2)


def test_its_sag_lies_between_a_stiff_pulley_and_the_bare_shaft(direct: SpurDrive) -> None:
    """A beam on two supports, the pulley as stiff as can be or not there at all, bearings without give."""
    soft, stiff = (
        overhung_sag_mm(
            SpurLayout(replace(direct, pulley_material=replace(direct.pulley_material, youngs_modulus_GPa=e)))
        )
        for e in (1e-3, 1e6)
    )
    own = overhung_sag_mm(SpurLayout(direct))
    assert stiff < own < soft, (stiff, own, soft)
    layout, gear = SpurLayout(direct), direct.gearhead
    second, modulus = pi / 64 * gear.shaft_diameter_mm**4, direct.material("steel").youngs_modulus_GPa * 1e3
    force = max(float(np.linalg.norm(loads.inputs[0].force_N)) for loads in layout.loads.on_bodies)
    a, b = layout.inputs[0].journal_bottom_z - layout.levels.motor_shelf_bottom_z, gear.span_mm
    # The shaft up to the pulley under the same force there alone sags less.
    assert own > force * a**2 * (a + b) / (3 * modulus * second)


def test_its_give_is_part_of_the_turn_at_the_payload(direct: SpurDrive) -> None:
    structure = structure_of(layout_of(direct))
    assert structure is not None
    names = {cause.name: cause.urad_Nm for cause in structure.at_payload}
    own = ("motors' shafts, torsion", "motors' shafts, bending", "motors' own bearings (estimate)")
    assert all(names[name] > 0.0 for name in own), names
    assert "gearheads" not in names and "input pulleys, bending" not in names
    thick = replace(
        direct, gearhead=replace(direct.gearhead, shaft_diameter_mm=1.2 * direct.gearhead.shaft_diameter_mm)
    )
    other = structure_of(layout_of(thick))
    assert other is not None
    less = {cause.name: cause.urad_Nm for cause in other.causes}["motors' shafts, bending"]
    assert less < names["motors' shafts, bending"]


@pytest.mark.parametrize(
    ("check", "field", "value"),
    [
        ("motor_shaft_load", "radial_load_N", 5.0),
        ("motor_shaft_stress", "shaft_diameter_mm", 1.0),
        ("motor_shaft_sag", "shaft_diameter_mm", 1.0),
        ("motor_shaft_grip", "shaft_length_mm", 4.0),
        ("motor_seat", "bolt_circle_mm", 9.0),
        ("pulley_set_screws", "shaft_diameter_mm", 0.1),
        ("hub_walls_of_pulley", "shaft_diameter_mm", 9.0),
    ],
)
def test_a_motor_that_cannot_carry_it_fails(direct: SpurDrive, check: str, field: str, value: float) -> None:
    weak = replace(direct, gearhead=replace(direct.gearhead, **{field: value}))
    assert statuses(SpurLayout(direct))[check] == "pass"
    assert statuses(SpurLayout(weak))[check] in ("fail", "warn")


def test_a_hub_as_large_as_the_gap_to_the_drum_fails(direct: SpurDrive) -> None:
    near = replace(direct, centre_distance_mm=direct.drum_radius_mm + direct.input_radius_mm + 0.3)
    assert statuses(SpurLayout(near))["hub_and_drum"] == "fail"


def test_the_rig_turns_it(direct: SpurDrive) -> None:
    assert rig_of(direct).encoders[0].resolution_rad == pytest.approx(2 * pi / 2**14)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("transmission: {input_to_drum: 16.0, cables: two_anchored}", "transmission.cables: .*no end faces"),
        ("drive: {gearhead: none, encoder: encoder-17}", "drive.encoder: the motor's shaft carries the pulley"),
        ("input_pulleys: {carried_by: motor, upper_bearing: 618/8}", "input_pulleys.upper_bearing: the motor's"),
        ("input_pulleys: {upper_bearing: none}", "upper_bearing: not in the catalogue"),
    ],
)
def test_what_it_has_no_place_for_is_refused(line: str, said: str) -> None:
    block = line.split(":")[0]
    text = "\n".join(line if old.startswith(block) else old for old in TEXT.splitlines())
    with pytest.raises(InputError, match=said):
        load_text(text + "\n")


def test_a_pulley_thinner_than_its_shaft_holds_nothing(direct: SpurDrive) -> None:
    """Its metal had a negative moment of area, and the radius of both as one shaft was a complex number."""
    thin = replace(direct, cables=tuple(replace(c, input_radius_mm=0.7) for c in direct.cables))
    assert 0.0 < structure_of(SpurLayout(thin)).stiffness_Nm_rad < structure_of(SpurLayout(direct)).stiffness_Nm_rad


SERVED = """\
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
    return spur(load_text(SERVED).drive)


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
        load_text(SERVED.replace(old, new))


SHORT = """\
name: bare
configuration: {layout}
travel: {{half_angle_deg: 45.0}}
transmission: {{input_to_drum: 9.0, drum_radius_mm: 75.0}}
loads: {{peak_torque_Nm: 1.0}}
drive: {{encoder: {encoder}, drum_encoder: {drum_encoder}}}
"""
BORE_MM = 40.0


def made(layout: str = "siso_spur", more: str = "", encoder: str = "none", drum_encoder: str = "none") -> Layout:
    text = SHORT.format(layout=layout, encoder=encoder, drum_encoder=drum_encoder)
    return layout_of(load_text(text + more).drive)


@pytest.fixture(scope="module")
def bare() -> Layout:
    return made()


@pytest.fixture(scope="module")
def hollow() -> Layout:
    return made(more=f"drum: {{shaft_bore_mm: {BORE_MM}}}\n")


@pytest.mark.parametrize("layout", ["siso_spur", "miso_spur"])
def test_it_passes_every_check_and_each_item_joins_in_one_step(layout: str) -> None:
    found = made(layout)
    assert failing(found) == {}
    names = [item.name for item in found.bill().items]
    assert [name for name in names if "encoder" in name] == []
    assert sorted(item for step in found.assembly_order for item in step.items) == sorted(names)


def test_no_step_speaks_of_an_encoder(bare: Layout) -> None:
    said = [step.text for step in bare.assembly_order if "encoder" in step.text]
    assert said == []
    assert "encoder" in " ".join(
        step.text for step in made(encoder="encoder-17", drum_encoder="encoder-24-ring").assembly_order
    )


def test_the_frame_has_neither_pocket_nor_threads_for_them(bare: SpurLayout) -> None:
    sheet = bare.bill().parts["frame"].part.sheet("frame")
    assert [group.letter for group in sheet.holes] == list("ABCDEF")
    assert not bare.frame.boss.has_encoder and not bare.frame.has_encoder


def test_the_motors_own_encoder_is_what_the_rig_reads(bare: Layout) -> None:
    step = rig_of(bare.drive).encoders[0].resolution_rad
    assert abs(step * 2**14 * bare.drive.gearhead.ratio / (2 * pi) - 1.0) < 1e-12, step


def test_a_controller_that_sees_only_the_motor_leaves_the_gearheads_twist(drive: SpurDrive) -> None:
    """With an encoder on its input the twist of gearhead and coupling is held off the payload, else it is not."""
    text = new_design_text("siso_spur", "siso_spur").replace("encoder: encoder-17", "encoder: none")
    seen, unseen = structure_of(layout_of(drive)), structure_of(layout_of(load_text(text).drive))
    assert seen is not None and unseen is not None
    before = [cause.name for cause in seen.causes if cause.before_input]
    assert before and seen.payload_urad_Nm < seen.motor_urad_Nm
    assert unseen.payload_urad_Nm == unseen.motor_urad_Nm
    assert set(before) <= {cause.name for cause in unseen.causes}, before


@pytest.mark.parametrize("layout", ["siso_bevel", "miso_bevel"])
@pytest.mark.parametrize("field", ["encoder", "drum_encoder"])
def test_other_layouts_refuse_with_what_to_do(layout: str, field: str) -> None:
    text = new_design_text("other", layout)
    line = next(line for line in text.splitlines() if line.startswith(f"  {field}: "))
    with pytest.raises(InputError, match=rf"drive.{field}: {layout} is drawn with this encoder only.*siso_spur"):
        load_text(text.replace(line, f"  {field}: none"))


def test_the_set_screws_do_not_meet_in_the_shaft_of_a_small_drive() -> None:
    """No ring encoder asks for a shaft of 5 mm any more; two M3 at a right angle would meet in one of 3 mm."""
    text = SHORT.format(layout="siso_spur", encoder="none", drum_encoder="none").replace(
        "torque_Nm: 1.0", "torque_Nm: 0.2"
    )
    layout = layout_of(load_text(text + "drum: {material: pla}\nsupport: {material: pla}\n").drive)
    assert failing(layout) == {}
    thin = layout_of(load_text(text + "drum: {bearing: 618/3}\n").drive)
    assert "set_screw_tips" in failing(thin)


def test_a_hollow_centre_of_the_stated_diameter_passes(hollow: SpurLayout) -> None:
    assert failing(hollow) == {}
    assert 2 * hollow.drum_shaft.bore_radius == BORE_MM
    bearing = hollow.drive.bearings.drum
    assert bearing.bore_mm - BORE_MM >= 2 * hollow.drive.shaft_material.min_wall_mm, bearing
    # Nothing else stands in it: the shaft runs from the frame's back to the face of the hub.
    assert hollow.drum_shaft.y_start == hollow.levels.back_y
    assert hollow.drum_shaft.y_end == hollow.levels.hub_face_y


def test_the_plates_round_end_takes_in_a_boss_wider_than_the_arm(hollow: SpurLayout) -> None:
    """Area of the disc outside a strip, against points counted on a grid."""
    frame = hollow.frame
    assert frame.boss.radius > frame.half_width, (frame.boss.radius, frame.half_width)
    r, w, n = frame.boss.radius, frame.half_width, 2000
    grid = (np.arange(n) + 0.5) / n * 2 * r - r
    x, z = np.meshgrid(grid, grid)
    inside = (x**2 + z**2 < r**2) & ~((np.abs(x) < w) & (z > 0.0))
    counted = inside.sum() * (2 * r / n) ** 2
    assert abs(round_end_mm2(frame) / counted - 1.0) < 1e-3, (round_end_mm2(frame), counted)
    narrow = replace(frame, boss=replace(frame.boss, radius=w / 2))
    assert abs(round_end_mm2(narrow) / (pi * w**2 / 2) - 1.0) < 1e-12
