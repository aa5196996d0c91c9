"""The cache: it returns what was stored, also with several processes, and never exceeds its limit.

Keys: equal for equal content, different for any other content.
"""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbcdm_cad.storage import cache, compiled, folders
from mbcdm_cad.storage.cache import Cache, cache_folder, canonical_json, content_key
from mbcdm_cad.storage.folders import aside

ROOT = Path(__file__).parents[3]


def key(number: int) -> str:
    return f"{number:064x}"


def entries(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.glob("*/*"))


@given(st.dictionaries(st.text(max_size=9), st.binary(max_size=200), max_size=4))
def test_what_is_packed_comes_out(blobs: dict[str, bytes]) -> None:
    assert cache._unpacked(cache._packed(blobs)) == blobs


def test_put_and_get(tmp_path: Path) -> None:
    cache = Cache(tmp_path)
    assert cache.get(key(1)) is None
    cache.put(key(1), {"brep": b"\x00\n1", "json": b"{}"})
    assert Cache(tmp_path).get(key(1)) == {"brep": b"\x00\n1", "json": b"{}"}
    assert cache.problem == ""


def test_made_once(tmp_path: Path) -> None:
    cache, made = Cache(tmp_path), []

    def make() -> dict[str, bytes]:
        made.append(1)
        return {"x": b"1"}

    assert [cache.get_or_make(key(1), make) for _ in range(3)] == [{"x": b"1"}] * 3
    assert len(made) == 1


def test_no_cache_makes_every_time() -> None:
    cache, made = Cache(None), []

    def make() -> dict[str, bytes]:
        made.append(1)
        return {"x": b"1"}

    for _ in range(3):
        cache.get_or_make(key(1), make)
    assert len(made) == 3


def test_every_broken_entry_is_seen_and_removed(tmp_path: Path) -> None:
    cache = Cache(tmp_path)
    cache.put(key(1), {"brep": b"some solid", "step": b"some text"})
    path = tmp_path / "00" / key(1)
    whole = path.read_bytes()
    broken = [whole[:n] for n in range(len(whole))]
    broken += [whole[:n] + bytes([whole[n] ^ 1]) + whole[n + 1 :] for n in range(len(whole))]
    for data in broken:
        path.write_bytes(data)
        assert cache.get(key(1)) is None, data
        assert not path.exists()
    assert cache.get_or_make(key(1), lambda: {"x": b"again"}) == {"x": b"again"}


def test_oldest_entries_go_first(tmp_path: Path) -> None:
    cache = Cache(tmp_path, limit_bytes=5000)
    for n in range(4):
        cache.put(key(n), {"x": bytes(1000)})
        os.utime(tmp_path / "00" / key(n), (n, n))
    cache.get(key(0))  # now the newest
    cache.put(key(9), {"x": bytes(1000)})
    assert entries(tmp_path) == sorted(map(key, (0, 2, 3, 9))), "entry 1 was the longest unused"
    size = sum(path.stat().st_size for path in tmp_path.glob("*/*"))
    assert size <= 5000, f"{size} bytes over the limit of 5000"


def test_entry_above_the_limit_is_not_kept(tmp_path: Path) -> None:
    cache = Cache(tmp_path, limit_bytes=500)
    assert cache.get_or_make(key(1), lambda: {"x": bytes(1000)}) == {"x": bytes(1000)}
    assert entries(tmp_path) == []


def test_leftovers_of_dead_processes_go(tmp_path: Path) -> None:
    folder = tmp_path / "00"
    folder.mkdir()
    dead, living = (aside(folder / key(n)).name for n in (1, 2))
    for name, age in ((dead, 7200), (living, 10)):
        (folder / name).write_bytes(b"half")
        os.utime(folder / name, (time.time() - age,) * 2)
    Cache(tmp_path).trim()
    assert entries(tmp_path) == [living]


def test_a_file_that_is_no_entry_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "photos").mkdir()
    (tmp_path / "photos" / "cat.jpg").write_bytes(bytes(9000))
    Cache(tmp_path, limit_bytes=10).put(key(1), {"x": bytes(1000)})
    assert entries(tmp_path) == ["cat.jpg"]


