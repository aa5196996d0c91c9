"""Two cable stages in series: figures by other routes, kinematics, checks, parts, the rig, messages."""

import re
from dataclasses import replace
from functools import cache
from itertools import combinations
from math import radians
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mbcdm_cad as mc
from mbcdm_cad.checks.run import run_check
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.jobs.outputs import write_experiment
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.loader import layout_of, load_text
from mbcdm_cad.layouts.siso_spur.checks.stage import FAMILIES, motor_beside_mm
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive, spur
from mbcdm_cad.layouts.siso_spur.first_stage import MOST_TRAVEL_DEG, split_ratio
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.layouts.turns import turns_of
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.losses import MOTOR
from mbcdm_cad.report.analysis_report import analyse_design
from mbcdm_cad.report.losses import stage_figures
from mbcdm_cad.workshop.kernel import location, validate_solid
from tests.support.checked import failing, held_rad, results

TEXT = """\
name: series
configuration: siso_spur
travel: {half_angle_deg: 30.0}
transmission: {drum_radius_mm: 60.0}
first_stage: {total_ratio: 24.0}
loads: {peak_torque_Nm: 5.0}
drive: {gearhead: none}
"""


SERVO = """\
name: series
configuration: siso_spur
travel: {half_angle_deg: 30.0}
transmission: {drum_radius_mm: 60.0}
first_stage:
  total_ratio: 6.0
  design: {input_pulleys: {carried_by: motor}, drum: {material: pla}, rope: {type: uhmwpe-1}}
loads: {peak_torque_Nm: 3.0}
drive: {motor: servo-35kg-25t, drum_encoder: none}
"""


SOFT = """\
name: soft
seed: 3
duration_s: 160.0
motion: {shape: triangle, amplitude_mrad: 450.0, period_s: 32.0}
load: {kind: torque_motor, wave: sine, levels_Nm: [1.5], wave_period_s: 13.0, bias_Nm: 0.5}
sensors: {input_at: AT}
physics: {cable_transport: false, structure: true}
"""


# Cables of the second stage side by side.
PARALLEL = pytest.mark.parametrize("parallel", [1, pytest.param(2, marks=pytest.mark.slow)])


@cache
def series(parallel: int = 1) -> SpurDrive:
    text = TEXT.replace("60.0}", f"60.0, parallel: {parallel}}}") if parallel > 1 else TEXT
    return spur(load_text(text, "series.yaml").drive)


def both(parallel: int = 1) -> tuple[SpurLayout, SpurLayout]:
    """The whole and its first stage."""
    whole = layout_of(series(parallel))
    assert isinstance(whole, SpurLayout) and whole.first_stage_unit is not None
    return whole, whole.first_stage_unit


@PARALLEL
def test_a_short_file_passes_and_names_the_stage_of_each_check(parallel: int) -> None:
    found = results(series(parallel))
    assert [r.id for r in found if r.status == "fail"] == []
    ids = [r.id for r in found]
    assert len(ids) == len(set(ids))
    of_first = [r for r in found if r.id.startswith("first_stage_") and r.title.startswith("First stage: ")]
    assert len(of_first) > 80


@settings(max_examples=60, deadline=None)
@given(total=st.floats(2.0, 400.0), travel=st.floats(5.0, 110.0))
def test_the_split_is_even_unless_the_first_drum_would_turn_too_far(total: float, travel: float) -> None:
    data = {"first_stage.total_ratio": total, "travel.half_angle_deg": travel, "travel.stop_clearance_deg": 0.25}
    last = split_ratio(data.get)
    assert last >= 1.0
    if last > 1.0:
        assert last * (travel + 0.25) <= MOST_TRAVEL_DEG + 1e-9
        assert last <= total**0.5 + 0.05
    # Half a step more would either turn the drum too far or leave less to the first stage than to this one.
    assert (last + 0.05) * (travel + 0.25) > MOST_TRAVEL_DEG or last + 0.05 >= total**0.5


