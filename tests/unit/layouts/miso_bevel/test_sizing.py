"""Sizing of miso_bevel: the reference from its requirements, and laws for every file."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import pytest
import yaml

from mbcdm_cad.design.fieldpath import leaves
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import load_design, load_text, reference_data
from mbcdm_cad.layouts.miso_bevel.sizing import size
from mbcdm_cad.sizing.known import KnownFields
from mbcdm_cad.solving.question import question_of
from tests.support.checked import failing

REFERENCE = reference_data()
# What the reference states: the paper's tables, its torques and parts, its mass and box, and one depth.
STATED = [
    *("name", "configuration", "travel.half_angle_deg"),
    *("transmission.centre_distance_mm", "transmission.drum_radii_mm", "transmission.ratios"),
    *("rope.type", "rope.modulus_GPa", "rope.modulus_area", "rope.friction_coefficient", "rope.preload_N"),
    *("drive", "loads", "limits.bend_ratio_min", "limits.frame_windup_max_mrad", "limits.losses"),
    *("targets", "support.back_y_mm"),
]


def stated() -> dict[str, Any]:
    """The reference design with every field left out that a rule gives."""
    data: dict[str, Any] = {}
    for path in STATED:
        *blocks, last = path.split(".")
        source, at = REFERENCE, data
        for block in blocks:
            source, at = source[block], at.setdefault(block, {})
        at[last] = copy.deepcopy(source[last])
    return data


def test_the_sized_reference_passes_every_check() -> None:
    loaded = load_text(yaml.safe_dump(stated()))
    assert failing(loaded) == {}


def test_a_short_file_gives_a_whole_drive() -> None:
    data = {
        "configuration": "miso_bevel",
        "travel": {"half_angle_deg": 35.0},
        "transmission": {"ratio": 9.0, "drum_radius_mm": 54.0},
        "loads": {"peak_torque_Nm": 3.0},
    }
    loaded = load_text(yaml.safe_dump(data), "short_one.yaml")
    assert loaded.drive.name == "short_one" and len(loaded.sized) > 45
    ratios = [c.drum_radius_mm / c.input_radius_mm for c in loaded.drive.cables]
    assert ratios == pytest.approx([9.0] * 4, rel=1e-6), ratios


def test_twice_the_size_takes_a_rope_of_one_and_a_half_millimetres() -> None:
    data = {
        "configuration": "miso_bevel",
        "travel": {"half_angle_deg": 35.0},
        "transmission": {"ratio": 9.0, "drum_radius_mm": 108.0},
        "loads": {"peak_torque_Nm": 3.15},
        "rope": {"type": "7x7-1.5"},
    }
    loaded = load_text(yaml.safe_dump(data), "twice.yaml")
    assert loaded.drive.cable.diameter_mm == 1.5
    assert failing(loaded) == {}


@pytest.mark.parametrize(("radius_mm", "ratio"), [(70.0, 4.5), (50.0, 5.0)])
def test_wide_motors_that_are_set_back_stand_apart_too(radius_mm: float, ratio: float) -> None:
    """Motors of 87 mm without gearhead pass behind the drum only if set back by half the usual centre distance."""
    data = {
        "configuration": "miso_bevel",
        "travel": {"half_angle_deg": 35.0},
        "transmission": {"ratio": ratio, "drum_radius_mm": radius_mm},
        "loads": {"peak_torque_Nm": 3.0},
        "drive": {"motor": "tmotor-u8-100kv", "gearhead": "none"},
        **{part: {"material": "pla"} for part in ("drum", "guide", "support")},
    }
    loaded = load_text(yaml.safe_dump(data), "wide.yaml")
    assert loaded.drive.input_setback_mm > 20.0, loaded.drive.input_setback_mm
    assert failing(loaded) == {}


@pytest.mark.parametrize(("radius_mm", "torque_Nm"), [(34.6, 4.64), (34.6, 1.0), (38.0, 4.64)])
def test_a_small_drum_that_pulls_hard_has_a_web_beside_the_stops_slot(radius_mm: float, torque_Nm: float) -> None:
    data = {
        "configuration": "miso_bevel",
        "travel": {"half_angle_deg": 13.2},
        "transmission": {"ratio": 4.3, "drum_radius_mm": radius_mm},
        "loads": {"peak_torque_Nm": torque_Nm},
        "rope": {"type": "uhmwpe-0.8"},
    }
    assert failing(load_text(yaml.safe_dump(data), "small.yaml")) == {}


@pytest.mark.parametrize(
    ("radius_mm", "ratio", "travel_deg"), [(40.0, 3.2, 50.0), (45.0, 4.0, 50.0), (60.0, 3.2, 60.0)]
)
def test_at_a_small_ratio_the_terminals_take_up_the_cable_on_guide_and_inputs(
    radius_mm: float, ratio: float, travel_deg: float
) -> None:
    """Half of a cable lies on a guide of half the drum's radius and on the inputs; a fibre rope beds in by 1 %."""
    data = {
        "configuration": "miso_bevel",
        "travel": {"half_angle_deg": travel_deg},
        "transmission": {"ratio": ratio, "drum_radius_mm": radius_mm},
        "loads": {"peak_torque_Nm": 1.0},
        "rope": {"type": "uhmwpe-0.8"},
    }
    loaded = load_text(yaml.safe_dump(data), "small_ratio.yaml")
    assert failing(loaded) == {}


