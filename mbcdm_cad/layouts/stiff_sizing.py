"""Sizing by stiffness: what is made stiffer than strength and place ask for, and how far.

The rules size a drive for strength and place. What gives then is made stiffer, first where a share of the payload's
compliance costs the least share of the drive's mass. The file says how far: up to ``loads.stiffness_Nm_rad``, down to
``loads.structure_share``, up to ``targets.mass_g``; where it states none of them, as long as 1 % of mass buys 1 % of
compliance, so that mass times compliance is least. All of these are one search, with different prices of compliance.
What makes another check fail is taken back: there the bounds of the design refuse.
"""

import copy
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from math import exp, inf, log
from operator import itemgetter
from typing import Any

import numpy as np
from pydantic import ValidationError

from mbcdm_cad.checks.comparison import Check
from mbcdm_cad.checks.run import bounds
from mbcdm_cad.checks.size import kept_mass_g
from mbcdm_cad.checks.structure import most_share
from mbcdm_cad.design.blocks import Design
from mbcdm_cad.design.drive import Drive, met
from mbcdm_cad.design.paths import at
from mbcdm_cad.design.resolve import Catalogue
from mbcdm_cad.design.rules import every_broken_rule
from mbcdm_cad.design.sized import Moved, SizedValue, Sizing, SizingError
from mbcdm_cad.layouts import registry
from mbcdm_cad.layouts.base import Layout, NoFigureError
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.layouts.structure import DrumStructure, drum_structure_of, drum_study, structure_with
from mbcdm_cad.model.structure.causes import urad_Nm
from mbcdm_cad.routes import Floats
from mbcdm_cad.sizing import KnownFields, rounded_up

# Most sizings where mass and compliance are weighed, and where the file asks for a figure; factor on a number with
# which its effect is measured, and the largest one of a round; how often a factor that is refused is halved; how near
# the border of a check is met, as a share of a step; what a sizing for the frame's windup counts for.
_SIZINGS, _SIZINGS_TO_FIGURE, _HALVINGS, _NEAR, _OF_FRAME = 6, 24, 2, 0.1, 0.25
_TRIED, _MOST = 1.1, 2.5
# Fields whose causes have less than this share of the turn stay as they are, as do those that promise less of mass
# times turn; and rounds that promise less, the first and any other; and what much is.
_LEAST_SHARE, _LEAST_GAIN, _LEAST_ROUND, _MUCH = 0.03, 0.004, (0.01, 0.03), -0.1
# What is aimed at beyond a figure, for rounding. Least % of mass that 1 % of a value counts with.
_SPARE, _LEAST_COST = 1.01, 1e-6
# Share by a fine mesh over that by the rough one, at most. Share of mass times turn that may be given for a structure
# which is no longer warned of (a choice).
_OFF_ROUGH, _CHEAP = 1.04, 0.05
# Turn that counts as none, urad/N m; share of a drum's turn in its plane from which on bending out of it is left out.
_NO_TURN, _FLAT = 1e-9, 0.93
_NO_DRIVE = (NoFigureError, ValueError, ZeroDivisionError)
# The checks of what is aimed at.
_OWN = frozenset({"stiffness", "structure_share"})
# Checks that follow from finite elements of drum or frame; they take longer than all others.
BY_ELEMENTS = frozenset({"drum_stress", "frame_windup", "servo_lash"}) | _OWN
CABLES, FRAME, DRUM, WINDUP = "cables", "frame", "drum: ", "frame_windup"
# Why a value is raised where the file states no figure.
PRICE = "stiffness as long as 1 % of mass buys 1 % of compliance"
_STIFFNESS = at.loads.stiffness_Nm_rad
# Ease of turning by less preload: shares of what its rule gives, which is twice what keeps the cables taut.
BACKDRIVE, PRELOAD, _PRELOAD_SHARES = "backdrive", at.rope.preload_N, (0.9, 0.8, 0.7, 0.65, 0.6, 0.55, 0.5)


