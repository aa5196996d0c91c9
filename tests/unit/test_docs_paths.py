"""Paths that the pages for contributors name are there: a file that moves takes its mention along."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
# Words in capitals stand for any name.
_ANY = re.compile(r"NAME|KIND|FORMAT")
_PATH = re.compile(r"`([\w.*/-]+/[\w.*-]+/?)`")


@pytest.mark.parametrize("page", ["docs/architecture.md", "docs/CONTRIBUTING.md"])
def test_every_path_of_a_page_is_there(page: str) -> None:
    lines = (ROOT / page).read_text("utf-8").splitlines()
    named = [(number, path) for number, line in enumerate(lines, 1) for path in _PATH.findall(line)]
    assert len(named) > 10, named
    gone = [
        f"{page}:{number}: {path}"
        for number, path in named
        if not any(True for room in (ROOT, ROOT / "mbcdm_cad") for _ in room.glob(_ANY.sub("*", path).rstrip("/")))
    ]
    assert not gone, "\n".join(gone)
