"""A belt or a pair of gears between motor and input: figures by other routes, checks, parts, the rig and the loop."""

from dataclasses import replace
from functools import cache
from math import pi, radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from mbcdm_cad.checks.motor_head import collar_gaps
from mbcdm_cad.checks.run import run_check
from mbcdm_cad.design.bought import NO_ENCODER
from mbcdm_cad.design.stage import BELTS, Stage, StageBlock, stage_of
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import layout_of, load_text
from mbcdm_cad.layouts.siso_spur.checks.stage import SERVICE, lewis_factor
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.layouts.turns import turns_at
from mbcdm_cad.measurement.loads import parts_seen
from mbcdm_cad.measurement.schema import CountedParts
from mbcdm_cad.parts.coupling import Belt, Wheel, collar_sweep_mm
from tests.support.checked import held_rad, results

TEXT = """\
name: staged
configuration: siso_spur
travel: {half_angle_deg: 45.0}
transmission: {input_to_drum: 8.0}
loads: {peak_torque_Nm: 2.0, stiffness_Nm_rad: 1.0}
"""


@cache
def drive(stage: str) -> SpurDrive:
    found = load_text(TEXT + (f"stage: {stage}\n" if stage else "")).drive
    assert isinstance(found, SpurDrive)
    return found


BELT, GEARS = "{kind: belt, ratio: 3.0}", "{kind: gears, ratio: 3.0}"


@settings(max_examples=30, deadline=None)
@given(
    name=st.sampled_from(sorted(BELTS)), small=st.integers(14, 30), ratio=st.floats(1.0, 5.0), more=st.integers(0, 80)
)
def test_belt_of_whole_teeth_lies_on_its_pulleys(name: str, small: int, ratio: float, more: int) -> None:
    block = StageBlock(kind="belt", ratio=ratio, belt=name, driver_teeth=small, belt_teeth=1000, width_mm=6.0)
    teeth = int(1.15 * (stage_of(block).driven_teeth + small)) + more + 4
    stage = replace(stage_of(block), belt_teeth=teeth)
    # The belt is the shortest closed line round both pitch circles.
    a = np.linspace(0.0, 2 * pi, 4001)
    circle = np.stack([np.sin(a), np.cos(a)], axis=1)
    both = np.concatenate([stage.driven_mm * circle, stage.driver_mm * circle + (0.0, stage.centre_mm)])
    assert float(ConvexHull(both).area) == pytest.approx(teeth * stage.pitch_mm, rel=1e-5)


def test_lewis_factor_is_near_that_of_lewis_formula() -> None:
    for teeth in (14, 18, 25, 40, 70, 120):
        assert lewis_factor(teeth) == pytest.approx(pi * (0.154 - 0.912 / teeth), rel=0.09)


@pytest.mark.parametrize("kind", [BELT, GEARS])
def test_short_file_is_sized_and_its_motor_holds(kind: str) -> None:
    lay = SpurLayout(drive(kind))
    for name in ("stage_strength", "stage_room", "stage_shaft", "stage_bond", "stage_journal", "motor_torque_back"):
        assert run_check(lay.checks_by_id()[name], lay).status == "pass", name
    stage = lay.drive.stage
    assert stage is not None and stage.ratio == pytest.approx(3.0, rel=0.01)
    # Wheels roll on each other at their pitch circles, gears against each other.
    driver = next(body for body in lay.moving_bodies if body.kind == "stage")
    own = next(body for body in lay.moving_bodies if body.kind == "input")
    assert driver.turns_per_drum * stage.driver_mm == pytest.approx(stage.sense * own.turns_per_drum * stage.driven_mm)
    apart = np.linalg.norm(np.array(driver.origin_mm) - own.origin_mm)
    assert apart == pytest.approx(stage.centre_mm)


@pytest.mark.parametrize("torque_Nm", [1.0, 3.0, 5.0, 12.0])
def test_gearhead_of_a_belt_leaves_room_for_a_key(torque_Nm: float) -> None:
    text = TEXT.replace("peak_torque_Nm: 2.0", f"peak_torque_Nm: {torque_Nm}")
    layout = layout_of(load_text(text + "stage: {kind: belt}\n").drive)
    found = {one.id: one for one in results(layout)}
    failed = [name for name, one in found.items() if one.status == "fail"]
    assert not failed, (torque_Nm, layout.drive.gearhead.name, failed)
    assert found["stage_key"].margin >= 0.0


