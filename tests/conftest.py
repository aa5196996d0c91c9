"""What holds for all tests."""

from __future__ import annotations

import pytest


@pytest.fixture(autouse=True)
def no_screen(monkeypatch: pytest.MonkeyPatch) -> None:
    """Text is not wrapped unless a test says how wide its screen is, whatever the shell or the test runner says."""
    monkeypatch.delenv("COLUMNS", raising=False)
