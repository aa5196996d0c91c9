"""The figures of docs/how-to/a-leg-and-a-handle.md are those of the package."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import mbcdm_cad as mc

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/how-to/a-leg-and-a-handle.md").read_text("utf-8")
ROWS = [line.strip("| \n").split(" | ") for line in PAGE.splitlines() if line.startswith("| ") and "`" in line]


def with_changes(change: str) -> str:
    """The leg's file with ``FIELD: VALUE`` of each change in backticks; "as it is" has none."""
    text = (ROOT / "params/how-to/leg.yaml").read_text("utf-8")
    for field, value in re.findall(r"`(\w+): ([\w.]+)`", change):
        found = re.subn(rf"\b{field}: [\w.]+", f"{field}: {value}", text)
        text = found[0] if found[1] else text + f"{field}: {value}\n"
    return text


@pytest.mark.parametrize("row", ROWS, ids=[row[0] for row in ROWS])
def test_a_row_of_the_leg_is_what_the_package_says(row: list[str], tmp_path: Path) -> None:
    change, mass, swing, sooner, half, fails = row
    path = tmp_path / "leg.yaml"
    path.write_text(with_changes(change))
    design = mc.load(path)
    checks, report = design.check(), design.analyse().to_dict()
    by_id = {result.id: result for result in checks}
    first = design.drive.layout.life.first
    assert first is not None
    assert float(mass) == pytest.approx(by_id["mass_estimate"].actual, rel=0.005)
    assert float(swing) == pytest.approx(report["structure"]["payload_swing_mrad"], rel=0.01)
    assert float(sooner.replace(",", "")) == pytest.approx(report["life"]["replace_at_cycles"], rel=0.06)
    assert float(half.replace(",", "")) == pytest.approx(first.cycles, rel=0.06)
    assert fails.split(", ") == [f"`{r.id}`" for r in checks if r.status == "fail"] or fails == "none"
    assert (fails == "none") == (not [r for r in checks if r.status == "fail"])


def test_the_handle_passes_and_turns_back_as_told() -> None:
    design = mc.load(ROOT / "params/how-to/handle.yaml")
    assert not [r.id for r in design.check() if r.status == "fail"]
    told = re.search(r"turns back with ([\d.]+) N m", PAGE)
    assert told is not None
    back = design.drive.layout.losses.backdrive
    assert back is not None and float(told[1]) == pytest.approx(back.start_Nm, rel=0.02), back.start_Nm
