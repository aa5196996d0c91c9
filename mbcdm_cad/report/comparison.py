"""Comparison of designs from the files of their builds: torque, mass, box, backlash, stiffness, modes, parts, margins.

Torque counts losses where ``limits.losses`` of a design does. Swings are computed at one load for all designs, the
smallest of their test torques, because those of cables do not grow in proportion to the load. Swing, stiffness and mode
are those at the payload, cables and structure; the cables alone stand beside them.

Columns of figures of many designs stand below, as text, plain data and data frames.
"""

from __future__ import annotations

import math
import re
from abc import abstractmethod
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import MbcdmError, did_you_mean
from mbcdm_cad.layouts.changes import changed_drives
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.layouts.turns import turns_at
from mbcdm_cad.model.bulk import BulkFigures, analyse_many, merged, stack_designs
from mbcdm_cad.model.capability import Requirements, requirements
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.report.table import ReportTable, TextReport, data_frame, designs_shown

if TYPE_CHECKING:
    import pandas

    from mbcdm_cad.design.loader import LoadedDesign


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
        (
            "toleranced fits on the drawings",
            lambda d: f"{d.toleranced_fits}" + (f", {d.undrawn} kinds not drawn" if d.undrawn else ""),
        ),
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


Values = NDArray[Any]
# Figures with a row for a load that opposes positive rotation, and one for the other direction.
_BOTH_WAYS = ("turn_rad", "peak_torque_Nm")
# Angles that are shown in degrees; the others, of backlash, in mrad.
_IN_DEGREES = ("wrap", "fleet_angle")


class DesignColumns(TextReport):
    """Columns by name, each with one value for each design. Iteration and indexing use columns."""

    @property
    @abstractmethod
    def columns(self) -> Mapping[str, Values]:
        """All columns by name, each (n,)."""

    @abstractmethod
    def summary(self) -> str:
        """How many designs there are, in one line."""

    def __getitem__(self, name: str) -> Values:
        """One column, (n,). Raises ``MbcdmError`` for a name that none has."""
        if name not in self.columns:
            raise MbcdmError(f"{name}: no such column; {did_you_mean(name, self.columns)}")
        return self.columns[name]

    def __iter__(self) -> Iterator[str]:
        """Names of the columns."""
        return iter(self.columns)

    def to_dict(self) -> dict[str, list[Any]]:
        """Columns as lists, ready for JSON: None if there is no figure."""
        return {
            name: [
                None if isinstance(value, float) and not math.isfinite(value) else value for value in column.tolist()
            ]
            for name, column in self.columns.items()
        }

    def to_pandas(self) -> pandas.DataFrame:
        """One row a design. ``MbcdmError`` without pandas."""
        return data_frame(dict(self.columns))

    def text(self, width: int | None = None) -> str:
        """How many designs there are, and the range of each column."""
        return "\n".join([self.summary(), *self._ranges().text(width, "  ")])

    def html(self) -> str:
        """For notebooks: the range of each column."""
        return f"<p>{self.summary()}</p>{self._ranges().html()}"

    def _ranges(self) -> ReportTable:
        rows = []
        for name, column in self.columns.items():
            if column.dtype == float and np.isfinite(column).any():
                rows.append((name, float(np.nanmin(column)), float(np.nanmax(column))))
        return ReportTable(("column", "lowest", "highest"), tuple(rows))


def figure_columns(figures: BulkFigures, cable_names: Sequence[str]) -> dict[str, Values]:
    """The figures by name and unit; those of a cable with its name, those of both directions as plus and minus."""
    found: dict[str, Values] = {}
    for field in fields(figures):
        values = np.asarray(getattr(figures, field.name))
        if values.ndim == 1:
            found |= _column(field.name, values)
        elif field.name in _BOTH_WAYS:
            for way, row in zip(("plus", "minus"), values, strict=True):
                stem, _, unit = field.name.rpartition("_")
                found |= _column(f"{stem}_{way}_{unit}", row)
        else:
            for cable, row in zip(cable_names, values, strict=True):
                found |= {f"{name}[{cable}]": column for name, column in _column(field.name, row).items()}
    return found


def _column(name: str, values: Values) -> dict[str, Values]:
    """A column in a readable unit, with which its name then ends."""
    stem, _, unit = name.rpartition("_")
    if unit == "rad":
        degrees = any(word in stem for word in _IN_DEGREES)
        return {f"{stem}_deg": np.degrees(values)} if degrees else {f"{stem}_mrad": values * 1e3}
    return {f"{stem}_mm": values * 1e3} if unit == "m" else {name: values}


