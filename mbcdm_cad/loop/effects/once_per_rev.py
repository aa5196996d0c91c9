"""Eccentric pulleys and encoders, and encoders that are wrong twice a turn.

An eccentric pulley moves its centre round its axis by e; the path of each of its cables changes by e . u_j for each
span that touches the pulley (u_j: unit vector of the span), inside the stretch delta_j, so it works the friction. An
eccentric encoder reads its own shaft wrongly by a wave of the shaft's angle; twice a turn by a disc that is oval or
tilted, a magnet whose field is not round, or two read heads that do not match.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from mbcdm_cad.loop.effect import Effect, Figure, length, pair, phase, wave
from mbcdm_cad.loop.prepare.setup import DriveSI, Floats, Prepared, Setup, Simulator
from mbcdm_cad.routes.route import path_slope


def path_change(d: DriveSI, stage: str, x: Floats, y: Floats) -> Floats:
    """Change of each cable's path, m, (n_cables, n), when the centre of the body ``stage`` is displaced by (x, y), m.

    x is along the body's reference, y at a right angle to it about the body's axis. KeyError if the drive has no such
    body.
    """
    body = d.routes.body(stage)
    along, across = np.array(body.reference), np.cross(body.axis, body.reference)
    slopes = np.array([path_slope(route, stage) for route in d.routes.cables])
    return np.asarray((slopes @ along)[:, None] * x + (slopes @ across)[:, None] * y)


NAME = "once_per_rev"
# Ratios nearer to 1 than this tell input and output encoder apart too slowly.
LEAST_APART = 0.05
TURN = "re-clock the encoder by 90 degrees on its shaft and run again: an encoder's phase turns with it, a pulley's not"


def _pulley(stage: str, setup: Setup, values: Floats, _: Simulator) -> Setup:
    d = setup.drive
    body = d.routes.body(stage)
    if body.kind == "input":
        shaft = setup.input_shaft_rad(d.routes.inputs.index(body))
    else:
        shaft = setup.drum_rad * body.turns_per_drum
    return setup.with_path(path_change(d, stage, *wave(values, shaft)))


def _input_encoder(index: int, waves: int, setup: Setup, values: Floats, _: Simulator) -> Setup:
    return setup.with_shift(index, -wave(values, waves * setup.input_shaft_rad(index))[0])


def _encoders(stage: str, size: float, apply: Callable[..., Setup], seen: float) -> list[Effect]:
    """The errors of one encoder, once and twice a turn; ``seen``: the share of them that the drum shows."""
    once = Effect(
        NAME,
        "eccentric encoder",
        "the disc of the encoder sits off centre on its shaft",
        f"runout of the encoder's disc on the shaft of the {stage}",
        TURN,
        pair(size, "rad"),
        partial(apply, 1),
        stage=stage,
        figures=(
            Figure("amplitude_rad", lambda v: seen * length(v)),
            Figure("phase_rad", phase, "minus the shaft angle at which it reads highest"),
        ),
        physical=(Figure("encoder_error_rad", length),),
        plain="the encoder disc of the {stage} sits off centre: it is wrong by {amplitude_rad} at the drum once a turn",
    )
    twice = replace(
        once,
        name="twice_per_rev",
        form="encoder",
        physics="the encoder is wrong twice a turn of its shaft: a disc that is oval or tilted, a magnet off its axis",
        where_to_look=f"tilt and distance of the encoder's disc or magnet on the shaft of the {stage}",
        apply=partial(apply, 2),
        plain="the encoder of the {stage} is wrong by {amplitude_rad} at the drum, twice a turn",
    )
    return [once, twice]


def _eccentric(stage: str, lever_m: float) -> Effect:
    return Effect(
        NAME,
        "eccentric pulley",
        "the pitch circle runs out: each cable's path changes by e . u_j",
        f"runout of the pulley on the {stage}, with a dial gauge on its steps",
        TURN,
        pair(1e-6, "m"),
        partial(_pulley, stage),
        stage=stage,
        figures=(
            Figure("amplitude_rad", lambda v: length(v) / lever_m),
            Figure("eccentricity_m", length),
            Figure("phase_rad", phase, "where its high side points at zero travel, from +x"),
        ),
        physical=(Figure("eccentricity_m", length),),
        plain="the pulley of the {stage} runs {eccentricity_m} off centre",
    )


def offer(d: DriveSI | None, p: Prepared) -> Iterator[Effect]:
    """Encoders always, pulleys where the drive is known."""
    yield from _encoders("drum", 1e-5, lambda waves, s, v, _: s.with_added(wave(v, waves * s.drum_rad)[0]), 1.0)
    if d is None:
        ratio = float(p.run.ratio or 1.0)
        # At a ratio of 1 both encoders do the same.
        if abs(ratio - 1.0) > LEAST_APART:
            yield from _encoders("input", 1e-5 * ratio, partial(_input_encoder, 0), 1.0 / ratio)
        return
    ratio = float(np.mean(d.total_ratio))
    # Amplitude at the drum of one metre off centre, per pulley: its spans' mean lever.
    middle = float(np.mean(d.drum_radius_m))
    if p.load_Nm is not None:
        yield _eccentric(d.routes.drum.name, middle)
    yield from (_eccentric(body.name, middle) for body in d.routes.passed)
    for index, body in enumerate(d.routes.inputs):
        share = float(np.mean(d.of_input(index)))
        yield _eccentric(body.name, middle / share)
        yield from _encoders(body.name, 1e-4, partial(_input_encoder, index), share / ratio)
