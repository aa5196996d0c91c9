"""Comparison of designs: figures that follow from others by definition, and the content of table and JSON."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from mbcdm_cad.jobs.build import ComparisonReport
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.model.stiffness import drum_backlash
from mbcdm_cad.report.comparison import compared, comparison_data, comparison_table, distinct_labels, own_folder
from mbcdm_cad.report.page.stage import charts_under_load, comparison_page

PARAMS = Path(__file__).parents[3] / "params"


def report(**changes: Any) -> dict[str, Any]:
    """What of a report counts."""
    data: dict[str, Any] = {
        "torque": {"peak_positive_Nm": 3.7, "peak_negative_Nm": 3.2, "above_gearhead": "the peak torque is above"},
        "mass": {"mass_g": 400.0},
        "envelope": {"size_mm": [100.0, 50.0, 40.0]},
        "torsion": {"lowest_inputs_held_Hz": 1234.0},
        "bill_of_materials": [
            {"kind": "made", "count": 2},
            {"kind": "made", "count": 1},
            {"kind": "bought", "count": 7},
        ],
        "checks": [
            {"id": "tension", "unit": "times", "limit": 5.0, "margin": 0.5, "status": "pass"},
            {"id": "motor_torque_back", "unit": "N m", "limit": 3.0, "margin": 0.15, "status": "pass"},
            {"id": "motor_losses", "unit": "N m", "limit": 3.0, "margin": -1.0, "status": "warn"},
            {"id": "walls", "unit": "mm", "limit": 1.0, "margin": 0.0, "status": "pass"},
        ],
    }
    return data | changes


def test_figures_follow_from_each_other() -> None:
    drive = load_design(PARAMS / "mbcdm.yaml").drive
    found = compared(drive, report(), 0.28)
    assert found.torque_to_weight_Nm_kg == pytest.approx(3.2 / 0.4)
    assert found.torque_per_volume_Nm_l == pytest.approx(3.2 / 0.2)
    assert found.lowest_mode_Hz == 1234.0
    structure = structure_of(layout_of(drive))
    assert structure is not None
    give = structure.payload_urad_Nm * 1e-6
    assert 1.0 / found.stiffness_Nm_rad == pytest.approx(1.0 / found.cable_stiffness_Nm_rad + give)
    assert (found.made_parts, found.made_kinds, found.bought_parts) == (3, 2, 7)
    # Of strength and torque, what passes nearest to its limit.
    assert (found.tightest_check, found.tightest_margin_share) == ("motor_torque_back", pytest.approx(0.05))
    assert found.toleranced_fits > 20
    assert found.undrawn == 0
    swing = float(drum_backlash(layout_of(drive).si, 0.28).reversal_swing_rad) * 1e3
    assert found.cable_swing_mrad == pytest.approx(swing)
    assert found.swing_mrad == pytest.approx(swing + 2.0 * give * 0.28 * 1e3)


def test_table_has_a_column_a_design_and_json_is_plain() -> None:
    designs = [compared(load_design(PARAMS / name).drive, report(), 0.28) for name in ("mbcdm.yaml", "siso_bevel.yaml")]
    table = comparison_table(designs)
    assert table.columns == ("", "mbcdm", "siso_bevel")
    rows = {row[0]: row[1:] for row in table.rows}
    assert rows["configuration"] == ("miso_bevel", "siso_bevel")
    assert rows["total ratio"] == (pytest.approx(9.0), pytest.approx(4.5))
    assert len({len(line.split("|")) for line in table.markdown()}) == 1
    compared_both = ComparisonReport(tuple(designs))
    for text in (compared_both.text(), compared_both.markdown()):
        assert "mbcdm: the peak torque is above" in text and "siso_bevel: the peak torque is above" in text
    plain = json.loads(json.dumps(comparison_data(designs)))
    assert [design["name"] for design in plain] == ["mbcdm", "siso_bevel"]
    assert plain[1]["box_mm"] == [100.0, 50.0, 40.0]


def test_page_holds_pictures_and_figures_and_needs_no_other_file() -> None:
    drive = load_design(PARAMS / "mbcdm.yaml").drive
    light = compared(drive, report(), 0.28)
    heavy = compared(drive, report(mass={"mass_g": 800.0}), 0.28)
    page = comparison_page([light, heavy], [drive, drive], [b"first", b"second"]).decode()
    assert page.count("data:image/png;base64,") == 2 and "http" not in page.replace("http://www.w3.org", "")
    row = page.split('<th scope="row">mass, g</th>')[1].split("</tr>")[0]
    assert ">400<" in row and "width:50.0%" in row and "width:100.0%" in row, row


def test_load_charts_agree_with_the_swings_of_the_table() -> None:
    drive = load_design(PARAMS / "mbcdm.yaml").drive
    swing = charts_under_load([("one", drive)])["swing"]["lines"][0]
    k = 12
    assert swing["y"][k] == pytest.approx(compared(drive, report(), swing["x"][k]).swing_mrad, rel=1e-4)


def test_designs_of_one_name_are_told_apart() -> None:
    left, right, other = Path("a/left.yaml"), Path("a/right.yaml"), Path("other.yaml")
    assert distinct_labels([("drive", left), ("drive", right), ("other", other)]) == [str(left), str(right), "other"]
    assert distinct_labels([("drive", left), ("drive", left)]) == ["drive 1", "drive 2"]
    assert [own_folder(label) for label in (str(left), "../x y.yaml", "drive 2")] == ["a-left", "x-y", "drive-2"]