# The rules of a layout, as ``size`` of its sizing module: the data with its open fields filled.
Size = Callable[[dict[str, Any], Moved | None, Sizing | None], Sizing]


@dataclass(frozen=True)
class Stiffener:
    """A field that its rule fills and that makes the drive stiffer.

    ``causes``: beginnings of the names of what turns less by it (:mod:`mbcdm_cad.layouts.structure`), or
    :data:`CABLES`. ``most``: largest multiple of the rule's value. A number is rounded
    up to ``step``; of a catalogue's ``kind`` the next entry is taken whose ``order`` is large enough and that ``fits``.
    ``grows``: power of the value with which mass grows. ``stated``: only where the file states a stiffness, since it
    costs friction and life of the rope, and next to no mass.
    """

    field: str
    causes: tuple[str, ...]
    most: float
    step: float = 0.1
    grows: float = 1.0
    kind: str = ""
    order: str = ""
    fits: Callable[[KnownFields, Mapping[str, Any], Mapping[str, Any]], bool] = lambda given, now, entry: True
    stated: bool = False

    def changed(self, given: KnownFields, factor: float, value: Any) -> Any:
        """A value times a factor; of the catalogue the smallest entry so large, else the value itself."""
        if not self.kind:
            eased = factor < 1.0 and self.stated
            return float(f"{factor * value:.2g}") if eased else rounded_up(value * factor, self.step)
        sizes = self._sizes(given, value)
        return next((n for n, size in sizes.items() if size >= sizes[value] * factor * (1.0 - 1e-9)), value)

    def multiples(self, given: KnownFields, value: Any) -> list[float]:
        """Multiples of a name's size that are other names, itself among them, in order."""
        sizes = self._sizes(given, value)
        return sorted(size / sizes[value] for size in sizes.values())

    def larger(self, given: KnownFields, value: Any) -> tuple[Any, float] | None:
        """A larger value with its multiple, by which its effect is measured; None where there is none."""
        if self.kind:
            by = next((m for m in self.multiples(given, value) if m > 1.0), 0.0)
            return (self.changed(given, by, value), by) if by else None
        found = rounded_up(max(value * _TRIED, value + self.step), self.step)
        return found, found / value

    def of(self, given: KnownFields, value: Any) -> float:
        """A value as a number: of a part its size."""
        return float(given.entries(self.kind)[value][self.order]) if self.kind else float(value)

    def nearest(self, given: KnownFields, name: str, wanted: float) -> float:
        """The logarithm of the multiple of a part's size nearest to ``wanted``."""
        return min(map(log, self.multiples(given, name)), key=lambda by: abs(by - wanted), default=0.0)

    def _sizes(self, given: KnownFields, value: Any) -> dict[str, float]:
        """Entries of the catalogue that fit in place of one of them, it too, the smallest first."""
        entries = given.entries(self.kind)
        if value not in entries:
            return {}
        fitting = (name for name in entries if name == value or self.fits(given, entries[value], entries[name]))
        return {name: entries[name][self.order] for name in sorted(fitting, key=lambda n: (entries[n][self.order], n))}


def _same_construction(given: KnownFields, now: Mapping[str, Any], entry: Mapping[str, Any]) -> bool:
    return bool(entry["construction"] == now["construction"])


def _no_thinner(given: KnownFields, now: Mapping[str, Any], entry: Mapping[str, Any]) -> bool:
    return bool(entry["bore_mm"] >= now["bore_mm"])


def _has_encoder(given: KnownFields, now: Mapping[str, Any], entry: Mapping[str, Any]) -> bool:
    encoders = given.entries("encoders").values()
    return _no_thinner(given, now, entry) and any(encoder["bore_mm"] == entry["bore_mm"] for encoder in encoders)


