"""The design under test, with what is worked out from it once and read by many checks."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from math import pi, radians, tau
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.configurations.miso_bevel.cable_path import CablePath
from mbcdm_cad.configurations.miso_bevel.layout import Layout, layout
from mbcdm_cad.configurations.miso_bevel.stack import Stack, stack
from mbcdm_cad.design.drive import CableRun, Drive

if TYPE_CHECKING:
    from mbcdm_cad.model.si import DriveSI

_Kept = TypeVar("_Kept")
# Beyond this multiple of sum(T_pre r_o), at which cables without friction go slack, the model is not asked.
OVERLOAD = 4.0


class NoFigureError(Exception):
    """A figure that does not exist for this design; the text says why and ends a sentence."""


class Loads:
    """Cable tensions (N), shape (n_cables,), in the states that the strength checks look at."""

    def __init__(self, drive: Drive, si: DriveSI) -> None:
        from mbcdm_cad.model.equilibrium import solve_equilibrium

        peak, test = drive.loads.peak_torque_Nm, drive.loads.test_torque_Nm
        self.si = si
        torques = np.array([0.0, peak, -peak, test, -test])
        self.equilibrium = solve_equilibrium(si, torques)
        tension = self.equilibrium.tension_N
        self.idle, self.peak_forward, self.peak_back, self.test_forward, self.test_back = tension.T
        self.input_torque_Nm = self.equilibrium.input_torque_Nm(si).T  # (state, input), states as above

    @property
    def states(self) -> tuple[tuple[str, NDArray[np.float64]], ...]:
        """Unloaded and at peak torque both ways."""
        return (("no load", self.idle), ("+peak torque", self.peak_forward), ("-peak torque", self.peak_back))

    @property
    def highest_N(self) -> float:
        """Largest tension of any cable in these states."""
        return float(max(tension.max() for _, tension in self.states))

    @property
    def highest_input_Nm(self) -> float:
        """Largest torque on an input pulley in these states."""
        return float(np.abs(self.input_torque_Nm[:3]).max())


class Subject:
    """A drive with its levels, layout and loads, each worked out when first asked for.

    Every property raises :class:`NoFigureError` where there is no such thing for this design.
    """

    def __init__(self, drive: Drive, given: Layout | None = None) -> None:
        self.drive = drive
        self._given = given
        self._kept: dict[str, Any] = {}
        self.steps: tuple[CableRun, ...] = tuple(sorted(drive.cables, key=lambda cable: cable.step))

    def once(self, name: str, make: Callable[[Subject], _Kept]) -> _Kept:
        """``make(self)``, worked out at the first call for this ``name`` and kept for the other checks that need it."""
        if name not in self._kept:
            self._kept[name] = make(self)
        kept: _Kept = self._kept[name]
        return kept

    @cached_property
    def levels(self) -> Stack:
        """Heights and depths."""
        if self._given is not None:
            return self._given.levels
        try:
            return stack(self.drive)
        except ValueError as error:
            raise NoFigureError(f"the pulleys have no place: {error}") from None

    @cached_property
    def layout(self) -> Layout:
        """All dimensions: those given, else worked out."""
        if self._given is not None:
            return self._given
        levels = self.levels
        if levels.motor_shelf_bottom_z <= 0.0:
            raise NoFigureError(
                f"the motor shelf comes to z = {levels.motor_shelf_bottom_z:.4g} mm, below the drum's axis (limit 0)"
            )
        try:
            return layout(self.drive)
        except (ValueError, ZeroDivisionError) as error:
            raise NoFigureError(f"the dimensions have no solution: {error}") from None

    @cached_property
    def loads(self) -> Loads:
        """Tensions by the model."""
        from mbcdm_cad.model.errors import ModelError
        from mbcdm_cad.model.si import to_si

        drive = self.drive
        carried = sum(c.preload_N * c.drum_radius_mm for c in drive.cables) * 1e-3
        largest = max(drive.loads.peak_torque_Nm, drive.loads.test_torque_Nm)
        if largest > OVERLOAD * carried:
            raise NoFigureError(
                f"the load of {largest:.4g} N m is more than {OVERLOAD:g} times what the preload can carry "
                f"({carried:.4g} N m): cables go slack far below it; raise rope.preload_N or lower the load"
            )
        try:
            return Loads(drive, to_si(drive))
        except ModelError as error:
            raise NoFigureError(f"the model has no answer: {error}") from None

    @cached_property
    def extreme_paths(self) -> tuple[tuple[float, tuple[CablePath, ...]], ...]:
        """Cable paths at one end of travel, centred, and at the other end, with the drum angles in rad."""
        half = self.half_travel_rad
        return tuple((angle, self.layout.cable_paths(angle)) for angle in (-half, 0.0, half))

    @property
    def half_travel_rad(self) -> float:
        """Travel each way."""
        return radians(self.drive.half_travel_deg)

    @property
    def flank_mm(self) -> float:
        """Half the cable's diameter."""
        return self.drive.cable.diameter_mm / 2

    def anchor_rad(self, cable: CableRun) -> float:
        """Where the cable leaves its land, drum centred."""
        return next(t.anchor_rad for t in self.layout.drum.tensioners if t.cable_name == cable.name)

    def smallest_wrap_rad(self, cable: CableRun) -> float:
        """Wrap on the drum at the end of travel that unwinds it."""
        return self.anchor_rad(cable) - self.half_travel_rad

    def wraps_rad(self, drum_angle_rad: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(input, drum) wraps of each cable at a drum angle, never below zero, shape (n_cables,)."""
        cables = self.drive.cables
        on_drum = [self.anchor_rad(c) + c.drum_side * drum_angle_rad for c in cables]
        on_input = [
            tau * self.drive.dead_turns
            + c.drum_radius_mm / c.input_radius_mm * (self.half_travel_rad - c.drum_side * drum_angle_rad)
            for c in cables
        ]
        return np.maximum(on_input, 0.0), np.clip(on_drum, 0.0, 2 * pi)