@pytest.mark.parametrize("obstacle", ["file", "full"])
def test_unusable_cache_does_not_stop_anything(tmp_path: Path, obstacle: str, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "cache"
    if obstacle == "file":
        folder.write_text("in the way")
    else:

        def no_room(path: Path, mode: str) -> int:
            raise OSError(28, "No space left on device")

        monkeypatch.setattr(folders, "open", no_room, raising=False)
    cache = Cache(folder)
    assert cache.get_or_make(key(1), lambda: {"x": b"1"}) == {"x": b"1"}
    assert str(folder) in cache.problem
    assert "is not usable" in cache.problem


@pytest.mark.parametrize("bad", ["", "..", "../../etc/passwd", key(1)[:-1], key(1).replace("1", "X")])
def test_a_key_is_a_hash(tmp_path: Path, bad: str) -> None:
    with pytest.raises(ValueError, match="64 hexadecimal digits"):
        Cache(tmp_path).get(bad)


def test_folder_from_the_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MBCDM_CACHE_DIR", str(tmp_path))
    assert cache_folder() == tmp_path
    monkeypatch.delenv("MBCDM_CACHE_DIR")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert cache_folder().name == "mbcdm_cad"


_WORKER = """
import sys
from pathlib import Path
from mbcdm_cad.storage.cache import Cache
cache = Cache(Path(sys.argv[1]), limit_bytes=400_000)
print("ready", flush=True)
for turn in range(int(sys.argv[2])):
    for n in range(8):
        content = bytes([n]) * 20_000
        found = cache.get_or_make(f"{n:064x}", lambda: {"x": content, "y": str(n).encode()})
        assert found == {"x": content, "y": str(n).encode()}, n
        if turn % 3 == 0:
            cache.put(f"{n:064x}", found)
assert not cache.problem, cache.problem
"""


def worker(folder: Path, turns: int) -> subprocess.Popen[str]:
    command = [sys.executable, "-c", _WORKER, str(folder), str(turns)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT)


def test_several_processes_at_once(tmp_path: Path) -> None:
    processes = [worker(tmp_path, 40) for _ in range(4)]
    for process in processes:
        _, errors = process.communicate(timeout=600)
        assert process.returncode == 0, errors
    assert entries(tmp_path) == [key(n) for n in range(8)]


def test_killed_while_writing(tmp_path: Path) -> None:
    for n in range(6):
        process = worker(tmp_path, 100_000)
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        time.sleep(0.01 + 0.007 * n)
        process.send_signal(signal.SIGKILL)
        process.communicate()
        for name in entries(tmp_path):
            if not name.startswith("."):
                assert Cache(tmp_path).get(name) is not None, "a killed process left a broken entry"


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
        ("part", disc),
        ("mesh", disc),
        ("part", replace(disc, radius_mm=math.nextafter(3.0, 4.0))),
        ("part", replace(disc, holes=(0.2, 0.1))),
        ("part", Ring(3.0, (0.1, 0.2))),
        ("part", {1: "a"}),
        ("part", {"1": "a"}),
        ("part", [None]),
        ("part", [False]),
        ("part", [0]),
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
    code = "from mbcdm_cad.storage.cache import content_key; print(content_key('part', {'b': 1, 'a': [0.1]}))"
    root = Path(__file__).parents[3]
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=root)
    assert done.stdout.strip() == content_key("part", {"a": [0.1], "b": 1})


def fresh_key(module: str = "mbcdm_cad") -> str:
    cache.code_hash.cache_clear()
    return content_key("part", [0.1], module)


@pytest.fixture
def program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A program of two files in the place of the package."""
    root = tmp_path / "program"
    (root / "deep").mkdir(parents=True)
    (root / "deep" / "down.py").write_text("WIDTH = 1.0\n")
    (root / "ropes.yaml").write_text("a: 1\n")
    monkeypatch.setattr(cache, "_ROOT", root)
    yield root
    cache.code_hash.cache_clear()


@pytest.mark.parametrize("changed", ["deep/down.py", "ropes.yaml"])
def test_a_key_changes_with_every_file_of_the_program(program: Path, changed: str) -> None:
    before = fresh_key()
    assert fresh_key() == before
    with (program / changed).open("a") as stream:
        stream.write("# another\n")
    assert fresh_key() != before, changed


def test_a_key_changes_with_the_libraries(monkeypatch: pytest.MonkeyPatch) -> None:
    before = content_key("part", [0.1])
    monkeypatch.setattr(cache, "versions", lambda: folders.versions() | {"cadquery": "0.0.1"})
    assert content_key("part", [0.1]) != before


def test_code_of_a_layout_from_elsewhere_counts_with_its_folder(
    program: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    (folder / "sizes.py").write_text("WIDTH = 1.0\n")
    module = ModuleType("elsewhere.draw")
    module.__file__ = str(folder / "draw.py")
    monkeypatch.setitem(sys.modules, "elsewhere.draw", module)
    before, own = fresh_key("elsewhere.draw"), fresh_key()
    assert before != own
    (folder / "sizes.py").write_text("WIDTH = 2.0\n")
    assert fresh_key("elsewhere.draw") != before
    assert fresh_key() == own


# Compiled code is not used after its sources change.


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
