"""Evaluate one point: size it, check it without advice, and take its figures as ``check`` or ``analyse`` gives them."""

import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from mbcdm_cad.checks.comparison import Check
from mbcdm_cad.checks.size import kept_mass_g
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.loader import Resolved
from mbcdm_cad.design.yamltree import leaves, value_at
from mbcdm_cad.errors import InputError, MbcdmError, did_you_mean
from mbcdm_cad.layouts import stiff_sizing
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.life import life_of
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.layouts.turns import TurnAt, turns_of
from mbcdm_cad.model.analysis import PeakTorques, peak_torques, reversal_swing_mrad
from mbcdm_cad.model.capability import torque_to_weight_Nm_kg
from mbcdm_cad.model.structure.causes import Structure
from mbcdm_cad.optimising.spread import Spread, percentile_of
from mbcdm_cad.optimising.wishes import Keep
from mbcdm_cad.parts.bill import Bill
from mbcdm_cad.parts.making import NoPriceError, bought_cost_EUR, material_cost_EUR
from mbcdm_cad.solving.question import Point, Question, stated
from mbcdm_cad.solving.trials import LAST, checks_by_id, missed, must_hold

# Figures are kept to this many significant digits: a linear algebra library with another number of threads changes the
# last ones, and a search that goes on elsewhere shall end with the same bytes.
DIGITS = 10
# Figures and checks that follow from finite elements of drum or frame.
BY_ELEMENTS = stiff_sizing.BY_ELEMENTS | {"swing_mrad", "stiffness_Nm_rad", "structure_over_cables"}


class Facts:
    """What the figures of one design follow from, each computed on first use. ``data``: the content of its file."""

    def __init__(self, drive: Drive, data: Mapping[str, Any]) -> None:
        self.drive, self.data = drive, data
        self.layout = layout_of(drive)
        self.checks: Mapping[str, Check] = {check.id: check for check in checks_of(drive)}
        # Why a figure that was asked for does not exist, by its name.
        self.reasons: dict[str, str] = {}

    @cached_property
    def torques(self) -> PeakTorques:
        """Peak torques both ways."""
        return peak_torques(self.layout)

    @cached_property
    def cable_swing_mrad(self) -> float:
        """Swing of the drum at a reversal of the test torque by the cables alone."""
        return reversal_swing_mrad(self.layout)

    @cached_property
    def bill(self) -> Bill:
        """All parts."""
        return self.layout.once("bill", lambda s: s.bill())

    @cached_property
    def mass_g(self) -> float:
        """The estimated mass, from closed forms."""
        return kept_mass_g(self.layout)

    @property
    def payload(self) -> TurnAt:
        """What the payload turns by at the test torque, by cables and structure."""
        turns = turns_of(self.layout)
        if turns.payload is None:
            raise NoFigureError(turns.no_structure)
        return turns.payload

    @property
    def structure(self) -> Structure:
        """What turns the payload besides the cables."""
        found = structure_of(self.layout)
        if found is None:
            raise NoFigureError(turns_of(self.layout).no_structure)
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
        life = life_of(self.layout)
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


