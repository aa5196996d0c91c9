"""The check command's output: a table for people, JSON for machines, and the exit code."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import fields
from typing import Any

from mbcdm_cad.checks.result import CheckResult, figures
from mbcdm_cad.checks.run import failed, run_checks
from mbcdm_cad.design.loaded import LoadedDesign

_COLOURS = {"pass": "32", "warn": "33", "fail": "31"}


def outputs(loaded: LoadedDesign) -> dict[str, bytes]:
    """What the check command prints, in each of its forms (plain, colour, json), and its exit ``code``: 0 or 1."""
    results = run_checks(loaded)
    name = loaded.drive.name
    return {
        "plain": "\n".join(table(name, results)).encode(),
        "colour": "\n".join(table(name, results, colour=True)).encode(),
        "json": json.dumps(as_data(loaded, results), indent=1, allow_nan=False).encode(),
        "code": b"1" if failed(results) else b"0",
    }


def as_data(loaded: LoadedDesign, results: Sequence[CheckResult]) -> dict[str, Any]:
    """All fields of all results, with a summary, ready for JSON."""
    names = [field.name for field in fields(CheckResult)]
    return {
        "design": loaded.drive.name,
        "design_sha256": loaded.sha256,
        "summary": counts(results),
        "checks": [{name: getattr(result, name) for name in names} for result in results],
    }


def counts(results: Sequence[CheckResult]) -> dict[str, int]:
    """Number of results by status; waived ones are counted as waived, not as passed."""
    found = Counter("waived" if r.waived_reason else r.status for r in results)
    return {word: found[word] for word in ("pass", "warn", "fail", "waived")}


def table(name: str, results: Sequence[CheckResult], colour: bool = False) -> Iterator[str]:
    """Lines: one a check; below it what was found and what to do, where it does not simply pass."""
    width = max((len(r.id) for r in results), default=0)
    for r in results:
        word = "waived" if r.waived_reason else r.status
        shown = f"\x1b[{_COLOURS[r.status]}m{word:<6}\x1b[0m" if colour else f"{word:<6}"
        yield f"{shown} {r.id:<{width}} {figures(r):<34} {r.title}"
        if word != "pass":
            yield f"{'':7}{r.message}"
            if r.waived_reason:
                yield f"{'':7}waived: {r.waived_reason}"
            elif r.remedy:
                yield f"{'':7}-> {r.remedy}"
    summary = counts(results)
    yield f"{name}: " + ", ".join(f"{n} {word}" for word, n in summary.items()) + f", of {len(results)} checks"
