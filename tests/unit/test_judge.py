"""The judge of the loop: its table and page are of the cases that it has, and a class that is worse is told."""

from dataclasses import astuple
from typing import Any

from benchmarks.judge import FRESH, PAGE, TABLE, key_of, page, part_of, worse
from benchmarks.judge_cases import cases
from benchmarks.study import read_rows

ROW = {"source": "rig", "kind": "one", "seed": 0, "true": "delay", "said": "delay", "cpu_s": 1.0}


def rows(*scores: str) -> list[dict[str, Any]]:
    return [{**ROW, "name": f"run {k}", "score": score} for k, score in enumerate(scores)]


def test_table_and_page_are_of_the_cases() -> None:
    known, table = cases(), read_rows(TABLE)
    judged = {key_of(row) for row in table}
    assert [key_of(row) for row in table] == [astuple(case) for case in known if astuple(case) in judged]
    assert PAGE.read_text("utf-8") == page(table, read_rows(FRESH)), "python -m benchmarks.judge --page"
    assert {f"{case.source} {case.kind}" for case in part_of(known)} == {f"{c.source} {c.kind}" for c in known}


def test_there_are_as_many_runs_as_were_asked_for() -> None:
    sources = [case.source for case in cases()]
    assert sources.count("rig") == 64 and len(sources) - 64 >= 120
    layouts = [case.seed % 4 for case in cases() if case.source == "layouts"]
    assert min(layouts.count(k) for k in range(4)) >= 15


def test_a_class_that_is_worse_is_told_and_a_better_one_is_not() -> None:
    before = rows("right", "set", "missed", "false")
    assert worse(before, before) == [] and worse(before, rows("set", "right", "right", "missed")) == []
    assert worse(before, rows("right", "missed", "missed", "false")) == ["rig one: -1 right or in a set, +0 false"]
    assert worse(before, rows("right", "set", "false", "false")) == ["rig one: +0 right or in a set, +1 false"]
    # Only cases that were judged are compared.
    assert worse(before, before[:2]) == [] and worse(before[:2], before) == []
