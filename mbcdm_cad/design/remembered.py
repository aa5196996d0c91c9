"""Reading a design that was read before, from the cache: no YAML, no schema, less than half of a start's time.

Only what passed schema and rules is remembered, under the hash of the file's bytes and of all code and data of this
package, so that a changed file, schema or catalogue is read anew. JSON, not pickle: a cache must not be able to run.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
from pathlib import Path
from typing import Any

from mbcdm_cad.design import drive as drive_module
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.loaded import LoadedDesign
from mbcdm_cad.design.source import read_text
from mbcdm_cad.storage.cache import Cache

_FOLDER = Path(__file__).parent
_BLOB = "design.json"


def load_remembered(path: str | Path, cache: Cache) -> LoadedDesign:
    """As :func:`mbcdm_cad.design.load_design`, taking the answer from the cache if it is there, else storing it."""
    path = Path(path)
    text = read_text(path)
    key = _key(text)
    blobs = cache.get(key)
    if blobs is not None and _BLOB in blobs:
        stored = json.loads(blobs[_BLOB])
        lines = {tuple(field_path): line for field_path, line in stored["lines"]}
        return LoadedDesign(drive_from_plain(stored["drive"]), path, stored["sha256"], text, lines)
    from mbcdm_cad.design.loader import load_text

    loaded = load_text(text, path)
    content = {
        "drive": dataclasses.asdict(loaded.drive),
        "lines": [[list(field_path), line] for field_path, line in loaded.lines.items()],
        "sha256": loaded.sha256,
    }
    cache.put(key, {_BLOB: json.dumps(content).encode()})
    return loaded


def drive_from_plain(data: dict[str, Any]) -> Drive:
    """The ``Drive`` whose ``dataclasses.asdict`` went through JSON."""
    drive: Drive = _rebuilt("Drive", data)
    return drive


def _rebuilt(annotation: str, value: Any) -> Any:
    """``value`` as the annotation says: a dataclass of the drive's module, a tuple of them, or plain data."""
    if isinstance(value, list):
        inner = annotation.removeprefix("tuple[").split(",")[0].rstrip("]")
        return tuple(_rebuilt(inner, item) for item in value)
    target = getattr(drive_module, annotation, None)
    if target is None or not isinstance(value, dict):
        return value
    return target(**{item.name: _rebuilt(str(item.type), value[item.name]) for item in dataclasses.fields(target)})


def _key(text: str) -> str:
    digest = hashlib.sha256()
    for file in sorted((*_FOLDER.glob("*.py"), *_FOLDER.glob("*.json"), *_FOLDER.glob("catalogue/*.json"))):
        digest.update(hashlib.sha256(file.read_bytes()).digest())
    digest.update(text.encode())
    return digest.hexdigest()
