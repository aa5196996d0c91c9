"""What there is: ropes, bought parts and materials of the package; programs and libraries of this machine.

The command line prints it, the Python API returns it.
"""

import ctypes.util
import importlib.metadata
import os
import platform
import shutil
import subprocess
import sys
import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from mbcdm_cad import __version__
from mbcdm_cad.design.catalogue import KINDS, package_entries
from mbcdm_cad.design.fields import adapter
from mbcdm_cad.errors import MbcdmError, did_you_mean
from mbcdm_cad.report.table import ReportTable, TextReport
from mbcdm_cad.storage.cache import ENVIRONMENT_VARIABLE, Cache, cache_folder

# Fields of text, told below the values: where these come from, and how an end is made.
_SOURCES = ("source", "price_source", "making")
_HEAD = """\
# The catalogue

Ropes, bought-out parts and materials that a design file names, such as `rope.type: FF-081`; written by
`mbcdm catalogue --markdown`. A design adds entries of its own, or puts other values over these, in its block
`catalogue` (see [design-file.md](design-file.md)).
"""


@dataclass(frozen=True)
class CatalogueList(TextReport):
    """Entries of the package's catalogue, of the kind ``kind`` (``ropes``, ``motors``, ...) or of all kinds."""

    kind: str | None = None

    def __post_init__(self) -> None:
        """Raise ``MbcdmError`` for a kind that the catalogue does not have."""
        if self.kind is not None and self.kind not in KINDS:
            remedy = did_you_mean(self.kind, KINDS) or "choose one of them"
            known = ", ".join(KINDS)
            raise MbcdmError(f"catalogue: no such kind (value {self.kind}, limit one of {known}); {remedy}")

    def text(self, width: int | None = None) -> str:
        """What ``mbcdm catalogue`` prints: the names of all entries, or the values of those of one kind."""
        if self.kind is not None:
            return "\n".join(_kind_lines(self.kind, width))
        rows = tuple((name, ", ".join(package_entries(name))) for name in KINDS)
        return "\n".join(ReportTable(("kind", "entries"), rows).text(width))

    def markdown(self) -> str:
        """A page with a table for each kind."""
        return catalogue_page(tuple(KINDS) if self.kind is None else (self.kind,))

    def to_dict(self) -> dict[str, dict[str, dict[str, Any]]]:
        """Values by kind, name and field; units stand in the field names."""
        kinds = KINDS if self.kind is None else (self.kind,)
        return {kind: {name: dict(values) for name, values in package_entries(kind).items()} for kind in kinds}


def catalogue_page(kinds: tuple[str, ...]) -> str:
    """Markdown: for each kind the meaning of its fields, a table of the entries, and the sources of their values."""
    lines = [_HEAD] if len(kinds) == len(KINDS) else []
    for kind in kinds:
        lines += [f"## {kind.capitalize()}", "", _about(kind), ""]
        lines += ReportTable(("field", "unit", "meaning"), _fields(kind)).markdown()
        lines += ["", *_values(kind).markdown(), ""]
        for block in _blocks(kind):
            lines += [*_block_values(kind, block).markdown(), ""]
        lines += ["Sources:", ""]
        lines += [f"- `{name}`: {_sources(entry)}" for name, entry in package_entries(kind).items()] + [""]
    return "\n".join(lines)


def _kind_lines(kind: str, width: int | None) -> list[str]:
    """Tables with one row for each field and as many entries side by side as the width allows."""
    entries = {name: _flat(entry) for name, entry in package_entries(kind).items()}
    names = list(entries)
    label_width = max(len(field) for field, _, _ in _fields(kind))
    columns = [
        max(len(name), *(len(_exact(value)) for key, value in entries[name].items() if key not in _SOURCES))
        for name in names
    ]
    lines = _filled(f"{kind}: {_about(kind)}", width)
    while names:
        room, taken = (width or 10_000) - label_width, 1
        while taken < len(names) and sum(columns[: taken + 1]) + 2 * (taken + 1) <= room:
            taken += 1
        here, names, columns = names[:taken], names[taken:], columns[taken:]
        shown = [f for f in _stated(kind) if "." not in f or any(f in entries[name] for name in here)]
        rows = tuple((field, *(_exact(entries[name].get(field)) for name in here)) for field in shown)
        lines += ["", *ReportTable(("", *here), rows).text()]
    lines += ["", "Sources:"]
    return lines + [line for name, entry in entries.items() for line in _filled(f"  {name}: {_sources(entry)}", width)]


