"""Words of siso_spur in miso_spur: idlers, capstans on the motors' shafts, bought servos, at each input."""

from functools import cache
from itertools import combinations

import cadquery as cq
import numpy as np
import pytest

from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import layout_of, load_text
from mbcdm_cad.layouts.miso_spur.layout import RoundDrumLayout
from mbcdm_cad.layouts.siso_spur.support.stiffness import frame_compliance
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.routes.route import body_load
from mbcdm_cad.workshop.kernel import location, validate_solid
from tests.support.checked import failing, held_rad, result

TEXT = """\
name: words
configuration: miso_spur
travel: {half_angle_deg: 40.0}
transmission: {input_to_drum: RATIO}
loads: {peak_torque_Nm: TORQUE}
"""
ON_SHAFT = "input_pulleys: {carried_by: motor}\n"
FILES = {
    "idlers": TEXT.replace("RATIO", "10.0, drum_radius_mm: 60.0, centre_distance_mm: 200.0").replace("TORQUE", "1.0")
    + "idlers: {pairs: 1}\n",
    "shaft": TEXT.replace("RATIO", "10.0, drum_radius_mm: 60.0").replace("TORQUE", "1.0")
    + ON_SHAFT
    + "drive: {gearhead: none, drum_encoder: none}\n",
    "servo": TEXT.replace("RATIO", "7.6, drum_radius_mm: 50.0").replace("TORQUE", "3.0")
    + ON_SHAFT
    + "drive: {motor: servo-35kg-25t, drum_encoder: none}\nrope: {type: uhmwpe-1}\n",
}


@cache
def made(word: str) -> RoundDrumLayout:
    return RoundDrumLayout(load_text(FILES[word], f"{word}.yaml").drive)


@pytest.mark.parametrize("word", FILES)
def test_short_file_passes_and_each_item_joins_once(word: str) -> None:
    layout = made(word)
    failed = failing(layout)
    assert not failed, failed
    joined = [name for step in layout.assembly_order for name in step.items]
    assert sorted(joined) == sorted(item.name for item in layout.bill().items)


@pytest.mark.parametrize("word", FILES)
def test_frame_and_pulleys_are_one_solid_of_their_volume_and_have_sheets(word: str) -> None:
    parts = made(word).bill().made
    names = ("frame", *(name for name in parts if name.startswith(("input_pulley", "idler_strap"))))
    for name in names:
        solid = parts[name].solid()
        validate_solid(name, solid)
        assert parts[name].volume_mm3() == pytest.approx(solid.Volume(), rel=0.01), name
        assert parts[name].sheet(name).dimensions, name


@pytest.mark.parametrize("word", FILES)
def test_nothing_round_the_inputs_meets(word: str) -> None:
    """Common volumes of frame, sectors, pulleys, motors, horns and idlers at one end of the travel."""
    bill = made(word).bill(40.0)
    kinds = ("idler", "frame", "drum_a", "drum_b", "input_pulley", "motor", "servo", "horn", "pulley_set_screw")
    solids = {
        item.name: bill.parts[item.part].part.solid().moved(cq.Location(location(item.location)))
        for item in bill.items
        if item.name.startswith(kinds) and "screw" not in item.name.replace("set_screw", "")
    }
    assert len(solids) > 6, list(solids)
    for one, two in combinations(solids, 2):
        if {one.split("_")[0], two.split("_")[0]} == {"pulley", "input"}:
            continue  # a set screw in its own thread
        common = solids[one].intersect(solids[two]).Volume()
        assert common < 0.05, f"{one} and {two} share {common:.3f} mm^3"


@pytest.mark.parametrize("load_Nm", [0.0, 1.0])
def test_pulls_of_led_cables_balance_the_torques(load_Nm: float) -> None:
    """Static balance of all cables: forces of the bodies add up to nothing, their moments to the shafts' torques."""
    d = layout_of(made("idlers").drive).si
    tension = solve_equilibrium(d, load_Nm).tension_N
    force, moment = np.zeros(3), 0.0
    for body in d.routes.bodies:
        load = body_load(d.routes, body.name, tension)
        force += load.force_N
        moment += float(np.cross(np.array(body.point_m), load.force_N)[1])
    assert np.abs(force).max() < 1e-9
    turned = d.sigma * tension * (d.drum_radius_m + d.input_radius_m)
    assert moment + float(turned.sum()) == pytest.approx(0.0, abs=1e-9)


def test_each_led_input_is_the_plain_drive_with_its_share() -> None:
    """Turn of the drum, and windup of a frame whose opposite arms are equal: each carries half of the load."""
    layout = made("idlers")
    all_of, one = layout.si, layout_of(layout.drive.unit(0)).si
    both = [
        float(np.diff(solve_equilibrium(d, np.array([0.0, load])).drum_angle_rad)[0])
        for d, load in ((all_of, 0.6), (one, 0.3))
    ]
    assert both[0] == pytest.approx(both[1], rel=1e-6)
    alone = sum(frame_compliance(unit).windup_urad_Nm for unit in layout.units)
    together = frame_compliance(layout).windup_urad_Nm
    assert 0.8 * alone / 4 < together <= 1.001 * alone / 4, (together, alone)


def test_far_capstan_is_held_where_the_shaft_is_and_pulls_hardest() -> None:
    """The pulley of the second input is longer by the pitch of the sectors; its set screws are over the shaft still."""
    layout = made("shaft")
    near, far = layout.inputs
    assert far.land_bottom_z - near.land_bottom_z == pytest.approx(layout.drive.pitch_mm)
    assert near.hub is not None and far.hub is not None and far.hub.screw_z == pytest.approx(near.hub.screw_z)
    load = result(layout, "motor_shaft_load")
    face, walked = layout.levels.motor_shelf_bottom_z, layout.drive.walk_mm / 2
    stated = float(load.message.split("shaft takes ")[1].split(" mm")[0])
    middle = (far.land_bottom_z + far.land_top_z) / 2
    assert middle - face < stated < far.land_top_z - face + walked, load.message


def test_rig_turns_two_led_inputs_as_one_with_half_the_load() -> None:
    drive = made("idlers").drive
    both, one = (np.ptp(held_rad(*of, structure=False)) for of in ((drive, 0.5), (drive.unit(0), 0.25)))
    assert both == pytest.approx(one, rel=1e-3)


def test_seat_and_pairs_are_refused_as_in_siso_spur() -> None:
    with pytest.raises(InputError, match="remove pairs"):
        load_text(FILES["idlers"].replace("pairs: 1", "pairs: 1, places: [{x_mm: 12, z_mm: 90}, {x_mm: 11, z_mm: 75}]"))
    with pytest.raises(InputError, match="no place for it"):
        load_text(FILES["shaft"] + "stage: {kind: belt}\n")


@pytest.mark.parametrize("word", ["idlers: {pairs: 1}", "input_pulleys: {carried_by: motor}"])
def test_layouts_with_crossed_axes_say_why_they_have_no_such_word(word: str) -> None:
    text = "name: x\nconfiguration: siso_bevel\ntravel: {half_angle_deg: 20.0}\nloads: {peak_torque_Nm: 1.0}\n"
    text += f"transmission: {{input_to_drum: 4.0, drum_radius_mm: 58.0}}\n{word}\n"
    with pytest.raises(InputError, match=r"where axes cross.*pitch line.*siso_spur or miso_spur"):
        load_text(text)