def varied_columns(ranges: Mapping[str, Any], *, grid: bool) -> dict[str, Values]:
    """The fields that vary by their dotted names, each (n,): paired row by row, or all combinations.

    Raises ``MbcdmError`` for arrays of different lengths or none.
    """
    names = [name.replace("__", ".") for name in ranges]
    arrays = [np.atleast_1d(np.asarray(values)) for values in ranges.values()]
    columns = [mesh.ravel() for mesh in np.meshgrid(*arrays, indexing="ij")] if grid else _paired(names, arrays)
    if not columns or not len(columns[0]):
        raise MbcdmError("no designs to analyse; give at least one field with at least one value")
    return dict(zip(names, columns, strict=True))


def _paired(names: Sequence[str], arrays: Sequence[Values]) -> list[Values]:
    n = max((len(array) for array in arrays), default=0)
    for name, array in zip(names, arrays, strict=True):
        if array.ndim != 1 or len(array) not in (1, n):
            raise MbcdmError(
                f"{name}: values of shape {array.shape} beside others of length {n}; give each field one value, or as "
                "many as the longest, or grid=True for all combinations"
            )
    return [np.broadcast_to(array, (n,)) for array in arrays]


@dataclass(frozen=True, eq=False)
class Sweep(DesignColumns):
    """Figures of n designs: ``varied`` fields by name, ``figures`` in SI, ``cable_names`` of their rows.

    Iterating and indexing goes over columns: the varied fields, then the figures in mm, N, N m, deg and, of backlash,
    mrad. A design that has no free span has ``valid`` False and NaN in its figures. ``reversal_swing_mrad`` is the
    backlash that a bench measures when the load changes sign; ``cable_backlash_mrad[NAME]`` is Eq. (14) of one cable.
    """

    name: str
    varied: Mapping[str, Values]
    figures: BulkFigures
    cable_names: tuple[str, ...]

    @cached_property
    def columns(self) -> dict[str, Values]:
        """All columns by name, each (n,)."""
        return {**self.varied, **figure_columns(self.figures, self.cable_names)}

    def __len__(self) -> int:
        """Number of designs."""
        return len(self.figures.valid)

    def summary(self) -> str:
        """How many designs there are, and how many have a free span."""
        return f"{self.name}: {designs_shown(len(self))}, {int(np.sum(self.figures.valid))} with a free span"


def sweep(loaded: LoadedDesign, ranges: Mapping[str, Any], *, grid: bool = False) -> Sweep:
    """Analyse the designs that ``ranges`` describe: for each field an array of values, one a design, or one for all.

    ``grid`` makes all combinations of the values instead, the last field varying fastest. Fields are named and
    validated as in :func:`mbcdm_cad.layouts.changes.with_changes`; what the file leaves out is sized again for
    each design, which takes 10 to 60 ms each. Errors: ``InputError`` for a value that the file could not hold,
    ``MbcdmError`` for arrays of different lengths or none.
    """
    varied = varied_columns(ranges, grid=grid)
    rows = [dict(zip(varied, row, strict=True)) for row in zip(*varied.values(), strict=True)]
    drives = list(changed_drives(loaded, rows))
    asked = [requirements(layout_of(drive)) for drive in drives]
    designs, groups = [layout_of(drive).si for drive in drives], list[tuple[list[int], BulkFigures]]()
    for members in _routed_alike(designs):
        need = Requirements(*(np.array([getattr(asked[k], f.name) for k in members]) for f in fields(Requirements)))
        groups.append((members, analyse_many(stack_designs([designs[k] for k in members]), need)))
    cables = tuple(cable.name for cable in drives[0].cables)
    return Sweep(loaded.drive.name, varied, merged(groups, len(rows)), cables)


def _routed_alike(designs: Sequence[DriveSI]) -> list[list[int]]:
    """Indices of the designs in groups with the same routes; sizing rules may choose other arrangements for some."""
    groups: list[list[int]] = []
    for k, design in enumerate(designs):
        own = next((group for group in groups if designs[group[0]].geometry == design.geometry), None)
        if own is None:
            groups.append([k])
        else:
            own.append(k)
    return groups
