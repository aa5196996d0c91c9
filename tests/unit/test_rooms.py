"""The order of the rooms, read from the imports; and that no room outside layouts/ knows one of them."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from mbcdm_cad.layouts import registry

PACKAGE = Path(__file__).parents[2] / "mbcdm_cad"
# A room may import from those before it and from itself. ``errors`` may be imported everywhere.
ORDER = (
    "errors",
    "storage",
    "design",
    "sizing",
    "routes",
    "face",
    "model",
    "parts",
    "checks",
    "layouts",
    "solving",
    "drawings",
    "build",
    "report",
    "robot",
    "measurement",
    "loop",
    "rig",
    "planning",
    "paper",
    "api",
    "live",
    "cli",
)
# What all rooms may know of configurations: that there are some, and what each supplies.
FACE = ("layouts", "layouts.interface", "layouts.registry")
# Imports against the order that are known: the importing module, the imported room, and why. None may be added without
# a reason; one that is no longer there fails the test as well.
AGAINST_THE_ORDER: dict[tuple[str, str], str] = {
    ("build.run", "report"): "the job writes the report, whose figures come from the built parts",
}
# Files outside layouts/ that hold a configuration's name or a guide as an identifier, and why.
NAMED: dict[str, str] = {
    "rig.dynamic.experiment": "experiment files of before say guide_mNm and guide_slip; these words stay valid",
    "rig.effects.bearing_friction": "experiment files of before say guide_mNm and guide_slip; these words stay valid",
    "rig.quasistatic.experiment": "experiment files of before say guide_mNm and guide_slip; these words stay valid",
}


def _files() -> list[Path]:
    return sorted(path for path in PACKAGE.rglob("*.py"))


def _module(path: Path) -> str:
    return ".".join(path.relative_to(PACKAGE).with_suffix("").parts).removesuffix(".__init__")


def _room(module: str) -> str:
    return "face" if module in FACE else module.partition(".")[0]


def _at_run_time(node: ast.AST) -> Iterator[ast.AST]:
    """The nodes below ``node``, but for what only a type checker reads."""
    for child in ast.iter_child_nodes(node):
        if not (isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING"):
            yield child
            yield from _at_run_time(child)


def _imported_rooms(path: Path) -> Iterator[tuple[str, int]]:
    for node in _at_run_time(ast.parse(path.read_text("utf-8"))):
        names: list[str] = []
        if isinstance(node, ast.ImportFrom) and node.module == "mbcdm_cad":
            names = [f"mbcdm_cad.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names = [node.module]
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        for name in names:
            room = _room(name.removeprefix("mbcdm_cad."))
            if name.startswith("mbcdm_cad.") and room in ORDER:
                yield room, node.lineno


def test_every_room_has_its_place_in_the_order() -> None:
    rooms = {_room(_module(path)) for path in _files()} - {"__init__", "__main__", ""}
    assert rooms <= set(ORDER), f"give these a place in ORDER: {sorted(rooms - set(ORDER))}"


def test_imports_point_back_along_the_order() -> None:
    place = {room: k for k, room in enumerate(ORDER)}
    against: dict[tuple[str, str], str] = {}
    for path in _files():
        module = _module(path)
        if _room(module) in place:
            for room, line in _imported_rooms(path):
                if place[room] > place[_room(module)]:
                    against[module, room] = f"{path.relative_to(PACKAGE.parent)}:{line} imports {room}"
    new = {key: where for key, where in against.items() if key not in AGAINST_THE_ORDER}
    assert not new, "\n".join(new.values())
    gone = set(AGAINST_THE_ORDER) - set(against)
    assert not gone, f"take these out of AGAINST_THE_ORDER: {sorted(gone)}"


def _identifiers(path: Path) -> Iterator[tuple[str, int]]:
    """Names in the code, and strings that look like one: attributes are also looked up by their names."""
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
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


def _named(path: Path) -> list[str]:
    words = re.compile("|".join(["guide", *registry.names()]), re.IGNORECASE)
    where = path.relative_to(PACKAGE.parent)
    return [f"{where}:{line}: {name}" for name, line in _identifiers(path) if words.search(name)]


def test_no_room_outside_names_a_configuration_or_its_guide() -> None:
    found = {
        _module(path): _named(path) for path in _files() if _room(_module(path)) not in ("layouts", "face", "paper")
    }
    named = {module: lines for module, lines in found.items() if lines}
    new = {module: lines for module, lines in named.items() if module not in NAMED}
    assert not new, "\n".join(line for lines in new.values() for line in lines)
    gone = set(NAMED) - set(named)
    assert not gone, f"take these out of NAMED: {sorted(gone)}"


@pytest.mark.parametrize("table", [AGAINST_THE_ORDER, NAMED])
def test_exceptions_have_reasons(table: dict[object, str]) -> None:
    assert all(len(reason) > 15 for reason in table.values()), table
