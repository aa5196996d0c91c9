"""The reference design's layout."""

from __future__ import annotations

from pathlib import Path

import pytest

from mbcdm_cad.design import load_design
from mbcdm_cad.layout.layout import Layout, layout

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="session")
def dims() -> Layout:
    """Layout of params/mbcdm.yaml."""
    return layout(load_design(ROOT / "params" / "mbcdm.yaml").drive)
