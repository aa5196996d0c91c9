"""The preloads of one input's cables from a ramp of its torque while the drum is held.

With the drum held, an input turned by an angle x stretches each of its cables by sigma r x. Its torque then follows
from the law of the cables, which bends where a cable goes slack:

    M(x) = sum_j sigma_j r_j T_j(sigma_j r_j x)

On the way out the rope that bends on the input, and the input's bearings, add their friction F in the direction of
motion; seen from the motor, at its torque times the gearhead's ratio, the gearhead and the motor add theirs:

    shaft: M + F + c        motor: (1 + g) (M + F) + c

with c what does not depend on the load. The two preloads are fitted to measured angles and torques together with the
rope's stiffness, the friction of its wraps, F, c and g, which are known to a standard deviation only (maximum of the
posterior density, linear sigmas). Where the log has the way back too, the mean of both ways at the turn is free of all
friction but g F, and sets the scale.
"""

from dataclasses import dataclass, replace

import numpy as np

from mbcdm_cad.model.equilibrium import tension_of_stretch
from mbcdm_cad.model.losses import FIBRE_SIGMA, GEARHEAD_IDLE_SIGMA, GEARHEAD_SIGMA, ROPE_SIGMA, Train
from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.model.wrap import stretch_first_loading
from mbcdm_cad.routes import Floats

# What the design does not know of stiffness and friction: standard deviations of their logarithms (estimates).
SIGMA_STIFFNESS, SIGMA_FRICTION = 0.1, 0.2
# Friction at the shaft that does not follow the tensions, such as that of a seal: none is expected; its standard
# deviation over the friction of rope and bearings at the preload (estimate).
SIGMA_CONSTANT = 0.5
# Samples nearer to angle 0 than this share of the whole ramp do not count: friction turns round there. The way back
# counts between these shares of the turn's angle.
START_SHARE, BACK_SHARES = 0.03, (0.75, 0.97)
# A cable with a smaller share of its preload counts as slack.
SLACK_SHARE = 0.05
# The ramp goes on beyond the knee by this share of the angle.
BEYOND = 1.3
# What the mean of both ways at the turn is known to, from a curve through each.
_MEAN_SHARE = 0.01
_POINTS, _STEP, _ROUNDS = 61, 1e-4, 40


@dataclass(frozen=True, eq=False)
class HeldDrive:
    """A drive whose drum is held at a stop, and the wraps (input, drum) of its cables there, each (n_cables,).

    ``falling_rad``: at the stop towards which the drum turns with falling angles, ``rising_rad``: at the other.
    ``train``: its friction; None counts none. ``at_motor``: torques are the motor's times the gearhead's ratio, else
    those on the input's shaft. ``factors``: on the friction F of rope and bearings; standard deviations by which c
    differs from the expected one; on the gearhead's loss g.
    """

    d: DriveSI
    falling_rad: tuple[Floats, Floats]
    rising_rad: tuple[Floats, Floats]
    train: Train | None = None
    at_motor: bool = False
    factors: tuple[float, float, float] = (1.0, 0.0, 1.0)

    def tensions_N(self, index: int, angle_rad: Floats) -> Floats:
        """Tensions (n_cables, n) with the input ``index`` turned by the angles (n,)."""
        angle = np.asarray(angle_rad, float)
        wraps = [
            np.where(angle >= 0.0, rising[:, None], falling[:, None])
            for falling, rising in zip(self.falling_rad, self.rising_rad, strict=True)
        ]
        wide = self.d.spread(angle.size).with_(input_wrap_rad=wraps[0], drum_wrap_rad=wraps[1])
        return tension_of_stretch(wide, np.multiply.outer(self.lever_m(index), angle))

    def lever_m(self, index: int) -> Floats:
        """Lever of each cable at an input, with its sense; 0 for the cables of others."""
        return np.asarray(self.d.of_input(index) * self.d.sigma * self.d.input_radius_m)

    def torque_Nm(self, index: int, angle_rad: Floats) -> Floats:
        """Torque (n,) that turns the input ``index`` to the angles (n,), on the way out from 0."""
        return self.torque_of_Nm(index, angle_rad, self.tensions_N(index, angle_rad))

    def torque_of_Nm(self, index: int, angle_rad: Floats, tension_N: Floats) -> Floats:
        """As :meth:`torque_Nm`, of known tensions (n_cables, n)."""
        found, way = self._pulled_Nm(index, tension_N), _sense(angle_rad)
        if self.train is None:
            return found
        _, differs, more = self.factors
        constant, sigma = self._constant_Nm(index, self.train)
        found = found + way * self._rubs_Nm(index, tension_N)
        if self.at_motor:
            found = found + way * more * self.train.gear_share * np.abs(found)
        return np.asarray(found + way * (constant + differs * sigma))

    def mean_of_Nm(self, index: int, angle_rad: Floats, tension_N: Floats) -> Floats:
        """Mean of the torques on the way out and back (n,) where the ramp turns round at the angles (n,)."""
        found = self._pulled_Nm(index, tension_N)
        if self.train is None or not self.at_motor:
            return found
        rubs = self._rubs_Nm(index, tension_N)
        return np.asarray(found + _sense(angle_rad) * self.factors[2] * self.train.gear_share * rubs)

    def _pulled_Nm(self, index: int, tension_N: Floats) -> Floats:
        """Torque of the cables on the input, without friction."""
        return np.asarray((self.lever_m(index)[:, None] * tension_N).sum(axis=0))

    def _rubs_Nm(self, index: int, tension_N: Floats) -> Floats:
        """Friction F (n,) of rope and bearings at the input, whichever way it turns."""
        if self.train is None:
            return np.zeros(tension_N.shape[1])
        size = np.abs(self.lever_m(index))[:, None] * tension_N
        found = sum((np.reshape(bend.share, (-1, 1)) * size).sum(axis=0) for bend in self.train.rope if bend.on_input)
        found = found + sum(b.torque_Nm(tension_N) for b in self.train.bearings if b.input_index == index)
        return np.asarray(self.factors[0] * found)

    def _constant_Nm(self, index: int, train: Train) -> tuple[float, float]:
        """Friction that does not follow the tensions, expected and its standard deviation."""
        if self.at_motor:
            idle = float(train.gear_idle_Nm + train.gear_ratio * train.motor_idle_Nm)
            return idle, GEARHEAD_IDLE_SIGMA * idle
        own = replace(self, factors=(1.0, 0.0, 1.0))
        return 0.0, SIGMA_CONSTANT * float(own._rubs_Nm(index, self.d.preload_N[:, None])[0])


