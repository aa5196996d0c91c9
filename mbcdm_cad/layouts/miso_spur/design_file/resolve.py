"""Make a drive from a validated miso_spur design."""

from __future__ import annotations

from collections.abc import Mapping

from mbcdm_cad.design.fieldpath import FieldPath
from mbcdm_cad.design.lookup import Catalogue
from mbcdm_cad.layouts.miso_spur.design_file.schema import RoundDrumDesign
from mbcdm_cad.layouts.miso_spur.drive import RoundDrumDrive
from mbcdm_cad.layouts.siso_spur.design_file.resolve import spur_values
from mbcdm_cad.layouts.siso_spur.drive import laid


def drive(design: RoundDrumDesign, catalogue: Catalogue, sigmas: Mapping[FieldPath, float]) -> RoundDrumDrive:
    """The drive of a valid design."""
    return laid(RoundDrumDrive(**spur_values(design, catalogue, sigmas)))
