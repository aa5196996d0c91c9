"""Text follows the terminal: its width, and whether it has colours."""

from __future__ import annotations

import sys
from io import StringIO
from pathlib import Path
from time import sleep

import pytest

from mbcdm_cad import cli
from mbcdm_cad.cli import group
from mbcdm_cad.cli.group import coloured, progress_of_trials, sign_of_life

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


class Paper(StringIO, Terminal):  # type: ignore[misc]
    """A terminal that keeps what it shows."""

    isatty = Terminal.isatty


def test_what_takes_long_says_so_on_a_terminal_and_nowhere_else(monkeypatch: pytest.MonkeyPatch) -> None:
    """The line comes after the patience, and goes with the answer; what is quick or piped shows nothing."""
    monkeypatch.setattr(group, "_PATIENCE_S", 0.0)
    for stream, shows in ((Paper(), True), (StringIO(), False)):
        monkeypatch.setattr(sys, "stderr", stream)
        with sign_of_life("leg.yaml: sizing"):
            for _ in range(1000):
                if not shows or stream.getvalue():
                    break
                sleep(0.01)
        assert ("leg.yaml: sizing ..." in stream.getvalue()) is shows
        assert stream.getvalue().endswith("\x1b[K" if shows else "")
    monkeypatch.setattr(group, "_PATIENCE_S", 1000.0)
    monkeypatch.setattr(sys, "stderr", quick := Paper())
    with sign_of_life("leg.yaml: sizing"):
        pass
    assert quick.getvalue() == ""


def test_a_search_that_is_piped_says_its_stages_and_how_far_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stderr", piped := StringIO())
    with progress_of_trials() as told:
        for stage, count in (("searching", 1), ("searching", 13), ("searching", 21), ("reducing", 22)):
            told(stage, count)
    assert piped.getvalue().splitlines() == ["1 trials: searching", "21 trials: searching", "22 trials: reducing"]


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
