"""A search that is cut off anywhere goes on and ends with the same bytes, on any number of workers."""

import errno
import hashlib
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import BinaryIO

import numpy as np
import pytest

import mbcdm_cad as mc
from mbcdm_cad.errors import MbcdmError, OutputError
from mbcdm_cad.jobs import outputs as job
from mbcdm_cad.optimising import Effort
from mbcdm_cad.optimising import search as searching
from mbcdm_cad.optimising.evaluate import Evaluated
from mbcdm_cad.optimising.search import FrontSearch, Journal, Searched
from mbcdm_cad.optimising.wishes import Keep, Variable, wishes_of
from mbcdm_cad.parallel import forks
from mbcdm_cad.solving.question import Fixed, Point, Question, question_of
from mbcdm_cad.storage.folders import OutputFolder
from tests.support.loopback import PATIENCE_S, Loopback
from tests.support.optimum import optimum

VARIABLES = [Variable("a", ruled=False), Variable("b", ruled=False), Variable("kind", ("x", "y"))]
WISHES = wishes_of(["mass:min", "swing:min"])


def stand_in(question: Question, point: Point, keeps: Sequence[Keep], names: Sequence[str]) -> Evaluated:
    """A drive of three fields in place of a sized one; designs with a large ``b`` fail a check."""
    a, b, kind = (point[name].value for name in ("a", "b", "kind"))  # type: ignore[union-attr]
    if b > 0.7:
        return Evaluated((("too_large", b),))
    figures = {"mass": 100.0 * (a + 0.3 * b) + (5.0 if kind == "y" else 0.0), "swing": 1.0 / (0.2 + a + b)}
    return Evaluated((), "", figures, {"a": a, "b": b, "kind": kind})


@pytest.fixture(autouse=True)
def _without_designs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(searching, "evaluate", stand_in)
    monkeypatch.setattr(forks, "_allowed", True)


def searched(path: Path, most: int | None = 180, *, resume: bool = False, workers: int = 1) -> Searched:
    with Journal(path, {"request": 1}, resume=resume) as journal:
        found = FrontSearch([None], [VARIABLES], WISHES, journal, lambda words, count: None)  # type: ignore[list-item]
        return found.run(Effort(most, None, workers))


def test_cut_off_at_any_byte_it_goes_on_to_the_same_bytes(tmp_path: Path) -> None:
    whole = searched(tmp_path / "whole.jsonl")
    content = (tmp_path / "whole.jsonl").read_bytes()
    rng = np.random.default_rng(3)
    for size in [0, 5, content.index(b"\n") + 1, *rng.integers(30, len(content), 6).tolist(), len(content)]:
        cut = tmp_path / "cut.jsonl"
        cut.write_bytes(content[:size])
        again = searched(cut, resume=True)
        assert cut.read_bytes() == content, f"cut at byte {size} of {len(content)}"
        assert (again.front, again.curve, again.stopped) == (whole.front, whole.curve, whole.stopped), size


def test_two_workers_and_a_worker_that_is_killed_give_the_same_bytes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    searched(tmp_path / "one.jsonl", 120)
    searched(tmp_path / "two.jsonl", 120, workers=2)
    mark = tmp_path / "killed"

    def dies_once(question: Question, point: Point, *rest: object) -> Evaluated:
        if point.get("kind") == Fixed("y") and not mark.exists():
            mark.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return stand_in(question, point, (), ())

    monkeypatch.setattr(searching, "evaluate", dies_once)
    searched(tmp_path / "three.jsonl", 120, workers=2)
    assert mark.exists(), "no worker was killed"
    one, *others = ((tmp_path / f"{name}.jsonl").read_bytes() for name in ("one", "two", "three"))
    assert others == [one, one]


def test_more_evaluations_go_on_from_those_before(tmp_path: Path) -> None:
    searched(tmp_path / "a.jsonl", 90)
    before = (tmp_path / "a.jsonl").read_bytes()
    longer = searched(tmp_path / "a.jsonl", 150, resume=True)
    assert len(longer.tried) == 150 and (tmp_path / "a.jsonl").read_bytes().startswith(before)


