"""Shared by all benchmarks: a figure with its limit, the smallest of several times, and the end of a run."""

import argparse
import json
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
# The helpers of tests/, however a benchmark is run.
sys.path.insert(0, str(ROOT))


@dataclass(frozen=True)
class Figure:
    """One measured figure; ``limit`` is the most allowed, or the least where ``at_least``; None: for information."""

    name: str
    value: float
    unit: str
    limit: float | None = None
    at_least: bool = False

    @property
    def holds(self) -> bool:
        """Whether the figure is within its limit."""
        if self.limit is None:
            return True
        return self.value >= self.limit if self.at_least else self.value <= self.limit

    def __str__(self) -> str:
        word = "at least" if self.at_least else "at most"
        verdict = "" if self.limit is None else f"   {word} {self.limit:g}   {'ok' if self.holds else 'TOO SLOW'}"
        return f"{self.name:<76}{self.value:12.4g} {self.unit}{verdict}"


def least(once: Callable[[], object], repeat: int) -> float:
    """Processor time (s) of all threads of this process, of the quickest of ``repeat`` runs."""
    times = []
    for _ in range(repeat):
        start = time.process_time()
        once()
        times.append(time.process_time() - start)
    return min(times)


def in_turns(rounds: int, **once: Callable[[], float]) -> dict[str, float]:
    """The least of the times that each function gives; they take turns, so that a busy machine slows all alike."""
    times: dict[str, list[float]] = {name: [] for name in once}
    for _ in range(rounds):
        for name, function in once.items():
            times[name].append(function())
    return {name: min(found) for name, found in times.items()}


def arguments(doc: str | None, repeat: int) -> argparse.ArgumentParser:
    """A parser of what every benchmark takes: the design file, how often to repeat, where to write the figures."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("design", nargs="?", type=Path, default=ROOT / "params" / "mbcdm.yaml")
    parser.add_argument("--repeat", type=int, default=repeat, help=f"runs of each figure (default {repeat})")
    parser.add_argument("--json", type=Path, help="also write the figures there")
    return parser


def finish(figures: Sequence[Figure], target: Path | None) -> int:
    """Write the figures to ``target`` as JSON, if given; the exit code: 1 if a limit is exceeded."""
    if target:
        rows = [asdict(figure) | {"holds": figure.holds} for figure in figures]
        target.write_text(json.dumps(rows, indent=1) + "\n")
    return 0 if all(figure.holds for figure in figures) else 1
