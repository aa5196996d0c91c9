"""The bench as built: cables, sensors, and the drive of the design with all changes by the effects of an experiment.

The bench file has the limits of a bench, within which ``mbcdm plan --within`` proposes runs.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AliasChoices, BaseModel, ConfigDict, Field
from scipy.signal import lfilter

from mbcdm_cad.design.blocks import INERTIA_MAX_KG_M2, STIFFNESS_MAX_NM_RAD, TORQUE_MAX_NM, TRAVEL_MAX_DEG
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.lumped import Compliance, PartsFriction, compliance_of, friction_of
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.layouts.structure import input_play_rad
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.route import Body, CableRoute, DriveRoutes, Wrap

# Bounds of what rig and bench do to a drive and read of it: those of what a design may state.
Torque = Annotated[float, Field(ge=-TORQUE_MAX_NM, le=TORQUE_MAX_NM)]
Friction = Annotated[float, Field(ge=0.0, le=TORQUE_MAX_NM)]
FrictionMilli = Annotated[float, Field(ge=0.0, le=1e3 * TORQUE_MAX_NM)]
Drag = Annotated[float, Field(ge=0.0, le=1e2 * TORQUE_MAX_NM)]
Inertia = Annotated[float, Field(ge=0.0, le=INERTIA_MAX_KG_M2)]
Stiffness = Annotated[float, Field(gt=0.0, le=STIFFNESS_MAX_NM_RAD)]
SurfaceAngle = Annotated[float, Field(ge=-TRAVEL_MAX_DEG, le=TRAVEL_MAX_DEG)]
# Moment of a weight that hangs on an arm: on a short travel it loads the drum with a small part of it.
Moment = Annotated[float, Field(ge=-1e5 * TORQUE_MAX_NM, le=1e5 * TORQUE_MAX_NM)]


class ExperimentBlock(BaseModel):
    """Unknown fields and strings for numbers are refused; units are in the fields' names."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class PhysicsBlock(ExperimentBlock):
    """Choices of the physics that both rigs have."""

    # Rope that is wound on keeps its tension and brings it back; the analytic model assumes this to be off.
    cable_transport: bool = True
    # Rope also creeps on the bodies that it passes; left out, as the design counts it.
    passed_slip: Annotated[bool | None, Field(validation_alias=AliasChoices("passed_slip", "guide_slip"))] = None
    piece_mrad: Annotated[float, Field(ge=0.5, le=100.0)] = 20.0
    # Parts besides the cables give: drum, shafts, bearings, frame; gearheads where the rig knows them.
    structure: bool = False
    # Cables lose tension where they bend, bearings rub; gearheads and motors as the design states them.
    losses: bool = False


@dataclass(frozen=True)
class RigCable:
    """One cable, SI. ``sigma``: sense in which its tension turns the drum; ``input_index``: the input on which it runs.

    ``route`` is its route in the design; the radii of input and drum are those as built. ``own_wrap_rad`` is this
    side's half of a wrap over the input that only friction holds; 0 where the cable counts as anchored there.
    ``anchor_m_N``: how far its end on the drum gives way for each newton there, by springs.
    """

    name: str
    sigma: int
    input_index: int
    input_radius_m: float
    drum_radius_m: float
    stiffness_N: float  # E A
    preload_N: float
    friction: float
    route: CableRoute
    own_wrap_rad: float = 0.0
    anchor_m_N: float = 0.0

    @property
    def free_span_m(self) -> float:
        """Free span L_free of the design, m."""
        return self.route.free_length_m

    @property
    def passed(self) -> tuple[Wrap, ...]:
        """The wraps on bodies between input and drum."""
        return self.route.passed


def routes_of(drive: Drive) -> DriveRoutes:
    """The routes of the cables of ``drive``. Raises ValueError where the geometry leaves no free span."""
    found = layout_of(drive).routed
    routes = found.routes
    if any(math.isnan(route.free_length_m) for route in routes.cables):
        raise ValueError(found.geometry.fault(found.parameters))
    return routes


