"""The dynamic rig as data: the motors, gearheads, loops, sensors and moments of inertia of a drive.

At the input the rotor counts with the square of the gearhead's ratio, which is far more than the pulleys.

SI throughout; inputs are positive when they drive the drum positive, a load torque when it opposes positive rotation.
"""

from dataclasses import dataclass, field

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.lumped import Compliance, PartsFriction
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.rig.bench import PathOf, RigCable, cables_of, routes_of
from mbcdm_cad.rig.chain import PIECE_RAD
from mbcdm_cad.rig.dynamic import train
from mbcdm_cad.routes.route import DriveRoutes

_G_CM2 = 1e-7  # kg m2


@dataclass(frozen=True)
class Inertias:
    """Moments of inertia in kg m2, each about its own axis; the rotor's is not reflected through the gearhead."""

    rotor_kg_m2: float
    gear_ratio: float
    bodies_kg_m2: dict[str, float]
    routes: DriveRoutes

    @property
    def inputs_kg_m2(self) -> tuple[float, ...]:
        """Inertia that each input turns on its side of the gearhead."""
        return tuple(self.bodies_kg_m2[body.name] for body in self.routes.inputs)

    @property
    def drum_and_passed_kg_m2(self) -> float:
        """The drum and all bodies that the cables turn with it, reflected to the drum."""
        total = self.bodies_kg_m2[self.routes.drum.name]
        for body in self.routes.passed:
            total += self.bodies_kg_m2[body.name] * body.turns_per_drum**2
        return total


def inertias(drive: Drive) -> Inertias:
    """Inertias of the moving parts of ``drive``. Raises ValueError where they have no form."""
    rotor = drive.motor.rotor_inertia_g_cm2 * _G_CM2
    try:
        bodies = dict(layout_of(drive).inertias_kg_m2)
    except NoFigureError as error:
        raise ValueError(str(error)) from None
    return Inertias(rotor, drive.reduction.ratio, bodies, routes_of(drive))


STEP_S = 1e-4
BANDWIDTH_HZ = 5.0
LOOP_RATE_HZ = 1000.0
# Resolution of encoder B of the paper's rig, 18000 lines times 256 [section 5].
DRUM_RESOLUTION_RAD = 1.3635e-6


@dataclass(frozen=True)
class EncoderSpec:
    """An encoder: resolution, white noise before counting, and delay of its readings."""

    resolution_rad: float
    noise_rad: float = 0.0
    delay_s: float = 0.0

    def __post_init__(self) -> None:
        train.require_not_negative(self, "resolution_rad", "noise_rad", "delay_s")


@dataclass(frozen=True)
class DynamicRig:
    """A drive on the bench: a motor, gearhead, loop and encoder for each input, in the order of the drive's inputs.

    ``cables`` are as built, ``paths`` give their extra length as a function of the angles, as of an eccentric pulley;
    ``piece_rad``, ``transport`` and ``passed_slip`` as in :func:`mbcdm_cad.rig.chain.chains`. Drags are Coulomb
    friction in bearings, each at its own shaft. ``compliance`` and ``friction`` are those of the parts besides the
    cables; as they stand, all parts are rigid and only motors and gearheads lose.
    """

    drive: Drive
    cables: tuple[RigCable, ...]
    motors: tuple[train.MotorSpec, ...]
    gearheads: tuple[train.GearheadSpec, ...]
    loops: tuple[train.ControllerSpec, ...]
    encoders: tuple[EncoderSpec, ...]
    drum_encoder: EncoderSpec = field(default_factory=lambda: EncoderSpec(DRUM_RESOLUTION_RAD))
    load: train.LoadSpec = field(default_factory=train.LoadSpec)
    torque_noise_Nm: float = 0.005
    input_drag_Nm: float = 0.0
    passed_drag_Nm: float = 0.0
    step_s: float = STEP_S
    piece_rad: float = PIECE_RAD
    transport: bool = True
    passed_slip: bool = False
    paths: tuple[PathOf, ...] = ()
    compliance: Compliance = field(default_factory=Compliance)
    friction: PartsFriction | None = None


def rig_of(
    drive: Drive,
    load: train.LoadSpec | None = None,
    ideal_gearhead: bool = False,
    bandwidth_Hz: float = BANDWIDTH_HZ,
    rate_Hz: float = LOOP_RATE_HZ,
) -> DynamicRig:
    """The rig with the design's motors, gearheads and encoders; the loops are tuned to the inertia of each input."""
    load = load or train.LoadSpec()
    motor, gearhead = train.motor_of(drive), train.gearhead_of(drive, ideal_gearhead)
    moved = inertias(drive)
    n_inputs = len(drive.input_names)
    share = (moved.drum_and_passed_kg_m2 + load.inertia_kg_m2) / n_inputs
    turns = input_turns(drive)
    loops = tuple(
        train.ControllerSpec(
            moved.rotor_kg_m2 * gearhead.ratio**2 + moved.inputs_kg_m2[i] + share / turns[i] ** 2,
            motor.torque_limit_Nm * gearhead.ratio,
            bandwidth_Hz,
            rate_Hz,
        )
        for i in range(n_inputs)
    )
    encoder = EncoderSpec(drive.encoder.resolution_urad * 1e-6)
    return DynamicRig(
        drive, cables_of(drive), (motor,) * n_inputs, (gearhead,) * n_inputs, loops, (encoder,) * n_inputs, load=load
    )


def input_turns(drive: Drive) -> tuple[float, ...]:
    """Turns of each input for one of the drum: the mean over its cables."""
    return tuple(body.turns_per_drum for body in routes_of(drive).inputs)
