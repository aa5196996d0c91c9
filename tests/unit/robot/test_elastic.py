"""The elastic MJCF in MuJoCo at its own step of 0.5 ms, compared with the rig and with closed forms."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from mbcdm_cad.design.blocks import AsBuilt, AsBuiltValue, Payload
from mbcdm_cad.design.resolve import with_as_built
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.layouts.turns import modes_of
from mbcdm_cad.loop.effects.friction import BEYOND, CONSTANT, DRIVEN, DRIVING, STRIBECK, VISCOUS, bases
from mbcdm_cad.model.analysis import analyse
from mbcdm_cad.rig.experiment import Experiment
from mbcdm_cad.rig.quasistatic import simulate
from mbcdm_cad.robot.elastic import ElasticDrive, elastic_drive, left_out, slipping
from mbcdm_cad.robot.fmu import fmu_file
from mbcdm_cad.robot.mechanism import Mechanism
from mbcdm_cad.robot.mjcf import robot_files
from tests.support.reference import PARAMS
from tests.unit.robot.test_play import _mechanism as light
from tests.unit.robot.test_play import drive as staged

mujoco = pytest.importorskip("mujoco", minversion="4.0")


@pytest.fixture(scope="module")
def soft(loaded: Any) -> ElasticDrive:
    return elastic_drive(loaded.drive)


@pytest.fixture(scope="module")
def path(robot: Mechanism, soft: ElasticDrive, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("elastic")
    for name, content in robot_files(robot, "mjcf", elastic=soft).items():
        (out / name).parent.mkdir(parents=True, exist_ok=True)
        (out / name).write_bytes(content)
    return out / "mbcdm.xml"


@pytest.fixture
def model(path: Path) -> Any:
    found = mujoco.MjModel.from_xml_path(str(path))
    found.opt.gravity[:] = 0.0
    assert found.opt.timestep == 0.0005
    return found


def started(model: Any) -> Any:
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    return data


def hold_inputs(model: Any, at_drum_Nm: float = 0.0) -> None:
    for name in ("input_left", "input_right"):
        model.dof_frictionloss[model.joint(name).dofadr[0]] = 10.0
    model.dof_frictionloss[model.joint("drum").dofadr[0]] = at_drum_Nm


def turned(data: Any, weights: Any, at: str) -> float:
    """Output less the inputs by their encoders, at the drum; the drive's inputs turn nine times as far."""
    inputs = [data.sensor(f"{name}_encoder").data[0] / 9.0 for name in ("input_left", "input_right")]
    return float(data.sensor(at).data[0] - np.dot(weights, inputs))


def loop(model: Any, soft: ElasticDrive, torque_Nm: float, period_s: float = 2.0) -> tuple[Any, dict[str, Any]]:
    """Load (n,) and turns by sensor (n,) over the last of 2.25 periods of a torque on the payload."""
    stiff = np.array([stage.sticking_Nm_rad for stage in soft.stages])
    data, drum, payload = started(model), model.joint("drum").dofadr[0], model.joint("payload").dofadr[0]
    load = torque_Nm * np.sin(2.0 * np.pi * np.arange(round(2.25 * period_s / 0.0005)) * 0.0005 / period_s)
    found: dict[str, Any] = {name: np.zeros(load.size) for name in ("payload_angle", "drum_encoder")}
    for k, now in enumerate(load):
        data.qfrc_applied[[drum, payload]] = -now
        mujoco.mj_step(model, data)
        for name, turns in found.items():
            turns[k] = turned(data, stiff / stiff.sum(), name)
    last = slice(round(1.25 * period_s / 0.0005), None)
    return load[last], {name: turns[last] for name, turns in found.items()}


def area_J(load: Any, turn: Any) -> float:
    return abs(float(np.trapezoid(np.append(load, load[0]), np.append(turn, turn[0]))))


def rig_loop(drive: Any, torque_Nm: float) -> Any:
    exact = {"input_resolution_rad": 0.0, "output_resolution_rad": 0.0, "torque_noise_Nm": 0.0}
    return simulate(
        drive,
        Experiment.model_validate(
            {
                "name": "loop",
                "duration_s": 45.0,
                "motion": {"shape": "hold", "amplitude_mrad": 1e-6, "period_s": 1.0, "stray_urad": 0.0},
                "load": {"kind": "torque_motor", "wave": "sine", "wave_period_s": 20.0, "levels_Nm": [torque_Nm]},
                "sensors": exact,
                "physics": {"cable_transport": False, "structure": True},
            }
        ),
    )