def test_designs_without_a_figure_of_an_aim_are_left_out_and_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    reason = "swing: no figure, no answer"

    def lacks(question: Question, point: Point, *rest: object) -> Evaluated:
        found = stand_in(question, point, (), ())
        return Evaluated(((reason, 1.0),)) if found.passes and point.get("kind") == Fixed("x") else found

    monkeypatch.setattr(searching, "evaluate", lacks)
    found = searched(tmp_path / "a.jsonl", 60)
    assert found.left_out[reason] == sum(one.result.failing == ((reason, 1.0),) for one in found.tried) > 0
    assert reason not in found.failing and {found.tried[row].values["kind"] for row in found.front} == {"y"}


def test_it_ends_when_the_front_no_longer_grows(tmp_path: Path) -> None:
    found = searched(tmp_path / "a.jsonl", None)
    assert "(limit 0.5%)" in found.stopped and found.finished, found.stopped
    assert found.grown is not None and found.grown < 0.005
    volumes = [volume for _, volume in found.curve]
    assert all(after >= before - 1e-12 for before, after in pairwise(volumes)), volumes
    assert set(found.failing) == {"too_large"} and found.failing["too_large"] > 0


def test_the_share_at_which_it_ends_is_asked_for(tmp_path: Path) -> None:
    def length(growth: float) -> int:
        with Journal(tmp_path / f"{growth}.jsonl", {}, resume=False) as journal:
            search = FrontSearch([None], [VARIABLES], WISHES, journal, lambda words, count: None)  # type: ignore[list-item]
            found = search.run(Effort(800, None, 1, growth=growth))
        assert found.grown is not None and (found.grown < growth or len(found.tried) == 800), found.stopped
        return len(found.tried)

    assert length(0.2) < length(0.005) < length(0.0) == 800
    with pytest.raises(MbcdmError, match=r"--growth: not a share \(value 1, limit 0 to 1\)"):
        Effort(growth=1.0)


def test_a_journal_is_neither_lost_nor_mixed_up(tmp_path: Path) -> None:
    searched(tmp_path / "a.jsonl", 50)
    with pytest.raises(OutputError, match=r"50 evaluated points of a search before; add --resume"):
        Journal(tmp_path / "a.jsonl", {"request": 1}, resume=False)
    with pytest.raises(OutputError, match="another request;"):
        Journal(tmp_path / "a.jsonl", {"request": 2}, resume=True)
    (tmp_path / "a.jsonl").write_bytes(b"not json\n")
    with pytest.raises(OutputError, match="damaged"):
        Journal(tmp_path / "a.jsonl", {"request": 1}, resume=True)


@pytest.mark.parametrize("other", [b"9", b"\0", b'[]\n{"sha256":"0","record":{}}\n', b"[" * 9999], ids=len)
def test_what_stands_behind_a_changed_byte_is_found_anew(tmp_path: Path, other: bytes) -> None:
    searched(tmp_path / "whole.jsonl", 50)
    content = (tmp_path / "whole.jsonl").read_bytes()
    digit = re.compile(rb"\d+\.").search(content, content.rindex(b'"mass":'))
    assert digit is not None
    (tmp_path / "a.jsonl").write_bytes(content[: digit.start()] + other + content[digit.start() + 1 :])
    with Journal(tmp_path / "a.jsonl", {"request": 1}, resume=True) as journal:
        assert len(journal.records) == content[: digit.start()].count(b"\n") - 1
    searched(tmp_path / "a.jsonl", 50, resume=True)
    assert (tmp_path / "a.jsonl").read_bytes() == content