def test_a_complete_file_is_left_alone() -> None:
    loaded = load_text(yaml.safe_dump(REFERENCE))
    assert loaded.sized == ()


FIGURES = [found for found in size(stated()).values if isinstance(found.value, float)]


@pytest.mark.parametrize("part", range(4))
def test_a_pin_stays_where_it_is(part: int) -> None:
    data, pins = KnownFields(stated()), {one.field: round(one.value * 1.01, 6) for one in FIGURES[part::4]}
    for field, value in pins.items():
        data.put(field, value)
    sizing = size(data.data)
    filled = KnownFields(sizing.data)
    assert len(pins) > 5
    for field, value in pins.items():
        assert sizing.of(field) is None and filled.peek(field) == value, field


@pytest.mark.parametrize(
    ("field", "said"),
    [
        ("travel.half_angle_deg", "travel.half_angle_deg: missing"),
        ("loads.peak_torque_Nm", "loads.peak_torque_Nm: missing"),
        ("transmission.drum_radii_mm", "transmission.drum_radius_mm: missing"),
    ],
)
def test_a_requirement_cannot_be_left_out(field: str, said: str) -> None:
    data = stated()
    block, last = field.split(".")
    del data[block][last]
    with pytest.raises(InputError) as refused:
        load_text(yaml.safe_dump(data), "f.yaml")
    assert said in str(refused.value), refused.value


PARAMS = Path(__file__).parents[4] / "params"


def test_tables_and_pins_give_a_drive_in_the_papers_box() -> None:
    """Its parts differ where the rules choose; what the paper states is kept: radii, span, box, depth and torque."""
    short, whole = load_design(PARAMS / "mbcdm-short.yaml"), load_design(PARAMS / "mbcdm.yaml")
    assert failing(short) == {}
    assert not whole.sized and len(short.sized) > 40, len(short.sized)
    for name in ("cable", "centre_distance_mm", "half_travel_deg", "motor", "gearhead", "dead_turns"):
        assert getattr(short.drive, name) == getattr(whole.drive, name), name
    radii = [[(c.drum_radius_mm, c.guide_radius_mm, c.input_radius_mm) for c in d.drive.cables] for d in (short, whole)]
    assert radii[0] == radii[1]


def test_one_dimension_is_held_by_hand() -> None:
    question = question_of((PARAMS / "mbcdm-short.yaml").read_text("utf-8"))
    assert list(question.releases) == ["support.back_y_mm"]
    assert len(list(leaves(question.data))) <= 20
