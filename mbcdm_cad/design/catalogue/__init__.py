"""The package's catalogue: one JSON file per kind of bought-out part, and materials.

JSON, because every start of the program reads several files, and JSON is parsed ten times as fast as YAML. Entries are
validated by :mod:`mbcdm_cad.design.entries` when they are looked up; a test validates them all.
"""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parent


@cache
def package_entries(kind: str) -> dict[str, dict[str, Any]]:
    """The entries of one kind (a key of ``entries.KINDS``) by name, as plain data; do not change them."""
    with open(FOLDER / f"{kind}.json", encoding="utf-8") as file:
        entries: dict[str, dict[str, Any]] = json.load(file)
    return entries
