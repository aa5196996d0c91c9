"""URDF and MJCF files of a mechanism, with meshes in metres. Frames and joints: docs/robot-formats.md.

The same mechanism gives the same bytes.
"""

from __future__ import annotations

from dataclasses import replace
from math import sqrt
from xml.etree import ElementTree as ET

import numpy as np

from mbcdm_cad.build.export.stl import stl_bytes
from mbcdm_cad.robot.mechanism import MM, Link, Mechanism
from mbcdm_cad.robot.urdf import BASE_LINK, UrdfOptions, urdf_files
from mbcdm_cad.robot.xml import document, numbers, triangle

FORMATS = ("urdf", "mjcf")
# Settings that make the ratio a stiff constraint: at 20 mN m it drifts by 6 urad, with default settings by 58 mrad.
_STIFF = {"solref": "0.001 1", "solimp": "0.9999 0.9999 0.001"}
_TIMESTEP_S = 0.0005
# Cables as springs: their modes are near 1 kHz, so that the time step is shorter; damping is a choice, 2 % of critical.
_ELASTIC_TIMESTEP_S = 0.00005
_DAMPING_RATIO = 0.02


def robot_files(
    mechanism: Mechanism, form: str, *, elastic: bool = False, options: UrdfOptions | None = None
) -> dict[str, bytes]:
    """All files of an export by path in its folder: the description and ``meshes/<link>.stl``.

    ``elastic`` (MJCF only): the cables are springs between inputs and drum instead of a rigid ratio; ``options`` (URDF
    only). Raises ``ValueError`` for an unknown ``form``, or one that has not what is asked.
    """
    if form not in FORMATS or (elastic and form != "mjcf") or (options and form != "urdf"):
        raise ValueError(f"no such form: {form}{', elastic' if elastic else ''}; there are {', '.join(FORMATS)}")
    meshes = {f"meshes/{link.name}.stl": _stl(link) for link in (mechanism.base, *mechanism.links)}
    if form == "urdf":
        return {**urdf_files(mechanism, options or UrdfOptions()), **meshes}
    return {f"{mechanism.name}.xml": document(_mjcf(mechanism, elastic)), **meshes}


def _stl(link: Link) -> bytes:
    """The link's mesh in metres, in the link's frame."""
    points = link.mesh.points_mm * MM - np.array(link.origin)
    return stl_bytes(link.name, replace(link.mesh, points_mm=points))


def _mjcf(m: Mechanism, elastic: bool) -> ET.Element:
    root = ET.Element("mujoco", model=m.name)
    ET.SubElement(root, "compiler", angle="radian", meshdir="meshes", inertiafromgeom="false", autolimits="true")
    step = _ELASTIC_TIMESTEP_S if elastic else _TIMESTEP_S
    ET.SubElement(root, "option", timestep=numbers([step]), integrator="implicitfast")
    assets = ET.SubElement(root, "asset")
    for link in (m.base, *m.links):
        ET.SubElement(assets, "mesh", name=link.name, file=f"{link.name}.stl")
    world = ET.SubElement(root, "worldbody")
    ET.SubElement(world, "light", pos="0.2 0.4 0.6", dir="-0.3 -0.6 -1")
    base = ET.SubElement(world, "body", name=BASE_LINK, pos=numbers(m.base.origin))
    _mjcf_body(base, m.base)
    for joint in m.joints:
        link = m.link(joint.link)
        body = ET.SubElement(base, "body", name=link.name, pos=numbers(link.origin))
        ET.SubElement(
            body,
            "joint",
            name=link.name,
            type="hinge",
            axis=numbers(joint.axis),
            range=numbers(joint.range_rad),
            armature=numbers([joint.armature]),
            attrib={"ref": numbers([joint.drawn_rad])} if joint.drawn_rad else {},
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
                polycoef=f"0 {numbers([joint.ratio])} 0 0 0",
                attrib=_STIFF,
            )
    if elastic:
        _tendons(root, m)
    return root


def _mjcf_body(body: ET.Element, link: Link) -> None:
    t = triangle(link.inertia)
    full = (t["ixx"], t["iyy"], t["izz"], t["ixy"], t["ixz"], t["iyz"])
    ET.SubElement(body, "inertial", pos=numbers(link.cog), mass=numbers([link.mass]), fullinertia=numbers(full))
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
        rgba=numbers((*link.colour, 1.0)),
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
            stiffness=numbers([cable.stiffness_N_m]),
            damping=numbers([damping * cable.stiffness_N_m]),
            springlength=numbers([rest]),
        )
        ET.SubElement(one, "joint", joint=m.drum, coef=numbers([cable.drum_lever]))
        ET.SubElement(one, "joint", joint=cable.input_link, coef=numbers([cable.input_lever]))
