"""A miso_spur drive: several inputs of siso_spur round one drum, each of which is a drive of that layout.

The sectors of all inputs are on one shaft, hub on hub, so that sectors and cables lie side by side along the axis. Seen
with its input above the drum, each sector is that of siso_spur.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property
from math import tau

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive
from mbcdm_cad.layouts.siso_spur.stack import boss_front_y_mm

_FIELDS = tuple(field.name for field in fields(SpurDrive))


@dataclass(frozen=True)
class RoundDrumDrive(SpurDrive):
    """A drive with inputs evenly round its drum. Cables are in the order of the inputs, two sides each."""

    @property
    def n_inputs(self) -> int:
        """Number of inputs."""
        return len(self.input_names)

    @property
    def angles_rad(self) -> tuple[float, ...]:
        """Angles of the inputs about Y, from +Z towards +X."""
        return tuple(tau * k / self.n_inputs for k in range(self.n_inputs))

    @cached_property
    def pitch_mm(self) -> float:
        """Distance between sectors along the axis, hub on hub."""
        return self.drum.hub_face_y_mm - boss_front_y_mm(self)

    @property
    def levels_mm(self) -> tuple[float, ...]:
        """Distance of each input's cable and sector from those of the first along the axis."""
        return tuple(k * self.pitch_mm for k in range(self.n_inputs))

    @cached_property
    def _units(self) -> dict[int, SpurDrive]:
        return {}

    def unit(self, index: int) -> SpurDrive:
        """The input with this index, its cable and its sector as a separate drive, the input above the drum."""
        if index not in self._units:
            self._units[index] = self._made_unit(index)
        return self._units[index]

    def _made_unit(self, index: int) -> SpurDrive:
        own = {name: getattr(self, name) for name in _FIELDS}
        places = [j for j, cable in enumerate(self.cables) if cable.input_name == self.input_names[index]]
        cables = [self.cables[j] for j in places]
        level = index * self.pitch_mm
        return SpurDrive(
            **own
            | {
                "configuration": "siso_spur",
                "input_names": (self.input_names[index],),
                "cables": tuple(replace(c, terminal_y_mm=level + c.outward * self.terminal_mm) for c in cables),
                "sigmas": self.sigmas.of_cables(places),
                "level_mm": level,
                "frame_angle_rad": tau / self.n_inputs,
            }
        )


def round_drum(drive: Drive) -> RoundDrumDrive:
    """``drive`` as one of this configuration. Raises ``TypeError`` for a drive of another."""
    if not isinstance(drive, RoundDrumDrive):
        raise TypeError(f"{drive.name}: a drive of configuration {drive.configuration}, not of miso_spur")
    return drive
