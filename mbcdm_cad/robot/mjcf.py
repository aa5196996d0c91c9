"""URDF, plain or as an xacro macro, with a block for ros2_control; MJCF, rigid by the ratios or elastic.

Elastic, all at the drum, g the drum's angle less that of an input over its ratio:

- Gearhead and cables of an input are a tendon over g, with spring and preload; each elastic-slip element is a joint on
  the input, which slips at its ``frictionloss``, and a spring from it to the drum.
- The parts behind the cables are a joint between drum and payload; encoders are tendons that take their share of its
  twist. The input's joint is that of the motor, over the gearhead's ratio.
- Play between motor and input makes the motor a joint of its own in the base, and the parts before the input the soft
  limits of a tendon between both: a spring would need a damping that rubs within the play too.
- Motors are ``dcmotor`` through the gearhead's ratio, commanded by torque; ``frictionloss`` of the joints is the
  friction of bearings, cables and gearheads under the preload.

Springs have a damping of one time step times their stiffness, which makes them implicit: MuJoCo treats springs
explicitly and damping implicitly, and the drum alone on its cables is faster than a step. Frames: see
docs/robot-formats.md.

The same mechanism gives the same bytes.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import copysign
from xml.etree import ElementTree as ET

import numpy as np

from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.parts.bill import Vector
from mbcdm_cad.robot.elastic import CableStage, ElasticDrive
from mbcdm_cad.robot.mechanism import MM, Joint, Link, Mechanism, document, numbers, triangle
from mbcdm_cad.workshop.export.files import stl_bytes

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


# Settings that make the ratio a stiff constraint: at 20 mN m it drifts by 6 urad, with default settings by 58 mrad.
_STIFF = {"solref": "0.001 1", "solimp": "0.9999 0.9999 0.001"}
_TIMESTEP_S = 0.0005
# Dry friction holds as firmly as MuJoCo's solver can.
_FIRM = {"solreffriction": "0.001 1", "solimpfriction": "0.9999 0.9999 0.001"}
_NOSLIP_ITERATIONS = 4
# Between these MuJoCo keeps the impedance of a constraint.
_IMPEDANCES = (0.0001, 0.9999)
# Inertia of a slip element over h^2 k: its own mode is then well below the step's.
_SLIP_INERTIA = 10.0
# Least inertia of a pulley behind play over h^2 k, k the sum of its springs: limits do not see the springs' damping.
_PULLEY_INERTIA = 1.0
# A joint's body needs a mass; this one is that of nothing.
_NOTHING_KG, _NOTHING_KG_M2 = 1e-9, 1e-12
# A payload's joint without a payload must not be lighter than MuJoCo can accelerate: a tenth of the reference's drum.
_PAYLOAD_KG_M2 = 1e-5
# Motor's own friction: turn of its shaft, rad, over which it is elastic before it slides.
_PRESLIDING_RAD = 0.01
# Stiffness of what a drum rubs more at a crawl, before it slides, over that of the cables.
_BRISTLES = 1.0
PAYLOAD = "payload"


def mjcf(m: Mechanism, elastic: ElasticDrive | None) -> ET.Element:
    """The whole file; ``elastic``: cables, parts and motors in place of the rigid ratio."""
    root = ET.Element("mujoco", model=m.name)
    ET.SubElement(root, "compiler", angle="radian", meshdir="meshes", inertiafromgeom="false", autolimits="true")
    option = ET.SubElement(root, "option", timestep=numbers([_TIMESTEP_S]), integrator="implicitfast")
    if elastic:
        option.set("noslip_iterations", str(_NOSLIP_ITERATIONS))
    assets = ET.SubElement(root, "asset")
    for link in (m.base, *m.links):
        ET.SubElement(assets, "mesh", name=link.name, file=f"{link.name}.stl")
    world = ET.SubElement(root, "worldbody")
    ET.SubElement(world, "light", pos="0.2 0.4 0.6", dir="-0.3 -0.6 -1")
    base = ET.SubElement(world, "body", name=BASE_LINK, pos=numbers(m.base.origin))
    _body(base, m.base)
    bodies = {joint.link: _jointed(base, m, joint, elastic) for joint in m.joints}
    equality = ET.SubElement(root, "equality")
    for joint in m.joints:
        if joint.link != m.drum and not (elastic and joint.link in m.inputs):
            ET.SubElement(
                equality,
                "joint",
                name=f"{joint.link}_ratio",
                joint1=joint.link,
                joint2=joint.leader or m.drum,
                polycoef=f"0 {numbers([joint.ratio / (m.joint(joint.leader).ratio if joint.leader else 1.0)])} 0 0 0",
                attrib=_STIFF,
            )
    if elastic:
        _elastic(root, m, elastic, bodies)
    return root


def _jointed(base: ET.Element, m: Mechanism, joint: Joint, elastic: ElasticDrive | None) -> ET.Element:
    link = m.link(joint.link)
    body = ET.SubElement(base, "body", name=link.name, pos=numbers(link.origin))
    friction, armature = joint.friction_Nm, joint.armature
    if elastic and joint.link == m.drum:
        friction = max(friction - elastic.built.slow_Nm, 0.0)
    if elastic and joint.link in m.inputs:
        friction = _input_friction_Nm(m, elastic, joint)
        if elastic.play_rad > 0.0:
            friction, armature = 0.0, _pulley_kg_m2(m, elastic, joint)
    node = ET.SubElement(
        body,
        "joint",
        name=link.name,
        type="hinge",
        axis=numbers(joint.axis),
        range=numbers(joint.range_rad),
        armature=numbers([armature]),
        frictionloss=numbers([friction]),
        attrib={"ref": numbers([joint.drawn_rad])} if joint.drawn_rad else {},
    )
    if joint.damping_Nm_s:
        node.set("damping", numbers([joint.damping_Nm_s]))
    if elastic:
        node.attrib.update(_FIRM)
    _body(body, link)
    return body


def _input_friction_Nm(m: Mechanism, e: ElasticDrive, joint: Joint) -> float:
    """At an input without that of its motor, the gearhead under the torque of the preload."""
    i = m.inputs.index(joint.link)
    return e.input_friction_Nm[i] + e.gear_share * abs(e.rest_Nm[i] / joint.ratio)


def _pulley_kg_m2(m: Mechanism, e: ElasticDrive, joint: Joint) -> float:
    """What the inertia of an input without its rotor lacks for MuJoCo's step."""
    cables = e.stages[m.inputs.index(joint.link)].sticking_Nm_rad / joint.ratio**2
    least = _PULLEY_INERTIA * _TIMESTEP_S**2 * (e.contact_Nm_rad + cables)
    return max(least - _about(joint.axis, m.link(joint.link)), 0.0)