def test_strength_is_force_over_what_the_belt_may_carry_and_its_remedy_passes() -> None:
    lay = SpurLayout(drive(BELT))
    stage, check = lay.drive.stage, lay.checks_by_id()["stage_strength"]
    assert stage is not None
    # By hand: peak torque through the ratio, at the driven pulley's radius, lossless: an upper bound of the margin.
    force = 2.0 / 8.0 / (stage.pitch_mm * stage.driven_teeth / (2 * pi) * 1e-3)
    most = 25.0 * 4.448 / 25.4 * stage.width_mm / force
    found = check.measure(lay)
    assert SERVICE <= found.actual < most < 1.35 * found.actual
    weak = lay.with_drive(
        replace(lay.drive, stage=replace(stage, width_mm=0.5 * SERVICE / found.actual * stage.width_mm))
    )
    failed = run_check(check, weak)
    assert failed.status == "fail" and "stage.width_mm" in failed.remedy


def test_stage_with_its_gearhead_loses_as_one_gearhead_of_both() -> None:
    """Energy: motor's power is the payload's and the losses; the stage's part is that of its own efficiency."""
    lay = SpurLayout(drive(GEARS))
    train, stage = lay.losses, lay.drive.stage
    assert stage is not None
    moved = train.moving(1.5, 1)
    turns = lay.drive.total_ratio * stage.ratio * lay.drive.gearhead.ratio
    assert float(moved.motor_Nm[0, 0]) * turns == pytest.approx(1.5 + float(moved.lost_Nm[0]), rel=1e-9)
    of_stage = next(x for x in moved.losses if x.kind == "stage")
    # What comes out of the stage is the load with the losses of cables and bearings.
    before = 1.5 + sum(float(x.torque_Nm[0]) for x in moved.losses if x.kind in ("rope", "bearings"))
    assert before / (before + float(of_stage.torque_Nm[0])) == pytest.approx(stage.efficiency, rel=1e-9)
    back = train.moving(1.5, -1)
    assert float(back.motor_Nm[0, 0]) < float(moved.motor_Nm[0, 0])


def test_motor_sees_ratio_twice_in_speed_and_squared_in_inertia() -> None:
    with_stage = drive(BELT)
    stage = with_stage.stage
    assert stage is not None
    plain = replace(with_stage, stage=None)
    assert with_stage.rotor_at_input_kg_m2 == pytest.approx(plain.rotor_at_input_kg_m2 * stage.ratio**2)
    assert with_stage.motor_turns == pytest.approx(plain.gearhead.ratio * stage.ratio)
    gears = drive(GEARS)
    assert gears.motor_turns < 0.0


@pytest.mark.parametrize("kind", [BELT, GEARS])
def test_rig_turns_by_the_stated_play_and_spring(kind: str) -> None:
    """The rig's own spring with play: the difference to a stage without either is what the ratio makes of both."""
    given = drive(kind)
    stage = given.stage
    assert isinstance(stage, Stage)
    load, ratio = 0.6, given.total_ratio
    firm = replace(given, stage=replace(stage, stated_stiffness_Nm_rad=1e7, stated_lash_arcmin=0.0))
    play = replace(given, stage=replace(stage, stated_stiffness_Nm_rad=1e7, stated_lash_arcmin=20.0))
    soft = replace(given, stage=replace(stage, stated_stiffness_Nm_rad=50.0, stated_lash_arcmin=0.0))
    base = float(np.ptp(held_rad(firm, load)))
    assert np.ptp(held_rad(play, load)) - base == pytest.approx(radians(20.0 / 60.0) / ratio, rel=0.02)
    # A torque load/ratio turns the spring, and that the drum by 1/ratio of it; both ways.
    assert np.ptp(held_rad(soft, load)) - base == pytest.approx(2 * load / ratio / 50.0 / ratio, rel=0.02)
    cause = next(c for c in structure_of(SpurLayout(soft)).causes if c.name == stage.words)
    assert cause.urad_Nm * 1e-6 == pytest.approx(1.0 / ratio**2 / 50.0, rel=1e-6)


def test_prediction_knows_the_play_only_before_the_stage() -> None:
    found = drive(GEARS)
    stage = found.stage
    assert stage is not None
    counted = CountedParts(structure=True, losses=False)
    assert parts_seen(found, counted, motor_side=True).play_rad == pytest.approx(stage.lash_rad)
    assert parts_seen(found, counted, motor_side=False).play_rad == 0.0


@pytest.mark.parametrize("kind", [BELT, GEARS])
def test_parts_have_the_volumes_that_their_masses_count_and_stand_apart(kind: str) -> None:
    lay = SpurLayout(drive(kind))
    dims = lay.stage
    assert dims is not None
    bodies = [Wheel(dims.driven).solid(), Wheel(dims.driver).solid().translate((0.0, dims.stage.centre_mm, 0.0))]
    for body, spec in zip(bodies, (dims.driven, dims.driver), strict=True):
        assert body.Volume() == pytest.approx(spec.volume_mm3, rel=0.02)
    if dims.belt is not None:
        belt = Belt(dims.belt).solid()
        assert belt.Volume() == pytest.approx(dims.belt.volume_mm3, rel=1e-6)
        bodies.append(belt.translate((0.0, 0.0, 1.1)))
    for k, one in enumerate(bodies):
        for other in bodies[:k]:
            assert one.intersect(other).Volume() < 1e-6


