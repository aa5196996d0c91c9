"""Text follows the terminal: its width, and whether it has colours."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from mbcdm_cad import cli
from mbcdm_cad.cli.screen import coloured

SHORT = Path(__file__).parents[3] / "params" / "mbcdm-short.yaml"


class Terminal:
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        """Always."""
        return True


@pytest.mark.parametrize(("term", "expected"), [("xterm-256color", True), ("dumb", False)])
def test_a_terminal_without_colours_gets_none(monkeypatch: pytest.MonkeyPatch, term: str, expected: bool) -> None:
    monkeypatch.setattr(sys, "stdout", Terminal())
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("TERM", term)
    assert coloured() is expected


@pytest.mark.parametrize("field", [(), ("support.back_y_mm",)])
@pytest.mark.parametrize("width", [60, 80, 120, 160])
def test_explain_keeps_to_the_width(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], width: int, field: tuple[str, ...]
) -> None:
    words = {}
    for columns in (None, width):
        if columns is not None:
            monkeypatch.setenv("COLUMNS", str(columns))
        assert cli.run(["explain", str(SHORT), *field]) == 0
        words[columns] = capsys.readouterr().out
    longest = max(words[width].splitlines(), key=len)
    assert len(longest) <= width, f"{len(longest)} characters: {longest}"
    assert words[None].split() == words[width].split(), "wrapping loses words"
