"""The design file of miso_bevel: what the loader needs to read it."""

from __future__ import annotations

from typing import Any

from mbcdm_cad.design.design_file import DesignFile, SizingOfMany
from mbcdm_cad.design.freedom import Freedom
from mbcdm_cad.design.sized import Moved, Sizing
from mbcdm_cad.layouts.miso_bevel.design_file.reference import SHARED
from mbcdm_cad.layouts.miso_bevel.design_file.resolve import drive
from mbcdm_cad.layouts.miso_bevel.design_file.rules import broken_rules, named_entries
from mbcdm_cad.layouts.miso_bevel.design_file.schema import BevelDesign
from mbcdm_cad.layouts.miso_bevel.design_file.starting import STARTING


def _size(data: dict[str, Any], moved: Moved, similar: Sizing | None) -> Sizing:
    from mbcdm_cad.layouts.miso_bevel.sizing import size  # only files with gaps need the rules

    return size(data, moved)  # closed form: needs no similar design


def _size_many() -> SizingOfMany:
    from mbcdm_cad.layouts.miso_bevel.sizing import many

    return SizingOfMany(many.size_many, many.FIELDS, many.drive_of_many)


def _derived() -> tuple[str, ...]:
    from mbcdm_cad.layouts.miso_bevel.sizing import DERIVED

    return DERIVED


def _freedoms() -> tuple[Freedom, ...]:
    from mbcdm_cad.layouts.miso_bevel.sizing.freedoms import FREEDOMS

    return FREEDOMS


DESIGN_FILE = DesignFile(
    BevelDesign, SHARED, broken_rules, named_entries, drive, _size, _derived, _freedoms, STARTING, _size_many
)
