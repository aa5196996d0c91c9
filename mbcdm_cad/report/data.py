"""The content of the report as plain data: report.json contains it, report.md is written from it. Masses, inertias."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import jinja2
import markupsafe
import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.checks.comparison import CheckResult, shown
from mbcdm_cad.design.describe import flow
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.base import Conventions, FrameCompliance, Layout
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.layouts.turns import modes_of
from mbcdm_cad.model import equations
from mbcdm_cad.model.analysis import analyse
from mbcdm_cad.model.bulk import preload_table
from mbcdm_cad.model.figures import Analysis
from mbcdm_cad.model.tolerance import stack_data
from mbcdm_cad.parts.bill import CABLE, Bill, Item
from mbcdm_cad.parts.part import BoughtPart, StandardPart
from mbcdm_cad.report import analysis_report
from mbcdm_cad.report.losses import losses_shown, stage_figures
from mbcdm_cad.report.preload import preload_shown
from mbcdm_cad.report.table import speed_shown
from mbcdm_cad.storage.cache import rounded
from mbcdm_cad.workshop.interference import bodies
from mbcdm_cad.workshop.mass import MassProperties, combined, item_mass
from mbcdm_cad.workshop.pairs import Clash
from mbcdm_cad.workshop.store import StoredPart

# One sigma of a mass that the catalogue calls an estimate, of one with a maker's figure, and of a machined part
# (density of the alloy and machining tolerances). Parts of one kind have the same error, different kinds independent
# ones.
ESTIMATE_SIGMA = 0.10
CATALOGUE_SIGMA = 0.02
MADE_SIGMA = 0.01
_MASS = re.compile(r"\bmass\b|\d\s?g\b(?!/cm3)", re.IGNORECASE)


@dataclass(frozen=True)
class BillLine:
    """One line of the bill of materials: all items of one part."""

    part: str
    count: int
    kind: str
    material: str
    each_g: float
    total_g: float
    sigma_g: float
    source: str


@dataclass(frozen=True)
class ReflectedInertias:
    """Moments of inertia of the moving parts, g mm^2: reflected to the drum's axis, and to one motor's shaft.

    ``passed_at_drum`` are those of bodies that cables pass; ``input_shafts`` are each input's about its own axis,
    without its rotor.
    """

    drum_group: float
    passed_at_drum: dict[str, float]
    inputs_at_drum: float
    rotors_at_drum: float
    at_drum_without_rotors: float
    at_drum: float
    at_motor: float
    input_shafts: tuple[float, ...]

    def to_dict(self) -> dict[str, Any]:
        """As the report holds it, a key ``NAME_at_drum`` for each body that cables pass."""
        plain = asdict(self)
        return {**{f"{name}_at_drum": value for name, value in plain.pop("passed_at_drum").items()}, **plain}


def _source(item: Item, parts_list: Bill, drive: Drive) -> str:
    if item.kind == "made":
        return f"volume x {item.material.density_g_cm3:g} g/cm^3 ({item.material.source})"
    if item.name.startswith(CABLE):
        return drive.cable.source
    body = parts_list.parts[item.part].part
    if isinstance(body, StandardPart):
        return f"{body.designation}; volume x {item.material.density_g_cm3:g} g/cm^3 ({item.material.source})"
    return body.entry.source if isinstance(body, BoughtPart) else ""


def mass_is_estimated(source: str) -> bool:
    """Whether a catalogue entry's source calls its mass an estimate.

    The clause about the mass (with this word, or a figure in g) decides; without one, the whole text.
    """
    clauses = re.split(r";|\.\s", source)
    of_mass = [clause for clause in clauses if _MASS.search(clause)]
    return any("estimate" in clause.lower() for clause in of_mass or clauses)


def bill_lines(centred: Bill, parts: Mapping[str, StoredPart], drive: Drive) -> tuple[BillLine, ...]:
    """Bill of materials, heaviest line first."""
    by_part: dict[str, list[Item]] = {}
    for item in centred.items:
        by_part.setdefault(item.part, []).append(item)
    lines = []
    for part, items in by_part.items():
        first = items[0]
        each = item_mass(first, parts[part].files.shape).mass_g
        source = _source(first, centred, drive)
        total, estimated = each * len(items), mass_is_estimated(source)
        lines.append(
            BillLine(
                part,
                len(items),
                first.kind,
                first.material.name,
                each,
                total,
                total * (MADE_SIGMA if first.kind == "made" else ESTIMATE_SIGMA if estimated else CATALOGUE_SIGMA),
                source,
            )
        )
    return tuple(sorted(lines, key=lambda line: (-line.total_g, line.part)))


def masses_by_item(centred: Bill, parts: Mapping[str, StoredPart]) -> dict[str, MassProperties]:
    """Mass properties of every item at its place."""
    return {item.name: item_mass(item, parts[item.part].files.shape) for item in centred.items}


def inertias(layout: Layout, centred: Bill, by_item: Mapping[str, MassProperties]) -> ReflectedInertias:
    """Inertia reflected to the drum's axis: each moving group times the square of its ratio to the drum.

    Cables are left out (2 g, moving with the rims); the rotors turn i_c x gearhead times faster than the drum.
    """
    drive = layout.drive
    groups: dict[str, list[MassProperties]] = {}
    for item in centred.items:
        groups.setdefault(item.group, []).append(by_item[item.name])
    drum = rotors = 0.0
    passed: dict[str, float] = {}
    inputs = 0.0
    shafts = []
    for body in layout.moving_bodies:
        own = combined(groups[body.name]).about_axis(body.axis, body.origin_mm)
        at_drum = own * body.turns_per_drum**2
        if body.kind == "drum":
            drum = own
        elif body.kind == "passed":
            passed[body.name] = at_drum
        elif body.kind == "stage":
            inputs += at_drum
        else:
            # kg m^2 to g mm^2.
            rotor = drive.rotor_at_input_kg_m2 * 1e9
            inputs += at_drum
            rotors += rotor * body.turns_per_drum**2
            shafts.append(own)
    first = drive.cables[0]
    motor_ratio = first.drum_radius_mm / first.input_radius_mm * drive.reduction.ratio
    without = drum + sum(passed.values()) + inputs
    everything = without + rotors
    return ReflectedInertias(
        drum, passed, inputs, rotors, without, everything, everything / motor_ratio**2, tuple(shafts)
    )


Box = tuple[NDArray[np.float64], NDArray[np.float64]]


def cable_boxes_mm(layout: Layout, drum_angles_deg: Sequence[float]) -> list[Box]:
    """Lowest and highest corner of all cables at each drum angle, from their centre lines and radius."""
    own, boxes = layout.drive.cable.diameter_mm, []
    for angle in drum_angles_deg:
        paths = layout.all_cable_paths(np.radians(angle))
        points = [(path.sample(0.25), (path.diameter_mm or own) / 2) for path in paths]
        low = np.min([at.min(axis=0) - radius for at, radius in points], axis=0)
        boxes.append((low, np.max([at.max(axis=0) + radius for at, radius in points], axis=0)))
    return boxes


def boxes_mm(
    layout: Layout,
    centred: Bill,
    parts: Mapping[str, StoredPart],
    drum_angles_deg: Sequence[float],
    cables: Sequence[Box],
) -> list[Box]:
    """Lowest and highest corner (x, y, z) of everything at each drum angle; ``cables`` from :func:`cable_boxes_mm`.

    Solids from their meshes (within the mesh tolerance), those of a body turned together.
    """
    items = {item.name: item for item in centred.items}
    boxes = list(cables)
    for group in bodies(layout.moving_bodies, centred):
        placed = [items[name].location.apply(parts[items[name].part].files.mesh.points_mm) for name in group.items]
        if not placed:
            continue
        points = np.ascontiguousarray(np.concatenate(placed).T)  # in rows, which are searched several times as fast
        low, high = points.min(axis=1), points.max(axis=1)
        for k, angle in enumerate(drum_angles_deg):
            if group.ratio:
                motion = group.at(angle)
                turned = motion.rotation @ points + motion.shift_mm[:, None]
                low, high = turned.min(axis=1), turned.max(axis=1)
            boxes[k] = np.minimum(boxes[k][0], low), np.maximum(boxes[k][1], high)
    return boxes


REPORT_FORMAT = 1
_SWEPT_POSES = 29


def _conventions(own: Conventions, threads: str) -> list[str]:
    drilled = ["In the files of single parts tapped holes have the diameter of their tap drill."]
    return [
        own.frame,
        "Radii of the design file are pitch radii, to the cable's centre line; surfaces are cut at r - d/2.",
        "Threads, outside and inside, are drawn as plain cylinders at the nominal diameter; "
        "tap drills are in the catalogue.",
        own.cables,
        "The box is taken over all solids with the drum centred, without leads; the swept box over the whole travel.",
        "Bought parts have their catalogue mass spread evenly over their simplified solid.",
        *(drilled if threads == "tap_drill" else []),
    ]


def _frame(frame: FrameCompliance, layout: Layout) -> dict[str, Any]:
    drive = layout.drive
    return {
        "windup_urad_Nm": frame.windup_urad_Nm,
        "windup_at_test_torque_mrad": frame.windup_mrad(drive.loads.test_torque_Nm),
        "limit_mrad": layout.windup_limit_mrad,
        "shares_urad_Nm": frame.shares_urad_Nm,
    }


def _mass(m: MassProperties) -> dict[str, Any]:
    return {"mass_g": m.mass_g, "cog_mm": m.cog_mm, "inertia_about_cog_g_mm2": m.inertia_g_mm2}


def checks_data(checks: Sequence[CheckResult]) -> dict[str, Any]:
    """The report's data of the checks; a report with failed checks exists only if the build was forced."""
    failed = [c.id for c in checks if c.status == "fail"]
    plain = rounded({"checks": [asdict(c) for c in checks], "failed_checks": failed, "forced": bool(failed)})
    assert isinstance(plain, dict)
    return plain