_part = partial(Stiffener, grows=2.0, order="diameter_mm")
# Of a bearing; a part that only one layout has may have one too.
bearing = partial(Stiffener, most=3.0, grows=2.0, kind="bearings", order="outer_diameter_mm", fits=_no_thinner)
SHARED: tuple[Stiffener, ...] = (
    _part(at.rope.type, (CABLES,), 4.0, kind="ropes", fits=_same_construction, stated=True),
    Stiffener(PRELOAD, (CABLES,), 2.0, 1.0, stated=True),
    Stiffener(at.drum.hub_diameter_mm, (DRUM,), 4.0, 0.5, grows=2.0),
    Stiffener(at.drum.web_thickness_mm, ("drum: web",), 6.0),
    bearing(at.drum.bearing, ("drum's ",), fits=_has_encoder),
    bearing(at.input_pulleys.upper_bearing, ("input pulleys' bearings", "input pulleys, bending"), fits=_has_encoder),
    bearing(at.input_pulleys.lower_bearing, ("input pulleys",)),
    _part(at.drive.gearhead, ("gearheads",), 3.0, kind="gearheads"),
)


_PANELS = {
    "plate": ("plate",),
    "bridge": ("bridge",),
    "side_wall": ("side walls", "motor head's walls"),
    "back_plate": ("back plate", "column back", "box back"),
    "rib": ("column ribs",),
}


# Largest multiples of what their rules give. A back plate of more than 12 mm, printed 21 mm, is a block: folded plates
# do not describe it, and it warps when it is printed (a choice).
_THICKEST = {"back_plate": 3.0, "plate": 5.0, "bridge": 5.0, "side_wall": 5.0, "rib": 5.0}


def walls(*fields: str) -> tuple[Stiffener, ...]:
    """Walls of the frame, by the names of its panels in its study."""
    return tuple(
        Stiffener(f"support.{field}_mm", tuple(f"{FRAME}: {panel}" for panel in _PANELS[field]), _THICKEST[field])
        for field in fields
    )


@dataclass(frozen=True)
class _End:
    """How far a drive is stiffened.

    ``field``: what the file asks for, or the check of the frame's windup, which ``holds`` for a counted turn and the
    cables' turn; none where mass and compliance are weighed, the mass at most ``most_g``. ``share``: the cables' turn
    does not count; ``of``: only causes whose names begin so do.
    """

    field: str = ""
    holds: Callable[[float, float], bool] = lambda turn, cables: False
    share: bool = False
    of: str = ""
    most_g: float = inf


def _ends(data: Mapping[str, Any]) -> Iterator[_End]:
    """What the file asks for. The stiffness comes first: a thicker rope for it leaves the structure a smaller turn."""
    loads, targets = data.get("loads") or {}, data.get("targets") or {}
    wanted, share, mass_g = loads.get("stiffness_Nm_rad"), loads.get("structure_share"), targets.get("mass_g")
    if isinstance(wanted, int | float):
        yield _End(_STIFFNESS, lambda turn, cables: turn * wanted <= 1e6)
    if isinstance(share, int | float):
        yield _End(at.loads.structure_share, lambda turn, cables: turn <= share * cables, share=True)
    if wanted is None and share is None:
        within_g = targets.get("mass_tolerance_g", 10.0)
        yield _End(most_g=mass_g + within_g) if isinstance(mass_g, int | float) else _End()


@dataclass(frozen=True)
class _Weighed:
    """A sizing with factors on what its rules gave; ``turns``: by cause, urad/N m, that by the ``drum`` among them."""

    sizing: Sizing
    factors: Mapping[str, float]
    layout: SectorLayout
    drum: DrumStructure
    turns: Mapping[str, float]
    mass_g: float

    @property
    def worth(self) -> float:
        """Logarithm of mass times turn, the smaller the better."""
        return log(self.mass_g) + log(sum(self.turns.values()))

    def counted(self, end: _End) -> dict[str, float]:
        """Turns that the end counts."""
        own = {name: urad for name, urad in self.turns.items() if name.startswith(end.of)}
        return {name: urad for name, urad in own.items() if not (end.share and name == CABLES)}

    def left(self, end: _End) -> bool:
        """Whether the end asks for more, or cannot tell."""
        return not (end.field and end.holds(sum(self.counted(end).values()), self.turns[CABLES]))

    def better(self, end: _End, before: "_Weighed") -> bool:
        """Whether it is nearer to the end than another; to a figure that the file asks for every step counts."""
        if end.of:
            return sum(self.counted(end).values()) < sum(before.counted(end).values())
        if end.field or before.mass_g > end.most_g:
            return bool(end.field) or self.mass_g < before.mass_g
        return self.mass_g <= end.most_g and self.worth < before.worth

    def value(self, field: str) -> Any:
        """The value of a field; None where no rule gives it."""
        found = self.sizing.of(field)
        return None if found is None else found.value