def test_ratio_is_the_product_and_the_motor_turns_as_the_input() -> None:
    whole, first = both()
    assert whole.drive.total_ratio * first.drive.total_ratio == pytest.approx(24.0)
    # Both crossings turn the sense back: motor and drum turn the same way, in the assembly.
    drum, _, driver = (whole.moving_bodies[k] for k in (0, 1, 2))
    assert driver.turns_per_drum * np.array(driver.axis) == pytest.approx(24.0 * np.array(drum.axis))
    assert whole.drive.motor_turns == pytest.approx(-first.drive.total_ratio)


@PARALLEL
def test_ends_of_the_first_cable_move_with_the_input_and_its_length_stays(parallel: int) -> None:
    whole, first = both(parallel)
    body = next(b for b in whole.moving_bodies if b.kind == "input")
    centred = whole.all_cable_paths(0.0)[-1]
    assert centred.cable.name.startswith("first_") and centred.diameter_mm == first.drive.cable.diameter_mm
    ends = [centred.line[0].points(np.array([0.0]))[0], centred.line[-1].points(np.array([1.0]))[0]]
    for angle_deg in (-30.0, -7.0, 19.0, 30.0):
        path = whole.all_cable_paths(np.radians(angle_deg))[-1]
        assert path.length_mm == pytest.approx(centred.length_mm, abs=1e-6)
        motion = body.motion(angle_deg) @ body.motion(0.0).inverse
        now = [path.line[0].points(np.array([0.0]))[0], path.line[-1].points(np.array([1.0]))[0]]
        assert np.allclose([motion.apply(end) for end in ends], now, atol=1e-6)


@PARALLEL
def test_stages_give_as_springs_in_series(parallel: int) -> None:
    """The energy in both under one load: that of each stage alone under its own torque, by its own figures."""
    whole, first = both(parallel)
    load, ratio = whole.drive.loads.test_torque_Nm, whole.drive.total_ratio
    alone = turns_of(first).motors_held
    assert alone is not None and first.drive.loads.test_torque_Nm == pytest.approx(load / ratio)
    hub = next(c.urad_Nm for c in structure_of(first).causes if c.name == "drum: hub to the payload")
    shaft = first.drum_shaft
    polar_m4 = np.pi / 2.0 * (shaft.radius**4 - shaft.bore_radius**4) * 1e-12
    steel = first.drive.shaft_material
    modulus = steel.youngs_modulus_GPa * 1e9 / 2.0 / (1.0 + steel.poisson_ratio)
    twist = (load / ratio) * (shaft.flat_y - shaft.y_start) * 1e-3 / modulus / polar_m4
    torque = load / ratio
    energy = 0.5 * torque * (alone.turn_mrad * 1e-3 - hub * 1e-6 * torque + twist)
    held, free = turns_of(whole).payload, turns_of(whole).motors_held
    assert held is not None and free is not None
    own = next(c.urad_Nm for c in structure_of(whole).causes if c.name == "input pulleys, torsion")
    assert 0.5 * load * (free.turn_mrad - held.turn_mrad) * 1e-3 == pytest.approx(
        energy + 0.5 * load**2 * own * 1e-6, rel=1e-9
    )


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("share", [0.2, 0.5, 1.0])
def test_losses_of_both_stages_are_those_of_each_alone(way: int, share: float) -> None:
    """Power: from the load through the second stage alone to the torque on the first, through that to the motor."""
    whole, first = both()
    load = share * whole.drive.loads.peak_torque_Nm
    together = whole.losses.moving(load, way)
    second = replace(whole.losses, gear_ratio=1.0, gear_share=0.0, gear_idle_Nm=0.0, motor_idle_Nm=0.0)
    on_first = float(second.moving(load, way).motor_Nm[0, 0])
    if on_first * way <= 0.0:
        pytest.skip("the load does not reach the first stage")
    alone = first.losses.with_drive(first.loads.si).moving(abs(on_first), way)
    idle = float(next(x for x in alone.losses if x.kind == MOTOR).torque_Nm[0])
    assert idle > 0.0
    assert float(together.motor_Nm[0, 0]) == pytest.approx(float(alone.motor_Nm[0, 0]), rel=5e-3)


