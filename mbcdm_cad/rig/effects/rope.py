"""Effects of the rope: modulus, preload, friction on pulleys, strands, broken wires, creep, anchors, temperature."""

from __future__ import annotations

from math import pi, radians
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.effects.base import CableNames, Phase, RigEffect, Share
from mbcdm_cad.rig.effects.pulleys import hump_integral
from mbcdm_cad.routes import Floats


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

        def path(inputs: Floats, drum: Floats) -> Floats:
            longer = np.zeros((len(bench.cables), drum.size))
            for j in which:
                c = bench.cables[j]
                longer[j] = wound(c.sigma * inputs[c.input_index], c.input_radius_m) + wound(
                    -c.sigma * drum, c.drum_radius_m
                )
            return longer

        bench.paths.append(path)
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
            on_input = before(0.0, middle)
            covered = on_input / c.input_radius_m
            for begin, end, radius_m in passed:
                covered = covered + (before(end, middle) - before(begin, middle)) / radius_m
            on_drum = half - before(drum_begin, middle)
            covered = covered + on_drum / c.drum_radius_m
            return np.asarray(self.height_um * 1e-6 * covered)

        def path(inputs: Floats, drum: Floats) -> Floats:
            longer = np.zeros((len(bench.cables), drum.size))
            longer[j] = extra(drum) - extra(np.zeros(1))[0]
            return longer

        bench.paths.append(path)
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

        def grown(inputs: Floats, drum: Floats) -> Floats:
            return np.stack(
                [
                    c.sigma
                    * body
                    * (
                        self.input_ppm_K * c.input_radius_m * inputs[c.input_index]
                        - self.drum_ppm_K * c.drum_radius_m * drum
                    )
                    for c in bench.cables
                ]
            )

        bench.paths.append(grown)
        if self.log:
            bench.temperature_C = self.ambient_degC + warm
        bench.tell(
            "thermal_drift",
            cables=[bench.cables[j].name for j in which],
            parameters={"rise_K": self.rise_K, "time_constant_s": self.time_constant_s},
        )

    def _since(self, time_s: Floats, begin_s: float) -> Floats:
        return np.asarray(self.rise_K * -np.expm1(-np.maximum(time_s - begin_s, 0.0) / self.time_constant_s))
