"""What a design's preload is made of, what more or less of it would do, and how the built drive measures its own."""

from dataclasses import dataclass
from math import radians

import numpy as np

from mbcdm_cad.checks.strength import needed_share
from mbcdm_cad.layouts.base import Layout, NoFigureError
from mbcdm_cad.layouts.life import life_with
from mbcdm_cad.model import preload_ramp
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.losses import BEARINGS, ROPE
from mbcdm_cad.model.preload_ramp import HeldDrive, MeasuredPreloads, Ramp, SampleNoise
from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.model.stiffness import drum_backlash
from mbcdm_cad.model.tensioning import influence
from mbcdm_cad.routes import Floats

# Preloads of the table over the design's own, and points of the curve on which the knee is sought.
FACTORS = (0.5, 0.71, 1.0, 1.41, 2.0)
_CURVE = 41
# Shares of the torque at the knee and of a whole ramp's angle that one sample is known to: a current's usual noise, and
# the encoder's resolution.
TORQUE_NOISE = 0.005


@dataclass(frozen=True)
class AtPreload:
    """The drive with all its preloads ``factor`` times as large.

    ``lowest_share``: lowest tension at the peak torque over the preload; ``swing_mrad`` at a reversal of the test
    torque; ``life_factor``: of the cables' median life, None without a figure; friction at the drum without a load.
    """

    factor: float
    preload_N: float
    lowest_share: float
    swing_mrad: float
    life_factor: float | None
    rope_Nm: float
    bearings_Nm: float


@dataclass(frozen=True)
class PreloadRule:
    """The design's largest preload among the preloads that its limits would allow, N.

    ``slack_N``: the least that keeps all cables taut at the peak torque; ``knee_N``: beyond it more preload buys
    little; ``most_N``: what ``limits.preload_share_max`` allows.
    """

    preload_N: float
    slack_N: float
    knee_N: float
    most_N: float
    table: tuple[AtPreload, ...]


@dataclass(frozen=True)
class NutTurn:
    """Correction of one cable: measured and wanted preload, N, and turns of its nut (positive: tighter)."""

    cable: str
    measured_N: float
    sigma_N: float
    wanted_N: float
    turns: float


def preload_rule(layout: Layout) -> PreloadRule:
    """Where the design's preload stands. Raises ``NoFigureError`` where the cables have no tensions."""
    needed, si = layout.once("preload needed", needed_share), layout.si
    own = float(si.preload_N.max())
    most = layout.drive.limits.preload_share_max * layout.drive.cable.breaking_load_N
    slack = needed * own
    try:
        return PreloadRule(own, slack, _knee_N(layout, si, slack, most), most, _table(layout, si))
    except ModelError as error:
        raise NoFigureError(f"the model has no answer: {error}") from None


def _table(layout: Layout, si: DriveSI) -> tuple[AtPreload, ...]:
    lives, rows = [life_with(layout, si.with_(preload_N=f * si.preload_N)) for f in FACTORS], []
    own = lives[FACTORS.index(1.0)]
    peak = layout.drive.loads.peak_torque_Nm
    for factor, life in zip(FACTORS, lives, strict=True):
        changed = si.with_(preload_N=factor * si.preload_N)
        tension = solve_equilibrium(changed, np.array([peak, -peak])).tension_N
        moved = layout.losses.with_drive(changed).moving(0.0, 1)
        lost = {kind: sum(float(x.torque_Nm[0]) for x in moved.losses if x.kind == kind) for kind in (ROPE, BEARINGS)}
        rows.append(
            AtPreload(
                factor,
                float(changed.preload_N.max()),
                float((tension / changed.preload_N[:, None]).min()),
                1e3 * float(drum_backlash(changed, layout.drive.loads.test_torque_Nm).reversal_swing_rad),
                None if own is None or life is None else life / own,
                lost[ROPE],
                lost[BEARINGS],
            )
        )
    return tuple(rows)


