"""The reference design, the folder of design files, and the root of the repository, for all tests."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from mbcdm_cad.layouts.loader import load_design

# The fixture ``says``: what a command with these words prints as ``out`` and ``err``; it must exit with a code, by
# default 0.
Says = Callable[..., Any]

ROOT = Path(__file__).parents[2]
PARAMS = ROOT / "params"
REFERENCE = PARAMS / "mbcdm.yaml"
DRIVE = load_design(REFERENCE).drive


ABOVE = """
name: above
configuration: miso_bevel
travel: {half_angle_deg: 35.0}
transmission: {ratio: 9.0, drum_radius_mm: 54.0}
loads: {peak_torque_Nm: 3.15}
drive: {motor_side: above}
"""
