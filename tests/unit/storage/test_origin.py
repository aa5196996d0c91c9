"""Two design files of one name do not replace each other's output without a word."""

from __future__ import annotations

from pathlib import Path

import pytest

from mbcdm_cad.errors import OutputError
from mbcdm_cad.storage.folders import ORIGIN_NAME, Manifest, output_folder, refuse_other_origin, write_from

FACTS = Manifest("d", "i")


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    """Two design files; their content does not matter here."""
    left, right = tmp_path / "left.yaml", tmp_path / "right.yaml"
    left.write_text("name: drive\n")
    right.write_text("name: drive\n")
    return left, right


def build(target: Path, design: Path, text: str) -> None:
    with output_folder(target, FACTS, design=design) as folder:
        folder.write("report.md", text)


def test_a_second_file_of_the_name_is_refused_and_told_what_to_do(tmp_path: Path, files: tuple[Path, Path]) -> None:
    left, right = files
    target = tmp_path / "out" / "drive"
    build(target, left, "left")
    with pytest.raises(OutputError) as refused:
        build(target, right, "right")
    words = str(refused.value)
    for part in (str(target), str(left), str(right), "change name", "--out"):
        assert part in words, words
    assert (target / "report.md").read_text() == "left"
    build(target, left, "left again")
    assert (target / "report.md").read_text() == "left again"


def test_files_beside_the_build_are_refused_as_well(tmp_path: Path, files: tuple[Path, Path]) -> None:
    left, right = files
    target = tmp_path / "drive-drawings"
    write_from(left, target, {"drum.dxf": b"left"})
    with pytest.raises(OutputError, match="another design file with the same name"):
        write_from(right, target, {"drum.dxf": b"right"})
    assert (target / "drum.dxf").read_bytes() == b"left"


def test_a_file_that_was_renamed_or_a_design_without_a_file_goes_on(tmp_path: Path, files: tuple[Path, Path]) -> None:
    left, right = files
    target = tmp_path / "drive"
    build(target, left, "left")
    refuse_other_origin(target, Path("<drive>"))
    left.unlink()
    build(target, right, "renamed")
    assert (target / "report.md").read_text() == "renamed"


def test_the_record_is_relative_and_moves_with_both(tmp_path: Path, files: tuple[Path, Path]) -> None:
    left, right = files
    here, there = tmp_path / "here", tmp_path / "there"
    here.mkdir()
    left, right = left.rename(here / "left.yaml"), right.rename(here / "right.yaml")
    build(here / "out" / "drive", left, "left")
    assert (here / "out" / "drive" / ORIGIN_NAME).read_text() == "../../left.yaml\n"
    here.rename(there)
    build(there / "out" / "drive", there / "left.yaml", "left")
    with pytest.raises(OutputError):
        build(there / "out" / "drive", there / "right.yaml", "right")


def test_a_folder_from_before_the_record_is_taken_over(tmp_path: Path, files: tuple[Path, Path]) -> None:
    target = tmp_path / "drive"
    with output_folder(target, FACTS) as folder:
        folder.write("report.md", "old")
    build(target, files[1], "new")
    assert (target / "report.md").read_text() == "new"
