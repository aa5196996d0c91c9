"""What the redesign has reached does not grow again: counts of the code with their limits."""

import ast
import json
import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import pytest

from mbcdm_cad.layouts import registry
from tests.house_counts import (
    ROOMS,
    House,
    back_arrows,
    circle_members,
    counts,
    docs_lines_by_hand,
    field_path_strings,
    repeats,
    room,
    room_lines,
    search_thresholds,
    short_helpers,
    twice_declared,
)

TREE = Path(__file__).parents[2]
# Largest allowed counts. A change that reaches less lowers them; they are raised only while an old and a new way stand
# side by side. Meanings: the docstrings of tests/house_counts.py.
LIMITS: dict[str, float] = json.loads((TREE / "tests" / "house_limits.json").read_text("utf-8"))
# What the owners of the project allow; it lies beside a checkout, not in it.
BUDGET = TREE.parent / "shared" / "budget.json"


@pytest.fixture(scope="module")
def found() -> dict[str, float]:
    """The counts of this tree."""
    return counts(House(TREE))


@pytest.mark.parametrize("name", LIMITS)
def test_a_count_is_within_its_limit(found: dict[str, float], name: str) -> None:
    assert found[name] <= LIMITS[name], f"{name}: {found[name]}; list: python tests/house_counts.py --help"


def test_every_count_has_a_limit(found: dict[str, float]) -> None:
    assert set(found) == set(LIMITS)


@pytest.mark.skipif(not BUDGET.is_file(), reason="the owners' budget is not beside this checkout")
def test_no_limit_stands_above_the_ceiling() -> None:
    ceilings = json.loads(BUDGET.read_text("utf-8"))["ceiling"]
    assert {name: LIMITS[name] for name, most in ceilings.items() if LIMITS[name] > most} == {}


def _house(folder: Path, **modules: str) -> House:
    (folder / "mbcdm_cad").mkdir()
    for name, text in modules.items():
        (folder / "mbcdm_cad" / f"{name}.py").write_text(text)
    return House(folder)


def test_the_same_code_with_other_names_is_a_repeating_pair(tmp_path: Path) -> None:
    body = "\n".join(f"    {{0}}{k} = other({{0}}{', {0}' * k}) - {{0}} / 2" for k in range(8))
    one, two = (f"import os\n\ndef {name}({name}):\n" + body.format(name) + "\n" for name in ("first", "second"))
    assert [pair[:4] for pair in repeats(_house(tmp_path, one=one, two=two))] == [("one", 3, "two", 3)]


def test_texts_pages_helpers_paths_and_thresholds_are_counted(tmp_path: Path) -> None:
    helper = "def _once(x):\n    return x\n\ndef call():\n    return _once('drum.hub_mm'), 'drum', 'other.hub_mm'\n"
    (tmp_path / "mbcdm_cad" / "loop" / "search").mkdir(parents=True)
    (tmp_path / "mbcdm_cad" / "loop" / "search" / "judge.py").write_text(
        "LEAST = (0.45, 2.0)\nNAME = 'x'\ndef f(x):\n    return x > 3.5 or x > 0\n" + helper
    )
    for name, text in {
        "docs/checks.md": "a\n",
        "docs/how/to.md": "a\nb\n",
        "params/a.yaml": "drum:\n  hub_mm: 1\n",
    }.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    house = House(tmp_path)
    assert docs_lines_by_hand(house) == 2
    assert short_helpers(house) == [("loop.search.judge", "_once")]
    assert field_path_strings(house) == 1
    assert search_thresholds(house) == 2
    assert room_lines(house)["loop"] == 9


def test_a_circle_through_a_function_or_a_type_is_found(tmp_path: Path) -> None:
    one = "def call():\n    from mbcdm_cad import two\n"
    two = "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from mbcdm_cad.one import call\n"
    assert circle_members(_house(tmp_path, one=one, two=two, three="import mbcdm_cad.two\n")) == [["one", "two"]]


@pytest.mark.parametrize("base", ["BaseModel", "PlainBlock"])
def test_fields_that_are_read_and_used_by_two_classes_are_found(base: str, tmp_path: Path) -> None:
    read = f"class Block({base}):\n    a: int\n    b: int\n    c: int\n"
    used = "class Plain:\n    a: int\n    b: int\n    c: int\n    d: int\n"
    assert twice_declared(_house(tmp_path, design=read + used)) == [("design.Block", "design.Plain", 3)]


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


HOUSE = House(Path(__file__).parents[2])
# Files outside layouts/ that hold a configuration's name or a guide as an identifier, and why.
NAMED: dict[str, str] = {
    "rig.experiment": "experiment files of before say guide_mNm and guide_slip; these words stay valid",
    "rig.effects.machine": "experiment files of before say guide_mNm and guide_slip; these words stay valid",
    "rig.bench": "experiment files of before say guide_mNm and guide_slip; these words stay valid",
}


def test_every_room_has_its_place_in_the_order() -> None:
    rooms = {room(module) for module in HOUSE.files} - {"__init__", "__main__", ""}
    assert rooms <= set(ROOMS), f"give these a place in ROOMS: {sorted(rooms - set(ROOMS))}"


def test_imports_point_back_along_the_order() -> None:
    assert not back_arrows(HOUSE), "\n".join(f"{module} imports {other}" for module, other in back_arrows(HOUSE))


def _identifiers(module: str) -> Iterator[tuple[str, int]]:
    """Names in the code, and strings that look like one: attributes are also looked up by their names."""
    for node in ast.walk(HOUSE.trees[module]):
        match node:
            case ast.Name(id=name) | ast.Attribute(attr=name) | ast.arg(arg=name):
                yield name, node.lineno
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name):
                yield name, node.lineno
            case ast.keyword(arg=str(name)):
                yield name, node.value.lineno
            case ast.ImportFrom(module=str(name)) | ast.alias(name=name):
                yield name, node.lineno
            case ast.Constant(value=str(text)) if re.fullmatch(r"[\w.]+", text):
                yield text, node.lineno


def _named(module: str) -> list[str]:
    words = re.compile("|".join(["guide", *registry.names()]), re.IGNORECASE)
    where = HOUSE.files[module].relative_to(HOUSE.tree)
    return [f"{where}:{line}: {name}" for name, line in _identifiers(module) if words.search(name)]


def test_no_room_outside_names_a_configuration_or_its_guide() -> None:
    found = {module: _named(module) for module in HOUSE.files if room(module) not in ("layouts", "face", "paper")}
    named = {module: lines for module, lines in found.items() if lines}
    new = {module: lines for module, lines in named.items() if module not in NAMED}
    assert not new, "\n".join(line for lines in new.values() for line in lines)
    gone = set(NAMED) - set(named)
    assert not gone, f"take these out of NAMED: {sorted(gone)}"


def test_exceptions_have_reasons() -> None:
    assert all(len(reason) > 15 for reason in NAMED.values()), NAMED