def cables_of(drive: Drive) -> tuple[RigCable, ...]:
    """The cables with the values of the design file. Raises ValueError where the geometry leaves no free span."""
    routes = routes_of(drive)
    return tuple(
        RigCable(
            name=route.cable,
            sigma=route.sense,
            input_index=drive.input_names.index(route.input_name),
            input_radius_m=route.input_radius_m,
            drum_radius_m=route.drum_radius_m,
            stiffness_N=drive.cable.axial_stiffness_N,
            preload_N=run.preload_N,
            friction=drive.friction_coefficient,
            route=route,
            anchor_m_N=drive.anchor_m_N,
        )
        for run, route in zip(drive.cables, routes.cables, strict=True)
    )


# As a measurement file may state them.
Resolution = Annotated[float, Field(ge=0.0, le=1.0)]
Noise = Annotated[float, Field(ge=0.0, le=1.0)]
Delay = Annotated[float, Field(ge=0.0, le=1.0)]


class BenchSensors(ExperimentBlock):
    """Encoders and torque sensor. A resolution of 0 means no steps; ``*_delay_s`` is not declared to the loop.

    ``input_at`` says where the input encoders sit: on the pulleys, or behind the motors, read at the gearhead's output.
    """

    input_at: Literal["pulley", "motor"] = "pulley"
    input_resolution_rad: Resolution = 1.9175e-4
    input_noise_rad: Noise = 0.0
    output_resolution_rad: Resolution = 1.3635e-6
    output_noise_rad: Noise = 0.0
    torque_noise_Nm: Friction = 0.005
    torque_delay_s: Delay = 0.0
    temperature_noise_K: Annotated[float, Field(ge=0.0, le=5.0)] = 0.05
    log_torque: bool = True


def counted(angle_rad: Floats, resolution_rad: float, noise_rad: float, rng: np.random.Generator) -> Floats:
    """The angle as an encoder counts it: noise is added, then it is rounded to steps with an arbitrary offset."""
    offset, noise = rng.random(), rng.standard_normal(angle_rad.size)
    seen = angle_rad + noise_rad * noise
    if resolution_rad == 0.0:
        return seen
    return np.asarray((np.floor(seen / resolution_rad + offset) - np.floor(offset)) * resolution_rad)


def late(time_s: Floats, value: Floats, delay_s: float) -> Floats:
    """The value ``delay_s`` earlier; before the start it is constant."""
    return value if delay_s == 0.0 else np.interp(time_s - delay_s, time_s, value)


LoadKind = Literal["brake", "weight", "torque_motor"]


class MotorCurrent(ExperimentBlock):
    """Motors' currents in place of a torque sensor: spread of the torque constant, one standard deviation as a share,
    and noise of the load that follows from them, at the drum."""

    torque_constant_share: Annotated[float, Field(ge=0.0, le=0.25)] = 0.05
    noise_Nm: Friction = 0.02


# Longest run, s.
MOST_DURATION_S = 20000.0


class BenchLimits(ExperimentBlock):
    """Limits of a bench; defaults: the travel of the design, no load, no limit of the speed."""

    format: Literal["mbcdm-bench-1"] = "mbcdm-bench-1"
    half_travel_deg: Annotated[float, Field(ge=0.01, le=TRAVEL_MAX_DEG)] | None = None
    duration_s: Annotated[float, Field(ge=60.0, le=MOST_DURATION_S)] = 160.0
    sample_rate_Hz: Annotated[float, Field(ge=1.0, le=5000.0)] = 100.0
    drum_speed_max_deg_s: Annotated[float, Field(gt=0.0, le=1e5)] | None = None
    loads: Annotated[tuple[LoadKind, ...], Field(max_length=3, strict=False)] = ()
    torque_Nm: Annotated[float, Field(gt=0.0, le=TORQUE_MAX_NM)] | None = None
    sensors: BenchSensors = BenchSensors()
    motor_current: MotorCurrent | None = None


# Extra path of every cable in m, (n_cables, n), for pulley angles (n_inputs, n) and drum angles (n,) in rad.
PathOf = Callable[[Floats, Floats], Floats]
# An angle error in rad, (n,), for the shaft's angle in rad, (n,).
ErrorOf = Callable[[Floats], Floats]