def _about(kind: str) -> str:
    return (KINDS[kind].__doc__ or "").strip()


def _fields(kind: str) -> tuple[tuple[str, str, str], ...]:
    """(name, unit, meaning) of every field except the source; those of a block as ``servo.ratio``, after it."""
    schema = adapter(KINDS[kind]).json_schema()
    found: list[tuple[str, str, str]] = []
    for name, node in schema["properties"].items():
        found.append((name, node["unit"], node["description"]))
        for branch in node.get("anyOf", ()):
            inner = schema["$defs"][branch["$ref"].rsplit("/", 1)[1]]["properties"] if "$ref" in branch else {}
            found += [(f"{name}.{key}", own["unit"], own["description"]) for key, own in inner.items()]
    return tuple(row for row in found if row[0] != "source")


def _flat(entry: Mapping[str, Any]) -> dict[str, Any]:
    """The entry's values, those of a block as ``servo.ratio``."""
    found: dict[str, Any] = {}
    for name, value in entry.items():
        found |= {f"{name}.{key}": own for key, own in value.items()} if isinstance(value, Mapping) else {name: value}
    return found


def _blocks(kind: str) -> list[str]:
    """Blocks of which an entry has one, such as ``servo``."""
    return list(dict.fromkeys(name.split(".")[0] for name in _stated(kind) if "." in name))


def _sources(entry: Mapping[str, Any]) -> str:
    """Where the values of an entry come from, its price if it has one, and how it is made where it says so."""
    price, making = entry.get("price_source"), entry.get("making")
    return f"{entry['source']}" + (f" Price: {price}." if price else "") + (f" Made so: {making}" if making else "")


def _stated(kind: str) -> list[str]:
    """The fields that an entry states, without the sources."""
    entries = [_flat(entry) for entry in package_entries(kind).values()]
    names = [name for name, _, _ in _fields(kind) if name not in _SOURCES]
    return [name for name in names if any(entry.get(name) is not None for entry in entries)]


def _values(kind: str) -> ReportTable:
    names = [name for name in _stated(kind) if "." not in name]
    rows = tuple(
        (entry, *(_exact(values.get(name)) for name in names)) for entry, values in package_entries(kind).items()
    )
    return ReportTable(("name", *names), rows)


def _block_values(kind: str, block: str) -> ReportTable:
    """A row for each field of a block, a column for each entry that has it."""
    having = {name: _flat(entry) for name, entry in package_entries(kind).items() if block in entry}
    rows = tuple(
        (field, *(_exact(values.get(field)) for values in having.values()))
        for field in _stated(kind)
        if field.startswith(f"{block}.")
    )
    return ReportTable((block, *having), rows)


def _exact(value: object) -> str:
    """A value as in the catalogue, without the rounding of result tables."""
    if value is None:
        return "-"
    if isinstance(value, list | tuple):
        return ", ".join(_exact(item) for item in value)
    return f"{value:g}" if isinstance(value, float) else str(value)


def _filled(text: str, width: int | None) -> list[str]:
    if width is None:
        return [text]
    return textwrap.wrap(text, width, subsequent_indent="    ", break_on_hyphens=False, break_long_words=False)


# Imported in another process: a library that fails to load must not end this one.
_IMPORT_TIMEOUT_S = 120.0
_LIBGL_REMEDY = "Debian, Ubuntu: apt-get install libgl1"
_FREECAD = ("freecadcmd", "FreeCADCmd", "freecad", "FreeCAD")
_BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome", "firefox", "microsoft-edge", "xdg-open", "open")


@dataclass(frozen=True)
class Dependency:
    """One dependency: ``found`` states version or place, ``remedy`` what to do if it is missing."""

    name: str
    there: bool
    required: bool
    found: str
    needed_for: str
    remedy: str = ""


