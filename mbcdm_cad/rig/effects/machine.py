"""Effects of what surrounds the cables: friction of bearings and brake, motor and gearhead, encoders."""

from math import radians
from typing import Annotated, Literal

import numpy as np
from pydantic import AliasChoices, Field

from mbcdm_cad.rig.bench import Bench, Drag, ExperimentBlock, FrictionMilli, Stiffness
from mbcdm_cad.rig.motion import brake

CableNames = Annotated[tuple[str, ...], Field(max_length=16, strict=False)]
Share = Annotated[float, Field(ge=-0.9, le=3.0)]
# Name of a body of the drive's routes, such as "drum" or "input_left".
Stage = Annotated[str, Field(min_length=1, max_length=80)]
Phase = Annotated[float, Field(ge=-360.0, le=360.0)]


class RigEffect(ExperimentBlock):
    """One effect on the bench."""

    def apply(self, bench: Bench) -> None:
        """Change ``bench``. KeyError names a cable or a stage that the drive does not have."""
        raise NotImplementedError


PASSED = AliasChoices("passed_mNm", "guide_mNm")


class BearingFriction(RigEffect):
    """Friction torque of bearings.

    Friction in bearings of the drum and of passed bodies: the cables carry it, the torque sensor does not see it.

    Coulomb torque against the motion, with a short elastic start (``presliding_urad`` of drum angle from side to side).
    A passed body turns r_o/r times as fast as the drum, so its drag counts that many times at the drum. Near standstill
    there is ``stribeck_mNm`` more, which falls as exp(-|w|/``stribeck_mrad_s``) with the drum's speed w.
    """

    effect: Literal["bearing_friction"]
    drum_mNm: FrictionMilli = 0.0
    passed_mNm: Annotated[FrictionMilli, Field(validation_alias=PASSED)] = 0.0
    presliding_urad: Annotated[float, Field(gt=0.0, le=1e4)] = 100.0
    stribeck_mNm: FrictionMilli = 0.0
    stribeck_mrad_s: Annotated[float, Field(gt=0.0, le=1e5)] = 50.0

    def apply(self, bench: Bench) -> None:
        turns = sum(abs(body.turns_per_drum) for body in bench.routes.passed)
        torque = (self.drum_mNm + self.passed_mNm * turns) * 1e-3
        speed = np.gradient(bench.drum_rad, bench.time_s)
        more = self.stribeck_mNm * 1e-3
        limit = torque + more * np.exp(-np.abs(speed) / (self.stribeck_mrad_s * 1e-3))
        bench.hidden_Nm.append(brake(bench.drum_rad, limit, self.presliding_urad * 1e-6))
        bench.tell("friction", parameters={"torque_Nm": torque} | ({"stribeck_Nm": more} if more else {}))


class ViscousDrag(RigEffect):
    """Viscous drag at the drum.

    Grease and eddy currents between drum and torque sensor: a torque proportional to the drum's speed.
    """

    effect: Literal["viscous_drag"]
    drag_Nms: Drag

    def apply(self, bench: Bench) -> None:
        bench.hidden_Nm.append(self.drag_Nms * np.gradient(bench.drum_rad, bench.time_s))
        bench.tell("delay", cause="viscous_drag", parameters={"drag_Nms": self.drag_Nms})


class BrakeStickSlip(RigEffect):
    """Stick-slip of the brake.

    A brake that sticks: it winds up through its own stiffness to a static torque, then drops (rig/load.py).

    The torque sensor measures all of it, so nothing is left to explain; but it drives the friction of the cables.
    """

    effect: Literal["brake_stick_slip"]
    static_share: Annotated[float, Field(gt=1.0, lt=2.0)] = 1.2
    scatter: Annotated[float, Field(ge=0.0, le=0.2)] = 0.03
    stiffness_Nm_rad: Stiffness = 500.0

    def apply(self, bench: Bench) -> None:
        n = bench.time_s.size
        share = self.static_share * (1.0 + self.scatter * bench.rng.uniform(-1.0, 1.0, n))
        bench.stick_slip = np.stack([np.maximum(share, 1.0), np.full(n, self.stiffness_Nm_rad)], axis=1)
        bench.tell("brake_stick_slip", in_vocabulary=False, seen=False, parameters={"static_share": self.static_share})


