"""All parts of the reference design, drawn once."""

import cadquery as cq
import pytest

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.layouts.miso_bevel.bill import bill
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.parts.bill import Bill
from tests.support.reference import ROOT


@pytest.fixture(scope="session")
def drive() -> Drive:
    """The drive of params/mbcdm.yaml."""
    return load_design(ROOT / "params" / "mbcdm.yaml").drive


@pytest.fixture(scope="session")
def dims(drive: Drive) -> BevelLayout:
    """Its layout."""
    return BevelLayout(drive)


@pytest.fixture(scope="session")
def centred(dims: BevelLayout) -> Bill:
    """Its bill with the drum centred."""
    return bill(dims)


@pytest.fixture(scope="session")
def solids(centred: Bill) -> dict[str, cq.Solid]:
    """Part name to solid."""
    return {name: spec.part.solid() for name, spec in centred.parts.items()}
