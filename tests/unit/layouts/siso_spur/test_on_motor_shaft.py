"""An input pulley on the motor's own shaft, without bearings of its own."""

from dataclasses import replace
from math import pi

import cadquery as cq
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbcdm_cad.checks.comparison import families
from mbcdm_cad.design.bought import MOTOR_SPAN
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import layout_of, load_text
from mbcdm_cad.layouts.siso_spur.cable_path import side_pieces
from mbcdm_cad.layouts.siso_spur.checks import overhung
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive, spur
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.structure import overhung_sag_mm, structure_of
from mbcdm_cad.model.structure.causes import Acting, Section, bending_urad_Nm
from mbcdm_cad.model.structure.drum_sector import Isotropic
from mbcdm_cad.rig.dynamic.rig import rig_of
from mbcdm_cad.routes.curves import Line
from mbcdm_cad.workshop.kernel import location, validate_solid
from tests.support.checked import statuses

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


@pytest.mark.parametrize("part", ["frame", "input_pulley_main"])
def test_its_parts_are_one_solid_of_the_volume_that_they_say(direct: SpurDrive, part: str) -> None:
    made = layout_of(direct).bill().made[part]
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
