"""Gearheads, or motors, that are turned about their axes on motor heads: threads behind holes, motor turned too."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from mbcdm_cad.layouts.loader import layout_of, load_text
from mbcdm_cad.parts.bodies import screw_places
from mbcdm_cad.parts.motor_head.part import MotorHead

PARAMS = Path(__file__).parents[3] / "params"


@pytest.mark.parametrize("turn", [0.0, 35.0, -110.0])
@pytest.mark.parametrize("name", ["siso_spur", "siso_bevel", "miso_spur"])
def test_threads_are_behind_the_holes(name: str, turn: float) -> None:
    data = yaml.safe_load((PARAMS / f"{name}.yaml").read_text("utf-8"))
    data["drive"]["gearhead_angle_deg"] = turn
    drive = load_text(yaml.safe_dump(data)).drive
    bill = layout_of(drive).bill()
    face = drive.gearhead
    heads = [item for item in bill.items if item.part == "motor_head"]
    mounted = [item for item in bill.items if item.name.startswith(f"{drive.mounted}_") and item.kind == "bought"]
    mounted = [item for item in mounted if "screw" not in item.name]
    assert len(heads) == len(mounted) == len(drive.input_names)
    local = [(x, y, 0.0) for x, y in screw_places(face.screw_count, face.bolt_circle_mm / 2)]
    threads = np.concatenate([item.location.apply(np.array(local)) for item in mounted])
    holes = []
    for item in heads:
        head = bill.parts[item.part].part
        assert isinstance(head, MotorHead)
        dims = head.dims
        holes.append(item.location.apply(np.array([(x, y, dims.top_z) for x, y in dims.gear_screws])))
    apart = np.linalg.norm(threads[:, None] - np.concatenate(holes)[None], axis=2).min(axis=1)
    assert apart.max() < 1e-6, apart