@dataclass(frozen=True)
class _Effect:
    """What a field does: powers with which turns fall, by cause; g over its value to the power ``grows``."""

    powers: Mapping[str, float]
    each_g: float


@dataclass(frozen=True)
class Ways:
    """Effect of some fields on a drive, by powers of the factors on their values.

    ``urad_Nm`` (c,): turns by cause, which fall with ``powers`` (c, f); ``mass_g``: that of the drive, to which a field
    adds ``each_g`` (f,) times its factor to the power ``grows`` (f,), less 1; ``bounds`` (2, f): logarithms of the
    factors that may be.
    """

    of: tuple[Stiffener, ...]
    urad_Nm: Floats
    powers: Floats
    mass_g: float
    each_g: Floats
    grows: Floats
    bounds: Floats

    def after(self, logs: Floats) -> tuple[Floats, float]:
        """Turns by cause, and mass, with these logarithms of the factors."""
        mass_g = self.mass_g + self.each_g @ np.expm1(self.grows * logs)
        return self.urad_Nm * np.exp(-self.powers @ logs), max(float(mass_g), 1e-3 * self.mass_g)

    def worth(self, logs: Floats, price: float) -> float:
        """Logarithm of mass times the turn to the power ``price``."""
        turns, mass_g = self.after(logs)
        return log(mass_g) + price * log(turns.sum())

    def best(self, price: float) -> Floats:
        """The logarithms of the factors at which that is least.

        There 1 % of each value costs ``price`` times as many % of mass as it saves of the turn, or is at a bound.
        """
        logs: Floats = np.zeros(len(self.of))
        # In log space mass times turn is convex: ever shorter steps down its slope meet its least value.
        for pace in 0.8 * 0.93 ** np.arange(60):
            turns, mass_g = self.after(logs)
            saved = price * (turns @ self.powers) / turns.sum()
            cost = np.maximum(self.each_g * self.grows * np.exp(self.grows * logs) / mass_g, _LEAST_COST)
            step = np.clip(np.log(np.maximum(saved, 1e-12) / cost), -1.0, 1.0)
            logs = np.clip(logs + pace * step, *self.bounds)
        return logs

    def price(self, end: _End, cables: float) -> float:
        """% of mass that 1 % of the turn may cost: 1, or less where the mass is limited; to a figure, the least."""

        def dear(price: float) -> bool:
            turns, mass_g = self.after(self.best(price))
            if end.field:
                return end.holds(_SPARE * float(turns.sum()), cables)
            return mass_g > end.most_g

        if not end.field and (end.most_g == inf or not dear(1.0)):
            return 1.0
        low, high = -10.0, 15.0 if end.field else 0.0
        while high - low > 0.01:
            middle = (low + high) / 2.0
            low, high = (low, middle) if dear(exp(middle)) else (middle, high)
        return exp(high if end.field else low)


