"""Sizing: compute a value for every field from the requirements, choices and pins of a design file.

A rule computes one field. In a pass rules run once, in a fixed order, and each reads only fields of the file or fields
that an earlier rule computed. The layouts supply the rules, and trial drives on which passes are repeated; this room
contains neither. A rule reads the data known so far and the catalogue; every field that is read is recorded.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from functools import cache, cached_property
from math import ceil, floor
from typing import Any, Self, TypeVar

from mbcdm_cad.design import bought
from mbcdm_cad.design.blocks import NO_PAYLOAD, Payload
from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.design.resolve import termination
from mbcdm_cad.design.rules import Broken, unknown_entry
from mbcdm_cad.design.sized import Moved, SizedValue, Sizing, SizingError

Value = TypeVar("Value")
# Diameter of the printer's nozzle, as in the schema.
NOZZLE_MM = 0.4


@cache
def _parts(field: str) -> tuple[str, ...]:
    """The names of a dotted field; cached, since a few hundred fields are read several thousand times for a design."""
    return tuple(field.split("."))


class KnownFields:
    """The data of one design file while its gaps are filled.

    Fields are named as in messages, ``drum.outer_face_y_mm``. Each field read through this object is recorded, so that
    the dependencies of a value are exactly the fields that its rule read.
    """

    def __init__(self, data: dict[str, Any]) -> None:
        self.data = data
        self._read: dict[str, Any] = {}
        self._known: dict[Callable[..., Any], Any] = {}

    def __getitem__(self, field: str) -> Any:
        """Value of a field that the file gives or an earlier rule filled. Raises ``KeyError`` where it is open."""
        value = self.peek(field)
        if value is None:
            raise KeyError(f"{field} is not known when it is read: its rule comes too late")
        self._read[field] = value
        return value

    def get(self, field: str, otherwise: Any = None) -> Any:
        """As ``known[field]``, but ``otherwise`` where the field is open."""
        return otherwise if self.peek(field) is None else self[field]

    @property
    def payload(self) -> Payload:
        """The payload; one without mass and load where the file states none."""
        stated = self.get("loads.payload")
        return Payload(**stated) if stated else NO_PAYLOAD

    def has(self, field: str) -> bool:
        """Whether the field is known; not recorded as read."""
        return self.peek(field) is not None

    def peek(self, field: str) -> Any:
        """Value of the field, None if it is open; not recorded as read."""
        at: Any = self.data
        try:
            for part in _parts(field):
                at = at.get(part)
        except AttributeError:  # a block that is left out, or no block
            return None
        return at

    def once(self, figure: Callable[[Self], Value]) -> Value:
        """``figure(self)``, worked out at the first call within a rule: many entries are compared with one need."""
        if figure not in self._known:
            self._known[figure] = figure(self)
        found: Value = self._known[figure]
        return found

    def put(self, field: str, value: Any) -> None:
        """Fill the field."""
        self._known = {}
        *blocks, last = _parts(field)
        at = self.data
        for part in blocks:
            if not isinstance(at.get(part), dict):
                at[part] = {}
            at = at[part]
        at[last] = value

    def leave_out(self, field: str) -> None:
        """A rule leaves the field out of this design."""

    def start(self) -> None:
        """Clear the record of fields read, before the next rule."""
        self._read, self._known = {}, {}

    @property
    def read(self) -> Mapping[str, Any]:
        """Fields read since :meth:`start`, in the order of reading."""
        return dict(self._read)

    def entries(self, kind: str) -> dict[str, dict[str, Any]]:
        """All entries of a kind of the catalogue; those of the design replace those of the package."""
        own = self.peek(f"catalogue.{kind}")
        return {**package_entries(kind), **own} if isinstance(own, dict) else package_entries(kind)

    def entry(self, kind: str, field: str) -> dict[str, Any]:
        """The entry that a field names. Raises ``SizingError`` for a name that is not in the catalogue."""
        name, entries = self[field], self.entries(kind)
        if kind == "gearheads" and name == bought.NO_GEARHEAD:
            return self._motor_face()
        if name not in entries:
            raise SizingError(unknown_entry(tuple(field.split(".")), kind, str(name), list(entries)))
        return entries[name]

    def motors_with_faces(self) -> dict[str, tuple[dict[str, Any], dict[str, Any]]]:
        """Motors that need no gearhead: entry, and face and shaft as an entry of a gearhead."""
        found = {}
        for name, entry in self.entries("motors").items():
            motor = bought.Motor(name=name, **entry)
            if not bought.missing_face_fields(motor):
                face = asdict(bought.without_gearhead(motor))
                del face["name"]
                face.pop("servo", None)
                found[name] = entry, face
        return found

    def _motor_face(self) -> dict[str, Any]:
        """Face and shaft of the chosen motor, as an entry of a gearhead."""
        self.entry("motors", "drive.motor")
        name, able = self["drive.motor"], self.motors_with_faces()
        if name not in able:
            what = f"{name} has no face and shaft of its own"
            remedy = (
                f"choose a gearhead, or one of {', '.join(n for n, (motor, _) in able.items() if 'servo' not in motor)}"
            )
            raise SizingError(Broken(("drive", "gearhead"), what, bought.NO_GEARHEAD, "", remedy))
        return able[name][1]


class RopeKnown(KnownFields):
    """Adds the rope, screws, and how parts are made."""

    @property
    def whole_drum(self) -> bool:
        """Whether the drum is closed all round."""
        return False

    @property
    def least_rope_mm(self) -> float:
        """Diameter of the thinnest rope that rules choose."""
        return 0.0

    def screw(self, name: str) -> bought.Screw:
        """A screw of the catalogue."""
        return bought.Screw(name=name, **self.entries("screws")[name])

    def printed(self, part: str) -> bool:
        """Whether a part is 3D printed."""
        return bool(self.entry("materials", f"{part}.material")["process"] in ("printed", "sintered"))

    def wall_mm(self, part: str) -> float:
        """Thinnest wall of the material of a part, ``"drum"``."""
        metal = self.entry("materials", f"{part}.material")
        nozzle = self.get("printing.nozzle_mm", NOZZLE_MM) if metal["process"] == "printed" else 0.0
        return bought.least_wall_mm(metal["process"], float(metal["min_wall_mm"]), nozzle)

    @property
    def rope(self) -> dict[str, Any]:
        """The rope's entry."""
        inline = self.get("rope.inline")
        return inline if inline is not None else self.entry("ropes", "rope.type")

    @property
    def d_mm(self) -> float:
        """The rope's diameter."""
        return float(self.rope["diameter_mm"])

    @property
    def termination(self) -> bought.TerminationSpec:
        """How the rope's ends are made: as named, else the strongest that fits."""
        rope = bought.CableSpec(name="rope", **{key: value for key, value in self.rope.items() if key != "name"})
        return termination(self.get("rope.termination"), self._terminations, rope)

    @cached_property
    def _terminations(self) -> list[bought.TerminationSpec]:
        """All of the catalogue, to which no rule adds any."""
        return [
            bought.TerminationSpec(name=name, **{**entry, "constructions": tuple(entry["constructions"])})
            for name, entry in self.entries("terminations").items()
        ]


