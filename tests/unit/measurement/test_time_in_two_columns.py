"""A time in two columns, whole seconds and what is over: the second one begins again every second."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from mbcdm_cad.measurement.draft import draft_text
from mbcdm_cad.measurement.reading import load_measurement
from mbcdm_cad.measurement.roles import Expected

TIME = 0.913 + 0.02 * np.arange(3000)
OUTPUT = 0.3 * np.sin(2.0 * np.pi * TIME / 12.0)


@pytest.mark.parametrize(("unit", "second"), [("us", 1e6), ("ns", 1e9), ("ms", 1e3)])
def test_the_draft_counts_the_seconds_on(tmp_path: Path, unit: str, second: float) -> None:
    whole = np.floor(TIME + 1e-9)
    over = np.round((TIME - whole) * second)
    lines = ["logger: begun on a Saturday; Capacity: 1000", f"mode motor joint time_s time_{unit}"]
    lines += [f"1 {8 * q:.6f} {q:.6f} {s:.0f} {u:.0f}" for q, s, u in zip(OUTPUT, whole, over, strict=True)]
    log = tmp_path / "run.log"
    log.write_text("\n".join(lines) + "\n")
    text = draft_text(log, Expected.of_ratio(8.0))
    fields = yaml.safe_load(text)["columns"]["time"]
    assert fields == {"column": f"time_{unit}", "wraps_at": second, "unit": unit}, text
    file = tmp_path / "run.yaml"
    file.write_text(text)
    run = load_measurement(file)
    assert np.allclose(run.time_s - run.time_s[0], TIME - TIME[0], atol=2e-3 if unit == "ms" else 1e-6)
