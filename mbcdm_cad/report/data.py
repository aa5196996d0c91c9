"""The content of the report as plain data: report.json contains it, report.md is written from it."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import jinja2
import numpy as np

from mbcdm_cad.checks.comparison import CheckResult, shown
from mbcdm_cad.design.describe import flow
from mbcdm_cad.layouts.base import Conventions, FrameCompliance, Layout
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.layouts.turns import modes_of
from mbcdm_cad.model import equations
from mbcdm_cad.model.analysis import analyse
from mbcdm_cad.model.bulk import preload_table
from mbcdm_cad.model.equations import papers_test
from mbcdm_cad.model.figures import Analysis
from mbcdm_cad.model.tolerance import stack_data
from mbcdm_cad.parts.bill import Bill
from mbcdm_cad.report.analysis_report import above_gearhead, motor_lines
from mbcdm_cad.report.duty import duty_report, duty_shown, life_report, life_shown
from mbcdm_cad.report.losses import losses_report, losses_shown, stage_figures
from mbcdm_cad.report.masses import Box, bill_lines, boxes_mm, cable_boxes_mm, inertias, masses_by_item, total_sigma_g
from mbcdm_cad.report.preload import preload_shares, preload_shown
from mbcdm_cad.report.structure import path_data, structure_report
from mbcdm_cad.report.table import speed_shown
from mbcdm_cad.workshop.mass import MassProperties, combined
from mbcdm_cad.workshop.pairs import Clash
from mbcdm_cad.workshop.store import StoredPart

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


def _rounded(value: Any, digits: int = 9) -> Any:
    """The data with figures rounded to ten significant digits, so that rounding errors do not appear."""
    if isinstance(value, float):
        return float(f"{value:.{digits}g}") if np.isfinite(value) else None
    if isinstance(value, dict):
        return {k: _rounded(v, digits) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_rounded(v, digits) for v in value]
    return value


def _frame(frame: FrameCompliance, layout: Layout) -> dict[str, Any]:
    drive = layout.drive
    return {
        "windup_urad_Nm": frame.windup_urad_Nm,
        "windup_at_test_torque_mrad": frame.windup_mrad(drive.loads.test_torque_Nm),
        "limit_mrad": layout.windup_limit_mrad,
        "shares_urad_Nm": frame.shares_urad_Nm,
    }


def _structure(layout: Layout) -> dict[str, Any] | None:
    found, _ = structure_report(layout)
    return None if found is None else found.to_dict()


def _mass(m: MassProperties) -> dict[str, Any]:
    return {"mass_g": m.mass_g, "cog_mm": m.cog_mm, "inertia_about_cog_g_mm2": m.inertia_g_mm2}


def checks_data(checks: Sequence[CheckResult]) -> dict[str, Any]:
    """The report's data of the checks; a report with failed checks exists only if the build was forced."""
    failed = [c.id for c in checks if c.status == "fail"]
    plain = _rounded({"checks": [asdict(c) for c in checks], "failed_checks": failed, "forced": bool(failed)})
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
    life, _ = life_report(layout)
    preload, _ = preload_shares(layout)
    half = drive.half_travel_deg
    angles = (0.0, *(float(angle) for angle in np.linspace(-half, half, _SWEPT_POSES)))
    data = {
        "analysis": analysis.to_dict(),
        "paths": path_data(layout),
        "structure": _structure(layout),
        "torsion": asdict(modes_of(layout)),
        "losses": losses_report(layout).to_dict(),
        "life": None if life is None else life.to_dict(),
        "preload": None if preload is None else preload.to_dict(),
        "duty": duty_report(layout).to_dict(),
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
            "sigma_g": total_sigma_g(lines),
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
            "above_gearhead": above_gearhead(
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
    plain = _rounded(data)
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
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("mbcdm_cad.report", "."),
        undefined=jinja2.StrictUndefined,
        keep_trailing_newline=True,
        autoescape=False,  # no HTML escapes in Markdown; all names in it are plain slugs
    )
    environment.filters["figure"] = _figure
    environment.filters["figures"] = _figure
    environment.filters["flow"] = flow
    environment.filters["speed"] = speed_shown
    paths = environment.from_string(paths_template).render(r=data)
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
        papers_test=papers_test(data["analysis"]["test"][0]["load_Nm"]),
        paths=paths,
        passed=passed,
        losses=losses_shown(data["losses"]),
        life=life_shown(data["life"]),
        preload=preload_shown(data["preload"]),
        duty=duty_shown(data["duty"]),
        motor_lines=motor_lines(motor) if motor else (),
    )
