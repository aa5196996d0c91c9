"""Which programs and libraries this machine has, and what each is needed for.

The command line prints it, the Python API returns it.
"""

from __future__ import annotations

import ctypes.util
import importlib.metadata
import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from mbcdm_cad import __version__
from mbcdm_cad.report.table import ReportTable
from mbcdm_cad.storage.cache import ENVIRONMENT_VARIABLE, cache_folder

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
class Machine:
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

    def __str__(self) -> str:
        """As :meth:`text`."""
        return self.text()

    def to_dict(self) -> list[dict[str, Any]]:
        """Plain data, one record a dependency."""
        return [asdict(item) for item in self.items]


def examine() -> Machine:
    """Look for all programs and libraries. Takes some seconds: compiled libraries are loaded in another process."""
    return Machine(tuple(examined()))


def _word(item: Dependency) -> str:
    return "ok" if item.there else "missing" if item.required else "absent"


def examined() -> Iterator[Dependency]:
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
    yield _libgl()
    yield _imported("CAD kernel", "OCP.gp", "cadquery", "build, picture, parts in Python")
    yield _imported("drawing library", "vtkmodules.vtkRenderingOpenGL2", "vtk", "picture, meshes")
    yield _cache()
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


def _libgl() -> Dependency:
    """The system library that no Python package contains; systems other than Linux always have it."""
    found = ctypes.util.find_library("GL")
    there = bool(found) or platform.system() != "Linux"
    return Dependency("libGL", there, True, found or "not found", "CAD kernel and drawing library", _LIBGL_REMEDY)


def _cache() -> Dependency:
    """The cache folder: its size, and whether it can be written."""
    folder = cache_folder()
    use = "building unchanged parts quickly; without it all parts are drawn each time"
    there = next((path for path in (folder, *folder.parents) if path.exists()), Path())
    if not os.access(there, os.W_OK | os.X_OK):
        remedy = f"allow writing to {there}, or set {ENVIRONMENT_VARIABLE} to another folder"
        return Dependency("cache", False, False, f"{folder} cannot be written", use, remedy)
    files = [path for path in folder.glob("*/*") if path.is_file()]
    size_MB = sum(path.stat().st_size for path in files) / 1e6
    return Dependency("cache", True, False, f"{folder}, {len(files)} entries, {size_MB:.0f} MB", use)


def _program(name: str, commands: tuple[str, ...], use: str) -> Dependency:
    path = next((path for path in map(shutil.which, commands) if path), None)
    return Dependency(name, path is not None, False, path or "not on the PATH", use)
