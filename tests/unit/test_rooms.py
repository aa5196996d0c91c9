"""The order of the rooms, read from the imports; and that no room outside layouts/ knows one of them."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

from mbcdm_cad.layouts import registry
from tests.house_counts import ROOMS, House, back_arrows, room

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