@pytest.mark.parametrize("share", [0.3, 1.0, 2.0])
def test_swing_and_loop_are_those_of_simulate(model: Any, soft: ElasticDrive, loaded: Any, share: float) -> None:
    """The inputs held, without the friction of the drum, which both have besides the loop of the cables."""
    hold_inputs(model)
    torque = share * loaded.drive.loads.test_torque_Nm
    rig, last = rig_loop(loaded.drive, torque), slice(2500, None)
    load, turns = loop(model, soft, torque)
    for at, angle in (("payload_angle", rig.payload_rad[last]), ("drum_encoder", rig.drum_rad[last])):
        turn = turns[at]
        assert np.ptp(turn) == pytest.approx(np.ptp(angle), rel=0.02), (at, np.ptp(turn), np.ptp(angle))
        wanted = area_J(rig.load_Nm[last], angle)
        assert area_J(load, turn) == pytest.approx(wanted, rel=0.1), (at, area_J(load, turn), wanted)


def test_friction_at_the_drum_keeps_its_part_of_the_load_from_the_cables(
    model: Any, soft: ElasticDrive, loaded: Any
) -> None:
    torque = loaded.drive.loads.test_torque_Nm
    hold_inputs(model, soft.drum_friction_Nm)
    turn = loop(model, soft, torque)[1]["drum_encoder"]
    cables = rig_loop(loaded.drive, torque - soft.drum_friction_Nm)
    parts = structure_of(layout_of(loaded.drive)).encoder_urad_Nm * 1e-6
    wanted = np.ptp(cables.drum_rad[2500:]) + 2.0 * parts * soft.drum_friction_Nm
    assert np.ptp(turn) == pytest.approx(wanted, rel=0.05), (np.ptp(turn), wanted)
    shares = sum(bend.share for bend in layout_of(loaded.drive).losses.rope if not bend.on_input)
    rope = sum(s * c.preload_N * c.drum_radius_mm for s, c in zip(shares, loaded.drive.cables, strict=True))
    assert soft.drum_friction_Nm == pytest.approx(rope * 1e-3, rel=0.05), "bearings take little of it"


def test_a_payload_rings_at_the_mode_of_cables_and_parts(model: Any, soft: ElasticDrive, loaded: Any) -> None:
    """A payload of 0.02 kg m2 against the rotors, wraps stuck, motors off; a short step with little damping."""
    heavy = 0.02
    model.dof_frictionloss[:] = [10.0 * ("slip" in model.joint(k).name) for k in range(model.njnt)]
    model.opt.timestep = 2e-5
    model.dof_damping[:] *= 0.04
    model.tendon_damping[:] *= 0.04
    model.tendon_lengthspring[:] = 0.0
    model.actuator_gear[:] = 1e-9
    model.body("payload").inertia[:] = heavy
    mujoco.mj_setConst(model, mujoco.MjData(model))
    data = started(model)
    data.qvel[model.joint("payload").dofadr[0]] = 1e-2
    seen = np.zeros(15000)
    for k in range(seen.size):
        mujoco.mj_step(model, data)
        seen[k] = data.qpos[model.joint("payload").qposadr[0]]
    spectrum = np.abs(np.fft.rfft((seen - seen.mean()) * np.hanning(seen.size), 1 << 19))
    found = float(np.fft.rfftfreq(1 << 19, 2e-5)[spectrum.argmax()])
    sticking = sum(stage.sticking_Nm_rad for stage in soft.stages)
    give = 1.0 / sticking + soft.compliance.land_to_payload
    rotors = 81.0 * sum(model.dof_armature[model.joint(f"input_{side}").dofadr[0]] for side in ("left", "right"))
    expected = np.sqrt((1.0 / heavy + 1.0 / rotors) / give) / 2.0 / np.pi
    assert found == pytest.approx(expected, rel=0.03), (found, expected)
    page = modes_of(layout_of(carrying(loaded.drive, heavy))).inputs_free_Hz
    assert min(abs(found / mode - 1.0) for mode in page) < 0.03, (found, page)


def carrying(drive: Any, inertia_kg_m2: float) -> Any:
    """The drive with a payload."""
    return replace(drive, loads=replace(drive.loads, payload=Payload(inertia_kg_m2=inertia_kg_m2)))


