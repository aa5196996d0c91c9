"""How an entry of the catalogue is picked by its margins; which margins a part needs stands in ``parts``."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from operator import itemgetter
from typing import Any

from mbcdm_cad.layouts.miso_bevel.sizing.known import BevelKnown
from mbcdm_cad.sizing.rule import Found, driver_of

Entry = Mapping[str, Any]
# Margins by check, as shares of its limit; negative if it fails.
Margins = Mapping[str, float]
# Text of a choice that meets all margins.
LIGHTEST = "lightest of the catalogue"


def first(candidates: Iterable[tuple[str, Callable[[], Margins]]]) -> Found:
    """The first candidate whose margins are all kept; else the one that misses least.

    A candidate is (name, function that computes its margins), the lightest first; later ones than the result are not
    computed.
    """
    refused: list[tuple[str, Margins]] = []
    for name, worked_out in candidates:
        margins = worked_out()
        if all(margin >= 0.0 for margin in margins.values()):
            return Found(name, driver_of(refused[-1][1], min) if refused else "", LIGHTEST)
        refused.append((name, margins))
    name, margins = max(refused, key=lambda one: min(one[1].values()))
    return Found(name, driver_of(margins, min), "nothing in the catalogue does: the nearest")


def careful(factors: tuple[float, float], pick: Callable[[float], Found]) -> Found:
    """The choice with the first factor on the load, or with the second if no part carries the first."""
    found = pick(factors[0])
    return found if found.rounding == LIGHTEST else pick(factors[1])


def by_mass(entry: Entry, other: Entry) -> float:
    return float(entry["mass_g"] + other["mass_g"])


def with_partner(
    given: BevelKnown,
    kind: str,
    partner: tuple[str, str],
    margins: Callable[[Entry, Entry], Margins],
    order: Callable[[Entry, Entry], float] = by_mass,
) -> Found:
    """The entry of a kind that is first in ``order`` together with a partner (its kind, its field).

    A given partner is kept.
    """
    other_kind, field = partner
    others = given.entries(other_kind)
    if given.has(field):
        others = {given[field]: given.entry(other_kind, field)}
    pairs = [
        (order(entry, other), f"{name} {other_name}", entry, other)
        for name, entry in given.entries(kind).items()
        # A motor with its own shaft is chosen if the file wants no gearhead.
        if "shaft_diameter_mm" not in entry
        for other_name, other in others.items()
    ]
    pairs.sort(key=itemgetter(0, 1))
    best = first((names, partial(margins, entry, other)) for _, names, entry, other in pairs)
    return Found(best.value.split(" ")[0], best.driver, best.rounding)


def lightest(given: BevelKnown, kind: str, margins: Callable[[Entry], Margins]) -> Found:
    """The lightest entry of a kind whose margins are all kept."""
    return ordered(given.entries(kind), "mass_g", margins)


def ordered(entries: Mapping[str, Entry], by: str, margins: Callable[[Entry], Margins]) -> Found:
    """The first of the entries whose margins are all kept, the smallest ``by`` one of their fields first."""
    listed = sorted((entry[by], name) for name, entry in entries.items())
    return first((name, partial(margins, entries[name])) for _, name in listed)
