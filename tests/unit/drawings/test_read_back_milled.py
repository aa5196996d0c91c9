"""Frames, motor heads and drum from their drawings alone; this fails without any one dimension, or with one twice."""

from __future__ import annotations

from math import pi
from pathlib import Path

import pytest
from ezdxf.document import Drawing

from mbcdm_cad.drawings.draw import PartFacts, draw_sheet
from mbcdm_cad.layouts.loader import layout_of, load_design
from tests.support.drawing_reader import (
    DoubledDimensionError,
    MissingDimensionError,
    ReadDimension,
    dimensions,
    document,
    table,
)
from tests.support.rebuilt import LARGE, OTHERS, SMALL, Rebuild

ROOT = Path(__file__).parents[3]
# Far under the volume of the smallest hole. Corners in which a motor head's bodies meet are a little more than it.
_VOLUME_ERROR, _OF_OTHERS = 1e-4, 5e-4
pytestmark = pytest.mark.slow
Sheets = dict[str, tuple[float, Drawing]]
DESIGNS = {
    "mbcdm": LARGE,
    # Motors above: a plate with boxes, and a frame that holds encoders.
    "gallery/overhead": {"frame": LARGE["frame"], "top_plate": SMALL["top_plate"]},
    "siso_bevel": OTHERS["siso_bevel"],
    "siso_spur": OTHERS["siso_spur"],
    # Its drum has the dowels that hold two sectors together, which no other has.
    "miso_spur": {"frame": OTHERS["miso_spur"]["frame"], "drum": LARGE["drum"]},
}
CASES: dict[str, Rebuild] = {f"{file}/{part}": make for file, parts in DESIGNS.items() for part, make in parts.items()}


@pytest.fixture(scope="module")
def sheets() -> Sheets:
    """Volume of each solid, and its drawing."""
    made = {}
    for file, parts in DESIGNS.items():
        drive = load_design(ROOT / "params" / f"{file}.yaml").drive
        specs = layout_of(drive).bill().parts
        for name in parts:
            spec = specs[name]
            solid = spec.part.solid()
            data = draw_sheet(spec.part.sheet(name), solid, PartFacts(file, "metal", 1.0, "0", 0.02))
            made[f"{file}/{name}"] = (solid.Volume(), document(data["dxf"]))
    return made


@pytest.mark.parametrize("case", CASES)
def test_the_drawing_makes_the_part(sheets: Sheets, case: str) -> None:
    volume, doc = sheets[case]
    error = _VOLUME_ERROR if case.startswith("mbcdm") else _OF_OTHERS
    assert CASES[case](doc, dimensions(doc)) == pytest.approx(volume, rel=error)


@pytest.mark.parametrize("case", CASES)
def test_every_dimension_is_needed_once(sheets: Sheets, case: str) -> None:
    _, doc = sheets[case]
    dims = dimensions(doc)
    assert len(dims) >= 10
    for n, one in enumerate(dims):
        said = f"{one.view}: {one.prefix}{one.value:g}{one.suffix}"
        assert _refused(case, doc, dims[:n] + dims[n + 1 :]), f"{said} is not needed"
        assert _refused(case, doc, [*dims, one]), f"{said} may stand there twice"


def _refused(case: str, doc: Drawing, dims: list[ReadDimension]) -> bool:
    try:
        CASES[case](doc, dims)
    except (MissingDimensionError, DoubledDimensionError, ValueError):
        return True
    return False


def test_a_missing_hole_would_be_seen(sheets: Sheets) -> None:
    volume, doc = sheets["mbcdm/frame"]
    depths = [(float(row[2]), float(row[4])) for row in table(doc, "Holes")[1:] if row[4][0].isdigit()]
    assert min(pi / 4 * d**2 * deep for d, deep in depths) > _VOLUME_ERROR * volume
