"""One sentence about a run, before any residual is looked at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from mbcdm_cad.design.loaded import FieldPath

Level = Literal["refused", "doubt", "fact"]


@dataclass(frozen=True)
class Finding:
    """``kind`` names it for programs; ``field`` is the field of the measurement file that it speaks of.

    ``refused``: the run cannot be judged as it is declared. ``doubt``: judged, with this in mind. ``fact``: what the
    experiment can and cannot tell.
    """

    kind: str
    level: Level
    text: str
    remedy: str = ""
    field: FieldPath = ()

    def __str__(self) -> str:
        """Sentence and remedy on one line."""
        return self.text + (f"; {self.remedy}" if self.remedy else "")


def doubts(notes: Sequence[str], findings: Sequence[Finding]) -> list[str]:
    """What speaks against taking a result at its word: notes of the reading, doubts of the vetting."""
    return [*notes, *(str(finding) for finding in findings if finding.level == "doubt")]


def column_of(input_name: str) -> FieldPath:
    """Field of the measurement file that describes one input."""
    return ("columns", "input" if input_name == "input" else f"input_{input_name}")