def _body(body: ET.Element, link: Link) -> None:
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


def _within(
    body: ET.Element,
    name: str,
    axis: tuple[float, float, float],
    joint: Mapping[str, str],
    at: Vector = (0.0, 0.0, 0.0),
) -> None:
    """A body of no mass in another, that turns in it about this axis."""
    inner = ET.SubElement(body, "body", name=name, attrib={"pos": numbers(at)} if any(at) else {})
    ET.SubElement(inner, "joint", name=name, type="hinge", axis=numbers(axis), attrib=dict(joint))
    none = numbers([_NOTHING_KG_M2] * 3)
    ET.SubElement(inner, "inertial", pos="0 0 0", mass=numbers([_NOTHING_KG]), diaginertia=none)


def _elastic(root: ET.Element, m: Mechanism, e: ElasticDrive, bodies: dict[str, ET.Element]) -> None:
    tendons, actuators = ET.SubElement(root, "tendon"), ET.SubElement(root, "actuator")
    drum = m.joint(m.drum)
    give = e.compliance.land_to_payload
    if give > 0.0:
        _within(
            bodies[m.drum],
            PAYLOAD,
            drum.axis,
            {"armature": numbers([e.payload_kg_m2 + _PAYLOAD_KG_M2]), **_spring(1.0 / give)},
        )
    for stage, name in zip(e.stages, m.inputs, strict=True):
        joint = m.joint(name)
        _stage(tendons, m, stage, joint, bodies[name])
        if e.play_rad > 0.0:
            _behind_play(root, tendons, m, e, joint)
        _motor(actuators, e, joint)
    _stribeck(actuators, e, m.drum)
    _sensors(root, tendons, m, e)
    # What the gearheads lose with the load follows from these, by a line of the program that steps the model.
    custom = ET.SubElement(root, "custom")
    ET.SubElement(custom, "numeric", name="gear_share", data=numbers([e.gear_share]))
    if e.built.driving_share or e.built.driven_share:
        shares = numbers([e.built.driving_share, e.built.driven_share, drum.friction_Nm])
        ET.SubElement(custom, "numeric", name="drum_load_shares", data=shares)
    for own, name in zip(e.input_friction_Nm, m.inputs, strict=True):
        ET.SubElement(custom, "numeric", name=f"{name}_friction", data=numbers([own]))
    keys = ET.SubElement(root, "keyframe")
    ET.SubElement(keys, "key", name="held", ctrl=numbers(e.held_Nm), qpos=numbers(_rest(m, e)))


