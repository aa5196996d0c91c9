"""What is simulated: drive, inputs, load, paths of the cables, what adds to the reading; and the simulation itself."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mbcdm_cad.loop.prepared import COMMON_WINDOW_S, Prepared, smoothed
from mbcdm_cad.loop.run import Floats
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.model.profiles import simulate_profiles
from mbcdm_cad.model.si import DriveSI

# Simulations remembered: as many as one Jacobian needs, so that what only adds to the reading costs nothing.
REMEMBERED = 24


@dataclass(frozen=True, eq=False)
class Setup:
    """One run as it is to be predicted: everything that an effect may change.

    ``d`` is None for a drive of which only the ratio is known; ``load_Nm`` None without a torque column.
    ``path_m`` (n_cables, n) lengthens the cables' paths; ``shift_rad`` (n_inputs, n) is how far each input pulley
    stands from where its encoder says; ``added_rad`` (n,) adds to the reading; ``winding`` is how much of the winding
    history is at work, 0 to 1.
    """

    d: DriveSI | None
    ratio: float
    p: Prepared
    angle_rad: Floats
    load_Nm: Floats | None
    path_m: Floats | None
    shift_rad: Floats | None
    added_rad: Floats
    winding: float = 0.0

    @property
    def drive(self) -> DriveSI:
        """The drive, where there is one."""
        assert self.d is not None, "an effect of the cables was offered where only the ratio is known"
        return self.d

    @property
    def load(self) -> Floats:
        """The load, where it was measured."""
        assert self.load_Nm is not None, "an effect of the load was offered for a run without torque"
        return self.load_Nm

    def with_path(self, path_m: Floats) -> Setup:
        """Lengthen the paths of the cables."""
        return replace(self, path_m=path_m if self.path_m is None else self.path_m + path_m)

    def with_shift(self, index: int, shift_rad: Floats) -> Setup:
        """Move one input pulley from where its encoder says."""
        shift = np.zeros_like(self.angle_rad) if self.shift_rad is None else self.shift_rad.copy()
        shift[index] += shift_rad
        return replace(self, shift_rad=shift)

    def with_added(self, added_rad: Floats) -> Setup:
        """Add to the reading."""
        return replace(self, added_rad=self.added_rad + added_rad)

    def input_shaft_rad(self, index: int) -> Floats:
        """Angle of one input pulley, freed of the encoder's steps."""
        return smoothed(self.angle_rad[index], COMMON_WINDOW_S, self.p.step_s)

    @property
    def drum_rad(self) -> Floats:
        """Drum angle as the ratio alone has it."""
        return smoothed(self.angle_rad.mean(axis=0), COMMON_WINDOW_S, self.p.step_s) / self.ratio


def declared(d: DriveSI | None, ratio: float, p: Prepared) -> Setup:
    """The declared model of a run."""
    return Setup(d, ratio, p, p.angle_rad, p.load_Nm, None, None, np.zeros_like(p.time_s))


def input_shares(d: DriveSI) -> Floats:
    """Share of each input in the stiffness at the drum, cables sticking; shape (n_inputs,)."""
    stiffness = d.drum_radius_m**2 / d.free_span_m
    return np.asarray([(stiffness * d.of_input(i)).sum() for i in range(d.n_inputs)] / stiffness.sum())


def rigid_drum_rad(s: Setup) -> Floats:
    """Drum angle with the elastic part off: the cables as springs that balance no load."""
    angle = s.angle_rad if s.shift_rad is None else s.angle_rad + s.shift_rad
    if s.d is None:
        return np.asarray(angle.mean(axis=0) / s.ratio)
    d = s.d
    wound = (d.sigma * d.input_radius_m)[:, None] * angle[list(d.input_of)]
    if s.path_m is not None:
        wound = wound + s.path_m
    weight = d.drum_radius_m / d.free_span_m
    return np.asarray(((weight * d.sigma)[:, None] * wound).sum(axis=0) / (weight * d.drum_radius_m).sum())


@dataclass(frozen=True, eq=False)
class Response:
    """Drum angle and what each input carries, on all samples: rad (n,), N m (n_inputs, n)."""

    drum_rad: Floats
    input_torque_Nm: Floats


def respond(s: Setup, winding: bool = False) -> Response:
    """The cables' answer to the quiet inputs, the inputs' noise added back linearly.

    The cables are simulated on every few samples and the elastic part, which changes slowly, is interpolated: the
    common motion of the inputs carries the drum along on every sample.
    """
    d, p = s.drive, s.p
    mean = s.angle_rad.mean(axis=0)
    apart = s.angle_rad - mean
    slow = smoothed(apart, p.difference_window_s, p.step_s)
    quiet = smoothed(mean, COMMON_WINDOW_S, p.step_s)
    at = p.coarse
    angle = (quiet + slow)[:, at]
    if s.shift_rad is not None:
        angle = angle + s.shift_rad[:, at]
    path = None if s.path_m is None else s.path_m[:, at]
    if winding:
        found = simulate_profiles(d, angle, s.load[at], path, winding=True)
    else:
        found = simulate(d, angle, s.load[at], path)
    everywhere = np.arange(mean.size)
    elastic = np.interp(everywhere, at, found.drum_angle_rad - quiet[at] / s.ratio)
    noise = (input_shares(d)[:, None] * (apart - slow)).sum(axis=0)
    torque = np.stack([np.interp(everywhere, at, row) for row in found.input_torque_Nm(d)])
    return Response((mean + noise) / s.ratio + elastic, torque)


class Simulator:
    """Predicts setups and remembers the last simulations."""

    def __init__(self) -> None:
        self._known: list[tuple[Setup, bool, Floats]] = []

    def __call__(self, s: Setup) -> Floats:
        """Reading of the output encoder, rad, shape (n,)."""
        drum = self._drum(s, False)
        if s.winding != 0.0:
            drum = drum + s.winding * (self._drum(s, True) - drum)
        return drum + s.added_rad

    def _drum(self, s: Setup, winding: bool) -> Floats:
        for known, flag, drum in self._known:
            same = known.d is s.d and known.angle_rad is s.angle_rad and known.load_Nm is s.load_Nm
            if same and known.path_m is s.path_m and known.shift_rad is s.shift_rad and flag == winding:
                return drum
        rigid = s.d is None or s.load_Nm is None
        drum = rigid_drum_rad(s) if rigid else respond(s, winding).drum_rad
        self._known.append((s, winding, drum))
        del self._known[:-REMEMBERED]
        return drum
