"""Base of all effects."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.block import ExperimentBlock

CableNames = Annotated[tuple[str, ...], Field(max_length=16, strict=False)]
Share = Annotated[float, Field(ge=-0.9, le=3.0)]
# Name of a body of the drive's routes, such as "drum" or "input_left".
Stage = Annotated[str, Field(min_length=1, max_length=80)]
Phase = Annotated[float, Field(ge=-360.0, le=360.0)]


class RigEffect(ExperimentBlock):
    """One effect on the bench."""

    def apply(self, bench: Bench) -> None:
        """Change ``bench``. KeyError names a cable or a stage that the drive does not have."""
        raise NotImplementedError
