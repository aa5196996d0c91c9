"""Sizing by ``loads.stiffness_Nm_rad`` and ``loads.structure_share``: what gives most is raised until they hold.

The rules size a drive for strength and place. Where it then gives more than the file allows, the fields that stiffen
its softest parts are raised over what their rules gave, the softest first, all down to one level, and the drive is
sized again, since other rules follow from them. A raise that makes another check fail is taken back: there the bounds
of the design refuse, and the check of the requirement says how far it came. Without either, anchored cables get less
preload for ``loads.backdrive_Nm``.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import inf
from typing import Any, Protocol

from pydantic import ValidationError

from mbcdm_cad.checks.comparison import Check
from mbcdm_cad.design.blocks import Design
from mbcdm_cad.design.drive import met
from mbcdm_cad.design.lookup import Catalogue
from mbcdm_cad.design.rules import every_broken_rule
from mbcdm_cad.design.sized import Moved, SizedValue, Sizing, SizingError
from mbcdm_cad.layouts.base import Layout, NoFigureError
from mbcdm_cad.layouts.structure import Cause, Structure, urad_Nm
from mbcdm_cad.sizing.known import KnownFields
from mbcdm_cad.sizing.rule import rounded_up

# Most sizings, largest factor on a value in one round, and what is aimed at beyond the requirement, for rounding and
# because the parts' turns are no exact powers of their sizes.
_SIZINGS, _STEP, _SPARE = 24, 1.5, 1.01
# Factor with which a raise is tried again that was refused: the next entry of the catalogue, the next step of a number.
_LEAST = 1.0 + 1e-6
# What can be raised turns no less than this share of what cannot: more metal would hardly stiffen the drive.
_QUARTER = 0.25
# The checks of what is aimed at.
_OWN = ("stiffness", "structure_share")
# Checks that follow from finite elements of drum or frame; they take longer than all others.
BY_ELEMENTS = frozenset({"drum_stress", "frame_windup", "stiffness", "structure_share", "servo_lash"})
CABLES = "cables"
# Ease of turning by less preload: shares of what its rule gives, which is twice what keeps the cables taut.
BACKDRIVE, PRELOAD, _PRELOAD_SHARES = "backdrive", "rope.preload_N", (0.9, 0.8, 0.7, 0.65, 0.6, 0.55, 0.5)


_Plain = Callable[[Mapping[str, float], Sizing | None], Sizing]


class Size(Protocol):
    """The rules of a layout, as ``size`` of its sizing module."""

    def __call__(self, data: dict[str, Any], moved: Moved | None, similar: Sizing | None) -> Sizing:
        """The data with its open fields filled."""


@dataclass(frozen=True)
class Stiffener:
    """A field that its rule fills and that makes some causes of the turn give less.

    ``causes``: beginnings of their names (:mod:`mbcdm_cad.layouts.structure`), or :data:`CABLES`. Their turn falls with
    about the power ``power`` of the field's value; ``most``: largest multiple of the rule's value. A number is rounded
    up to ``step``; of a catalogue's ``kind`` the next entry is taken whose ``order`` is large enough and that
    ``fits``. ``last``: only where no other field lowers the cause any more.
    """

    field: str
    causes: tuple[str, ...]
    power: float
    most: float
    step: float = 0.1
    kind: str = ""
    order: str = ""
    fits: Callable[[KnownFields, Mapping[str, Any], Mapping[str, Any]], bool] = lambda given, now, entry: True
    last: bool = False

    def lowers(self, cause: str) -> bool:
        """Whether it makes a cause give less."""
        return cause.startswith(self.causes)

    def raised(self, given: KnownFields, factor: float, value: Any) -> Any:
        """The rule's value times a factor; of the catalogue the smallest entry so large, else the value itself."""
        if not self.kind:
            return rounded_up(value * factor, self.step)
        entries = given.entries(self.kind)
        if value not in entries:
            return value
        now = entries[value]
        least = now[self.order] * factor * (1.0 - 1e-9)
        fitting = (n for n in entries if entries[n][self.order] >= least and self.fits(given, now, entries[n]))
        return min(fitting, key=lambda name: (entries[name][self.order], name), default=value)