def _sense(angle_rad: Floats) -> Floats:
    """Sense of the way out at the angles."""
    return np.where(np.asarray(angle_rad, float) >= 0.0, 1.0, -1.0)


@dataclass(frozen=True)
class SampleNoise:
    """Standard deviations of one sample of a ramp."""

    angle_rad: float
    torque_Nm: float


@dataclass(frozen=True, eq=False)
class Ramp:
    """Expected ramps of one input: with the angle rising from 0, at one stop of the drum, and falling, at the other.

    ``angle_rad`` and ``torque_Nm`` (n,), sorted by the angle; ``sigma_Nm`` (n,): of the torque, by what is not known
    of stiffness and friction. ``knee_rad`` and ``knee_Nm``: where a cable goes slack, falling and rising.
    ``sigma_N`` (n_own,): of each preload that the ramps will give.
    """

    input_name: str
    cables: tuple[int, ...]
    angle_rad: Floats
    torque_Nm: Floats
    sigma_Nm: Floats
    knee_rad: tuple[float, float]
    knee_Nm: tuple[float, float]
    slack_first: tuple[str, str]
    sigma_N: Floats


@dataclass(frozen=True, eq=False)
class MeasuredPreloads:
    """Preloads of an input's cables found from its ramps, N, their sigmas; stiffness and friction over the design's.

    ``friction``: of the wraps; ``rubbing``: of rope and bearings at the input; ``gearhead``: its loss with the load.
    """

    cables: tuple[int, ...]
    preload_N: Floats
    sigma_N: Floats
    stiffness: float
    friction: float
    rubbing: float
    gearhead: float


