"""How long a search for the best designs may take, and on how many processes."""

from __future__ import annotations

import os
from dataclasses import dataclass

from mbcdm_cad.errors import MbcdmError


@dataclass(frozen=True)
class Effort:
    """When a search ends at the latest (number of points, time), on how many processes (None: all cores).

    ``resume``: go on with a search that was stopped.
    """

    evaluations: int | None = None
    time_s: float | None = None
    workers: int | None = None
    resume: bool = False

    def __post_init__(self) -> None:
        """Raise ``MbcdmError`` for a limit that is none."""
        for name in ("evaluations", "workers"):
            value = getattr(self, name)
            if value is not None and value < 1:
                raise MbcdmError(f"--{name}: not a number (value {value}, limit at least 1)")
        if self.time_s is not None and not self.time_s > 0.0:
            raise MbcdmError(f"--time: not a time (value {self.time_s:g} s, limit above 0)")

    @property
    def processes(self) -> int:
        """Number of processes."""
        return self.workers or len(os.sched_getaffinity(0))
