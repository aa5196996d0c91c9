"""The base class of all layouts, through which all other rooms use a design.

An object of a layout is one design of one kind of drive, with all that follows from its fields: routes, dimensions of
every part, bill, figures for the checks. Each is computed on first use, and modules are imported when they are needed,
so that a program that only simulates does not load the code of the parts.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, wraps
from importlib import import_module
from importlib.resources import files
from math import copysign, radians
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.design.drive import Drive

if TYPE_CHECKING:
    from mbcdm_cad.checks.comparison import Check, Family
    from mbcdm_cad.checks.design_variables import DesignVariable
    from mbcdm_cad.design.bought import Material
    from mbcdm_cad.design.loader import DesignFile
    from mbcdm_cad.model.duty import Duty, MotorDay
    from mbcdm_cad.model.equilibrium import CableTensions
    from mbcdm_cad.model.losses import BearingPair, Train
    from mbcdm_cad.model.si import DriveSI
    from mbcdm_cad.model.structure.causes import Cause
    from mbcdm_cad.model.tensioning import TensioningPlan
    from mbcdm_cad.model.tolerance import StackUp
    from mbcdm_cad.parts.bill import AssemblyStep, Bill, BillBuilder, MovingBody, Placement
    from mbcdm_cad.routes.curves import CablePath
    from mbcdm_cad.routes.route import RoutedDrive

_T = TypeVar("_T")
# The model is not evaluated above this multiple of sum(T_pre r_o), at which cables without friction go slack.
OVERLOAD = 4.0
# A printed frame may turn the drum by this multiple of the cables' turn: plastic is some forty times as soft as
# aluminium, and thicker walls make up for only a part of that (a choice).
PRINTED_WINDUP = 6.0


class NoFigureError(Exception):
    """Raised for a figure that does not exist for this design; the text gives the reason and ends a sentence."""


@dataclass(frozen=True)
class Conventions:
    """Texts of the report on the drawn model: its frame of reference, and how its cables are drawn."""

    frame: str
    cables: str


@dataclass(frozen=True)
class FrameCompliance:
    """Rotation of the drum per N m by the support's deflection, in total and by the part whose strain causes it."""

    windup_urad_Nm: float
    shares_urad_Nm: dict[str, float]

    def windup_mrad(self, torque_Nm: float) -> float:
        """Rotation of the drum under an external torque, mrad; proportional to the torque."""
        return self.windup_urad_Nm * torque_Nm * 1e-3


@dataclass(frozen=True)
class FrameStudy:
    """The computation of the frame's compliance and all that it depends on, so that its result can be cached.

    ``module`` is the one whose code computes it, ``inputs`` are plain data, complete for the cache key. ``walls`` are
    the fields of
    ``support`` that make the frame stiffer, with their values in mm.
    """

    module: str
    inputs: Any
    compute: Callable[[], FrameCompliance]
    walls: Mapping[str, float]

    def compliance(self) -> FrameCompliance:
        """The compliance; infinite if the frame has no metal that carries the load."""
        try:
            return self.compute()
        except (ValueError, ArithmeticError):
            return FrameCompliance(float("inf"), {})


class PathFigures(Protocol):
    """Figures of the cables' true paths: a frozen dataclass that goes into the report with all its fields.

    ``cables`` has an entry for each cable, with at least ``name``, ``length_um`` (change of the length between the
    anchors from the centred drum, at each angle) and ``input_wrap_deg``, ``drum_wrap_deg`` (at each angle).
    """

    @property
    def drum_angle_deg(self) -> tuple[float, ...]:
        """The drum angles over the travel."""

    @property
    def cables(self) -> tuple[Any, ...]:
        """Figures of each cable."""

    @property
    def usable_deg(self) -> tuple[float, float]:
        """(lowest, highest) drum angle of the usable travel, deg."""


def dimensions(worked_out: Callable[[Any], _T]) -> cached_property[_T]:
    """A cached property with the dimensions of a part, in mm, drum centred.

    Reading it raises :class:`NoFigureError` with the reason where no geometry exists for the design.
    """

    @wraps(worked_out)
    def of(layout: Layout) -> _T:
        layout.require_geometry()
        try:
            return worked_out(layout)
        except (ValueError, ZeroDivisionError) as error:
            raise _no_solution(error) from None

    return cached_property(of)


