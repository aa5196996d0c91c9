"""The design file of miso_spur: what the loader needs to read it, and a short file to start from."""

from __future__ import annotations

from mbcdm_cad.design.design_file import DesignFile, LazySizing
from mbcdm_cad.layouts.miso_spur.design_file.resolve import broken_rules, drive
from mbcdm_cad.layouts.miso_spur.design_file.schema import REFERENCE, RoundDrumDesign
from mbcdm_cad.layouts.siso_spur.design_file import starting
from mbcdm_cad.layouts.siso_spur.design_file.resolve import named_entries

STARTING = starting("miso_spur", 4.0, "# inputs: [{{name: a}}, {{name: b}}, {{name: c}}]  # left out: two inputs\n")
DESIGN_FILE = DesignFile(
    RoundDrumDesign,
    REFERENCE.values,
    broken_rules,
    named_entries,
    drive,
    LazySizing("mbcdm_cad.layouts.miso_spur.sizing"),
    STARTING,
)