def test_a_stalled_motor_warms_as_one_body_does(model: Any, soft: ElasticDrive) -> None:
    motor = soft.motor
    data = started(model)
    at = model.actuator("input_left_motor").actadr[0]
    states = model.actuator("input_left_motor").actnum[0]
    assert states == 2, "temperature and bristle"
    for name in ("input_left", "input_right"):
        model.dof_frictionloss[model.joint(name).dofadr[0]] = 10.0
    data.ctrl[:] = motor.peak_Nm
    for _ in range(2000):
        mujoco.mj_step(model, data)
    power = motor.resistance_ohm * (motor.peak_Nm / motor.constant_Nm_A) ** 2
    cold = 1.0 + motor.copper_per_K * (motor.ambient_C - motor.rated_at_C)
    warmer = data.act[at : at + states].max()
    assert warmer == pytest.approx(power * cold / motor.heat_J_K, rel=0.02), (warmer, power * cold / motor.heat_J_K)


def test_the_fit_follows_loops_of_other_drives() -> None:
    for name, worst in (("siso_spur", 0.03), ("miso_spur", 0.03), ("siso_bevel", 0.12)):
        drive = load_design(PARAMS / f"{name}.yaml").drive
        soft = elastic_drive(drive)
        torque = drive.loads.test_torque_Nm
        run = simulate(
            drive,
            Experiment.model_validate(
                {
                    "name": "loop",
                    "duration_s": 45.0,
                    "motion": {"shape": "hold", "amplitude_mrad": 1e-6, "period_s": 1.0, "stray_urad": 0.0},
                    "load": {"kind": "torque_motor", "wave": "sine", "wave_period_s": 20.0, "levels_Nm": [torque]},
                    "sensors": {"input_at": "motor"},
                    "physics": {"cable_transport": False, "structure": True},
                }
            ),
        )
        # The drum where the cables lie on it; the motors stand.
        land = run.drum_rad + soft.compliance.land_to_encoder * run.load_Nm
        carried = np.zeros(land.size)
        for stage in soft.stages:
            # At rest the preload has twisted the gearhead of a motor that stands where its angle is 0.
            give = 1.0 / soft.compliance.before_inputs_Nm_rad / soft.turns[stage.input_index] ** 2
            twist = np.append(0.0, land + stage.preload_Nm * give)
            carried += stage.preload_Nm - stage.spring_Nm_rad * twist[1:]
            for slip in stage.slips:
                limit = slip.limit_Nm / slip.stiffness_Nm_rad
                carried -= slip.stiffness_Nm_rad * slipping(twist, limit)[1:]
        off = np.abs(carried - run.load_Nm)[1:].max() / torque
        assert off < worst, (name, off)


def test_a_drive_as_built_carries_its_effects(loaded: Any, soft: ElasticDrive) -> None:
    """A softer rope, as the loop writes it into the file, changes the fit as it changes the model."""
    share = AsBuiltValue(name="share", value=-0.2)
    entry = AsBuilt(name="stiffness_error", form="modulus of the rope", values=(share,))
    built = with_as_built(loaded.drive, (entry,))
    ratio = analyse(layout_of(built)).reversal_swing_mrad / analyse(layout_of(loaded.drive)).reversal_swing_mrad
    soften = [1.0 / sum(stage.sticking_Nm_rad for stage in of.stages) for of in (soft, elastic_drive(built))]
    assert ratio > 1.1
    wanted = 0.25 / analyse(layout_of(loaded.drive)).sticking_stiffness_Nm_rad
    assert soften[1] - soften[0] == pytest.approx(wanted, rel=0.1), (soften, wanted)


_PAGE = Path(__file__).parents[3] / "docs" / "robot-formats.md"


def _lifts_at(model: Any, drive: Any, load_Nm: float, step: Any) -> float:
    """Share of the motors' torque by ``analyse`` at which they begin to lift a load, in a ramp from 0.3 on."""
    needs = layout_of(drive).losses.moving(load_Nm, 1).motor_Nm[:, 0]
    data, at = started(model), [model.joint(name).dofadr[0] for name in ("drum", "payload")]
    angle: list[float] = []
    for k in range(3000):
        share = 0.3 + k * model.opt.timestep
        # A saturated motor gives no more: the ramp ends well below.
        data.ctrl[:] = share * needs
        data.qfrc_applied[at] = -load_Nm
        step(model, data)
        angle.append(data.sensor("payload_angle").data[0])
        if k > 200 and angle[-1] - angle[-100] > 0.02 * 0.05:
            return share
    raise AssertionError("it lifts nothing")


def _with_losses() -> Any:
    """The function of the page."""
    code = re.search(r"```python\n(def step_with_losses.*?)```", _PAGE.read_text("utf-8"), re.S)
    assert code
    scope: dict[str, Any] = {"mujoco": mujoco}
    exec(code[1], scope)
    return scope["step_with_losses"]


