"""A design that was read: what :func:`mbcdm_cad.layouts.loader.load_design` gives."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from mbcdm_cad.design.blocks import Design
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.fieldpath import FieldPath, nearest_line
from mbcdm_cad.design.sized import SizedValue


@dataclass(frozen=True)
class LoadedDesign:
    """A design file that passed schema and rules.

    ``design`` is the file as its schema's model, ``data`` the plain values of the fields that the file gives or sizing
    filled, ``sized`` those that sizing filled.
    """

    drive: Drive
    path: Path
    design: Design = field(repr=False)
    text: str = field(repr=False)
    lines: Mapping[FieldPath, int] = field(repr=False)
    data: Mapping[str, Any] = field(repr=False)
    sized: tuple[SizedValue, ...] = field(default=(), repr=False)

    @cached_property
    def sha256(self) -> str:
        """Hash of the content: all values and the catalogue entries that they use, without layout and comments."""
        content = {"design": self.design.model_dump(mode="json"), "drive": asdict(self.drive)}
        return hashlib.sha256(json.dumps(content, sort_keys=True, separators=(",", ":")).encode()).hexdigest()

    @cached_property
    def given(self) -> dict[str, Any]:
        """The validated values of the fields in ``data``, without the defaults of the others, as JSON has them."""
        found: dict[str, Any] = _of_keys(self.design.model_dump(mode="json"), self.data)
        return found

    def line_of(self, *field_path: str | int) -> int:
        """Line of a field, as in ``line_of("cables", 0, "step")``; of the block above it where it is not given."""
        return nearest_line(self.lines, field_path)


def _of_keys(value: Any, like: Any) -> Any:
    """``value`` with those keys of its blocks that ``like`` has too, in the order of ``like``."""
    if isinstance(value, dict) and isinstance(like, Mapping):
        return {key: _of_keys(value[key], item) for key, item in like.items() if key in value}
    if isinstance(value, list) and isinstance(like, list):
        return [_of_keys(item, other) for item, other in zip(value, like, strict=True)]
    return value
