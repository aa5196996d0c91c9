"""A miso_spur drive: several inputs of siso_spur round one drum, each of which is a drive of that layout.

The sectors of all inputs are on one shaft, hub on hub, so that sectors and cables lie side by side along the axis. Seen
with its input above the drum, each sector is that of siso_spur.
"""

from dataclasses import dataclass
from math import tau

from mbcdm_cad.layouts.siso_spur.drive import SpurDrive


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

    @property
    def sector_names(self) -> tuple[str, ...]:
        """See the base class; here those of the inputs."""
        return self.input_names

    @property
    def unit_frame_angle_rad(self) -> float:
        """See the base class."""
        return tau / self.n_inputs
