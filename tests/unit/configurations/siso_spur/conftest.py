"""The reference design of siso_spur, as its schema writes it."""

from __future__ import annotations

import pytest

from mbcdm_cad.configurations.loader import load_text, new_design_text
from mbcdm_cad.configurations.siso_spur.drive import SpurDrive, spur
from mbcdm_cad.configurations.siso_spur.layout import SpurLayout, layout


@pytest.fixture(scope="session")
def drive() -> SpurDrive:
    """Its drive."""
    return spur(load_text(new_design_text("siso_spur", "siso_spur")).drive)


@pytest.fixture(scope="session")
def dims(drive: SpurDrive) -> SpurLayout:
    """Its dimensions."""
    return layout(drive)
