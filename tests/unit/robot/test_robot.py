"""URDF and MJCF read by other programs: mass, inertia, ratio, stiffness."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from mbcdm_cad.design.blocks import DutyBlock, DutyRow
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.model.analysis import analyse
from mbcdm_cad.report.data import inertias, masses_by_item
from mbcdm_cad.robot.elastic import elastic_drive
from mbcdm_cad.robot.mechanism import (
    LARGEST_FACES,
    SPEED_WITHOUT_FIGURES_RAD_S,
    Mechanism,
    _limits,
    mechanism,
    within_faces,
)
from mbcdm_cad.robot.mjcf import UrdfOptions, robot_files
from tests.support.checked import of_params

G_MM2 = 1e-9


@pytest.fixture(scope="module")
def masses(loaded: Any, parts: Any) -> dict[str, Any]:
    """The report's own sums: mass of the whole (g), inertia at the drum with and without rotors (g mm^2)."""
    dims = layout_of(loaded.drive)
    centred = dims.bill()
    by_item = masses_by_item(centred, parts)
    moving = inertias(dims, centred, by_item)
    return {
        "mass_g": sum(m.mass_g for m in by_item.values()),
        "without": moving.at_drum_without_rotors,
        "with": moving.at_drum,
    }


@pytest.fixture(scope="module")
def folder(robot: Mechanism, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """urdf/ and mjcf/, written out."""
    out = tmp_path_factory.mktemp("robot")
    for name, files in {"urdf": robot_files(robot, "urdf"), "mjcf": robot_files(robot, "mjcf")}.items():
        for path, content in files.items():
            (out / name / path).parent.mkdir(parents=True, exist_ok=True)
            (out / name / path).write_bytes(content)
    return out


@pytest.fixture(scope="module")
def urdf(folder: Path) -> Any:
    yourdfpy = pytest.importorskip("yourdfpy")
    return yourdfpy.URDF.load(str(folder / "urdf" / "mbcdm.urdf"), build_collision_scene_graph=False)


@pytest.fixture(scope="module")
def mujoco() -> Any:
    return pytest.importorskip("mujoco")


@pytest.fixture(scope="module")
def rigid(mujoco: Any, folder: Path) -> Any:
    return mujoco.MjModel.from_xml_path(str(folder / "mjcf" / "mbcdm.xml"))


def test_the_same_drive_gives_the_same_bytes(robot: Mechanism) -> None:
    assert robot_files(robot, "mjcf") == robot_files(robot, "mjcf")


@pytest.mark.parametrize(("form", "soft"), [("sdf", False), ("urdf", True)])
def test_unknown_forms_are_refused(robot: Mechanism, loaded: Any, form: str, soft: bool) -> None:
    with pytest.raises(ValueError, match="no such form"):
        robot_files(robot, form, elastic=elastic_drive(loaded.drive) if soft else None)


def test_meshes_are_in_metres_and_small_enough(robot: Mechanism, folder: Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    for link in (robot.base, *robot.links):
        mesh = trimesh.load(folder / "urdf" / "meshes" / f"{link.name}.stl")
        assert 0 < len(mesh.faces) < LARGEST_FACES, (link.name, len(mesh.faces))
        assert 0.001 < mesh.extents.max() < 0.5, (link.name, mesh.extents)


def test_a_mesh_too_fine_for_simulators_is_coarsened(parts: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    files = {name: part.files for name, part in parts.items()}
    shown = ["drum", "nut", "nut"]
    fine = {name: len(files[name].mesh.triangles) for name in shown}
    limit = fine["drum"] * 2 // 3
    monkeypatch.setattr("mbcdm_cad.robot.mechanism.LARGEST_FACES", limit)
    found = within_faces("drum", shown, files, 0.01)
    assert sum(len(found[name].triangles) for name in shown) < limit, (fine, limit)
    assert found["nut"] is files["nut"].mesh, "a part of few faces is left as it is"
    assert len(found["drum"].open_edges_mm()) == 0 and 0.01 < found["drum"].deviation_mm <= 0.04 * 4
    assert abs(found["drum"].volume_mm3 / files["drum"].shape.volume_mm3 - 1.0) < 0.01


def test_a_body_that_no_mesh_makes_small_enough_is_refused(parts: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mbcdm_cad.robot.mechanism.LARGEST_FACES", 10)
    with pytest.raises(MbcdmError, match=r"mesh of drum has too many faces for simulators .*limit 9"):
        within_faces("drum", ["nut"], {"nut": parts["nut"].files}, 0.01)


class TestUrdf:
    def test_is_valid_and_weighs_what_the_report_says(self, urdf: Any, masses: dict[str, Any]) -> None:
        assert urdf.validate(), urdf.errors
        whole = sum(link.inertial.mass for link in urdf.robot.links if link.inertial)
        assert abs(whole * 1e3 / masses["mass_g"] - 1.0) < 1e-9, (whole, masses["mass_g"])

    def test_one_joint_leads_and_the_others_follow_by_the_ratios(self, urdf: Any, loaded: Any) -> None:
        turns = analyse(layout_of(loaded.drive)).shaft_turns[0].turned_deg
        ratio = {"guide": turns["guide"] / turns["drum"]}
        assert urdf.actuated_joint_names == ["drum"]
        urdf.update_cfg([0.3])
        for joint in urdf.robot.joints:
            if joint.name in ("drum", "base_fixed"):
                continue
            wanted = ratio.get(joint.name, turns["input"] / turns["drum"])
            assert abs(joint.mimic.multiplier / wanted - 1.0) < 1e-9, (joint.name, joint.mimic.multiplier, wanted)
            frame = urdf.get_transform(joint.child)
            angle = np.arctan2(frame[1, 0], frame[0, 0])
            error = (angle - wanted * 0.3 + np.pi) % (2 * np.pi) - np.pi
            assert abs(error) < 1e-9, (joint.name, angle, error)


class TestMujoco:
    def test_weighs_what_the_report_says(self, rigid: Any, masses: dict[str, Any]) -> None:
        whole = float(rigid.body_mass.sum())
        assert abs(whole * 1e3 / masses["mass_g"] - 1.0) < 1e-6, (whole, masses["mass_g"])

    @pytest.mark.parametrize("rotors", ["without", "with"])
    def test_inertia_at_the_drum_is_the_reports(
        self, mujoco: Any, rigid: Any, robot: Mechanism, masses: dict[str, Any], rotors: str
    ) -> None:
        data = mujoco.MjData(rigid)
        mujoco.mj_forward(rigid, data)
        full = np.zeros((rigid.nv, rigid.nv))
        mujoco.mj_fullM(rigid, data, full)
        names = [rigid.joint(k).name for k in range(rigid.njnt)]
        ratio = np.array([next(j.ratio for j in robot.joints if j.link == name) for name in names])
        if rotors == "without":
            full -= np.diag(rigid.dof_armature)
        seen = float(ratio @ full @ ratio) / G_MM2
        assert abs(seen / masses[rotors] - 1.0) < 1e-6, (seen, masses[rotors])

    def test_the_ratio_holds_in_a_swing(self, mujoco: Any, rigid: Any, robot: Mechanism) -> None:
        data = mujoco.MjData(rigid)
        worst = reached = 0.0
        for step in range(4000):
            data.qfrc_applied[rigid.joint("input_left").dofadr[0]] = 0.1 * np.sin(2 * np.pi * step * 0.0005 / 0.5)
            mujoco.mj_step(rigid, data)
            drum = data.joint("drum").qpos[0]
            reached = max(reached, abs(drum))
            for joint in robot.joints:
                # seen at the drum
                worst = max(worst, abs(data.joint(joint.link).qpos[0] / joint.ratio - drum))
        assert reached > np.radians(2.0), reached
        assert worst < 20e-6, (worst, reached)


@pytest.fixture(scope="module")
def shifted(loaded: Any, parts: Any) -> Mechanism:
    """The mechanism of a drive whose travel is not the same both ways."""
    drive = replace(loaded.drive, travel_from_deg=-50.0)
    return mechanism(drive, {name: part.files for name, part in parts.items()})


class TestTravelFromTo:
    """Joints count from the zero of the output; the links are drawn in the middle of the travel."""

    def test_limits_are_the_ends_with_the_stops(self, shifted: Mechanism, loaded: Any) -> None:
        drum = next(joint for joint in shifted.joints if joint.link == "drum")
        clear = loaded.drive.stop_clearance_deg
        assert np.allclose(np.degrees(drum.range_rad), (-50.0 - clear, 20.0 + clear)), drum.range_rad

    def test_urdf_stands_as_drawn_in_the_middle(self, shifted: Mechanism, tmp_path: Path) -> None:
        yourdfpy = pytest.importorskip("yourdfpy")
        for path, content in robot_files(shifted, "urdf").items():
            (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / path).write_bytes(content)
        urdf = yourdfpy.URDF.load(str(tmp_path / "mbcdm.urdf"), load_meshes=False, build_collision_scene_graph=False)
        urdf.update_cfg([np.radians(-15.0)])
        for link in shifted.links:
            turned = urdf.get_transform(link.name)[:3, :3]
            assert np.allclose(turned, np.eye(3), atol=1e-9), (link.name, turned)

    def test_mujoco_begins_in_the_middle(self, shifted: Mechanism, mujoco: Any, tmp_path: Path) -> None:
        for path, content in robot_files(shifted, "mjcf").items():
            (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / path).write_bytes(content)
        model = mujoco.MjModel.from_xml_path(str(tmp_path / "mbcdm.xml"))
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        assert abs(np.degrees(data.joint("drum").qpos[0]) + 15.0) < 1e-9
        for link in shifted.links:
            assert np.allclose(data.body(link.name).xmat.reshape(3, 3), np.eye(3), atol=1e-9), link.name
            joint = next(joint for joint in shifted.joints if joint.link == link.name)
            held = data.joint(link.name).qpos[0] - joint.ratio * data.joint("drum").qpos[0]
            assert abs(held) < 1e-9, (link.name, held)


# The URDF in three simulators: the same inertia, no contact over the travel; names, limits and options of the file.


POSES = np.linspace(-1.0, 1.0, 9)


@pytest.fixture(scope="module")
def path(robot: Mechanism, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("urdf")
    for name, content in robot_files(robot, "urdf").items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes(content)
    return folder / "mbcdm.urdf"


@pytest.fixture(scope="module")
def drum_with_rotors(loaded: Any, parts: Any) -> float:
    """Inertia at the drum with guide, inputs and rotors, kg m^2, as the report sums it."""
    layout = layout_of(loaded.drive)
    centred = layout.bill()
    return float(inertias(layout, centred, masses_by_item(centred, parts)).at_drum * G_MM2)


def test_pinocchio_sees_the_reports_inertia_with_the_rotors(path: Path, drum_with_rotors: float) -> None:
    pin = pytest.importorskip("pinocchio")
    model = pin.buildModelFromUrdf(str(path), mimic=True)
    assert (model.nq, model.nv) == (1, 1), "the followers are no coordinates of their own"
    seen = float(pin.crba(model, model.createData(), pin.neutral(model))[0, 0])
    assert seen == pytest.approx(drum_with_rotors, rel=1e-6)


def test_pybullet_finds_no_contact_over_the_travel_and_takes_the_inertias(path: Path, robot: Mechanism) -> None:
    pb = pytest.importorskip("pybullet")
    client = pb.connect(pb.DIRECT)
    try:
        body = pb.loadURDF(
            str(path), useFixedBase=True, flags=pb.URDF_USE_SELF_COLLISION | pb.URDF_USE_INERTIA_FROM_FILE
        )
        at = {pb.getJointInfo(body, k)[1].decode(): k for k in range(pb.getNumJoints(body))}
        for share in POSES:
            for joint in robot.joints:
                sign = np.sign(joint.ratio)
                pb.resetJointState(body, at[joint.link], share * sign * joint.range_rad[1])
            pb.performCollisionDetection()
            assert not pb.getContactPoints(body, body), share
        for k in at.values():
            inertia = pb.getDynamicsInfo(body, k)[2]
            assert all(value > 0.0 for value in inertia), "an inertia that Bullet refuses is set to zero"
        rotor = next(joint.armature for joint in robot.joints if joint.link == "input_left")
        assert rotor < pb.getDynamicsInfo(body, at["input_left"])[2][2] < 1.01 * rotor, "the rotor is in the link"
    finally:
        pb.disconnect(client)


def test_mujoco_reads_the_urdf_without_contacts(path: Path, robot: Mechanism) -> None:
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    for share in POSES:
        for joint in robot.joints:
            data.joint(joint.link).qpos = share * np.sign(joint.ratio) * joint.range_rad[1]
        mujoco.mj_forward(model, data)
        assert data.ncon == 0, (share, data.ncon)


def test_limits_are_those_of_the_motors_with_losses(robot: Mechanism, loaded: Any) -> None:
    found = analyse(layout_of(loaded.drive))
    limit = {
        node.get("name"): {k: float(v) for k, v in node.find("limit").attrib.items()}  # type: ignore[union-attr]
        for node in _urdf(robot, UrdfOptions()).findall("joint")
        if node.find("limit") is not None
    }
    drum, left = limit["drum"], limit["input_left"]
    assert drum["effort"] == pytest.approx(min(found.peak_torque_with_losses_Nm), rel=1e-9)
    motor, gear = loaded.drive.motor, loaded.drive.gearhead
    by_hand = (motor.rated_torque_mNm * gear.ratio - 0.03 * gear.rated_torque_mNm) * gear.efficiency * 1e-3
    assert left["effort"] == pytest.approx(by_hand, rel=1e-9), (left, by_hand)
    assert left["velocity"] == pytest.approx(9.0 * drum["velocity"], rel=1e-9)


def test_a_stated_duty_sets_the_effort_by_the_heat_of_its_motors(loaded: Any) -> None:
    """Moved all the time in hot air less than the continuous torque, for a share of the time more."""
    peak, train = loaded.drive.loads.peak_torque_Nm, layout_of(loaded.drive).losses
    output = train.output_Nm(loaded.drive.motor.peak_torque_mNm * 1e-3)
    short = min(float(train.raised_Nm(output, way).min()) for way in (1, -1))

    def effort(share: float) -> float:
        rows = [DutyRow(torque_Nm=peak, share=share, range_deg=60.0), DutyRow(torque_Nm=0.0, share=1.0 - share)]
        duty = DutyBlock(period_s=2.0, ambient_C=100.0, rows=[row for row in rows if row.share > 0.0])
        drive = replace(loaded.drive, loads=replace(loaded.drive.loads, duty=duty))
        found = _limits(drive)[0]
        assert found <= short * (1.0 + 1e-9)
        if found < short:
            # The hottest winding then just reaches its limit.
            scaled = [
                day.heat.repeated(day.duty.time_s, found / peak * day.heat_torque_Nm, 100.0)
                for day in layout_of(drive).motor_days
            ]
            hottest = max(found.hottest_winding_C for found in scaled if found is not None)
            assert hottest == pytest.approx(layout_of(drive).motor_days[0].heat.limit_C, abs=0.1)
        return found

    always = effort(1.0)
    assert always < _limits(loaded.drive)[0]
    assert always < effort(0.5) <= effort(0.1)


@pytest.mark.parametrize("name", ["mbcdm", "gallery/capstan"])
def test_the_speed_is_one_at_which_the_voltage_still_gives_the_torque(name: str) -> None:
    drive = of_params(name).drive
    _, speed = _limits(drive)
    motor = drive.motor
    if motor.torque_constant_mNm_A is None:
        assert speed == SPEED_WITHOUT_FIGURES_RAD_S
        return
    constant = motor.torque_constant_mNm_A * 1e-3
    turns = drive.gearhead.ratio * max(c.drum_radius_mm / c.input_radius_mm for c in drive.cables)
    at_motor = (drive.bus_voltage_V - motor.resistance_ohm * motor.rated_torque_mNm * 1e-3 / constant) / constant
    assert speed >= at_motor / turns * (1.0 - 1e-9), (speed, at_motor / turns)
    assert speed <= drive.bus_voltage_V / constant / turns, speed


def _urdf(robot: Mechanism, options: UrdfOptions) -> ET.Element:
    name = "mbcdm.urdf.xacro" if options.xacro else "mbcdm.urdf"
    return ET.fromstring(robot_files(robot, "urdf", options=options)[name])


def test_meshes_by_package_and_a_root_without_mass(robot: Mechanism) -> None:
    root = _urdf(robot, UrdfOptions(package="my_drive"))
    names = {mesh.get("filename") for mesh in root.iter("mesh")}
    assert "package://my_drive/meshes/drum.stl" in names and len(names) == 5, names
    children = {child.get("link") for child in root.iter("child")}
    (top,) = [link for link in root.findall("link") if link.get("name") not in children]
    assert top.find("inertial") is None
    with pytest.raises(MbcdmError, match=r"package: no name of a ROS package \(value My-Drive"):
        UrdfOptions(package="My-Drive")


def test_an_xacro_macro_is_the_same_robot_under_a_prefix(robot: Mechanism, tmp_path: Path) -> None:
    yourdfpy = pytest.importorskip("yourdfpy")
    (text,) = [
        content.decode()
        for name, content in robot_files(robot, "urdf", options=UrdfOptions(xacro=True)).items()
        if name.endswith(".xacro")
    ]
    macro = re.search(r"<xacro:macro name=\"drive_mbcdm\".*?>(.*)</xacro:macro>", text, re.DOTALL)
    assert macro, text[:300]
    # What xacro does with prefix "a_" and parent "world".
    body = macro[1].replace("${prefix}", "a_").replace("${parent}", "world")
    body = body.replace('<xacro:insert_block name="origin" />', '<origin xyz="0 0 0.1" rpy="0 0 0"/>')
    (tmp_path / "a.urdf").write_text(f'<robot name="a"><link name="world"/>{body}</robot>')
    read = yourdfpy.URDF.load(str(tmp_path / "a.urdf"), load_meshes=False)
    assert read.validate(), read.errors
    assert read.actuated_joint_names == ["a_drum"]
    assert read.get_transform("a_base")[2, 3] == pytest.approx(0.1)
    assert "$" not in body and "xacro" not in body


def test_ros2_control_commands_the_drum_alone(robot: Mechanism) -> None:
    (block,) = _urdf(robot, UrdfOptions(ros2_control=True)).findall("ros2_control")
    commands = {joint.get("name"): len(joint.findall("command_interface")) for joint in block.findall("joint")}
    assert commands == {"drum": 1, "guide": 0, "input_left": 0, "input_right": 0}
    states = {state.get("name") for state in block.iter("state_interface")}
    assert states == {"position", "velocity"}