def _same_construction(given: KnownFields, now: Mapping[str, Any], entry: Mapping[str, Any]) -> bool:
    return bool(entry["construction"] == now["construction"])


def _has_encoder(given: KnownFields, now: Mapping[str, Any], entry: Mapping[str, Any]) -> bool:
    return any(encoder["bore_mm"] == entry["bore_mm"] for encoder in given.entries("encoders").values())


# Powers are estimates: how far a raise came, the next round sees. The rope is thicker before it is tighter.
SHARED: tuple[Stiffener, ...] = (
    Stiffener("rope.type", (CABLES,), 2.0, 4.0, kind="ropes", order="diameter_mm", fits=_same_construction),
    Stiffener("rope.preload_N", (CABLES,), 0.3, 2.0, 1.0, last=True),
    Stiffener("drum.hub_diameter_mm", ("drum: ",), 2.0, 2.5, 0.5),
    Stiffener("drum.web_thickness_mm", ("drum: web",), 0.8, 4.0),
    Stiffener("drum.bearing", ("drum's ",), 1.0, 3.0, kind="bearings", order="outer_diameter_mm", fits=_has_encoder),
    Stiffener(
        "input_pulleys.upper_bearing",
        ("input pulleys' bearings", "input pulleys, bending"),
        1.0,
        3.0,
        kind="bearings",
        order="outer_diameter_mm",
        fits=_has_encoder,
    ),
    Stiffener("input_pulleys.lower_bearing", ("input pulleys",), 1.0, 3.0, kind="bearings", order="outer_diameter_mm"),
    Stiffener("drive.gearhead", ("gearheads",), 3.0, 3.0, kind="gearheads", order="diameter_mm"),
)


@dataclass(frozen=True)
class _Aim:
    """A requirement of the file: the causes that it counts turn at most so far together."""

    field: str
    counted: Callable[[Structure], tuple[Cause, ...]]
    most_urad_Nm: Callable[[Structure], float]

    def holds(self, structure: Structure) -> bool:
        """Whether the structure meets it."""
        return urad_Nm(self.counted(structure)) <= self.most_urad_Nm(structure)


def _aims(loads: Mapping[str, Any]) -> Iterator[_Aim]:
    """What the file asks for. The stiffness comes first: a thicker rope for it leaves the structure a smaller turn."""
    wanted, share = loads.get("stiffness_Nm_rad"), loads.get("structure_share")
    if isinstance(wanted, int | float):
        yield _Aim(
            "loads.stiffness_Nm_rad",
            lambda found: (Cause(CABLES, found.cables_urad_Nm), *found.at_payload),
            lambda found: 1e6 / wanted,
        )
    if isinstance(share, int | float):
        yield _Aim("loads.structure_share", lambda found: found.at_payload, lambda found: share * found.cables_urad_Nm)


def walls(*fields: str) -> tuple[Stiffener, ...]:
    """Walls of the frame that stiffen it together."""
    return tuple(Stiffener(field, ("frame",), 2.0 / len(fields), 5.0) for field in fields)


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
    """The sizing of ``size``, its stiffness and share of the structure as stated, or as near as its bounds allow.

    ``eases``: where the file states neither, see :func:`_eased`; no, where the preload's rule does it itself. A search
    (``moved``, with the sizing ``similar``) keeps what was raised there: it changes these values itself.
    """
    aims = tuple(_aims(data.get("loads") or {}))
    plain = partial(_sized, size, copy.deepcopy(data), (stiffeners, aims), moved or {})
    if not aims:
        return _eased(size, data, layout, moved or {}, similar) if eases else plain({}, similar)
    if similar is not None and similar.raised is not None:
        return plain(similar.raised, similar)
    best = plain({}, similar)
    start = _judged(layout, best)
    if start is None:
        return best
    structure, failing = start
    factors: dict[str, float] = {}
    closed: set[str] = set()
    budget = _Budget(_SIZINGS)
    while budget.left > 0:
        open_ = [
            s for s in stiffeners if best.of(s.field) and factors.get(s.field, 1.0) < s.most and s.field not in closed
        ]
        room = {s.field: s.most / factors.get(s.field, 1.0) for s in open_}
        missed = (aim for aim in aims if not aim.holds(structure))
        steps = (_step(aim.counted(structure), aim.most_urad_Nm(structure) / _SPARE, open_) for aim in missed)
        step = {f: min(by, room[f]) for f, by in next(filter(None, steps), {}).items()}
        if not step:
            break
        found = _passing(partial(budget.spent, plain), layout, best, factors, step, failing)
        closed |= found.closed
        factors, best, structure = found.factors, found.sizing, found.structure or structure
    return replace(best, raised=factors)


