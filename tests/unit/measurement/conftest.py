"""The fixture ``write``: a small measured run on disk that each test changes."""

from pathlib import Path

import pytest

from tests.unit.measurement.sound_runs import Write, writer


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Writes run.csv and run.yaml."""
    return writer(tmp_path)
