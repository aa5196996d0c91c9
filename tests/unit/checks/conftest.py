"""Make the helper modules of this folder importable, and provide the reference drive."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from designs import reference

from mbcdm_cad.design.drive import Drive


@pytest.fixture
def drive() -> Drive:
    """The drive of the reference design."""
    return reference()