def _swing_rad(d: SpurDrive, load_Nm: float) -> float:
    """Swing of the drum's encoder in the rig between loads of both signs, the motor's motion taken off."""
    return float(np.ptp(held_rad(d, load_Nm) - held_rad(d, 1e-6)))


def test_play_before_the_first_stage_turns_the_drum_by_it_over_both_ratios() -> None:
    """By hand: the play of the servo's gears over the product of both ratios, as the file states it."""
    found = spur(load_text(SERVO, "series.yaml").drive)
    spring = found.cable_stage
    assert found.first_stage is not None and found.first_stage.servo is not None and spring is not None
    play, load = radians(found.first_stage.servo.lash_deg) / 6.0, found.loads.test_torque_Nm
    tight = replace(found, gearhead=replace(spring, lash_rad=0.0))
    loose, held = turns_of(layout_of(found)).motors_held, turns_of(layout_of(tight)).motors_held
    assert loose is not None and held is not None and play > 1e-3
    assert (loose.swing_mrad - held.swing_mrad) * 1e-3 == pytest.approx(play, rel=1e-6)
    assert np.ptp(held_rad(found, load) - held_rad(tight, load)) == pytest.approx(play, rel=2e-3)


@PARALLEL
def test_rig_of_both_turns_as_the_rigs_of_each(parallel: int) -> None:
    """The first stage in a rig of its own, slip on its wraps counted, at the torque that the second one gives it."""
    whole, first = both(parallel)
    load, ratio, spring = whole.drive.loads.test_torque_Nm, whole.drive.total_ratio, whole.drive.cable_stage
    assert spring is not None
    rigid = replace(whole.drive, gearhead=replace(spring, stiffness_Nm_rad=1e9))
    added = _swing_rad(whole.drive, load) - _swing_rad(rigid, load)
    # Its own rig does not have the twist of the shaft's end.
    end = first.drum_shaft
    twist = 2.0 * load / ratio**2 * _twist_rad_Nm(first, end.flat_y - end.y_start)
    alone = _swing_rad(first.drive, load / ratio) / ratio
    assert added == pytest.approx(alone + twist, rel=0.03), (added, alone, twist)


@pytest.mark.slow
@pytest.mark.parametrize(("input_at", "seen"), [("motor", True), ("pulley", False)])
def test_loop_finds_a_soft_first_stage_only_from_the_motor(input_at: str, seen: bool, tmp_path: Path) -> None:
    drive, spring = series(), series().cable_stage
    assert spring is not None and spring.stiffness_Nm_rad is not None
    (tmp_path / "soft.yaml").write_text(SOFT.replace("AT", input_at), "utf-8")
    soft = replace(drive, gearhead=replace(spring, stiffness_Nm_rad=0.5 * spring.stiffness_Nm_rad))
    write_experiment(soft, tmp_path / "soft.yaml", tmp_path / "out")
    (tmp_path / "series.yaml").write_text(TEXT, "utf-8")
    result = mc.close_loop(mc.load(tmp_path / "series.yaml"), tmp_path / "out/soft/soft.yaml")
    words = str(result)
    assert ("lacks stiffness_error" in words) == seen, words
    more = 1e6 / spring.stiffness_Nm_rad / drive.total_ratio**2
    if seen:
        found = re.search(r"compliance ([0-9.]+) urad", words)
        assert found is not None and float(found[1]) == pytest.approx(more, rel=0.02), words


