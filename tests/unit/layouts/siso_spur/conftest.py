"""The reference design of siso_spur, as its schema writes it, and with two anchored cables."""

import pytest

from mbcdm_cad.layouts.loader import load_text, new_design_text
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive, spur
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout


@pytest.fixture(scope="session")
def drive() -> SpurDrive:
    """Its drive."""
    return spur(load_text(new_design_text("siso_spur", "siso_spur")).drive)


@pytest.fixture(scope="session")
def anchored() -> SpurDrive:
    """The same drive with two cables that are anchored on input and drum, all else as it is."""
    text = new_design_text("siso_spur", "siso_spur").replace("cables: continuous", "cables: two_anchored")
    return spur(load_text(text).drive)


@pytest.fixture(scope="session")
def dims(drive: SpurDrive) -> SpurLayout:
    """Its dimensions."""
    return SpurLayout(drive)
