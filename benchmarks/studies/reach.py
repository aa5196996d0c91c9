"""Which short files give a drive: random requirements, sized and checked.

    python -m benchmarks.studies.reach --count 300 --seed 1
    python -m benchmarks.studies.reach --only 17 --save DIR
    python -m benchmarks.studies.reach --edits
    python -m benchmarks.studies.reach --prove all
    python -m benchmarks.studies.reach --layout siso_bevel --count 50 --prove bound

Each seed is one file of about ten lines, drawn from the whole range of a layout (:data:`LAYOUTS`). Printed are the
share that passes every check, the failures by the first check that fails, and their requirements.
``--build`` also builds the passing designs and counts clashes and invalid solids. Exit 1 if one of them does not build.
``--edits`` changes one requirement of each passing file by 10 %, up and down, and counts the designs that still pass
without a second edit. ``--prove`` tests for each file that does not pass whether its requirements exclude each other:
``bound`` by a bound over the catalogue alone, within a minute; ``all`` also by ``mbcdm solve`` and an independent
search, a minute for each file (miso_bevel only; the other layouts have only the bound).
"""

import argparse
import copy
import sys
import time
from bisect import bisect_left
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from benchmarks.study import add_workers, run_many
from mbcdm_cad.errors import InputError
from mbcdm_cad.solving.question import question_of
from mbcdm_cad.solving.solve import solve
from tests.support import layout_bound
from tests.support.random_generator import LAYOUTS, failing, load, requirements, search
from tests.support.reach_bound import asked, excluding

# Requirements that are numbers: (block, field).
NUMBERS = (
    ("transmission", "ratio"),
    ("transmission", "input_to_drum"),
    ("transmission", "drum_radius_mm"),
    ("travel", "half_angle_deg"),
    ("loads", "peak_torque_Nm"),
    ("transmission", "centre_distance_mm"),
)

BOUND, SEARCHES, SOLVED, FOUND, OPEN = "bound", "searches", "solved", "found", "open"
WORDS = {
    SOLVED: "get a design from 'mbcdm solve'",
    FOUND: "get one from the independent search alone",
    BOUND: "exclude each other by a bound over the catalogue",
    SEARCHES: "exclude each other by both searches, and a design passes after one is relaxed",
    OPEN: "are neither: no design found, and no requirement that helps when it is relaxed",
}


@dataclass(frozen=True)
class Proof:
    """``kind``: one of :data:`WORDS`; ``names``: the requirements that exclude each other, or what was moved."""

    seed: int
    kind: str
    names: tuple[str, ...]


def proof(seed: int, data: dict[str, Any], *, searched: bool = True) -> Proof:
    """Of one file that does not pass. Without ``searched`` only the bound is asked, which takes a tenth of a second."""
    names = excluding(asked(data))
    if names:
        return Proof(seed, BOUND, names)
    if not searched:
        return Proof(seed, OPEN, ())
    try:
        solution = solve(question_of(yaml.safe_dump(data, sort_keys=False)))
    except InputError as error:
        return Proof(seed, OPEN, (str(error.problems[0].what),))
    if solution.conflict is None:
        return Proof(seed, SOLVED, tuple(change.field for change in solution.changes))
    found = search(data)
    if found is not None:
        return Proof(seed, FOUND, tuple(found))
    conflict = solution.conflict
    gives = (*conflict.either, *conflict.first) if conflict.either else ()
    return Proof(seed, SEARCHES if gives else OPEN, tuple(sorted({way.field for way in gives})))


def summary(passing: int, count: int, proofs: Sequence[Proof]) -> Iterator[str]:
    """How many files of each kind, which sets exclude each other, and the files that are left."""
    kinds = Counter(found.kind for found in proofs)
    yield f"{passing} of {count} pass every check by the rules alone"
    yield from (f"{kinds[kind]} {words}" for kind, words in WORDS.items())
    settled = passing + kinds[SOLVED] + kinds[BOUND] + kinds[SEARCHES]
    yield f"{settled} of {count} settled ({settled / count:.1%})"
    sets = Counter((found.kind, found.names) for found in proofs if found.kind in (BOUND, SEARCHES))
    yield from (f"  {number:>4} {kind:<9}{', '.join(names)}" for (kind, names), number in sets.most_common())
    yield from (
        f"  seed {found.seed}: {found.kind} {', '.join(found.names)}"
        for found in proofs
        if found.kind in (SOLVED, FOUND, OPEN)
    )


