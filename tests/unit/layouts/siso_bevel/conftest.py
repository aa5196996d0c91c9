"""The reference design of siso_bevel, as its schema writes it."""

import pytest

from mbcdm_cad.layouts.loader import load_text, new_design_text
from mbcdm_cad.layouts.siso_bevel.design_file import DirectDrive
from mbcdm_cad.layouts.siso_bevel.layout import DirectLayout


@pytest.fixture(scope="session")
def drive() -> DirectDrive:
    """Its drive."""
    return load_text(new_design_text("siso_bevel", "siso_bevel")).drive


@pytest.fixture(scope="session")
def dims(drive: DirectDrive) -> DirectLayout:
    """Its dimensions."""
    return DirectLayout(drive)