def _knee_N(layout: Layout, si: DriveSI, low_N: float, high_N: float) -> float:
    """The preload at which the curve of swing over preload is furthest from its chord between the two preloads.

    Both axes count as shares of their range (Satopaa and others, 2011, "Finding a kneedle in a haystack").
    """
    own = float(si.preload_N.max())
    if not low_N < high_N:
        return low_N
    preload = np.linspace(max(low_N, 0.02 * high_N), high_N, _CURVE)
    torque = layout.drive.loads.test_torque_Nm
    many = si.spread(_CURVE).with_(preload_N=si.preload_N[:, None] * preload / own)
    swing = np.asarray(drum_backlash(many, torque).reversal_swing_rad)
    x, y = (preload - preload[0]) / np.ptp(preload), (swing - swing[-1]) / max(float(np.ptp(swing)), 1e-30)
    return float(preload[int(np.argmax(1.0 - x - y))])


def noise_of(layout: Layout, knee_Nm: float) -> SampleNoise:
    """Noise of a sample: the input encoder's resolution, and the usual one of a current for the torque."""
    return SampleNoise(layout.drive.encoder.resolution_urad * 1e-6 / np.sqrt(12.0), TORQUE_NOISE * knee_Nm)


def ramps(layout: Layout, at_motor: bool = False) -> tuple[Ramp, ...]:
    """Expected ramps of every input, torque on its shaft or, ``at_motor``, the motor's times the gearhead's ratio.

    Raises ``NoFigureError`` for cables that slip on their input before they slack.
    """
    held = _held(layout, at_motor)
    d = held.d
    if d.through_wrap_rad is not None:
        raise NoFigureError(
            "the cable passes through its input and slips there before a side goes slack; set its preload by its pitch "
            "or a gauge"
        )
    try:
        return tuple(
            preload_ramp.expected(held, i, noise_of(layout, min(abs(knee) for knee in preload_ramp.knees_Nm(held, i))))
            for i in range(d.n_inputs)
        )
    except ModelError as error:
        raise NoFigureError(str(error)) from None


def measured(
    layout: Layout, input_name: str, angle_rad: Floats, torque_Nm: Floats, at_motor: bool = False
) -> MeasuredPreloads:
    """Preloads from the ramps of one input, samples in the order of time; ``at_motor`` as in :func:`ramps`.

    Raises ``ModelError`` for an unknown input or a log that does not do.
    """
    held = _held(layout, at_motor)
    d = held.d
    if input_name not in d.input_names:
        raise ModelError(f"no input {input_name}; the drive has {', '.join(d.input_names)}")
    largest = float(np.abs(torque_Nm).max()) if np.size(torque_Nm) else 1.0
    return preload_ramp.fitted(held, d.input_names.index(input_name), angle_rad, torque_Nm, noise_of(layout, largest))


def _held(layout: Layout, at_motor: bool) -> HeldDrive:
    """The drive with its drum at its stops, its friction as ``analyse`` counts it."""
    stop, si = layout.half_travel_rad + radians(layout.drive.stop_clearance_deg), layout.si
    train = layout.losses.with_drive(si)
    return HeldDrive(si, layout.wraps_rad(-stop), layout.wraps_rad(stop), train, at_motor)


def nut_turns(layout: Layout, found: tuple[MeasuredPreloads, ...]) -> tuple[NutTurn, ...]:
    """Which nut to turn by how much; cables that were not measured count as they should be.

    Raises ``NoFigureError`` for a layout without nuts that are set one by one.
    """
    plan, si = layout.tensioning, layout.si
    if plan is None:
        raise NoFigureError("the layout has no plan of its nuts")
    goal = si.preload_N
    now, sigma = goal.copy(), np.zeros_like(goal)
    for one in found:
        now[list(one.cables)], sigma[list(one.cables)] = one.preload_N, one.sigma_N
    stiffness = np.array([1.0 / (c.turns_per_N * plan.pitch_m) for c in plan.cables])
    drawn, *_ = np.linalg.lstsq(influence(stiffness, si.sigma * si.drum_radius_m), goal - now, rcond=None)
    return tuple(
        NutTurn(name, float(now[k]), float(sigma[k]), float(goal[k]), float(drawn[k] / plan.pitch_m))
        for k, name in enumerate(si.cable_names)
    )