@dataclass(frozen=True)
class Reached:
    """What came of one file: the checks that fail, in order, with their margins as shares of their limits."""

    seed: int
    data: dict[str, Any]
    failed: tuple[tuple[str, str], ...]
    refused: str = ""
    seconds: float = 0.0

    @property
    def passes(self) -> bool:
        """Whether every check passes."""
        return not self.failed and not self.refused


def reach(task: tuple[int, str]) -> Reached:
    """One seed of a layout, sized and checked."""
    seed, layout = task
    return judged(seed, requirements(seed, LAYOUTS[layout]))


def proved(task: tuple[Reached, bool]) -> Proof:
    """Whether the requirements of a file that does not pass exclude each other; with a search too if wanted."""
    reached, searched = task
    return proof(reached.seed, reached.data, searched=searched)


def judged(seed: int, data: dict[str, Any]) -> Reached:
    """One file, sized and checked."""
    start = time.perf_counter()
    try:
        loaded = load(data)
    except InputError as error:
        return Reached(seed, data, (), str(error.problems[0]))
    seconds = time.perf_counter() - start
    return Reached(seed, data, failing(loaded), seconds=seconds)


def built(reached: Reached) -> Iterator[str]:
    """What goes wrong when a file that passes is built."""
    from benchmarks.studies.random_designs import exercise  # draws solids: only where it is asked for
    from tests.support.random_generator import Passing

    found = Passing(reached.seed, reached.data, load(reached.data))
    yield from (f"{fault.stage}: {fault.what}" for fault in exercise(found, 3))


def ratio_of(data: dict[str, Any]) -> float:
    """Ratio that a file asks for."""
    t = data["transmission"]
    return float(t["ratio"] if "ratio" in t else t["input_to_drum"])


def described(data: dict[str, Any]) -> str:
    """The requirements on one line."""
    t = data["transmission"]
    words = [
        f"ratio {ratio_of(data):g}",
        f"r {t['drum_radius_mm']:g}",
        f"travel {data['travel']['half_angle_deg']:g}",
        f"torque {data['loads']['peak_torque_Nm']:g}",
        f"rope {data.get('rope', {}).get('type', 'free')}",
        f"L {t.get('centre_distance_mm', 'free')}",
        "printed" if "drum" in data else "milled",
    ]
    return ", ".join(words)


def table(found: Sequence[Reached]) -> Iterator[str]:
    """Shares passing, by each requirement in halves or thirds of its range."""

    def share(rows: list[Reached]) -> str:
        return f"{sum(r.passes for r in rows)}/{len(rows)}"

    cuts: dict[str, Any] = {
        "ratio": lambda r: _part(ratio_of(r.data), (3, 6, 10)),
        "drum radius": lambda r: _part(r.data["transmission"]["drum_radius_mm"], (30, 40, 60, 100)),
        "travel": lambda r: _part(r.data["travel"]["half_angle_deg"], (25, 40, 60)),
        "torque": lambda r: _part(r.data["loads"]["peak_torque_Nm"], (0.3, 2, 10)),
        "rope": lambda r: "given" if "rope" in r.data else "free",
        "L": lambda r: "given" if "centre_distance_mm" in r.data["transmission"] else "free",
        "made": lambda r: "printed" if "drum" in r.data else "milled",
    }
    for name, cut in cuts.items():
        groups: dict[str, list[Reached]] = {}
        for r in found:
            groups.setdefault(cut(r), []).append(r)
        yield f"  {name:<12} " + "   ".join(f"{key} {share(rows)}" for key, rows in sorted(groups.items()))


def _part(value: float, cuts: Sequence[float]) -> str:
    """The part of the range between two cuts in which a value lies."""
    at = bisect_left(cuts, value)
    return f"to {cuts[at]:g}" if at < len(cuts) else f"over {cuts[-1]:g}"


def report(found: Sequence[Reached]) -> str:
    """What is printed."""
    passing = [r for r in found if r.passes]
    lines = [f"{len(passing)} of {len(found)} pass every check ({len(passing) / len(found):.0%})", ""]
    first = Counter(r.failed[0][0] if r.failed else "refused" for r in found if not r.passes)
    every = Counter(check for r in found for check, _ in r.failed)
    alone = Counter(r.failed[0][0] for r in found if len(r.failed) == 1)
    lines.append(f"{'check':<26}{'first':>6}{'alone':>6}{'any':>6}")
    lines += [f"{name:<26}{first[name]:>6}{alone[name]:>6}{count:>6}" for name, count in every.most_common(30)]
    lines += ["", *table(found)]
    times = sorted(r.seconds for r in found)
    lines.append(f"\nreading and sizing: median {times[len(times) // 2] * 1e3:.0f} ms")
    return "\n".join(lines)


