"""Experiment file of the dynamic rig (``rig: dynamic``): motion, load, sensors and effects."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AliasChoices, Field

from mbcdm_cad.rig.block import Drag, ExperimentBlock, Friction, Inertia, Moment, PhysicsBlock, Torque
from mbcdm_cad.rig.dynamic.controller import chirp, sine, standstill
from mbcdm_cad.rig.effects.registry import AnyEffect
from mbcdm_cad.rig.quasistatic.motion import WIDEST_MRAD
from mbcdm_cad.rig.sensors import Delay, Noise, Resolution
from mbcdm_cad.routes import Floats

Share = Annotated[float, Field(ge=0.0, le=1.0)]


class DynamicMotion(ExperimentBlock):
    """A sine of the drum's angle that starts from rest, standstill, or a chirp: a sweep of the frequency with one size
    of the acceleration, for a frequency response."""

    shape: Literal["sine", "hold", "chirp"] = "sine"
    amplitude_mrad: Annotated[float, Field(gt=0.0, le=WIDEST_MRAD)] = 50.0
    frequency_Hz: Annotated[float, Field(ge=1e-3, le=20.0)] = 0.1
    acceleration_rad_s2: Annotated[float, Field(gt=0.0, le=1e4)] = 10.0
    from_Hz: Annotated[float, Field(ge=0.5, le=400.0)] = 5.0
    to_Hz: Annotated[float, Field(ge=0.5, le=400.0)] = 150.0

    def reference(self, duration_s: float, rate_Hz: float) -> Floats:
        """Angle, speed and acceleration of the drum at each period of the loops, (n, 3)."""
        if self.shape == "hold":
            return standstill(duration_s, rate_Hz)
        if self.shape == "chirp":
            return chirp(self.acceleration_rad_s2, self.from_Hz, self.to_Hz, duration_s, rate_Hz)
        return sine(self.amplitude_mrad * 1e-3, self.frequency_Hz, duration_s * self.frequency_Hz, rate_Hz)


class DynamicLoad(ExperimentBlock):
    """Brake and torque motor may act together; a brake with a ``static_ratio`` above 1 sticks and slips."""

    brake_Nm: Friction = 0.0
    static_ratio: Annotated[float, Field(ge=1.0, le=3.0)] = 1.0
    static_speed_rad_s: Annotated[float, Field(gt=0.0, le=1.0)] = 1e-3
    torque_Nm: Torque = 0.0
    ramp_Nm_s: Torque = 0.0
    inertia_kg_m2: Inertia = 0.0
    unbalance_Nm: Moment = 0.0


class Drives(ExperimentBlock):
    """Motors and gearheads; defaults are those of the design. ``lossless`` switches all their friction off."""

    lossless: bool = False
    cogging_share: Share = 0.0  # of the rated torque, once a turn of the motor unless the order says otherwise
    cogging_per_turn: Annotated[float, Field(gt=0.0, le=200.0)] = 1.0
    lash_mrad: Annotated[float, Field(ge=0.0, le=100.0)] = 0.0
    mesh_error_urad: Annotated[float, Field(ge=0.0, le=1e4)] = 0.0
    mesh_per_motor_turn: Annotated[float, Field(gt=0.0, le=200.0)] = 1.0
    bandwidth_Hz: Annotated[float, Field(ge=0.5, le=25.0)] = 5.0


class BearingDrag(ExperimentBlock):
    """Friction of the bearings, each at its own shaft. The torque sensor does not see it.

    At the drum it is drum_Nm + viscous_Nms |w| + stribeck_Nm exp(-|w|/stribeck_rad_s), w its speed, and a share of the
    load: one while the drum moves against it, one while the load moves the drum.
    """

    input_Nm: Friction = 0.0
    passed_Nm: Annotated[Friction, Field(validation_alias=AliasChoices("passed_Nm", "guide_Nm"))] = 0.0
    drum_Nm: Friction = 0.0
    viscous_Nms: Drag = 0.0
    stribeck_Nm: Friction = 0.0
    stribeck_rad_s: Annotated[float, Field(gt=0.0, le=100.0)] = 0.05
    driving_share: Share = 0.0
    driven_share: Share = 0.0


class DynamicSensors(ExperimentBlock):
    """Errors of the sensors; the position loops use the input encoders too, the other sensors are only logged."""

    input_resolution_rad: Resolution = 1.9175e-4
    input_noise_rad: Noise = 0.0
    input_delay_s: Delay = 0.0
    output_resolution_rad: Resolution = 1.3635e-6
    output_noise_rad: Noise = 0.0
    output_delay_s: Delay = 0.0
    torque_noise_Nm: Friction = 0.005

    @property
    def log_torque(self) -> bool:
        """The dynamic rig always logs the torque."""
        return True


class DynamicPhysics(PhysicsBlock):
    """Choices of the physics."""

    step_us: Literal[20, 50, 100, 200, 500] = 100


class DynamicExperiment(ExperimentBlock):
    """An experiment on the dynamic rig. ``paper`` runs one of the paper's three and needs nothing else."""

    rig: Literal["dynamic"]
    name: Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9_-]{0,79}$")]
    about: Annotated[str, Field(max_length=500)] = ""
    seed: Annotated[int, Field(ge=0, le=2**31 - 1)] = 1
    paper: Literal["driving-capability", "positioning", "backlash"] | None = None
    duration_s: Annotated[float, Field(gt=0.0, le=2000.0)] = 160.0
    sample_rate_Hz: Literal[50, 100, 200, 500, 1000] = 100
    motion: DynamicMotion = DynamicMotion()
    load: DynamicLoad = DynamicLoad()
    drives: Drives = Drives()
    bearings: BearingDrag = BearingDrag()
    sensors: DynamicSensors = DynamicSensors()
    physics: DynamicPhysics = DynamicPhysics()
    effects: Annotated[tuple[AnyEffect, ...], Field(max_length=50, strict=False)] = ()
