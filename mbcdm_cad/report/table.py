"""A small table of figures or words: as text for a terminal, Markdown, HTML, or a pandas frame."""

from __future__ import annotations

import html
import textwrap
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from mbcdm_cad.errors import MbcdmError

if TYPE_CHECKING:
    import pandas

_GAP = "  "
# Least width of a wrapped column of words, also on a narrow terminal.
_NARROWEST = 12


class TextReport(ABC):
    """What a command prints and a method of the Python API returns: ``print`` shows its text."""

    @abstractmethod
    def text(self) -> str:
        """What the command prints."""

    def __str__(self) -> str:
        """As :meth:`text`."""
        return self.text()

    def html(self) -> str:
        """What a notebook shows."""
        return preformatted(self.text())

    def _repr_html_(self) -> str:
        """As :meth:`html`, which notebooks ask for by this name."""
        return self.html()


@dataclass(frozen=True)
class ReportTable:
    """Rows of cells under named columns; floats are shown with four significant digits, None as an empty cell."""

    columns: tuple[str, ...]
    rows: tuple[tuple[Any, ...], ...]

    def text(self, width: int | None = None, indent: str = "") -> list[str]:
        """Lines, numbers to the right. Only the last column wraps, so that a line has at most ``width`` characters."""
        cells = [[shown_cell(cell) for cell in row] for row in (self.columns, *self.rows)]
        numeric = [all(_is_number(row[k]) for row in self.rows) for k in range(len(self.columns))]
        widths = [max(len(row[k]) for row in cells) for k in range(len(self.columns))]
        before = len(indent) + sum(widths[:-1]) + len(_GAP) * (len(widths) - 1)
        last = max(len(row[-1]) for row in cells) if width is None else max(width - before, _NARROWEST)
        lines = []
        for row in cells:
            aligned = [
                cell.rjust(size) if right else cell.ljust(size)
                for cell, size, right in zip(row[:-1], widths[:-1], numeric[:-1], strict=True)
            ]
            end = row[-1].rjust(min(widths[-1], last)) if numeric[-1] else row[-1]
            first, *more = textwrap.wrap(end, last, drop_whitespace=not numeric[-1]) or [""]
            lines.append((indent + _GAP.join([*aligned, first])).rstrip())
            lines += [" " * before + part for part in more]
        return lines

    def markdown(self) -> list[str]:
        """Lines of a Markdown table."""
        rows = [[shown_cell(cell).replace("|", "\\|") for cell in row] for row in self.rows]
        return ["| " + " | ".join(row) + " |" for row in (list(self.columns), ["---"] * len(self.columns), *rows)]

    def html(self) -> str:
        """An HTML table without style of its own, as notebooks show it."""
        head = "".join(f"<th>{html.escape(name)}</th>" for name in self.columns)
        body = "".join(
            "<tr>" + "".join(f"<td>{html.escape(shown_cell(cell))}</td>" for cell in row) + "</tr>" for row in self.rows
        )
        return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"

    def pandas(self) -> pandas.DataFrame:
        """The same rows as a data frame. Raises ``MbcdmError`` where pandas is not installed."""
        return data_frame({name: [row[k] for row in self.rows] for k, name in enumerate(self.columns)})


def data_frame(columns: Mapping[str, Any]) -> pandas.DataFrame:
    """A pandas frame of the columns. Raises ``MbcdmError`` where pandas is not installed: nothing else needs it."""
    try:
        import pandas  # optional
    except ImportError:
        raise MbcdmError(
            "pandas is not installed, and to_pandas() needs it; install it ('pip install pandas') or use to_dict()"
        ) from None
    return pandas.DataFrame(columns)


def chart(title: str, x: tuple[str, str], y: tuple[str, str], lines: Any) -> dict[str, Any]:
    """A chart as plain data: ``x`` and ``y`` are (label, unit) of the axes; a line has ``label``, ``x`` and ``y``."""
    return {"title": title, "x": {"label": x[0], "unit": x[1]}, "y": {"label": y[0], "unit": y[1]}, "lines": lines}


def preformatted(text: str) -> str:
    """HTML of a text for a notebook, with its columns aligned."""
    return f"<pre>{html.escape(text)}</pre>"


def shown_cell(cell: object) -> str:
    """One cell as text."""
    if cell is None:
        return ""
    if isinstance(cell, float):
        return f"{cell:.4g}"
    if isinstance(cell, list | tuple):
        return ", ".join(shown_cell(item) for item in cell)
    return str(cell)


def filled(text: str, width: int | None) -> list[str]:
    """The text in lines of at most ``width``, continued four columns further in."""
    if width is None or len(text) <= width:
        return [text]
    indent = " " * (len(text) - len(text.lstrip()))
    return textwrap.wrap(
        text.lstrip(),
        max(width, 40),
        initial_indent=indent,
        subsequent_indent=indent + "    ",
        break_on_hyphens=False,
        break_long_words=False,
    )


def rendered(template: str, package: str = "mbcdm_cad.report", **known: Any) -> str:
    """The text of a template of a package; ``each`` writes every figure of a list in one format."""
    import jinja2  # most commands need no template

    environment = jinja2.Environment(
        loader=jinja2.PackageLoader(package, "."),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        autoescape=False,  # no HTML in it
    )
    environment.filters["each"] = lambda values, form, between=", ": between.join(form % value for value in values)
    environment.filters["speed"] = speed_shown
    environment.filters |= known.pop("filters", {})
    return environment.get_template(template).render(**known)


def blocks(text: str) -> Iterator[tuple[str, str | ReportTable]]:
    """Lines and tables of a text, each with its indent: a table has rows ``| a | b |``, and begins anew at ``||``."""
    rows: list[tuple[str, ...]] = []
    indent = ""
    for line in (*text.splitlines(), None):
        stripped = "" if line is None else line.lstrip()
        if rows and (stripped.startswith("||") or not stripped.startswith("|")):
            yield indent, ReportTable(rows[0], tuple(rows[1:]))
            rows = []
        if line is None:
            return
        indent = line[: len(line) - len(stripped)]
        if stripped.startswith("|"):
            rows.append(tuple(cell.strip() for cell in stripped.lstrip("|").removesuffix("|").split("|")))
        else:
            yield indent, line


def terminal_lines(text: str, width: int | None) -> Iterator[str]:
    """The text with its tables aligned and its sentences in lines of at most ``width``."""
    for indent, block in blocks(text):
        yield from filled(block, width) if isinstance(block, str) else block.text(width, indent)


def _is_number(cell: object) -> bool:
    try:
        float(shown_cell(cell))
    except ValueError:
        return False
    return True


def designs_shown(count: int) -> str:
    """``1 design``, ``7 designs``."""
    return f"{count} design{'s' * (count != 1)}"


def speed_shown(speed_deg_s: float) -> str:
    """A speed of the drum, deg/s: whole degrees from 100 on, three digits below."""
    return f"{speed_deg_s:.0f}" if speed_deg_s >= 100.0 else f"{speed_deg_s:.3g}"
