"""Motion and load of an experiment: the drum's reference angle over time, and what the torque sensor measures.

Positive torque opposes positive rotation. A brake's torque follows the motion through its own twist (``flank_mrad`` of
drum angle from one side to the other): tau += 2 level dtheta / flank, held within the level.
"""

from math import pi
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mbcdm_cad.rig.bench import ExperimentBlock, Inertia, Moment, Torque
from mbcdm_cad.routes import Floats
from mbcdm_cad.storage.compiled import compiled

# Widest motion of a drum from its centre, mrad: the three turns that a whole drum may have.
WIDEST_MRAD = 19000.0
# Longest period of a motion.
LONGEST_PERIOD_S = 1e4


class Motion(ExperimentBlock):
    """Triangle or sine about the centre, or a hold after a quarter of a period. Angles are the drum's."""

    shape: Literal["triangle", "sine", "hold"] = "triangle"
    amplitude_mrad: Annotated[float, Field(gt=0.0, le=WIDEST_MRAD)]
    period_s: Annotated[float, Field(gt=0.0, le=LONGEST_PERIOD_S)]
    # Time over which a corner of the triangle is rounded: a position loop cannot reverse instantly.
    corner_s: Annotated[float, Field(ge=0.0, le=10.0)] = 0.2
    # Slow difference (30 to 90 s) between left and right position loops, at the input pulleys.
    stray_urad: Annotated[float, Field(ge=0.0, le=1e4)] = 20.0

    def drum_rad(self, time_s: Floats) -> Floats:
        """The drum's angle over time, starting at zero; shape of ``time_s``."""
        phase = time_s / self.period_s
        amplitude = self.amplitude_mrad * 1e-3
        if self.shape == "hold":
            return amplitude * np.sin(0.5 * pi * np.minimum(4.0 * phase, 1.0))
        if self.shape == "sine":
            return amplitude * np.sin(2.0 * pi * phase)
        # The moving mean of the triangle over the corner's time, from its closed integral; the corner becomes a
        # parabola.
        half = 0.5 * min(self.corner_s / self.period_s, 0.5)
        if half == 0.0:
            return amplitude * np.asarray(1.0 - 4.0 * np.abs((phase + 0.25) % 1.0 - 0.5))
        wave = (_triangle_integral(phase + half) - _triangle_integral(phase - half)) / (2.0 * half)
        return amplitude * wave

    def strays_rad(self, time_s: Floats, n_inputs: int, rng: np.random.Generator) -> Floats:
        """Deviation of each input from its command, rad (n_inputs, n): three slow sines of random period and phase."""
        total = np.zeros((n_inputs, time_s.size))
        for i in range(n_inputs):
            for period, phase in zip(rng.uniform(30.0, 90.0, 3), rng.uniform(0.0, 2.0 * pi, 3), strict=True):
                total[i] += self.stray_urad * 1e-6 * np.sin(2.0 * pi * time_s / period + phase) / np.sqrt(3.0)
        return total


def _triangle_integral(phase: Floats) -> Floats:
    """Integral of the triangle wave, periodic since its mean is zero."""
    p = (phase + 0.25) % 1.0
    return np.asarray(np.where(p < 0.5, 2.0 * p * p - p, -2.0 * (p - 1.0) ** 2 + (1.0 - p)))


class Load(ExperimentBlock):
    """The load. ``levels_Nm`` follow one another, each for ``periods_per_level`` periods of the motion."""

    kind: Literal["none", "brake", "torque_motor", "inertia_plate"] = "none"
    levels_Nm: Annotated[tuple[Torque, ...], Field(min_length=1, max_length=50, strict=False)] = (0.0,)
    periods_per_level: Annotated[float, Field(gt=0.0, le=1000.0)] = 1.0
    # Torque motor: steady, or a sine or square of its own period.
    wave: Literal["steady", "sine", "square"] = "steady"
    wave_period_s: Annotated[float, Field(gt=0.0, le=1e4)] = 10.0
    bias_Nm: Torque = 0.0
    # Brake: drum angle over which its torque changes sign.
    flank_mrad: Annotated[float, Field(gt=0.0, le=50.0)] = 0.5
    # Inertia plate.
    inertia_kg_m2: Inertia = 0.0
    unbalance_Nm: Moment = 0.0
    unbalance_angle_deg: Annotated[float, Field(ge=-360.0, le=360.0)] = 0.0

    def torque_Nm(self, time_s: Floats, drum_rad: Floats, period_s: float, stick_slip: Floats | None = None) -> Floats:
        """Torque on the drum, (n,). ``stick_slip`` (n, 2): static share and stiffness of a brake that sticks."""
        which = (time_s / (self.periods_per_level * period_s)).astype(np.int64) % len(self.levels_Nm)
        level = np.asarray(self.levels_Nm)[which]
        if self.kind == "brake":
            if stick_slip is not None:
                return stuck_brake(drum_rad, level, stick_slip) + self.bias_Nm
            return brake(drum_rad, level, self.flank_mrad * 1e-3) + self.bias_Nm
        if self.kind == "torque_motor":
            phase = 2.0 * pi * time_s / self.wave_period_s
            # The flanks of the square wave take a few percent of its period, as those of a torque motor.
            sine = np.sin(phase)
            wave = {"steady": np.ones_like(phase), "sine": sine, "square": np.tanh(20.0 * sine)}[self.wave]
            return np.asarray(level * wave + self.bias_Nm)
        if self.kind == "inertia_plate":
            step = time_s[1] - time_s[0]
            acceleration = np.gradient(np.gradient(drum_rad, step), step)
            weight = self.unbalance_Nm * np.sin(drum_rad + self.unbalance_angle_deg * pi / 180.0)
            return np.asarray(self.inertia_kg_m2 * acceleration + weight + self.bias_Nm)
        return np.full(time_s.size, self.bias_Nm)


@compiled
def brake(drum_rad: Floats, level: Floats, flank_rad: float) -> Floats:
    """Torque of a brake with these levels, N m: an elastic flank, then slip."""
    torque = np.zeros(drum_rad.size)
    for k in range(1, drum_rad.size):
        now = torque[k - 1] + 2.0 * level[k] / flank_rad * (drum_rad[k] - drum_rad[k - 1])
        torque[k] = min(max(now, -abs(level[k])), abs(level[k]))
    return torque


@compiled
def stuck_brake(drum_rad: Floats, level: Floats, character: Floats) -> Floats:
    """As :func:`brake`, but the brake sticks up to a static share of its level; then the torque drops below the level.

    ``character`` (n, 2): static share (> 1, may scatter from sample to sample) and stiffness in N m/rad. The torque
    drops as far below the kinetic level as it was above it, because a mass that slips freely overshoots by as much.
    """
    torque = np.zeros(drum_rad.size)
    for k in range(1, drum_rad.size):
        now = torque[k - 1] + character[k, 1] * (drum_rad[k] - drum_rad[k - 1])
        hold = character[k, 0] * abs(level[k])
        if abs(now) > hold:
            now = math_sign(now) * (2.0 * abs(level[k]) - hold)
        torque[k] = now
    return torque


@compiled
def math_sign(value: float) -> float:
    """Sign of a number, 1 for zero."""
    return -1.0 if value < 0.0 else 1.0
