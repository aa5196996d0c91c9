"""Base of every block of an experiment file."""

from __future__ import annotations

from typing import Annotated

from pydantic import AliasChoices, BaseModel, ConfigDict, Field

from mbcdm_cad.design.blocks import INERTIA_MAX_KG_M2, STIFFNESS_MAX_NM_RAD, TORQUE_MAX_NM, TRAVEL_MAX_DEG

# Bounds of what rig and bench do to a drive and read of it: those of what a design may state.
Torque = Annotated[float, Field(ge=-TORQUE_MAX_NM, le=TORQUE_MAX_NM)]
Friction = Annotated[float, Field(ge=0.0, le=TORQUE_MAX_NM)]
FrictionMilli = Annotated[float, Field(ge=0.0, le=1e3 * TORQUE_MAX_NM)]
Drag = Annotated[float, Field(ge=0.0, le=1e2 * TORQUE_MAX_NM)]
Inertia = Annotated[float, Field(ge=0.0, le=INERTIA_MAX_KG_M2)]
Stiffness = Annotated[float, Field(gt=0.0, le=STIFFNESS_MAX_NM_RAD)]
SurfaceAngle = Annotated[float, Field(ge=-TRAVEL_MAX_DEG, le=TRAVEL_MAX_DEG)]
# Moment of a weight that hangs on an arm: on a short travel it loads the drum with a small part of it.
Moment = Annotated[float, Field(ge=-1e5 * TORQUE_MAX_NM, le=1e5 * TORQUE_MAX_NM)]


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
