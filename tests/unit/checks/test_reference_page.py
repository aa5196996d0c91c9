"""docs/checks.md is what the registry says."""

from __future__ import annotations

from pathlib import Path

from mbcdm_cad.checks.reference import checks_page
from mbcdm_cad.checks.registry import CHECKS, known_ids
from mbcdm_cad.design import load_design

ROOT = Path(__file__).parents[3]


def test_page_in_docs_is_up_to_date() -> None:
    """Write it anew with: python -m mbcdm_cad.checks.reference > docs/checks.md."""
    page = checks_page(load_design(ROOT / "params" / "mbcdm.yaml").drive)
    assert (ROOT / "docs" / "checks.md").read_text("utf-8") == page


def test_page_names_every_check() -> None:
    page = checks_page(load_design(ROOT / "params" / "mbcdm.yaml").drive)
    assert all(f"| `{name}`" in page for name in known_ids())
    assert len(CHECKS) > 100
