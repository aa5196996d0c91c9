"""The figures of a design that can be an aim or be kept, by name: each as ``check`` or ``analyse`` gives it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from mbcdm_cad.checks.comparison import Check
from mbcdm_cad.checks.size import kept_mass_g
from mbcdm_cad.design.fieldpath import value_at
from mbcdm_cad.errors import MbcdmError, did_you_mean
from mbcdm_cad.layouts import stiff_sizing
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.model.analysis import PeakTorques, peak_torques, reversal_swing_mrad
from mbcdm_cad.model.capability import torque_to_weight_Nm_kg
from mbcdm_cad.optimising.spread import Spread, percentile_of
from mbcdm_cad.parts.making import NoPriceError, bought_cost_EUR, material_cost_EUR
from mbcdm_cad.report.structure import StructureReport, structure_report
from mbcdm_cad.solving.trials import checks_by_id

if TYPE_CHECKING:
    from mbcdm_cad.design.drive import Drive
    from mbcdm_cad.parts.bill import Bill
    from mbcdm_cad.solving.question import Question

# Figures are kept to this many significant digits: a linear algebra library with another number of threads changes the
# last ones, and a search that goes on elsewhere shall end with the same bytes.
DIGITS = 10
# Figures and checks that follow from finite elements of drum or frame.
BY_ELEMENTS = stiff_sizing.BY_ELEMENTS | {"swing_mrad", "stiffness_Nm_rad", "structure_over_cables"}


class Facts:
    """What the figures of one design follow from, each computed on first use. ``checks``: those of its layout."""

    def __init__(self, drive: Drive, checks: Mapping[str, Check], data: Mapping[str, Any]) -> None:
        self.drive = drive
        self.layout = drive.layout
        self.checks = checks
        self.data = data
        # Why a figure that was asked for does not exist, by its name.
        self.reasons: dict[str, str] = {}

    @cached_property
    def torques(self) -> PeakTorques:
        """Peak torques both ways."""
        return peak_torques(self.drive)

    @cached_property
    def cable_swing_mrad(self) -> float:
        """Swing of the drum at a reversal of the test torque by the cables alone."""
        return reversal_swing_mrad(self.drive)

    @cached_property
    def bill(self) -> Bill:
        """All parts."""
        return self.layout.once("bill", lambda s: s.bill())

    @cached_property
    def mass_g(self) -> float:
        """The estimated mass, from closed forms."""
        return kept_mass_g(self.layout)

    @cached_property
    def structure(self) -> StructureReport:
        """What turns the payload besides the cables."""
        found, reason = structure_report(self.layout)
        if found is None:
            raise NoFigureError(reason)
        return found

    @cached_property
    def box_mm(self) -> tuple[float, float, float]:
        """The box (X, Z, Y) of all parts with the drum centred."""
        # The check of the box has worked it out; it is kept with the design.
        self.checks["envelope_x"].measure(self.layout)
        return self.layout.once("box_mm", _no_box)

    @cached_property
    def spread(self) -> Spread:
        """Figures over the drives that the design gives."""
        return Spread(self.drive, lambda: self.mass_g)

    @property
    def life_cycles(self) -> float:
        """Cycles at which half of the first cable to break have broken; by the formula where it outlives the data."""
        life = self.layout.life
        unknown = [rope.refused for rope in life.ropes if rope.refused and not rope.longer]
        if unknown:
            raise NoFigureError(unknown[0])
        return min(1.0 / float(rope.damage.max()) for rope in life.ropes)

    @property
    def backdrive_Nm(self) -> float:
        """Torque at the drum that starts to turn it, motors without current."""
        found = self.layout.losses.backdrive
        if found is None:
            raise NoFigureError("the gearheads lock: no torque at the drum turns them")
        return found.start_Nm

    @cached_property
    def material_cost_EUR(self) -> float:
        """Material of the made parts."""
        return _priced(lambda: material_cost_EUR(self.bill))

    @property
    def cost_EUR(self) -> float:
        """Material and bought parts."""
        bought = _priced(lambda: bought_cost_EUR(self.bill, self.drive.cable))
        return self.material_cost_EUR + bought

    @property
    def efficiency(self) -> float:
        """Share of the motors' work that reaches the payload at the peak torque, all losses counted."""
        peak = np.array([self.drive.loads.peak_torque_Nm])
        return float(self.layout.losses.moving(peak, 1).efficiency[0])


def _priced(cost: Callable[[], float]) -> float:
    try:
        return cost()
    except NoPriceError as error:
        raise NoFigureError(str(error)) from None


def _no_box(_: Any) -> tuple[float, float, float]:
    raise NoFigureError("the layout states no box")


@dataclass(frozen=True)
class DesignFigure:
    """A figure by its meaning and unit."""

    text: str
    unit: str
    of: Callable[[Facts], float]


def _bend_ratio(f: Facts) -> float:
    return 2.0 * min(radius for *_, radius in f.layout.bends_mm()) / f.drive.cable.diameter_mm


