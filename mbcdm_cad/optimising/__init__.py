"""The best designs for two or more wishes: free fields, figures, a search that can be interrupted, the front.

``pymoo`` proposes points, this package sizes and checks them and keeps each in a file. A search that goes on repeats
the proposals from the start and takes the results from this file, so that it ends with the same bytes.
"""

from dataclasses import dataclass

from mbcdm_cad.errors import MbcdmError

# Growth of the front's hypervolume in the last rounds, as a share, below which a search ends.
GROWTH = 0.005


@dataclass(frozen=True)
class Effort:
    """When a search ends at the latest (number of points, time), on how many processes (None: all cores).

    ``resume``: go on with a search that was stopped; ``scheduler``: the address of a dask scheduler whose workers
    evaluate the points in place of processes of this machine; ``growth``: the search ends earlier if the front's
    hypervolume grew by less than this share in its last generations, with 0 it does not.
    """

    evaluations: int | None = None
    time_s: float | None = None
    workers: int | None = None
    resume: bool = False
    scheduler: str | None = None
    growth: float = GROWTH

    def __post_init__(self) -> None:
        """Raise ``MbcdmError`` for a limit that is none."""
        for name in ("evaluations", "workers"):
            value = getattr(self, name)
            if value is not None and value < 1:
                raise MbcdmError(f"--{name}: not a number (value {value}, limit at least 1)")
        if self.workers is not None and self.scheduler is not None:
            raise MbcdmError("--workers: processes of this machine, and --scheduler: those of others; give one of them")
        if self.time_s is not None and not self.time_s > 0.0:
            raise MbcdmError(f"--time: not a time (value {self.time_s:g} s, limit above 0)")
        if not 0.0 <= self.growth < 1.0:
            raise MbcdmError(f"--growth: not a share (value {self.growth:g}, limit 0 to 1); write 0.005, say")
