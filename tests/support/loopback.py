"""A dask scheduler and its workers as processes of this machine, for tests of work on a cluster."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Self

PRELOAD = ("--preload", "mbcdm_cad.parallel.worker")
# Longer than any step takes on a machine that does much else too: only a step that hangs fails.
PATIENCE_S = 600.0


class Loopback:
    """A scheduler on loopback, inside a ``with`` block; ``address`` is its own."""

    def __enter__(self) -> Self:
        """Start the scheduler and wait until it answers."""
        self._folder = TemporaryDirectory()
        self._processes: list[subprocess.Popen[bytes]] = []
        file = Path(self._folder.name) / "scheduler.json"
        self._start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(file))
        end = time.monotonic() + PATIENCE_S
        while not file.exists() or not file.read_text():
            assert time.monotonic() < end, self.log("scheduler")
            time.sleep(0.05)
        self.address: str = json.loads(file.read_text())["address"]
        return self

    def worker(self, *, path: Path | None = None, preload: bool = True) -> subprocess.Popen[bytes]:
        """Start a worker, with the package of the folder ``path`` if given; it joins when it can."""
        words = ["worker", self.address, "--nthreads", "1", "--no-nanny", "--no-dashboard", "--host", "127.0.0.1"]
        return self._start(*words, *(PRELOAD if preload else ()), path=path)

    def _start(self, kind: str, *words: str, path: Path | None = None) -> subprocess.Popen[bytes]:
        here = {} if path is None else {"PYTHONPATH": str(path)}
        command = [sys.executable, "-m", "dask", kind, *words]
        with (Path(self._folder.name) / f"{kind}.log").open("ab") as log:
            found = subprocess.Popen(
                command, stdout=log, stderr=log, env=os.environ | here, cwd=path or self._folder.name
            )
        self._processes.append(found)
        return found

    def log(self, kind: str) -> str:
        """What the scheduler, or the workers, have said."""
        return (Path(self._folder.name) / f"{kind}.log").read_text()

    def __exit__(self, *error: object) -> None:
        """End all of them; a test that fails shows what they have said."""
        if error[0] is not None:
            print(self.log("scheduler"), self.log("worker"), sep="\n")
        for one in self._processes:
            one.kill()  # a worker that is asked to end waits for its scheduler, which may be gone
            one.wait()
        self._folder.cleanup()
