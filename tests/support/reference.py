"""The reference design, the folder of design files, and the root of the repository, for all tests."""

from pathlib import Path

from mbcdm_cad.layouts.loader import load_design

ROOT = Path(__file__).parents[2]
PARAMS = ROOT / "params"
DRIVE = load_design(PARAMS / "mbcdm.yaml").drive
