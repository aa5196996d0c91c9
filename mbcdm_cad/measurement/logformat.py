"""The format of a logger's file: separator, place of the names, first row of data; its units and their SI values."""

import math
import re
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from mbcdm_cad.design.blocks import STANDARD_GRAVITY_M_S2
from mbcdm_cad.errors import InputError, Problem

COUNTS = "counts"


@dataclass(frozen=True)
class Unit:
    """SI value = ``factor`` times the figure + ``shift``."""

    factor: float
    shift: float = 0.0


def _scaled(*spelt: tuple[str, float]) -> dict[str, Unit]:
    return {name: Unit(factor) for names, factor in spelt for name in names.split()}


# Dates and times as ISO 8601 writes them; the reader turns them into seconds.
ISO_CLOCK = "iso8601"
TIME = _scaled(
    (ISO_CLOCK, 1.0),
    ("s sec second seconds", 1.0),
    ("ms", 1e-3),
    ("us µs", 1e-6),
    ("ns", 1e-9),
    ("min", 60.0),
    ("h", 3600.0),
)
ANGLE = _scaled(
    ("rad", 1.0),
    ("mrad", 1e-3),
    ("urad µrad", 1e-6),
    ("deg degree degrees °", math.pi / 180.0),
    ("arcmin", math.pi / 10800.0),
    ("arcsec", math.pi / 648000.0),
    ("turn turns rev", 2.0 * math.pi),
)
_KGF = STANDARD_GRAVITY_M_S2
TORQUE = _scaled(
    ("N*m Nm N.m", 1.0),
    ("mN*m mNm mN.m N*mm Nmm N.mm", 1e-3),
    ("N*cm Ncm N.cm", 1e-2),
    ("uN*m uNm µN*m", 1e-6),
    ("kgf*m", _KGF),
    ("kgf*cm kgfcm", 1e-2 * _KGF),
    ("gf*cm gfcm", 1e-5 * _KGF),
    ("ozf*in", 28.349523125e-3 * 0.0254 * _KGF),
    ("lbf*in", 0.45359237 * 0.0254 * _KGF),
    ("lbf*ft", 0.45359237 * 0.3048 * _KGF),
)
# A force with its lever arm gives a torque.
FORCE = _scaled(("N", 1.0), ("mN", 1e-3), ("kN", 1e3), ("kgf", _KGF), ("gf", 1e-3 * _KGF), ("lbf", 0.45359237 * _KGF))
# A length at a radius gives an angle.
LENGTH = _scaled(("mm", 1e-3), ("um µm", 1e-6), ("m", 1.0), ("in", 0.0254))
# Temperatures stay in degC: the effects use only their differences.
TEMPERATURE = {
    **dict.fromkeys(("degC", "°C", "C"), Unit(1.0)),
    **dict.fromkeys(("K",), Unit(1.0, -273.15)),
    **dict.fromkeys(("degF", "°F", "F"), Unit(5.0 / 9.0, -160.0 / 9.0)),
}

CURRENT = _scaled(("A", 1.0), ("mA", 1e-3), ("uA µA", 1e-6))
MASS = _scaled(("kg", 1.0), ("g", 1e-3), ("lb", 0.45359237))
ORDER = _scaled(("cycle/rad cycles/rad 1/rad", 1.0), ("cycle/turn cycles/turn 1/turn", 0.5 / math.pi))

FREQUENCY = _scaled(("Hz 1/s", 1.0), ("kHz", 1e3), ("rad/s", 0.5 / math.pi), ("rpm", 1.0 / 60.0))
# A gain in decibels is no multiple of one; the others are ratios of angles, or angles over a torque.
DECIBEL = "dB"
RATIO = _scaled(("- rad/rad deg/deg", 1.0))
GIVE = _scaled(
    ("rad/(N*m) rad/Nm", 1.0),
    ("mrad/(N*m) mrad/Nm", 1e-3),
    ("urad/(N*m) urad/Nm", 1e-6),
    ("deg/(N*m) deg/Nm", math.pi / 180),
)

