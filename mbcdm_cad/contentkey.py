"""Names for what is stored: equal inputs, code and versions have equal keys, anything else has another."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from pathlib import PurePath
from typing import Any


def content_key(kind: str, data: Any, source: str, versions: Mapping[str, str]) -> str:
    """SHA-256 (hex) that names what is made from ``data`` (plain data and dataclasses) as ``kind``.

    ``source`` is the hash of the code that makes it (:func:`mbcdm_cad.sourcehash.source_hash`), ``versions`` those of
    the libraries it uses. Raises as :func:`canonical_json` does.
    """
    text = canonical_json({"kind": kind, "data": data, "source": source, "versions": dict(versions)})
    return hashlib.sha256(text.encode("utf-8")).hexdigest()


def canonical_json(value: Any) -> str:
    """JSON text that is equal for equal values: keys sorted, floats to the last bit, dataclasses with their class.

    Raises ``TypeError`` for what is not plain data, ``ValueError`` for a number that is not finite.
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
