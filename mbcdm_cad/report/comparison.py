"""Comparison of designs from the files of their builds: torque, mass, box, backlash, stiffness, modes, parts, margins.

Torque counts losses where ``limits.losses`` of a design does. Swings are computed at one load for all designs, the
smallest of their test torques, because those of cables do not grow in proportion to the load. Swing, stiffness and mode
are those at the payload, cables and structure; the cables alone stand beside them.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.layouts.turns import turns_at
from mbcdm_cad.report.table import ReportTable

# Units for which the margin over the limit is a reserve of load.
_LOADS = ("times", "N m", "of breaking load")


@dataclass(frozen=True)
class ComparedDesign:
    """Figures of one design. ``tightest_check``: of the checks of strength and torque, and its margin over its limit.

    ``above_gearhead``: a sentence where the torque is above a rating of the gearhead, else "".
    ``toleranced_fits`` counts the fits on the drawings of its made parts, ``undrawn`` the made parts without one.
    """

    name: str
    configuration: str
    torque_positive_Nm: float
    torque_negative_Nm: float
    above_gearhead: str
    mass_g: float
    torque_to_weight_Nm_kg: float
    box_mm: tuple[float, float, float]
    box_cm3: float
    torque_per_volume_Nm_l: float
    swing_load_Nm: float
    swing_mrad: float
    cable_swing_mrad: float
    stiffness_Nm_rad: float
    cable_stiffness_Nm_rad: float
    lowest_mode_Hz: float
    travel_deg: float
    total_ratio: float
    made_parts: int
    made_kinds: int
    bought_parts: int
    toleranced_fits: int
    undrawn: int
    tightest_check: str
    tightest_margin_share: float


def distinct_labels(designs: Sequence[tuple[str, Path]]) -> list[str]:
    """A word for each design (name, file) that no other has: its name; its file if names are equal; else a number."""
    names, files = Counter(name for name, _ in designs), Counter(path for _, path in designs)
    return [
        name if names[name] == 1 else str(path) if files[path] == 1 else f"{name} {number}"
        for number, (name, path) in enumerate(designs, 1)
    ]


def own_folder(label: str) -> str:
    """Name of a folder for the build of a design that shares its name with another one."""
    return re.sub(r"\W+", "-", label.removesuffix(".yaml")).strip("-")


def compared(drive: Drive, report: dict[str, Any], load_Nm: float) -> ComparedDesign:
    """Figures of one built design from its report, with the swings at ``load_Nm``."""
    torque = report["torque"]["peak_positive_Nm"], report["torque"]["peak_negative_Nm"]
    mass, box = report["mass"]["mass_g"], tuple(report["envelope"]["size_mm"])
    litres = box[0] * box[1] * box[2] * 1e-6
    turns = turns_at(layout_of(drive), load_Nm)
    lines = report["bill_of_materials"]
    made = [line for line in lines if line["kind"] == "made"]
    name, share = _tightest(report["checks"])
    fits, undrawn = _fits(drive)
    return ComparedDesign(
        name=drive.name,
        configuration=drive.configuration,
        torque_positive_Nm=torque[0],
        torque_negative_Nm=torque[1],
        above_gearhead=report["torque"]["above_gearhead"],
        mass_g=mass,
        torque_to_weight_Nm_kg=min(torque) / mass * 1e3,
        box_mm=(box[0], box[1], box[2]),
        box_cm3=litres * 1e3,
        torque_per_volume_Nm_l=min(torque) / litres,
        swing_load_Nm=load_Nm,
        swing_mrad=turns.felt.swing_mrad,
        cable_swing_mrad=turns.cables.swing_mrad,
        stiffness_Nm_rad=turns.felt.sticking_stiffness_Nm_rad,
        cable_stiffness_Nm_rad=turns.cables.sticking_stiffness_Nm_rad,
        lowest_mode_Hz=report["torsion"]["lowest_inputs_held_Hz"],
        travel_deg=2.0 * drive.half_travel_deg,
        total_ratio=drive.cables[0].drum_radius_mm / drive.cables[0].input_radius_mm,
        made_parts=sum(line["count"] for line in made),
        made_kinds=len(made),
        bought_parts=sum(line["count"] for line in lines if line["kind"] != "made"),
        toleranced_fits=fits,
        undrawn=undrawn,
        tightest_check=name,
        tightest_margin_share=share,
    )


def _tightest(checks: Sequence[dict[str, Any]]) -> tuple[str, float]:
    """(id, margin over limit) of the check of strength or torque that is nearest to its limit, without warnings."""
    found = [
        (check["margin"] / abs(check["limit"]), check["id"])
        for check in checks
        if check["unit"] in _LOADS and check["limit"] and check["status"] == "pass"
    ]
    share, name = min(found, default=(float("nan"), ""))
    return name, share


def _fits(drive: Drive) -> tuple[int, int]:
    """Fits on the drawings of all kinds of made parts, and how many kinds have no drawing."""
    bill = layout_of(drive).bill()
    made = {item.part for item in bill.items if item.mass_g is None}
    fits = sum(len(part.sheet(name).fits) for name, part in bill.made.items())
    return fits, len(made) - len(bill.made)


def comparison_data(designs: Sequence[ComparedDesign]) -> list[dict[str, Any]]:
    """The designs as plain data."""
    return [asdict(design) for design in designs]


def comparison_table(designs: Sequence[ComparedDesign]) -> ReportTable:
    """One column a design."""
    rows: tuple[tuple[str, str | Callable[[ComparedDesign], Any]], ...] = (
        ("configuration", "configuration"),
        ("total ratio", "total_ratio"),
        ("travel, deg", "travel_deg"),
        ("torque at the drum, +, N m", "torque_positive_Nm"),
        ("torque at the drum, -, N m", "torque_negative_Nm"),
        ("mass, g", "mass_g"),
        ("torque to weight, N m/kg", "torque_to_weight_Nm_kg"),
        ("box X x Z x Y, mm", lambda d: " x ".join(f"{side:.1f}" for side in d.box_mm)),
        ("box, cm3", "box_cm3"),
        ("torque per volume of the box, N m/l", "torque_per_volume_Nm_l"),
        ("swing of the payload at a reversal, mrad", "swing_mrad"),
        ("  by the cables alone", "cable_swing_mrad"),
        ("  at the load, N m", "swing_load_Nm"),
        ("stiffness at the payload, small motion, N m/rad", "stiffness_Nm_rad"),
        ("  of the cables alone", "cable_stiffness_Nm_rad"),
        ("lowest mode, inputs held, Hz", "lowest_mode_Hz"),
        ("made parts (kinds)", lambda d: f"{d.made_parts} ({d.made_kinds})"),
        ("bought parts", "bought_parts"),
        ("toleranced fits on the drawings", _fit_words),
        ("tightest check of strength and torque", lambda d: f"{d.tightest_check} {d.tightest_margin_share:+.1%}"),
    )
    return ReportTable(
        ("", *(design.name for design in designs)),
        tuple(
            (label, *(getattr(design, of) if isinstance(of, str) else of(design) for design in designs))
            for label, of in rows
        ),
    )


def torque_notes(designs: Sequence[ComparedDesign]) -> list[str]:
    """Sentences on torques of the table that are above a rating of the gearhead."""
    return [f"{design.name}: {design.above_gearhead}" for design in designs if design.above_gearhead]


def _fit_words(d: ComparedDesign) -> str:
    return str(d.toleranced_fits) + (f", {d.undrawn} kinds not drawn" if d.undrawn else "")
