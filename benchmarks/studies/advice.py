"""Follow the advice of ``mbcdm check`` after one edit of the reference, until it ends.

    python -m benchmarks.studies.advice [--short] [--only "L 38"] [--solve]

Each start is one of the single edits of ``tests/acceptance/test_docs_commands.py``, written into the complete reference
file (box and mass open, 1.0 N m and D/d 10 required), or with ``--short`` into the file of its requirements alone. In
each round the design is checked, and the changes of the advice are written into the file. It ends with a design that
passes, with the list of checks that still fail, or in a cycle: a file that occurred before. ``--solve`` runs
``mbcdm solve`` on those that do not end in a pass. Exit 1 if one ends in a cycle, or if its advice is wrong.
"""

import argparse
import copy
import sys
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from benchmarks.study import add_workers, run_many
from mbcdm_cad.checks.comparison import failed
from mbcdm_cad.design.yamltree import put, take_out
from mbcdm_cad.layouts.check_design import advised_checks
from mbcdm_cad.layouts.loader import load_text
from mbcdm_cad.solving.question import question_of
from mbcdm_cad.solving.solve import solve
from tests.acceptance.test_docs_commands import EDITS, requirements

REFERENCE = Path(__file__).parents[2] / "params" / "mbcdm.yaml"
ROUNDS = 8
PASSES, STAYS, CYCLE, BROKEN = "passes", "says what stays", "cycle", "advice does not hold"


@dataclass(frozen=True)
class End:
    """How it ends, after how many rounds of changes, and the words of the last advice."""

    kind: str
    rounds: int
    words: str
    data: dict[str, Any]


def complete() -> dict[str, Any]:
    """The complete reference file, box and mass open, with what the edits ask."""
    data: dict[str, Any] = yaml.safe_load(REFERENCE.read_text("utf-8"))
    data["targets"] = {}
    data["loads"] = {"test_torque_Nm": 0.91, "peak_torque_Nm": 1.0}
    data["limits"]["bend_ratio_min"] = 10.0
    return data


def start(name: str, *, short: bool) -> dict[str, Any]:
    """The file after one edit."""
    data = requirements() if short else complete()
    EDITS[name](data)
    return data


def follow(data: dict[str, Any]) -> End:
    """Check and change until nothing more is advised that passes."""
    data, seen, words, promised = copy.deepcopy(data), set[str](), "", False
    for rounds in range(ROUNDS + 1):
        text = yaml.safe_dump(data, sort_keys=False)
        if text in seen:
            return End(CYCLE, rounds, words, data)
        seen.add(text)
        loaded = load_text(text, "edited.yaml")
        results, together = advised_checks(loaded)
        if not failed(results):
            return End(PASSES, rounds, words, data)
        if promised:
            return End(BROKEN, rounds, words, data)
        if together is None or not together.passes:
            return End(STAYS, rounds, together.words("edited.yaml") if together else "", data)
        words, promised = together.words("edited.yaml"), True
        for field in together.taken_out:
            take_out(data, field)
        for field, value in together.changes.items():
            put(data, field, value)
    return End(CYCLE, ROUNDS, words, data)


def ended(asked: tuple[str, bool, bool]) -> tuple[str, End, str]:
    """An edit by its name (of the short file, ``solve`` asked where it stays), how it ends, what ``solve`` says."""
    name, short, solves = asked
    end = follow(start(name, short=short))
    if not solves or end.kind != STAYS:
        return name, end, ""
    conflict = solve(question_of(yaml.safe_dump(end.data, sort_keys=False))).conflict
    words = "a design" if conflict is None else f"no design: {', '.join(conflict.exclude) or 'no set found'}"
    return name, end, words


def main() -> int:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--short", action="store_true", help="edit the file of requirements alone")
    parser.add_argument("--only", help="one edit by its name")
    parser.add_argument("--solve", action="store_true", help="ask mbcdm solve about those that stay")
    add_workers(parser)
    args = parser.parse_args()
    counted: Counter[str] = Counter()
    asked = [(name, args.short, args.solve) for name in ([args.only] if args.only else EDITS)]
    for name, end, words in run_many(ended, asked, args):
        counted[end.kind] += 1
        print(f"{name:<20} {end.kind} after {end.rounds}: {end.words}", flush=True)
        if words:
            counted[f"solve: {words.split(':')[0]}"] += 1
            print(f"{'':<20} solve: {words}", flush=True)
    print(", ".join(f"{n} {kind}" for kind, n in counted.items()))
    return int(bool(counted[CYCLE] + counted[BROKEN]))


if __name__ == "__main__":
    sys.exit(main())
