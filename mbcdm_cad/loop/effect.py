"""The class of an effect: its name, one physical form of it, how it changes a run, and how it is judged.

Everything that the search, the judgement and the report must know of an effect is a field here, so that an effect is
one file of ``effects/``. Shapes that several effects share stand below.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from mbcdm_cad.loop.prepare.prepared import Prepared
from mbcdm_cad.loop.prepare.setup import Setup, Simulator
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.routes import Floats

Starts = Callable[[Setup, Floats], list[list[float]]]
# Strength 1 is friction and wraps as declared; far above it the friction coefficient itself is wrong.
MOST_STRENGTH = 1.5


@dataclass(frozen=True)
class Words:
    """What an effect is, where to look for it, and the sentence for a person; as the fields of :class:`Effect`."""

    physics: str
    where_to_look: str
    plain: str


@dataclass(frozen=True)
class Parameter:
    """One figure that the fit varies: its name with unit, a typical small size, and bounds.

    ``role``: "size" says how large the effect is, and only sizes are tested against zero; "place" says where it lies (a
    time, a time constant), "order" is the cycles a turn of the output of a line in the spectrum. ``default`` is its
    value where an as-built file does not give it.
    """

    name: str
    size: float
    low: float = -np.inf
    high: float = np.inf
    role: Literal["size", "place", "order"] = "size"
    default: float | None = None


@dataclass(frozen=True)
class Figure:
    """One figure as it is reported: a function of the fitted values, whose interval follows by linear propagation.

    ``meaning`` says, for the page, what the figure means on the bench where its name does not.
    """

    name: str
    of: Callable[[Floats], float]
    meaning: str = ""


@dataclass(frozen=True, eq=False)
class Effect:
    """One form of an effect.

    ``apply`` changes the setup of a run; ``starts`` gives first guesses from the residual (rad, all samples), by
    default one at zero. ``figures`` are what is reported, ``physical`` what they mean as hardware; both default to the
    parameters themselves. ``cables`` are the names of the cables concerned.

    ``run``: the number of the only run that has it, None for all runs. ``several``: there may be more than one in a
    run. ``once``: it happened once, at a time that the search, which may have seen only a part of the run, need not
    know. ``doubtful`` checks fitted values: where no such part can exist it returns a sentence that says what to look
    for instead, otherwise an empty text. ``hangs_on`` is the quantity on which the effect depends, other than angle,
    direction and load: no correction table can represent it. ``last``: a shape rather than a cause, which is less
    likely. ``inside``: a form that moves the cables, where the other forms of its name only add to the reading; it is
    tried in place of one of them. ``saturates``: beyond some size a larger one changes nothing, so that the data may
    only give a lower bound. ``unmeasured``: the influence of a quantity that this run did not measure; it is fitted and
    never named. ``plain`` describes the effect in a sentence for a person who does not know these names: figures in
    braces, ``{way_...}`` for "higher" or "lower", ``{stage}`` and ``{cables}``. ``reversed_words`` describe it where
    its first figure is negative, if that is something else. ``base`` is the effect of which a change during the run is
    one; ``later`` applies it to the runs after its own. ``richer``: all forms of an effect that is a sum of terms.
    ``shapes``: the same effect with other shapes of its law, none of which the search tries: its figures are not known
    better.
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
    run: int | None = None
    starts: Starts | None = None
    figures: tuple[Figure, ...] = ()
    physical: tuple[Figure, ...] = ()
    several: bool = False
    once: bool = False
    doubtful: Callable[[Floats], str] | None = None
    hangs_on: str = ""
    last: bool = False
    inside: bool = False
    saturates: bool = False
    unmeasured: bool = False
    plain: str = ""
    reversed_words: Words | None = None
    base: "Effect | None" = None
    later: Callable[[Setup, Floats, Simulator], Setup] | None = None
    richer: "Callable[[], list[Effect]] | None" = None
    shapes: "Callable[[], list[Effect]] | None" = None

    @property
    def words(self) -> Words:
        """What it is called where its first figure is not negative."""
        return Words(self.physics, self.where_to_look, self.plain)

    def words_of(self, values: Floats) -> Words:
        """What it is called with these values."""
        return self.reversed_words if self.reversed_words and values[0] < 0.0 else self.words

    @property
    def key(self) -> tuple[str, str | None, tuple[str, ...], int | None]:
        """Its name, stage, cables and run in a result; forms with the same key have the same name."""
        return self.name, self.stage, self.cables, self.run

    @property
    def label(self) -> str:
        """Text for results: name, stage, cables, form."""
        words = [self.name, self.stage or "", *(self.cables if len(self.cables) == 1 else ())]
        words += [] if self.run is None else [f"in run {self.run + 1}"]
        return " ".join(filter(None, words)) + f" ({self.form})"

    @property
    def order_index(self) -> int | None:
        """Index of the parameter that is the order of a line; None if the effect is not a line."""
        return next((k for k, p in enumerate(self.parameters) if p.role == "order"), None)

    def first_guesses(self, setup: Setup, residual: Floats) -> list[list[float]]:
        """Values from which the fit starts."""
        return self.starts(setup, residual) if self.starts else [[0.0] * len(self.parameters)]

    def reported(self) -> tuple[Figure, ...]:
        """Figures of the result file."""
        return self.figures or tuple(
            Figure(p.name, lambda v, k=k: float(v[k]))  # type: ignore[misc]
            for k, p in enumerate(self.parameters)
        )


# Type of ``offer``: the effects that are possible for a drive (None: only the ratio is known) and a run.
Effects = Iterator[Effect]
Offer = Callable[[DriveSI | None, Prepared], Effects]


def elapsed_s(setup: Setup) -> Floats:
    """Time since the run began."""
    return np.asarray(setup.p.time_s - setup.p.time_s[0])


def best_step(at: Floats, residual: Floats, shape: Floats | None = None) -> float:
    """Place along ``at``, which ascends, from which a shape (n,), or 1, explains the residual best, beside a constant
    and the shape throughout; not at its ends."""
    one = np.ones_like(at)
    shape, known = (one, [one]) if shape is None else (shape, [one, shape])
    basis = np.linalg.qr(np.column_stack(known))[0]
    # Sums from each sample to the end.
    rows = np.column_stack([shape * (residual - basis @ (basis.T @ residual)), shape**2, basis * shape[:, None]])
    along, square, *others = np.cumsum(rows[::-1], axis=0)[::-1].T
    left = square - np.sum(np.square(others), axis=0)
    edge = max(1, at.size // 25)
    inside = slice(edge, -edge)
    return float(at[inside][int(np.argmax(along[inside] ** 2 / np.maximum(left[inside], 1e-9 * square[0])))])


def wave(values: Floats, angle_rad: Floats) -> tuple[Floats, Floats]:
    """(x, y) of a point at ``values`` in the turning frame, from where it stands at angle zero; same unit as values."""
    c, s = np.cos(angle_rad) - 1.0, np.sin(angle_rad)
    return values[0] * c - values[1] * s, values[0] * s + values[1] * c


def pair(size: float, unit: str) -> tuple[Parameter, Parameter]:
    """Cosine and sine that vanish at zero angle, the two coordinates of every once-per-turn error, as parameters."""
    return Parameter(f"cosine_{unit}", size), Parameter(f"sine_{unit}", size)


def length(values: Floats) -> float:
    """Amplitude of the wave, in the unit of ``values``."""
    return float(np.hypot(values[0], values[1]))


def phase(values: Floats) -> float:
    """Phase of the wave, rad: it is highest at minus this shaft angle."""
    return float(np.arctan2(values[1], values[0]))