FIGURES: dict[str, DesignFigure] = {
    "mass_g": DesignFigure("estimated mass of all parts", "g", lambda f: f.mass_g),
    "swing_mrad": DesignFigure(
        "swing of the payload at a reversal of the test torque, cables and structure",
        "mrad",
        lambda f: f.payload.swing_mrad,
    ),
    "cable_swing_mrad": DesignFigure(
        "swing of the drum at a reversal of the test torque, cables alone, as in the paper",
        "mrad",
        lambda f: f.cable_swing_mrad,
    ),
    "stiffness_Nm_rad": DesignFigure("stiffness at the payload", "N m/rad", lambda f: f.structure.stiffness_Nm_rad),
    "structure_over_cables": DesignFigure(
        "turn of the structure over that of the cables", "-", lambda f: f.structure.over_cables
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
    "bend_ratio": DesignFigure(
        "least D/d of all bends",
        "-",
        lambda f: 2.0 * min(radius for *_, radius in f.layout.bends_mm()) / f.drive.cable.diameter_mm,
    ),
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


# Figures without a limit, which fail only where the model has no answer.
NOTED = frozenset({"wrap_slip_test", "wrap_slip_peak"})
# Checks that take as long as all quick ones together and seldom miss.
LONG = frozenset({"life", "path_length", "pair_mismatch", "transmission_error", "backdrive", "take_up"})
BOX = frozenset(f"envelope_{axis}" for axis in "xyz")
# The checks run in stages, and keeps with them, by what they take: those of a stage only if a design passes all before.
ELEMENTS, SLOWER, QUICK = range(3)
_SLOWER = LAST | NOTED | LONG | BOX
# What a miss in a stage adds, so that a design that passes more stages is always nearer to a pass.
STAGE = 200.0
# Violation of a point that gives no drive.
NO_DRIVE = 1000.0
# Between the name of an aim and the reason why a design cannot be compared with others.
NO_FIGURE = ": no figure, "
# Beginning of the reason of a point that shows a fault of this program.
FAULT = "fault of the program: "


@dataclass(frozen=True)
class Evaluated:
    """One evaluated point, plain data.

    ``failing``: the checks and keeps that it misses, and the aims of which it has no figure, each with its share of
    ``violation``; ``refused``: why it is no drive; ``figures`` and ``fields`` (of its file, by dotted name) of a design
    that passes.
    """

    failing: tuple[tuple[str, float], ...] = ()
    refused: str = ""
    figures: Mapping[str, float] = field(default_factory=dict)
    fields: Mapping[str, Any] = field(default_factory=dict)

    @property
    def passes(self) -> bool:
        """Whether it is a drive that passes every check and keeps every figure."""
        return not self.failing and not self.refused

    @property
    def violation(self) -> float:
        """Zero for a design that passes, and the larger the further it is from that."""
        if self.refused:
            return NO_DRIVE
        reached = max((_stage(name) for name, _ in self.failing), default=ELEMENTS)
        return STAGE * reached + sum(miss for _, miss in self.failing)


def _stage(name: str) -> int:
    """The stage of a check, of a keep as text, or of an aim without a figure."""
    figure, _, limit = name.partition(":")
    if figure in BY_ELEMENTS or percentile_of(figure) is not None:
        return ELEMENTS
    return SLOWER if limit or figure in _SLOWER else QUICK


def evaluate(question: Question, point: Point, keeps: Sequence[Keep], names: Sequence[str]) -> Evaluated:
    """Evaluate a point; ``names`` are the figures wanted beside those of :data:`FIGURES`.

    The file that states the point decides: where a rule changes because a value is stated, that design counts.
    """
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        try:
            data, moved = question.trial(point)
            found = question.resolve(data, moved)
            facts = facts_of(found)
            failing = _missed_early(facts, keeps, names)
            if failing:
                return Evaluated(failing)
            if moved:
                data = stated(data, moved, found)
                as_stated = question.resolve(data, {})
                if as_stated.design != found.design:
                    facts = facts_of(as_stated)
                    failing = _missed_early(facts, keeps, names)
            failing = failing or _missed(facts, keeps, names, ELEMENTS)
            if failing:
                return Evaluated(failing)
            return _figures(facts, data, names, keeps)
        except InputError as error:
            return Evaluated(refused=str(error.problems[0].what))
        except (MbcdmError, NoFigureError) as error:
            return Evaluated(refused=str(error))
        except Exception as error:  # a search of hours must not end at one point; the result counts them
            return Evaluated(refused=f"{FAULT}{type(error).__name__}: {error}")


_Missed = tuple[tuple[str, float], ...]


def _missed_early(facts: Facts, keeps: Sequence[Keep], names: Sequence[str]) -> _Missed:
    return _missed(facts, keeps, names, QUICK) or _missed(facts, keeps, names, SLOWER)


def _missed(facts: Facts, keeps: Sequence[Keep], names: Sequence[str], stage: int) -> _Missed:
    """The checks of a stage that fail and are not waived; if there are none, its keeps that are missed.

    A design without a figure of an aim cannot be compared with others: that counts as a keep that is missed.
    """
    drive = facts.drive
    asked = [
        check
        for check in facts.checks.values()
        if _stage(check.id) == stage and must_hold(check, drive) and drive.waiver(check.id) is None
    ]
    misses = [(check.id, missed(check, layout_of(drive))) for check in asked]
    own = [keep for keep in keeps if _stage(str(keep)) == stage]
    aims = [name for name in names if _stage(name + NO_FIGURE) == stage]
    if not any(miss for _, miss in misses):
        misses = [(str(keep), _short(keep, figure(facts, keep.figure))) for keep in own]
        lacking = [name for name in aims if not np.isfinite(figure(facts, name))]
        misses += [(name + NO_FIGURE + facts.reasons.get(name, "the file has no such number"), 1.0) for name in lacking]
    return tuple((name, float(f"{miss:.9g}")) for name, miss in misses if miss)


def _short(keep: Keep, value: float) -> float:
    """What a keep adds to the violation, below 1; zero if it is kept."""
    margin = keep.margin(value) if np.isfinite(value) else float("-inf")
    share = max(-margin, 0.0) / (abs(keep.limit) or 1.0)
    return share / (1.0 + share) if np.isfinite(share) else 1.0


def facts_of(found: Resolved) -> Facts:
    """What the figures of a design follow from."""
    return Facts(found.drive, found.sizing.data if found.sizing is not None else found.design.model_dump())


def _figures(facts: Facts, data: Mapping[str, Any], names: Sequence[str], keeps: Sequence[Keep]) -> Evaluated:
    figures = {name: figure(facts, name) for name in dict.fromkeys([*FIGURES, *names, *(k.figure for k in keeps)])}
    known = {name: value for name, value in figures.items() if np.isfinite(value)}
    return Evaluated((), "", known, dict(leaves(data)))
