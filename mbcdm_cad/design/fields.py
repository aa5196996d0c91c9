"""Building blocks of the schema: strict number types and the one way of declaring a field."""

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field
from dataclasses import Field as DataclassField
from typing import Annotated, Any, ClassVar, TypeVar, get_args

from pydantic import BaseModel, ConfigDict, Field, Strict, StringConstraints, TypeAdapter

Number = Annotated[float, Strict(), Field(allow_inf_nan=False)]
Integer = Annotated[int, Strict()]
# Source of a value that nothing but judgement gives.
ESTIMATE = "estimate"
SLUG = r"^[a-z0-9][a-z0-9_-]{0,63}$"
ENTRY_NAME = r"^[A-Za-z0-9][A-Za-z0-9._/+-]{0,63}$"
CHECK_ID = r"^[a-z][a-z0-9_]{0,63}$"
PATTERN_WORDS = {
    SLUG: "1 to 64 of a-z, 0-9, _ and -, a letter or digit first",
    ENTRY_NAME: "1 to 64 of A-Z, a-z, 0-9 and . _ / + -, a letter or digit first",
    CHECK_ID: "1 to 64 of a-z, 0-9 and _, a letter first",
}
Slug = Annotated[str, StringConstraints(pattern=SLUG)]
EntryName = Annotated[str, StringConstraints(pattern=ENTRY_NAME)]
CheckId = Annotated[str, StringConstraints(pattern=CHECK_ID)]
Text = Annotated[str, StringConstraints(min_length=1, max_length=400, strip_whitespace=True)]

# Units by the end of a field's name, the longest first; a name with none of these ends has no unit.
_ONE_WORD = ("mm", "mm2", "deg", "rad", "mrad", "urad", "arcmin", "g", "kg", "N", "s", "h", "Hz", "GPa", "MPa")
_UNITS = {
    "g_cm2": "g cm2",
    "g_cm3": "g/cm3",
    "g_m": "g/m",
    "kg_m2": "kg m2",
    "N_mm": "N/mm",
    "Nm": "N m",
    "mNm": "mN m",
    "Nm_rad": "N m/rad",
    "Nm_A": "N m/A",
    "mNm_A": "mN m/A",
    "deg_s": "deg/s",
    "K_W": "K/W",
    "kJ_mol": "kJ/mol",
} | {word: word for word in (*_ONE_WORD, "A", "V", "ohm", "C", "EUR")}


def unit_in(name: str) -> str:
    """The unit that a field's name ends with; ``-`` for none."""
    words = name.split("_")
    ends = ("_".join(words[k:]) for k in range(1, len(words)))
    return next((_UNITS[end] for end in ends if end in _UNITS), "-")


class _UnitsInNames:
    """A class whose fields have the units that their names tell, unless a field states one.

    A field that may be None is None where it is left out, unless it states another default.
    """

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        for name, declaration in vars(cls).items():
            if isinstance(declaration, DataclassField):
                extra = declaration.metadata.get("json_schema_extra", {"unit": "-"})
                extra["unit"] = extra["unit"] or unit_in(name)
                kind = cls.__annotations__[name]
                may_be_none = kind.endswith("| None") if isinstance(kind, str) else type(None) in get_args(kind)
                if may_be_none and declaration.default is MISSING:
                    declaration.default = None


class Block(_UnitsInNames, BaseModel):
    """A block of a file from which other values follow: unknown keys refused, values fixed once read."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

    # The first fields in files and on pages, with those that a block which extends this one may put between them.
    ORDER: ClassVar[tuple[str, ...]] = ()


@dataclass(frozen=True, kw_only=True)
class PlainBlock(_UnitsInNames):
    """A block of a file that all rooms read as it is: a frozen dataclass with its fields declared as in :class:`Block`.

    pydantic validates it when it is read from a file; an object made in Python is not validated.
    """

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid")
    ORDER: ClassVar[tuple[str, ...]] = ()


_Read = TypeVar("_Read", bound=Block | PlainBlock)


def is_block(annotation: Any) -> bool:
    """Whether a field of this type is a block of the file."""
    return isinstance(annotation, type) and issubclass(annotation, Block | PlainBlock)


def validated(kind: type[_Read], data: Any) -> _Read:
    """A block made from plain data. Raises pydantic's ``ValidationError``."""
    found: _Read = adapter(kind).validate_python(data)
    return found


_ADAPTERS: dict[type, TypeAdapter[Any]] = {}


def adapter(kind: type[Any]) -> TypeAdapter[Any]:
    """What validates a block of this class and writes its schema."""
    if kind not in _ADAPTERS:
        _ADAPTERS[kind] = TypeAdapter(kind)
    return _ADAPTERS[kind]


def declared(meaning: str, extra: dict[str, Any], default: Any, bounds: Mapping[str, Any]) -> Any:
    """A field of a dataclass or a model that pydantic validates; ``extra`` goes to the JSON Schema."""
    return field(default=default, metadata={"description": meaning, "json_schema_extra": extra, **bounds})


def _bounds(within: str) -> dict[str, float]:
    """pydantic's bounds of an interval such as ``(0, 1]``; none of an empty text."""
    if not within:
        return {}
    low, high = map(float, within[1:-1].split(","))
    return {"gt" if within[0] == "(" else "ge": low, "lt" if within[-1] == ")" else "le": high}


def quantity(
    meaning: str,
    within: str = "",
    *,
    unit: str = "",
    source: str = "-",
    reference: Any = None,
    example: Any = None,
    uncertain: bool = False,
    **bounds: Any,
) -> Any:
    """A field with its meaning, bounds such as ``(0, 1]`` and source in one place.

    ``unit`` is needed only where the end of its name, such as ``_mm``, does not tell it.
    ``reference`` is the value of the reference design, from which ``mbcdm init --reference`` writes a file, and
    ``source`` says where it comes from; both are given elsewhere for a block that several configurations share. A field
    with ``example`` instead is written there as a comment. Either is shown to the user as an example. ``uncertain``
    allows ``{value: ..., sigma: ...}`` in place of the number, or of each number of a list. ``bounds`` that are no
    figures in an interval go to pydantic (``ge``, ``gt``, ``le``, ``lt``, ``min_length``, ``max_length``); a
    ``default`` among them makes the field optional.
    """
    extra: dict[str, Any] = {"unit": unit, "source": source}
    if reference is not None:
        extra |= {"examples": [reference], "in_reference": True}
    elif example is not None:
        extra |= {"examples": [example]}
    if uncertain:
        extra["uncertain"] = True
    return declared(meaning, extra, bounds.pop("default", MISSING), _bounds(within) | bounds)


def choice(meaning: str, *, source: str = "-", reference: Any = None, example: Any = None, **bounds: Any) -> Any:
    """A field without a unit: a name, a word of a fixed set, a list of names."""
    return quantity(meaning, unit="-", source=source, reference=reference, example=example, **bounds)


def entry_field(
    meaning: str, within: str = "", *, default: Any = MISSING, uncertain: bool = False, **bounds: Any
) -> Any:
    """As :func:`quantity`, of an entry of the catalogue, whose source is that of the whole entry."""
    return declared(
        meaning, {"unit": ""} | ({"uncertain": True} if uncertain else {}), default, _bounds(within) | bounds
    )
