"""Fixtures of the tests of this layout."""

import pytest

from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout

from .designs import reference


@pytest.fixture(scope="session")
def drive() -> BevelDrive:
    """The reference design's drive."""
    return reference()


@pytest.fixture(scope="session")
def dims(drive: BevelDrive) -> BevelLayout:
    """The reference design's layout."""
    return BevelLayout(drive)