@dataclass(frozen=True)
class Machine(TextReport):
    """What this machine has of all that the program can use."""

    items: tuple[Dependency, ...]

    @property
    def missing(self) -> tuple[Dependency, ...]:
        """Required dependencies that are not there."""
        return tuple(item for item in self.items if item.required and not item.there)

    @property
    def passed(self) -> bool:
        """Whether nothing required is missing."""
        return not self.missing

    def text(self, width: int | None = None) -> str:
        """What ``mbcdm doctor`` prints: all findings, and what to do about those that are not there."""
        rows = tuple((_word(item), item.name, f"{item.found}; for {item.needed_for}") for item in self.items)
        lines = ReportTable(("", "what", "found"), rows).text(width)
        lines += [f"{item.name}: {item.remedy}" for item in self.items if not item.there and item.remedy]
        missing = ", ".join(item.name for item in self.missing)
        return "\n".join([*lines, f"missing: {missing}" if missing else "nothing required is missing"])

    def to_dict(self) -> list[dict[str, Any]]:
        """Plain data, one record a dependency."""
        return [asdict(item) for item in self.items]


def examine(*, verify: bool = False) -> Machine:
    """Look for all programs and libraries. Takes some seconds: compiled libraries are loaded in another process.

    With ``verify`` every entry of the cache is read; broken ones are removed.
    """
    return Machine(tuple(examined(verify)))


def _word(item: Dependency) -> str:
    return "ok" if item.there else "missing" if item.required else "absent"


def examined(verify: bool = False) -> Iterator[Dependency]:
    """All dependencies of the program, required ones first."""
    yield Dependency("mbcdm_cad", True, True, f"{__version__}, Python {platform.python_version()}", "everything")
    for name, use in (
        ("numpy", "the model"),
        ("pydantic", "reading design files"),
        ("scipy", "sensitivity studies and the loop"),
        ("numba", "simulate and the loop"),
        ("matplotlib", "plots of studies, runs and the loop's page"),
    ):
        version = _version(name)
        yield Dependency(name, bool(version), True, version or "not installed", use, "install the package again")
    # The system library that no Python package contains; systems other than Linux always have it.
    found = ctypes.util.find_library("GL")
    there = bool(found) or platform.system() != "Linux"
    yield Dependency("libGL", there, True, found or "not found", "CAD kernel and drawing library", _LIBGL_REMEDY)
    yield _imported("CAD kernel", "OCP.gp", "cadquery", "build, picture, parts in Python")
    yield _imported("drawing library", "vtkmodules.vtkRenderingOpenGL2", "vtk", "picture, meshes")
    yield _cache(verify)
    yield _program("FreeCAD", _FREECAD, "opening the STEP files, and the tests that do so; not needed to write them")
    yield _program("browser", _BROWSERS, "the pages that 'page', 'watch', 'loop --report' and 'compare --page' write")
    pandas = _version("pandas")
    remedy = "pip install pandas"
    yield Dependency(
        "pandas", bool(pandas), False, pandas or "not installed", "to_pandas() of results in Python", remedy
    )


def _version(package: str) -> str:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return ""


def _imported(name: str, module: str, package: str, use: str) -> Dependency:
    """Whether a compiled library loads, which also needs libraries of the system."""
    version = f"{package} {_version(package) or 'not installed'}"
    try:
        done = subprocess.run(
            [sys.executable, "-c", f"import {module}"],
            capture_output=True,
            text=True,
            timeout=_IMPORT_TIMEOUT_S,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        return Dependency(name, False, True, f"{version}, cannot be tried: {error}", use)
    if done.returncode == 0:
        return Dependency(name, True, True, version, use)
    why = (done.stderr.strip().splitlines() or [f"ended with code {done.returncode}"])[-1]
    remedy = _LIBGL_REMEDY if "libGL" in why else "install the package again"
    return Dependency(name, False, True, f"{version}, does not load: {why}", use, remedy)


def _cache(verify: bool) -> Dependency:
    """The cache folder: its size, whether it can be written, and with ``verify`` how many entries are broken."""
    folder = cache_folder()
    use = "building unchanged parts quickly; without it all parts are drawn each time"
    there = next((path for path in (folder, *folder.parents) if path.exists()), Path())
    if not os.access(there, os.W_OK | os.X_OK):
        remedy = f"allow writing to {there}, or set {ENVIRONMENT_VARIABLE} to another folder"
        return Dependency("cache", False, False, f"{folder} cannot be written", use, remedy)
    count, size, broken = Cache(folder).summary(verify=verify)
    read = f", {broken} of them broken and removed" if verify else ""
    return Dependency("cache", True, False, f"{folder}, {count} entries, {size / 1e6:.0f} MB{read}", use)


def _program(name: str, commands: tuple[str, ...], use: str) -> Dependency:
    path = next((path for path in map(shutil.which, commands) if path), None)
    return Dependency(name, path is not None, False, path or "not on the PATH", use)