def test_what_is_refused_is_refused_before_any_file_is_sized(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drive, path = mc.new_design("drive", "siso_spur"), tmp_path / "drive-optimum.jsonl"
    with pytest.raises(MbcdmError, match="no such figure"):
        mc.optimise(drive, ["mass_kg:min"], tmp_path)
    assert not path.read_bytes(), "a request that is wrong begins no search"
    with Journal(path, {"files": []}, resume=False) as journal:
        journal.add({})
    monkeypatch.setattr(job, "question_of", lambda *_: pytest.fail("a file is sized"))
    for resume, words in ((True, "another files, aims"), (False, "add --resume")):
        with pytest.raises(OutputError, match=words):
            mc.optimise(drive, ["mass_g:min"], tmp_path, effort=Effort(resume=resume))


def test_a_full_disk_is_told_with_the_remedy_and_the_search_goes_on(tmp_path: Path) -> None:
    searched(tmp_path / "whole.jsonl", 50)

    class Full:
        """A disk with room for 300 bytes more."""

        def __init__(self, file: BinaryIO) -> None:
            self.file, self.room = file, 300

        def write(self, line: bytes) -> int:
            if not self.room:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            written = self.file.write(line[: self.room])
            self.room -= written
            return written

        def close(self) -> None:
            self.file.close()

    with Journal(tmp_path / "a.jsonl", {"request": 1}, resume=False) as journal:
        journal._file = Full(journal._file)  # type: ignore[assignment, arg-type]
        with pytest.raises(
            OutputError, match=r"No space left on device; make room or rights, then go on with --resume"
        ):
            FrontSearch([None], [VARIABLES], WISHES, journal, lambda words, count: None).run(Effort(50))  # type: ignore[list-item]
    assert len((tmp_path / "a.jsonl").read_bytes()) == 300, "the last line should be cut off"
    searched(tmp_path / "a.jsonl", 50, resume=True)
    assert (tmp_path / "a.jsonl").read_bytes() == (tmp_path / "whole.jsonl").read_bytes()


def test_the_time_ends_it_where_it_can_go_on(tmp_path: Path) -> None:
    with Journal(tmp_path / "a.jsonl", {"request": 1}, resume=False) as journal:
        found = FrontSearch([None], [VARIABLES], WISHES, journal, lambda words, count: None).run(Effort(None, 1e-6, 1))  # type: ignore[list-item]
    assert found.stopped == "the time is over" and not found.finished and len(found.tried) < 40
    whole = searched(tmp_path / "b.jsonl")
    assert searched(tmp_path / "a.jsonl", resume=True).front == whole.front
    assert (tmp_path / "a.jsonl").read_bytes() == (tmp_path / "b.jsonl").read_bytes()


def test_a_full_disk_at_the_result_says_how_to_go_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(self: object, name: str, data: bytes | str) -> None:
        raise OutputError(f"{tmp_path}: cannot write: {os.strerror(errno.ENOSPC)}")

    monkeypatch.setattr(OutputFolder, "write", full)
    asked = mc.new_design("drive", "siso_spur")
    question = question_of(asked.loaded.text, tmp_path / "drive.yaml")
    with pytest.raises(OutputError, match=r"No space left on device; the evaluated points are kept: go on with --res"):
        job._write(replace(optimum(), folder=tmp_path / "drive-optimum"), [question], {})
    assert not list(tmp_path.iterdir())


# More than one generation, and enough that the search is in the middle whenever it is stopped, on a fast machine too.
ENDED_AT = 64


def command(folder: Path, out: str, *more: str) -> list[str]:
    words = ["optimise", str(folder / "drive.yaml"), "--aim", "mass_g:min", "--aim", "swing_mrad:min"]
    words += ["--over", "tolerances", "--evaluations", str(ENDED_AT), "--out", str(folder / out), *more]
    return [sys.executable, "-m", "mbcdm_cad", *words]


def hashes(folder: Path) -> dict[str, str]:
    files = [path for path in sorted(folder.rglob("*")) if path.is_file() and not path.name.endswith(".lock")]
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def started(words: list[str]) -> subprocess.Popen[str]:
    """A command that Ctrl-C reaches, also where the tests run as a shell's background job, whose children ignore it."""
    heard = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        return subprocess.Popen(words, stderr=subprocess.PIPE, text=True)
    finally:
        signal.signal(signal.SIGINT, heard)


def stopped(words: list[str], journal: Path, lines: int, how: signal.Signals) -> tuple[int, str]:
    """Run a command, end it by a signal once its journal has so many lines; exit code and standard error."""
    running = started(words)
    _wait_for(running, journal, lines)
    running.send_signal(how)
    said = running.communicate(timeout=PATIENCE_S)[1]
    assert journal.read_bytes().count(b"\n") < ENDED_AT, f"it was not stopped in the middle: {said}"
    return running.returncode, said


def _wait_for(running: subprocess.Popen[str], journal: Path, lines: int) -> None:
    end = time.monotonic() + PATIENCE_S
    while running.poll() is None and not (journal.exists() and journal.read_bytes().count(b"\n") > lines):
        assert time.monotonic() < end, f"no {lines} points within {PATIENCE_S:g} s"
        time.sleep(0.02)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Files of a search that nobody stopped."""
    folder = tmp_path_factory.mktemp("whole")
    mc.new_design("drive", "siso_spur").save(folder / "drive.yaml")
    subprocess.run(command(folder, "whole", "--workers", "2"), check=True, capture_output=True)
    found = hashes(folder / "whole")
    assert len(found) > 5
    return found


@pytest.mark.slow
def test_killed_in_the_middle_it_goes_on_to_the_same_files(tmp_path: Path, whole: dict[str, str]) -> None:
    mc.new_design("drive", "siso_spur").save(tmp_path / "drive.yaml")
    journal = tmp_path / "killed" / "drive-optimum.jsonl"
    code, _ = stopped(command(tmp_path, "killed", "--workers", "1"), journal, ENDED_AT // 3, signal.SIGKILL)
    assert code == -signal.SIGKILL and not (tmp_path / "killed" / "drive-optimum").exists()
    refused = subprocess.run(command(tmp_path, "killed"), capture_output=True, text=True, check=False)
    assert refused.returncode == 2 and "add --resume to go on" in refused.stderr, refused.stderr
    subprocess.run(command(tmp_path, "killed", "--workers", "2", "--resume"), check=True, capture_output=True)
    assert hashes(tmp_path / "killed") == whole


@pytest.mark.slow
def test_a_cluster_whose_workers_die_come_late_or_have_another_version_ends_with_the_same_files(
    tmp_path: Path, whole: dict[str, str]
) -> None:
    mc.new_design("drive", "siso_spur").save(tmp_path / "drive.yaml")
    package = Path(mc.__file__).parent
    shutil.copytree(package, tmp_path / "other" / package.name, ignore=shutil.ignore_patterns("__pycache__"))
    with (tmp_path / "other" / package.name / "errors.py").open("a") as changed:
        changed.write("# Another version.\n")
    journal = tmp_path / "many" / "drive-optimum.jsonl"
    with Loopback() as many:
        words = command(tmp_path, "many", "--scheduler", many.address)
        many.worker(path=tmp_path / "other")
        first = many.worker()
        running = started(words)
        _wait_for(running, journal, ENDED_AT // 4)
        first.kill()
        first.wait()
        before = journal.read_bytes().count(b"\n")
        many.worker()
        _wait_for(running, journal, before + 3)
        running.send_signal(signal.SIGINT)
        said = running.communicate(timeout=PATIENCE_S)[1]
        assert running.returncode == 130 and "it goes on with --resume" in said, said
        assert "gets no work: it has another state of the package" in said, said
        left = journal.read_bytes().count(b"\n")
        assert left < ENDED_AT, "it was not interrupted in the middle"
        code, said = stopped([*words, "--resume"], journal, left + 3, signal.SIGKILL)
        assert code == -signal.SIGKILL, said
        ended = subprocess.run([*words, "--resume"], capture_output=True, text=True, check=False, timeout=PATIENCE_S)
        assert ended.returncode == 0, ended.stderr
    assert hashes(tmp_path / "many") == whole