KINDS = {
    "time": TIME,
    "input": ANGLE,
    "output": ANGLE,
    "load_torque": TORQUE,
    "temperature": TEMPERATURE,
    "current": CURRENT,
    "excitation": ANGLE | TORQUE | CURRENT | {"V": Unit(1.0), "-": Unit(1.0)},
    "frequency": FREQUENCY,
    "gain": {DECIBEL: Unit(1.0)} | RATIO | GIVE,
    "phase": ANGLE,
    "coherence": _scaled(("-", 1.0), ("%", 0.01)),
    "amplitude": ANGLE | TORQUE,
    "peak_torque": TORQUE,
    "mass": MASS,
    "backlash": ANGLE,
    "ripple_amplitude": ANGLE,
    "ripple_order": ORDER,
}
ENCODERS = ("input", "output")
LOAD = "load_torque"


def unit_of(
    quantity: str,
    name: str,
    counts_per_turn: float | None = None,
    lever_arm_mm: float | None = None,
    radius_mm: float | None = None,
) -> Unit | None:
    """The unit called ``name`` of a column ``quantity``, None if there is no such unit.

    Encoder counts need ``counts_per_turn``, a force as load torque needs ``lever_arm_mm``, a length as angle needs
    ``radius_mm``: the angle is the length over the radius.
    """
    kind = kind_of(quantity)
    spelt = name.strip().replace(" ", "").replace("·", "*").replace("μ", "µ")
    if spelt in (COUNTS, "count") and kind in ENCODERS and counts_per_turn is not None:
        return Unit(2.0 * math.pi / counts_per_turn)
    if kind == LOAD and spelt in FORCE and lever_arm_mm is not None:
        return Unit(FORCE[spelt].factor * 1e-3 * lever_arm_mm)
    if kind in ENCODERS and spelt in LENGTH and radius_mm is not None:
        return Unit(LENGTH[spelt].factor / (1e-3 * radius_mm))
    return KINDS[kind].get(spelt)


def known_units(quantity: str) -> list[str]:
    """Names to offer for a column."""
    kind = kind_of(quantity)
    return [*KINDS[kind], *([COUNTS, *LENGTH] if kind in ENCODERS else []), *(FORCE if kind == LOAD else [])]


def kind_of(quantity: str) -> str:
    """The kind of quantity of a column; all inputs are of one kind, whatever their names."""
    return next((kind for kind in ("input", "current") if quantity.startswith(f"{kind}_")), quantity)


# Longest line of a logger's file: a file without a line end within this length is not a table.
LONGEST_LINE = 1 << 16
# Rows used to find delimiter, number of columns and header, and largest number of lines before the data.
FIRST_ROWS = 50
LONGEST_PREAMBLE = 100_000
# Largest number of rows of units, channels and the like below the names, and largest length of one of their cells.
MOST_UNITS = 3
# So many lines of figures are rows of the table.
ROWS_IN_A_ROW = 4
# So many rows whose cells have names before colons make a table of such rows.
FEWEST_LABELLED = 10
LONGEST_UNIT = 12
# Serial monitors write a time of day and this before what the device sent.
ARROW = " -> "
# A line of candump: (1436509052.249713) can0 044#2A366C2BBA, with or without -l.
_CAN_FRAME = re.compile(rb"\s*(\([\d.:\s-]+\)\s+)?v?s?l?can\d+\s+[0-9A-Fa-f]{3,8}(#|\s+\[\d+\])")
_IN_BRACKETS = re.compile(r"[\[(]\s*([^\[\]()]+?)\s*[\])]\s*\Z")
# A cell with its name, as motor:1.25.
_LABEL = re.compile(r"[A-Za-z_][^:]*:\s*[-+]?[\d.]")
# A list in a cell, as of a bag's messages or a printed array, and the sign between its elements once it is read.
_LIST, WITHIN = re.compile(r"(?<!\w)(?:array\('\w', )?\[([^\[\]]*)\]\)?"), "\x1f"
SIGNS = {"comma": ",", "semicolon": ";", "tab": "\t", "space": None}
Lines = list[tuple[int, str]]