@dataclass(frozen=True)
class Tested:
    """Results that only a whole build has: clashes at the tested poses, and the windup of the frame."""

    clashes: Sequence[Clash] = ()
    poses_deg: Sequence[float] = ()
    frame: FrameCompliance | None = None


@dataclass(frozen=True)
class DesignFigures:
    """The report's data that need no drawn part: ``data`` as in the report, and values that other data depend on.

    ``boxes`` are those of the cables at ``angles_deg``, the first with the drum centred, the others over its travel.
    """

    analysis: Analysis
    data: dict[str, Any]
    angles_deg: tuple[float, ...]
    boxes: tuple[Box, ...]


def design_figures(layout: Layout, centred: Bill) -> DesignFigures:
    """Model, tolerances, tensioning and order of assembly of a design; ``centred`` is its bill, the drum centred."""
    drive = layout.drive
    analysis, order = analyse(layout_of(drive)), layout.assembly_order
    half = drive.half_travel_deg
    angles = (0.0, *(float(angle) for angle in np.linspace(-half, half, _SWEPT_POSES)))
    data = {
        "analysis": analysis.to_dict(),
        "paths": analysis_report.path_data(layout),
        "torsion": asdict(modes_of(layout)),
        **{
            name: analysis_report.subject_or_reason(layout, name)[0]
            for name in ("structure", "losses", "life", "preload", "duty")
        },
        "tolerance_stacks": [stack_data(stack) for stack in layout.tolerance_stacks],
        "holes": centred.holes(),
        "asked_torque_Nm": drive.loads.peak_torque_Nm,
        "reached_preloads": [asdict(row) | {"holds_Nm": row.holds_Nm} for row in preload_table(layout_of(drive))],
        "tensioning": (None if layout.tensioning is None else asdict(layout.tensioning)),
        "cable_lengths_mm": {p.cable.name: p.length_mm for p in layout.all_cable_paths(0.0)},
        "assembly_order": [step.text for step in order],
        "assembly_items": [list(step.items) for step in order],
        "conventions": _conventions(layout.conventions, drive.export.threads),
    }
    if layout.first_stage_unit is not None:
        data["stages"] = [asdict(one) for one in stage_figures(layout)]
    return DesignFigures(analysis, data, angles, tuple(cable_boxes_mm(layout, angles)))


