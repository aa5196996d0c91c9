"""What ``mbcdm solve`` may change of drives with a motor head, besides derived dimensions: parts and preload."""

from __future__ import annotations

from mbcdm_cad.checks.design_variables import ROPE_DIAMETER
from mbcdm_cad.configurations.head_parts import COLLAR_SCREWS
from mbcdm_cad.design.freedom import Freedom

PARTS: tuple[Freedom, ...] = (
    Freedom("rope.type", kind="ropes", order="diameter_mm", mends=((ROPE_DIAMETER, 1),)),
    Freedom("rope.preload_N", 0.5, 2.0),
    Freedom("drive.motor", kind="motors", order="rated_torque_mNm"),
    Freedom("drive.gearhead", kind="gearheads", order="max_torque_mNm"),
    Freedom("drum.tensioner", kind="tensioners", order="stud_length_mm"),
    Freedom("drum.bearing", kind="bearings", order="bore_mm"),
    Freedom("input_pulleys.lower_bearing", kind="bearings", order="bore_mm"),
    Freedom("input_pulleys.upper_bearing", kind="bearings", order="bore_mm"),
    Freedom("input_pulleys.collar_screw", words=COLLAR_SCREWS),
    Freedom("drive.encoder", kind="encoders", order="bore_mm"),
    Freedom("drive.drum_encoder", kind="encoders", order="bore_mm"),
)