@dataclass(frozen=True)
class Format:
    """Layout of the file. ``sign`` is None for runs of blanks; ``names`` is empty without a header.

    ``begin_line`` is the first line (from 1) that may hold figures, ``fields`` the number of columns. ``units`` are the
    cells of the first row below the names where no row down to ``units_line`` has a figure; empty and 0 without one.
    ``unnamed`` says that rows hold more than the header names, ``labelled`` that each cell has its name before a colon,
    as Arduino's plotter wants it.
    """

    sign: str | None
    decimal_comma: bool
    comment: str
    names: tuple[str, ...]
    header_line: int
    begin_line: int
    fields: int
    units: tuple[str, ...] = ()
    units_line: int = 0
    unnamed: bool = False
    labelled: bool = False

    def told(self, index: int) -> tuple[str, str]:
        """Name of a column, and its unit by the row of units or by brackets at the end of the name; empty for none."""
        name = self.names[index] if index < len(self.names) else ""
        unit = self.units[index] if index < len(self.units) else ""
        inside = _IN_BRACKETS.search(name)
        return name, unit.strip("[]() ") or (inside[1] if inside else "")

    def cells(self, line: str) -> list[str]:
        """Cells of a line, without the labels of a table that repeats its names in each row."""
        found = split(line, self.sign)
        return [_without_label(cell) for cell in found] if self.labelled else found


def wrong(path: Path, line: int, what: str, remedy: str, value: str = "", limit: str = "") -> InputError:
    """The error of one thing that is wrong with a logger's file."""
    return InputError([Problem(str(path), line, "", what, value, limit, remedy)])


def too_long(path: Path, number: int) -> InputError:
    """The error for a file without line ends, which is not a table."""
    most, remedy = f"{LONGEST_LINE} bytes", "give a text file with one row a line, ended by LF or CR LF"
    return wrong(path, number, "a line too long", remedy, f"over {most}", most)


def split(line: str, sign: str | None) -> list[str]:
    """Cells of a line, without blanks and quotes around them; an arrow after a time stamp divides them too.

    Each element of a cell that is a list is a cell of its own.
    """
    return [part for cell in _whole(line, sign) for part in cell.split(WITHIN)]


def _whole(line: str, sign: str | None) -> list[str]:
    """Cells of a line, the elements of a list joined by WITHIN."""
    if ARROW in line:
        line = line.replace(ARROW, sign or " ", 1)
    if "[" in line:
        line = _LIST.sub(_elements, line)
    return [cell.strip().strip("\"'").strip() for cell in line.strip("\r\n").split(sign)]


def _elements(found: re.Match[str]) -> str:
    """The elements of a list; a unit in brackets stays as it is."""
    parts = found[1].split(",") if "," in found[1] else found[1].split()
    listed = "," in found[1] or (bool(parts) and all(_is_figure(part, False) for part in parts))
    return WITHIN.join(part.strip(" \t\"'") for part in parts) if listed else found[0]


def _names_in_lists(names: tuple[str, ...], line: str, sign: str | None) -> tuple[str, ...]:
    """The names of the elements where cells are lists: by a list of words as long as theirs, else by number."""
    cells = [cell.split(WITHIN) for cell in _whole(line, sign)]
    if len(cells) != len(names) or all(len(parts) == 1 for parts in cells):
        return names
    words = {len(parts): parts for parts in reversed(cells) if not any(_is_figure(part, False) for part in parts)}
    found = list[str]()
    for name, parts in zip(names, cells, strict=True):
        told = words.get(len(parts), parts)
        by = [f"[{k}]" if told is parts else f"/{word}" for k, word in enumerate(told)]
        found += [name] if len(parts) == 1 else [name + end for end in by]
    return tuple(found)


def find_format(path: Path, delimiter: str, decimal: str, comment: str, skip_rows: int, header: str) -> Format:
    """Delimiter, number of columns and place of the names, from the first rows. InputError if there are no rows."""
    comma = decimal == "comma"
    comments, rows = _first_lines(path, comment, skip_rows)
    if not rows:
        raise wrong(path, skip_rows + 1, "no rows", "check the file, skip_rows and comment")
    sign = SIGNS[delimiter] if delimiter != "auto" else _likely_sign(rows, comma)
    labels, greeting = _labels(rows, sign) if header == "auto" else ((), 0)
    rows = rows[greeting:]
    names, names_line = (labels, 0) if labels else _names(path, comments, rows, sign, comma, header)
    begin = rows[0][0] + 1 if names_line == rows[0][0] else rows[0][0]
    body = [line for number, line in rows if number >= begin]
    units, units_line = _units_row(rows, begin, sign, comma) if names else ((), 0)
    if units:
        begin = units_line + 1
        body = [line for number, line in rows if number >= begin]
    if not body:
        raise wrong(path, begin, "no rows below the header", "check the file and header")
    names = _names_in_lists(names, body[0], sign)
    fields = Counter(len(split(line, sign)) for line in body).most_common(1)[0][0]
    # Rows with quotes may have the delimiter within a cell.
    full = [cells for cells in (split(line, sign) for line in body if '"' not in line) if len(cells) == fields]
    unnamed = bool(names) and any(any(cells[len(names) :]) for cells in full)
    return Format(sign, comma, comment, names, names_line, begin, fields, units, units_line, unnamed, bool(labels))


