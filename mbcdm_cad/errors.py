"""Errors that a user can correct, with all information that is needed for it."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from math import inf


class MbcdmError(Exception):
    """Base of every error whose text is meant for the user; anything else is a fault of the program."""


@dataclass(frozen=True)
class Problem:
    """One thing wrong with an input file: where, what, which value against which limit, and what to do about it.

    ``value`` and ``limit`` may be empty if there is none. ``may_move``: the file itself is valid, and other values of
    free fields may solve the problem, so that a search continues. ``missing``: the file lacks a required field.
    """

    file: str
    line: int
    field: str
    what: str
    value: str = ""
    limit: str = ""
    remedy: str = ""
    may_move: bool = False
    missing: bool = False

    def __str__(self) -> str:
        """``FILE:LINE: field: what (value ..., limit ...); remedy`` on one line."""
        file = self.file if self.file.isprintable() else repr(self.file)
        where = f"{file}:{self.line}: " + (f"{self.field}: " if self.field else "")
        figures = ", ".join(f"{word} {text}" for word, text in (("value", self.value), ("limit", self.limit)) if text)
        return where + self.what + (f" ({figures})" if figures else "") + (f"; {self.remedy}" if self.remedy else "")


class InputError(MbcdmError):
    """An input file that cannot be used. Contains every problem found, one line of text each."""

    def __init__(self, problems: tuple[Problem, ...] | list[Problem]) -> None:
        if not problems:
            raise ValueError("an InputError needs at least one problem")
        self.problems = tuple(problems)
        super().__init__("\n".join(str(problem) for problem in self.problems))

    def __reduce__(self) -> "tuple[type[InputError], tuple[tuple[Problem, ...]]]":
        """Whole across processes: pickle would make it anew of its text."""
        return type(self), (self.problems,)


class OutputError(MbcdmError):
    """The output folder cannot or must not be written; the text says which folder, why, and what to do."""


def shortened(value: object, limit: int = 60) -> str:
    """``repr`` of a value on one line, cut to ``limit`` characters, of any size and depth, without recursion limits."""
    if isinstance(value, dict):
        text = f"a block of {len(value)} fields" if value else "an empty block"
    elif isinstance(value, list | tuple) and (len(value) > 8 or any(isinstance(item, dict | list) for item in value)):
        text = f"a list of {len(value)}"
    else:
        text = "nothing" if value is None else repr(value)
    return text if len(text) <= limit else text[: limit - 3] + "..."


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """``did you mean X?``, or the known names if none is similar."""
    import difflib  # only when something is wrong

    known = list(known)
    near = difflib.get_close_matches(name[:80], known, n=8, cutoff=0.6)
    near = [other for other in known if other.casefold() == name.casefold()] or near
    near.sort(key=lambda other: (-difflib.SequenceMatcher(None, other, name).ratio(), _size_apart(name, other)))
    if near:
        return f"did you mean {near[0]}?"
    listed = ", ".join(known[:30]) + (", ..." if len(known) > 30 else "")
    return f"known here: {listed}" if known else "nothing is known here; remove it"


def _size_apart(name: str, other: str) -> float:
    """Difference of the sizes with which two names end if all else is equal; else infinite."""
    one, two = (re.fullmatch(r"(.*?)([0-9]*\.?[0-9]+)", text) for text in (name, other))
    return abs(float(one[2]) - float(two[2])) if one and two and one[1] == two[1] else inf


class GeometryError(MbcdmError):
    """A solid that is not one valid body, or cannot be meshed within its tolerance; the text says which and why."""