def test_motors_lift_with_the_torque_that_analyse_states_once_gears_lose_with_the_load(
    model: Any, soft: ElasticDrive, loaded: Any
) -> None:
    """With the page's lines; without them the gearheads lose under the preload only, and they lift with less."""
    load = loaded.drive.loads.test_torque_Nm
    # The page's lines leave their friction in the model.
    plain = _lifts_at(model, loaded.drive, load, mujoco.mj_step)
    counted = _lifts_at(model, loaded.drive, load, _with_losses())
    assert counted == pytest.approx(1.0, abs=0.05), (counted, plain)
    assert plain < 0.92, (counted, plain)


FADES, LOAD_NM = 0.1, 0.6
_FOUND = {"torque_Nm": 0.04, "drag_Nm_s": 3.0, "stribeck_Nm": 0.1, "driving_share": 0.3, "driven_share": 0.2}


def as_found(drive: Any, **values: float) -> Any:
    """The drive with a friction at its drum, as the loop writes it."""
    listed = tuple(AsBuiltValue(name=name, value=value) for name, value in values.items())
    return with_as_built(drive, (AsBuilt(name="friction", form=f"{BEYOND.form}: Stribeck", values=listed),))


def steady_rad_s(own_Nm: float, load_Nm: float) -> float:
    """Speed to which a load that moves the drive brings it: there the loop's formula takes the whole of it."""
    terms = (CONSTANT, VISCOUS, STRIBECK, DRIVING, DRIVEN)

    def left(speed: float) -> float:
        rows = bases(terms, np.ones(1), np.array([speed]), np.array([-load_Nm]), FADES)[:, 0]
        return load_Nm - own_Nm - float(np.dot(list(_FOUND.values()), rows))

    return float(brentq(left, 0.01, 10.0))


@pytest.mark.slow
def test_a_friction_found_on_the_drum_takes_what_the_loops_formula_says(tmp_path: Path) -> None:
    """Constant, speed and Stribeck part by the file alone; the part in proportion to the load with the page's lines."""
    soft = elastic_drive(as_found(staged(0.0), **_FOUND, fades_rad_s=FADES))
    plain = light()
    drum = replace(plain.joint("drum"), friction_Nm=soft.drum_friction_Nm, damping_Nm_s=soft.built.viscous_Nm_s)
    for name, content in robot_files(replace(plain, joints=(drum, plain.joints[1])), "mjcf", elastic=soft).items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(content)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "staged.xml"))
    model.opt.gravity[:] = 0.0
    model.dof_frictionloss[model.joint("input_main").dofadr[0]] = 0.0
    model.actuator("input_main_motor").gear[:] = 1e-9
    for name in ("gear_share", "input_main_friction"):
        model.numeric(name).data[:] = 0.0
    data, step = started(model), _with_losses()
    at = [model.joint(name).dofadr[0] for name in ("drum", "payload")]
    wanted = steady_rad_s(soft.drum_friction_Nm - _FOUND["torque_Nm"], LOAD_NM)
    for joint in plain.joints:
        data.qvel[model.joint(joint.link).dofadr[0]] = 0.8 * wanted * joint.ratio
    for _ in range(1500):
        data.qfrc_applied[at] = LOAD_NM
        step(model, data)
    assert float(data.qvel[at[0]]) == pytest.approx(wanted, rel=0.005), (data.qvel[at[0]], wanted)
    fmpy, (content, _) = pytest.importorskip("fmpy"), fmu_file(staged(0.0), soft)
    (tmp_path / "staged.fmu").write_bytes(content)
    free = {"input_friction_main": 0.0, "motor_friction": 0.0, "gear_share": 0.0, "load_torque": -LOAD_NM}
    seen = fmpy.simulate_fmu(str(tmp_path / "staged.fmu"), stop_time=2.0, step_size=1e-3, start_values=free)
    assert seen["payload_speed"][-1] == pytest.approx(wanted, rel=0.005), (seen["payload_speed"][-1], wanted)


def test_what_a_file_lacks_is_named_with_its_figure(loaded: Any) -> None:
    shift = AsBuilt(name="once_per_rev", form="drum", values=(AsBuiltValue(name="amplitude_rad", value=6e-5),))
    built = with_as_built(as_found(loaded.drive, torque_Nm=0.01, load_share=0.03), (shift,))
    assert left_out(built, "fmu") == ("once_per_rev (drum): amplitude_rad 6e-05",)
    assert left_out(built, "elastic")[0].endswith(": load_share 0.03") and len(left_out(built, "elastic")) == 2
    assert left_out(loaded.drive, "urdf") == ()
