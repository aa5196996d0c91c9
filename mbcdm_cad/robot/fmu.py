"""A drive as an FMU for co-simulation (FMI 2.0): motors' torques and load in, encoders and payload out.

The FMU holds the sources ``drive.c`` and ``parameters.h`` of one design, and the library for this computer where a C
compiler is found. It has what the elastic MJCF has, and the part of the gearheads' loss that follows the load. The same
design gives the same sources. Standard: fmi-standard.org, FMI 2.0.
"""

import io
import shutil
import subprocess
import sys
import tempfile
import uuid
import zipfile
from collections.abc import Iterable
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from xml.etree import ElementTree as ET

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.robot.elastic import ElasticDrive
from mbcdm_cad.robot.mechanism import document

# Identifies designs of this program among GUIDs made from content.
_SPACE = uuid.UUID("6a1f6d0e-0c0f-5d0f-8a37-5d2c6b0b2f0a")
_MODEL = "drive"
# The same files give the same archive.
_DATE = (2000, 1, 1, 0, 0, 0)


@dataclass(frozen=True)
class FmuVariable:
    """A variable of the FMU, or one for each input: C name of the first, names, unit, and values at the start.

    ``causality`` is that of FMI: parameter, input or output.
    """

    constant: str
    names: tuple[str, ...]
    unit: str
    causality: str
    start: tuple[float, ...]
    about: str


def variables(e: ElasticDrive, inputs: tuple[str, ...]) -> tuple[FmuVariable, ...]:
    """All variables in the order of their value references."""
    motor = e.motor
    none = (0.0,) * len(inputs)

    def one(constant: str, unit: str, start: float, about: str, causality: str = "parameter") -> FmuVariable:
        return FmuVariable(constant, (constant.lower(),), unit, causality, (start,), about)

    def each(constant: str, unit: str, start: Iterable[float], about: str, causality: str) -> FmuVariable:
        names = tuple(f"{constant.lower()}_{name}" for name in inputs)
        return FmuVariable(constant, names, unit, causality, tuple(start), about)

    return (
        one("PAYLOAD_INERTIA", "kg.m2", e.payload_kg_m2, "moment of inertia of the payload about the drum's axis"),
        one(
            "COMPLIANCE",
            "rad/(N.m)",
            e.compliance.land_to_payload,
            "turn of the payload by the parts behind the cables",
        ),
        one("DRUM_FRICTION", "N.m", e.drum_friction_Nm, "cables and bearings at the drum and bodies that cables pass"),
        each("INPUT_FRICTION", "N.m", e.input_friction_Nm, "cables, bearings, gearhead without load", "parameter"),
        one("GEAR_SHARE", "1", e.gear_share, "loss of a gearhead over the torque at its output"),
        one("MOTOR_FRICTION", "N.m", motor.friction_Nm, "friction of a motor at its shaft"),
        one("PEAK_TORQUE", "N.m", motor.peak_Nm, "largest torque of a motor"),
        one("TORQUE_CONSTANT", "N.m/A", motor.constant_Nm_A, "torque of a motor over its current"),
        one("RESISTANCE", "Ohm", motor.resistance_ohm, f"between two terminals at {motor.rated_at_C:g} C"),
        one("AMBIENT", "degC", motor.ambient_C, "temperature of the air"),
        each(
            "MOTOR_TORQUE",
            "N.m",
            e.held_Nm,
            "torque at the motor's shaft, positive where it drives the drum so",
            "input",
        ),
        one("LOAD_TORQUE", "N.m", 0.0, "torque on the payload, positive against positive rotation", "input"),
        one("DRUM_ENCODER", "rad", 0.0, "angle of the drum at its encoder", "output"),
        one("PAYLOAD_ANGLE", "rad", 0.0, "angle of the payload", "output"),
        one("PAYLOAD_SPEED", "rad/s", 0.0, "speed of the payload", "output"),
        each("INPUT_ENCODER", "rad", none, "angle of the input's pulley", "output"),
        each("MOTOR_ANGLE", "rad", none, "angle of the motor's shaft", "output"),
        each(
            "WINDING_TEMPERATURE", "degC", [motor.ambient_C] * len(inputs), "winding and housing as one body", "output"
        ),
    )


