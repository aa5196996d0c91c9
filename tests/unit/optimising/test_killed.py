"""The command killed by the system goes on, and ends with the same files as one that was never stopped."""

from __future__ import annotations

import hashlib
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import mbcdm_cad as mc

ENDED_AT = 40


def command(folder: Path, out: str, *more: str) -> list[str]:
    words = ["optimise", str(folder / "drive.yaml"), "--aim", "mass_g:min", "--aim", "swing_mrad:min"]
    words += ["--evaluations", str(ENDED_AT), "--out", str(folder / out), *more]
    return [sys.executable, "-m", "mbcdm_cad", *words]


def hashes(folder: Path) -> dict[str, str]:
    files = [path for path in sorted(folder.rglob("*")) if path.is_file() and not path.name.endswith(".lock")]
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


@pytest.mark.slow
def test_killed_in_the_middle_it_goes_on_to_the_same_files(tmp_path: Path) -> None:
    mc.new_design("drive", "siso_spur").save(tmp_path / "drive.yaml")
    subprocess.run(command(tmp_path, "whole", "--workers", "2"), check=True, capture_output=True)
    journal = tmp_path / "killed" / "drive-optimum.jsonl"
    running = subprocess.Popen(command(tmp_path, "killed", "--workers", "1"), stderr=subprocess.DEVNULL)
    while running.poll() is None and not (journal.exists() and journal.read_bytes().count(b"\n") > ENDED_AT // 3):
        time.sleep(0.05)
    running.send_signal(signal.SIGKILL)
    assert running.wait() == -signal.SIGKILL and not (tmp_path / "killed" / "drive-optimum").exists()
    assert journal.read_bytes().count(b"\n") < ENDED_AT, "it was not killed in the middle"
    refused = subprocess.run(command(tmp_path, "killed"), capture_output=True, text=True, check=False)
    assert refused.returncode == 2 and "add --resume to go on" in refused.stderr, refused.stderr
    subprocess.run(command(tmp_path, "killed", "--workers", "2", "--resume"), check=True, capture_output=True)
    whole, killed = hashes(tmp_path / "whole"), hashes(tmp_path / "killed")
    assert len(whole) > 5 and killed == whole
