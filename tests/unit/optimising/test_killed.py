"""The command killed by the system goes on, and ends with the same files as one that was never stopped."""

from __future__ import annotations

import hashlib
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import mbcdm_cad as mc
from tests.support.loopback import PATIENCE_S, Loopback

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