@pytest.mark.parametrize("kind", [BELT, GEARS])
def test_motor_head_and_pulley_have_their_volumes_and_sheets(kind: str) -> None:
    made = SpurLayout(drive(kind)).bill().made
    for name in ("motor_head", "input_pulley_main"):
        part = made[name]
        assert part.solid().Volume() == pytest.approx(part.volume_mm3(), rel=0.01), name
        assert part.sheet(name).dimensions


def test_other_kind_and_other_layouts_are_refused_with_a_remedy() -> None:
    with pytest.raises(InputError, match="given for a stage of kind belt"):
        load_text(TEXT + "stage: {kind: belt, ratio: 3.0, module_mm: 1.0}\n")
    with pytest.raises(InputError, match="a second cable stage is the block first_stage"):
        load_text(TEXT + "second_stage: {transmission: {input_to_drum: 6.0}}\n")
    for layout in ("siso_bevel", "miso_bevel"):
        text = f"name: x\nconfiguration: {layout}\ntravel: {{half_angle_deg: 20.0}}\nloads: {{peak_torque_Nm: 1.0}}\n"
        radius = ", drum_radius_mm: 58.0"
        ratio = "input_to_drum: 4.0" if layout == "siso_bevel" else "ratio: 6.0"
        text += f"transmission: {{{ratio}{radius}}}\nstage: {BELT}\n"
        with pytest.raises(InputError, match="siso_spur or miso_spur"):
            load_text(text)


@pytest.mark.parametrize("encoder", [True, False])
def test_its_play_turns_the_drum_where_no_sensor_sees_it(encoder: bool) -> None:
    """The drum's play is the input's over the ratio: all of the difference between a stage with and without play."""
    given, loads = drive(GEARS), ("payload", "drum_encoder", "motors_held")
    if not encoder:
        given = replace(given, encoder=replace(given.encoder, name=NO_ENCODER))
    assert given.stage is not None and given.encoder.absent is not encoder

    def swings(arcmin: float) -> dict[str, float]:
        at = turns_at(layout_of(replace(given, stage=replace(given.stage, stated_lash_arcmin=arcmin))), 0.6)
        return {name: getattr(at, name).swing_mrad for name in loads} | {"turn": at.motors_held.turn_mrad}

    loose, tight = swings(20.0), swings(0.0)
    play = radians(20.0 / 60.0) / 8.0 * 1e3
    wanted = {"payload": 0.0, "drum_encoder": 0.0} if encoder else {"payload": play, "drum_encoder": play}
    wanted |= {"motors_held": play, "turn": play / 2}
    assert {name: loose[name] - tight[name] for name in wanted} == pytest.approx(wanted, abs=1e-9)


def test_the_collar_turns_in_its_own_radius_beside_a_larger_wheel() -> None:
    """At the bearing shelf the wall is as far from the collar as its own sweep leaves, whatever the wheel's radius."""
    found = SpurLayout(drive(GEARS))
    gaps, h, c, v = dict(collar_gaps(found)), found.head, found.collar, found.levels
    assert found.stage is not None
    sweep = collar_sweep_mm(found.drive)
    assert found.stage.stage.reach_mm(found.stage.stage.driven_mm) > sweep
    corner = min(h.corner_radius, 0.49 * (v.bearing_shelf_bottom_z - v.motor_shelf_top_z))
    # By hand: its sweep ends before the rounding of the corner.
    assert sweep < h.inner_x - corner
    wanted = min(h.inner_x - sweep, v.bearing_shelf_bottom_z - c.top_z)
    assert gaps["clamp collar from walls and bearing shelf"] == pytest.approx(wanted)
    assert gaps["wheel from walls and bearing shelf"] < gaps["clamp collar from walls and bearing shelf"]


def test_bridge_stands_over_the_pulley_not_at_the_edge_of_a_wide_flange() -> None:
    wide = layout_of(drive("{kind: belt, ratio: 6.0}")).frame
    plain = layout_of(drive("")).frame
    assert wide.plate_top_z > wide.top_z + 5.0, "the plate carries the wheel's flange"
    assert wide.bridge_bottom_z - wide.axis_z < plain.bridge_bottom_z - plain.axis_z + 1.0
    assert plain.plate_top_z == plain.top_z
