"""The sheet of the whole drive lists each part once, with its number in the bill, and points to where it is seen."""

from __future__ import annotations

from collections import Counter
from itertools import combinations
from math import dist
from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.parts.sheet import Linear, Vector
from mbcdm_cad.workshop.assembly_sheet import SeenBody, assembly_sheet, numbers, pointers
from tests.support.drawing_reader import document, leaders_at_one_point, sections_without_line

ROOT = Path(__file__).parents[3]
_FACES = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))


def _block(number: int, middle: Vector, half: Vector, whole: bool = False, inward: bool = False) -> SeenBody:
    """A box; with ``inward`` a hollow of the body of that number."""
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    corners = np.array(middle) + signs * np.array(half)
    quads = [quad[::-1] if inward else quad for quad in _FACES]
    return SeenBody(number, np.array([corners[list(q)] for a, b, c, d in quads for q in ((a, b, c), (a, c, d))]), whole)


# A housing with a bearing and a screw inside it, a shaft through both, and two plates behind each other.
_HOUSING, _BEARING, _SHAFT, _SCREW, _PLATE, _BEHIND = range(1, 7)
_MADE = {
    _HOUSING: ((0.0, 0.0, 0.0), (20.0, 20.0, 20.0)),
    _BEARING: ((6.0, 0.0, 0.0), (5.0, 10.0, 5.0)),
    _SHAFT: ((6.0, 5.0, 0.0), (2.0, 30.0, 2.0)),
    _SCREW: ((-10.0, 0.0, 0.0), (2.0, 6.0, 2.0)),
    _PLATE: ((0.0, 26.0, -30.0), (19.0, 1.0, 8.0)),
    _BEHIND: ((0.0, 0.0, -30.0), (6.0, 6.0, 6.0)),
}


def _bodies() -> list[SeenBody]:
    hollow = np.concatenate(
        [_block(1, *_MADE[1]).corners_mm, _block(1, (-2.0, 0, 0), (14.0, 12.0, 8.0), inward=True).corners_mm]
    )
    others = [_block(n, *place, whole=n in (_SHAFT, _SCREW)) for n, place in _MADE.items() if n != _HOUSING]
    return [SeenBody(_HOUSING, hollow), *others]


def test_numbers_point_to_where_their_parts_are_seen() -> None:
    seen = pointers(_bodies(), ((-20.0, -25.0, -38.0), (20.0, 35.0, 20.0)))
    assert set(seen.places) == set(_MADE)
    assert seen.places[_BEARING][0].startswith("section"), "a part inside another is seen in a section"
    for number, (view, point) in seen.places.items():
        middle, half = _MADE[number]
        off = max(abs(p - m) - h for p, m, h in zip(point, middle, half, strict=True))
        assert off < 0.2, f"number {number} in {view} points {off:.2f} mm beside its part"
    on_paper = [(v, next(w for w in seen.views if w.name == v).project(p)) for v, p in seen.places.values()]
    for (one, a), (other, b) in combinations(on_paper, 2):
        assert one != other or dist(a, b) > 1.0, (one, a, b)


def test_a_part_that_no_view_shows_is_said_to_be_hidden() -> None:
    inside = [_block(2, (0.0, 0.0, 0.0), (3.0, 3.0, 3.0)), _block(3, (0.0, 0.0, 0.0), (1.0, 1.0, 1.0), whole=True)]
    cube = [_block(1, (0.0, 0.0, 0.0), (9.0, 9.0, 9.0))]
    shell = [_block(n, (x, 0.0, 0.0), (1.0, 5.0, 5.0)) for n, x in ((4, -20.0), (5, 20.0))]
    seen = pointers([*cube, *inside, *shell], ((-21.0, -9.0, -9.0), (21.0, 9.0, 9.0)))
    assert seen.hidden == (), seen
    # A screw is not cut, so no section shows what lies inside it.
    hull = [_block(9, (0.0, 0.0, 0.0), (40.0, 40.0, 40.0), whole=True), _block(8, (0.0, 0.0, 0.0), (5.0, 5.0, 5.0))]
    assert pointers(hull, ((-40.0, -40.0, -40.0), (40.0, 40.0, 40.0))).hidden == (8,)


