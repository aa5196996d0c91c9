"""Whichever call to the system fails, or is the last of a process that dies, the next plain run gives the same bytes.

The n-th opening, reading, syncing, renaming, linking, making or removing of a file of a writing command fails, or the
process dies there, for every n; then once more with files that may have only so many bytes, as on a full disk.
"""

import errno
import os
import resource
import signal
import sys
from collections.abc import Callable
from itertools import count
from pathlib import Path
from typing import Any

import pytest

from mbcdm_cad import cli
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.optimising.search import Journal, sole_search
from mbcdm_cad.storage import folders
from mbcdm_cad.storage.cache import Cache
from mbcdm_cad.storage.folders import Manifest, output_folder, write_from, write_whole

DIED, NO_CALL_LEFT = 9, 99
EVENTS = {"open", "os.rename", "os.link", "os.mkdir", "os.remove", "os.rmdir", "os.listdir", "os.scandir", "os.fork"}
FILES = {"a.txt": b"one", "deep/b.txt": bytes(2000)}


def folder(out: Path, content: bytes = b"new") -> None:
    """As ``mbcdm build`` writes, with a file of the user's own in it."""
    with output_folder(out / "drive", Manifest("d", content.decode()), design=out / "drive.yaml") as made:
        for name in ("x", "deep/y"):
            made.write(name, content * 500)


def folder_without_exchange(out: Path) -> None:
    """As on systems that cannot exchange two folders in one step."""
    folders._exchange = lambda first, second: False  # in a process of its own
    folder(out)


def journal(out: Path) -> None:
    """As ``mbcdm optimise`` keeps its points."""
    path = out / "drive.jsonl"
    with sole_search(path), Journal(path, {"request": 1}, resume=path.exists()) as kept:
        for n in range(len(kept.records), 3):
            kept.add({"point": n, "text": "x" * 200})
        kept.keep()


def cache(out: Path) -> None:
    """Never fails itself: a result is made anew."""
    kept = Cache(out, limit_bytes=10_000)
    for n in range(2):
        assert kept.get_or_make(f"{n:064x}", lambda: {"x": bytes(500)}) == {"x": bytes(500)}


CASES: dict[str, Callable[[Path], Any]] = {
    "folder": folder,
    "folder without exchange": folder_without_exchange,
    "folder of many commands": lambda out: write_from(out / "drive.yaml", out / "drive-prints", FILES),
    "files": lambda out: write_whole({out / name: data for name, data in FILES.items()}),
    "journal": journal,
    "cache": cache,
    "init": lambda out: None if (out / "n.yaml").exists() else cli.run(["init", str(out / "n.yaml"), "--reference"]),
}


def run(work: Callable[[Path], Any], out: Path, n: int | None, dies: bool, most_bytes: int = -1) -> int:
    """Exit code of a process in which the ``n``-th call fails, or is the last."""
    if child := os.fork():
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    calls = count(1)
    left = True

    def strike(event: str, arguments: tuple[Any, ...]) -> None:
        nonlocal left
        if n is not None and event in EVENTS and str(out) in str(arguments[:1]) and next(calls) == n:
            left = False
            if dies:
                os._exit(DIED)
            raise OSError(errno.ENOSPC, "No space left on device", str(arguments[0]))

    fsync = os.fsync
    os.fsync = lambda number: (strike("open", (str(out),)), fsync(number))[1]
    code = 70
    try:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        sys.addaudithook(strike)
        if most_bytes >= 0:
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))
        done = work(out)
        code = done if isinstance(done, int) else 0
    except (MbcdmError, OSError):
        code = 2
    finally:
        os._exit(NO_CALL_LEFT if n is not None and left else code)


def content(out: Path) -> dict[str, bytes]:
    return {str(path.relative_to(out)): path.read_bytes() for path in sorted(out.rglob("*")) if path.is_file()}


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_the_next_run_puts_everything_right(name: str, tmp_path: Path) -> None:
    work = CASES[name]

    def fresh(where: str) -> Path:
        out = tmp_path / where / "out"
        out.mkdir(parents=True)
        (out / "drive.yaml").write_text("a design")
        if name.startswith("folder"):
            folder(out, b"old")
            (out / "drive" / "own.txt").write_text("the user's")
        return out

    whole = fresh("whole")
    before = content(whole)
    assert run(work, whole, None, False) == 0
    after = content(whole)
    faults = [(n, dies, -1) for dies in (False, True) for n in range(1, 200)]
    faults += [(None, False, size) for size in (0, 1, 100, 700, 1900)]
    ended = set()
    for n, dies, most in faults:
        if (dies, "over") in ended:
            continue
        out = fresh(f"{n} {dies} {most}")
        code = run(work, out, n, dies, most)
        if code == NO_CALL_LEFT:
            ended.add((dies, "over"))
        else:
            assert code in ((DIED,) if dies else (0, 2)), (n, dies, most, code)
        if "folder" in name and not dies and code == 2:
            assert {file: data for file, data in content(out).items() if file in before} == before, (n, most)
        assert run(work, out, None, False) == 0
        assert content(out) == after, (n, dies, most)
    assert {(False, "over"), (True, "over")} <= ended
