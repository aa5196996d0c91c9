"""The design under test, with results that are computed once and used by many checks."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from math import radians
from typing import Any, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.checks.design_variables import DesignVariable
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.model.equilibrium import BearingLoads, bearing_loads, solve_equilibrium
from mbcdm_cad.model.si import DriveSI, ModelError, to_si

_Kept = TypeVar("_Kept")
# The model is not evaluated above this multiple of sum(T_pre r_o), at which cables without friction go slack.
OVERLOAD = 4.0


class NoFigureError(Exception):
    """Raised for a figure that does not exist for this design; the text gives the reason and ends a sentence."""


class CableTensions:
    """Cable tensions (N), shape (n_cables,), in the states that the strength checks use."""

    def __init__(self, drive: Drive, si: DriveSI) -> None:
        peak, test = drive.loads.peak_torque_Nm, drive.loads.test_torque_Nm
        self.si, self._loads = si, drive.loads
        torques = np.array([0.0, peak, -peak, test, -test])
        self.equilibrium = solve_equilibrium(si, torques)
        tension = self.equilibrium.tension_N
        self.idle, self.peak_forward, self.peak_back, self.test_forward, self.test_back = tension.T
        self.input_torque_Nm = self.equilibrium.input_torque_Nm(si).T  # (state, input), states as above

    def are_those_of(self, drive: Drive, si: DriveSI) -> bool:
        """Whether another drive has the same, because nothing differs that they follow from."""
        return self._loads == drive.loads and self.si.is_same(si)

    @property
    def states(self) -> tuple[tuple[str, NDArray[np.float64]], ...]:
        """Unloaded and at peak torque both ways."""
        return (("no load", self.idle), ("+peak torque", self.peak_forward), ("-peak torque", self.peak_back))

    @cached_property
    def on_bodies(self) -> tuple[BearingLoads, ...]:
        """Loads of the cables on every body in these states."""
        return tuple(bearing_loads(self.si, tension) for _, tension in self.states)

    @property
    def highest_N(self) -> float:
        """Largest tension of any cable in these states."""
        return float(max(tension.max() for _, tension in self.states))

    @property
    def highest_input_Nm(self) -> float:
        """Largest torque on an input pulley in these states."""
        return float(np.abs(self.input_torque_Nm[:3]).max())


class DesignUnderTest(ABC):
    """A drive with its layout and loads, each computed on first use. Each configuration has its own subclass.

    Every property raises :class:`NoFigureError` if the figure does not exist for this design.
    """

    def __init__(self, drive: Drive, layout: Any = None) -> None:
        """``layout``: the dimensions to test instead of those that follow from ``drive``."""
        self.drive = drive
        self._given = layout
        self._kept: dict[str, Any] = {}
        # A design whose loads are worked out already, and which may have the same.
        self.before: DesignUnderTest | None = None

    @property
    @abstractmethod
    def variables(self) -> Mapping[str, DesignVariable]:
        """Design variables that a remedy may change, by name."""

    @abstractmethod
    def wraps_rad(self, drum_angle_rad: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(input, drum) wraps of each cable at a drum angle, never below zero, shape (n_cables,)."""

    @abstractmethod
    def bends_mm(self) -> Sequence[tuple[str, str, float]]:
        """(cable, pulley, pitch radius in mm) of every pulley that a cable is bent on."""

    def given_or(self, worked_out: Callable[[], _Kept]) -> _Kept:
        """The given dimensions, else those computed from the drive; NoFigureError if these have no solution."""
        if self._given is not None:
            given: _Kept = self._given
            return given
        try:
            return worked_out()
        except (ValueError, ZeroDivisionError) as error:
            raise NoFigureError(f"the dimensions have no solution: {error}") from None

    def with_drive(self, drive: Drive) -> Self:
        """The same tests on another drive."""
        return type(self)(drive)

    def once(self, name: str, make: Callable[[Self], _Kept]) -> _Kept:
        """``make(self)``, computed at the first call for this ``name`` and kept for the other checks that need it."""
        if name not in self._kept:
            self._kept[name] = make(self)
        kept: _Kept = self._kept[name]
        return kept

    @cached_property
    def loads(self) -> CableTensions:
        """Tensions by the model."""
        drive = self.drive
        carried = sum(c.preload_N * c.drum_radius_mm for c in drive.cables) * 1e-3
        largest = max(drive.loads.peak_torque_Nm, drive.loads.test_torque_Nm)
        if largest > OVERLOAD * carried:
            raise NoFigureError(
                f"the load of {largest:.4g} N m is more than {OVERLOAD:g} times what the preload can carry "
                f"({carried:.4g} N m): cables go slack far below it; raise rope.preload_N or lower the load"
            )
        try:
            si = to_si(drive)
            if self.before is not None and self.before.loads.are_those_of(drive, si):
                return self.before.loads
            return CableTensions(drive, si)
        except ModelError as error:
            raise NoFigureError(f"the model has no answer: {error}") from None

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
