"""Keys of the cache: equal inputs, code and versions have equal keys; any difference gives another key.

The hash of the code is part of a key, so that a changed program does not use results of the old one.
"""

from __future__ import annotations

import ast
import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path, PurePath
from typing import Any

_PACKAGE = __name__.partition(".")[0]
_ROOT = Path(__file__).parents[1]


def content_key(kind: str, data: Any, source: str, versions: Mapping[str, str]) -> str:
    """SHA-256 (hex) that names what is made from ``data`` (plain data and dataclasses) as ``kind``.

    ``source`` is the hash of the code that makes it (:func:`source_hash`), ``versions`` those of
    the libraries it uses. Raises as :func:`canonical_json` does.
    """
    text = canonical_json({"kind": kind, "data": data, "source": source, "versions": dict(versions)})
    return hashlib.sha256(text.encode("utf-8")).hexdigest()


def canonical_json(value: Any) -> str:
    """JSON text that is equal for equal values: keys sorted, floats to the last bit, dataclasses with their class.

    Raises ``TypeError`` for a value that is not plain data, ``ValueError`` for a number that is not finite.
    """
    return json.dumps(_plain(value), sort_keys=True, separators=(",", ":"), allow_nan=False)


def _plain(value: Any) -> Any:
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if is_dataclass(value) and not isinstance(value, type):
        name = f"{type(value).__module__}.{type(value).__qualname__}"
        return {"class": name, "fields": {field.name: _plain(getattr(value, field.name)) for field in fields(value)}}
    if isinstance(value, Mapping):
        return {"pairs": sorted(([_plain(key), _plain(content)] for key, content in value.items()), key=json.dumps)}
    if isinstance(value, list | tuple):
        return [_plain(element) for element in value]
    if isinstance(value, PurePath):
        return {"path": value.as_posix()}
    if hasattr(value, "tolist"):  # an array or a number of numpy, without importing it
        return _plain(value.tolist())
    raise TypeError(f"{type(value).__name__} is not plain data and cannot be part of a key: {value!r:.80}")


@cache
def source_hash(*modules: str) -> str:
    """SHA-256 (hex) of the sources of the modules and of all modules of this package that they import.

    Imports are read from the text, wherever in it they stand; nothing is imported. A module outside this package, as a
    configuration from elsewhere has them, counts with those modules of its own folder that it imports. Raises
    ``ValueError`` for a module that does not exist.
    """
    missing = [module for module in modules if _path(module) is None]
    if missing:
        raise ValueError(f"no module {missing[0]!r}")
    found: set[str] = set()
    waiting = set(modules)
    while waiting:
        found |= waiting
        waiting = {imported for module in waiting for imported in _imports(module)} - found
    digest = hashlib.sha256()
    for module in sorted(found):
        digest.update(f"{module} {hashlib.sha256(_source(module)).hexdigest()}\n".encode())
    return digest.hexdigest()


@cache
def package_hash() -> str:
    """SHA-256 (hex) of every file of the program and its data: equal only if nothing of it has changed."""
    digest = hashlib.sha256()
    # This is part of every start, and would take half as long again with Path objects.
    files = (os.path.join(folder, name) for folder, _, names in os.walk(_ROOT) for name in names)
    for file in sorted(name for name in files if name.endswith((".py", ".json", ".yaml", ".j2"))):
        with open(file, "rb") as content:
            sha256 = hashlib.sha256(content.read()).hexdigest()
        digest.update(f"{file.removeprefix(str(_ROOT))} {sha256}\n".encode())
    return digest.hexdigest()


@cache
def _imports(module: str) -> frozenset[str]:
    """Modules of this package and of the module's own that ``module`` imports, with the packages they lie in."""
    path = _path(module)
    package = module if path is not None and path.name == "__init__.py" else module.rpartition(".")[0]
    named = {name for node in ast.walk(ast.parse(_source(module))) for name in _names(node, package)}
    with_packages = {name.rsplit(".", up)[0] for name in named for up in range(name.count(".") + 1)}
    own = (f"{_PACKAGE}.", f"{package or module}.")
    return frozenset(name for name in with_packages if f"{name}.".startswith(own) and _path(name) is not None)


def _names(node: ast.AST, package: str) -> Iterator[str]:
    """All modules that an import statement may mean: the name after ``from``, and each imported name."""
    if isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names)
    elif isinstance(node, ast.ImportFrom):
        base = node.module or ""
        if node.level:
            up = package.rsplit(".", node.level - 1)[0]
            base = f"{up}.{base}" if base else up
        yield base
        yield from (f"{base}.{alias.name}" for alias in node.names)


@cache
def _path(module: str) -> Path | None:
    """The file of a module; None where there is none."""
    if module.partition(".")[0] != _PACKAGE:
        return _outside(module)
    base = _ROOT.joinpath(*module.split(".")[1:])
    files = (base / "__init__.py", base.with_suffix(".py"))
    return next((file for file in files if file.is_file()), None)


def _outside(module: str) -> Path | None:
    """The file of a module of another package, found as an import would find it."""
    try:
        spec = find_spec(module)
    except (ImportError, ValueError):
        return None
    return Path(spec.origin) if spec is not None and spec.has_location and spec.origin else None


def _source(module: str) -> bytes:
    path = _path(module)
    return path.read_bytes() if path is not None else b""
