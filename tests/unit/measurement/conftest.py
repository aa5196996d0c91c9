"""The fixture ``write``: a small measured run on disk that each test changes."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
from sound_runs import Write, writer


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Writes run.csv and run.yaml."""
    return writer(tmp_path)
