"""Compiled code is not used after its sources change."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from mbcdm_cad.storage import compiled

ROOT = Path(__file__).parents[3]
CALLED = "from mbcdm_cad.storage.compiled import compiled\n\n\n@compiled\ndef called(x):\n    return {} * x\n"
CALLER = (
    "from mbcdm_cad.storage.compiled import compiled\nfrom called import called\n\n\n"
    "@compiled\ndef caller(x):\n    return called(x)\n"
)


@pytest.fixture
def sources(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of two compiled functions in two files and of a third file."""
    (tmp_path / "called.py").write_text(CALLED.format("2.0"))
    (tmp_path / "caller.py").write_text(CALLER)
    (tmp_path / "other.py").write_text("a = 1\n")
    monkeypatch.setattr(compiled, "_ROOT", tmp_path)
    return tmp_path


def folder() -> Path:
    compiled.machine_code_folder.cache_clear()
    try:
        return compiled.machine_code_folder()
    finally:
        compiled.machine_code_folder.cache_clear()


def test_only_a_change_of_a_compiled_source_gives_another_folder(sources: Path) -> None:
    before = folder()
    (sources / "other.py").write_text("a = 2\n")
    assert folder() == before, "no compiled function has changed"
    (sources / "called.py").write_text(CALLED.format("3.0"))
    assert folder() != before


def test_folders_of_other_sources_go_after_a_day(sources: Path) -> None:
    old, young, own = (sources / "__pycache__" / name for name in ("numba-old", "numba-young", folder().name))
    for path, age_s in ((old, 90_000.0), (young, 60.0), (own, 90_000.0)):
        path.mkdir(parents=True)
        os.utime(path, (time.time() - age_s,) * 2)
    folder()
    assert [path.exists() for path in (old, young, own)] == [False, True, True]


@pytest.mark.slow
@pytest.mark.skipif(not compiled.COMPILED, reason="numba is not installed")
def test_a_changed_function_is_seen_by_those_that_call_it(sources: Path) -> None:
    code = (
        "import sys; from pathlib import Path; from mbcdm_cad.storage import compiled as c;"
        f"c._ROOT = Path({str(sources)!r}); sys.path.insert(0, str(c._ROOT));"
        "from caller import caller; print(caller(1.0))"
    )

    def answer() -> float:
        done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
        return float(done.stdout)

    assert answer() == 2.0
    assert any(sources.glob("__pycache__/numba-*/**/*.nbc")), "nothing was kept: the test shows nothing"
    (sources / "called.py").write_text(CALLED.format("3.0"))
    assert answer() == 3.0
