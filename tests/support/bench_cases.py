"""The cases: effects with random sizes by seed, and the motion of each case."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from tests.support.bench_effects import (
    ALL,
    Draw,
    amount,
    anchor,
    both,
    bump,
    climb,
    input_encoder,
    jump,
    nothing,
    output_encoder,
    pulley,
    ripple,
    shares,
    size,
    wear,
)
from tests.support.bench_motion import Plan


def motion(
    amplitudes: tuple[float, ...], loads: tuple[str, ...], waves: tuple[str, ...] = ("triangle", "sine")
) -> Callable[[np.random.Generator], Plan]:
    """A motion drawn from a few."""

    def draw(rng: np.random.Generator) -> Plan:
        plan = Plan(amplitude_rad=float(rng.choice(amplitudes)), load=str(rng.choice(loads)))
        wave = str(rng.choice(waves))
        return replace(plan, wave=wave, frequency_hz=float(rng.choice([0.05, 0.0625, 0.1])))

    return draw


# Once-per-turn effects want travel, load effects a load that does not only follow the speed.
WIDE = motion((0.45, 0.6), ("levels", "bias", "steps"))
ANY = motion((0.05, 0.45, 0.6), ("brake", "levels", "bias", "steps"))
LOADED = motion((0.05, 0.45, 0.6), ("levels", "bias", "steps"))
STEPS = motion((0.05, 0.45, 0.6), ("bias", "steps"))
BARE = motion((0.45, 0.6), ("bare",))
# On a triangle speed has one size, so that what goes with it cannot be told from what goes with its sign.
SINE = motion((0.45, 0.6), ("bias", "steps"), ("sine",))


@dataclass(frozen=True)
class Case:
    """A kind of run. ``group`` says by which aim it is judged: null, texture, single, fair, alike
    (nobody could tell from one run of this motion: a set is right), pair or outside."""

    plan: Callable[[np.random.Generator], Plan]
    effects: Draw
    group: str = "single"
    temperature: bool = False


_PULLEYS = {
    "pulley_drum": Case(WIDE, pulley("drum", 8.0, 30.0)),
    "pulley_guide": Case(WIDE, pulley("guide", 3.0, 12.0)),
    "pulley_input_left": Case(WIDE, pulley("input_left", 3.0, 12.0), "fair"),
    "pulley_input_right": Case(WIDE, pulley("input_right", 3.0, 12.0), "fair"),
    "encoder_drum": Case(WIDE, output_encoder(2e-4, 6e-4)),
    "encoder_input_left": Case(WIDE, input_encoder("input_left", 4e-4, 1.5e-3), "fair"),
    "encoder_input_right": Case(WIDE, input_encoder("input_right", 4e-4, 1.5e-3), "fair"),
}
_CABLES = {
    "preload_all": Case(LOADED, shares("preload_error", "preload", 0.2, 0.4, cables=ALL), "fair"),
    "preload_1": Case(LOADED, shares("preload_error", "preload", 0.3, 0.5, cables=(0,)), "fair"),
    "preload_2": Case(LOADED, shares("preload_error", "preload", 0.3, 0.5, cables=(1,)), "fair"),
    "preload_3": Case(LOADED, shares("preload_error", "preload", 0.3, 0.5, cables=(2,)), "fair"),
    "preload_4": Case(LOADED, shares("preload_error", "preload", 0.3, 0.5, cables=(3,)), "fair"),
    "cable_friction": Case(LOADED, shares("cable_friction", "mu", 0.25, 0.5), "fair"),
    "stiffness_modulus": Case(LOADED, shares("stiffness_error", "modulus", 0.12, 0.3)),
    "stiffness_shaft": Case(LOADED, size("stiffness_error", "shaft_compliance", "compliance_rad_Nm", 1.5e-5, 6e-5)),
    "winding": Case(WIDE, amount("winding_history", "transport", {})),
    "winding_short": Case(motion((0.05,), ("bias", "steps", "levels")), amount("winding_history", "transport", {})),
}
_REST = {
    "ratio_radii": Case(WIDE, shares("ratio_error", "radii", 1e-4, 6e-4)),
    "ratio_encoder": Case(WIDE, shares("ratio_error", "output_scale", 1e-4, 6e-4)),
    "ratio_bare": Case(BARE, shares("ratio_error", "output_scale", 1e-4, 6e-4)),
    "guide_bare": Case(BARE, pulley("guide", 3.0, 12.0)),
    "friction": Case(SINE, size("friction", "bearing", "torque_Nm", 0.08, 0.25)),
    "delay": Case(SINE, size("delay", "latency", "delay_s", 3e-4, 2e-3)),
    "drag": Case(SINE, size("delay", "viscous", "drag_Nm_s", 0.5, 1.5)),
    "lash_output": Case(STEPS, size("lash", "output_play", "play_rad", 4e-5, 2e-4)),
    "lash_input_left": Case(LOADED, size("lash", "input_play", "play_rad", 4e-4, 1.5e-3, stage="input_left")),
    "lash_input_right": Case(LOADED, size("lash", "input_play", "play_rad", 4e-4, 1.5e-3, stage="input_right")),
    "ripple_slow": Case(WIDE, ripple((20.0, 50.0), 1e-5, 4e-5)),
    "ripple_fast": Case(ANY, ripple((200.0, 700.0), 1e-5, 4e-5)),
    "thermal": Case(LOADED, size("thermal_drift", "warming", "turn_rad_K", 2e-5, 6e-5), "fair", temperature=True),
    "creep": Case(LOADED, amount("creep", "settling", {"amplitude_rad": (1e-5, 4e-5), "time_s": (2.0, 15.0)}), "fair"),
    "slip_anchor": Case(LOADED, anchor(4e-6, 1.5e-5)),
    "slip_mount": Case(LOADED, jump(2e-5, 8e-5)),
}
_ALIKE = {
    "delay_triangle": Case(motion((0.45, 0.6), ("bias",), ("triangle",)), _REST["delay"].effects),
    "friction_brake": Case(motion((0.45, 0.6), ("brake",), ("triangle",)), _REST["friction"].effects),
    "drum_short": Case(motion((0.05,), ("steps",)), output_encoder(3e-3, 6e-3)),
    "ratio_short": Case(motion((0.05,), ("steps",)), shares("ratio_error", "output_scale", 5e-4, 2e-3)),
    "winding_brake": Case(motion((0.45,), ("brake",)), _CABLES["winding"].effects),
}
_PAIRS = {
    "guide+ratio": ("pulley_guide", "ratio_encoder"),
    "guide+stiffness": ("pulley_guide", "stiffness_shaft"),
    "ripple+friction": ("ripple_fast", "friction"),
    "left+delay": ("pulley_input_left", "delay"),
    "winding+guide": ("winding", "pulley_guide"),
    "jump+ratio": ("slip_mount", "ratio_radii"),
    "modulus+ripple": ("stiffness_modulus", "ripple_slow"),
    "friction+guide": ("friction", "pulley_guide"),
    "thermal+right": ("thermal", "pulley_input_right"),
    "preload+ratio": ("preload_all", "ratio_encoder"),
}
_OUTSIDE = {
    "out_strand": Case(LOADED, bump(5e-5, 1.2e-4)),
    "out_climbing": Case(WIDE, climb(2e-5, 8e-5)),
    "out_worn_land": Case(WIDE, wear(3e-4, 1e-3)),
    "out_hardening": Case(LOADED, size("hardening", "hardening", "compliance_rad_Nm2", 3e-5, 8e-5)),
    "out_square": Case(LOADED, size("bending frame", "one_sided_square", "compliance_rad_Nm2", 3e-5, 8e-5)),
    "out_speed": Case(
        motion((0.45, 0.6), ("steps", "bias"), ("paced",)),
        size("speed squared", "speed_squared", "coefficient_rad_s2", 2e-3, 6e-3),
    ),
    "out_stick_slip": Case(
        LOADED, amount("stick-slip", "stick_slip", {"height_rad": (3e-5, 8e-5), "pitch_rad": (0.01, 0.04)})
    ),
    "out_wander": Case(LOADED, amount("wander", "wander", {"rms_rad": (1e-5, 3e-5), "memory_s": (1.0, 6.0)})),
}


def _pair(one: str, other: str) -> Case:
    singles = _PULLEYS | _CABLES | _REST
    first, second = singles[one], singles[other]
    temperature = first.temperature or second.temperature
    return Case(SINE, both(first.effects, second.effects), "pair", temperature)


CASES: dict[str, Case] = {
    "null": Case(ANY, nothing, "null"),
    "null_bare": Case(BARE, nothing, "null"),
    "null_texture": Case(ANY, amount("texture", "texture", {"rms_rad": (1e-6, 2e-6)}), "texture"),
    **_PULLEYS,
    **_CABLES,
    **_REST,
    **{name: replace(case, group="alike") for name, case in _ALIKE.items()},
    **{name: _pair(*parts) for name, parts in _PAIRS.items()},
    **{name: replace(case, group="outside") for name, case in _OUTSIDE.items()},
}
