"""Comparison of designs: figures that follow from others by definition, and the content of table and JSON."""

from __future__ import annotations

import json
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from benchmarks.studies.built_by_others import page, told
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.jobs.build import ComparisonReport
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.model.stiffness import drum_backlash
from mbcdm_cad.report.checks_page import checks_page
from mbcdm_cad.report.comparison import compared, comparison_data, comparison_table, distinct_labels, own_folder
from mbcdm_cad.report.gallery_page import GalleryDrive
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


ROOT = Path(__file__).parents[3]
FILES = sorted((ROOT / "params" / "built-by-others").glob("*.yaml"))
DRIVES_OF_OTHERS = ROOT / "docs" / "built-by-others.md"


def test_comments_are_what_it_is_what_is_published_and_what_differs() -> None:
    text = "# An arm.\n# Published: 8:1\n# and 3 N m.\nname: arm # 2 m\n# Differs: one stage.\n"
    assert told(text) == {"": "An arm.", "Published": "8:1 and 3 N m.", "Differs": "one stage."}


def test_there_are_ten_drives_the_printed_capstan_and_three_of_new_users() -> None:
    assert len(FILES) == 14, FILES


def test_a_drive_that_is_not_drawn_anew_stays_on_the_page() -> None:
    """The page of no new drive is the page."""
    text = DRIVES_OF_OTHERS.read_text("utf-8")
    assert page([], "pictures", text) == text


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_file_is_short_and_says_what_is_published_and_what_differs(path: Path) -> None:
    text = path.read_text("utf-8")
    assert len(text.splitlines()) <= 12, len(text.splitlines())
    assert set(told(text)) - {"Seen"} == {"", "Published", "Differs"}, told(text)
    assert f"name: {path.stem}\n" in text


def test_the_page_has_every_drive_and_a_picture_of_those_that_pass_and_are_not_large() -> None:
    written = DRIVES_OF_OTHERS.read_text("utf-8")
    sections = dict(re.findall(r"^## ([\w-]+)\n(.*?)(?=^## |\Z)", written, re.M | re.S))
    assert sorted(sections) == [path.stem for path in FILES]
    assert len(re.findall(r"\]\((pictures/[^)]+)\)", written)) >= 6
    for name, text in sections.items():
        pictures = re.findall(r"\]\((pictures/[^)]+)\)", text)
        fails = re.findall(r"^- `\w+` fails: ", text, re.M)
        assert not (pictures and fails), (name, pictures, fails)
        sizes = [(DRIVES_OF_OTHERS.parent / picture).stat().st_size for picture in pictures]
        assert all(4_000 < size < 60_000 for size in sizes), sizes


PAGE = ROOT / "docs" / "gallery.md"


@pytest.mark.parametrize(
    ("text", "words", "lines"),
    [
        (
            "# A wrist: thin rope. Everything else follows: mbcdm explain wrist.yaml\nname: a\n\n# b\nc: 1\n",
            "A wrist: thin rope.",
            2,
        ),
        ("# A small joint. mbcdm explain finger.yaml\nname: a\n", "A small joint.", 1),
        ("# Nothing more to say\nname: a\n", "Nothing more to say.", 1),
    ],
)
def test_words_are_the_files_own_first_sentence(text: str, words: str, lines: int) -> None:
    drive = GalleryDrive(cast(Any, SimpleNamespace(text=text)), {}, b"")
    assert (drive.words, drive.lines) == (words, lines)


def test_every_drive_on_the_page_has_its_file_and_its_picture() -> None:
    text = PAGE.read_text("utf-8")
    files = re.findall(r"`(params/gallery/[\w.-]+\.yaml)`:", text)
    pictures = re.findall(r"\]\((pictures/[^)]+)\)", text)
    assert len(files) == len(pictures) >= 12, (len(files), len(pictures))
    assert [name for name in files if not (ROOT / name).is_file()] == []
    sizes = {name: (PAGE.parent / name).stat().st_size for name in pictures}
    assert all(4_000 < size < 200_000 for size in sizes.values()), sizes


# docs/checks.md agrees with the registry.


# As the Makefile names them.
REFERENCES = ("mbcdm", "siso_bevel", "siso_spur", "miso_spur")


@pytest.fixture(scope="module")
def drives() -> list[Drive]:
    return [load_design(ROOT / "params" / f"{name}.yaml").drive for name in REFERENCES]


@pytest.fixture(scope="module")
def page_of(drives: list[Drive]) -> str:
    return checks_page(drives)


def test_page_in_docs_is_up_to_date(page_of: str) -> None:
    """Write it anew with: make docs."""
    assert (ROOT / "docs" / "checks.md").read_text("utf-8") == page_of


def test_each_check_of_each_layout_stands_once_in_its_column(page_of: str, drives: list[Drive]) -> None:
    tables, _ = page_of.split("## Checks of the build")
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in tables.splitlines() if line.startswith("| `")]
    for column, drive in enumerate(drives, start=3):
        found = sorted(row[0].split("`")[1] for row in rows if row[column])
        assert found == sorted(layout_of(drive).checks_by_id()), drive.name
        assert len(found) > 100
