"""What ``mbcdm solve`` may change in every configuration, besides derived dimensions: parts and preload."""

from collections.abc import Mapping
from functools import partial
from typing import Any

from mbcdm_cad.checks.design_variables import ROPE_DIAMETER
from mbcdm_cad.design.paths import at
from mbcdm_cad.design.sized import Freedom, to_a_size
from mbcdm_cad.layouts.common_rules import COLLAR_SCREWS, STOP_PINS_MM

DRIVE: tuple[Freedom, ...] = (
    Freedom(at.rope.type, kind="ropes", order="diameter_mm", mends=((ROPE_DIAMETER, 1),)),
    Freedom(at.rope.preload_N, 0.5, 2.0),
    Freedom(at.drive.motor, kind="motors", order="rated_torque_mNm"),
    Freedom(at.drive.gearhead, kind="gearheads", order="max_torque_mNm"),
    Freedom(at.drum.tensioner, kind="tensioners", order="stud_length_mm"),
    Freedom(at.drum.bearing, kind="bearings", order="bore_mm"),
    Freedom(at.drum.stop_pin_mm, 0.5, 2.0, partial(to_a_size, STOP_PINS_MM)),
)
INPUTS: tuple[Freedom, ...] = (
    Freedom(at.input_pulleys.lower_bearing, kind="bearings", order="bore_mm"),
    Freedom(at.input_pulleys.upper_bearing, kind="bearings", order="bore_mm"),
    Freedom(at.input_pulleys.collar_screw, words=COLLAR_SCREWS),
)
SURFACE = Freedom(at.input_pulleys.surface, words=("smooth", "grooved"))
ENCODERS: tuple[Freedom, ...] = (
    Freedom(at.drive.encoder, kind="encoders", order="bore_mm"),
    Freedom(at.drive.drum_encoder, kind="encoders", order="bore_mm"),
)
# A metal frame or drum that the file leaves to its rule is of aluminium; steel is three times as stiff, and as heavy.
METALS: tuple[Freedom, ...] = tuple(
    Freedom(f"{part}.material", words=("aluminium-7075", "steel"), only_named=True) for part in ("drum", "support")
)
PARTS = (*DRIVE, *INPUTS, *ENCODERS, *METALS)


def first_radius(data: Mapping[str, Any]) -> dict[str, Any]:
    """Of a file with all radii of the drum, the field that gives the first alone; empty if it has none."""
    radii = data["transmission"].get("drum_radii_mm")
    return {at.transmission.drum_radius_mm: radii[0]} if radii else {}