def _no_solution(error: Exception) -> NoFigureError:
    return NoFigureError(f"the dimensions have no solution: {error}")


class Layout(ABC):
    """One design of one kind of drive. A layout is a subclass in a package of its own, ``LAYOUT`` of its ``layout.py``.

    What is long has a module of its own beside that file, found by its name: ``design_file`` (``DESIGN_FILE``),
    ``cable_path`` (``routed``), ``bill`` (``bill``, ``steps_of`` with ``assembly.md.j2``),
    ``path_figures`` (``path_figures``, ``path_lines``, ``plan`` of the preloads), ``checks`` (``FAMILIES``,
    ``stacks``), ``support.stiffness`` (``frame_study``), and ``paths.md.j2``. A small layout overrides the methods
    below instead.

    Every figure raises :class:`NoFigureError` if it does not exist for this design.
    """

    # Name in the design file (``configuration: NAME``), and a short description in one line.
    name: ClassVar[str]
    title: ClassVar[str]
    conventions: ClassVar[Conventions]
    # Kinds of options that its designs may have.
    takes: ClassVar[tuple[type[Attachment], ...]] = ()
    _by_id: ClassVar[dict[str, Check]]

    def __init__(self, drive: Drive, **given: Any) -> None:
        """``given``: dimensions by their names, in place of those that follow from ``drive``."""
        self.drive = drive
        self.__dict__.update(given)
        self._kept: dict[str, Any] = {}
        # A design whose loads are worked out already, and which may have the same.
        self.before: Layout | None = None

    # What all designs of a layout share.

    @classmethod
    def module(cls, name: str) -> Any:
        """A module of the layout's package, by its name there."""
        return import_module(f"{cls.__module__.rpartition('.')[0]}.{name}")

    @classmethod
    def design_file(cls) -> DesignFile:
        """Schema, reference values and rules of its design files, and the function that makes a drive from one."""
        found: DesignFile = cls.module("design_file").DESIGN_FILE
        return found

    @classmethod
    def check_families(cls) -> tuple[Family, ...]:
        """The checks of its designs, in the order in which they are run and shown."""
        found: tuple[Family, ...] = cls.module("checks").FAMILIES
        return found

    @classmethod
    def checks_by_id(cls) -> Mapping[str, Check]:
        """The checks of its designs by their ids."""
        if "_by_id" not in cls.__dict__:
            cls._by_id = {check.id: check for family in cls.check_families() for check in family.checks}
        return cls._by_id

    @classmethod
    def path_lines(cls, cable: dict[str, Any]) -> Iterator[str]:
        """One cable's path figures (as a dict) for the terminal."""
        found: Iterator[str] = cls.module("path_figures").path_lines(cable)
        return found

    @classmethod
    def paths_template(cls) -> str:
        """Jinja template of the report's table of cable paths; ``r`` is the report's data."""
        return files(cls.module("layout").__package__).joinpath("paths.md.j2").read_text("utf-8")

    # Other designs of this layout.

    def with_drive(self, drive: Drive) -> Self:
        """The same for another drive."""
        return type(self)(drive)

    def with_dimensions(self, **given: Any) -> Self:
        """The design with dimensions in place of its own, by their names; those that follow from them change too."""
        return type(self)(self.drive, **given)

    # The mechanism.

    @cached_property
    def routed(self) -> RoutedDrive:
        """Routes of the cables, on which model, rig and loop work."""
        return self.routes_in(1e-3)

    def routes_in(self, unit: float) -> RoutedDrive:
        """The same in another unit of length, given what a mm is in it."""
        found: RoutedDrive = self.module("cable_path").routed(self.drive, unit)
        return found

    @property
    def si(self) -> DriveSI:
        """The drive in SI; the same object for the same drive, so that what follows from it is worked out once.

        Raises ``ModelError`` where it has no routes.
        """
        from mbcdm_cad.model.si import to_si

        return self.drive.once("si", lambda drive: to_si(drive, lambda: self.routed, self.slips_on_passed))

    @cached_property
    def inertias_kg_m2(self) -> Mapping[str, float]:
        """Moment of inertia of each body of the routes with all that turns with it, about its own axis, without CAD.

        That of an input contains what stands before it, up to the rotor. ``NoFigureError`` where a part has no form.
        """
        self.require_geometry()
        try:
            bill = self.bill()
            each = [(body, bill.inertia_g_mm2(body) * 1e-9) for body in self.moving_bodies]
        except (ValueError, ZeroDivisionError) as error:
            raise _no_solution(error) from None
        found: dict[str, float] = {}
        own: MovingBody | None = None
        for body, inertia in each:
            if body.kind == "stage":
                assert own is not None, "the input that a stage turns comes before it"
                found[own.name] += inertia * (body.turns_per_drum / own.turns_per_drum) ** 2
            else:
                found[body.name], own = inertia, body
        return found

    # Its parts.

    def require_geometry(self) -> None:
        """Raise NoFigureError with the reason if no geometry exists for the design at all."""
        if self._why_impossible is not None:
            raise NoFigureError(self._why_impossible)

    @cached_property
    def _why_impossible(self) -> str | None:
        try:
            self.refuse_impossible()
        except (ValueError, ZeroDivisionError) as error:
            return str(_no_solution(error))
        except NoFigureError as error:
            return str(error)
        return None

    def refuse_impossible(self) -> None:
        """Raise ValueError, ZeroDivisionError or NoFigureError for a design without any geometry."""
        return

    @abstractmethod
    def cable_paths(self, drum_angle_rad: float) -> tuple[CablePath, ...]:
        """Centre lines of all cables, in the order of the design's cables."""

    def all_cable_paths(self, drum_angle_rad: float) -> tuple[CablePath, ...]:
        """As :meth:`cable_paths`, with the cables of a drive that stands before this one in the assembly."""
        attached = (path for each in self.attachments for path in each.cable_paths(drum_angle_rad))
        return (*self.cable_paths(drum_angle_rad), *attached)

    @cached_property
    def attachments(self) -> tuple[Attachment, ...]:
        """The options that this design has, of those that its layout takes."""
        return tuple(kind(self) for kind in self.takes if getattr(self.drive, kind.block) is not None)

    @property
    def first_stage_unit(self) -> Layout | None:
        """The drive that turns the input of this one, in the same file; None for a drive of one stage."""
        return next((each.unit for each in self.attachments if each.unit is not None), None)

    @property
    def further_checks(self) -> tuple[Check, ...]:
        """Checks of this design besides those of its layout, run after them: of a drive that stands before this one."""
        return tuple(check for each in self.attachments for check in each.checks)

    @cached_property
    def moving_bodies(self) -> tuple[MovingBody, ...]:
        """The bodies of the routes, each with those of attachments that turn with it."""
        from mbcdm_cad.parts.bill import MovingBody

        routes, found = self.routes_in(1.0).routes, list[MovingBody]()
        for body in routes.bodies:
            radii = 1.0, 1.0
            if body.kind != "drum":
                on_it = ((w, route.wraps[-1]) for route in routes.cables for w in route.wraps if w.body == body.name)
                own, drum = next(on_it)
                radii = copysign(drum.radius_m, body.turns_per_drum), own.radius_m
            found.append(MovingBody(body.name, body.kind, body.point_m, body.axis, *radii))
            found += (other for each in self.attachments for other in each.moving_bodies(found[-1]))
        return tuple(found)

    def bill(self, drum_angle_deg: float = 0.0) -> Bill:
        """All parts, and all instances of them with the drum at ``drum_angle_deg``.

        The group of each instance is ``"fixed"`` or the name of a moving body.
        """
        found: Bill = self.module("bill").bill(self, drum_angle_deg)
        return found

    @cached_property
    def assembly_order(self) -> tuple[AssemblyStep, ...]:
        """Steps of the assembly: every item of the bill joins in one of them, each screw is accessible in its step."""
        before = (step for each in self.attachments for step in each.steps_before())
        return (*before, *self.own_steps())

    def own_steps(self, **more: Any) -> tuple[AssemblyStep, ...]:
        """Those without its attachments; ``more``: what the template gets besides, or in place of, its figures."""
        found: tuple[AssemblyStep, ...] = self.module("bill").steps_of(self, **more)
        return found

    @cached_property
    def frame_study(self) -> FrameStudy | None:
        """Study of the drum's rotation by the frame's deflection; None if the frame is assumed to be rigid."""
        found: FrameStudy | None = self.module("support.stiffness").frame_study(self)
        return found

    @cached_property
    def frame_compliance(self) -> FrameCompliance | None:
        """Rotation of the drum by the frame's deflection; None if the frame is assumed to be rigid."""
        study = self.frame_study
        return None if study is None else study.compliance()

    @property
    def slips_on_passed(self) -> bool:
        """Whether the design counts the rope's creep on the bodies that cables pass."""
        return False

    @property
    def printed_frame(self) -> bool:
        """Whether the frame is printed, of plastic."""
        return False

    @property
    def frame_material(self) -> Material:
        """Material of the frame, which holds the motors. Raises ``NoFigureError`` where the layout states none."""
        raise NoFigureError(f"{self.name} states no material of its frame")

    @property
    def windup_limit_mrad(self) -> float:
        """Limit of the drum's turn by the frame's deflection at the test torque.

        The design's own; left out, the turn of the cables there, or ``PRINTED_WINDUP`` times that for a printed frame.
        """
        stated = self.drive.limits.frame_windup_max_mrad
        if stated is not None:
            return stated
        cables = self.loads.test_urad_Nm * 1e-3 * self.drive.loads.test_torque_Nm
        return cables * (PRINTED_WINDUP if self.printed_frame else 1.0)

    @property
    def passing_deg(self) -> tuple[float, ...]:
        """Drum angles (deg) between those evenly over the travel at which a part of the drum comes by a fixed one."""
        return ()

    @property
    def softer_ends(self) -> float:
        """Give of a cable with the spring at its end over that of its rope alone, least of all cables; 1 without."""
        return 1.0

    @cached_property
    def losses(self) -> Train:
        """Friction between motors and payload: cables, bearings, gearheads, motors.

        Bearings that have no place, because parts have no geometry, do not count. Raises ``ModelError`` where the
        routes have no free span.
        """
        from mbcdm_cad.model.losses import train_of

        d = self.si
        try:
            bearings = tuple(self.bearing_friction(d))
        except NoFigureError:
            bearings = ()
        return train_of(self.drive, d, bearings)

    @cached_property
    def duty(self) -> Duty:
        """What the drive does all day: that of the design file, or an assumed one."""
        from mbcdm_cad.model.duty import duty_of

        return duty_of(self.drive)

    @cached_property
    def motor_days(self) -> tuple[MotorDay, ...]:
        """Torque and temperatures of each motor over the duty. Raises ``ModelError`` as :attr:`losses` does."""
        from mbcdm_cad.model.duty import motor_days
        from mbcdm_cad.model.heat import motor_heat

        drive = self.drive
        heat, peak = motor_heat(drive.motor), drive.loads.peak_torque_Nm
        return motor_days(self.losses, heat, self.duty, peak, drive.input_names)

    def bearing_friction(self, d: DriveSI) -> Iterable[BearingPair]:
        """The bearings of all bodies, whose friction counts; none where the layout does not say."""
        return ()

    @property
    def smallest_bend_ratio(self) -> float:
        """Smallest D/d of any cable on any pulley."""
        return min(2.0 * radius for *_, radius in self.bends_mm()) / self.drive.cable.diameter_mm

    def groove_ratio(self, body: str) -> float | None:
        """Radius of the groove in which cables lie on a body, over the cable's diameter; None where it is smooth."""
        return None

    @cached_property
    def path_figures(self) -> PathFigures:
        """Figures of the cables' paths over the travel."""
        found: PathFigures = self.module("path_figures").path_figures(self)
        return found

    @cached_property
    def tolerance_stacks(self) -> tuple[StackUp, ...]:
        """Tolerance stacks of each gap and ratio; may be empty."""
        return tuple(self.module("checks").stacks(self))

    @cached_property
    def tensioning(self) -> TensioningPlan | None:
        """Plan for setting the preloads: cut lengths, nut turns, pitch of the spans, order; None if there is none."""
        found: TensioningPlan | None = self.module("path_figures").plan(self)
        return found

    # What its checks read.

    @property
    @abstractmethod
    def variables(self) -> Mapping[str, DesignVariable]:
        """Design variables that a remedy may change, by name."""

    @abstractmethod
    def wraps_rad(self, drum_angle_rad: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(input, drum) wraps of each cable at a drum angle, never below zero, shape (n_cables,)."""

    @cached_property
    def wraps_at_ends_rad(self) -> tuple[Mapping[str, NDArray[np.float64]], ...]:
        """Wraps of each cable at both ends of the travel, as ``DriveSI`` names them; none without terminals' places.

        A cable that runs on round its input has no anchor there: only its wraps on the drum end.
        """
        try:
            ends = [self.wraps_rad(angle) for angle in (self.half_travel_rad, -self.half_travel_rad)]
        except NoFigureError:
            return ()
        if self.si.through_wrap_rad is not None:
            return tuple({"drum_wrap_rad": on_drum} for _, on_drum in ends)
        return tuple({"input_wrap_rad": on_input, "drum_wrap_rad": on_drum} for on_input, on_drum in ends)

    @abstractmethod
    def bends_mm(self) -> Sequence[tuple[str, str, float]]:
        """(cable, pulley, pitch radius in mm) of every pulley that a cable is bent on."""

    def once(self, name: str, make: Callable[[Self], _T]) -> _T:
        """``make(self)``, computed at the first call for this ``name`` and kept for the other checks that need it."""
        if name not in self._kept:
            self._kept[name] = make(self)
        kept: _T = self._kept[name]
        return kept

    @cached_property
    def loads(self) -> CableTensions:
        """Tensions by the model."""
        from mbcdm_cad.model.equilibrium import CableTensions
        from mbcdm_cad.model.si import ModelError

        drive = self.drive
        carried = sum(c.preload_N * c.drum_radius_mm for c in drive.cables) * 1e-3
        largest = max(drive.loads.peak_torque_Nm, drive.loads.test_torque_Nm)
        if largest > OVERLOAD * carried:
            raise NoFigureError(
                f"the load of {largest:.4g} N m is more than {OVERLOAD:g} times what the preload can carry "
                f"({carried:.4g} N m): cables go slack far below it; raise rope.preload_N or lower the load"
            )
        try:
            si = self.as_set(self.si)
            if self.before is not None and self.before.loads.are_those_of(drive, si):
                return self.before.loads
            return CableTensions(drive, si)
        except ModelError as error:
            raise NoFigureError(f"the model has no answer: {error}") from None

    def as_set(self, si: DriveSI) -> DriveSI:
        """``si`` with the least favourable preloads that tightening leaves, which :attr:`loads` has."""
        return si

    @property
    def has_loads(self) -> bool:
        """Whether they are worked out."""
        return "loads" in self.__dict__

    @property
    def half_travel_rad(self) -> float:
        """Travel each way."""
        return radians(self.drive.half_travel_deg)

    @property
    def flank_mm(self) -> float:
        """Half the cable's diameter."""
        return self.drive.cable.diameter_mm / 2


class Attachment:
    """An option that a design file may have or leave out, with all that it adds to a drive.

    A layout names the kinds that it ``takes``, and asks those that a design has at fixed places; it knows none of them.
    What a kind does not override it does not add.
    """

    # The drive's field that is None in a design without it.
    block: ClassVar[str]

    def __init__(self, layout: Any) -> None:
        self.layout = layout

    @property
    def unit(self) -> Layout | None:
        """The drive that it is, as a design of its own."""
        return None

    @property
    def checks(self) -> Iterable[Check]:
        """Checks besides those of the layout, run after them."""
        return ()

    @property
    def passing_deg(self) -> Iterable[float]:
        """Drum angles (deg) at which a part of it comes by another."""
        return ()

    def moving_bodies(self, body: MovingBody) -> Iterable[MovingBody]:
        """Its bodies that turn with one of the routes."""
        return ()

    def add_on_input(self, b: BillBuilder, name: str, turn: Placement) -> None:
        """Adds to the bill what turns with an input, or turns it; ``turn``: of that input about the drum's axis."""

    def add_at_input(self, b: BillBuilder, turn: Placement, mark: str) -> None:
        """Adds to the bill what stands at an input, its names with ``mark``; ``turn``: as above."""

    def bearings(self, d: DriveSI) -> Iterable[BearingPair]:
        """Its bearings, whose friction counts."""
        return ()

    def structure(self, unit_tension_N: NDArray[np.float64]) -> Iterable[Cause]:
        """Causes of the drum's turn in it, for the tensions of 1 N m on the drum."""
        return ()

    def add_items(self, b: BillBuilder, drum_angle_deg: float) -> None:
        """Adds its parts to the bill."""

    def cable_paths(self, drum_angle_rad: float) -> Iterable[CablePath]:
        """Centre lines of its own cables."""
        return ()

    def steps_before(self) -> Iterable[AssemblyStep]:
        """Steps of assembly before those of the layout."""
        return ()