@pytest.mark.parametrize("thick_mm", [0.2, 0.6])
def test_a_part_thinner_than_the_points_is_found(thick_mm: float) -> None:
    """A shim between blocks of 100 mm, whose points are a third of a millimetre apart; one behind them is hidden."""
    blocks = [_block(n, (0.0, 0.0, s * (25.0 + thick_mm / 2)), (50.0, 10.0, 25.0)) for n, s in ((1, 1), (2, -1))]
    shims = [_block(3, (0.0, 2.0, 0.0), (6.0, 8.0, thick_mm / 2)), _block(4, (20.0, -2.0, 0.0), (4.0, 6.0, 0.01))]
    seen = pointers([*blocks, *shims], ((-50.0, -10.0, -50.0), (50.0, 10.0, 50.0)))
    view, point = seen.places[3]
    assert 3 not in seen.hidden and abs(point[2]) <= thick_mm / 2 and abs(point[0]) <= 6.0, (view, point, seen.hidden)
    assert 4 in seen.hidden, seen


def test_list_of_parts_is_the_bill() -> None:
    drive = load_design(ROOT / "params" / "mbcdm.yaml").drive
    items = layout_of(drive).bill().items
    number = numbers(items)
    bodies = [_block(number[i.part], tuple(i.location.shift_mm), (1.0, 1.0, 1.0)) for i in items]
    envelope = ((-63.0, -14.0, -11.0), (63.0, 20.0, 86.0))
    sheet = assembly_sheet("assembly", items, bodies, envelope, {"nut": "ISO 4032 - M1.6"})
    (table,) = sheet.tables
    assert {row[1]: int(row[2]) for row in table.rows} == Counter(item.part for item in items)
    said = {row[1]: row[3] for row in table.rows}
    assert (said["nut"], said["screw_M2x6"], said["frame"]) == ("ISO 4032 - M1.6", "bought", "aluminium-7075"), said
    assert [label.text for label in sheet.labels] == [row[0] for row in table.rows]
    assert sorted(d.value for d in sheet.dimensions if isinstance(d, Linear)) == [34.0, 97.0, 126.0]


@pytest.mark.slow
def test_drawn_sections_have_lines_and_leaders_their_own_points() -> None:
    import cadquery as cq

    from mbcdm_cad.drawings.draw import PartFacts, draw_sheet
    from mbcdm_cad.parts.bill import Item, Placement

    metal = next(iter(layout_of(load_design(ROOT / "params" / "mbcdm.yaml").drive).bill().items)).material
    items = [Item(f"p{n}", f"p{n}", metal, "made", Placement.identity(), "fixed") for n in _MADE]
    sheet = assembly_sheet("assembly", items, _bodies(), ((-20.0, -25.0, -38.0), (20.0, 35.0, 20.0)), {})
    solids = {n: cq.Workplane().box(*(2 * h for h in half)).translate(at).val() for n, (at, half) in _MADE.items()}
    solids[_HOUSING] = (
        cq.Workplane(obj=solids[_HOUSING]).cut(cq.Workplane().box(28, 24, 16).translate((-2, 0, 0))).val()
    )
    whole = cq.Compound.makeCompound([solids.pop(n) for n in (_SHAFT, _SCREW)])
    drawn = draw_sheet(
        sheet, cq.Compound.makeCompound(list(solids.values())), PartFacts("d", "m", 1.0, "0", 0.02), whole
    )
    doc = document(drawn["dxf"])
    assert not leaders_at_one_point(doc, 1.0)
    assert not sections_without_line(doc)
    hatched = {h.dxf.pattern_angle for b in doc.blocks if b.name.startswith("VIEW_SECTION") for h in b.query("HATCH")}
    assert len(hatched) > 1, "bodies beside each other are hatched differently"
