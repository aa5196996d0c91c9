"""URDF and MJCF files of a mechanism, with meshes in metres. Frames and joints: docs/robot-formats.md.

The same mechanism gives the same bytes.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from math import sqrt
from xml.etree import ElementTree as ET

import numpy as np

from mbcdm_cad.build.export.stl import stl_bytes
from mbcdm_cad.robot.mechanism import MM, Link, Mechanism

FORMATS = ("urdf", "mjcf")
BASE_LINK = "base"
# URDF needs a speed limit, but the catalogue has none for the motors: a round value well above the usual speeds.
DRUM_SPEED_RAD_S = 10.0
# Settings that make the ratio a stiff constraint: at 20 mN m it drifts by 6 urad, with default settings by 58 mrad.
_STIFF = {"solref": "0.001 1", "solimp": "0.9999 0.9999 0.001"}
_TIMESTEP_S = 0.0005
# Cables as springs: their modes are near 1 kHz, so that the time step is shorter; damping is a choice, 2 % of critical.
_ELASTIC_TIMESTEP_S = 0.00005
_DAMPING_RATIO = 0.02


def robot_files(mechanism: Mechanism, form: str, elastic: bool = False) -> dict[str, bytes]:
    """All files by their path in the output folder: the description and ``meshes/<link>.stl``.

    ``elastic`` (MJCF only): the cables are springs between inputs and drum instead of a rigid ratio.
    Raises ``ValueError`` for an unknown ``form`` or an elastic URDF.
    """
    if form not in FORMATS or (elastic and form != "mjcf"):
        raise ValueError(f"no such form: {form}{', elastic' if elastic else ''}; there are {', '.join(FORMATS)}")
    root = _urdf(mechanism) if form == "urdf" else _mjcf(mechanism, elastic)
    ET.indent(root)
    suffix = ".urdf" if form == "urdf" else ".xml"
    text = ET.tostring(root, encoding="utf-8", xml_declaration=True) + b"\n"
    meshes = {f"meshes/{link.name}.stl": _stl(link) for link in (mechanism.base, *mechanism.links)}
    return {f"{mechanism.name}{suffix}": text, **meshes}


def _stl(link: Link) -> bytes:
    """The link's mesh in metres, in the link's frame."""
    points = link.mesh.points_mm * MM - np.array(link.origin)
    return stl_bytes(link.name, replace(link.mesh, points_mm=points))


def _numbers(values: Iterable[float]) -> str:
    return " ".join(f"{value:.10g}" for value in values)


def _triangle(inertia: tuple[tuple[float, ...], ...]) -> dict[str, float]:
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = inertia
    return {"ixx": xx, "ixy": xy, "ixz": xz, "iyy": yy, "iyz": yz, "izz": zz}


def _urdf(m: Mechanism) -> ET.Element:
    robot = ET.Element("robot", name=m.name)
    for link in (m.base, *m.links):
        material = ET.SubElement(robot, "material", name=f"{link.name}_colour")
        ET.SubElement(material, "color", rgba=_numbers((*link.colour, 1.0)))
    _urdf_link(robot, m.base, BASE_LINK)
    for link in m.links:
        _urdf_link(robot, link, link.name)
    lead = next(joint for joint in m.joints if joint.link == m.drum)
    for joint in sorted(m.joints, key=lambda j: j.link != m.drum):
        node = ET.SubElement(robot, "joint", name=joint.link, type="revolute")
        ET.SubElement(node, "parent", link=BASE_LINK)
        ET.SubElement(node, "child", link=joint.link)
        ET.SubElement(node, "origin", xyz=_numbers(m.link(joint.link).origin), rpy="0 0 0")
        ET.SubElement(node, "axis", xyz=_numbers(joint.axis))
        ET.SubElement(
            node,
            "limit",
            lower=_numbers([-joint.limit_rad]),
            upper=_numbers([joint.limit_rad]),
            effort=_numbers([m.peak_torque_Nm / abs(joint.ratio)]),
            velocity=_numbers([DRUM_SPEED_RAD_S * abs(joint.ratio)]),
        )
        if joint is not lead:
            ET.SubElement(node, "mimic", joint=lead.link, multiplier=_numbers([joint.ratio]), offset="0")
    return robot


def _urdf_link(robot: ET.Element, link: Link, name: str) -> None:
    node = ET.SubElement(robot, "link", name=name)
    inertial = ET.SubElement(node, "inertial")
    ET.SubElement(inertial, "origin", xyz=_numbers(link.cog), rpy="0 0 0")
    ET.SubElement(inertial, "mass", value=_numbers([link.mass]))
    terms = {key: _numbers([value]) for key, value in _triangle(link.inertia).items()}
    ET.SubElement(inertial, "inertia", attrib=terms)
    for kind in ("visual", "collision"):
        shape = ET.SubElement(node, kind)
        ET.SubElement(shape, "origin", xyz="0 0 0", rpy="0 0 0")
        geometry = ET.SubElement(shape, "geometry")
        ET.SubElement(geometry, "mesh", filename=f"meshes/{link.name}.stl")
        if kind == "visual":
            ET.SubElement(shape, "material", name=f"{link.name}_colour")


def _mjcf(m: Mechanism, elastic: bool) -> ET.Element:
    root = ET.Element("mujoco", model=m.name)
    ET.SubElement(root, "compiler", angle="radian", meshdir="meshes", inertiafromgeom="false", autolimits="true")
    step = _ELASTIC_TIMESTEP_S if elastic else _TIMESTEP_S
    ET.SubElement(root, "option", timestep=_numbers([step]), integrator="implicitfast")
    assets = ET.SubElement(root, "asset")
    for link in (m.base, *m.links):
        ET.SubElement(assets, "mesh", name=link.name, file=f"{link.name}.stl")
    world = ET.SubElement(root, "worldbody")
    ET.SubElement(world, "light", pos="0.2 0.4 0.6", dir="-0.3 -0.6 -1")
    base = ET.SubElement(world, "body", name=BASE_LINK, pos=_numbers(m.base.origin))
    _mjcf_body(base, m.base)
    for joint in m.joints:
        link = m.link(joint.link)
        body = ET.SubElement(base, "body", name=link.name, pos=_numbers(link.origin))
        ET.SubElement(
            body,
            "joint",
            name=link.name,
            type="hinge",
            axis=_numbers(joint.axis),
            range=_numbers((-joint.limit_rad, joint.limit_rad)),
            armature=_numbers([joint.armature]),
        )
        _mjcf_body(body, link)
    springy = {cable.input_link for cable in m.cables} if elastic else set()
    equality = ET.SubElement(root, "equality")
    for joint in m.joints:
        if joint.link != m.drum and joint.link not in springy:
            ET.SubElement(
                equality,
                "joint",
                name=f"{joint.link}_ratio",
                joint1=joint.link,
                joint2=m.drum,
                polycoef=f"0 {_numbers([joint.ratio])} 0 0 0",
                attrib=_STIFF,
            )
    if elastic:
        _tendons(root, m)
    return root


def _mjcf_body(body: ET.Element, link: Link) -> None:
    t = _triangle(link.inertia)
    full = (t["ixx"], t["iyy"], t["izz"], t["ixy"], t["ixz"], t["iyz"])
    ET.SubElement(body, "inertial", pos=_numbers(link.cog), mass=_numbers([link.mass]), fullinertia=_numbers(full))
    # Only shown, without collisions: the parts of a drive touch each other as intended.
    ET.SubElement(
        body,
        "geom",
        name=link.name,
        type="mesh",
        mesh=link.name,
        contype="0",
        conaffinity="0",
        group="2",
        rgba=_numbers((*link.colour, 1.0)),
    )


def _tendons(root: ET.Element, m: Mechanism) -> None:
    """Each cable as a spring with a negative rest length, so that its tension at zero angles is the preload."""
    total = sum(cable.stiffness_N_m * cable.drum_lever**2 for cable in m.cables)
    drum = m.link(m.drum)
    axis = np.array(next(joint.axis for joint in m.joints if joint.link == m.drum))
    about = float(axis @ np.array(drum.inertia) @ axis) + drum.mass * float(np.sum(np.cross(axis, drum.cog) ** 2))
    damping = 2.0 * _DAMPING_RATIO * sqrt(about / total)  # s: damping over stiffness of every cable
    node = ET.SubElement(root, "tendon")
    for cable in m.cables:
        rest = -cable.preload_N / cable.stiffness_N_m
        one = ET.SubElement(
            node,
            "fixed",
            name=cable.name,
            stiffness=_numbers([cable.stiffness_N_m]),
            damping=_numbers([damping * cable.stiffness_N_m]),
            springlength=_numbers([rest]),
        )
        ET.SubElement(one, "joint", joint=m.drum, coef=_numbers([cable.drum_lever]))
        ET.SubElement(one, "joint", joint=cable.input_link, coef=_numbers([cable.input_lever]))
