"""House rules that a test of the source can hold: class names, the array type, arguments of functions, formatting."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "mbcdm_cad"
MODULES = {path: ast.parse(path.read_text("utf-8")) for path in sorted(PACKAGE.rglob("*.py"))}
# Classes that share a name with another one, and why.
SHARED_NAMES: dict[str, str] = {}
MOST_ARGUMENTS = 8
# A function of the face has what the options of its command have, each by its name.
FACE_OF_COMMANDS = PACKAGE / "api" / "designs.py"


def _where(path: Path, line: int) -> str:
    return f"{path.relative_to(ROOT)}:{line}"


def test_no_two_classes_have_one_name() -> None:
    found: dict[str, list[str]] = defaultdict(list)
    for path, tree in MODULES.items():
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef):
                found[node.name].append(_where(path, node.lineno))
    shared = {name: places for name, places in found.items() if len(places) > 1}
    new = {name: places for name, places in shared.items() if name not in SHARED_NAMES}
    assert not new, "\n".join(f"{name}: {', '.join(places)}" for name, places in new.items())
    gone = set(SHARED_NAMES) - set(shared)
    assert not gone, f"take these out of SHARED_NAMES: {sorted(gone)}"
    many = {name: places for name, places in shared.items() if len(places) > 2}
    assert not many, f"two of a name are explained, not more: {many}"


def _assigned(tree: ast.Module) -> Iterator[tuple[str, int]]:
    for node in tree.body:
        if isinstance(node, ast.Assign):
            yield from ((t.id, node.lineno) for t in node.targets if isinstance(t, ast.Name))
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            yield node.target.id, node.lineno


def test_the_array_type_is_defined_once() -> None:
    places = [_where(p, line) for p, tree in MODULES.items() for name, line in _assigned(tree) if name == "Floats"]
    assert len(places) == 1, f"Floats is defined at {places}"


def test_no_function_takes_too_many_arguments() -> None:
    """Here lambdas and inner functions count as well; the linter counts the same but for ``self``."""
    over = []
    for path, tree in MODULES.items():
        for node in ast.walk(tree):
            if path != FACE_OF_COMMANDS and isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
                names = [a.arg for a in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs)]
                count = len([name for name in names if name not in ("self", "cls")])
                if count > MOST_ARGUMENTS:
                    over.append(f"{_where(path, node.lineno)}: {count} arguments")
    assert not over, "\n".join(over)


def test_the_formatter_is_never_switched_off() -> None:
    mark = "fmt" + ": skip"
    found = [
        _where(path, line)
        for folder in (PACKAGE, ROOT / "tests", ROOT / "benchmarks")
        for path in sorted(folder.rglob("*.py"))
        for line, text in enumerate(path.read_text("utf-8").splitlines(), start=1)
        if mark in text
    ]
    assert not found, "\n".join(found)


# Paths that the pages for contributors name are there: a file that moves takes its mention along.


# Words in capitals stand for any name.
_ANY = re.compile(r"NAME|KIND|FORMAT")
_PATH = re.compile(r"`([\w.*/-]+/[\w.*-]+/?)`")


@pytest.mark.parametrize("page", ["docs/architecture.md", "docs/CONTRIBUTING.md"])
def test_every_path_of_a_page_is_there(page: str) -> None:
    lines = (ROOT / page).read_text("utf-8").splitlines()
    named = [(number, path) for number, line in enumerate(lines, 1) for path in _PATH.findall(line)]
    assert len(named) > 10, named
    gone = [
        f"{page}:{number}: {path}"
        for number, path in named
        if not any(True for room in (ROOT, ROOT / "mbcdm_cad") for _ in room.glob(_ANY.sub("*", path).rstrip("/")))
    ]
    assert not gone, "\n".join(gone)
