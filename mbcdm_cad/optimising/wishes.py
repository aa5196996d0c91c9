"""What a search for the best design shall reach, the fields that it may set, and how long it may take."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from mbcdm_cad.errors import MbcdmError

SENSES = ("min", "max")
MOST_AIMS = 4
# Growth of the front's hypervolume in the last rounds, as a share, below which a search ends.
GROWTH = 0.005


@dataclass(frozen=True)
class Aim:
    """One figure to make as small (``min``) or as large (``max``) as possible."""

    figure: str
    sense: str

    def less(self, value: float) -> float:
        """The figure such that less is better."""
        return value if self.sense == "min" else -value

    def __str__(self) -> str:
        """As the command line takes it."""
        return f"{self.figure}:{self.sense}"


@dataclass(frozen=True)
class Keep:
    """One figure that must be at least (``sense`` +1) or at most (-1) a limit."""

    figure: str
    sense: int
    limit: float

    def margin(self, value: float) -> float:
        """Distance from the limit in the figure's unit, positive inside."""
        return self.sense * (value - self.limit)

    def __str__(self) -> str:
        """As the command line takes it."""
        return f"{self.figure}:{'>=' if self.sense > 0 else '<='}{self.limit:g}"


@dataclass(frozen=True)
class Freed:
    """A field that a search may set: to one of ``values``, or to a number from ``low`` to ``high``."""

    field: str
    values: tuple[Any, ...] = ()
    low: float = 0.0
    high: float = 0.0


@dataclass(frozen=True)
class Wishes:
    """All of a search: 1 to 4 ``aims``, ``keeps``, and ``free`` fields.

    ``only_free``: fields that the file leaves to their rules follow these rules and are not free.
    """

    aims: tuple[Aim, ...]
    keeps: tuple[Keep, ...] = ()
    free: tuple[Freed, ...] = ()
    only_free: bool = False


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


def wishes_of(
    aims: Sequence[str], keeps: Sequence[str] = (), free: Sequence[str] = (), *, only_free: bool = False
) -> Wishes:
    """Wishes from their texts.

    Such as ``mass_g:min``, ``torque_Nm:>=3``, ``drum.material=pa12,pla`` or ``rope.preload_N=30..90``. Raises
    ``MbcdmError`` for a text that is none, for no aim, more than four, or one figure twice.
    """
    found = tuple(_aim(text) for text in aims)
    if not 1 <= len(found) <= MOST_AIMS:
        raise MbcdmError(f"--aim: {len(found)} given (limit 1 to {MOST_AIMS}); for example --aim mass_g:min")
    names = [aim.figure for aim in found]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise MbcdmError(f"--aim: {twice} is given twice; give each figure one aim")
    return Wishes(found, tuple(_keep(text) for text in keeps), tuple(_freed(text) for text in free), only_free)


def over_tolerances(wishes: Sequence[str]) -> tuple[str, ...]:
    """Texts of aims or keeps with the value that 95 % of the drives reach in place of each figure that has one.

    ``swing_mrad:min`` becomes ``swing_mrad_p95:min``, ``torque_Nm:>=2`` becomes ``torque_Nm_p5:>=2``; see
    :mod:`mbcdm_cad.optimising.spread`.
    """
    from mbcdm_cad.optimising.spread import SPREAD

    found = []
    for text in wishes:
        figure, colon, rest = text.partition(":")
        worse = "_p95" if rest.strip().startswith(("min", "<")) else "_p5"
        found.append(f"{figure}{worse if figure.strip() in SPREAD else ''}{colon}{rest}")
    return tuple(found)


def _aim(text: str) -> Aim:
    figure, _, sense = text.partition(":")
    if sense not in SENSES or not figure:
        raise MbcdmError(f"--aim: not an aim (value {text}, limit FIGURE:min or FIGURE:max); write mass_g:min, say")
    return Aim(figure, sense)


def _keep(text: str) -> Keep:
    found = re.fullmatch(r"([^:]+):(>=|<=)(.+)", text.replace(" ", ""))
    try:
        if found is not None:
            return Keep(found[1], 1 if found[2] == ">=" else -1, float(found[3]))
    except ValueError:
        pass
    raise MbcdmError(
        f"--keep: not a figure with a limit (value {text}, limit FIGURE:>=NUMBER or FIGURE:<=NUMBER); write "
        "torque_to_weight_Nm_kg:>=9, say"
    )


def _freed(text: str) -> Freed:
    field, _, given = text.partition("=")
    span = re.fullmatch(r"(\S+)\.\.(\S+)", given)
    if span is not None:
        try:
            low, high = float(span[1]), float(span[2])
        except ValueError:
            low = high = 0.0
        if low < high:
            return Freed(field, (), low, high)
    elif field and given:
        import yaml  # the package's own import brings this file, and should be fast

        return Freed(field, tuple(yaml.safe_load(value) for value in given.split(",")))
    raise MbcdmError(
        f"--free: not a field with values (value {text}, limit FIELD=A,B,... or FIELD=LOW..HIGH); write "
        "drum.material=aluminium-7075,pa12, say"
    )
