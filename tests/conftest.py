"""Settings and fixtures of all tests."""

import gc
import os
import shutil
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

from mbcdm_cad.storage.cache import ENVIRONMENT_VARIABLE

# A busy machine makes any example slow: time is measured in benchmarks/, not here.
settings.register_profile("without a clock", deadline=None)
settings.load_profile("without a clock")


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Where only slow tests run, files without one are not imported: that takes as long as many tests."""
    only_slow = config.getoption("markexpr") == "slow" and collection_path.match("test_*.py")
    return True if only_slow and "mark.slow" not in collection_path.read_text("utf-8") else None


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Files with slow tests first, then those with many: at the end, when a worker may be alone, they are short."""
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    tests = Counter(item.path for item in items)
    items.sort(key=lambda item: (item.path not in slow, -tests[item.path], str(item.path)))


def pytest_collection_finish() -> None:
    """What is imported stays: the collector of garbage need not look through half a million objects again and again."""
    gc.collect()
    gc.freeze()


@pytest.fixture(autouse=True)
def no_screen(monkeypatch: pytest.MonkeyPatch) -> None:
    """Text is not wrapped unless a test says how wide its screen is, whatever the shell or the test runner says."""
    monkeypatch.delenv("COLUMNS", raising=False)


@pytest.fixture
def says(capsys: pytest.CaptureFixture[str]) -> Callable[..., Any]:
    """Runs a command, which must exit with ``code``, and gives what it printed."""
    from mbcdm_cad import cli

    def run(words: list[str], code: int = 0) -> Any:
        found = cli.run(words)
        printed = capsys.readouterr()
        assert found == code, printed
        return printed

    return run


@pytest.fixture(scope="session", autouse=True)
def shared_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """One cache for all tests of a run that name none of their own, in all its processes: each part is drawn once.

    It begins as a copy of the one that the environment names, so what an earlier run of the tests stored is never used.
    """
    folder = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        folder = folder.parent
    cache, named = folder / "cache", os.environ.get(ENVIRONMENT_VARIABLE)
    try:
        cache.mkdir()
    except FileExistsError:
        pass  # another process of this run is before us
    else:
        if named and Path(named).is_dir():
            shutil.copytree(named, cache, dirs_exist_ok=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(ENVIRONMENT_VARIABLE, str(cache))
        yield cache