@dataclass
class Bench:
    """All that effects may change before a run; arrays over the n samples of ``time_s``.

    ``command_rad`` are the commanded angles of the gearheads, ``drum_rad`` the drum angle that they give without any
    error. ``passed_slip``: whether rope creeps on passed bodies; ``unseen_slip``: though the design does not count it.
    ``input_at`` is the place of the input encoders, "pulley" or "motor"; ``strains`` is the stress-free strain
    of rope over bed on each wrap, (n_cables, w, n), the wraps those of :mod:`mbcdm_cad.rig.chain`.
    """

    drive: Drive
    time_s: Floats
    drum_rad: Floats
    command_rad: Floats
    rng: np.random.Generator
    cables: tuple[RigCable, ...]
    routes: DriveRoutes
    input_at: str
    paths: list[PathOf] = field(default_factory=list)
    strains: Floats | None = None
    gear_stiffness_Nm_rad: list[float] = field(default_factory=list)
    gear_play_rad: list[float] = field(default_factory=list)
    gear_errors: list[tuple[int, ErrorOf]] = field(default_factory=list)
    hidden_Nm: list[Floats] = field(default_factory=list)
    stick_slip: Floats | None = None
    output_twist_rad_Nm: float = 0.0
    slow_twist: list[tuple[float, float]] = field(default_factory=list)
    encoder_errors: list[tuple[str, ErrorOf]] = field(default_factory=list)
    output_delay_s: float = 0.0
    input_delay_s: float = 0.0
    temperature_C: Floats | None = None
    compliance: Compliance = field(default_factory=Compliance)
    friction: PartsFriction | None = None
    passed_slip: bool = False
    unseen_slip: bool = False
    truth: list[dict[str, Any]] = field(default_factory=list)

    def count_structure(self) -> None:
        """Parts besides the cables give as the design states. Raises ValueError for a part without a figure."""
        try:
            self.compliance = compliance_of(self.drive)
        except NoFigureError as error:
            raise ValueError(str(error)) from None
        if self.input_at == "motor":
            before = 1.0 / self.compliance.before_inputs_Nm_rad
            if before > 0.0:
                self.gear_stiffness_Nm_rad = [1.0 / (1.0 / k + before) for k in self.gear_stiffness_Nm_rad]
            self.tell("structure", seen=False, stage="inputs", parameters={"compliance_rad_Nm": before})
        given = {"compliance_rad_Nm": self.compliance.land_to_encoder}
        play = input_play_rad(self.drive, motors_held=True)
        if play > 0.0:
            self.gear_play_rad = [own + play for own in self.gear_play_rad]
            self.tell("lash", seen=False, stage="inputs", cause="structure", parameters={"play_rad": play})
        # The measurement file lets the prediction count it, so that it is no effect of the drive.
        self.tell("stiffness_error", seen=False, cause="structure", parameters=given)

    def count_losses(self) -> None:
        """Bends of the cables and bearings rub as the design states."""
        self.friction = friction_of(self.drive)
        share, bearings = self.friction.drum_share, self.friction.drum_bearings_Nm
        torque = bearings + sum(s * c.preload_N * c.drum_radius_m for s, c in zip(share, self.cables, strict=True))
        self.tell("friction", seen=False, cause="losses", parameters={"torque_Nm": float(torque)})

    def change(self, which: list[int], **factors: float) -> None:
        """Multiply fields of these cables, as in ``change([0, 1], preload_N=0.9)``."""
        self.cables = tuple(
            replace(c, **{name: getattr(c, name) * factor for name, factor in factors.items()}) if j in which else c
            for j, c in enumerate(self.cables)
        )

    def which(self, names: tuple[str, ...]) -> list[int]:
        """Indices of the cables of these names; of all if there are no names. KeyError for an unknown name."""
        known = [c.name for c in self.cables]
        for name in names:
            if name not in known:
                raise KeyError(name)
        return [known.index(name) for name in names] if names else list(range(len(known)))

    def input_index(self, stage: str) -> int:
        """Index of the input of a stage such as ``input_left``; KeyError if the drive has none of that name."""
        names = [body.name for body in self.routes.inputs]
        if stage not in names:
            raise KeyError(stage)
        return names.index(stage)

    def turns(self, i: int) -> float:
        """Turns of input ``i`` for one of the drum."""
        return self.routes.inputs[i].turns_per_drum

    def body(self, stage: str) -> Body:
        """The body called ``stage``; KeyError if no cable of the drive runs on one of that name."""
        return self.routes.body(stage)

    def body_rad(self, body: Body, inputs: Floats, drum: Floats) -> Floats:
        """Angle of a body about its axis (n,) for pulley angles (n_inputs, n) and drum angles (n,)."""
        return np.asarray(
            inputs[self.routes.inputs.index(body)] if body.kind == "input" else drum * body.turns_per_drum
        )

    def add_encoder_error(self, stage: str, error: ErrorOf) -> None:
        """Add an angle error to the encoder of this stage; KeyError if the drive has no such encoder."""
        if stage != self.routes.drum.name:
            self.input_index(stage)
        self.encoder_errors.append((stage, error))

    def add_strain(self, which: list[int], free: Floats, wraps: tuple[Floats, Floats, Floats]) -> None:
        """Add a strain ``free`` (n,) to the free spans of these cables, and strains ``wraps`` relative to the pulleys.

        ``wraps`` are the strains on the input, on bodies that are passed, and on the drum.
        """
        n_wraps = 2 + max(len(c.passed) for c in self.cables)
        if self.strains is None:
            self.strains = np.zeros((len(self.cables), n_wraps, self.time_s.size))
        longer = np.zeros((len(self.cables), self.time_s.size))
        for j in which:
            longer[j] = free * self.cables[j].free_span_m
            for w in range(n_wraps):
                self.strains[j, w] += wraps[0 if w == 0 else 2 if w == n_wraps - 1 else 1]
        self.paths.append(lambda inputs, drum: -longer)

    def slow_twist_rad(self, load_Nm: Floats) -> Floats:
        """Twist of the parts that give way slowly under the load, rad (n,): each of ``slow_twist``, a give in rad/(N m)
        and a time in s, follows the load with that delay."""
        twist = np.zeros_like(load_Nm)
        for give, time in self.slow_twist:
            follows = 1.0 - np.exp(-(self.time_s[1] - self.time_s[0]) / time)
            twist += give * lfilter([follows], [1.0, follows - 1.0], load_Nm)
        return twist

    def tell(self, name: str, in_vocabulary: bool = True, seen: bool = True, **more: Any) -> None:
        """Write an effect into the truth. ``seen`` is false for an effect that the logged signals already contain."""
        entry: dict[str, Any] = {"name": name, "in_vocabulary": in_vocabulary}
        if not seen:
            entry["seen"] = False
        parameters = more.pop("parameters", {})
        self.truth.append({**entry, **more, "parameters": parameters})


def bench_of(
    drive: Drive,
    time_s: Floats,
    drum_rad: Floats,
    strays_rad: Floats,
    rng: np.random.Generator,
    physics: PhysicsBlock,
    input_at: str = "pulley",
) -> Bench:
    """A bench without effects: gearheads stiff and without play, cables as designed; of the parts what physics counts.

    Raises ValueError where the design has no cables' spans, or a part that is counted has no figure.
    """
    bench = Bench(drive, time_s, drum_rad, strays_rad, rng, cables_of(drive), routes_of(drive), input_at)
    n_inputs = len(drive.input_names)
    bench.command_rad = strays_rad + np.stack([drum_rad * bench.turns(i) for i in range(n_inputs)])
    bench.gear_stiffness_Nm_rad = [float("inf")] * n_inputs
    bench.gear_play_rad = [0.0] * n_inputs
    counted = layout_of(drive).slips_on_passed
    bench.passed_slip = counted if physics.passed_slip is None else physics.passed_slip
    bench.unseen_slip = bench.passed_slip and not counted
    if physics.structure:
        bench.count_structure()
    if physics.losses:
        bench.count_losses()
    return bench