def expected(held: HeldDrive, index: int, noise: SampleNoise, samples: int = 200) -> Ramp:
    """The ramps of an input on the drive as designed, ``samples`` each way. ``ModelError`` if no cable goes slack."""
    d = held.d
    own = tuple(j for j, i in enumerate(d.input_of) if i == index)
    ends, slack = [], []
    for sense in (-1.0, 1.0):
        knee, name = _knee(held, index, own, sense)
        ends.append(sense * knee)
        slack.append(name)
    angle = np.concatenate(
        [np.linspace(BEYOND * ends[0], 0.0, _POINTS)[:-1], np.linspace(0.0, BEYOND * ends[1], _POINTS)]
    )
    found = held.torque_Nm(index, angle)
    columns = _slopes(held, index, own, angle)
    sigmas = _sigmas(held)
    spread = np.sqrt(np.square(columns[len(own) :] * sigmas[:, None]).sum(axis=0))
    scale = samples / _POINTS
    known = np.concatenate([np.zeros(len(columns) - sigmas.size), sigmas**-2])
    normal = (columns * (_weight(held, index, angle, noise) * scale)) @ columns.T + np.diag(known)
    sigma = np.sqrt(np.diag(np.linalg.inv(normal)))[: len(own)]
    knees = held.torque_Nm(index, np.array(ends))
    return Ramp(
        d.input_names[index],
        own,
        angle,
        found,
        spread,
        (ends[0], ends[1]),
        (float(knees[0]), float(knees[1])),
        (slack[0], slack[1]),
        sigma * d.preload_N[list(own)],
    )


def knees_Nm(held: HeldDrive, index: int) -> tuple[float, float]:
    """Torques at which a cable goes slack, falling and rising. ``ModelError`` if none does."""
    own = tuple(j for j, i in enumerate(held.d.input_of) if i == index)
    ends = np.array([sense * _knee(held, index, own, sense)[0] for sense in (-1.0, 1.0)])
    falling, rising = held.torque_Nm(index, ends)
    return float(falling), float(rising)


def fitted(held: HeldDrive, index: int, angle_rad: Floats, measured_Nm: Floats, noise: SampleNoise) -> MeasuredPreloads:
    """Preloads from ramps both ways, samples in the order of time, with or without the way back.

    Raises ``ModelError`` for fewer than 8 samples on the way out, and where a preload does not follow from them: the
    fit does not end, or its standard deviation is as large as the preload.
    """
    angle, torque = np.asarray(angle_rad, float), np.asarray(measured_Nm, float)
    if angle.size < 8 or angle.size != torque.size:
        raise ModelError(f"a ramp of {angle.size} angles and {torque.size} torques; give at least 8 samples of both")
    out, turns, means = _ways(angle, torque)
    angle, torque = angle[out], torque[out]
    if angle.size < 8:
        raise ModelError(f"a ramp of {angle.size} samples on the way out; give at least 8")
    own = [j for j, i in enumerate(held.d.input_of) if i == index]
    sigmas = _sigmas(held)
    x, known = np.zeros(len(own) + sigmas.size), np.concatenate([np.zeros(len(own)), sigmas**-2])
    size = float("inf")
    for _ in range(_ROUNDS):
        now = _changed(held, own, x)
        weight = _weight(now, index, angle, noise)
        columns = _slopes(now, index, tuple(own), angle)
        hessian = (columns * weight) @ columns.T + np.diag(known)
        pull = (columns * weight) @ (torque - now.torque_Nm(index, angle)) - known * x
        if turns.size:
            at_turns = _slopes(now, index, tuple(own), turns, mean=True)
            # As well as the line through the way back is known: some samples of it.
            sure = 1.0 / (noise.torque_Nm**2 + (_MEAN_SHARE * means) ** 2)
            hessian = hessian + (at_turns * sure) @ at_turns.T
            pull = pull + (at_turns * sure) @ (means - now.mean_of_Nm(index, turns, now.tensions_N(index, turns)))
        try:
            step = np.linalg.solve(hessian, pull)
        except np.linalg.LinAlgError:
            break
        size = float(np.abs(step).max())
        x = x + np.clip(step, -0.5, 0.5)
        if size < 1e-6:
            break
    # Of the logarithms of the preloads.
    spread = np.sqrt(np.diag(np.linalg.inv(hessian))[: len(own)]) if size < 1e-3 else np.full(len(own), np.inf)
    if not spread.max() < 1.0:
        raise ModelError(
            f"the preloads of input {held.d.input_names[index]} do not follow from this ramp (standard deviation "
            f"{spread.max():.2g} of the preload, limit 1): turn it beyond the knee at both stops; see docs/preload.md"
        )
    preload = held.d.preload_N[own] * np.exp(x[: len(own)])
    stiffness, wraps, rubbing, _, gearhead = x[len(own) :]
    return MeasuredPreloads(
        tuple(own),
        preload,
        preload * spread,
        float(np.exp(stiffness)),
        float(np.exp(wraps)),
        float(np.exp(rubbing)),
        float(np.exp(gearhead)),
    )


