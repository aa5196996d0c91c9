"""Keys: equal for equal content, different for any other content."""

from __future__ import annotations

import math
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbcdm_cad.storage import cache
from mbcdm_cad.storage.cache import canonical_json, content_key, source_hash

VERSIONS = {"cadquery": "2.8.0"}


@dataclass(frozen=True)
class Disc:
    radius_mm: float
    holes: tuple[float, ...] = ()


@dataclass(frozen=True)
class Ring:
    radius_mm: float
    holes: tuple[float, ...] = ()


def test_anything_that_changes_changes_the_key() -> None:
    disc = Disc(3.0, (0.1, 0.2))
    cases = [
        ("part", disc, "s", VERSIONS),
        ("mesh", disc, "s", VERSIONS),
        ("part", replace(disc, radius_mm=math.nextafter(3.0, 4.0)), "s", VERSIONS),
        ("part", replace(disc, holes=(0.2, 0.1)), "s", VERSIONS),
        ("part", Ring(3.0, (0.1, 0.2)), "s", VERSIONS),
        ("part", disc, "t", VERSIONS),
        ("part", disc, "s", {"cadquery": "2.8.1"}),
        ("part", {1: "a"}, "s", VERSIONS),
        ("part", {"1": "a"}, "s", VERSIONS),
        ("part", [None], "s", VERSIONS),
        ("part", [False], "s", VERSIONS),
        ("part", [0], "s", VERSIONS),
    ]
    keys = [content_key(*case) for case in cases]
    assert len(set(keys)) == len(cases)
    assert keys == [content_key(*case) for case in cases]


@given(st.dictionaries(st.text(), st.floats(allow_nan=False, allow_infinity=False)))
def test_order_of_a_mapping_does_not_matter(data: dict[str, float]) -> None:
    assert canonical_json(data) == canonical_json(dict(reversed(data.items())))


def test_arrays_are_their_numbers() -> None:
    assert canonical_json(np.array([[1.0, 0.1]])) == canonical_json([[1.0, 0.1]])
    assert canonical_json(np.float64(0.1)) == canonical_json(0.1)


def test_what_has_no_lasting_text_is_refused() -> None:
    with pytest.raises(TypeError, match="object is not plain data"):
        canonical_json([object()])
    with pytest.raises(TypeError, match="set is not plain data"):
        canonical_json({1, 2})
    with pytest.raises(ValueError, match="Out of range float"):
        canonical_json(math.nan)


def test_key_is_the_same_in_another_process() -> None:
    code = "from mbcdm_cad.storage.cache import content_key; print(content_key('part', {'b': 1, 'a': [0.1]}, 's', {}))"
    root = Path(__file__).parents[3]
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=root)
    assert done.stdout.strip() == content_key("part", {"a": [0.1], "b": 1}, "s", {})


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A package with every form of import; ``aside`` is imported by nobody."""
    files = {
        "__init__.py": "",
        "drum.py": "import os\nfrom mbcdm_cad.shapes import disc\ndef f():\n    from . import late\n",
        "late.py": "",
        "aside.py": "",
        "shapes/__init__.py": "from .rounds import disc",
        "shapes/rounds.py": "from ..numbers import (\n    tables,\n)",
        "numbers/tables.py": "import mbcdm_cad.deep.down\nfrom mbcdm_cad import nowhere",
        "deep/down.py": "",
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    monkeypatch.setattr(cache, "_ROOT", tmp_path)
    yield tmp_path
    _forget()


def _forget() -> None:
    for cached in (cache.source_hash, cache._imports, cache._path):
        cached.cache_clear()


def fresh_hash(*modules: str) -> str:
    _forget()
    return source_hash(*modules)


@pytest.mark.parametrize(
    ("changed", "matters"),
    [
        ("__init__.py", True),
        ("drum.py", True),
        ("late.py", True),
        ("shapes/__init__.py", True),
        ("shapes/rounds.py", True),
        ("numbers/tables.py", True),
        ("deep/down.py", True),
        ("aside.py", False),
    ],
)
def test_only_what_is_imported_matters(package: Path, changed: str, matters: bool) -> None:
    before = fresh_hash("mbcdm_cad.drum")
    assert fresh_hash("mbcdm_cad.drum") == before
    with (package / changed).open("a") as stream:
        stream.write("\n# another\n")
    assert (fresh_hash("mbcdm_cad.drum") != before) == matters, changed


def test_unknown_module_is_refused() -> None:
    assert len(source_hash("mbcdm_cad.storage.cache")) == 64
    for name in ("mbcdm_cad.no_such_part", "no_such_package", "no_such_package.part"):
        with pytest.raises(ValueError, match="no module"):
            source_hash(name)


def test_a_module_of_another_package_counts_with_those_of_its_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    (folder / "__init__.py").write_text("")
    (folder / "sizes.py").write_text("WIDTH = 1.0\n")
    (folder / "other.py").write_text("")
    (folder / "draw.py").write_text("import json\nfrom elsewhere.sizes import WIDTH\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    before = fresh_hash("elsewhere.draw")
    (folder / "other.py").write_text("# not imported\n")
    assert fresh_hash("elsewhere.draw") == before
    (folder / "sizes.py").write_text("WIDTH = 2.0\n")
    assert fresh_hash("elsewhere.draw") != before