def report_data(
    layout: Layout,
    centred: Bill,
    parts: Mapping[str, StoredPart],
    tested: Tested,
    *,
    drum_angle_deg: float,
    design_sha256: str,
    figures: DesignFigures | None = None,
) -> dict[str, Any]:
    """The report of one build without its checks, some of which judge these data.

    ``centred`` is the bill with the drum centred; ``figures`` are those of :func:`design_figures` if they are known.
    """
    drive = layout.drive
    figures = figures or design_figures(layout, centred)
    by_item = masses_by_item(centred, parts)
    whole = combined(by_item.values())
    lines = bill_lines(centred, parts, drive)
    boxes = boxes_mm(layout, centred, parts, figures.angles_deg, figures.boxes)
    low, high = boxes[0]
    size = high - low
    swept = np.max([box[1] for box in boxes[1:]], axis=0) - np.min([box[0] for box in boxes[1:]], axis=0)
    moving = inertias(layout, centred, by_item)
    kilograms = whole.mass_g / 1e3
    data = {
        "format": REPORT_FORMAT,
        "design": drive.name,
        "design_sha256": design_sha256,
        "configuration": drive.configuration,
        "drum_angle_deg": drum_angle_deg,
        "travel_deg": [drive.middle_deg - drive.half_travel_deg, drive.middle_deg + drive.half_travel_deg],
        "mass": {
            **_mass(whole),
            "sigma_g": float(np.sqrt(sum(line.sigma_g**2 for line in lines))),  # kinds of parts err independently
            "target_g": drive.targets.mass_g,
            "tolerance_g": drive.targets.mass_tolerance_g,
            "prototype_measured_g": drive.targets.prototype_mass_g,
        },
        "inertia_moving_g_mm2": moving.to_dict(),
        "envelope": {
            "axes": ["X", "Z", "Y"],
            "size_mm": [float(size[0]), float(size[2]), float(size[1])],
            "low_xyz_mm": [float(v) for v in low],
            "high_xyz_mm": [float(v) for v in high],
            "target_mm": drive.targets.envelope_mm,
            "tolerance_mm": drive.targets.envelope_tolerance_mm,
            "swept_xyz_mm": [float(v) for v in swept],
        },
        "interference": {"poses_deg": list(tested.poses_deg), "clashes": [asdict(c) for c in tested.clashes]},
        "frame": _frame(tested.frame, layout) if tested.frame else None,
        "torque": {
            "peak_positive_Nm": figures.analysis.peak_torque_Nm[0],
            "peak_negative_Nm": figures.analysis.peak_torque_Nm[1],
            "above_gearhead": analysis_report.above_gearhead(
                figures.analysis.limits, drive.mounted, "peak torque", figures.analysis.peak_torque_Nm
            ),
            "torque_to_weight_Nm_kg": min(figures.analysis.peak_torque_Nm) / kilograms,
            "paper_design_Nm_kg": equations.DESIGN_TORQUE_TO_WEIGHT_NM_KG,
            "paper_measured_Nm_kg": equations.TORQUE_TO_WEIGHT_NM_KG,
        },
        "bill_of_materials": [asdict(line) for line in lines],
        "items": {
            item.name: {"part": item.part, "group": item.group, **_mass(by_item[item.name])} for item in centred.items
        },
        "parts": {
            name: {
                "volume_mm3": made.files.shape.volume_mm3,
                "area_mm2": made.files.shape.area_mm2,
                "box_low_mm": made.files.shape.low_mm,
                "box_high_mm": made.files.shape.high_mm,
                "mesh_deviation_mm": made.files.mesh.deviation_mm,
                "mesh_volume_error": made.files.mesh_volume_error,
                "triangles": len(made.files.mesh.triangles),
            }
            for name, made in sorted(parts.items())
            if not made.files.mesh.is_empty
        },
        **figures.data,
    }
    plain = rounded(data)
    assert isinstance(plain, dict)
    return plain


