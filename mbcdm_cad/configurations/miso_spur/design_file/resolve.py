"""Make a drive from a validated miso_spur design."""

from __future__ import annotations

from collections.abc import Mapping

from mbcdm_cad.configurations.miso_spur.design_file.schema import RoundDrumDesign
from mbcdm_cad.configurations.miso_spur.drive import RoundDrumDrive
from mbcdm_cad.configurations.siso_spur.design_file.resolve import spur_values
from mbcdm_cad.configurations.siso_spur.drive import laid
from mbcdm_cad.design.fieldpath import FieldPath
from mbcdm_cad.design.lookup import Catalogue


def drive(design: RoundDrumDesign, catalogue: Catalogue, sigmas: Mapping[FieldPath, float]) -> RoundDrumDrive:
    """The drive of a valid design."""
    return laid(RoundDrumDrive(**spur_values(design, catalogue, sigmas)))
