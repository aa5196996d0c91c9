"""Rules of the drum by its stress: windows closed where the web would be thicker for them, the hub by its torsion."""

from dataclasses import replace
from typing import Any

import pytest
import yaml

from mbcdm_cad.checks.structure import drum_stress
from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.layouts.head_dims import CLOSED_GAIN
from mbcdm_cad.layouts.loader import layout_of, load_text
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.parts.drum_sector.part import DrumSector
from tests.support.checked import statuses

ANTENNA: dict[str, Any] = {
    "configuration": "siso_spur",
    "travel": {"half_angle_deg": 120},
    "transmission": {"input_to_drum": 8, "drum_radius_mm": 300},
    "rope": {"type": "7x19-2.0"},
    "loads": {"peak_torque_Nm": 150},
}
# A printed drum whose windows leave little web beside the slot.
SOFT: dict[str, Any] = {
    "configuration": "siso_bevel",
    "travel": {"half_angle_deg": 62.1},
    "transmission": {"input_to_drum": 1.9, "drum_radius_mm": 31.7},
    "loads": {"peak_torque_Nm": 0.052},
    "support": {"material": "pla"},
}
LIGHT: dict[str, Any] = {
    "configuration": "siso_spur",
    "travel": {"half_angle_deg": 40},
    "transmission": {"input_to_drum": 8, "drum_radius_mm": 60},
    "loads": {"peak_torque_Nm": 0.5},
}


def sized(data: dict[str, Any], **drum: Any) -> LoadedDesign:
    """As strength and place ask for it: any stiffness will do."""
    data = {**data, "loads": {**data["loads"], "stiffness_Nm_rad": 1.0}}
    return load_text(yaml.safe_dump({"name": "windows", **data, **({"drum": drum} if drum else {})}))


def drum_g(loaded: LoadedDesign) -> float:
    drive = loaded.drive
    dims = layout_of(drive).drum
    return (
        float(DrumSector(dims, drive.screw(dims.set_screw).thread_mm).volume_mm3())
        * 1e-3
        * float(drive.drum_material.density_g_cm3)
    )


def turn(loaded: LoadedDesign) -> float:
    structure = structure_of(layout_of(loaded.drive))
    assert structure is not None
    return float(sum(c.urad_Nm for c in structure.causes if c.in_drum))


def test_a_stressed_web_has_no_windows_and_is_lighter_and_stiffer() -> None:
    closed, open_ = sized(ANTENNA), sized(ANTENNA, windows="outer")
    record = next(v for v in closed.sized if v.field == "drum.windows")
    assert (record.value, record.driver) == ("none", "drum_stress") and not layout_of(closed.drive).drum.windows
    assert layout_of(open_.drive).drum.windows and open_.drive.drum.windows == "outer"
    assert drum_g(closed) < 0.8 * drum_g(open_) and turn(closed) < 0.4 * turn(open_)
    for design in (closed, open_):
        assert statuses(design)["drum_stress"] == "pass"


def test_windows_that_cost_much_stiffness_for_their_mass_are_closed() -> None:
    closed, open_ = sized(SOFT, material="pla"), sized(SOFT, material="pla", windows="outer")
    assert closed.drive.drum.windows == "none" and not layout_of(closed.drive).drum.windows
    assert statuses(open_)["drum_stress"] == "pass", "stress alone closes them: this design shows nothing"
    assert turn(open_) * drum_g(open_) > CLOSED_GAIN * turn(closed) * drum_g(closed)


def test_a_web_that_bears_its_stress_keeps_them_and_a_file_may_close_them() -> None:
    usual, closed = sized(LIGHT), sized(LIGHT, windows="none")
    assert layout_of(usual.drive).drum.windows and not [v for v in usual.sized if v.field == "drum.windows"]
    assert not layout_of(closed.drive).drum.windows
    assert turn(closed) < turn(usual) and drum_g(closed) > drum_g(usual)
    assert drum_g(closed) == pytest.approx(drum_g(usual), rel=0.15)


@pytest.mark.parametrize(
    ("configuration", "transmission"),
    [
        ("siso_spur", {"input_to_drum": 8, "drum_radius_mm": 80}),
        ("siso_bevel", {"input_to_drum": 8, "drum_radius_mm": 60}),
        ("miso_bevel", {"ratio": 9, "drum_radius_mm": 60}),
    ],
)
def test_a_printed_hub_is_as_wide_as_its_torsion_asks(configuration: str, transmission: dict[str, float]) -> None:
    loaded = load_text(
        yaml.safe_dump(
            {
                "name": "hub",
                "configuration": configuration,
                "travel": {"half_angle_deg": 40},
                "transmission": transmission,
                "loads": {"peak_torque_Nm": 4.0, "stiffness_Nm_rad": 1.0},
                "drum": {"material": "pla"},
                "support": {"material": "pla"},
            }
        )
    )
    record = next(v for v in loaded.sized if v.field == "drum.hub_diameter_mm")
    assert record.driver == "drum_stress", record
    drive = loaded.drive
    layout = layout_of(drive)
    assert isinstance(layout, SectorLayout)
    assert drum_stress(layout).holds, drum_stress(layout)
    narrower = layout_of(replace(drive, drum=replace(drive.drum, hub_diameter_mm=record.value - 1.0)))
    assert isinstance(narrower, SectorLayout)
    refused = drum_stress(narrower)
    assert "the hub" in refused.subject and not refused.holds, refused


def test_a_printed_web_bears_its_stress_beside_the_slot_of_a_thick_pin() -> None:
    file = {
        "configuration": "miso_bevel",
        "travel": {"half_angle_deg": 50.2},
        "transmission": {"ratio": 6.94, "drum_radius_mm": 31.4, "centre_distance_mm": 34.0},
        "loads": {"peak_torque_Nm": 1.89},
        "rope": {"type": "7x7-0.45"},
        **{part: {"material": "pa12"} for part in ("drum", "guide", "support")},
    }
    layout = layout_of(load_text(yaml.safe_dump(file)).drive)
    assert isinstance(layout, SectorLayout)
    assert layout.drive.drum.stop_pin_mm >= 5.0 and drum_stress(layout).holds, drum_stress(layout)
