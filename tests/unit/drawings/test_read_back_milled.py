"""Frame and drum sector made from their drawings alone; without any one dimension, or with one twice, they are not."""

from __future__ import annotations

from math import pi
from pathlib import Path

import pytest
from ezdxf.document import Drawing

from mbcdm_cad.configurations.loader import load_design
from mbcdm_cad.configurations.registry import configuration
from mbcdm_cad.drawings.draw import PartFacts, draw_sheet
from mbcdm_cad.parts.make import make
from mbcdm_cad.parts.sheets.lookup import sheet_of
from tests.support.drawing_reader import (
    DoubledDimensionError,
    MissingDimensionError,
    ReadDimension,
    dimensions,
    document,
    table,
)
from tests.support.rebuilt import LARGE

ROOT = Path(__file__).parents[3]
# Far under the volume of the smallest hole.
_VOLUME_ERROR = 1e-4
pytestmark = pytest.mark.slow
Sheets = dict[str, tuple[float, Drawing]]


@pytest.fixture(scope="module")
def sheets() -> Sheets:
    """Volume of each solid, and its drawing."""
    drive = load_design(ROOT / "params" / "mbcdm.yaml").drive
    of = configuration(drive.configuration)
    specs = of.bill(of.layout(drive)).parts
    made = {}
    for name in LARGE:
        spec = specs[name]
        solid = make(spec.maker, spec.args)
        data = draw_sheet(sheet_of(name, spec.maker, spec.args), solid, PartFacts("mbcdm", "metal", 1.0, "0", 0.02))
        made[name] = (solid.Volume(), document(data["dxf"]))
    return made


@pytest.mark.parametrize("name", LARGE)
def test_the_drawing_makes_the_part(sheets: Sheets, name: str) -> None:
    volume, doc = sheets[name]
    assert LARGE[name](doc, dimensions(doc)) == pytest.approx(volume, rel=_VOLUME_ERROR)


@pytest.mark.parametrize("name", LARGE)
def test_every_dimension_is_needed_once(sheets: Sheets, name: str) -> None:
    _, doc = sheets[name]
    dims = dimensions(doc)
    assert len(dims) >= 12
    for n, one in enumerate(dims):
        said = f"{one.view}: {one.prefix}{one.value:g}{one.suffix}"
        assert _refused(name, doc, dims[:n] + dims[n + 1 :]), f"{said} is not needed"
        assert _refused(name, doc, [*dims, one]), f"{said} may stand there twice"


def _refused(name: str, doc: Drawing, dims: list[ReadDimension]) -> bool:
    try:
        LARGE[name](doc, dims)
    except (MissingDimensionError, DoubledDimensionError, ValueError):
        return True
    return False


def test_a_missing_hole_would_be_seen(sheets: Sheets) -> None:
    volume, doc = sheets["frame"]
    depths = [(float(row[2]), float(row[4])) for row in table(doc, "Holes")[1:] if row[4][0].isdigit()]
    assert min(pi / 4 * d**2 * deep for d, deep in depths) > _VOLUME_ERROR * volume
