"""URDF and MJCF read by other programs: mass, inertia, ratio, stiffness."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.model.analysis import analyse
from mbcdm_cad.report.masses import inertias, masses_by_item
from mbcdm_cad.robot.elastic import elastic_drive
from mbcdm_cad.robot.mechanism import LARGEST_FACES, Mechanism, mechanism, within_faces
from mbcdm_cad.robot.mjcf import robot_files

REFERENCE = Path(__file__).parents[3] / "params" / "mbcdm.yaml"
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
