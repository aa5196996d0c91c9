"""Fixtures of the layout's tests."""

from __future__ import annotations

import pytest

from mbcdm_cad.configurations.miso_bevel.layout import Layout, layout
from mbcdm_cad.design.drive import Drive

from .designs import reference


@pytest.fixture(scope="session")
def drive() -> Drive:
    """The reference design's drive."""
    return reference()


@pytest.fixture(scope="session")
def dims(drive: Drive) -> Layout:
    """The reference design's layout."""
    return layout(drive)