def test_both_stages_add_up_in_the_report() -> None:
    whole, first = both()
    one, two, all_ = stage_figures(whole)
    assert one.ratio * two.ratio == pytest.approx(all_.ratio) == pytest.approx(24.0)
    held = turns_of(whole).motors_held
    assert held is not None and all_.urad_Nm is not None
    assert all_.urad_Nm * turns_of(whole).load_Nm * 1e-3 == pytest.approx(held.turn_mrad, rel=1e-9)
    moving = whole.losses.moving(whole.drive.loads.peak_torque_Nm, 1)
    motors = sum(float(x.torque_Nm[0]) for x in moving.losses if x.kind == MOTOR)
    assert all_.lost_Nm == pytest.approx(float(moving.lost_Nm[0]) - motors)
    assert one.travel_deg == pytest.approx(first.drive.half_travel_deg)
    found = analyse_design(whole.drive).to_dict()
    assert found["first_stage"]["structure"] and [s["stage"] for s in found["stages"]] == ["first", "second", "both"]
    # Its rope bends sharper than the data on life reach: the second stage's figure does not stand alone.
    assert one.life_cycles is None and "may break first" in one.no_life, one
    text = analyse_design(whole.drive).text()
    assert one.no_life in text and "torque that the first stage is made for" in text and "gearhead's cont" not in text


def _twist_rad_Nm(first: SpurLayout, length_mm: float) -> float:
    shaft, steel = first.drum_shaft, first.drive.shaft_material
    polar_m4 = np.pi / 2.0 * (shaft.radius**4 - shaft.bore_radius**4) * 1e-12
    return length_mm * 1e-3 * 2.0 * (1.0 + steel.poisson_ratio) / (steel.youngs_modulus_GPa * 1e9) / polar_m4


def test_inertia_counts_both_stages_by_their_speeds() -> None:
    whole, first = both()
    bodies = first.inertias_kg_m2
    by_hand = bodies["drum"] + bodies["input_main"] * first.drive.total_ratio**2
    plain = replace(whole.drive, first_stage=None, gearhead=first.drive.gearhead)
    own = SpurLayout(plain).inertias_kg_m2["input_main"]
    assert whole.inertias_kg_m2["input_main"] - own == pytest.approx(by_hand, rel=0.01), "its collar is another"
    rotor = first.drive.motor.rotor_inertia_g_cm2 * 1e-7
    assert whole.drive.rotor_at_input_kg_m2 == pytest.approx(rotor * first.drive.total_ratio**2)


@pytest.mark.parametrize("check", [c for c in FAMILIES[1].checks if c.id.startswith("shaft_end")], ids=lambda c: c.id)
def test_checks_of_the_shaft_end_have_their_border(check) -> None:  # type: ignore[no-untyped-def]
    """Torque is raised until each fails; the twist is compared at the test torque, and so by a thin shaft."""
    _, first = both()
    assert check.measure(first).holds
    if check.id == "shaft_end_twist":
        thin = replace(first.drum_shaft, radius=0.3 * first.drum_shaft.radius, bore_radius=0.0)
        assert run_check(check, first.with_dimensions(drum_shaft=thin)).status == "fail"
        return
    loads = replace(first.drive.loads, peak_torque_Nm=200.0 * first.drive.loads.peak_torque_Nm)
    assert run_check(check, first.with_drive(replace(first.drive, loads=loads))).status == "fail"


def test_room_between_stages_is_no_more_than_that_between_their_solids() -> None:
    import cadquery as cq

    whole, first = both()
    bill = whole.bill()
    items = {item.name: item for item in bill.items}

    def solid(name: str) -> cq.Shape:
        item = items[name]
        return bill.parts[item.part].part.solid().moved(cq.Location(location(item.location)))

    motor = solid("first_motor_main")
    gaps = [motor.distance(solid(name)) for name in ("motor_head", "frame")]
    room = whole.drive.clearances.running_mm - motor_beside_mm(whole, first)
    assert whole.drive.clearances.running_mm <= room + 1e-9 and room <= min(gaps) + 1e-6


