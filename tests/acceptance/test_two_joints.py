"""The figures of docs/how-to/a-leg-and-a-handle.md are those of the package."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import mbcdm_cad as mc
from mbcdm_cad.layouts.life import life_of
from mbcdm_cad.layouts.registry import layout_of
from tests.support.checked import failing, results

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/how-to/a-leg-and-a-handle.md").read_text("utf-8")
ROWS = [line.strip("| \n").split(" | ") for line in PAGE.splitlines() if line.startswith("| `")]
LEG, HANDLE = ([row for row in ROWS if len(row) == columns] for columns in (6, 5))


def with_changes(name: str, change: str) -> str:
    """A file with ``FIELD: VALUE`` of each change in backticks."""
    text = (ROOT / f"params/how-to/{name}.yaml").read_text("utf-8")
    for field, value in re.findall(r"`(\w+): ([\w.]+)`", change):
        found = re.subn(rf"\b{field}: [\w.]+", f"{field}: {value}", text)
        text = found[0] if found[1] else text + f"{field}: {value}\n"
    return text


@pytest.mark.parametrize("row", LEG, ids=[row[0] for row in LEG])
def test_a_row_of_the_leg_is_what_the_package_says(row: list[str], tmp_path: Path) -> None:
    change, mass, swing, sooner, half, fails = row
    path = tmp_path / "leg.yaml"
    path.write_text(with_changes("leg", change))
    design = mc.load(path)
    checks, report = results(design.loaded), design.analyse().to_dict()
    by_id = {result.id: result for result in checks}
    first = life_of(layout_of(design.drive)).first
    assert first is not None
    assert float(mass) == pytest.approx(by_id["mass_estimate"].actual, rel=0.005)
    assert float(swing) == pytest.approx(report["structure"]["payload_swing_mrad"], rel=0.01)
    assert float(sooner.replace(",", "")) == pytest.approx(report["life"]["replace_at_cycles"], rel=0.06)
    assert float(half.replace(",", "")) == pytest.approx(first.cycles, rel=0.06)
    assert fails.split(", ") == [f"`{r.id}`" for r in checks if r.status == "fail"] or fails == "none"
    assert (fails == "none") == (not [r for r in checks if r.status == "fail"])


@pytest.mark.parametrize("row", HANDLE, ids=[row[0] for row in HANDLE])
def test_a_row_of_the_handle_is_what_the_package_says(row: list[str], tmp_path: Path) -> None:
    change, back, parts, mass, fails = row
    path = tmp_path / "handle.yaml"
    path.write_text(with_changes("handle", change))
    design = mc.load(path)
    checks, drive = results(design.loaded), design.drive
    assert parts == f"{drive.motor.name}, {drive.gearhead.name}"
    found = layout_of(drive).losses.backdrive
    assert found is not None and float(back) == pytest.approx(found.start_Nm, rel=0.01)
    assert float(mass) == pytest.approx(next(r.actual for r in checks if r.id == "mass_estimate"), rel=0.005)
    assert fails == (", ".join(f"`{r.id}`" for r in checks if r.status == "fail") or "none")


def test_a_handle_whose_motor_is_named_gets_the_ratio_that_uses_it_up(tmp_path: Path) -> None:
    path = tmp_path / "handle.yaml"
    text = with_changes("handle", "").replace(", input_to_drum: 8", "")
    path.write_text(text.replace("{encoder", "{motor: maxon-ec45flat-70W, encoder"))
    design = mc.load(path)
    told = re.search(r"rules take ([\d.]+), which turns back with ([\d.]+) N m", PAGE)
    assert told is not None
    found, turns = layout_of(design.drive).losses.backdrive, layout_of(design.drive).loads.si.input_turns.max()
    assert found is not None and not failing(design.loaded)
    assert (turns, found.start_Nm) == pytest.approx((float(told[1]), float(told[2])), rel=0.01)


def test_the_handle_passes_and_turns_back_as_told() -> None:
    design = mc.load(ROOT / "params/how-to/handle.yaml")
    assert not failing(design.loaded)
    told = re.search(r"turns back with ([\d.]+) N m", PAGE)
    assert told is not None
    back = layout_of(design.drive).losses.backdrive
    assert back is not None and float(told[1]) == pytest.approx(back.start_Nm, rel=0.02), back.start_Nm
