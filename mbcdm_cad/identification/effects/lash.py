"""Play: the side in contact follows the sign of the torque carried; where friction decides, a play operator."""

from __future__ import annotations

from functools import partial

import numpy as np

from mbcdm_cad.identification.effect import Effect, Parameter
from mbcdm_cad.identification.prepared import Prepared
from mbcdm_cad.identification.setup import Setup, Simulator, input_torque_Nm
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.routes import Floats
from mbcdm_cad.storage.compiled import compiled

SEPARATE = "a constant bias torque keeps one side in contact: lash vanishes, friction does not"
# Torque at the drum over which the contact changes sides: a few times the sensor's noise.
DRUM_CHANGE_NM = 0.01
# Rounds in which a floating pulley finds its place; slipping cables are softer, so each leaves under half of the way.
ROUNDS = 3


def _output(setup: Setup, values: Floats, _: Simulator) -> Setup:
    return setup.with_added(-0.5 * values[0] * np.tanh(setup.load / DRUM_CHANGE_NM))


def _input(index: int, setup: Setup, values: Floats, _: Simulator) -> Setup:
    """The pulley lags by half the play on the face that carries, and floats between where neither face is pressed.

    In the gap it stands where its cables leave no torque. That is found by rounds over the whole run: the torque left,
    over the stiffness that the pulley sees while its cables stick, is how far it has yet to move. A single input turns
    with the drum and sees none: it never floats, and the sign of its torque decides.
    """
    d, half = setup.drive, 0.5 * float(values[0])
    bias = float(np.sum(d.sigma * d.input_radius_m * d.preload_N * d.of_input(index)))
    start = half if bias >= 0.0 else -half
    stiffness = _stiffness_Nm_rad(d, index)
    lag = np.full(setup.p.time_s.size, start)
    for _round in range(ROUNDS):
        carried = input_torque_Nm(setup.with_shift(index, start - lag), index)
        if stiffness == 0.0:
            lag = np.where(carried == 0.0, lag, half * np.sign(carried))
        else:
            lag = np.clip(lag + carried / stiffness, -half, half)
    return setup.with_shift(index, start - lag)


def _stiffness_Nm_rad(d: DriveSI, index: int) -> float:
    """Torque at one input per angle of it, the other inputs held and the drum under a constant load, N m/rad.

    Zero for a single input.
    """
    if d.n_inputs == 1:
        return 0.0
    each = d.axial_stiffness_N / d.free_span_m
    own = d.of_input(index)
    direct = float(np.sum(own * each * d.input_radius_m**2))
    crossed = float(np.sum(own * each * d.input_radius_m * d.drum_radius_m))
    return direct - crossed**2 / float(np.sum(each * d.drum_radius_m**2))


@compiled
def _play(drive: Floats, half: float, out: Floats) -> None:
    at = drive[0]
    for k in range(drive.size):
        at = min(max(at, drive[k] - half), drive[k] + half)
        out[k] = at


def _operator(setup: Setup, values: Floats, _: Simulator) -> Setup:
    drum = np.ascontiguousarray(setup.drum_rad)
    out = np.empty_like(drum)
    _play(drum, 0.5 * abs(float(values[0])), out)
    return setup.with_added(out - drum)


def _width(setup: Setup, residual: Floats) -> list[list[float]]:
    return [[float(np.ptp(np.quantile(residual, [0.05, 0.95])))]]


def _at_input(d: DriveSI, index: int, setup: Setup, residual: Floats) -> list[list[float]]:
    """No play, and as much as makes what is left if the input moves its share of the drum."""
    share = float(np.sum(d.drum_radius_m**2 / d.free_span_m * d.of_input(index)))
    share /= float(np.sum(d.drum_radius_m**2 / d.free_span_m))
    width = float(np.ptp(np.quantile(residual[setup.p.used], [0.05, 0.95])))
    return [[0.0], [width * setup.ratio / share]]


def offer(d: DriveSI | None, p: Prepared) -> list[Effect]:
    """By torque where it was measured; by motion for a drive of which only the ratio is known."""
    found = []
    play = (Parameter("play_rad", 1e-5, 0.0),)
    if p.load_Nm is not None:
        found.append(
            Effect(
                "lash",
                "play at the output",
                "a coupling or gearhead rests on one flank or the other, by the load's sign",
                "coupling and key between drum and load",
                SEPARATE,
                play,
                _output,
                generic=True,
                plain="there is {play_rad} of play between drum and load",
            )
        )
    if d is not None and p.load_Nm is not None:
        found += [
            Effect(
                "lash",
                "play at an input",
                "play between input encoder and pulley; the preload's bias holds one side",
                f"gearhead and collar of input {name}",
                SEPARATE,
                (Parameter("play_rad", 1e-4, 0.0),),
                partial(_input, index),
                starts=partial(_at_input, d, index),
                stage=f"input_{name}",
                generic=True,
                plain="there is {play_rad} of play between encoder and pulley of the {stage}",
            )
            for index, name in enumerate(d.input_names)
        ]
    if d is None:
        found.append(
            Effect(
                "lash",
                "play taken up by motion",
                "friction holds the output until the play is taken up",
                "gears and couplings between input and output",
                SEPARATE,
                play,
                _operator,
                starts=_width,
                generic=True,
                plain="there is {play_rad} of play between input and output",
            )
        )
    return found
