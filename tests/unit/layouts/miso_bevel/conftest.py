"""Fixtures of the tests of this layout."""

from __future__ import annotations

import pytest

from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive
from mbcdm_cad.layouts.miso_bevel.layout import Layout, layout

from .designs import reference


@pytest.fixture(scope="session")
def drive() -> BevelDrive:
    """The reference design's drive."""
    return reference()


@pytest.fixture(scope="session")
def dims(drive: BevelDrive) -> Layout:
    """The reference design's layout."""
    return layout(drive)
