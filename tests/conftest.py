"""What holds for all tests."""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest

from mbcdm_cad.storage.cache import ENVIRONMENT_VARIABLE


@pytest.fixture(autouse=True)
def no_screen(monkeypatch: pytest.MonkeyPatch) -> None:
    """Text is not wrapped unless a test says how wide its screen is, whatever the shell or the test runner says."""
    monkeypatch.delenv("COLUMNS", raising=False)


@pytest.fixture(scope="session", autouse=True)
def shared_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """One cache for all tests of a run that name none of their own, in all its processes: each part is drawn once.

    It is the run's own unless the environment names one, as ``.ci/run`` does with the cache of the main job.
    """
    folder = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        folder = folder.parent
    with pytest.MonkeyPatch.context() as patch:
        if not os.environ.get(ENVIRONMENT_VARIABLE):
            patch.setenv(ENVIRONMENT_VARIABLE, str(folder / "cache"))
        yield