class GearheadLash(RigEffect):
    """Lash (play) of the gearhead or coupling of an input.

    Play and softness between motor and input pulley.

    The gearhead's shaft drives the pulley with the torque s(phi - theta), zero within the play. The flank in contact
    follows from the torque of the cables on that input, including the bias of their preload; between the flanks the
    pulley floats at the angle at which the cables balance. Encoders on the pulleys measure this motion, so the effect
    shows only with ``sensors.input_at: motor``.
    """

    effect: Literal["gearhead_lash"]
    stage: Stage
    play_urad: Annotated[float, Field(ge=0.0, le=1e5)]
    # A stiff shaft by default, so that only the lash has an effect.
    stiffness_Nm_rad: Stiffness = 5000.0

    def apply(self, bench: Bench) -> None:
        i = bench.input_index(self.stage)
        bench.gear_play_rad[i] += self.play_urad * 1e-6
        bench.gear_stiffness_Nm_rad[i] = 1.0 / (1.0 / bench.gear_stiffness_Nm_rad[i] + 1.0 / self.stiffness_Nm_rad)
        bench.tell(
            "lash",
            seen=bench.input_at == "motor",
            stage=self.stage,
            parameters={"play_rad": self.play_urad * 1e-6, "compliance_rad_Nm": 1.0 / self.stiffness_Nm_rad},
        )


class GearMesh(RigEffect):
    """Ripple from the tooth mesh of a gearhead.

    Unequal gear teeth: the gearhead's output leads and lags with every tooth.

    Error amplitude sin(cycles a + phase) at the gearhead's output, a its angle. Encoders on the pulleys see the motion,
    so it shows only with ``sensors.input_at: motor``.
    """

    effect: Literal["gear_mesh"]
    stage: Stage
    amplitude_urad: Annotated[float, Field(ge=0.0, le=1e5)]
    cycles_per_input_rev: Annotated[float, Field(gt=0.0, le=1e6)]
    phase_deg: Phase = 0.0

    def apply(self, bench: Bench) -> None:
        i = bench.input_index(self.stage)
        amplitude, phase, cycles = self.amplitude_urad * 1e-6, radians(self.phase_deg), self.cycles_per_input_rev
        bench.gear_errors.append((i, lambda angle: np.asarray(amplitude * np.sin(cycles * angle + phase))))
        turns = bench.turns(i)
        bench.tell(
            "ripple",
            seen=bench.input_at == "motor",
            stage=self.stage,
            cause="gear_mesh",
            parameters={
                "cycles_per_output_rev": cycles * turns,
                "amplitude_rad": amplitude / turns / len(bench.drive.input_names),
            },
        )


class MotorCogging(RigEffect):
    """Cogging of a motor under its position loop.

    Cogging: the motor's torque ripples with its angle, and the position loop yields by torque over stiffness.

    Without dynamics the position loop is a static stiffness at the motor: error at the gearhead's output = torque /
    (loop stiffness x ratio), with ``cycles_per_motor_turn`` times ratio cycles a turn of the output. The encoders
    measure this motion wherever they sit, so nothing is left to explain; the motion is less smooth.
    """

    effect: Literal["motor_cogging"]
    stage: Stage
    torque_mNm: FrictionMilli
    cycles_per_motor_turn: Annotated[float, Field(gt=0.0, le=200.0)] = 6.0
    loop_stiffness_mNm_rad: Annotated[float, Field(gt=0.0, le=1e7)] = 2.0

    def apply(self, bench: Bench) -> None:
        i, ratio = bench.input_index(self.stage), bench.drive.reduction.ratio
        amplitude = self.torque_mNm / self.loop_stiffness_mNm_rad / ratio
        order = self.cycles_per_motor_turn * ratio
        bench.command_rad[i] += amplitude * np.sin(order * bench.command_rad[i])
        bench.tell(
            "motor_cogging",
            in_vocabulary=False,
            seen=False,
            stage=self.stage,
            parameters={"motion_amplitude_rad": amplitude, "cycles_per_input_rev": order},
        )


class SlowPart(RigEffect):
    """Creep of a printed or glued part under the load.

    A printed hub or a bond between the drum and its encoder gives way slowly: springs with dampers in series, one for
    each of ``per_decade_urad_Nm``, whose times are ten times apart from ``first_s`` on. No law of time is put in.
    """

    effect: Literal["slow_part"]
    per_decade_urad_Nm: Annotated[tuple[float, ...], Field(min_length=1, max_length=12, strict=False)]
    first_s: Annotated[float, Field(gt=0.0, le=1e6)] = 1.0

    def apply(self, bench: Bench) -> None:
        bench.slow_twist += [(1e-6 * give, self.first_s * 10.0**k) for k, give in enumerate(self.per_decade_urad_Nm)]
        total = 1e-6 * sum(self.per_decade_urad_Nm)
        bench.tell("creep", cause="slow_part", parameters={"give_rad_Nm": total, "first_s": self.first_s})


