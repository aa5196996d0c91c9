"""Sizing of miso_bevel: the reference from its requirements, and laws for every file."""

import copy
from pathlib import Path
from typing import Any

import pytest
import yaml

from mbcdm_cad.checks.size import kept_mass_g
from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.design.sized import SizedValue
from mbcdm_cad.design.yamltree import leaves
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import layout_of, load_design, load_text, reference_data
from mbcdm_cad.layouts.miso_bevel.sizing import size
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.solving.question import question_of
from tests.support.checked import failing

REFERENCE = reference_data()


def sector_of(loaded: LoadedDesign) -> SectorLayout:
    layout = layout_of(loaded.drive)
    assert isinstance(layout, SectorLayout)
    return layout


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


def test_the_sized_reference_passes_every_check_and_turns_no_more_than_the_stated_one() -> None:
    """Rules need not choose the paper's values, but mass times turn is as low as with them."""
    sized, whole = (load_text(yaml.safe_dump(data)) for data in (stated(), REFERENCE))
    assert failing(sized) == {}
    worth = [kept_mass_g(layout) / structure_of(layout).stiffness_Nm_rad for layout in map(sector_of, (sized, whole))]
    assert worth[0] <= 1.01 * worth[1], worth


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


@pytest.mark.parametrize(("radius_mm", "ratio", "setback_mm"), [(70.0, 4.5, 0.0), (50.0, 5.0, 20.0)])
def test_wide_motors_pass_beside_a_large_guide_or_are_set_back(
    radius_mm: float, ratio: float, setback_mm: float
) -> None:
    """Motors of 87 mm without gearhead: beside the smaller drum so large a guide leaves its terminals no way."""
    data = {
        "configuration": "miso_bevel",
        "travel": {"half_angle_deg": 35.0},
        "transmission": {"ratio": ratio, "drum_radius_mm": radius_mm},
        "loads": {"peak_torque_Nm": 3.0},
        "drive": {"motor": "tmotor-u8-100kv", "gearhead": "none"},
        **{part: {"material": "pla"} for part in ("drum", "guide", "support")},
    }
    loaded = load_text(yaml.safe_dump(data), "wide.yaml")
    assert loaded.drive.input_setback_mm >= setback_mm, loaded.drive.input_setback_mm
    assert failing(loaded) == {}


@pytest.mark.parametrize(
    ("radius_mm", "torque_Nm", "bearing", "encoder"),
    [
        (34.6, 4.64, "618/4", "encoder-17"),
        (34.6, 1.0, "618/5", "encoder-19-ring-5"),
        (38.0, 4.64, "618/5", "encoder-19-ring-5"),
    ],
)
def test_a_small_drum_that_pulls_hard_gets_the_smaller_boss(
    radius_mm: float, torque_Nm: float, bearing: str, encoder: str
) -> None:
    """The lighter pair would leave no web beside the stop's slot."""
    data = {
        "configuration": "miso_bevel",
        "travel": {"half_angle_deg": 13.2},
        "transmission": {"ratio": 4.3, "drum_radius_mm": radius_mm},
        "loads": {"peak_torque_Nm": torque_Nm, "stiffness_Nm_rad": 1.0},
        "rope": {"type": "uhmwpe-0.8"},
    }
    loaded = load_text(yaml.safe_dump(data), "small.yaml")
    assert failing(loaded) == {}
    assert (loaded.design.drum.bearing, loaded.design.drive.drum_encoder) == (bearing, encoder)


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


FIGURES = [found for found in size(stated()).values if isinstance(found.value, float)]


@pytest.mark.parametrize("found", FIGURES, ids=lambda found: found.field)
def test_a_pin_stays_where_it_is(found: SizedValue) -> None:
    data = stated()
    *blocks, last = found.field.split(".")
    at = data
    for block in blocks:
        at = at.setdefault(block, {})
    at[last] = round(found.value * 1.01, 6)
    sizing = size(data)
    assert sizing.of(found.field) is None
    at = sizing.data
    for block in blocks:
        at = at[block]
    assert at[last] == round(found.value * 1.01, 6)


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


def test_a_whole_file_is_left_to_no_rule_and_the_short_one_holds_its_mass_and_box() -> None:
    short, whole = load_design(PARAMS / "mbcdm-short.yaml"), load_design(PARAMS / "mbcdm.yaml")
    assert not whole.sized and len(short.sized) > 40, len(short.sized)
    assert failing(short) == failing(whole) == {}


def test_one_dimension_is_held_by_hand() -> None:
    question = question_of((PARAMS / "mbcdm-short.yaml").read_text("utf-8"))
    assert list(question.releases) == ["support.back_y_mm"]
    assert len(list(leaves(question.data))) <= 20