class _Run:
    """The sizing of one file by stiffness."""

    def __init__(
        self, size: Size, data: dict[str, Any], layout: type[Layout], stiffeners: Sequence[Stiffener], moved: Moved
    ) -> None:
        self._size, self._data, self._layout, self._moved = size, copy.deepcopy(data), layout, moved
        self._given, self._by_field = KnownFields(self._data), {s.field: s for s in stiffeners}
        self.ends = tuple(_ends(data))
        # Whether only mass and compliance are weighed, so that no check compares the turn with a figure.
        self.weighs = not self.ends[0].field
        # More metal makes no check by finite elements fail.
        self._unjudged = BY_ELEMENTS - {WINDUP} if self.weighs else _OWN
        self.left = float(_SIZINGS if self.weighs else _SIZINGS_TO_FIGURE)
        # Largest and least factors, nearer to 1 where a farther one was refused.
        self._bounds = {s.field: (1.0, s.most) for s in stiffeners}
        self._refused, self._effects = list[str](), dict[str, _Effect]()
        self._measured_for: _End | None = None
        self._flat: bool | None = None
        # What was changed for the frame's windup, before anything was weighed.
        self._for_frame = set[str]()

    def sized(self, factors: Mapping[str, float], similar: Sizing | None) -> Sizing:
        """The sizing with factors on values of rules; what a search moves, it moves after that."""

        by_rule = dict[str, Any]()

        def both(field: str, value: Any) -> Any:
            by_rule[field] = value
            value = self._by_field[field].changed(self._given, factors[field], value)
            return self._moved[field](value) if field in self._moved else value

        moved = dict(self._moved) | {field: partial(both, field) for field in factors}
        found = self._size(copy.deepcopy(self._data), moved, similar)
        changed = by_rule.keys() - self._moved.keys()
        said = (self._said(v, by_rule[v.field]) if v.field in changed else v for v in found.values)
        return replace(found, values=tuple(said), raised=dict(factors))

    def _said(self, value: SizedValue, by_rule: Any) -> SizedValue:
        """The record of a value that is another one than by its rule."""
        if value.value == by_rule:
            return value
        stated = {end.field: KnownFields(self._data).get(end.field) for end in self.ends if "." in end.field}
        driver, how, why = "stiffness", "raised for the stiffness", " and ".join(stated) or PRICE
        if value.field in self._for_frame:
            driver, how, why = WINDUP, "raised for the frame", WINDUP
        if value.field == PRELOAD and value.value < by_rule:
            driver, how, why = BACKDRIVE, "lowered to turn easily", at.loads.backdrive_Nm
        text = f"{value.text} ({by_rule}), {how.partition(' ')[0]} for {why}"
        return replace(value, text=text, driver=driver, rests_on={**value.rests_on, **stated}, rounding=how)

    def drive(self, factors: Mapping[str, float], sizing: Sizing) -> _Weighed | None:
        """A sizing with these factors as a drive; None where it is none."""
        try:
            found = layout_of(self._layout, sizing.data)
            assert isinstance(found, SectorLayout)
            found.require_geometry()
            drum = self._drum(found)
            return _Weighed(sizing, dict(factors), found, drum, _turns(found, drum), kept_mass_g(found))
        except _NO_DRIVE:
            return None

    def _drum(self, found: SectorLayout) -> DrumStructure:
        """The drum of a drive: as the checks have it, or for weighing more roughly, flat where it hardly bends."""
        if not self.weighs:
            return drum_structure_of(found)
        if self._flat is None:
            whole, flat = (urad_Nm(drum_study(found, rough=True, flat=one).causes) for one in (False, True))
            self._flat = flat > _FLAT * whole
        return drum_study(found, rough=True, flat=self._flat)

    def _effect(self, drive: _Weighed, s: Stiffener) -> _Effect | None:
        """What a field does with the others as they are; of meshes only those are solved that it changes."""
        value = drive.value(s.field)
        by = s.larger(self._given, value)
        if by is None:
            return None
        try:
            found = registry.layout_of(_drive_of(self._layout, _with(drive.sizing.data, s.field, by[0])))
            assert isinstance(found, SectorLayout)
            found.require_geometry()
            if not s.causes[0].startswith(FRAME):
                found.frame_compliance = drive.layout.frame_compliance
            drum = drive.drum
            if s.causes[0].startswith(DRUM):
                drum = self._drum(found)
            then, mass_g = _turns(found, drum), kept_mass_g(found)
        except _NO_DRIVE:
            return None
        # The hub has not followed a larger bearing yet: of a part only its own causes count, and no mass is saved.
        powers = {
            n: log(max(u, _NO_TURN) / max(then.get(n, u), _NO_TURN)) / log(by[1])
            for n, u in drive.turns.items()
            if n.startswith(s.causes) or not s.kind
        }
        added_g = max(mass_g - drive.mass_g, 0.0) if s.kind else mass_g - drive.mass_g
        return _Effect(powers, added_g / (by[1] ** s.grows - 1.0) / s.of(self._given, value) ** s.grows)

    def ways(self, drive: _Weighed, end: _End) -> Ways | None:
        """Fields that can be raised, or taken back, and what each does; None where there are none."""
        # Where mass and compliance are weighed, a second round corrects the first: what was measured there holds.
        if end is not self._measured_for:
            self._effects.clear()
        self._measured_for = end
        turns, found, known = drive.counted(end), list[tuple[Any, ...]](), bool(self._effects)
        for s in self._by_field.values():
            value, factor, (least, most) = drive.value(s.field), drive.factors.get(s.field, 1.0), self._bounds[s.field]
            share = sum(urad for name, urad in turns.items() if name.startswith(s.causes)) / sum(turns.values())
            open_ = value is not None and share >= _LEAST_SHARE and factor < most
            if not open_ or (s.stated and end.field != _STIFFNESS):
                continue
            if not s.kind:
                most = min(most, max(bounds(drive.layout, s.field)[1] * factor / value, factor))
            effect = self._effects.get(s.field) if known else self._effect(drive, s)
            if effect is not None:
                self._effects[s.field] = effect
                logs = log(min(least / factor, 1.0)), min(log(most / factor), log(_MOST))
                powers = [effect.powers.get(name, 0.0) for name in turns]
                found.append((s, powers, effect.each_g * s.of(self._given, value) ** s.grows, logs))
        if not found:
            return None
        of, falls, grams, limits = zip(*found, strict=True)
        urad, grows = np.maximum(list(turns.values()), _NO_TURN), np.array([s.grows for s in of])
        return Ways(of, urad, np.array(falls).T, drive.mass_g, np.array(grams), grows, np.array(limits).T)

    def proposed(self, drive: _Weighed, end: _End) -> tuple[_End, dict[str, float], float]:
        """The end, factors on fields whose values then change, and what :attr:`_Weighed.worth` should change by."""
        ways = self.ways(drive, end)
        if ways is None:
            return end, {}, 0.0
        logs, none = ways.best(ways.price(end, drive.turns[CABLES])), np.zeros(len(ways.of))
        # Parts come in sizes: numbers make up for what the nearest ones leave.
        for k, stiffener in enumerate(ways.of):
            if stiffener.kind:
                ways.bounds[:, k] = stiffener.nearest(self._given, drive.value(stiffener.field), logs[k])
        price = ways.price(end, drive.turns[CABLES])
        logs = ways.best(price)
        for k, stiffener in enumerate(ways.of):
            # Up to a figure each step counts, down from one and for the least of mass times turn half a step.
            least = stiffener.step * (0.01 if end.field and logs[k] > 0.0 else 0.5)
            small = not stiffener.kind and abs(exp(logs[k]) - 1.0) * drive.value(stiffener.field) < least
            without = np.where(np.arange(len(logs)) == k, 0.0, logs)
            if small or (not end.field and ways.worth(without, price) - ways.worth(logs, price) < _LEAST_GAIN):
                logs[k] = 0.0
        changed = ((s.field, by) for s, by in zip(ways.of, logs, strict=True) if by != 0.0)
        factors = {field: drive.factors.get(field, 1.0) * exp(by) for field, by in changed}
        return end, factors, ways.worth(logs, price) - ways.worth(none, price)

    def taken(self, drive: _Weighed, factors: Mapping[str, float], end: _End, promised: float) -> _Weighed:
        """The drive with the factors where they pay and fail no other check; else the farthest gets a nearer limit."""
        found, whole = None, {**drive.factors, **factors}
        self.left -= _OF_FRAME if end.of else 1.0
        with suppress(SizingError):
            found = self.drive(whole, self.sized(whole, drive.sizing))
        pays, failing = found is None or found.better(end, drive), set[str]()
        if found is not None and pays:
            failing = set(misses(found.layout, self._unjudged))
            failing -= misses(drive.layout, self._unjudged).keys() if failing else set()
            if not failing:
                if end.field:
                    self._effects.clear()
                return found
        changed = {field: log(factor / drive.factors.get(field, 1.0)) for field, factor in factors.items()}
        field = max(changed, key=lambda name: abs(changed[name]))
        left = inf
        if found is not None and failing:
            without = {name: self._missed_with(found, failing, name, drive.value(name)) for name in changed}
            field = min(changed, key=lambda name: without[name])
            left = without[field]
        # What is refused, too heavy, or promised much is tried half as far, twice; what costs more than it promised, as
        # its followers grow, is not.
        least, most = self._bounds[field]
        heavy = found is not None and found.mass_g > end.most_g
        # The sizes of a part are few: half as far is soon the same one.
        halvings = 1 if self._by_field[field].kind else _HALVINGS
        again = (pays or heavy or promised < _MUCH) and self._refused.count(field) < halvings
        share = 0.5 if again else 0.0
        if found is not None and left == 0.0 and not self._by_field[field].kind:
            share = self._border(found, failing, field, changed[field])
        limit = factors[field] * exp((share - 1.0) * changed[field])
        self._bounds[field] = (least, limit) if changed[field] > 0.0 else (limit, most)
        self._refused.append(field)
        return drive

    def _border(self, refused: _Weighed, failing: Collection[str], field: str, by: float) -> float:
        """Largest share of a number's step ``by``, in logarithms, with which a refused drive holds what fails."""
        low, high = 0.0, 1.0
        while high - low > _NEAR:
            middle = (low + high) / 2.0
            value = self._by_field[field].changed(self._given, exp((middle - 1.0) * by), refused.value(field))
            holds = self._missed_with(refused, failing, field, value) == 0.0
            low, high = (middle, high) if holds else (low, middle)
        return low

    def _missed_with(self, refused: _Weighed, failing: Collection[str], field: str, value: Any) -> float:
        """What a drive that fails checks misses with another value of one field."""
        try:
            found = registry.layout_of(_drive_of(self._layout, _with(refused.sizing.data, field, value)))
            return sum(misses(found, only=failing).values())
        except _NO_DRIVE:
            return inf

    def stiffer(self, drive: _Weighed) -> _Weighed:
        """The drive raised until its ends are reached, or nothing pays any more."""
        while self.left > 0:
            steps = (self.proposed(drive, end) for end in self.ends if drive.left(end))
            end, factors, promised = next(filter(itemgetter(1), steps), (None, {}, 0.0))
            if end is None or (not end.field and promised > -_LEAST_ROUND[bool(drive.factors)]):
                break
            if end.of:
                self._for_frame |= factors.keys()
            drive = self.taken(drive, factors, end, promised)
        return drive

    def eased(self, drive: _Weighed) -> _Weighed:
        """The drive with the highest preload with which it turns as easily as the file asks.

        If there is none, the lowest that fails no other check.
        """
        failing = misses(layout_of(self._layout, drive.sizing.data))
        for share in _PRELOAD_SHARES if BACKDRIVE in failing else ():
            try:
                sizing = self.sized({PRELOAD: share}, drive.sizing)
                now, tried = misses(layout_of(self._layout, sizing.data)), self.drive({PRELOAD: share}, sizing)
            except (NoFigureError, SizingError):
                break
            if tried is None or not now.keys() <= failing.keys():
                break
            drive = tried
            if BACKDRIVE not in now:
                break
        return drive


