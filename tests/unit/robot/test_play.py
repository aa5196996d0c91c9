"""Play of a gear stage in the robot files: the drum swings by it where the motor is held, and an encoder shows it."""

import shutil
from dataclasses import replace
from functools import cache
from math import radians
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import layout_of, load_text
from mbcdm_cad.layouts.turns import turns_at
from mbcdm_cad.robot.elastic import ElasticDrive, elastic_drive
from mbcdm_cad.robot.fmu import fmu_file
from mbcdm_cad.robot.mechanism import Joint, Link, Mechanism, _named
from mbcdm_cad.robot.mjcf import robot_files
from mbcdm_cad.workshop.interference import MovingGroup
from mbcdm_cad.workshop.trianglemesh import TriangleMesh

ARCMIN, RATIO, PERIOD_S, STEP_S = 20.0, 8.0, 2.0, 1e-3
TEXT = f"""\
name: staged
configuration: siso_spur
travel: {{half_angle_deg: 45.0}}
transmission: {{input_to_drum: {RATIO}}}
loads: {{peak_torque_Nm: 2.0}}
stage: {{kind: gears, lash_arcmin: {ARCMIN}}}
"""
# By hand: the play at the input over the ratio of the cables.
PLAY_RAD = radians(ARCMIN / 60.0) / RATIO


@cache
def drive(arcmin: float) -> Any:
    found = load_text(TEXT).drive
    assert found.stage is not None
    return replace(found, stage=replace(found.stage, stated_lash_arcmin=arcmin))


def _loads(step_s: float) -> Any:
    time = np.arange(0.0, 2.25 * PERIOD_S, step_s)
    return time, drive(ARCMIN).loads.test_torque_Nm * np.sin(2.0 * np.pi * time / PERIOD_S)


def _swing_rad(signal: Any, step_s: float) -> float:
    """Between the greatest loads of both signs: where the play has just been crossed, a pulley may bounce."""
    return abs(float(signal[-1] - signal[round(1.75 * PERIOD_S / step_s)]))


def _as_closed_form(loose: tuple[float, float], tight: tuple[float, float]) -> None:
    """(swing of the payload, of the input's encoder at the drum), both with play and without, motors held."""
    for (payload, _), arcmin in ((loose, ARCMIN), (tight, 0.0)):
        wanted = turns_at(layout_of(drive(arcmin)), drive(arcmin).loads.test_torque_Nm).motors_held
        assert wanted is not None
        assert payload * 1e3 == pytest.approx(wanted.swing_mrad, rel=0.02), (payload, wanted)
    assert loose[0] - tight[0] == pytest.approx(PLAY_RAD, rel=0.02), (loose, tight)
    assert loose[1] - tight[1] == pytest.approx(PLAY_RAD, rel=0.02), (loose, tight)


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_an_fmu_swings_by_its_play(tmp_path: Path) -> None:
    fmpy = pytest.importorskip("fmpy")
    time, load = _loads(STEP_S)
    signals = np.zeros(time.size, dtype=[("time", float), ("load_torque", float), ("motor_torque_main", float)])
    signals["time"], signals["load_torque"] = time, load

    def swings(arcmin: float) -> tuple[float, float]:
        content, _ = fmu_file(drive(arcmin), elastic_drive(drive(arcmin)))
        (tmp_path / "staged.fmu").write_bytes(content)
        held = {"input_friction_main": 100.0, "drum_friction": 0.0}
        found = fmpy.simulate_fmu(
            str(tmp_path / "staged.fmu"),
            stop_time=float(time[-1]),
            output_interval=STEP_S,
            step_size=STEP_S,
            input=signals,
            start_values=held,
        )
        return _swing_rad(found["payload_angle"], STEP_S), _swing_rad(found["input_encoder_main"], STEP_S) / RATIO

    _as_closed_form(swings(ARCMIN), swings(0.0))


