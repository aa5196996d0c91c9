"""Numbers and documents as both robot formats write them."""

from __future__ import annotations

from collections.abc import Iterable
from xml.etree import ElementTree as ET


def document(root: ET.Element) -> bytes:
    """The file, indented; the same tree gives the same bytes."""
    ET.indent(root)
    return bytes(ET.tostring(root, encoding="utf-8", xml_declaration=True)) + b"\n"


def numbers(values: Iterable[float]) -> str:
    """Values with ten digits, between spaces."""
    return " ".join(f"{value:.10g}" for value in values)


def triangle(inertia: tuple[tuple[float, ...], ...]) -> dict[str, float]:
    """The six terms of a symmetric tensor by name."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = inertia
    return {"ixx": xx, "ixy": xy, "ixz": xz, "iyy": yy, "iyz": yz, "izz": zz}
