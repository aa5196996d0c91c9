"""Compiled code does not outlive the sources it was made from."""

from __future__ import annotations

from pathlib import Path

from mbcdm_cad.storage.compiled import drop_stale


def test_a_changed_source_drops_all_compiled_code(tmp_path: Path) -> None:
    (tmp_path / "called.py").write_text("a = 1\n")
    cache = tmp_path / "__pycache__"
    cache.mkdir()
    code = [cache / "caller.run-1.py311.nbi", cache / "caller.run-1.py311.1.nbc"]

    def compile_again() -> None:
        for path in code:
            path.write_bytes(b"code")

    compile_again()
    assert drop_stale(tmp_path) and not any(path.exists() for path in code), "unknown sources: code is dropped"
    compile_again()
    assert not drop_stale(tmp_path) and all(path.exists() for path in code), "nothing changed: code stays"
    (tmp_path / "called.py").write_text("a = 22\n")
    assert drop_stale(tmp_path) and not any(path.exists() for path in code), "a source changed: code is dropped"
