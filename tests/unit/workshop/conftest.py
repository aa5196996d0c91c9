"""BevelLayout and solids of the reference design, drawn once."""

from typing import Any

import pytest

from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.layouts.miso_bevel.bill import bill
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.parts.bill import CABLE
from tests.support.reference import ROOT


@pytest.fixture(scope="session")
def dims() -> BevelLayout:
    """BevelLayout of params/mbcdm.yaml."""
    return BevelLayout(load_design(ROOT / "params" / "mbcdm.yaml").drive)


@pytest.fixture(scope="session")
def solids(dims: BevelLayout) -> dict[str, Any]:
    """Part name to solid, the cables left out: the interference run draws them itself."""
    parts = bill(dims).parts
    return {name: spec.part.solid() for name, spec in parts.items() if not name.startswith(CABLE)}
