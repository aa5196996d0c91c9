"""The gallery: its page in docs, and the text and figures that it takes from a file."""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.report.checks_page import checks_page
from mbcdm_cad.report.gallery_page import GalleryDrive

ROOT = Path(__file__).parents[3]
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
def page(drives: list[Drive]) -> str:
    return checks_page(drives)


def test_page_in_docs_is_up_to_date(page: str) -> None:
    """Write it anew with: make docs."""
    assert (ROOT / "docs" / "checks.md").read_text("utf-8") == page


def test_each_check_of_each_layout_stands_once_in_its_column(page: str, drives: list[Drive]) -> None:
    tables, _ = page.split("## Checks of the build")
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in tables.splitlines() if line.startswith("| `")]
    for column, drive in enumerate(drives, start=3):
        found = sorted(row[0].split("`")[1] for row in rows if row[column])
        assert found == sorted(layout_of(drive).checks_by_id()), drive.name
        assert len(found) > 100
