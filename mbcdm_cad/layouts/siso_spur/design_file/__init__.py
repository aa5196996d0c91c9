"""The design file of siso_spur: what the loader needs to read it."""

from __future__ import annotations

from typing import Any

from mbcdm_cad.design.design_file import DesignFile
from mbcdm_cad.design.freedom import Freedom
from mbcdm_cad.design.sized import Moved, Sizing
from mbcdm_cad.layouts.siso_spur.design_file.reference import SHARED
from mbcdm_cad.layouts.siso_spur.design_file.resolve import drive
from mbcdm_cad.layouts.siso_spur.design_file.rules import broken_rules, named_entries
from mbcdm_cad.layouts.siso_spur.design_file.schema import SpurDesign
from mbcdm_cad.layouts.siso_spur.design_file.starting import STARTING


def _size(data: dict[str, Any], moved: Moved, similar: Sizing | None) -> Sizing:
    from mbcdm_cad.layouts.siso_spur.sizing import size  # only files with gaps need the rules

    return size(data, moved, similar)


def _derived() -> tuple[str, ...]:
    from mbcdm_cad.layouts.siso_spur.sizing import DERIVED

    return DERIVED


def _freedoms() -> tuple[Freedom, ...]:
    from mbcdm_cad.layouts.siso_spur.sizing.freedoms import FREEDOMS

    return FREEDOMS


DESIGN_FILE = DesignFile(SpurDesign, SHARED, broken_rules, named_entries, drive, _size, _derived, _freedoms, STARTING)
