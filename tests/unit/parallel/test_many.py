"""Studies find their functions on other machines by name, and only with the same tests."""

from __future__ import annotations

import argparse
import pickle
from dataclasses import replace

import pytest

from benchmarks.study import Named, run_many
from mbcdm_cad.errors import MbcdmError


def double(k: int) -> int:
    return 2 * k


def test_a_function_of_a_program_is_found_by_its_name() -> None:
    found = pickle.loads(pickle.dumps(Named.of(double)))
    assert found.module == "tests.unit.parallel.test_many" and found(21) == 42


def test_other_tests_are_refused() -> None:
    with pytest.raises(MbcdmError, match="check out the same state"):
        replace(Named.of(double), state="another")(21)


def test_results_come_in_order() -> None:
    assert list(run_many(double, iter(range(5)), argparse.Namespace(workers=1, scheduler=None))) == [0, 2, 4, 6, 8]
