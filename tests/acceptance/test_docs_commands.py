"""Run the commands and scripts of the docs unchanged, page by page, in an empty folder with the params.

The word after the language of a code block states its needs: ``build`` and ``loop`` run with the slow tests,
``viewer`` needs a program that the tests do not have and is only compiled.
"""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass
from pathlib import Path

import pytest

from mbcdm_cad.cli import run

ROOT = Path(__file__).parents[2]
PAGES = ("tour.md", *(f"how-to/{path.name}" for path in sorted((ROOT / "docs/how-to").glob("*.md"))))
_BLOCK = re.compile(r"^```(sh|python)(?: (\w+))?\n(.*?)^```$", re.M | re.S)


@dataclass(frozen=True)
class Block:
    """One code block: its language, what it takes, its text."""

    language: str
    takes: str
    text: str


def blocks(page: str) -> list[Block]:
    """Those of a page that can be run, in order."""
    return [Block(m[1], m[2] or "", m[3]) for m in _BLOCK.finditer((ROOT / "docs" / page).read_text("utf-8"))]


def do(block: Block) -> None:
    """Run a block in the current folder. Fails where a command does not end with 0."""
    if block.language == "python":
        code = compile(block.text, "the docs", "exec")
        if block.takes != "viewer":
            exec(code, {})
        return
    for line in block.text.splitlines():
        words = shlex.split(line, comments=True)
        if words:
            assert words[0] == "mbcdm", f"{line}: not a command of ours"
            assert run(words[1:]) == 0, line


@pytest.fixture
def empty(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "params").symlink_to(ROOT / "params")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("page", PAGES)
def test_the_short_blocks_of_a_page_run(page: str, empty: Path) -> None:
    found = [block for block in blocks(page) if block.takes in ("", "viewer")]
    if not found:
        pytest.skip("no code block that can be run")
    for block in found:
        do(block)


@pytest.mark.slow
@pytest.mark.parametrize("page", [page for page in PAGES if any(b.takes in ("build", "loop") for b in blocks(page))])
def test_all_blocks_of_a_page_run(page: str, empty: Path) -> None:
    for block in blocks(page):
        do(block)


def test_the_readme_shows_what_check_prints(empty: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """But for the places where the lines are broken."""
    assert run(["init", "mine.yaml", "--reference"]) == 0
    text = Path("mine.yaml").read_text()
    assert "type: FF-081" in text
    Path("mine.yaml").write_text(text.replace("type: FF-081", "type: 7x7-1.0"))
    capsys.readouterr()
    assert run(["check", "mine.yaml", "--failed"]) == 1
    shown = re.search(r"^```\n(fail .*?)^```$", (ROOT / "README.md").read_text("utf-8"), re.M | re.S)
    assert shown is not None
    assert shown[1].split() == capsys.readouterr().out.split()


def test_a_command_that_fails_fails_this_test(empty: Path) -> None:
    with pytest.raises(AssertionError, match=r"check none\.yaml"):
        do(Block("sh", "", "mbcdm check none.yaml\n"))