def stiffened(
    size: Size,
    data: dict[str, Any],
    layout: type[Layout],
    stiffeners: Sequence[Stiffener],
    moved: Moved | None = None,
    similar: Sizing | None = None,
    *,
    eases: bool = True,
) -> Sizing:
    """The sizing of ``size``, as stiff as the file asks, or as near as the bounds of the design allow.

    ``eases``: whether anchored cables get less preload for ``loads.backdrive_Nm``; no, where the preload's rule does it
    itself. A search (``moved``, with the sizing ``similar``) keeps the factors that were found there.
    """
    run = _Run(size, data, layout, stiffeners, moved or {})
    if similar is not None and similar.raised is not None:
        return run.sized(similar.raised, similar)
    plain = run.sized({}, similar)
    drive = run.drive({}, plain)
    if drive is None:
        return plain
    limit = drive.layout.windup_limit_mrad / drive.layout.drive.loads.test_torque_Nm * 1e3
    run.ends = (_End(WINDUP, lambda turn, cables: turn <= limit, of=f"{FRAME}: "), *run.ends)
    if eases and run.weighs and plain.of(PRELOAD) and (data.get("loads") or {}).get("backdrive_Nm") is not None:
        drive = run.eased(drive)
    drive, most = run.stiffer(drive), most_share(drive.layout) / _OFF_ROUGH
    within = _End("structure_share", lambda turn, cables: turn <= most * cables, share=True)
    if run.weighs and run.ends[-1].most_g == inf and drive.left(within):
        # Where least mass times turn leaves a structure that is warned of, it is made as stiff as that asks, if cheap.
        run.ends, run.left = (within,), _SIZINGS
        stiffer = run.stiffer(drive)
        if not stiffer.left(within) and stiffer.worth < drive.worth + _CHEAP:
            drive = stiffer
    return drive.sizing