def test_parts_at_the_joint_share_no_volume_and_have_their_own() -> None:
    import cadquery as cq

    whole, _ = both()
    bill = whole.bill(11.0)
    joint = ("first_frame", "first_drum_shaft", "first_drum_bearing_rear", "motor_head", "collar_main")
    screws = tuple(f"first_stage_screw_main_{n}" for n in range(1, 5))
    names = (*joint, "input_pulley_main", "frame", *screws)
    items = {item.name: item for item in bill.items if item.name in names}
    assert set(items) == set(names)
    shapes = {
        name: bill.parts[item.part].part.solid().moved(cq.Location(location(item.location)))
        for name, item in items.items()
    }
    for one, other in combinations(names, 2):
        if {one, other} & {"collar_main"} and "input_pulley_main" in (one, other):
            continue  # clamped on the journal, which it touches all round
        threaded = "screw" in one + other and "first_frame" in (one, other)
        shared = shapes[one].intersect(shapes[other]).Volume()
        assert shared < (30.0 if threaded else 1e-3), (one, other, shared)
    for name in ("first_frame", "first_drum_shaft"):
        made = bill.made[items[name].part]
        body = made.solid()
        validate_solid(name, body)
        assert body.Volume() == pytest.approx(made.volume_mm3(), rel=0.01), name
        assert made.sheet(name).dimensions
    # The shaft ends within the clamp collar, and its face lies on the motor head's.
    box = shapes["first_drum_shaft"].BoundingBox()
    collar = shapes["collar_main"].BoundingBox()
    assert box.ymax >= collar.ymin + whole.drive.gearhead.shaft_diameter_mm - 1e-6
    assert shapes["first_frame"].distance(shapes["motor_head"]) < 1e-6


def test_every_item_joins_once_and_the_first_stage_first() -> None:
    whole, _ = both()
    joined = [name for step in whole.assembly_order for name in step.items]
    assert sorted(joined) == sorted(item.name for item in whole.bill().items)
    of_first = [k for k, step in enumerate(whole.assembly_order) if step.text.startswith("First stage: ")]
    assert of_first == list(range(len(of_first)))


def test_load_on_the_first_stage_is_what_it_was_sized_for() -> None:
    whole, first = both()
    d, peak = whole.loads.si, whole.drive.loads.peak_torque_Nm
    for sign in (1.0, -1.0):
        lossless = abs(float(solve_equilibrium(d, sign * peak).input_torque_Nm(d)[0]))
        assert lossless < first.drive.loads.peak_torque_Nm
    assert run_check(next(c for c in checks_of(whole.drive) if c.id == "gearhead_maximum"), whole).status == "pass"


def _with(line: str, text: str = TEXT) -> str:
    key = line.split(":")[0]
    kept = [old for old in text.splitlines() if not old.startswith(f"{key}:")]
    return "\n".join([*kept, line, ""])


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("transmission: {input_to_drum: 40.0}", "the drum of the first stage turns by the ratio of the second stage"),
        ("first_stage: {total_ratio: 20.0, ratio: 3.0, design: {travel: {half_angle_deg: 3.0}}}", "has no place in a"),
        ("first_stage: {total_ratio: 20.0, design: {drum: {web: 3.0}}}", "first_stage.design.drum.web: unknown field"),
        ("first_stage: {total_ratio: 20.0, design: {rope: {type: none-such}}}", "first_stage.design.rope.type"),
        ("stage: {kind: belt, ratio: 3.0}", "not beside first_stage"),
        ("input_pulleys: {carried_by: motor}", "turns an input in bearings"),
        ("configuration: miso_spur", "the block first_stage: {total_ratio: 24.0} of a siso_spur file"),
    ],
)
def test_what_it_cannot_be_is_refused_with_its_place(line: str, says: str) -> None:
    with pytest.raises(MbcdmError, match=r"series\.yaml:\d+: ") as caught:
        load_text(_with(line), "series.yaml")
    assert says in str(caught.value)


def test_three_ratios_that_disagree_are_refused() -> None:
    text = _with("first_stage: {total_ratio: 24.0, ratio: 6.0}", _with("transmission: {input_to_drum: 3.0}"))
    with pytest.raises(MbcdmError, match="not the product of both ratios"):
        load_text(text, "series.yaml")


def test_a_file_without_any_ratio_gets_a_first_stage_and_a_motor_by_rule() -> None:
    text = _with("first_stage: {}", TEXT.replace("drive: {gearhead: none}\n", ""))
    found = spur(load_text(text, "series.yaml").drive)
    assert found.first_stage is not None and found.motor == found.first_stage.motor
    assert failing(found) == {}
