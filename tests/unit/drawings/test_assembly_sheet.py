"""The sheet of the whole drive lists each part once, with its number in the bill."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from mbcdm_cad.build.drawings import assembly_sheet
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.parts.sheets.description import Linear

ROOT = Path(__file__).parents[3]


def test_list_of_parts_is_the_bill() -> None:
    drive = load_design(ROOT / "params" / "mbcdm.yaml").drive
    items = drive.layout.bill().items
    boxes = {item.part: ((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0)) for item in items}
    envelope = ((-63.0, -14.0, -11.0), (63.0, 20.0, 86.0))
    sheet = assembly_sheet("assembly", items, boxes, envelope, {"nut": "ISO 4032 - M1.6"})
    (table,) = sheet.tables
    assert {row[1]: int(row[2]) for row in table.rows} == Counter(item.part for item in items)
    said = {row[1]: row[3] for row in table.rows}
    assert (said["nut"], said["screw_M2x6"], said["frame"]) == ("ISO 4032 - M1.6", "bought", "aluminium-7075"), said
    assert [label.text for label in sheet.labels] == [row[0] for row in table.rows]
    assert sorted(d.value for d in sheet.dimensions if isinstance(d, Linear)) == [34.0, 97.0, 126.0]
