"""Finds the sheet that belongs to a part's drawing function: ``create_x`` of ``.../draw.py`` has ``x_sheet`` in
``.../sheet.py`` beside it, with the same arguments after the part's name. In a module of another name, ``y.py``, it is
``y_sheet.py``."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import Any

from mbcdm_cad.parts.bill import Bill
from mbcdm_cad.parts.sheets.description import Sheet


def sheet_module(maker: str) -> str:
    """Full name of the module that describes the sheet of ``module:function``."""
    module = maker.partition(":")[0]
    return module.removesuffix(".draw") + ".sheet" if module.endswith(".draw") else module + "_sheet"


def has_sheet(maker: str) -> bool:
    """Whether the part of a drawing function has a sheet."""
    return find_spec(sheet_module(maker)) is not None


def sheet_of(part: str, maker: str, args: tuple[Any, ...]) -> Sheet:
    """The sheet of a part. Raises ``LookupError`` naming part and function where there is none."""
    name = maker.partition(":")[2].removeprefix("create_") + "_sheet"
    try:
        describe = getattr(import_module(sheet_module(maker)), name)
    except (ImportError, AttributeError) as error:
        raise LookupError(
            f"{part}: no sheet {name} in {sheet_module(maker)}; every made part has one, with the arguments of "
            f"{maker.partition(':')[2]}"
        ) from error
    sheet = describe(part, *args)
    assert isinstance(sheet, Sheet)
    return sheet


def holes_of(bill: Bill) -> dict[str, list[dict[str, Any]]]:
    """The holes of each made part that has some, as its sheet's table gives them, by the part's name."""
    found = {}
    for name in dict.fromkeys(item.part for item in bill.items if item.kind == "made"):
        spec = bill.parts[name]
        if has_sheet(spec.maker):
            groups = sheet_of(name, spec.maker, spec.args).holes
            if groups:
                found[name] = [group.data() for group in groups]
    return found
