"""A small measured run on disk that each test changes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import yaml

RATIO = 9.0
Write = Callable[..., Path]


def signals(samples: int = 400) -> dict[str, np.ndarray]:
    """A drive of ratio 9 swept up and down at 100 Hz."""
    t = np.arange(samples) * 0.01
    drum = 0.4 * np.sin(2.0 * np.pi * 0.5 * t)
    return {"t": t, "left": RATIO * drum, "right": RATIO * drum, "drum": drum, "tau": 0.9 * np.sign(np.cos(np.pi * t))}


def table(columns: dict[str, np.ndarray], sign: str = ",", digits: str = "%.9g") -> str:
    """The signals as a logger would write them."""
    head = sign.join(columns)
    rows = zip(*columns.values(), strict=True)
    return "\n".join([head, *(sign.join(digits % value for value in row) for row in rows)]) + "\n"


def mapping(**changed: Any) -> dict[str, Any]:
    """A measurement file's content; a field of None is left out."""
    content = {
        "data": "run.csv",
        "columns": {
            "time": {"column": "t", "unit": "s"},
            "input_left": {"column": "left", "unit": "rad"},
            "input_right": {"column": "right", "unit": "rad"},
            "output": {"column": "drum", "unit": "rad"},
            "load_torque": {"column": "tau", "unit": "N*m"},
        },
    }
    return {key: value for key, value in (content | changed).items() if value is not None}


def writer(folder: Path) -> Write:
    """Writes run.csv (text or bytes) and run.yaml into ``folder``, and gives the path of the latter."""

    def made(data: str | bytes, content: dict[str, Any] | None = None) -> Path:
        (folder / "run.csv").write_bytes(data.encode() if isinstance(data, str) else data)
        path = folder / "run.yaml"
        path.write_text(yaml.safe_dump(mapping() if content is None else content, sort_keys=False))
        return path

    return made
