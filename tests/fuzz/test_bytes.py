"""Byte-level mutations of the real design file: the result is always a drive or an InputError, and never a hang."""

from __future__ import annotations

import random
import time
from pathlib import Path

import pytest

from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import load_design
from tests.support.mutants import mutate

PARAMS = Path(__file__).parents[2] / "params" / "mbcdm.yaml"
SPICE = [
    b"&a ",
    b"*a",
    b"!!python/object:os.system ",
    b"<<: ",
    b"[",
    b"]",
    b"{",
    b"}",
    b": ",
    b"- ",
    b"\t",
    b"\n",
    b"\r",
    b"'",
    b'"',
    b"|",
    b">",
    b"%",
    b"---\n",
    b"...\n",
    b"\x00",
    b"\xff",
    b"\xc3",
    b"\xe2\x80\xa8",
    b"1e999",
    b".nan",
    b"~",
    b"? ",
    b"#",
    b"@",
    b"`",
    b"\xef\xbb\xbf",
    b"0" * 50,
    b"9" * 50,
    b"-",
    b".",
    b"e",
    b"\x85",
]


def run(path: Path, seeds: range) -> tuple[int, int]:
    """Load the mutant of each seed; how many loaded, and how many were refused."""
    content = PARAMS.read_bytes()
    loaded = refused = 0
    for seed in seeds:
        mutant = mutate(content, SPICE, random.Random(seed))
        path.write_bytes(mutant)
        start = time.process_time()
        try:
            load_design(path)
            loaded += 1
        except InputError as error:
            refused += 1
            for problem in error.problems:
                assert problem.file == str(path) and problem.line >= 1 and problem.what and problem.remedy, (
                    seed,
                    problem,
                )
                assert str(problem).isprintable() and len(str(problem)) < 900, (seed, problem)
        except BaseException as error:
            raise AssertionError(f"seed {seed}: {type(error).__name__}: {error}") from error
        took = time.process_time() - start
        # Not a measure of speed: a mutant that leaves the ratios out has nine drives sized; a hang takes minutes.
        assert took < 30.0, f"seed {seed}: {took:.2f} s of processor time"
    return loaded, refused


def test_two_hundred_mutants(tmp_path: Path) -> None:
    loaded, refused = run(tmp_path / "f.yaml", range(200))
    assert loaded > 20 and refused > 60, (
        f"{loaded} loaded and {refused} refused: the mutations are too weak or too strong"
    )


@pytest.mark.slow
def test_two_thousand_more_mutants(tmp_path: Path) -> None:
    loaded, refused = run(tmp_path / "f.yaml", range(200, 2200))
    assert loaded > 200 and refused > 600, f"{loaded} loaded and {refused} refused"
