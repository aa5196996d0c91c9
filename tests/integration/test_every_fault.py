"""Whichever call to the system fails, or is the last of a process that dies, the next plain run gives the same bytes.

The n-th opening, reading, syncing, renaming, linking, making or removing of a file, or the n-th fork, of a writing
command fails, or the process dies there: for every n of each way in which files are written, and for some n of each
command, or for every n where MBCDM_EVERY_FAULT names the commands. Then once more with files that may have only so many
bytes, as on a full disk.
"""

import errno
import os
import random
import resource
import shutil
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
from mbcdm_cad.parallel import forks
from mbcdm_cad.storage import folders
from mbcdm_cad.storage.cache import ENVIRONMENT_VARIABLE, Cache
from mbcdm_cad.storage.folders import Manifest, output_folder, write_from, write_whole
from tests.support.reference import REFERENCE, ROOT
from tests.unit.loop.test_study import RATIO, SHARES, study

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


AIMS = "--aim mass_g:min --aim swing_mrad:min --evaluations 8 --workers 2"
EXPERIMENT = ROOT / "params/experiments/null-short-levels.yaml"
COMMANDS = (
    "build design.yaml --jobs 2",
    "page design.yaml",
    "compare design.yaml --page page.html",
    "picture design.yaml picture.png",
    "export design.yaml --format urdf",
    "export design.yaml --format mjcf --elastic",
    "export design.yaml --format fmu",
    "drawings design.yaml --part guide --jobs 2",
    "pictures design.yaml",
    "prints design.yaml --all",
    "preload design.yaml",
    "sensitivity design.yaml --workers 2",
    "explain design.yaml --graph why.svg",
    "solve design.yaml --apply solved.yaml",
    f"optimise design.yaml {AIMS}",
    f"simulate design.yaml {EXPERIMENT}",
    f"plan design.yaml {EXPERIMENT} --json plan.json",
    "measurement-init r0.csv design.yaml --out drafted.yaml",
    f"loop r0.yaml --ratio {RATIO} --json loop.json --report report --correction correction",
    "trend study.yaml --json trend.json --picture trend.png",
)
ASKED = os.environ.get("MBCDM_EVERY_FAULT", "build preload measurement-init").split()


def command(line: str) -> Callable[[Path], int | None]:
    """A command in the folder; a search goes on, and what was written whole is not written again."""

    def work(out: Path) -> int | None:
        os.chdir(out)
        words = line.split()
        if words[0] == "optimise" and list(out.glob("out/*.jsonl")):
            words.append("--resume")
        refuses = {"trend": ["trend.json"], "measurement-init": ["drafted.yaml"]}.get(words[0], [])
        return 0 if refuses and all(map(os.path.exists, refuses)) else cli.run(words)

    return work


def run(work: Callable[[Path], Any], out: Path, n: int | None, dies: bool, most_bytes: int = -1) -> int:
    """Exit code of a process in which the ``n``-th call fails, or is the last."""
    if child := os.fork():
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    calls = count(1)
    left = True
    ours = (str(out), os.environ[ENVIRONMENT_VARIABLE])

    def strike(event: str, arguments: tuple[Any, ...]) -> None:
        nonlocal left
        if n is None or event not in EVENTS:
            return
        named = event == "os.fork" or isinstance(arguments[0], str | bytes | os.PathLike)
        path = out if event == "os.fork" else os.path.abspath(os.fsdecode(arguments[0])) if named else ""
        if str(path).startswith(ours) and next(calls) == n:
            left = False
            if dies:
                os._exit(DIED)
            raise OSError(errno.ENOSPC, "No space left on device", str(path))

    fsync = os.fsync
    os.fsync = lambda number: (strike("open", (str(out),)), fsync(number))[1]
    forks.allow_processes()
    code = 70
    try:
        for number, name in enumerate((os.devnull, os.devnull, str(out.with_name("said")))):
            os.dup2(os.open(name, os.O_RDWR | os.O_CREAT | os.O_TRUNC), number)
        sys.stdout, sys.stderr = sys.__stdout__, sys.__stderr__
        sys.addaudithook(strike)
        if most_bytes >= 0:
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))
        done = work(out)
        code = done if isinstance(done, int) else 0
    except (MbcdmError, OSError):
        code = 2
    finally:
        if n == 0:
            out.with_name("calls").write_text(str(next(calls) - 1))
        os._exit(NO_CALL_LEFT if n and left else code)


def content(out: Path) -> dict[str, bytes]:
    return {str(path.relative_to(out)): path.read_bytes() for path in sorted(out.rglob("*")) if path.is_file()}


@pytest.mark.slow
@pytest.mark.parametrize("name", [*CASES, *(line for line in COMMANDS if line.split()[0] in ASKED)])
def test_the_next_run_puts_everything_right(name: str, tmp_path: Path) -> None:
    work = CASES.get(name) or command(name)

    def fresh(where: object) -> Path:
        out = tmp_path / str(where) / "out"
        out.mkdir(parents=True)
        if name in COMMANDS:
            study(out, SHARES, "differs: [ratio_error]")
            if name.split()[0] not in ("solve", "optimise"):
                (out / "design.yaml").write_bytes(REFERENCE.read_bytes())
            return out
        (out / "drive.yaml").write_text("a design")
        if name.startswith("folder"):
            folder(out, b"old")
            (out / "drive" / "own.txt").write_text("the user's")
        if name == "files":
            (out / "a.txt").write_text("old")
        return out

    whole = fresh("whole")
    before = content(whole)
    assert run(work, whole, None, False) == 0, whole.with_name("said").read_text()
    after = content(whole)
    counted = fresh("counted")
    assert run(work, counted, 0, False) == 0
    calls = range(1, int(counted.with_name("calls").read_text()) + 1)
    if name in COMMANDS and "MBCDM_EVERY_FAULT" not in os.environ:
        calls = sorted(random.Random(name).sample(calls, min(2, len(calls))))
    faults = [(n, dies, -1) for dies in (False, True) for n in calls]
    faults += [(None, False, size) for size in ((700,) if name in COMMANDS else (0, 1, 100, 700, 1900))]
    for fault in faults:
        out = fresh(fault)
        code = run(work, out, *fault)
        assert code in (0, 2, NO_CALL_LEFT, DIED), (fault, code, out.with_name("said").read_text())
        if code == 2 and name.startswith(("folder", "files")):
            assert {file: data for file, data in content(out).items() if file in before} == before, fault
        if code == DIED and name == "files":
            write_whole({out / "deep" / "other.txt": b""})
            (out / "deep" / "other.txt").unlink()
            seen = {file: data for file, data in content(out).items() if not Path(file).name.startswith(".")}
            assert seen in (before, after), fault
        assert run(work, out, None, False) == 0, (fault, out.with_name("said").read_text())
        assert content(out) == after, fault
        shutil.rmtree(out)
