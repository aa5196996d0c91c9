"""A process that is forked after its parent used the kernel must not wait for threads that do not exist in it."""

from __future__ import annotations

import subprocess
import sys

import pytest

SCRIPT = """
from mbcdm_cad.workshop import kernel  # as everything of this room that draws does
from mbcdm_cad.parallel.forks import allow_processes, fork_map
import cadquery as cq

def drawn(size):
    return cq.Solid.makeBox(size, 1, 1).cut(cq.Solid.makeSphere(0.5, cq.Vector(0, 0, 0))).Volume()

allow_processes()
here = [drawn(size) for size in (1.0, 2.0)]
assert fork_map(drawn, [1.0, 2.0], 2) == here, here
print("the same", kernel.__name__)
"""


@pytest.mark.slow
def test_a_forked_process_draws_after_its_parent_has_drawn() -> None:
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0 and "the same" in done.stdout, done.stderr