def _spring(stiffness_Nm_rad: float) -> dict[str, str]:
    return {"stiffness": numbers([stiffness_Nm_rad]), "damping": numbers([_TIMESTEP_S * stiffness_Nm_rad])}


def _stage(tendons: ET.Element, m: Mechanism, stage: CableStage, joint: Joint, body: ET.Element) -> None:
    """The cables of one input: their spring with the preload, and each elastic-slip element."""
    # Without a spring its rest length would not carry the preload.
    spring = stage.spring_Nm_rad
    rest = {"springlength": numbers([stage.preload_Nm / spring])} if spring > 0.0 else {}
    tendon = ET.SubElement(tendons, "fixed", name=f"{joint.link}_cables", attrib={**_spring(spring), **rest})
    lever = numbers([-1.0 / joint.ratio])
    ET.SubElement(tendon, "joint", joint=m.drum, coef="1")
    ET.SubElement(tendon, "joint", joint=joint.link, coef=lever)
    for k, slip in enumerate(stage.slips, 1):
        name = f"{joint.link}_slip_{k}"
        inertia = _SLIP_INERTIA * _TIMESTEP_S**2 * slip.stiffness_Nm_rad
        own = {"armature": numbers([inertia]), "frictionloss": numbers([slip.limit_Nm]), **_FIRM}
        _within(body, name, joint.axis, own)
        tendon = ET.SubElement(
            tendons, "fixed", name=name, attrib={**_spring(slip.stiffness_Nm_rad), "springlength": "0"}
        )
        ET.SubElement(tendon, "joint", joint=m.drum, coef="1")
        ET.SubElement(tendon, "joint", joint=joint.link, coef=lever)
        ET.SubElement(tendon, "joint", joint=name, coef="-1")


def _behind_play(root: ET.Element, tendons: ET.Element, m: Mechanism, e: ElasticDrive, joint: Joint) -> None:
    """The motor of an input as a joint of the base at the input's scale, and what it turns the input by."""
    base = root.find(f"worldbody/body[@name='{BASE_LINK}']")
    assert base is not None
    friction = numbers([_input_friction_Nm(m, e, joint)])
    drawn = {"ref": numbers([joint.drawn_rad])} if joint.drawn_rad else {}
    name, turned = f"{joint.link}_rotor", {"armature": numbers([joint.armature]), "frictionloss": friction}
    _within(base, name, joint.axis, {**turned, **_FIRM, **drawn}, m.link(joint.link).origin)
    half = 0.5 * e.play_rad
    ends = {"range": numbers([-half, half]), **_soft_end(m, e, joint)}
    tendon = ET.SubElement(tendons, "fixed", name=f"{joint.link}_play", attrib=ends)
    ET.SubElement(tendon, "joint", joint=name, coef="1")
    ET.SubElement(tendon, "joint", joint=joint.link, coef="-1")


def _soft_end(m: Mechanism, e: ElasticDrive, joint: Joint) -> dict[str, str]:
    """A limit that is a spring k at the end of each step: its torque is -(a + v/h + r/h^2)/R with R = 1/(k h^2).

    MuJoCo's R is (1 - d)/d times the inverse inertia of the tendon; a, v, r are its acceleration, speed, way beyond.
    """
    pulley = _about(joint.axis, m.link(joint.link)) + _pulley_kg_m2(m, e, joint)
    d = 1.0 / (1.0 + 1.0 / (e.contact_Nm_rad * _TIMESTEP_S**2 * (1.0 / joint.armature + 1.0 / pulley)))
    d = min(max(d, _IMPEDANCES[0]), _IMPEDANCES[1])
    reference = numbers([-d / _TIMESTEP_S**2, -d / _TIMESTEP_S])
    return {"solreflimit": reference, "solimplimit": numbers([d, d, 1.0])}


def _about(axis: Vector, link: Link) -> float:
    """Moment of inertia of a link about its joint's axis."""
    along, cog = np.array(axis), np.array(link.cog)
    return float(along @ np.array(link.inertia) @ along + link.mass * (cog @ cog - (along @ cog) ** 2))


def _motor(actuators: ET.Element, e: ElasticDrive, joint: Joint) -> None:
    motor = e.motor
    bristle = motor.friction_Nm / _PRESLIDING_RAD
    damping = (bristle * motor.inertia_kg_m2) ** 0.5  # half of critical
    ET.SubElement(
        actuators,
        "dcmotor",
        name=f"{joint.link}_motor",
        joint=f"{joint.link}_rotor" if e.play_rad > 0.0 else joint.link,
        gear=numbers([copysign(e.gear_ratio, joint.ratio)]),
        input="ff",
        motorconst=numbers([motor.constant_Nm_A, motor.constant_Nm_A]),
        resistance=numbers([motor.resistance_ohm]),
        saturation=numbers([motor.peak_Nm, 0.0, 0.0]),
        controller=numbers([0.0] * 5 + [motor.voltage_V or 0.0]),
        thermal=numbers([motor.heat_K_W, motor.heat_J_K, 0.0, motor.copper_per_K, motor.rated_at_C, motor.ambient_C]),
        lugre=numbers([bristle, damping, motor.friction_Nm, motor.friction_Nm, 1.0]),
    )


