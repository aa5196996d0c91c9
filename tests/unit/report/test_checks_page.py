"""docs/checks.md agrees with the registry."""

from __future__ import annotations

from pathlib import Path

from mbcdm_cad.layouts.check_design import known_ids
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.layouts.miso_bevel.checks import CHECKS
from mbcdm_cad.report.checks_page import checks_page

ROOT = Path(__file__).parents[3]


def test_page_in_docs_is_up_to_date() -> None:
    """Write it anew with: python -m mbcdm_cad.report.checks_page > docs/checks.md."""
    page = checks_page(load_design(ROOT / "params" / "mbcdm.yaml").drive)
    assert (ROOT / "docs" / "checks.md").read_text("utf-8") == page


def test_page_names_every_check() -> None:
    page = checks_page(load_design(ROOT / "params" / "mbcdm.yaml").drive)
    assert all(f"| `{name}`" in page for name in known_ids(load_design(ROOT / "params" / "mbcdm.yaml").drive))
    assert len(CHECKS) > 100
