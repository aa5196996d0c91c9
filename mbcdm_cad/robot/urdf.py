"""URDF of a mechanism, plain or as an xacro macro, with a block for ros2_control. Frames: docs/robot-formats.md."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree import ElementTree as ET

import numpy as np

from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.robot.mechanism import Joint, Link, Mechanism, document, numbers, triangle

# The root has no mass, because KDL ignores the inertia of a root; the drive's base hangs on it.
ROOT_LINK, BASE_LINK = "base_link", "base"
_XACRO = "http://www.ros.org/wiki/xacro"
_PACKAGE = re.compile(r"[a-z][a-z0-9_]*")
# The plugin that stands for hardware until there is some: it answers each command at once.
_MOCK = "mock_components/GenericSystem"


@dataclass(frozen=True)
class UrdfOptions:
    """How a URDF is written.

    ``package``: meshes by ``package://NAME/meshes/``, as RViz and Gazebo find them, instead of relative paths.
    ``xacro``: a macro for a robot's own description, with a prefix for all names. ``ros2_control``: the block that a
    controller manager reads, with the drum as the joint that takes commands. Raises ``MbcdmError`` for a name that no
    package has.
    """

    package: str | None = None
    xacro: bool = False
    ros2_control: bool = False

    def __post_init__(self) -> None:
        if self.package is not None and not _PACKAGE.fullmatch(self.package):
            limit = "a-z, 0-9 and _, from a letter on"
            raise MbcdmError(f"package: no name of a ROS package (value {self.package}, limit {limit}); rename it")


def urdf_files(m: Mechanism, options: UrdfOptions) -> dict[str, bytes]:
    """The description by its file name, ``NAME.urdf`` or ``NAME.urdf.xacro``."""
    prefix = "${prefix}" if options.xacro else ""
    folder = f"package://{options.package}/meshes" if options.package else "meshes"
    robot = ET.Element("robot", name=m.name)
    found = [_link(m.base, m.base.inertia, f"{prefix}{BASE_LINK}", folder)]
    for link in m.links:
        joint = next(joint for joint in m.joints if joint.link == link.name)
        found.append(_link(link, with_rotor(link, joint), f"{prefix}{link.name}", folder))
    parts = [*found, *_joints(m, prefix)]
    if options.ros2_control:
        parts.append(_ros2_control(m, prefix))
    if not options.xacro:
        robot.extend([ET.Element("link", name=ROOT_LINK), _fixed(ROOT_LINK, BASE_LINK, "base_fixed"), *parts])
        return {f"{m.name}.urdf": document(robot, m.note)}
    robot.set("xmlns:xacro", _XACRO)
    macro = ET.SubElement(
        robot, "xacro:macro", name=f"drive_{m.name.replace('-', '_')}", params="parent prefix:='' *origin"
    )
    stand = _fixed("${parent}", f"{prefix}{BASE_LINK}", f"{prefix}base_fixed")
    stand.append(ET.Element("xacro:insert_block", name="origin"))
    macro.extend([stand, *parts])
    return {f"{m.name}.urdf.xacro": document(robot, m.note)}


def _fixed(parent: str, child: str, name: str) -> ET.Element:
    joint = ET.Element("joint", name=name, type="fixed")
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)
    return joint


def with_rotor(link: Link, joint: Joint) -> tuple[tuple[float, ...], ...]:
    """The link's inertia with the motor's rotor, through the gearhead: J about the axis and J/2 across it.

    A tensor with J about the axis alone is that of no body, and readers refuse it; J and J/2 are those of a thin disc.
    """
    axis = np.array(joint.axis)
    disc = joint.armature / 2.0 * (np.eye(3) + np.outer(axis, axis))
    rows = np.array(link.inertia) + disc
    return tuple(tuple(float(value) for value in row) for row in rows)


def _link(link: Link, inertia: tuple[tuple[float, ...], ...], name: str, folder: str) -> ET.Element:
    """A link without collision geometry: its parts run inside each other, so that any convex shape would touch."""
    node = ET.Element("link", name=name)
    inertial = ET.SubElement(node, "inertial")
    ET.SubElement(inertial, "origin", xyz=numbers(link.cog), rpy="0 0 0")
    ET.SubElement(inertial, "mass", value=numbers([link.mass]))
    terms = {key: numbers([value]) for key, value in triangle(inertia).items()}
    ET.SubElement(inertial, "inertia", attrib=terms)
    visual = ET.SubElement(node, "visual")
    ET.SubElement(visual, "origin", xyz="0 0 0", rpy="0 0 0")
    geometry = ET.SubElement(visual, "geometry")
    ET.SubElement(geometry, "mesh", filename=f"{folder}/{link.name}.stl")
    material = ET.SubElement(visual, "material", name=f"{name}_colour")
    ET.SubElement(material, "color", rgba=numbers((*link.colour, 1.0)))
    return node


def _leading_first(m: Mechanism) -> Sequence[Joint]:
    return sorted(m.joints, key=lambda joint: joint.link != m.drum)


def _joints(m: Mechanism, prefix: str) -> list[ET.Element]:
    found = []
    for joint in _leading_first(m):
        node = ET.Element("joint", name=f"{prefix}{joint.link}", type="revolute")
        ET.SubElement(node, "parent", link=f"{prefix}{BASE_LINK}")
        ET.SubElement(node, "child", link=f"{prefix}{joint.link}")
        # Roll, pitch and yaw of a link's frame at the zero of its joint: it is drawn at ``drawn_rad`` from there.
        x, y, z = (-joint.drawn_rad * part + 0.0 for part in joint.axis)
        if sum(part != 0.0 for part in joint.axis) != 1:
            raise ValueError(f"axis {joint.axis} of {joint.link} is along none of X, Y and Z")
        ET.SubElement(node, "origin", xyz=numbers(m.link(joint.link).origin), rpy=numbers((x, y, z)))
        ET.SubElement(node, "axis", xyz=numbers(joint.axis))
        ET.SubElement(
            node,
            "limit",
            lower=numbers([joint.range_rad[0]]),
            upper=numbers([joint.range_rad[1]]),
            effort=numbers([joint.effort_Nm]),
            velocity=numbers([joint.speed_rad_s]),
        )
        ET.SubElement(node, "dynamics", damping=numbers([joint.damping_Nm_s]), friction=numbers([joint.friction_Nm]))
        if joint.link != m.drum:
            follows = {"joint": f"{prefix}{m.drum}", "multiplier": numbers([joint.ratio]), "offset": "0"}
            ET.SubElement(node, "mimic", attrib=follows)
        found.append(node)
    return found


def _ros2_control(m: Mechanism, prefix: str) -> ET.Element:
    """The drum takes positions and tells position and speed; the joints that follow it by ``mimic`` only tell."""
    block = ET.Element("ros2_control", name=f"{prefix}{m.name}", type="system")
    ET.SubElement(ET.SubElement(block, "hardware"), "plugin").text = _MOCK
    for joint in _leading_first(m):
        node = ET.SubElement(block, "joint", name=f"{prefix}{joint.link}")
        if joint.link == m.drum:
            command = ET.SubElement(node, "command_interface", name="position")
            for end, value in zip(("min", "max"), joint.range_rad, strict=True):
                ET.SubElement(command, "param", name=end).text = numbers([value])
        for state in ("position", "velocity"):
            ET.SubElement(node, "state_interface", name=state)
    return block