def _stribeck(actuators: ET.Element, e: ElasticDrive, drum: str) -> None:
    """What a built drum rubs more at a crawl, as a motor without current, whose LuGre friction fades with the speed."""
    built = e.built
    most = built.slow_Nm + built.stribeck_Nm
    if most <= 0.0:
        return
    # Stiffer than the cables it would be unstable at this step.
    bristle = _BRISTLES * sum(stage.sticking_Nm_rad for stage in e.stages)
    if built.built_up_rad > 0.0:
        bristle = min(bristle, most / built.built_up_rad)
    ET.SubElement(
        actuators,
        "dcmotor",
        name=f"{drum}_stribeck",
        joint=drum,
        input="none",
        motorconst="0 0",
        resistance="1",
        lugre=numbers([bristle, 0.0, max(built.slow_Nm, 1e-6 * most), most, built.fades_rad_s]),
    )


def _sensors(root: ET.Element, tendons: ET.Element, m: Mechanism, e: ElasticDrive) -> None:
    """What the encoders and the payload turn by, as sensors."""
    sensors = ET.SubElement(root, "sensor")
    at = e.compliance
    give = at.land_to_payload

    def sensor(name: str, joint: str, share: float) -> None:
        tendon = ET.SubElement(tendons, "fixed", name=name)
        ET.SubElement(tendon, "joint", joint=joint, coef="1")
        if give > 0.0:
            ET.SubElement(tendon, "joint", joint=PAYLOAD, coef=numbers([share]))
        ET.SubElement(sensors, "tendonpos", name=name, tendon=name)

    sensor("drum_encoder", m.drum, at.land_to_encoder / give if give else 0.0)
    sensor("payload_angle", m.drum, 1.0)
    for name, share in zip(m.inputs, e.input_shares, strict=True):
        # 1 N m on the payload, which turns it back by the whole, holds the pulley back by the part before it.
        # Behind its play the motor has a joint of its own, and the input's is that of the pulley.
        whole = give > 0.0 and e.play_rad == 0.0
        back = copysign(share / at.before_inputs_Nm_rad / give, m.joint(name).ratio) if whole else 0.0
        sensor(f"{name}_encoder", name, back)


def _rest(m: Mechanism, e: ElasticDrive) -> list[float]:
    """Angles of all joints as drawn, in the file's order."""
    found = []
    for joint in m.joints:
        found.append(joint.drawn_rad)
        if joint.link == m.drum and e.compliance.land_to_payload > 0.0:
            found.append(0.0)
        if joint.link in m.inputs:
            found += [0.0] * len(e.stages[m.inputs.index(joint.link)].slips)
    for rest, name in zip(e.rest_Nm, m.inputs, strict=True) if e.play_rad > 0.0 else ():
        torque = rest / m.joint(name).ratio
        twist = torque / e.contact_Nm_rad + (copysign(0.5 * e.play_rad, torque) if torque else 0.0)
        found.append(m.joint(name).drawn_rad + twist)
    return found


FORMATS = ("urdf", "mjcf")


def robot_files(
    mechanism: Mechanism, form: str, *, elastic: ElasticDrive | None = None, options: UrdfOptions | None = None
) -> dict[str, bytes]:
    """All files of an export by path in its folder: the description and ``meshes/<link>.stl``.

    ``elastic`` (MJCF only): cables, parts and motors between inputs and drum instead of a rigid ratio; ``options``
    (URDF only). Raises ``ValueError`` for an unknown ``form``, or one that has not what is asked.
    """
    if form not in FORMATS or (elastic and form != "mjcf") or (options and form != "urdf"):
        raise ValueError(f"no such form: {form}{', elastic' if elastic else ''}; there are {', '.join(FORMATS)}")
    meshes = {}
    for link in (mechanism.base, *mechanism.links):  # in metres, in the link's frame
        placed = replace(link.mesh, points_mm=link.mesh.points_mm * MM - np.array(link.origin))
        meshes[f"meshes/{link.name}.stl"] = stl_bytes(link.name, placed)
    if form == "urdf":
        return {**urdf_files(mechanism, options or UrdfOptions()), **meshes}
    return {f"{mechanism.name}.xml": document(mjcf(mechanism, elastic), mechanism.note), **meshes}
