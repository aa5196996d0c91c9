"""Effects of pulleys (radius, eccentricity, lands, slip) and rope (modulus, friction, damage, creep, anchors)."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import pi, radians
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.rig.bench import Bench, SurfaceAngle
from mbcdm_cad.rig.effects.machine import CableNames, Phase, RigEffect, Share, Stage
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.route import offset_m, path_change_m


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
    (:mod:`mbcdm_cad.routes.route`), which changes tensions and friction. The preload was set with the shaft at
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


def _lengthen(bench: Bench, grown: dict[int, Callable[[Floats, Floats], Floats]]) -> None:
    """Let the path of each of these cables grow by a function of the angles of inputs and drum."""

    def path(inputs: Floats, drum: Floats) -> Floats:
        longer = np.zeros((len(bench.cables), drum.size))
        for j, of in grown.items():
            longer[j] = of(inputs, drum)
        return longer

    bench.paths.append(path)


def _raise_land(
    bench: Bench, effect: str, cable: str, raised_m: float, shape: Callable[[Floats], Floats], **figures: float
) -> None:
    """Let the path of a cable grow by a height times the integral ``shape`` over the drum's surface angle, and tell it.

    Surface angle x = -sigma theta_o counts from the tangent point at the centre, growing as rope is wound on; the
    wrap's length is the integral of the radius.
    """
    (j,) = bench.which((cable,))
    sigma = bench.cables[j].sigma
    _lengthen(bench, {j: lambda inputs, drum: raised_m * (shape(-sigma * drum) - shape(np.zeros(1)))})
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
    def _in_order(self) -> "LandWear":
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

    Nothing anchors it on the input: the rig's :mod:`mbcdm_cad.rig.chain` on its true wrap. Without this effect each
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
        found = layout_of(bench.drive).routed
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


class Modulus(RigEffect):
    """Modulus of the rope differs from the declared one.

    A rope softer or stiffer than declared: E A of every cable times 1 + share.
    """

    effect: Literal["modulus"]
    share: Share

    def apply(self, bench: Bench) -> None:
        bench.change(bench.which(()), stiffness_N=1.0 + self.share)
        bench.tell("stiffness_error", parameters={"share": self.share})


class Preload(RigEffect):
    """Preload differs from the declared one.

    Tensioners set to another preload than declared: T_pre of all cables, or of those named, times 1 + share.
    """

    effect: Literal["preload"]
    share: Share
    cables: CableNames = ()

    def apply(self, bench: Bench) -> None:
        which = bench.which(self.cables)
        bench.change(which, preload_N=1.0 + self.share)
        bench.tell("preload_error", cables=[bench.cables[j].name for j in which], parameters={"share": self.share})


class RopeFriction(RigEffect):
    """Friction of the rope on the pulleys differs from the declared one.

    Rope on pulley rougher or slicker than declared (dirt, oil): mu of every cable times 1 + share.
    """

    effect: Literal["rope_friction"]
    share: Share

    def apply(self, bench: Bench) -> None:
        bench.change(bench.which(()), friction=1.0 + self.share)
        bench.tell("cable_friction", parameters={"share": self.share})


class RopeLay(RigEffect):
    """Ripple from the twist (lay) of the strands of a rope.

    The rope's strands: its centre line rides higher where a strand's crown lies on the pulley, once for each lay
    length.

    Rope lies on each pulley in the same places whenever it is wound, so the pitch radius there is r + a sin(2 pi s /
    lay), s the length along the pulley from the tangent point at the centre. Wound angle x then takes the integral of
    that, on the input (x = sigma theta_i) and on the drum (x = -sigma theta_o).
    """

    effect: Literal["rope_lay"]
    amplitude_um: Annotated[float, Field(ge=0.0, le=500.0)]
    lay_mm: Annotated[float, Field(gt=0.1, le=100.0)] = 6.5
    phase_deg: Phase = 0.0
    cables: CableNames = ()

    def apply(self, bench: Bench) -> None:
        which, phase, wave = bench.which(self.cables), radians(self.phase_deg), 2.0 * pi / (self.lay_mm * 1e-3)
        height = self.amplitude_um * 1e-6

        def wound(x: Floats, radius: float) -> Floats:
            return np.asarray(height / (wave * radius) * (np.cos(phase) - np.cos(wave * radius * x + phase)))

        def grown(inputs: Floats, drum: Floats, j: int) -> Floats:
            c = bench.cables[j]
            on_input = wound(c.sigma * inputs[c.input_index], c.input_radius_m)
            return on_input + wound(-c.sigma * drum, c.drum_radius_m)

        _lengthen(bench, {j: partial(grown, j=j) for j in which})
        for j in which:
            c = bench.cables[j]
            bench.tell(
                "ripple",
                cause="rope_lay",
                cables=[c.name],
                parameters={"cycles_per_output_rev": wave * c.drum_radius_m},
            )


class StrandDamage(RigEffect):
    """Damaged strand: a local bump on a rope.

    A broken wire: the rope is thicker by ``height_um`` over ``length_mm`` at one place.

    Where the thick place lies on a pulley of radius r, the centre line lies further out by its height: the path grows
    by the integral of the height over the angle that it covers there, i.e. by height x covered length / r. In the free
    span it has no effect. ``position_mm`` is its middle, measured along the rope from the tangent point on the input
    with the drum at zero (so the first wrap that it passes begins after the first span); it moves with the rope.
    """

    effect: Literal["strand_damage"]
    cable: str
    height_um: Annotated[float, Field(ge=0.0, le=1000.0)]
    length_mm: Annotated[float, Field(gt=0.0, le=50.0)] = 2.0
    position_mm: Annotated[float, Field(ge=-2e4, le=2e4)]

    def apply(self, bench: Bench) -> None:
        (j,) = bench.which((self.cable,))
        c = bench.cables[j]
        half = 0.5e-3 * self.length_mm
        begin, passed = 0.0, []
        for span, wrap in zip(c.route.spans, c.passed, strict=False):
            begin += span.length_m
            end = begin + wrap.angle_rad * wrap.radius_m
            passed.append((begin, end, wrap.radius_m))
            begin = end
        drum_begin = begin + c.route.spans[-1].length_m

        def before(end_m: float, middle: Floats) -> Floats:
            """Integral of the height over the part of the rope on this side of ``end_m``."""
            return hump_integral(end_m - middle, -half, half)

        def extra(drum: Floats) -> Floats:
            middle = self.position_mm * 1e-3 - c.sigma * c.drum_radius_m * drum
            covered = before(0.0, middle) / c.input_radius_m
            for begin, end, radius_m in passed:
                covered = covered + (before(end, middle) - before(begin, middle)) / radius_m
            covered = covered + (half - before(drum_begin, middle)) / c.drum_radius_m
            return np.asarray(self.height_um * 1e-6 * covered)

        _lengthen(bench, {j: lambda inputs, drum: extra(drum) - extra(np.zeros(1))[0]})
        bench.tell(
            "strand_damage",
            in_vocabulary=False,
            cables=[self.cable],
            parameters={"height_m": self.height_um * 1e-6, "position_m": self.position_mm * 1e-3},
        )


class Creep(RigEffect):
    """Creep of ropes: they grow longer under tension.

    A new rope settles: its strands bed in and it grows by ``strain_ppm`` for each unit of ln(1 + t / t0).
    """

    effect: Literal["creep"]
    strain_ppm: Annotated[float, Field(ge=0.0, le=5000.0)]
    t0_s: Annotated[float, Field(gt=0.0, le=1e5)] = 5.0
    cables: CableNames = ()

    def apply(self, bench: Bench) -> None:
        grown = self.strain_ppm * 1e-6 * np.log1p(bench.time_s / self.t0_s)
        which = bench.which(self.cables)
        bench.add_strain(which, grown, (grown, grown, grown))
        bench.tell(
            "creep",
            cables=[bench.cables[j].name for j in which],
            parameters={"strain": self.strain_ppm * 1e-6, "t0_s": self.t0_s},
        )


class AnchorSlip(RigEffect):
    """Slip of a cable's anchor.

    Anchor slip: a terminal slips by ``slip_um`` within ``over_s``, and the rope of its short wrap slips with it.

    On the real drum the wrap before the anchor is about 20 degrees, and its friction holds only some 6 % of the
    tension. So the whole slip of the anchor reaches the tangent point, and the path changes by the whole slip.
    """

    effect: Literal["anchor_slip"]
    cable: str
    at_s: Annotated[float, Field(ge=0.0, le=1e5)]
    slip_um: Annotated[float, Field(ge=0.0, le=5000.0)]
    over_s: Annotated[float, Field(gt=0.0, le=100.0)] = 0.05

    def apply(self, bench: Bench) -> None:
        (j,) = bench.which((self.cable,))
        shorter = np.zeros((len(bench.cables), bench.time_s.size))
        shorter[j] = -self.slip_um * 1e-6 * np.clip((bench.time_s - self.at_s) / self.over_s, 0.0, 1.0)
        bench.paths.append(lambda inputs, drum: shorter)
        bench.tell("slip_step", cables=[self.cable], parameters={"time_s": self.at_s, "slip_m": self.slip_um * 1e-6})


Expansion = Annotated[float, Field(ge=0.0, le=100.0)]


class Temperature(RigEffect):
    """Thermal expansion of cables relative to frame and pulleys.

    Temperature: rope, frame and pulleys expand, each with its own coefficient.

    The temperature of the named ropes rises by rise (1 - e^(-t/tau)) from ``start_s`` on, and falls with the same tau
    from ``cool_s`` on; that of frame and pulleys changes by ``body_share`` of it. The free span expands with the frame,
    its rope with its own coefficient; rope that sticks to a pulley is strained by the difference of the expansions. The
    radii of drum and inputs grow by different shares, which changes the ratio. If all ropes warm alike, hardly anything
    but the preload changes; if one rope warms alone, the drum turns.
    """

    effect: Literal["temperature"]
    rise_K: Annotated[float, Field(ge=-100.0, le=100.0)]
    time_constant_s: Annotated[float, Field(gt=0.0, le=1e5)] = 60.0
    start_s: Annotated[float, Field(ge=0.0, le=1e5)] = 0.0
    cool_s: Annotated[float, Field(ge=0.0, le=1e5)] = 1e5
    cables: CableNames = ()
    body_share: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0
    rope_ppm_K: Expansion = 16.0
    frame_ppm_K: Expansion = 23.4
    drum_ppm_K: Expansion = 23.4
    input_ppm_K: Expansion = 12.0
    ambient_degC: Annotated[float, Field(ge=-50.0, le=100.0)] = 22.0
    log: bool = True

    def apply(self, bench: Bench) -> None:
        warm = self._since(bench.time_s, self.start_s) - self._since(bench.time_s, max(self.cool_s, self.start_s))
        rope, body = warm * self.rope_ppm_K * 1e-6, warm * self.body_share * 1e-6
        which = bench.which(self.cables)
        for j in range(len(bench.cables)):
            own = rope if j in which else np.zeros_like(rope)
            bench.add_strain(
                [j],
                own - body * self.frame_ppm_K,
                (own - body * self.input_ppm_K, own - body * self.frame_ppm_K, own - body * self.drum_ppm_K),
            )

        def grown(inputs: Floats, drum: Floats, j: int) -> Floats:
            c = bench.cables[j]
            wound = self.input_ppm_K * c.input_radius_m * inputs[c.input_index]
            return np.asarray(c.sigma * body * (wound - self.drum_ppm_K * c.drum_radius_m * drum))

        _lengthen(bench, {j: partial(grown, j=j) for j in range(len(bench.cables))})
        if self.log:
            bench.temperature_C = self.ambient_degC + warm
        bench.tell(
            "thermal_drift",
            cables=[bench.cables[j].name for j in which],
            parameters={"rise_K": self.rise_K, "time_constant_s": self.time_constant_s},
        )

    def _since(self, time_s: Floats, begin_s: float) -> Floats:
        return np.asarray(self.rise_K * -np.expm1(-np.maximum(time_s - begin_s, 0.0) / self.time_constant_s))
