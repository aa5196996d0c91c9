"""Rewrite the kernel's STEP text in a canonical form, so that the same model gives the same text.

Five things differ in the kernel's text although the model is the same: the time in the header, the ids of the
NEXT_ASSEMBLY_USAGE_OCCURRENCEs (they count up within a process), the number of an entity, the order of the colour
blocks (it follows memory addresses) and the sign of zero (it is lost when a solid is stored and read). Here the header
is written anew, entities are numbered depth first from the roots in a fixed order, occurrences are counted from 1,
no zero has a sign, and each entity stands on one line.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

# Blocks that nothing refers to, in random order in the kernel's text: sorted by their content.
_UNORDERED = ("MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION", "PROPERTY_DEFINITION_REPRESENTATION")
_OCCURRENCE = re.compile(r"NEXT_ASSEMBLY_USAGE_OCCURRENCE\('[^']*'")
_ENTITY = re.compile(r"#(\d+)\s*=\s*((?:[^';]+|'[^']*')*);")
_TOKEN = re.compile(r"'[^']*'|#(\d+)")
_LAYOUT = re.compile(r"('[^']*')|\s+|-0\.(?=[\s,)])")
_UNIT_ELEMENT = re.compile(r"DERIVED_UNIT_ELEMENT\(#(\d+),[-0-9.]+\)")
_FIXED_TIME = "1970-01-01T00:00:00"


def canonical_step(text: str, name: str, description: str) -> str:
    """The kernel's STEP ``text`` in canonical form, with ``name`` and ``description`` in its header.

    Raises ``ValueError`` if the text has no data section.
    """
    try:
        data = text[text.index("\nDATA;") + len("\nDATA;") : text.rindex("ENDSEC;")]
        schema = text[text.index("FILE_SCHEMA") : text.index("ENDSEC;")]
    except ValueError:
        raise ValueError(f"no STEP data section in {len(text)} characters that start with {text[:40]!r}") from None
    entities = {int(number): _without_layout(body) for number, body in _ENTITY.findall(data)}
    _correct_density_units(entities)
    lines = (f"#{new}={body};" for new, body in _renumbered(entities))
    return "\n".join(
        (
            "ISO-10303-21;",
            *_header(name, description, _without_layout(schema)),
            "DATA;",
            *lines,
            "ENDSEC;",
            "END-ISO-10303-21;",
            "",
        )
    )


def with_description(text: str, description: str) -> str:
    """A canonical STEP text with another description in its header; everything else stays."""
    first = text.index("FILE_DESCRIPTION")
    return text[:first] + _description(description) + text[text.index("\n", first) :]


def _header(name: str, description: str, schema: str) -> list[str]:
    stamp = f"FILE_NAME({_string(name)},'{_FIXED_TIME}',(''),(''),'Open CASCADE','mbcdm_cad','');"
    return ["HEADER;", _description(description), stamp, schema, "ENDSEC;"]


def _description(description: str) -> str:
    return f"FILE_DESCRIPTION(({_string(description)}),'2;1');"


def _string(text: str) -> str:
    r"""A STEP string: quotes and backslashes doubled, other characters than printable ASCII as ``\X4\`` code points."""
    plain = "".join(c if " " <= c <= "~" else f"\\X4\\{ord(c):08X}\\X0\\" for c in text.replace("\\", "\\\\"))
    return "'" + plain.replace("'", "''") + "'"


def _without_layout(body: str) -> str:
    """The body on one line: no white space and no minus zero outside strings, no line break inside them."""
    if body.count("'") == 2 * body.count("''") and "-0." not in body:
        return "".join(body.split())  # most bodies contain no text; this case is three times as fast
    return _LAYOUT.sub(lambda match: match[1].replace("\n", "") if match[1] else match[0].strip().lstrip("-"), body)


def _correct_density_units(entities: dict[int, str]) -> None:
    """Correct the unit of densities: the kernel writes g^3 cm^2 in place of g cm^-3, and reads both as the same."""
    for number, body in entities.items():
        match = _UNIT_ELEMENT.fullmatch(body)
        if match:
            exponent = "1." if "MASS_UNIT" in entities[int(match[1])] else "-3."
            entities[number] = f"DERIVED_UNIT_ELEMENT(#{match[1]},{exponent})"


def _references(body: str) -> list[int]:
    return [int(number) for number in _TOKEN.findall(body) if number] if "#" in body else []


def _renumbered(entities: dict[int, str]) -> Iterator[tuple[int, str]]:
    """(new number, body) of every entity, depth first: the product structure as it comes, then the sorted blocks."""
    references = {number: _references(body) for number, body in entities.items()}
    referred = {target for targets in references.values() for target in targets}
    roots = [number for number in entities if number not in referred]
    new: dict[int, int] = {}

    def visit(root: int) -> None:
        stack = [root]
        while stack:
            number = stack.pop()
            if number not in new:
                new[number] = len(new) + 1
                stack.extend(reversed(references[number]))

    def meaning(number: int) -> str:
        """Content of an unordered block: its text with the numbers given so far, and other entities written out."""
        return _TOKEN.sub(
            lambda m: m[0] if not m[1] else f"#{new[int(m[1])]}" if int(m[1]) in new else meaning(int(m[1])),
            entities[number],
        )

    for root in roots:
        if not entities[root].startswith(_UNORDERED):
            visit(root)
    # The keys are computed before any of these blocks is numbered, so blocks with equal keys are interchangeable.
    for root in sorted((root for root in roots if entities[root].startswith(_UNORDERED)), key=meaning):
        visit(root)

    occurrences = 0
    for number, position in new.items():
        body = entities[number]
        if references[number]:
            body = _TOKEN.sub(lambda m: f"#{new[int(m[1])]}" if m[1] else m[0], body)
        if body.startswith("NEXT_ASSEMBLY_USAGE_OCCURRENCE"):
            occurrences += 1
            body = _OCCURRENCE.sub(f"NEXT_ASSEMBLY_USAGE_OCCURRENCE('{occurrences}'", body, count=1)
        yield position, body