def fmu_file(drive: Drive, e: ElasticDrive) -> tuple[bytes, str]:
    """The FMU, and the platform whose library it holds, or "" where no C compiler is found.

    Raises ``MbcdmError`` where the compiler fails, or the parts of the drive do not give.
    """
    if not e.compliance.land_to_payload > 0.0:
        raise MbcdmError(f"{drive.name}: no FMU: none of its parts gives; state a layout with a structure")
    listed = variables(e, drive.input_names)
    parameters = _parameters(drive, e, listed)
    sources = {"drive.c": files("mbcdm_cad.robot").joinpath("drive.c").read_text("utf-8"), "parameters.h": parameters}
    guid = str(uuid.uuid5(_SPACE, "".join(sources.values())))
    sources["parameters.h"] += f'#define GUID "{guid}"\n'
    content = {f"sources/{name}": text.encode() for name, text in sources.items()}
    content["modelDescription.xml"] = document(_description(drive, listed, guid))
    platform, library = _compiled(sources)
    if library:
        content[f"binaries/{platform}/{_MODEL}{_SUFFIX[platform]}"] = library
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as zipped:
        for name in sorted(content):
            zipped.writestr(zipfile.ZipInfo(name, _DATE), content[name])
    return archive.getvalue(), platform if library else ""


def _parameters(drive: Drive, e: ElasticDrive, listed: tuple[FmuVariable, ...]) -> str:
    """The header with the figures of the design and the places of the variables."""
    cables = [(s.input_index, s.spring_Nm_rad, float("inf")) for s in e.stages if s.spring_Nm_rad > 0.0]
    cables += [(s.input_index, slip.stiffness_Nm_rad, slip.limit_Nm) for s in e.stages for slip in s.slips]
    at = e.compliance
    start = [value for variable in listed for value in variable.start]
    lines = [f"/* {drive.name}, written by mbcdm export; SI units. */"]
    place = 0
    for variable in listed:
        lines.append(f"#define {variable.constant} {place}")
        place += len(variable.start)
    inertias = layout_of(drive).inertias_kg_m2
    routes = layout_of(drive).routed.routes
    drum = inertias[routes.drum.name]
    drum += sum(inertias[body.name] * body.turns_per_drum**2 for body in routes.passed)
    pulleys = [inertias[body.name] * body.turns_per_drum**2 for body in routes.inputs]
    if e.play_rad == 0.0:
        drum += sum(pulleys)
    defined: dict[str, str] = {
        "N_VALUES": str(place),
        "N_INPUTS": str(len(e.stages)),
        "N_CABLES": str(len(cables)),
        "N_PULLEYS": "N_INPUTS" if e.play_rad > 0.0 else "0",
        "VALUES": _braced(start),
        "PRELOADS": _braced(stage.preload_Nm for stage in e.stages),
        "TURNS": _braced(e.turns),
        "INPUT_GIVE": _number(1.0 / at.before_inputs_Nm_rad),
        "ENCODER_SHARE": _number(at.land_to_encoder / at.land_to_payload),
        "CABLE_ELEMENTS": "{" + ", ".join(_braced(row) for row in cables) + "}",
        "GEAR_RATIO": _number(e.gear_ratio),
        "ROTOR_INERTIA": _number(e.motor.inertia_kg_m2),
        "DRUM_INERTIA": _number(drum),
        "PULLEY_INERTIAS": _braced(pulleys),
        "PLAY": _number(e.play_rad),
        "CONTACT": _number(e.contact_Nm_rad),
        "BUS_VOLTAGE": _number(e.motor.voltage_V or 0.0),
        "COPPER_PER_K": _number(e.motor.copper_per_K),
        "RATED_AT": _number(e.motor.rated_at_C),
        "HEAT_K_W": _number(e.motor.heat_K_W),
        "HEAT_J_K": _number(e.motor.heat_J_K),
        "DRUM_VISCOUS": _number(e.built.viscous_Nm_s),
        "DRUM_STRIBECK": _number(e.built.stribeck_Nm),
        "DRUM_FADES": _number(e.built.fades_rad_s),
        "DRUM_SHARES": _braced([e.built.driving_share, e.built.driven_share]),
    }
    return "\n".join([*lines, *(f"#define {name} {value}" for name, value in defined.items())]) + "\n"