def edited(data: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """The file with one requirement a tenth smaller or larger, and which."""
    for block, name in NUMBERS:
        for factor in (0.9, 1.1):
            if name in data[block]:
                other = copy.deepcopy(data)
                other[block][name] = round(data[block][name] * factor, 6)
                yield f"{name} x {factor:g}", other


def edits(found: Sequence[Reached]) -> str:
    """What comes of the edits of the files that pass."""
    passed: dict[str, list[bool]] = {}
    first: Counter[str] = Counter()
    for reached in found:
        for name, data in edited(reached.data) if reached.passes else ():
            r = judged(reached.seed, data)
            passed.setdefault(name, []).append(r.passes)
            first.update([r.failed[0][0] if r.failed else "refused"] if not r.passes else [])
    lines = [f"  {name:<26} {sum(each)}/{len(each)}" for name, each in passed.items()]
    every = [one for each in passed.values() for one in each]
    lines.append(f"{sum(every)} of {len(every)} edits pass ({sum(every) / max(len(every), 1):.1%})")
    return "\n".join([*lines, "first to fail: " + ", ".join(f"{check} {n}" for check, n in first.most_common())])


def excluded(layout: str, found: Sequence[Reached]) -> Iterator[str]:
    """Which of the files of a layout without a guide ask what excludes itself, and why; the files that are left."""
    rest = [r for r in found if not r.passes]
    bounds = {r.seed: layout_bound.excluding(layout, layout_bound.asked(r.data)) for r in rest}
    left = [r for r in rest if not bounds[r.seed][0]]
    out = len(rest) - len(left)
    yield f"{len(found) - len(rest)} of {len(found)} pass every check by the rules alone; {out} exclude themselves:"
    for (names, why), number in Counter(bound for bound in bounds.values() if bound[0]).most_common():
        yield f"  {number:>4}  {', '.join(names)}: {why}"
    wrong = [r.seed for r in found if r.passes and layout_bound.excluding(layout, layout_bound.asked(r.data))[0]]
    yield f"of the {len(found) - out} others {len(found) - len(rest)} pass; passes although excluded: {wrong or 'none'}"
    for r in left:
        yield f"  seed {r.seed}: {described(r.data)}: {r.refused or '; '.join(': '.join(one) for one in r.failed[:2])}"


def main() -> int:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--layout", choices=sorted(LAYOUTS), default="miso_bevel", help="layout to draw from")
    parser.add_argument("--only", type=int, help="one seed: its requirements and what fails")
    parser.add_argument("--of", help="list the seeds that fail this check first")
    parser.add_argument("--save", type=Path, help="write the files there")
    parser.add_argument("--edits", action="store_true", help="edit what passes by a tenth")
    parser.add_argument("--prove", choices=("bound", "all"), help="what excludes each other in the files that fail")
    parser.add_argument("--build", type=int, default=0, metavar="N", help="build the first N that pass")
    add_workers(parser)
    args = parser.parse_args()
    seeds = [args.only] if args.only is not None else range(args.seed, args.seed + args.count)
    found = list(run_many(reach, [(seed, args.layout) for seed in seeds], args))
    if args.save:
        args.save.mkdir(parents=True, exist_ok=True)
        for r in found:
            (args.save / f"{r.data['name']}.yaml").write_text(yaml.safe_dump(r.data, sort_keys=False))
    if args.only is not None or args.of:
        for r in found:
            if not args.of or (r.failed and r.failed[0][0] == args.of):
                print(f"{r.seed}: {described(r.data)}{'  ' + r.refused if r.refused else ''}")
                print("\n".join(f"    {check}: {message}" for check, message in r.failed))
        return 0
    print(report(found))
    if args.edits:
        print(edits(found))
    if args.prove and args.layout != "miso_bevel":
        print("\n".join(["", *excluded(args.layout, found)]))
    elif args.prove:
        rest = [r for r in found if not r.passes]
        proofs = list(run_many(proved, [(r, args.prove == "all") for r in rest], args))
        print("\n".join(["", *summary(len(found) - len(rest), len(found), proofs)]))
    faults = 0
    for r in [r for r in found if r.passes][: args.build]:
        wrong = list(built(r))
        faults += bool(wrong)
        print(f"seed {r.seed}: {'builds' if not wrong else '; '.join(wrong)}", flush=True)
    return int(bool(faults))


if __name__ == "__main__":
    sys.exit(main())