def _mechanism() -> Mechanism:
    """Drum and input as joints, with a tetrahedron in place of each body's mesh."""
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], np.int32)
    mesh = TriangleMesh(corners, corners, faces, np.empty((0, 2), np.int32), 0.0)
    small = ((1e-5, 0.0, 0.0), (0.0, 1e-5, 0.0), (0.0, 0.0, 1e-5))
    links = [
        Link(name, (at, 0.0, 0.0), 0.1, (0.0, 0.0, 0.0), small, (0.5, 0.5, 0.5), mesh)
        for name, at in (("base", 0.0), ("drum", 0.0), ("input_main", 0.1))
    ]
    turning = [("drum", 1.0, 0.0), ("input_main", RATIO, drive(ARCMIN).rotor_at_input_kg_m2)]
    joints = [Joint(name, (0.0, 0.0, 1.0), n, (-9.0, 9.0), 0.0, j, 2.0, 10.0, 0.0) for name, n, j in turning]
    return Mechanism("staged", links[0], tuple(links[1:]), tuple(joints), "drum", ("input_main",))


def test_mujoco_swings_by_its_play(tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco", minversion="4.0")

    def swings(soft: ElasticDrive) -> tuple[float, float, float]:
        for name, content in robot_files(_mechanism(), "mjcf", elastic=soft).items():
            (tmp_path / name).parent.mkdir(exist_ok=True)
            (tmp_path / name).write_bytes(content)
        model = mujoco.MjModel.from_xml_path(str(tmp_path / "staged.xml"))
        data, step = mujoco.MjData(model), model.opt.timestep
        mujoco.mj_resetDataKeyframe(model, data, 0)
        motor = "input_main_rotor" if soft.play_rad else "input_main"
        model.dof_frictionloss[model.joint(motor).dofadr[0]] = 10.0
        model.dof_frictionloss[model.joint("drum").dofadr[0]] = 0.0
        _, load = _loads(step)
        at = [model.joint(name).dofadr[0] for name in ("drum", "payload")]
        seen = np.zeros((load.size, 2))
        for k, now in enumerate(load):
            data.qfrc_applied[at] = -now
            mujoco.mj_step(model, data)
            seen[k] = [data.sensor(name).data[0] for name in ("payload_angle", "input_main_encoder")]
        # The load of a step balances the angle at its end.
        first = round(1.25 * PERIOD_S / step)
        lost = abs(float(np.trapezoid(load[first:-1], seen[first + 1 :, 0])))
        return _swing_rad(seen[:, 0], step), _swing_rad(seen[:, 1], step) / RATIO, lost

    *loose, lost = swings(elastic_drive(drive(ARCMIN)))
    *tight, cables = swings(elastic_drive(drive(0.0)))
    _as_closed_form((loose[0], loose[1]), (tight[0], tight[1]))
    through = drive(ARCMIN).loads.test_torque_Nm * PLAY_RAD
    # What inertia takes to cross it; a damping of the contact, one step times its stiffness, took a third.
    assert lost - cables < 0.2 * through, (lost, cables, through)


def test_pinocchio_reads_a_driving_wheel_that_follows_the_drum(tmp_path: Path) -> None:
    """It goes through joints by alphabet: one that follows must come behind the one that leads."""
    pin = pytest.importorskip("pinocchio")
    whole = _mechanism()
    driver = _named(MovingGroup("driver_main", "stage", (0.0, 0.0, 1.0), (0.0, 0.0, 0.0), -3.0 * RATIO, ()))
    link, joint = (replace(whole.links[1], name=driver.name), replace(whole.joints[1], link=driver.name))
    staged = replace(
        whole,
        links=(*whole.links, link),
        joints=(*whole.joints, replace(joint, ratio=-3.0 * RATIO, leader="input_main")),
    )
    for name, content in robot_files(staged, "urdf").items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(content)
    model = pin.buildModelFromUrdf(str(tmp_path / "staged.urdf"), mimic=True)
    assert (model.nq, model.nv) == (1, 1)
    seen = float(pin.crba(model, model.createData(), pin.neutral(model))[0, 0])
    each = 1e-5 * (1.0 + RATIO**2 + (3.0 * RATIO) ** 2) + joint.armature * (RATIO**2 + (3.0 * RATIO) ** 2)
    assert seen == pytest.approx(each, rel=1e-6)
