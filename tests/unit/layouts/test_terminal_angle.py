"""A terminal whose angle the file states stands there; the others stay, and its cable ends there."""

from math import degrees, radians
from pathlib import Path
from typing import Any

import pytest
import yaml

from mbcdm_cad.checks.run import run_check
from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.loader import layout_of, load_text
from tests.support.checked import failing

PARAMS = Path(__file__).parents[3] / "params"
LAYOUTS = ("mbcdm", "siso_spur", "miso_spur", "siso_bevel")
# More than the travel, and less than the reference designs have.
ASKED_DEG = {"mbcdm": 55.0, "siso_spur": 70.0, "miso_spur": 70.0, "siso_bevel": 55.0}


def with_angle(name: str, angle_deg: float | None) -> LoadedDesign:
    data = yaml.safe_load((PARAMS / f"{name}.yaml").read_text())
    if angle_deg is not None:
        data["cables"][0]["terminal_angle_deg"] = angle_deg
    return load_text(yaml.safe_dump(data, sort_keys=False))


@pytest.mark.parametrize("name", LAYOUTS)
def test_only_the_terminal_with_an_angle_moves(name: str) -> None:
    free, asked = with_angle(name, None), with_angle(name, ASKED_DEG[name])
    before, after = (layout_of(loaded.drive).terminals for loaded in (free, asked))
    first = asked.design.cables[0].name
    for old, new in zip(before, after, strict=True):
        if new.cable_name == first:
            assert degrees(new.anchor_rad) == pytest.approx(ASKED_DEG[name])
            assert new.furthest_rad == old.anchor_rad > new.anchor_rad
        else:
            assert new.anchor_rad == old.anchor_rad


@pytest.mark.parametrize("name", LAYOUTS)
def test_length_on_the_drum_follows_the_angle(name: str) -> None:
    """Of the drawn paths: the cable loses r times the angle, the others keep their length."""
    free, asked = with_angle(name, None), with_angle(name, ASKED_DEG[name])
    terminals = layout_of(free.drive).terminals
    lost = terminals[0].radius_mm * (terminals[0].anchor_rad - radians(ASKED_DEG[name]))
    before, after = (sum(p.length_mm for p in layout_of(x.drive).cable_paths(0.0)) for x in (free, asked))
    assert lost > 3.0
    # A winding's slope on the input may change a little with its length.
    assert before - after == pytest.approx(lost, abs=0.02)


@pytest.mark.parametrize("name", LAYOUTS)
def test_an_angle_outside_the_sector_fails_with_the_limit(name: str) -> None:
    asked = with_angle(name, 200.0)
    test = layout_of(asked.drive)
    check = next(c for c in checks_of(asked.drive) if c.id == "terminal_angles")
    result = run_check(check, test)
    assert result.status == "fail"
    assert result.actual == pytest.approx(200.0)
    assert result.limit == pytest.approx(degrees(test.terminals[0].furthest_rad))
    assert "terminal_angle_deg" in result.remedy


@pytest.mark.parametrize("name", ["miso_bevel", "siso_spur", "miso_spur", "siso_bevel"])
def test_the_sector_grows_for_a_stated_angle(name: str) -> None:
    """A short file with a terminal further out than its sector would reach gets a larger sector, and passes."""
    data: dict[str, Any] = {
        "name": "asked",
        "configuration": name,
        "travel": {"half_angle_deg": 30.0},
        "transmission": {"ratio" if name == "miso_bevel" else "input_to_drum": 4.0, "drum_radius_mm": 80.0},
        "loads": {"peak_torque_Nm": 1.0},
    }
    free = load_text(yaml.safe_dump(data))
    furthest = degrees(layout_of(free.drive).terminals[0].furthest_rad)
    cables = [c.model_dump(exclude_none=True) for c in free.design.cables]
    cables[0]["terminal_angle_deg"] = round(furthest + 12.0, 1)
    asked = load_text(yaml.safe_dump({**data, "cables": cables}))
    terminal = layout_of(asked.drive).terminals[0]
    assert degrees(terminal.anchor_rad) == pytest.approx(cables[0]["terminal_angle_deg"])
    assert asked.design.drum.sector_half_angle_deg > free.design.drum.sector_half_angle_deg
    assert failing(asked) == {}
