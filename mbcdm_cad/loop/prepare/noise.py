"""The noise floor: the part of the residual that does not repeat in the data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mbcdm_cad.loop.prepare.prepared import Prepared

# If the floor is so many times the declared one, the sensor or its data sheet is doubtful.
FAR_ABOVE = 1.5


@dataclass(frozen=True)
class Noise:
    """The part of the residual that does not repeat, rad RMS.

    ``total_rad`` is the floor in use; ``white_rad`` and ``coloured_rad`` its parts (quadratic sum), ``memory_s`` the
    correlation time of the coloured part, ``declared_rad`` the noise from the sensors' declared steps alone, 0 where
    they are not given. ``source`` says how it was found.
    """

    total_rad: float
    white_rad: float
    coloured_rad: float
    memory_s: float
    declared_rad: float
    source: str

    @property
    def far_above(self) -> bool:
        """Whether it is far above the noise that the sensors are declared to have."""
        return 0.0 < self.declared_rad * FAR_ABOVE < self.total_rad

    def to_json(self) -> dict[str, float | str]:
        """For the result file."""
        return {
            "floor_rad": self.total_rad,
            "white_rad": self.white_rad,
            "coloured_rad": self.coloured_rad,
            "memory_s": self.memory_s,
            "declared_rad": self.declared_rad,
            "source": self.source,
        }


def doubt_of(noise: Noise, names: str) -> str:
    """A sentence where the noise is far above what the file declares; ``names`` are the runs."""
    return (
        f"{names}: the sensors are noisier than declared: {1e6 * noise.total_rad:.3g} urad RMS do not repeat, where "
        f"the declared steps make {1e6 * noise.declared_rad:.3g} urad (white {1e6 * noise.white_rad:.3g}, coloured "
        f"{1e6 * noise.coloured_rad:.3g} urad"
        + (f" with a memory of {noise.memory_s:.2g} s" if noise.memory_s else "")
        + "); check mounts, cables and supply of the encoders, or declare their angle noise"
    )


def runs_of(prepared: Sequence[Prepared]) -> str:
    """Names of the runs, for a message."""
    return ", ".join(dict.fromkeys(p.run.source or "run" for p in prepared))