def title_lines(path: Path, decimal: str, comment: str) -> int:
    """Lines before the names, such as a title or a greeting: a value for ``skip_rows``; 0 if the names come first.

    The names are the last line of words above the figures, over a line of units if there is one. A line of names may
    have one cell more than the figures, as LabVIEW's has for comments.
    """
    comma = decimal == "comma"
    _, rows = _first_lines(path, comment, 0)
    sign = _likely_sign(rows, comma) if rows else None
    cells = [[_without_label(cell) for cell in _whole(line, sign)] for _, line in rows]
    figures = [sum(_is_figure(cell.partition(WITHIN)[0], comma) for cell in row) for row in cells]
    fields = Counter(len(row) for row, found in zip(cells, figures, strict=True) if found).most_common(1)
    wide = fields[0][0] if fields else 0
    used = sum(map(bool, cells[-1])) if cells else 0  # a spreadsheet fills its rows up with empty cells
    full = [len(row) == wide and 2 * found >= used for row, found in zip(cells, figures, strict=True)]
    # Lines of a preamble may hold figures too, but not several in a row.
    body = next((k for k in range(len(rows)) if all(full[k : k + ROWS_IN_A_ROW])), 0)
    above = [k for k in range(body) if not figures[k] and len(cells[k]) in (wide, wide + 1)]
    if not above:
        # The figures have no names: only what stands above them is left out.
        return rows[body - 1][0] if body else 0
    names, known = above[-1], {"", "-", COUNTS, *TIME, *ANGLE, *TORQUE, *FORCE, *TEMPERATURE}
    # A line under the names whose cells are units, half of them or more, in brackets or not.
    while names - 1 in above and 2 * sum(cell.strip("[]() ") in known for cell in cells[names]) >= len(cells[names]):
        names -= 1
    return rows[names - 1][0] if names else 0


def _without_label(cell: str) -> str:
    return cell.rpartition(":")[2].strip() if _LABEL.match(cell) else cell


def _labels(rows: Lines, sign: str | None) -> tuple[tuple[str, ...], int]:
    """Names of a table whose cells have them, and the rows of greeting before it; no names for any other table."""
    tables = [split(line, sign) for _, line in rows]
    labelled = [[bool(_LABEL.match(cell)) for cell in row] for row in tables]
    alike = next((k for k, found in enumerate(reversed(labelled)) if found != labelled[-1]), len(labelled))
    if sum(labelled[-1]) < 2 or alike < min(FEWEST_LABELLED, len(rows)):
        return (), 0
    cells = enumerate(zip(tables[-1], labelled[-1], strict=True), 1)
    names = (cell.partition(":")[0].strip() if named else f"column {k}" for k, (cell, named) in cells)
    return tuple(names), len(rows) - alike


def _units_row(rows: Lines, begin: int, sign: str | None, comma: bool) -> tuple[tuple[str, ...], int]:
    """Cells of the first of up to MOST_UNITS rows without a figure between the names and the figures; the last's line.

    A row of text where figures should be, dates for one, is no row of units: another such row follows.
    """
    found: list[tuple[int, list[str]]] = []
    for number, line in rows:
        cells = split(line, sign)
        if number < begin:
            continue
        if any(_is_figure(cell, comma) for cell in cells):
            return (tuple(found[0][1]), found[-1][0]) if found else ((), 0)
        if len(found) == MOST_UNITS or any(len(cell) > LONGEST_UNIT for cell in cells):
            break
        found.append((number, cells))
    return (), 0


def line_with(path: Path, name: str) -> int:
    """The first line, from 1, that has ``name`` as a cell, with any delimiter; 0 if there is none."""
    with open(path, "rb") as file:
        for number in range(1, FIRST_ROWS + 1):
            line = _decoded(file.readline(LONGEST_LINE + 1))
            if any(name in split(line, sign) for sign in SIGNS.values()):
                return number
    return 0


