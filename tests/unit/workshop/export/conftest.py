"""The samples as fixtures."""

import sys
from pathlib import Path

import cadquery as cq
import pytest

from mbcdm_cad.parts.bill import Item

sys.path.insert(0, str(Path(__file__).parent))  # the tests are no package: this is how they find their samples

from export_samples import make_items, make_solids


@pytest.fixture(scope="session")
def solids() -> dict[str, cq.Solid]:
    return make_solids()


@pytest.fixture
def items() -> list[Item]:
    return make_items()
