"""The resolved design: every catalogue reference looked up, every radius known, every optional field filled.

The YAML file is validated by :mod:`mbcdm_cad.design.loader`; what the other rooms read is the ``Drive`` below.
Units are those of the file: mm, degrees, N, grams, GPa. The model converts to SI in one place of its own.
"""

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self, TypeVar

from mbcdm_cad.design import bought
from mbcdm_cad.design.blocks import AsBuilt, Export, Limits, Loads, Making, Printing, Targets, Waiver
from mbcdm_cad.design.stage import Stage

_T = TypeVar("_T")


@dataclass(frozen=True)
class CableRun:
    """One cable of the drive and its pitch radii at both ends (to the cable's centre line)."""

    name: str
    input_name: str
    input_radius_mm: float
    drum_radius_mm: float
    preload_N: float


@dataclass(frozen=True, kw_only=True)
class Sigmas:
    """Standard deviations of the values that were given with one, 0 for the others; tuples are by cable."""

    preload_N: tuple[float, ...]
    friction_coefficient: float
    modulus_GPa: float
    area_mm2: float  # of the area that the modulus refers to
    test_torque_Nm: float
    motor_torque_mNm: float
    # Of the layout's own lengths, by the length's name. A dict has no hash.
    lengths_mm: Mapping[str, float | tuple[float, ...]] = field(default_factory=dict, hash=False)

    def of_cables(self, places: Sequence[int]) -> "Sigmas":
        """The same with the cables at these places alone."""

        def of(size: float | tuple[float, ...]) -> Any:
            return tuple(size[k] for k in places) if isinstance(size, tuple) else size

        lengths = {name: of(size) for name, size in self.lengths_mm.items()}
        return replace(self, preload_N=of(self.preload_N), lengths_mm=lengths)