class ShaftCompliance(RigEffect):
    """Compliance of the output shaft.

    A soft shaft between the drum and its encoder: the encoder lags behind the drum by compliance times load torque.
    """

    effect: Literal["shaft_compliance"]
    compliance_urad_Nm: Annotated[float, Field(ge=0.0, le=1e8)]

    def apply(self, bench: Bench) -> None:
        bench.output_twist_rad_Nm += self.compliance_urad_Nm * 1e-6
        bench.tell(
            "stiffness_error",
            cause="shaft_compliance",
            parameters={"compliance_rad_Nm": self.compliance_urad_Nm * 1e-6},
        )


class EncoderScale(RigEffect):
    """Scale error of an encoder.

    An encoder that counts too many or too few lines a turn: it reads its shaft's angle times 1 + share.
    """

    effect: Literal["encoder_scale"]
    stage: Stage
    share_ppm: Annotated[float, Field(ge=-1e5, le=1e5)]

    def apply(self, bench: Bench) -> None:
        share = self.share_ppm * 1e-6
        bench.add_encoder_error(self.stage, lambda angle: np.asarray(share * angle))
        # Error of the ratio of output to inputs; one input counts with its share.
        inputs = len(bench.drive.input_names)
        ratio = share if self.stage == bench.routes.drum.name else -share / inputs
        bench.tell(
            "ratio_error", stage=self.stage, cause="encoder_scale", parameters={"share": ratio, "encoder_share": share}
        )


class EccentricEncoder(RigEffect):
    """Eccentric encoder on the drum's or an input's shaft.

    An encoder whose disc is not centred: at the shaft angle a its error is amplitude cos(a + phase).
    """

    effect: Literal["eccentric_encoder"]
    stage: Stage
    amplitude_urad: Annotated[float, Field(ge=0.0, le=1e5)]
    phase_deg: Phase = 0.0

    def apply(self, bench: Bench) -> None:
        amplitude, phase = self.amplitude_urad * 1e-6, radians(self.phase_deg)
        bench.add_encoder_error(self.stage, lambda angle: np.asarray(amplitude * np.cos(angle + phase)))
        bench.tell(
            "once_per_rev",
            stage=self.stage,
            cause="eccentric_encoder",
            parameters={"amplitude_rad": amplitude, "phase_rad": phase},
        )


class EncoderSubdivision(RigEffect):
    """Sub-division error of an encoder.

    Sub-division error: sine and cosine of an encoder's lines differ, which causes an error periodic in the lines.

    Unequal amplitudes give two periods a line, offsets one: ``cycles_per_rev`` is lines times that. Angle error
    amplitude sin(cycles a + phase) on the encoder's shaft.
    """

    effect: Literal["encoder_subdivision"]
    stage: Stage
    amplitude_urad: Annotated[float, Field(ge=0.0, le=1e5)]
    cycles_per_rev: Annotated[float, Field(gt=0.0, le=1e6)]
    phase_deg: Phase = 0.0

    def apply(self, bench: Bench) -> None:
        amplitude, phase, cycles = self.amplitude_urad * 1e-6, radians(self.phase_deg), self.cycles_per_rev
        bench.add_encoder_error(self.stage, lambda angle: np.asarray(amplitude * np.sin(cycles * angle + phase)))
        turns, part = 1.0, 1.0
        if self.stage != bench.routes.drum.name:
            turns, part = bench.turns(bench.input_index(self.stage)), 1.0 / len(bench.drive.input_names)
        # At the output the error of an input is divided by its ratio and by the number of inputs, which share about
        # equally.
        bench.tell(
            "ripple",
            stage=self.stage,
            cause="encoder_subdivision",
            parameters={"cycles_per_output_rev": cycles * turns, "amplitude_rad": amplitude / turns * part},
        )


class SensorDelay(RigEffect):
    """Delay of encoders.

    Readings that arrive late: the output's encoder, or all input encoders, ``delay_ms`` old.
    """

    effect: Literal["sensor_delay"]
    sensor: Literal["output", "inputs"] = "output"
    delay_ms: Annotated[float, Field(ge=0.0, le=1000.0)]

    def apply(self, bench: Bench) -> None:
        delay = self.delay_ms * 1e-3
        if self.sensor == "output":
            bench.output_delay_s += delay
        else:
            bench.input_delay_s += delay
        # Only the delay between output and inputs can be measured.
        bench.tell("delay", cause="sensor_delay", parameters={"delay_s": delay if self.sensor == "output" else -delay})
