"""The drive as built: write named effects into the design file."""

import math
from collections.abc import Sequence
from typing import Any

import yaml

from mbcdm_cad.design import yamltree
from mbcdm_cad.design.describe import flow
from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.loop.result import LoopResult, Named

KEY = "as_built"
# Correlations below this are left out.
LEAST_CORRELATION = 0.01
_HEADING = "# Effects that the built drive was found to have, written by 'mbcdm loop --apply'"


def as_built_text(loaded: LoadedDesign, result: LoopResult, source: str = "") -> str:
    """The text of the design file with the effects that ``result`` names added to its list ``as_built``.

    Nothing else of the text changes. Members of a set are written as comments; removing the comment marks of one puts
    it in force. Comments that an earlier run wrote are removed, because this run has judged the set again. ``source``
    names the run.
    """
    lines = loaded.text.split("\n")
    start, end = _block(loaded.text, lines)
    before = yamltree.parse(loaded.text, str(loaded.path)).data.get(KEY) or []
    lasting = _lasting(result.effects)
    entries = before + [
        _entry(named, source) | _correlated(named, lasting[: k + 1], len(before)) for k, named in enumerate(lasting)
    ]
    block = [f"{KEY}:" if entries or result.one_of else f"{KEY}: []"]
    for entry in entries:
        block += _written(entry)
    for number, group in enumerate(result.one_of, 1):
        block += _undecided(group, number, len(result.one_of), source)
    if start == end:
        while lines and not lines[-1].strip():
            lines.pop()
        return "\n".join([*lines, "", _HEADING, *block, ""])
    return "\n".join([*lines[:start], *block, *lines[end:]])


def _correlated(named: Named, earlier: Sequence[Named], first: int) -> dict[str, Any]:
    """Correlations of an entry's values with each other and with those of earlier ones, numbered from ``first``."""
    found = []
    for k, other in enumerate(earlier, first):
        table = named.correlated.get(other.words)
        if table is None:
            continue
        for i, own in enumerate(named.fitted):
            for j, name in enumerate(other.fitted):
                if abs(table[i, j]) >= LEAST_CORRELATION and (other is not named or j < i):
                    found.append({"own": own, "entry": k, "other": name, "correlation": round(float(table[i, j]), 3)})
    return {"correlated": found} if found else {}


def _lasting(effects: Sequence[Named]) -> list[Named]:
    """What the drive has after the runs, as a design file holds it: of a change what it left, in place of what was."""
    changed = [named.after for named in effects if named.after]
    gone = {(one.name, one.form, one.stage, one.cables) for one in changed}
    kept = [named for named in effects if not named.after and named.fitted]
    return [named for named in kept if (named.name, named.form, named.stage, named.cables) not in gone] + changed


def applied_words(result: LoopResult) -> str:
    """What :func:`as_built_text` wrote, for the terminal."""
    held = [named for named in result.effects if named.fitted or named.after]
    words = [f"{', '.join(named.words for named in held)} in force"] if held else []
    words += [
        f"undecided, as comments: {' or '.join(named.words for named in group)} "
        "(remove the comment marks of the one that the bench confirms)"
        for group in result.one_of
    ]
    return "; ".join(words) or (
        "nothing was named that a design file holds, so the design is unchanged"
        if result.effects
        else "no effect was named, so the design is unchanged"
    )


def _undecided(group: Sequence[Named], number: int, count: int, source: str) -> list[str]:
    """Members of a set as comments. A line of words has two marks: it is still a comment when one mark is removed."""
    which = f"set {number} of {count}: " if count > 1 else ""
    lines = [
        f"  ## UNDECIDED, {which}the runs cannot tell which one of these {len(group)} it is. None is in force.",
        "  ## Put the one in force that the bench confirms: take '# ', the mark and one blank, off each of its lines.",
    ]
    for k, named in enumerate(group, 1):
        lines.append(f"  ## {k}. {named.words} ({named.form}); look at: {named.where_to_look}".rstrip())
        if named.fitted:
            lines += [f"  # {line[2:]}" for line in _written(_entry(named, source))]
    return lines


def _block(text: str, lines: list[str]) -> tuple[int, int]:
    """First line of the list and the one after its last; two equal numbers where the file has none."""
    root = yaml.compose(text, Loader=yaml.SafeLoader)
    assert isinstance(root, yaml.MappingNode), "a design file that was read is a mapping"
    for key, value in root.value:
        if key.value == KEY:
            start, end = key.start_mark.line, value.end_mark.line + (value.end_mark.column > 0)
            end = max(end, start + 1)
            # A block list ends where the next field begins; blank lines and comments before that field belong to it.
            while end > start + 1 and (not lines[end - 1].strip() or lines[end - 1].startswith("#")):
                end -= 1
            # Indented comments belong to the list, also where the list has nothing else.
            while end < len(lines) and lines[end].startswith(" ") and lines[end].lstrip().startswith("#"):
                end += 1
            return start, end
    return 0, 0


def _entry(named: Named, source: str) -> dict[str, Any]:
    values = [_value(name, value, named) for name, value in named.fitted.items()]
    where = {"stage": named.stage, "cables": list(named.cables)}
    more = {key: value for key, value in where.items() if value}
    return {"name": named.name, "form": named.form, **more, "values": values} | ({"source": source} if source else {})


def _value(name: str, value: float, named: Named) -> dict[str, Any]:
    """A fitted value with its interval, where it is known to both sides."""
    found: dict[str, Any] = {"name": name, "value": value}
    half = named.half_widths.get(name, 0.0)
    figure = named.parameters.get(name)
    if figure is not None:
        ends = figure.low, figure.high
    elif half and all(math.isfinite(one.high) for one in named.parameters.values()):
        ends = value - half, value + half
    else:
        return found
    return found | ({"low": ends[0], "high": ends[1]} if all(map(math.isfinite, ends)) else {})


def _written(entry: dict[str, Any]) -> list[str]:
    """One entry as YAML, a line a field."""
    lists = {key: value for key, value in entry.items() if key in ("values", "correlated")}
    rest = [f"    {key}: {flow(value)}" for key, value in entry.items() if key not in ("name", *lists)]
    items = [line for key, rows in lists.items() for line in (f"    {key}:", *("      - " + flow(row) for row in rows))]
    return [f"  - name: {entry['name']}", *rest, *items]
