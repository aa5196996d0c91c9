"""Cable tensions and input torques of a design in the states that its strength checks use."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.model.equilibrium import BearingLoads, bearing_loads, solve_equilibrium
from mbcdm_cad.model.si import DriveSI


class CableTensions:
    """Cable tensions (N), shape (n_cables,), in the states that the strength checks use."""

    def __init__(self, drive: Drive, si: DriveSI) -> None:
        peak, test = drive.loads.peak_torque_Nm, drive.loads.test_torque_Nm
        self.si, self._loads = si, drive.loads
        self.torques_Nm = np.array([0.0, peak, -peak, test, -test])
        self.equilibrium = solve_equilibrium(si, self.torques_Nm)
        tension = self.equilibrium.tension_N
        self.idle, self.peak_forward, self.peak_back, self.test_forward, self.test_back = tension.T
        self.input_torque_Nm = self.equilibrium.input_torque_Nm(si).T  # (state, input), states as above

    def are_those_of(self, drive: Drive, si: DriveSI) -> bool:
        """Whether another drive has the same, because nothing differs that they follow from."""
        return self._loads == drive.loads and self.si.is_same(si)

    @property
    def test_urad_Nm(self) -> float:
        """Turn of the drum by its cables at the test torque, over that torque, urad per N m."""
        idle, test = self.equilibrium.drum_angle_rad[[0, 3]]
        return abs(float(test - idle)) / self._loads.test_torque_Nm * 1e6

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
