"""The friction of a design's drive, from its routes, its bearings and the catalogue entries of gearhead and motor."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from mbcdm_cad.design.bought import CableStageOutput
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.model import losses
from mbcdm_cad.model.losses import BearingPair, RopeBend, Train
from mbcdm_cad.model.si import MM, DriveSI, to_si
from mbcdm_cad.routes.route import body_load, two_bearing_reactions_N

if TYPE_CHECKING:
    from mbcdm_cad.design.bought import Bearing
    from mbcdm_cad.layouts.base import Layout
    from mbcdm_cad.layouts.sector import SectorLayout
    from mbcdm_cad.routes.route import Body, DriveRoutes


def train_of(layout: Layout) -> Train:
    """The friction of one design. Bearings that have no place, because parts have no geometry, do not count.

    Raises ``ModelError`` where the routes have no free span.
    """
    drive = layout.drive
    d, gear, motor, stage = to_si(drive), drive.gearhead, drive.motor, drive.stage
    idle = motor.idle_torque_mNm
    try:
        bearings = tuple(layout.bearing_friction(d))
    except NoFigureError:
        bearings = ()
    idle_at_input = 0.0 if gear.absent else losses.GEARHEAD_IDLE_SHARE * gear.rated_torque_mNm * 1e-3
    if isinstance(gear, CableStageOutput):
        idle_at_input = gear.idle_torque_Nm
    if stage is not None:
        idle_at_input *= stage.ratio
    return Train(
        d=d,
        rope=tuple(_rope_bends(d.routes, drive.cable.diameter_mm * MM)),
        bearings=bearings,
        fibre=drive.cable.construction == "braid",
        gear_ratio=drive.reduction.ratio,
        gear_share=losses.gearhead_share(drive.reduction.efficiency),
        gear_idle_Nm=idle_at_input,
        motor_idle_Nm=losses.motor_idle_mNm(motor.rated_torque_mNm, idle) * 1e-3,
        motor_sigma=losses.MOTOR_IDLE_SIGMA if idle is None else losses.MOTOR_STATED_SIGMA,
        stage_share=0.0 if stage is None else losses.gearhead_share(stage.efficiency),
        gear_words=drive.mounted if isinstance(gear, CableStageOutput) else "gearheads",
    )


def _rope_bends(routes: DriveRoutes, rope_m: float) -> Iterator[RopeBend]:
    """Inputs, each passed body, drum: half a sheave's loss for each tangent point of a cable."""
    groups = [("inputs", routes.inputs), *((body.name, (body,)) for body in routes.passed), ("drum", (routes.drum,))]
    for name, bodies in groups:
        names = {body.name for body in bodies}
        share = np.zeros(len(routes.cables))
        for j, route in enumerate(routes.cables):
            for at in route.contacts():
                if at.wrap.body in names:
                    points = (at.arriving is not None) + (at.leaving is not None)
                    share[j] += points * float(losses.tangent_share(rope_m, 2.0 * at.wrap.radius_m))
        yield RopeBend(f"cables on the {name}", share, on_input=name == "inputs")


def body_bearings(
    d: DriveSI,
    body: Body,
    name: str,
    specs: tuple[Bearing, Bearing],
    at_mm: tuple[float, float],
    axial_N: float = 0.0,
    input_index: int | None = None,
) -> BearingPair:
    """The two bearings of a body, with their middles along its axis."""
    lower, upper = (z * MM for z in at_mm)
    columns = []
    for one in np.eye(d.n_cables):
        load = body_load(d.routes, body.name, one)
        columns.append(two_bearing_reactions_N(load.force_N, load.moment_Nm, load.height_m, lower, upper, body.axis))
    bores = (specs[0].bore_mm * MM, specs[1].bore_mm * MM)
    return BearingPair(name, body.turns_per_drum, bores, np.stack(columns, axis=2), axial_N, input_index)


def sector_bearings(layout: SectorLayout, d: DriveSI) -> Iterator[BearingPair]:
    """Bearings of the inputs and of the drum's shaft."""
    routes, bearings = d.routes, layout.drive.bearings
    ends = (bearings.input_lower, bearings.input_upper)
    for i, body in enumerate(routes.inputs):
        lower, upper = (z * layout.levels_sense for z in layout.input_bearings_mm(i))
        yield body_bearings(d, body, "input pulleys' bearings", ends, (lower, upper), input_index=i)
    both = (bearings.drum, bearings.drum)
    spring = layout.preload_spring.force_N
    yield body_bearings(d, routes.drum, "drum's bearings", both, layout.drum_bearings_mm, spring)