def _number(value: float) -> str:
    return "HUGE_VAL" if value == float("inf") else f"{value:.12g}"


def _braced(values: Iterable[float]) -> str:
    return "{" + ", ".join(_number(value) for value in values) + "}"


def _description(drive: Drive, listed: tuple[FmuVariable, ...], guid: str) -> ET.Element:
    """modelDescription.xml."""
    root = ET.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=drive.name,
        guid=guid,
        generationTool="mbcdm-cad",
        variableNamingConvention="flat",
        numberOfEventIndicators="0",
    )
    co = ET.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=_MODEL,
        canHandleVariableCommunicationStepSize="true",
        canGetAndSetFMUstate="true",
        canNotUseMemoryManagementFunctions="true",
    )
    ET.SubElement(ET.SubElement(co, "SourceFiles"), "File", name="drive.c")
    units = ET.SubElement(root, "UnitDefinitions")
    for unit in dict.fromkeys(variable.unit for variable in listed):
        ET.SubElement(units, "Unit", name=unit)
    ET.SubElement(root, "DefaultExperiment", startTime="0", stopTime="1", stepSize="0.001")
    node, outputs = ET.SubElement(root, "ModelVariables"), []
    place = 0
    for variable in listed:
        fixed = variable.causality == "parameter"
        for name, start in zip(variable.names, variable.start, strict=True):
            scalar = ET.SubElement(
                node,
                "ScalarVariable",
                name=name,
                valueReference=str(place),
                description=variable.about,
                causality=variable.causality,
                variability="tunable" if fixed else "continuous",
                attrib={"initial": "exact"} if fixed else {},
            )
            given = {} if variable.causality == "output" else {"start": f"{start:.12g}"}
            ET.SubElement(scalar, "Real", unit=variable.unit, attrib=given)
            place += 1
            if variable.causality == "output":
                outputs.append(place)
    structure = ET.SubElement(root, "ModelStructure")
    for kind in ("Outputs", "InitialUnknowns"):
        unknowns = ET.SubElement(structure, kind)
        for index in outputs:
            ET.SubElement(unknowns, "Unknown", index=str(index))
    return root


_SUFFIX = {"linux64": ".so", "darwin64": ".dylib", "win64": ".dll"}


def _compiled(sources: dict[str, str]) -> tuple[str, bytes]:
    """The platform's name in FMI 2.0, and its library; empty where there is no compiler called ``cc``."""
    platform = {"linux": "linux64", "darwin": "darwin64"}.get(sys.platform, "win64")
    compiler = shutil.which("cc")
    if compiler is None:
        return platform, b""
    with tempfile.TemporaryDirectory() as folder:
        for name, text in sources.items():
            Path(folder, name).write_text(text, "utf-8")
        library = f"{_MODEL}{_SUFFIX[platform]}"
        command = [
            compiler,
            "-O2",
            "-std=c99",
            "-shared",
            "-fPIC",
            "-fvisibility=hidden",
            "-o",
            library,
            "drive.c",
            "-lm",
        ]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise MbcdmError(f"the C compiler refuses the FMU's sources: {done.stderr.strip()[:300]}")
        return platform, Path(folder, library).read_bytes()