@dataclass(frozen=True)
class Drive:
    """All values of a design that every configuration has; a configuration adds its own fields in a subclass.

    ``as_built`` has the effects found on the built drive that change no value; a modulus, preload or friction that was
    found is already in the values (:mod:`mbcdm_cad.design.resolve`).

    ``screws``, ``materials``, ``inserts`` and ``terminations`` hold the whole catalogue with the design's own entries:
    parts choose screws by name, bought parts name their material, and a remedy names the terminations that fit.
    """

    name: str
    configuration: str
    cables: tuple[CableRun, ...]
    input_names: tuple[str, ...]
    half_travel_deg: float
    travel_from_deg: float | None  # angle of the output at the lower end; None: the output's zero is the middle
    stop_clearance_deg: float
    cable: bought.CableSpec
    terminations: tuple[bought.TerminationSpec, ...]
    termination: bought.TerminationSpec
    friction_coefficient: float
    helix_lead_mm: float
    dead_turns: float
    cut_tolerance_mm: float
    motor: bought.Motor
    gearhead: bought.Gearhead  # the motor's own face where there is none
    gearhead_angle_deg: float  # how far gearheads and motors are turned about their axes
    bus_voltage_V: float | None  # None where neither file nor catalogue has one
    encoder: bought.Encoder
    drum_encoder: bought.Encoder
    loads: Loads
    limits: Limits
    making: Making
    printing: Printing
    targets: Targets
    export: Export
    waivers: tuple[Waiver, ...]
    screws: tuple[bought.Screw, ...]
    materials: tuple[bought.Material, ...]
    inserts: tuple[bought.InsertSpec, ...]
    sigmas: Sigmas
    as_built: tuple[AsBuilt, ...]
    stage: Stage | None  # between the gearhead, or the motor, and each input

    def once(self, name: str, make: Callable[[Self], _T]) -> _T:
        """``make(self)``, computed at the first call for this ``name`` and kept with the drive."""
        kept: dict[str, Any] = self.__dict__.setdefault("_kept", {})
        if name not in kept:
            kept[name] = make(self)
        found: _T = kept[name]
        return found

    @property
    def ends_per_run(self) -> int:
        """Ends of rope of each of ``cables``: its terminal and its stop; one of a side of a cable through an input."""
        return 2

    @property
    def anchor_m_N(self) -> float:
        """How far the end of a cable on the drum gives way for each newton there; 0 for an end that is held."""
        return 0.0

    @property
    def setting_mm(self) -> float:
        """Rope that the ends of each of ``cables`` give off at their first loads."""
        return self.ends_per_run * self.termination.setting_ratio * self.cable.diameter_mm

    @property
    def middle_deg(self) -> float:
        """Angle of the output in the middle of the travel, from which all angles of the drum are counted."""
        return 0.0 if self.travel_from_deg is None else self.travel_from_deg + self.half_travel_deg

    @property
    def travel_words(self) -> str:
        """The travel as the file asks for it: both ways alike, or from an angle of the output to another."""
        if self.travel_from_deg is None:
            return f"+-{self.half_travel_deg:g}"
        return f"{self.travel_from_deg:+g} to {self.travel_from_deg + 2 * self.half_travel_deg:+g}"

    @property
    def mounted(self) -> str:
        """The body that is screwed on for each input, in words: its gearhead, or the motor without one."""
        if self.servo is not None:
            return "servo"
        if self.cable_stage is not None:
            return "first stage"
        return "motor" if self.gearhead.absent else "gearhead"

    @property
    def mounted_stem(self) -> str:
        """The same as the beginning of names of items."""
        return self.mounted.replace(" ", "_")

    @property
    def cable_stage(self) -> bought.CableStageOutput | None:
        """The first cable stage that turns the input; None for a drive of one stage."""
        return self.gearhead if isinstance(self.gearhead, bought.CableStageOutput) else None

    @cached_property
    def reduction(self) -> bought.Gearhead:
        """Gearhead and stage together, as one gearhead whose output is the input; the gearhead itself without a stage.

        Only its torques, ratio and efficiency count so: face and shaft are those of the gearhead.
        """
        stage, gear = self.stage, self.gearhead
        if stage is None:
            return gear
        passed = stage.ratio * stage.efficiency
        return replace(
            gear,
            ratio=gear.ratio * stage.ratio,
            efficiency=gear.efficiency * stage.efficiency,
            rated_torque_mNm=gear.rated_torque_mNm * passed,
            max_torque_mNm=gear.max_torque_mNm * passed,
        )

    @property
    def motor_turns(self) -> float:
        """Turns of a motor for one of its input, below zero where gears or crossed cables turn it the other way."""
        sense = -1 if self.cable_stage is not None else 1 if self.stage is None else self.stage.sense
        return self.reduction.ratio * sense

    @property
    def servo(self) -> bought.Servo | None:
        """What the motor has as a bought servo; None for a plain motor."""
        return self.gearhead.servo if isinstance(self.gearhead, bought.ServoOutput) else None

    @property
    def rotor_at_input_kg_m2(self) -> float:
        """Inertia of one rotor, reflected through gearhead and stage to its input pulley."""
        return self.motor.rotor_inertia_g_cm2 * 1e-7 * self.reduction.ratio**2

    @property
    def face_depth_mm(self) -> float:
        """Length of the body behind the face that is screwed on: the gearhead's, or the motor's without one."""
        return self.motor.length_mm if self.gearhead.absent else self.gearhead.length_mm

    def screw(self, name: str) -> bought.Screw:
        """The screw of the catalogue called ``name``; KeyError if there is none."""
        return self._screws_by_name.get(name) or _named(self.screws, name, "screw")

    @cached_property
    def _screws_by_name(self) -> dict[str, bought.Screw]:
        # The dimensions of one drive look screws up a hundred times, in a catalogue of dozens.
        return {screw.name: screw for screw in self.screws}

    def material(self, name: str) -> bought.Material:
        """The material of the catalogue called ``name``; KeyError if there is none."""
        return _named(self.materials, name, "material")

    def insert(self, material: bought.Material, thread_mm: float) -> bought.InsertSpec | None:
        """The insert that a thread gets in a part of ``material``.

        None if the thread is cut in the part itself: the part is not printed, the design uses no inserts, or none has
        this size.
        """
        if self.printing.threads != "inserts" or not material.printed:
            return None
        return bought.shortest_insert(self.inserts, thread_mm)

    def waiver(self, check: str) -> Waiver | None:
        """The waiver for the check with this id, if the design holds one."""
        return next((waiver for waiver in self.waivers if waiver.check == check), None)


_Entry = TypeVar("_Entry", bound=bought.Entry)


def _named(entries: tuple[_Entry, ...], name: str, kind: str) -> _Entry:
    for entry in entries:
        if entry.name == name:
            return entry
    raise KeyError(f"no {kind} {name!r} in the catalogue; it holds {', '.join(entry.name for entry in entries)}")


# The last designs that were met, whose layouts are worked out.
_MET: deque[Drive] = deque(maxlen=4)
AnyDrive = TypeVar("AnyDrive", bound=Drive)


def met(drive: AnyDrive) -> AnyDrive:
    """The equal drive that was met before, with what its layout has worked out; else the drive itself.

    The sizing rules work out frame and loads of a design to test them, and the checks need the same again.
    """
    for known in _MET:
        if type(known) is type(drive) and known == drive:
            return known
    _MET.append(drive)
    return drive
