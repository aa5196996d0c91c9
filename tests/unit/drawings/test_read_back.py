"""Each drawing, read from its DXF alone, gives the part; without any one of its dimensions it does not."""

from __future__ import annotations

from pathlib import Path

import cadquery as cq
import pytest

from mbcdm_cad.drawings.draw import PartFacts, draw_sheet
from mbcdm_cad.layouts.loader import layout_of, load_design
from tests.support.drawing_reader import DoubledDimensionError, MissingDimensionError, dimensions, document
from tests.support.rebuilt import SMALL, turned

pytestmark = pytest.mark.slow
ROOT = Path(__file__).parents[3]
# Lengths are printed to a hundredth or a thousandth of a millimetre; a small part feels that most.
_VOLUME_ERROR = 2e-3


@pytest.fixture(scope="module")
def parts() -> dict[str, tuple[cq.Solid, bytes]]:
    """Solid and DXF of the parts that are rebuilt."""
    drive = load_design(ROOT / "params" / "mbcdm.yaml").drive
    specs = layout_of(drive).bill().parts
    made = {}
    for name in SMALL:
        spec = specs[name]
        solid = spec.part.solid()
        sheet = spec.part.sheet(name)
        made[name] = (solid, draw_sheet(sheet, solid, PartFacts("mbcdm", "metal", 1.0, "0", 0.02))["dxf"])
    return made


@pytest.mark.parametrize("name", SMALL)
def test_the_drawing_makes_the_part(parts: dict[str, tuple[cq.Solid, bytes]], name: str) -> None:
    solid, data = parts[name]
    doc = document(data)
    assert SMALL[name](doc, dimensions(doc)) == pytest.approx(solid.Volume(), rel=_VOLUME_ERROR)


@pytest.mark.parametrize("name", SMALL)
def test_without_any_one_dimension_it_does_not(parts: dict[str, tuple[cq.Solid, bytes]], name: str) -> None:
    solid, data = parts[name]
    doc = document(data)
    dims = dimensions(doc)
    for missing in dims:
        rest = [d for d in dims if d is not missing]
        try:
            volume = SMALL[name](doc, rest)
        except (MissingDimensionError, ValueError, IndexError, StopIteration):
            continue
        error = abs(volume / solid.Volume() - 1.0)
        assert error > _VOLUME_ERROR, f"{missing.prefix}{missing.value} in {missing.view} is not needed: {error:.2g}"


@pytest.mark.parametrize("name", SMALL)
def test_a_dimension_said_twice_is_found(parts: dict[str, tuple[cq.Solid, bytes]], name: str) -> None:
    if SMALL[name] is not turned:
        pytest.skip("only where the outline says which dimensions there can be")
    doc = document(parts[name][1])
    dims = dimensions(doc)
    for doubled in dims:
        if "45" in doubled.suffix:
            continue
        with pytest.raises(DoubledDimensionError):
            turned(doc, [*dims, doubled])