FIGURES: dict[str, DesignFigure] = {
    "mass_g": DesignFigure("estimated mass of all parts", "g", lambda f: f.mass_g),
    "swing_mrad": DesignFigure(
        "swing of the payload at a reversal of the test torque, cables and structure",
        "mrad",
        lambda f: f.structure.payload.swing_mrad,
    ),
    "cable_swing_mrad": DesignFigure(
        "swing of the drum at a reversal of the test torque, cables alone, as in the paper",
        "mrad",
        lambda f: f.cable_swing_mrad,
    ),
    "stiffness_Nm_rad": DesignFigure(
        "stiffness at the payload", "N m/rad", lambda f: f.structure.structure.stiffness_Nm_rad
    ),
    "structure_over_cables": DesignFigure(
        "turn of the structure over that of the cables", "-", lambda f: f.structure.structure.over_cables
    ),
    "torque_Nm": DesignFigure(
        "peak torque in the weaker direction, losses as limits.losses says", "N m", lambda f: min(f.torques.counted_Nm)
    ),
    "torque_lossless_Nm": DesignFigure(
        "peak torque in the weaker direction without losses", "N m", lambda f: min(f.torques.lossless_Nm)
    ),
    "torque_with_losses_Nm": DesignFigure(
        "peak torque in the weaker direction with all losses", "N m", lambda f: min(f.torques.with_losses_Nm)
    ),
    "torque_to_weight_Nm_kg": DesignFigure(
        "torque_Nm over the mass", "N m/kg", lambda f: torque_to_weight_Nm_kg(min(f.torques.counted_Nm), f.mass_g)
    ),
    "torque_to_weight_lossless_Nm_kg": DesignFigure(
        "torque_lossless_Nm over the mass",
        "N m/kg",
        lambda f: torque_to_weight_Nm_kg(min(f.torques.lossless_Nm), f.mass_g),
    ),
    "torque_to_weight_with_losses_Nm_kg": DesignFigure(
        "torque_with_losses_Nm over the mass",
        "N m/kg",
        lambda f: torque_to_weight_Nm_kg(min(f.torques.with_losses_Nm), f.mass_g),
    ),
    "efficiency": DesignFigure("at the peak torque, motors moving the load", "-", lambda f: f.efficiency),
    "backdrive_Nm": DesignFigure(
        "torque at the drum that starts to turn it, motors without current", "N m", lambda f: f.backdrive_Nm
    ),
    "life_cycles": DesignFigure(
        "cycles at which half of the cables that break first have broken", "-", lambda f: f.life_cycles
    ),
    "material_cost_EUR": DesignFigure(
        "material in the made parts, no waste, no work", "EUR", lambda f: f.material_cost_EUR
    ),
    "cost_EUR": DesignFigure("material, and bought parts with an entry", "EUR", lambda f: f.cost_EUR),
    "bend_ratio": DesignFigure("least D/d of all bends", "-", _bend_ratio),
    "box_x_mm": DesignFigure("box along X, drum centred", "mm", lambda f: f.box_mm[0]),
    "box_z_mm": DesignFigure("box along Z, drum centred", "mm", lambda f: f.box_mm[1]),
    "box_y_mm": DesignFigure("box along Y, drum centred", "mm", lambda f: f.box_mm[2]),
    "box_cm3": DesignFigure("volume of the box", "cm^3", lambda f: float(np.prod(f.box_mm)) * 1e-3),
}


def figure(facts: Facts, name: str) -> float:
    """A figure by its name, the id of a check or the dotted name of a field; NaN where the design has none."""
    percentile = percentile_of(name)
    try:
        if name in FIGURES:
            value = FIGURES[name].of(facts)
        elif percentile is not None:
            value = facts.spread.percentile(*percentile)
        elif name in facts.checks:
            value = facts.checks[name].measure(facts.layout).actual
        else:
            given = value_at(facts.data, name)
            value = float("nan") if isinstance(given, bool) or not isinstance(given, int | float) else float(given)
    except NoFigureError as error:
        facts.reasons[name] = str(error)
        return float("nan")
    return float(f"{value:.{DIGITS}g}") if np.isfinite(value) else float("nan")


def unit_of(name: str) -> str:
    """The unit of a figure; empty where its name tells it."""
    base = (percentile_of(name) or (name,))[0]
    return FIGURES[base].unit if base in FIGURES else ""


def refuse_unknown(names: Iterable[str], questions: Iterable[Question]) -> None:
    """Raise ``MbcdmError`` for a name that is no figure, and no check or field with a number of every layout."""
    for question in questions:
        checks = checks_by_id(question)
        for name in names:
            node = question.file.node_at(tuple(name.split("."))) or {}
            if name in FIGURES or percentile_of(name) or name in checks or node.get("type") in ("number", "integer"):
                continue
            near = did_you_mean(name, [*FIGURES, *checks])
            listed = near if near.startswith("did you") else "one of " + ", ".join(FIGURES)
            raise MbcdmError(f"{name}: no such figure; {listed}, the id of a check, or a field with a number")
