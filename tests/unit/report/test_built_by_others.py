"""Drives that people built: their short files, and the page that shows them."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from benchmarks.studies.built_by_others import page, told

ROOT = Path(__file__).parents[3]
FILES = sorted((ROOT / "params" / "built-by-others").glob("*.yaml"))
PAGE = ROOT / "docs" / "built-by-others.md"


def test_comments_are_what_it_is_what_is_published_and_what_differs() -> None:
    text = "# An arm.\n# Published: 8:1\n# and 3 N m.\nname: arm # 2 m\n# Differs: one stage.\n"
    assert told(text) == {"": "An arm.", "Published": "8:1 and 3 N m.", "Differs": "one stage."}


def test_there_are_ten_drives_the_printed_capstan_and_three_of_new_users() -> None:
    assert len(FILES) == 14, FILES


def test_a_drive_that_is_not_drawn_anew_stays_on_the_page() -> None:
    """The page of no new drive is the page."""
    text = PAGE.read_text("utf-8")
    assert page([], "pictures", text) == text


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_file_is_short_and_says_what_is_published_and_what_differs(path: Path) -> None:
    text = path.read_text("utf-8")
    assert len(text.splitlines()) <= 12, len(text.splitlines())
    assert set(told(text)) - {"Seen"} == {"", "Published", "Differs"}, told(text)
    assert f"name: {path.stem}\n" in text


def test_the_page_has_every_drive_and_a_picture_of_those_that_pass_and_are_not_large() -> None:
    written = PAGE.read_text("utf-8")
    sections = dict(re.findall(r"^## ([\w-]+)\n(.*?)(?=^## |\Z)", written, re.M | re.S))
    assert sorted(sections) == [path.stem for path in FILES]
    assert len(re.findall(r"\]\((pictures/[^)]+)\)", written)) >= 6
    for name, text in sections.items():
        pictures = re.findall(r"\]\((pictures/[^)]+)\)", text)
        fails = re.findall(r"^- `\w+` fails: ", text, re.M)
        assert not (pictures and fails), (name, pictures, fails)
        sizes = [(PAGE.parent / picture).stat().st_size for picture in pictures]
        assert all(4_000 < size < 60_000 for size in sizes), sizes
