"""The command ``solve``: the nearest design that passes, as a patch of the file, or why there is none."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from mbcdm_cad.cli.screen import coloured
from mbcdm_cad.design.describe import flow
from mbcdm_cad.errors import InputError, Problem
from mbcdm_cad.solving.conflict import Conflict, Give
from mbcdm_cad.solving.patch import difference, patched
from mbcdm_cad.solving.question import Out, Times, read_question
from mbcdm_cad.solving.solve import MOST_TRIALS, Solution, solve
from mbcdm_cad.storage.files import refuse_missing_folder, write_whole


def solve_command(design: Path, *, apply: Path | None, as_json: bool) -> int:
    """Search, print the result, and write it to ``apply``. 0 if a passing design was found, else 1."""
    if apply is not None:
        _refuse_other_file(design, apply)
    question = read_question(design)
    with _progress() as told:
        found = solve(question, told)
    text = None if found.data is None else patched(question.text, str(design), found.data)
    if as_json:
        click.echo(json.dumps(_as_json(found, question.text, text), indent=1, allow_nan=False))
    else:
        for line in _lines(found, question.text, text):
            click.echo(line)
    if apply is not None and text is not None:
        write_whole({apply: text.encode()})
        click.echo(f"{apply} written", err=as_json)
    return int(text is None)


@contextmanager
def _progress() -> Iterator[Callable[[str, int], None] | None]:
    """A progress bar of trials on a terminal; nothing if the output is piped."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console  # only needed on a terminal
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed} trials"),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("searching", total=MOST_TRIALS)
        yield lambda stage, count: bar.update(task, description=stage, completed=count)


def _lines(found: Solution, before: str, after: str | None) -> Iterator[str]:
    name = str(found.question.path)
    if after is None:
        assert found.conflict is not None, "without a design there is a conflict"
        yield from _conflict_lines(found.conflict, name, found.trials)
        return
    if not found.changes:
        yield f"{name}: passes every check as it is"
        return
    count = len(found.changes)
    yield f"{name}: {count} change{'s' * (count > 1)} and it passes every check ({found.trials} designs tried)"
    for change in found.changes:
        yield f"  {change.field}: {_word(change.before)} -> {_word(change.after)}  ({change.note})"
    yield ""
    yield from _coloured(difference(before, after, name))


def _conflict_lines(conflict: Conflict, name: str, trials: int) -> Iterator[str]:
    yield f"{name}: no design passes every check ({trials} designs tried)"
    if conflict.first:
        yield "These requirements were relaxed first, one after the other:"
        yield from (f"  {_give(way)}" for way in conflict.first)
    if conflict.exclude:
        several = (
            "these exclude each other"
            if len(conflict.exclude) > 1
            else "this cannot be met together with the rest of the file"
        )
        sure = several if conflict.proved else f"{several}, perhaps with others"
        yield f"{'Then ' if conflict.first else ''}{sure}: {', '.join(conflict.exclude)}"
        yield "To relax one of them is enough; each of these was tried and passes:"
        yield from (f"  {_give(way)}" for way in conflict.either)
    else:
        yield "No requirement was found that gives a passing design when it alone is relaxed."
    yield "Checks that fail on the design that came nearest:"
    yield from (f"  {check}: {message}" for check, message in conflict.nearest)


def _give(way: Give) -> str:
    moved = ", ".join(f"{field} {_setting(value)}" for field, value in way.moves.items())
    with_it = f"  (then also changed: {moved})" if moved else ""
    if way.after is None:
        return f"{way.field}: {_word(way.before)} -> left out; its rule then gives the value{with_it}"
    return f"{way.field}: {_word(way.before)} -> {_word(way.after)}{with_it}"


def _setting(value: Any) -> str:
    if isinstance(value, Times):
        return f"times {value.factor:g}"
    return "left out" if isinstance(value, Out) else _word(value)


def _word(value: Any) -> str:
    if value is None:
        return "left out"
    return value if isinstance(value, str) else flow(value)


def _coloured(diff: str) -> Iterator[str]:
    for line in diff.splitlines():
        colour = {"+": "32", "-": "31", "@": "36"}.get(line[:1])
        yield f"\x1b[{colour}m{line}\x1b[0m" if colour and coloured() else line


def _as_json(found: Solution, before: str, after: str | None) -> dict[str, Any]:
    words: dict[str, Any] = {
        "design": str(found.question.path),
        "passes": after is not None,
        "trials": found.trials,
        "changes": [asdict(change) for change in found.changes],
        "patch": None if after is None else difference(before, after, str(found.question.path)),
        "conflict": None,
    }
    if found.conflict is not None:
        conflict = found.conflict
        words["conflict"] = {
            "exclude": list(conflict.exclude),
            "proved": conflict.proved,
            "first": [_give_json(way) for way in conflict.first],
            "either": [_give_json(way) for way in conflict.either],
            "nearest": [{"check": check, "message": message} for check, message in conflict.nearest],
        }
    return words


def _give_json(way: Give) -> dict[str, Any]:
    moves = {field: _setting(value) for field, value in way.moves.items()}
    return {"field": way.field, "before": way.before, "after": way.after, "moves": moves}


def _refuse_other_file(design: Path, apply: Path) -> None:
    """Raise ``InputError`` if the result would replace a file other than the design itself."""
    refuse_missing_folder(apply)
    if apply.exists() and apply.resolve() != design.resolve():
        problem = Problem(str(apply), 1, "", "exists already", remedy="choose another name, or remove it first")
        raise InputError([problem])
