"""The configuration of Fig. 1 (b): two to four inputs evenly round one drum, each with its own cable."""

from __future__ import annotations

from mbcdm_cad.layouts.folder import FolderConfiguration
from mbcdm_cad.layouts.interface import Conventions
from mbcdm_cad.layouts.miso_spur.drive import round_drum

CONFIGURATION = FolderConfiguration(
    __name__,
    "two to four inputs evenly round one drum, a cable round each, axes parallel (Fig. 1 b)",
    Conventions(
        frame="Frame: origin on the drum axis (Y), in the middle of the first input's cable; the first input stands at "
        "+Z, the others evenly about Y, each further along it; lengths in mm.",
        cables="Cables are round rods at the nominal diameter; their turns walk along the inputs as the drum turns.",
    ),
    round_drum,
)
