"""The design file of miso_spur: what the loader needs to read it."""

from __future__ import annotations

from mbcdm_cad.configurations.miso_spur.design_file.reference import SHARED
from mbcdm_cad.configurations.miso_spur.design_file.resolve import drive
from mbcdm_cad.configurations.miso_spur.design_file.rules import broken_rules
from mbcdm_cad.configurations.miso_spur.design_file.schema import RoundDrumDesign
from mbcdm_cad.configurations.siso_spur.design_file.rules import named_entries
from mbcdm_cad.design.design_file import DesignFile

DESIGN_FILE = DesignFile(RoundDrumDesign, SHARED, broken_rules, named_entries, drive)