def _turns(found: SectorLayout, drum: DrumStructure) -> dict[str, float]:
    """Turns by cause, urad/N m, that of the frame by its walls."""
    structure, frame = structure_with(found, drum), found.frame_compliance
    turns = {CABLES: structure.cables_urad_Nm, **{c.name: c.urad_Nm for c in structure.at_payload}}
    if frame is not None:
        turns[FRAME] -= sum(frame.shares_urad_Nm.values())
        turns |= {f"{FRAME}: {wall}": urad for wall, urad in frame.shares_urad_Nm.items()}
    return turns


def _with(data: Mapping[str, Any], field: str, value: Any) -> dict[str, Any]:
    block, _, name = field.partition(".")
    return {**data, block: {**data[block], name: value}}


def layout_of(layout: type[Layout], data: Mapping[str, Any]) -> Layout:
    """The design of a sizing's data. Raises ``NoFigureError`` where it is no drive."""
    return registry.layout_of(met(_drive_of(layout, data)))


def _drive_of(layout: type[Layout], data: Mapping[str, Any]) -> Drive:
    """As :func:`layout_of`, a drive that is not kept."""
    file = layout.design_file()
    try:
        design: Design = file.schema.model_validate(data)
    except ValidationError as error:
        raise NoFigureError(str(error)) from None
    catalogue = Catalogue(design)
    broken = next(every_broken_rule(design, catalogue, file.rules(design), file.named(design)), None)
    if broken is not None:
        raise NoFigureError(broken.what)
    return file.drive(design, catalogue, {})


def misses(found: Layout, without: Collection[str] = (), only: Collection[str] | None = None) -> dict[str, float]:
    """Checks that fail on a design, with what each misses over its limit; infinite where it has no figure.

    ``without``: ids left out; ``only``: ids, of which alone the checks are made.
    """
    drive, failing = found.drive, dict[str, float]()
    for check in found.checks_by_id().values():
        judged = check.severity_on(drive) == "fail" and check.id not in without and check.asked_of(drive)
        judged = judged and (only is None or check.id in only)
        if judged and drive.waiver(check.id) is None:
            missed = _missed(check, found)
            if missed > 0.0:
                failing[check.id] = missed
    return failing


def _missed(check: Check, found: Layout) -> float:
    try:
        measured = check.measure(found)
    except _NO_DRIVE:
        return inf
    return 0.0 if measured.holds else -measured.margin / (abs(measured.limit) or 1.0)
