"""Base of every block of an experiment file."""

from __future__ import annotations

from typing import Annotated

from pydantic import AliasChoices, BaseModel, ConfigDict, Field


class ExperimentBlock(BaseModel):
    """Unknown fields and strings for numbers are refused; units are in the fields' names."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class PhysicsBlock(ExperimentBlock):
    """Choices of the physics that both rigs have."""

    # Rope that is wound on keeps its tension and brings it back; the analytic model assumes this to be off.
    cable_transport: bool = True
    # Rope also creeps on the bodies that it passes; left out, as the design counts it.
    passed_slip: Annotated[bool | None, Field(validation_alias=AliasChoices("passed_slip", "guide_slip"))] = None
    piece_mrad: Annotated[float, Field(ge=0.5, le=100.0)] = 20.0
    # Parts besides the cables give: drum, shafts, bearings, frame; gearheads where the rig knows them.
    structure: bool = False
    # Cables lose tension where they bend, bearings rub; gearheads and motors as the design states them.
    losses: bool = False
