"""A design read from the cache is the design read from the file, and costs neither YAML nor schema."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from mbcdm_cad.design import load_design, load_remembered, remembered
from mbcdm_cad.design.template import new_design_text
from mbcdm_cad.errors import InputError
from mbcdm_cad.storage.cache import Cache

PARAMS = Path(__file__).parents[3] / "params" / "mbcdm.yaml"


def files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.is_file())


def test_remembered_design_equals_the_one_read(tmp_path: Path) -> None:
    read = load_design(PARAMS)
    first, second = (load_remembered(PARAMS, Cache(tmp_path)) for _ in range(2))
    assert len(files(tmp_path)) == 1
    assert first == second == read
    assert hash(second.drive) == hash(read.drive)
    assert dict(second.lines) == dict(read.lines)
    assert second.line_of("cables", 2, "step") == read.line_of("cables", 2)
    assert second.design == read.design


def test_without_a_cache_it_is_read_every_time() -> None:
    assert load_remembered(PARAMS, Cache(None)) == load_design(PARAMS)


def test_bad_designs_are_not_remembered(tmp_path: Path) -> None:
    path = tmp_path / "f.yaml"
    path.write_text(new_design_text("trial").replace("34.6 ", "-34.6 "))
    for _ in range(2):
        with pytest.raises(InputError, match="centre_distance_mm: out of bounds"):
            load_remembered(path, Cache(tmp_path / "cache"))
    assert files(tmp_path) == [path]


def test_another_text_or_another_catalogue_has_another_key(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = new_design_text("trial")
    keys = {remembered._key(text), remembered._key(text + "#")}
    copy = tmp_path / "design"
    shutil.copytree(remembered._FOLDER, copy)
    monkeypatch.setattr(remembered, "_FOLDER", copy)
    assert remembered._key(text) in keys
    for name in ("catalogue/ropes.json", "schema.py"):
        with open(copy / name, "a") as file:
            file.write("\n")
        key = remembered._key(text)
        assert key not in keys, f"a change of {name} is not seen"
        keys.add(key)


def test_a_second_start_imports_neither_pydantic_nor_yaml(tmp_path: Path) -> None:
    code = (
        "import sys; from pathlib import Path; from mbcdm_cad.storage.cache import Cache;"
        "from mbcdm_cad.design import load_remembered;"
        f"load_remembered({str(PARAMS)!r}, Cache(Path({str(tmp_path)!r})));"
        "print(sorted({'pydantic', 'yaml', 'numpy'} & set(sys.modules)))"
    )
    outputs = [
        subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=30
        ).stdout.strip()
        for _ in range(2)
    ]
    assert outputs == ["['yaml']", "[]"], "a right file is read without pydantic (plain.py), a known one without YAML"