def _first_lines(path: Path, comment: str, skip_rows: int) -> tuple[Lines, Lines]:
    """Comment lines before the first row, and the first rows, with their numbers."""
    comments: Lines = []
    rows: Lines = []
    if path.exists() and not path.is_file():  # a pipe may never end
        raise wrong(path, 1, "not a regular file", "give the path of the logger's file")
    with open(path, "rb") as file:
        number = 0
        while len(rows) < FIRST_ROWS + 1 and number < skip_rows + LONGEST_PREAMBLE:
            raw = file.readline(LONGEST_LINE + 1)
            if not raw:
                break
            number += 1
            if number == 1:
                _refuse_no_text(path, raw)
            if len(raw) > LONGEST_LINE:
                raise too_long(path, number)
            line = _decoded(raw.removeprefix(b"\xef\xbb\xbf") if number == 1 else raw)
            if number <= skip_rows or not line.strip():
                continue
            if line.lstrip().startswith(comment):
                if not rows:
                    comments.append((number, line.lstrip().removeprefix(comment)))
            else:
                rows.append((number, line))
    return comments, rows


def _refuse_no_text(path: Path, raw: bytes) -> None:
    """Refuse files of a spreadsheet, a binary logger or an editor of another system; ``raw`` is the first line."""
    what, remedy = "", "export the data as text, one row a line (CSV)"
    if raw.startswith(b"PK\x03\x04"):
        what = "a spreadsheet or another zipped file"
    elif raw[:2] in (b"\xff\xfe", b"\xfe\xff") or (
        raw[1::2].count(0) > 0.4 * len(raw) or raw[::2].count(0) > 0.4 * len(raw)
    ):
        what, remedy = "UTF-16 text", "save the file as UTF-8 or plain text"
    elif raw.count(0) or sum(byte < 32 and byte not in b"\t\r\n\f\x1a" for byte in raw[:1000]) > 20:
        what = "not a text file"
    elif _CAN_FRAME.match(raw):
        what = "frames of a CAN bus, whose bytes are not decoded"
        remedy = "decode them with the bus's DBC file (cantools, python-can), and write time, name and figure as CSV"
    elif raw.count(b"\r") > 1 + raw.count(b"\n"):
        what, remedy = "line ends of CR alone", "save the file with line ends of LF or CR LF"
    if what:
        raise wrong(path, 1, what, remedy)


def _decoded(raw: bytes) -> str:
    """The text as UTF-8, or in the code page of desktop systems if it is not UTF-8."""
    try:
        return raw.decode("utf-8")
    except UnicodeDecodeError:
        return raw.decode("latin-1")


def _likely_sign(rows: Lines, decimal_comma: bool) -> str | None:
    """The delimiter that splits most rows into the same number of columns; of several, that with the most columns."""
    best: tuple[int, int] = (0, 0)
    found: str | None = None
    for sign in (";", "\t", *(() if decimal_comma else (",",)), None):
        # The arrow after a time stamp divides cells too, whichever sign does behind it.
        widths = (len(split(line, sign)) if sign is None or sign in line else 1 for _, line in rows)
        count, often = Counter(widths).most_common(1)[0]
        if count > 1 and (often, count) > best:
            best, found = (often, count), sign
    return found


def _names(
    path: Path, comments: Lines, rows: Lines, sign: str | None, decimal_comma: bool, header: str
) -> tuple[tuple[str, ...], int]:
    """Names of the columns and the line they are on; no names and line 0 where there are none."""
    number, first = rows[0]
    cells = split(first, sign)
    if header == "row" or (header == "auto" and not any(_is_figure(cell, decimal_comma) for cell in cells)):
        return tuple(cells), number
    if header == "none":
        return (), 0
    if comments:
        number, text = comments[-1]
        named = split(text, sign)
        if header == "comment" or len(named) > 1:
            return tuple(named), number
    if header == "comment":
        remedy = "set header: none and give columns by number from 1"
        raise wrong(path, number, "no comment line with the names before the data", remedy)
    return (), 0


def figure_of(cell: str) -> float:
    """The figure of a cell, also of counts in hexadecimal digits, 0x0FF3. Raises ValueError for other text."""
    return float(int(cell, 16)) if cell[:2] in ("0x", "0X") else float(cell)


def _is_figure(cell: str, decimal_comma: bool) -> bool:
    try:
        figure_of(cell.replace(",", ".") if decimal_comma else cell)
    except ValueError:
        return False
    return True
