"""A ratio that the file leaves open together with the motor: that of the lightest drive which passes every check.

Torque, speed, heat and back-driving fix only motor, gearhead and ratio together: a larger ratio has a smaller motor and
a larger drum. So whole drives are sized at round ratios, each with the train that its rules choose, and compared.
"""

import copy
import marshal
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from math import inf
from operator import itemgetter
from typing import Any

from mbcdm_cad.checks.size import kept_mass_g
from mbcdm_cad.design.rules import Broken
from mbcdm_cad.design.sized import LIGHTEST, Moved, Sizing, SizingError
from mbcdm_cad.layouts.base import Layout, NoFigureError
from mbcdm_cad.layouts.stiff_sizing import BY_ELEMENTS, Size, Stiffener, layout_of, misses, stiffened
from mbcdm_cad.layouts.trial_sizing import TrialKnown, repeated
from mbcdm_cad.sizing import Found, KnownFields, Rule

# Below the first no drive is built with a capstan; above the last the input of a thin rope outgrows any usual drum.
RATIOS = (2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 15.0, 20.0)
# Wishes that choose a train.
_WISHES = ("peak_torque_Nm", "continuous_torque_Nm", "speed_deg_s", "backdrive_Nm", "duty", "payload")


# The rules of a layout as ``Size``, and with the rule of a ratio before them.
SizeWith = Callable[..., Sizing]


@dataclass(frozen=True)
class SizingRules:
    """The sizing of a layout: ``names`` and the other ``rules`` in their order, on what is ``known`` of a drive.

    ``guesses``: values of a drive of medium size for the first pass. ``missing``: requirements that no rule can fill.
    ``open_ratio``: field of a ratio that nothing fixes in this file, "" if there is none. ``eases``: see
    :func:`~mbcdm_cad.layouts.stiff_sizing.stiffened`.
    """

    known: type[TrialKnown]
    names: tuple[Rule, ...]
    rules: tuple[Rule, ...]
    stiffeners: tuple[Stiffener, ...]
    guesses: Callable[[Any], dict[str, Any]]
    missing: Callable[[Any], Iterator[Broken]]
    open_ratio: Callable[[Any], str] = lambda given: ""
    eases: Callable[[Any], bool] = lambda given: True

    def __call__(self, data: dict[str, Any], moved: Moved | None = None, similar: Sizing | None = None) -> Sizing:
        """The data with all open fields filled; ``moved`` changes the values that rules give.

        ``similar``: see :func:`~mbcdm_cad.layouts.trial_sizing.repeated`. Raises ``SizingError`` if a requirement is
        missing.
        """
        given = self.known(data, {})
        missing = list(self.missing(given))
        if missing:
            raise SizingError(*missing)

        def by_rules(
            data: dict[str, Any], moved: Moved | None, similar: Sizing | None, ratio: tuple[Rule, ...] = ()
        ) -> Sizing:
            rules, guesses = (*self.names, *ratio, *self.rules), self.guesses(self.known(data, {}))
            return repeated(data, self.known, rules, guesses, moved, similar)

        plain: Size = by_rules
        field, layout = self.open_ratio(given), self.known.layout
        if field:
            plain = partial(lightest, by_rules, field, layout=layout)
        return stiffened(plain, data, layout, self.stiffeners, moved, similar, eases=self.eases(given))


def lightest(
    size: SizeWith,
    field: str,
    data: dict[str, Any],
    moved: Moved | None,
    similar: Sizing | None,
    *,
    layout: type[Layout],
) -> Sizing:
    """The sizing with the ratio ``field`` of the lightest drive of all that fail fewest checks, and miss them least.

    A search (``moved``, with the sizing ``similar``) keeps the ratio that was found there. Raises ``SizingError`` where
    no ratio gives a drive.
    """
    ratio = similar.ratio if similar is not None else None
    if ratio is None:
        # One command sizes the same file several times.
        key = layout.__name__, marshal.dumps(data, 2)
        best = _FOUND.pop(key, None) or _lightest(size, field, data, layout)
        _FOUND[key] = best
        if len(_FOUND) > _REMEMBERED:
            del _FOUND[next(iter(_FOUND))]
        if not moved and similar is None:
            return replace(best, data=copy.deepcopy(best.data))
        ratio = best.ratio
        assert ratio is not None
    return _with(size, field, data, moved, similar, ratio)


# The lightest drives of the last files, the latest used last.
_FOUND: dict[tuple[str, bytes], Sizing] = {}
_REMEMBERED = 64


def _lightest(size: SizeWith, field: str, data: dict[str, Any], layout: type[Layout]) -> Sizing:
    sized: dict[float, Sizing] = {}
    drives = list[tuple[_Rank, float, Layout, dict[str, float]]]()
    refused: list[NoFigureError | SizingError] = []
    for ratio in RATIOS:
        try:
            sized[ratio] = _with(size, field, data, None, None, ratio)
            found = layout_of(layout, sized[ratio].data)
            missed = misses(found, without=BY_ELEMENTS)
            drives.append((_rank(found, missed), ratio, found, missed))
        except (NoFigureError, SizingError) as error:
            refused.append(error)
    best: tuple[_Rank, float] | None = None
    # Finite elements add misses at most, so that a drive behind the best without them stays there.
    for rank, ratio, found, missed in sorted(drives, key=itemgetter(0, 1)):
        if best is not None and best <= (rank, ratio):
            break
        whole = _rank(found, missed | misses(found, only=BY_ELEMENTS)), ratio
        best = whole if best is None else min(best, whole)
    if best is not None:
        return sized[best[1]]
    if isinstance(refused[0], SizingError) and len({str(error) for error in refused}) == 1:
        raise refused[0]  # a fault of the file, whatever the ratio
    what = f"missing, and no ratio from {RATIOS[0]:g} to {RATIOS[-1]:g} gives a drive: {refused[0]}"
    raise SizingError(Broken(tuple(field.split(".")), what, "", "", "add it, or name the motor under drive:"))


def _with(
    size: SizeWith, field: str, data: dict[str, Any], moved: Moved | None, similar: Sizing | None, ratio: float
) -> Sizing:
    found = size(copy.deepcopy(data), moved, similar, (_rule(field, ratio),))
    return replace(found, ratio=ratio)


def _rule(field: str, ratio: float) -> Rule:
    def chosen(given: KnownFields) -> Found:
        for wish in _WISHES:
            given.get(f"loads.{wish}")
        return Found(ratio, LIGHTEST, f"of {RATIOS[0]:g} to {RATIOS[-1]:g}")

    return Rule(
        field,
        "that of the lightest drive which passes, of round ratios with the motor and gearhead that loads ask for",
        "motor_torque_forward",
        chosen,
    )


# Number of failing checks, what they miss over their limits, mass in g.
_Rank = tuple[int, float, float]


def _rank(found: Layout, missed: Mapping[str, float]) -> _Rank:
    """The rank of a drive that misses these checks."""
    try:
        mass_g = kept_mass_g(found)
    except (ValueError, ZeroDivisionError):
        mass_g = inf
    return len(missed), sum(missed.values()), mass_g
