"""Play: the side in contact follows the sign of the transmitted torque; where friction decides, a play operator."""

from functools import partial

import numpy as np

from mbcdm_cad.loop.effect import Effect, Effects, Figure, Parameter, best_step
from mbcdm_cad.loop.prepare.prepared import played
from mbcdm_cad.loop.prepare.setup import DriveSI, Floats, Prepared, Setup, Simulator, input_shares
from mbcdm_cad.measurement.schema import MOTION

NAME, BY_MOTION = "lash", "play taken up by motion"
SEPARATE = "a constant bias torque keeps one side in contact: lash vanishes, friction does not"
# Range of torque at the drum in which the contact changes sides: a few times the sensor's noise.
DRUM_CHANGE_NM = 0.01
# An encoder before the play may have been set to zero with the pulley anywhere in it, so where its zero lies is fitted.
INPUT_PLAY = (Parameter("play_rad", 1e-4, 0.0), Parameter("zero_rad", 1e-4, -0.01, 0.01, role="place", default=0.0))


def _where_it_steps(setup: Setup, residual: Floats) -> list[list[float]]:
    """Two starts: contact that changes sides without a load, and at the load where one step explains most."""
    used = setup.p.used
    order = np.argsort(setup.load[used])
    return [[0.0, 0.0], [0.0, best_step(setup.load[used][order], residual[used][order])]]


def _input(index: int, setup: Setup, values: Floats, _: Simulator) -> Setup:
    rest = np.full(setup.p.time_s.size, float(values[1]))
    return setup.with_play(index, float(values[0])).with_shift(index, rest)


def by_motion(setup: Setup, values: Floats, _: Simulator) -> Setup:
    """The drum as it follows the motion behind a play of the first of ``values``, rad."""
    drum = setup.drum_rad
    return setup.with_added(played(drum, 0.5 * abs(float(values[0]))) - drum)


def width(setup: Setup, residual: Floats) -> list[list[float]]:
    """A start: the play that would cause the whole residual."""
    return [[float(np.ptp(np.quantile(residual, [0.05, 0.95])))]]


def _at_input(d: DriveSI, index: int, setup: Setup, residual: Floats) -> list[list[float]]:
    """Two starts: no play, and the play that would cause the whole residual through the input's share of the drum."""
    share = float(input_shares(d)[index])
    width = float(np.ptp(np.quantile(residual[setup.p.used], [0.05, 0.95])))
    return [[0.0, 0.0], [width * setup.ratio / share, 0.0]]


def offer(d: DriveSI | None, p: Prepared) -> Effects:
    """By torque where it was measured; by motion for a drive of which only the ratio is known, or without a load."""
    play = Parameter("play_rad", 1e-5, 0.0)
    idle = p.load_Nm is not None and not p.load_Nm.any()
    if p.load_Nm is not None and not idle:
        most = 0.5 * float(np.abs(p.load_Nm).max())
        yield Effect(
            NAME,
            "play at the output",
            "a coupling or gearhead rests on one flank or the other, by the load's sign",
            "coupling and key between drum and load; where the contact changes sides off zero, zero of the torque "
            "sensor, and friction that it does not see",
            SEPARATE,
            (play, Parameter("zero_Nm", 0.002, -most, most, role="place", default=0.0)),
            lambda s, v, _: s.with_added(-0.5 * v[0] * np.tanh((s.load - v[1]) / DRUM_CHANGE_NM)),
            starts=_where_it_steps,
            figures=(
                Figure("play_rad", lambda v: float(v[0])),
                Figure("zero_Nm", lambda v: float(v[1]), "torque of the sensor at which the contact changes sides"),
            ),
            plain="there is {play_rad} of play between drum and load",
        )
    if d is not None and p.load_Nm is not None:
        yield from (
            Effect(
                NAME,
                "play at an input",
                "play between input encoder and pulley; the torque from the preload holds one side in contact",
                f"gearhead and collar of input {name}",
                SEPARATE,
                INPUT_PLAY,
                partial(_input, index),
                figures=(Figure("play_rad", lambda v: float(v[0])),),
                starts=partial(_at_input, d, index),
                stage=f"input_{name}",
                saturates=True,
                plain="there is {play_rad} of play between encoder and pulley of the {stage}",
            )
            for index, name in enumerate(d.input_names)
        )
    if d is None or idle or (p.load_Nm is None and p.run.kind != MOTION):
        yield Effect(
            NAME,
            BY_MOTION,
            "friction holds the output until the play is taken up",
            "gears and couplings between input and output",
            SEPARATE,
            (play,),
            by_motion,
            starts=width,
            plain="there is {play_rad} of play between input and output",
        )