_AT_DRUM = "_at_drum"


def _figure(value: Any) -> str:
    if isinstance(value, float):
        return shown(value)
    if isinstance(value, list | tuple):
        return ", ".join(_figure(v) for v in value)
    return "none" if value is None else str(value)


def report_markdown(data: dict[str, Any], paths_template: str) -> str:
    """The report in words and tables; ``paths_template`` is the layout's for its cable paths."""

    def in_markdown(value: Any) -> Any:  # reasons and sources of users become no column, no link and no HTML
        if not isinstance(value, str) or isinstance(value, markupsafe.Markup):
            return value
        return " ".join(value.splitlines()).replace("|", "\\|").replace("<", "&lt;").replace("](", "]\\(")

    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("mbcdm_cad.report", "."),
        undefined=jinja2.StrictUndefined,
        keep_trailing_newline=True,
        autoescape=False,  # these are for HTML
        finalize=in_markdown,
    )
    environment.filters["figure"] = _figure
    environment.filters["figures"] = _figure
    environment.filters["flow"] = flow
    environment.filters["speed"] = speed_shown
    paths = markupsafe.Markup(environment.from_string(paths_template).render(r=data))
    moving = data["inertia_moving_g_mm2"]
    passed = {
        name.removesuffix(_AT_DRUM): value
        for name, value in moving.items()
        if name.endswith(_AT_DRUM) and name not in ("inputs_at_drum", "rotors_at_drum")
    }
    motor = data["analysis"]["motor"]
    return environment.get_template("report.md.j2").render(
        r=data,
        a=data["analysis"],
        papers_test=equations.papers_test(data["analysis"]["test"][0]["load_Nm"]),
        paths=paths,
        passed=passed,
        losses=losses_shown(data["losses"]),
        life=analysis_report.life_shown(data["life"]),
        preload=preload_shown(data["preload"]),
        duty=analysis_report.duty_shown(data["duty"]),
        motor_lines=analysis_report.motor_lines(motor) if motor else (),
    )
