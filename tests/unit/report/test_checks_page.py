"""docs/checks.md agrees with the registry."""

from __future__ import annotations

from pathlib import Path

import pytest

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.report.checks_page import checks_page

ROOT = Path(__file__).parents[3]
# As the Makefile names them.
REFERENCES = ("mbcdm", "siso_bevel", "siso_spur", "miso_spur")


@pytest.fixture(scope="module")
def drives() -> list[Drive]:
    return [load_design(ROOT / "params" / f"{name}.yaml").drive for name in REFERENCES]


@pytest.fixture(scope="module")
def page(drives: list[Drive]) -> str:
    return checks_page(drives)


def test_page_in_docs_is_up_to_date(page: str) -> None:
    """Write it anew with: make docs."""
    assert (ROOT / "docs" / "checks.md").read_text("utf-8") == page


def test_each_check_of_each_layout_stands_once_in_its_column(page: str, drives: list[Drive]) -> None:
    tables, _ = page.split("## Checks of the build")
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in tables.splitlines() if line.startswith("| `")]
    for column, drive in enumerate(drives, start=3):
        found = sorted(row[0].split("`")[1] for row in rows if row[column])
        assert found == sorted(drive.layout.checks_by_id()), drive.name
        assert len(found) > 100