def _eased(size: Size, data: dict[str, Any], layout: type[Layout], moved: Moved, similar: Sizing | None) -> Sizing:
    """The sizing with less preload where the drum turns harder than the file asks for, as long as no other check fails.

    The highest preload with which it turns so easily, else the lowest that no other check refuses. A search keeps the
    share that was found for ``similar``.
    """

    def shared(share: float, near: Sizing | None) -> Sizing:
        def less(value: Any) -> Any:
            value = float(f"{share * value:.2g}")
            return moved[PRELOAD](value) if PRELOAD in moved else value

        found = size(copy.deepcopy(data), {**moved, PRELOAD: less} if share < 1.0 else moved, near)
        said = [
            replace(v, driver=BACKDRIVE, rounding="lowered to turn easily") if v.field == PRELOAD else v
            for v in found.values
        ]
        return replace(found, values=tuple(said), raised={PRELOAD: share}) if share < 1.0 else found

    if not isinstance((data.get("loads") or {}).get("backdrive_Nm"), int | float):
        return size(copy.deepcopy(data), moved, similar)
    if similar is not None and similar.raised is not None:
        return shared(similar.raised.get(PRELOAD, 1.0), similar)
    best = shared(1.0, similar)
    if best.of(PRELOAD) is None:
        return best
    try:
        failing = misses(layout_of(layout, best))
        for share in _PRELOAD_SHARES if BACKDRIVE in failing else ():
            tried = shared(share, best)
            now = misses(layout_of(layout, tried))
            if not now.keys() <= failing.keys():
                break
            best = tried
            if BACKDRIVE not in now:
                break
    except (NoFigureError, SizingError):
        pass
    return replace(best, raised=best.raised or {})


@dataclass
class _Budget:
    """Number of sizings that are left."""

    left: int

    def spent(self, plain: _Plain, raised: Mapping[str, float], similar: Sizing | None) -> Sizing:
        """One of them."""
        self.left -= 1
        return plain(raised, similar)


@dataclass(frozen=True)
class _Round:
    """What came of one round: the sizing, its structure where it changed, and the fields that cannot be raised."""

    sizing: Sizing
    factors: dict[str, float]
    structure: Structure | None
    closed: frozenset[str]


def _passing(
    plain: _Plain,
    layout: type[Layout],
    before: Sizing,
    factors: Mapping[str, float],
    step: Mapping[str, float],
    failing: frozenset[str],
) -> _Round:
    """The round's raises together; those that make another check fail take their least step, or none."""
    steps = dict(step)

    def tried(fields: Sequence[str]) -> _Round | None:
        raised = {**factors, **{f: factors.get(f, 1.0) * steps[f] for f in fields}}
        try:
            sizing = plain(raised, before)
        except SizingError:
            return None
        found = _judged(layout, sizing)
        if found is None or not found[1] <= failing:
            return None
        same = frozenset(f for f in fields if _value(sizing, f) == _value(before, f))
        return _Round(sizing, raised, found[0], same)

    refused: frozenset[str] = frozenset()
    while steps:
        found = tried(tuple(steps))
        if found is not None:
            return replace(found, closed=found.closed | refused)
        alone = [f for f in steps if len(steps) == 1 or tried([f]) is None] or list(steps)
        for field in alone:
            if steps[field] > _LEAST:
                steps[field] = _LEAST
            else:
                refused |= {field}
                del steps[field]
    return _Round(before, dict(factors), None, refused)


def _value(sizing: Sizing, field: str) -> Any:
    found = sizing.of(field)
    return None if found is None else found.value


