"""Tapped holes in the files of single parts: at the major diameter, or drawn again at the tap drill on request."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

from mbcdm_cad.build.made_parts import exported_parts
from mbcdm_cad.build.store import Store, StoredPart
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.parts.bill import PartSpec


class _Asked:
    """Stands for the store: remembers what it is asked to make."""

    def __init__(self) -> None:
        self.specs: dict[str, PartSpec] = {}

    def parts(self, specs: Mapping[str, PartSpec], *rest: Any) -> dict[str, StoredPart]:
        self.specs = dict(specs)
        return {name: cast(StoredPart, ("drilled", spec.part)) for name, spec in specs.items()}


def test_only_parts_with_tapped_holes_are_drawn_anew_and_only_where_asked() -> None:
    drive = load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive
    whole = drive.layout.bill()
    parts = {name: cast(StoredPart, ("major", spec.part)) for name, spec in whole.parts.items()}
    store = _Asked()
    assert exported_parts(cast(Store, store), whole, parts, drive, 1) == parts and not store.specs
    asked = replace(drive, export=replace(drive.export, threads="tap_drill"))
    files = exported_parts(cast(Store, store), whole, parts, asked, 1)
    changed = {name for name in parts if files[name] != parts[name]}
    assert changed == {"frame", "drum", "collar"} and set(files) == set(parts)
    assert all(store.specs[name].part == whole.parts[name].drilled for name in changed)