def _ways(angle: Floats, torque: Floats) -> tuple[np.ndarray, Floats, Floats]:
    """Which samples are on the way out, the angles at which the ramps turn round, and the mean of both ways there.

    Samples that are sorted by their angle have no way back.
    """
    out = np.zeros(angle.size, dtype=bool)
    turns, means = [], []
    largest = float(np.abs(angle).max())
    for sign in (-1.0, 1.0):
        own = np.flatnonzero(angle * sign > START_SHARE * largest)
        if not own.size:
            continue
        last = int(np.argmax(angle[own] * sign))
        if last == 0 and own.size > 1:
            out[own] = True
            continue
        out[own[: last + 1]] = True
        end, low, high = angle[own[last]], *(share * abs(angle[own[last]]) for share in BACK_SHARES)
        ends = []
        for part in (own[: last + 1], own[last + 1 :]):
            near = part[(angle[part] * sign >= low) & (angle[part] * sign <= high)]
            if near.size >= 4:
                ends.append(float(np.polyval(np.polyfit(angle[near] - end, torque[near], 2), 0.0)))
        if len(ends) == 2:
            turns.append(float(end))
            means.append(0.5 * sum(ends))
    return out, np.array(turns), np.array(means)


def _sigmas(held: HeldDrive) -> Floats:
    """Standard deviations of what is not known besides the preloads: stiffness, wraps, F, c, g."""
    rope = FIBRE_SIGMA if held.train is not None and held.train.fibre else ROPE_SIGMA
    return np.array([SIGMA_STIFFNESS, SIGMA_FRICTION, rope, 1.0, GEARHEAD_SIGMA])


def _changed(held: HeldDrive, own: list[int], x: Floats) -> HeldDrive:
    """The drive with logarithms of preloads, stiffness and friction changed."""
    d = held.d
    preload = d.preload_N.copy()
    preload[own] *= np.exp(x[: len(own)])
    stiffness, wraps, rubbing, constant, gearhead = x[len(own) :]
    changed = d.with_(
        preload_N=preload,
        modulus_Pa=d.modulus_Pa * np.exp(stiffness),
        friction_coefficient=d.friction_coefficient * np.exp(wraps),
    )
    return replace(held, d=changed, factors=(float(np.exp(rubbing)), float(constant), float(np.exp(gearhead))))


def _slopes(held: HeldDrive, index: int, own: tuple[int, ...], angle: Floats, mean: bool = False) -> Floats:
    """Change of the torque for each parameter of the fit, (n_own + 5, n); ``mean``: of that of both ways."""
    rubbing, constant, gearhead = held.factors
    at = np.array([*np.zeros(len(own) + 2), np.log(rubbing), constant, np.log(gearhead)])
    rows, here = [], held.tensions_N(index, angle)
    for k in range(at.size):
        sides = []
        for sign in (1.0, -1.0):
            step = at.copy()
            step[k] += sign * _STEP
            moved = _changed(held, list(own), step)
            # Friction leaves the tensions as they are.
            tension = here if k >= len(own) + 2 else moved.tensions_N(index, angle)
            of = moved.mean_of_Nm if mean else moved.torque_of_Nm
            sides.append(of(index, angle, tension))
        rows.append((sides[0] - sides[1]) / (2.0 * _STEP))
    return np.array(rows)


def _weight(held: HeldDrive, index: int, angle: Floats, noise: SampleNoise) -> Floats:
    """Inverse variance of each sample's torque, the noise of its angle included."""
    step = 1e-3 * float(np.abs(angle).max())
    # Without the jump of the friction at angle 0.
    high, low = (replace(held, train=None).torque_Nm(index, angle + sign * step) for sign in (1.0, -1.0))
    slope = (high - low) / (2.0 * step)
    return np.asarray(1.0 / (noise.torque_Nm**2 + (slope * noise.angle_rad) ** 2))


def _knee(held: HeldDrive, index: int, own: tuple[int, ...], sense: float) -> tuple[float, str]:
    """Angle at which the first cable of an input goes slack, and the cable's name."""
    d = held.d
    of_input, of_drum = held.rising_rad if sense > 0.0 else held.falling_rad
    gone_m, _ = stretch_first_loading(
        d.with_(input_wrap_rad=of_input, drum_wrap_rad=of_drum), SLACK_SHARE * d.preload_N
    )
    lever = sense * held.lever_m(index)
    slackened = [(float(gone_m[j] / lever[j]), d.cable_names[j]) for j in own if lever[j] < 0.0]
    if not slackened:
        raise ModelError(f"no cable of input {d.input_names[index]} goes slack, however far it is turned")
    return min(slackened)