def _sized(
    size: Size,
    data: dict[str, Any],
    asked: tuple[Sequence[Stiffener], Sequence[_Aim]],
    moved: Moved,
    raised: Mapping[str, float],
    similar: Sizing | None,
) -> Sizing:
    """The sizing with fields raised by their factors; what a search moves, it moves after that."""
    stiffeners, aims = asked
    by_field = {s.field: s for s in stiffeners if s.field in raised}
    given = KnownFields(data)

    def both(field: str, value: Any) -> Any:
        value = by_field[field].raised(given, raised[field], value)
        return moved[field](value) if field in moved else value

    found = size(copy.deepcopy(data), {**moved, **{field: partial(both, field) for field in by_field}}, similar)
    if not raised:
        return found
    values = tuple(
        _said(value, data, aims) if value.field in by_field and value.field not in moved else value
        for value in found.values
    )
    return replace(found, values=values, raised=dict(raised))


def _said(value: SizedValue, data: Mapping[str, Any], aims: Sequence[_Aim]) -> SizedValue:
    stated = {aim.field: data["loads"][aim.field.partition(".")[2]] for aim in aims}
    rests_on = {**value.rests_on, **stated}
    return replace(value, driver="stiffness", rests_on=rests_on, rounding="raised for the stiffness")


def _step(counted: Sequence[Cause], target_urad_Nm: float, open_: Sequence[Stiffener]) -> dict[str, float]:
    """Factor on each field with which the causes that can be lowered come down to one level, at most ``_STEP``."""
    ways: list[tuple[float, list[Stiffener]]] = []
    fixed = 0.0
    for cause in counted:
        fields = [s for s in open_ if s.lowers(cause.name)]
        if fields:
            ways.append((cause.urad_Nm, [s for s in fields if not s.last] or fields))
        else:
            fixed += cause.urad_Nm
    aim = max(target_urad_Nm - fixed, _QUARTER * fixed)
    level, found = _level([urad for urad, _ in ways], aim), dict[str, float]()
    for urad, fields in ways:
        if urad > level:
            by = min((urad / level) ** (1.0 / sum(s.power for s in fields)), _STEP)
            found |= {s.field: max(by, found.get(s.field, 1.0)) for s in fields}
    return found


def _level(turns: Sequence[float], target: float) -> float:
    """The level to which the largest of some turns must come down for their sum to be ``target``."""
    ordered = sorted(turns)
    for k, turn in enumerate(ordered):
        # Those below k stay as they are; the others come down to one level.
        level = (target - sum(ordered[:k])) / (len(ordered) - k)
        if level <= turn:
            return level
    return inf


def _judged(layout: type[Layout], sizing: Sizing) -> tuple[Structure, frozenset[str]] | None:
    """Structure and failing checks of a sized design, those of the aims left out; None where it is no drive."""
    try:
        found = layout_of(layout, sizing)
        structure = found.structure
    except NoFigureError:
        return None
    return None if structure is None else (structure, frozenset(misses(found, _OWN)))


def layout_of(layout: type[Layout], sizing: Sizing) -> Layout:
    """A sized design. Raises ``NoFigureError`` where it is no drive."""
    file = layout.design_file()
    try:
        design: Design = file.schema.model_validate(sizing.data)
    except ValidationError as error:
        raise NoFigureError(str(error)) from None
    catalogue = Catalogue(design)
    broken = next(every_broken_rule(design, catalogue, file.rules(design), file.named(design)), None)
    if broken is not None:
        raise NoFigureError(broken.what)
    return met(file.drive(design, catalogue, {})).layout


def misses(found: Layout, without: Collection[str] = (), only: Collection[str] | None = None) -> dict[str, float]:
    """Checks that fail on a design, with what each misses over its limit; infinite where it has no figure.

    ``without``: ids left out; ``only``: ids, of which alone the checks are made.
    """
    drive, failing = found.drive, dict[str, float]()
    for check in found.checks_by_id().values():
        judged = check.severity == "fail" and check.id not in without and check.asked_of(drive)
        judged = judged and (only is None or check.id in only)
        if judged and drive.waiver(check.id) is None:
            missed = _missed(check, found)
            if missed > 0.0:
                failing[check.id] = missed
    return failing


def _missed(check: Check, found: Layout) -> float:
    try:
        measured = check.measure(found)
    except (NoFigureError, ValueError, ZeroDivisionError):
        return inf
    return 0.0 if measured.holds else -measured.margin / (abs(measured.limit) or 1.0)
