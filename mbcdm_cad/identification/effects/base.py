"""What an effect is to the loop: a name of the vocabulary, one physical form of it, and how it changes a run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mbcdm_cad.identification.prepared import Prepared
from mbcdm_cad.identification.setup import Setup, Simulator
from mbcdm_cad.measurement.run import Floats
from mbcdm_cad.model.si import DriveSI

Starts = Callable[[Setup, Floats], list[list[float]]]


@dataclass(frozen=True)
class Parameter:
    """One figure that the fit turns: its name with unit, a typical small size, and bounds."""

    name: str
    size: float
    low: float = -np.inf
    high: float = np.inf


@dataclass(frozen=True)
class Figure:
    """One figure as it is reported: a function of the fitted values, whose interval follows by linear propagation."""

    name: str
    of: Callable[[Floats], float]


@dataclass(frozen=True, eq=False)
class Effect:
    """One form of an effect.

    ``apply`` changes the setup of a run; ``starts`` gives first guesses from the residual (rad, all samples), by
    default one at zero. ``figures`` are what is reported, ``physical`` what it means in metal; both default to the
    parameters themselves. ``cables`` are names.
    """

    name: str
    form: str
    physics: str
    where_to_look: str
    separate_by: str
    parameters: tuple[Parameter, ...]
    apply: Callable[[Setup, Floats, Simulator], Setup]
    stage: str | None = None
    cables: tuple[str, ...] = ()
    starts: Starts | None = None
    figures: tuple[Figure, ...] = ()
    physical: tuple[Figure, ...] = ()

    @property
    def key(self) -> tuple[str, str | None, tuple[str, ...]]:
        """What it is called in a result; forms of one key are one name."""
        return self.name, self.stage, self.cables

    @property
    def label(self) -> str:
        """For people: name, stage, cables, form."""
        words = [self.name, self.stage or "", *(self.cables if len(self.cables) == 1 else ())]
        return " ".join(filter(None, words)) + f" ({self.form})"

    def first_guesses(self, setup: Setup, residual: Floats) -> list[list[float]]:
        """Values to begin with."""
        return self.starts(setup, residual) if self.starts else [[0.0] * len(self.parameters)]

    def reported(self) -> tuple[Figure, ...]:
        """Figures of the result file."""
        return self.figures or tuple(
            Figure(p.name, lambda v, k=k: float(v[k]))  # type: ignore[misc]
            for k, p in enumerate(self.parameters)
        )


# What a file of this folder offers: the effects that make sense for a drive (None: only the ratio is known) and a run.
Offer = Callable[[DriveSI | None, Prepared], list[Effect]]


def sign_of_speed(setup: Setup) -> Floats:
    """Sense of motion, -1 to 1, rounded where the drive all but stands."""
    speed = setup.p.speed_rad_s
    return np.asarray(np.tanh(speed / (0.02 * np.sqrt(np.mean(speed**2)))))


def elapsed_s(setup: Setup) -> Floats:
    """Time since the run began."""
    return np.asarray(setup.p.time_s - setup.p.time_s[0])
