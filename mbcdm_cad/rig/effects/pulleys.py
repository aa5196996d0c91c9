"""Effects of the pulleys: radius, eccentricity, a step in or a worn place of a land, slip round a free input."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import pi, radians
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.block import SurfaceAngle
from mbcdm_cad.rig.effects.base import CableNames, Phase, RigEffect, Stage
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.displaced import offset_m, path_change_m


class RadiusError(RigEffect):
    """Pitch radius differs from the declared one.

    Grooves cut too deep or too shallow: pitch radii of drum or inputs off by ``error_um``, of all cables or some.

    If only one cable is concerned, its ratio differs from that of the others, and its tension changes with the angle.
    """

    effect: Literal["radius_error"]
    stage: Literal["drum", "inputs"]
    error_um: Annotated[float, Field(ge=-1000.0, le=1000.0)]
    cables: CableNames = ()

    def apply(self, bench: Bench) -> None:
        which = bench.which(self.cables)
        share = 0.0
        for j in which:
            cable = bench.cables[j]
            radius = cable.drum_radius_m if self.stage == "drum" else cable.input_radius_m
            factor = 1.0 + self.error_um * 1e-6 / radius
            bench.change([j], **{"drum_radius_m" if self.stage == "drum" else "input_radius_m": factor})
            share += (1.0 / factor if self.stage == "drum" else factor) - 1.0
        names = [bench.cables[j].name for j in which]
        bench.tell(
            "ratio_error",
            stage=self.stage,
            cause="radius_error",
            cables=names,
            parameters={"share": share / len(bench.cables)},
        )


class EccentricPulley(RigEffect):
    """Eccentric groove of a body that cables run on.

    The centre of the groove turns with the shaft, at the distance e from the axis and at the angle a + phase from the
    body's reference, a the shaft's angle. Each cable's path changes with its tangents
    (:mod:`mbcdm_cad.routes.displaced`), which changes tensions and friction. The preload was set with the shaft at
    zero.
    """

    effect: Literal["eccentric_pulley"]
    stage: Stage
    eccentricity_um: Annotated[float, Field(ge=0.0, le=1000.0)]
    phase_deg: Phase = 0.0

    def apply(self, bench: Bench) -> None:
        phase, e = radians(self.phase_deg), self.eccentricity_um * 1e-6
        body = bench.body(self.stage)

        def path(inputs: Floats, drum: Floats) -> Floats:
            moved = {body.name: offset_m(body, e, bench.body_rad(body, inputs, drum) + phase)}
            return np.stack([path_change_m(bench.routes, c.route, moved) for c in bench.cables])

        zero = path(np.zeros((len(bench.drive.input_names), 1)), np.zeros(1))
        bench.paths.append(lambda inputs, drum: path(inputs, drum) - zero)
        bench.tell(
            "once_per_rev",
            stage=self.stage,
            cause="eccentric_pulley",
            parameters={"eccentricity_m": e, "phase_rad": phase},
        )


def _raise_land(
    bench: Bench, effect: str, cable: str, raised_m: float, shape: Callable[[Floats], Floats], **figures: float
) -> None:
    """Let the path of a cable grow by a height times the integral ``shape`` over the drum's surface angle, and tell it.

    Surface angle x = -sigma theta_o counts from the tangent point at the centre, growing as rope is wound on; the
    wrap's length is the integral of the radius.
    """
    (j,) = bench.which((cable,))
    sigma = bench.cables[j].sigma

    def path(inputs: Floats, drum: Floats) -> Floats:
        longer = np.zeros((len(bench.cables), drum.size))
        longer[j] = raised_m * (shape(-sigma * drum) - shape(np.zeros(1)))
        return longer

    bench.paths.append(path)
    bench.tell(effect, in_vocabulary=False, cables=[cable], parameters=figures)


class StepClimb(RigEffect):
    """A cable that climbs up the flank of its step.

    From a given surface angle on it lies higher by ``height_um``: the radius rises over ``over_deg`` and stays up, so
    that from there on the cable winds faster than its partners and its tension grows with the travel.
    """

    effect: Literal["step_climb"]
    cable: str
    height_um: Annotated[float, Field(ge=0.0, le=2000.0)]
    from_deg: SurfaceAngle
    over_deg: Annotated[float, Field(gt=0.0, le=90.0)] = 2.0

    def apply(self, bench: Bench) -> None:
        begin, over = radians(self.from_deg), radians(self.over_deg)
        height = self.height_um * 1e-6
        shape = partial(rise_integral, begin=begin, over=over)
        _raise_land(bench, self.effect, self.cable, height, shape, height_m=height, from_rad=begin)


class LandWear(RigEffect):
    """Uneven wear of a drum land, the surface that carries a cable.

    Its radius is smaller by up to ``depth_um`` between two surface angles.
    """

    effect: Literal["land_wear"]
    cable: str
    depth_um: Annotated[float, Field(ge=0.0, le=1000.0)]
    from_deg: SurfaceAngle
    to_deg: SurfaceAngle

    @model_validator(mode="after")
    def _in_order(self) -> LandWear:
        if not self.to_deg > self.from_deg:
            raise ValueError("to_deg must lie above from_deg")
        return self

    def apply(self, bench: Bench) -> None:
        begin, end = radians(self.from_deg), radians(self.to_deg)
        depth = self.depth_um * 1e-6
        shape = partial(hump_integral, begin=begin, end=end)
        _raise_land(bench, self.effect, self.cable, -depth, shape, depth_m=depth, from_rad=begin, to_rad=end)


class InputCreep(RigEffect):
    """A cable that creeps over its input; its wrap is that of the design unless given.

    Nothing anchors it on the input: the rig's :mod:`mbcdm_cad.rig.through` on its true wrap. Without this effect each
    side of the cable counts as anchored there. With it the wrap has its built length, and where the travel carries off
    the part that sticks, the cable creeps under load as a belt does. ``wrap_deg`` is for a cable with fewer turns than
    designed; the effect ``rope_friction`` added to it, for one with less friction.
    """

    effect: Literal["input_creep"]
    wrap_deg: Annotated[float, Field(ge=90.0, le=5e5)] | None = None

    def apply(self, bench: Bench) -> None:
        free = [c.route.wraps[0].may_slip_through for c in bench.cables]
        if not any(free):
            raise KeyError("cable that friction alone holds on its input")
        found = bench.drive.layout.routed
        wraps = np.asarray(found.geometry.through_wrap_rad(found.parameters), dtype=float)
        if self.wrap_deg is not None:
            wraps[:] = radians(self.wrap_deg)
        bench.cables = tuple(
            replace(c, own_wrap_rad=float(wraps[j // 2]) / 2.0) if slips else c
            for j, (c, slips) in enumerate(zip(bench.cables, free, strict=True))
        )
        bench.tell("input_creep", parameters={"wrap_rad": float(wraps.min())})


def hump_integral(x: Floats, begin: float, end: float) -> Floats:
    """Integral up to x of a raised cosine of height 1 between ``begin`` and ``end``."""
    width = end - begin
    u = np.clip((x - begin) / width, 0.0, 1.0)
    return np.asarray(width * (0.5 * u - np.sin(2.0 * pi * u) / (4.0 * pi)))


def rise_integral(x: Floats, begin: float, over: float) -> Floats:
    """Integral up to x of a cosine ramp from 0 at ``begin`` to 1 at ``begin + over`` and on."""
    u = np.clip((x - begin) / over, 0.0, 1.0)
    ramp = over * (0.5 * u - np.sin(pi * u) / (2.0 * pi))
    return np.asarray(ramp + np.maximum(x - begin - over, 0.0))
