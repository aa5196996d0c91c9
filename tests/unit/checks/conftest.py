"""The reference drive."""

import pytest

from mbcdm_cad.design.drive import Drive
from tests.unit.checks.designs import reference


@pytest.fixture
def drive() -> Drive:
    """The drive of the reference design."""
    return reference()