# Tolerance, so that a figure that is already a multiple of its step is not rounded up.
_ON_STEP = 1e-9


@dataclass(frozen=True)
class Found:
    """Result of a rule: the value, the need that determined it, and how it was rounded."""

    value: Any
    driver: str = ""
    rounding: str = ""


@dataclass(frozen=True)
class Rule:
    """How one field is filled.

    ``text`` is one sentence for people; ``driver`` the check or requirement that the value serves, where ``value`` does
    not say which of several it was. ``value`` gets the configuration's :class:`~mbcdm_cad.sizing.KnownFields` and
    returns the value, or a :class:`Found`. ``applies``: whether the field belongs to this design at all.
    """

    field: str
    text: str
    driver: str
    value: Callable[[Any], Any]
    applies: Callable[[Any], bool] = lambda given: True


def rule(
    field: str, text: str, driver: str, applies: Callable[[Any], bool] = lambda given: True
) -> Callable[[Callable[[Any], Any]], Rule]:
    """Make the :class:`Rule` of a field, whose name is the function's, of the function below that gives its value."""
    return lambda value: Rule(field, text, driver, value, applies)


def rounded_up(value: float, step: float) -> float:
    """The value rounded up to a multiple of ``step``, without the noise of binary fractions."""
    return round(ceil(value / step - _ON_STEP) * step, 9)


def rounded_down(value: float, step: float) -> float:
    """The value rounded down to a multiple of ``step``."""
    return round(floor(value / step + _ON_STEP) * step, 9)


def significant(value: float, digits: int) -> float:
    """The value rounded to significant digits."""
    return float(f"{value:.{digits}g}")


def largest(needs: dict[str, float], step: float) -> Found:
    """The smallest value that meets all needs, rounded up; the need that determines it is the driver."""
    return Found(rounded_up(max(needs.values()), step), driver_of(needs, max), f"up to {step:g}")


def driver_of(needs: Mapping[str, float], which: Callable[..., str]) -> str:
    """Name of the largest need (``which`` is ``max``) or of the smallest (``min``)."""
    return which(needs, key=lambda name: needs[name])


def constant(field: str, value: Any, text: str, driver: str) -> Rule:
    """A field that has one value for every design."""

    def same(given: KnownFields) -> Any:
        return value

    return Rule(field, text, driver, same)


def fill(given: KnownFields, rules: Iterable[Rule], moved: Moved | None = None) -> Sizing:
    """Fill every open field for which a rule applies; fields of the file do not change.

    ``moved``: by field, a function with which a search changes the value of a rule; later rules use the changed value.
    """
    moved = moved or {}
    records: list[SizedValue] = []
    for one in rules:
        if given.has(one.field):
            continue
        if not one.applies(given):
            given.leave_out(one.field)
            continue
        given.start()
        try:
            found = one.value(given)
        except (ValueError, ArithmeticError, IndexError) as error:
            path, why = tuple(one.field.split(".")), f"no rule can fill it here ({error})"
            raise SizingError(
                Broken(path, why, "", "", f"state it in the file; its rule gives: {one.text}", may_move=True)
            ) from None
        if not isinstance(found, Found):
            found = Found(found)
        if one.field in moved:
            found = Found(moved[one.field](found.value), found.driver, "moved")
        rests_on = given.read
        given.put(one.field, found.value)
        records.append(
            SizedValue(one.field, found.value, one.text, found.driver or one.driver, rests_on, found.rounding)
        )
    return Sizing(given.data, tuple(records))
