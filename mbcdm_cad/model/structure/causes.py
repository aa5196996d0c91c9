"""Turn of the payload by cause, and of the shafts among them: bending, torsion, radial give of bearings.

The right half is a curved beam from the lowest point, where by antisymmetry only a shear force passes, up into the
block. Units: mm, N, MPa.

Everything is energy: under the loads that 1 N m on the drum causes, twice the strain energy of a part is the turn of
the drum that this part causes (Castigliano; unit loads). Units: mm, N, MPa; loads are those for 1 N m; results in urad
per N m.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import floor, hypot, log, pi, radians, sin
from typing import Any

import numpy as np

from mbcdm_cad.model.stiffness import Chain
from mbcdm_cad.model.structure.drum_sector import Isotropic
from mbcdm_cad.routes import Floats

# One standard deviation, as a factor: of drums and shafts, compared with closed forms and solid elements, with the
# tolerances of walls and moduli; of the frame, with its mount; of bearings, whose balls have a usual size; of
# gearheads; of springs in the terminals, which friction on the drum shields.
BY_PARTS, BY_FRAME, BY_BEARINGS, BY_GEARHEADS, BY_SPRINGS = 1.1, 1.15, 1.3, 2.0, 1.3


@dataclass(frozen=True)
class Cause:
    """Turn of the payload per N m by one part's strain.

    ``at_encoder``: whether the drum's encoder sees it too. ``before_input``: whether it lies between the motor and the
    input pulley's encoder. ``in_drum``: whether it lies between the drum's land and the payload. ``factor``: one
    standard deviation of its logarithm, as a factor. ``after_slip``: whether it gives only where slip of the cables has
    reached it, so that it is rigid for small motion; the rig's cables have it themselves. ``stiffer``: fields that make
    it give less.
    """

    name: str
    urad_Nm: float
    at_encoder: bool = True
    before_input: bool = False
    in_drum: bool = False
    factor: float = BY_PARTS
    after_slip: bool = False
    stiffer: str = "its bearings"


@dataclass(frozen=True)
class Structure:
    """Compliance of a drive by cause, and the stress of its drum.

    ``cables_urad_Nm``: turn by the cables at the test torque, over that torque. ``stress_MPa`` gives the largest
    equivalent stress of the drum's web and rim under a torque of either sense, N m, with the preload; ``yield_MPa``:
    the yield stress of its material. ``motor_encoders``: whether only the motors' own encoders hold the inputs, so that
    the gearheads give then too.
    """

    causes: tuple[Cause, ...]
    cables_urad_Nm: float
    stress_MPa: Callable[[float], float] = field(repr=False, compare=False)
    peak_torque_Nm: float
    yield_MPa: float
    motor_encoders: bool = False

    @property
    def peak_stress_MPa(self) -> float:
        """Largest stress of the drum's web and rim at the peak torque."""
        return self.stress_MPa(self.peak_torque_Nm)

    @property
    def at_payload(self) -> tuple[Cause, ...]:
        """Causes that the payload sees, the inputs held by their encoders."""
        return tuple(c for c in self.causes if self.motor_encoders or not c.before_input)

    @property
    def at_encoder(self) -> tuple[Cause, ...]:
        """As :attr:`at_payload`, those that the drum's encoder sees."""
        return tuple(c for c in self.at_payload if c.at_encoder)

    @property
    def payload_urad_Nm(self) -> float:
        """Turn of the payload besides that of the cables, the inputs held by their encoders."""
        return urad_Nm(self.at_payload)

    @property
    def encoder_urad_Nm(self) -> float:
        """As :attr:`payload_urad_Nm`, as the drum's encoder sees it."""
        return urad_Nm(self.at_encoder)

    @property
    def motor_urad_Nm(self) -> float:
        """As :attr:`payload_urad_Nm`, the motors' shafts held in place of the inputs."""
        return urad_Nm(self.causes)

    @property
    def over_cables(self) -> float:
        """Turn of the structure over that of the cables, as the payload sees it."""
        return self.payload_urad_Nm / self.cables_urad_Nm

    @property
    def stiffness_Nm_rad(self) -> float:
        """Test torque over the payload's turn by cables and structure, the inputs held by their encoders."""
        return 1e6 / (self.cables_urad_Nm + self.payload_urad_Nm)

    @property
    def chain(self) -> Chain:
        """Where the structure gives, for the torsional modes."""
        before = urad_Nm(c for c in self.causes if c.before_input)
        in_drum = urad_Nm(c for c in self.causes if c.in_drum)
        return Chain(before * 1e-6, (urad_Nm(sticking(self.causes)) - before - in_drum) * 1e-6, in_drum * 1e-6)

    def to_dict(self) -> dict[str, Any]:
        """Everything, ready for JSON."""
        return {
            "causes": [
                {
                    "name": c.name,
                    "urad_Nm": c.urad_Nm,
                    "factor": c.factor,
                    "seen_by_drum_encoder": c.at_encoder,
                    "between_motor_and_input_encoder": c not in self.at_payload,
                }
                for c in self.causes
            ],
            "cables_urad_Nm": self.cables_urad_Nm,
            "structure_at_payload_urad_Nm": self.payload_urad_Nm,
            "structure_at_drum_encoder_urad_Nm": self.encoder_urad_Nm,
            "structure_motors_held_urad_Nm": self.motor_urad_Nm,
            "structure_over_cables": self.over_cables,
            "stiffness_at_payload_Nm_rad": self.stiffness_Nm_rad,
            "drum_peak_stress_MPa": self.peak_stress_MPa,
            "drum_yield_MPa": self.yield_MPa,
        }


def urad_Nm(causes: Iterable[Cause]) -> float:
    """Turn by several causes."""
    return sum(c.urad_Nm for c in causes)


def sticking(causes: Iterable[Cause]) -> tuple[Cause, ...]:
    """Those that give for small motion too, every wrap sticking."""
    return tuple(c for c in causes if not c.after_slip)


def sigma_urad_Nm(causes: Iterable[Cause]) -> float:
    """Standard deviation of the turn by several causes: those with one factor are wrong together."""
    by_factor: dict[float, float] = {}
    for c in causes:
        by_factor[c.factor] = by_factor.get(c.factor, 0.0) + c.urad_Nm * log(c.factor)
    return hypot(*by_factor.values())


_SHEAR_FACTOR = 5.0 / 6.0


@dataclass(frozen=True)
class BossRing:
    """A boss: radius of its bore, its own radius, the height over its axis up to which the block is solid, its ends."""

    inner_mm: float
    outer_mm: float
    block_mm: float
    from_mm: float
    to_mm: float

    def slice_mm_N(self, material: Isotropic) -> float:
        """Lateral compliance for 1 N per mm of depth along the axis, for a pressure p cos(phi) of the seat.

        The depth of the beam grows from the round wall to the block's corner.
        """
        phi = np.linspace(-pi / 2, pi / 3, 121)
        outer = np.full_like(phi, self.outer_mm)
        up = phi > 0.0
        outer[up] = np.minimum(self.outer_mm / np.cos(phi[up]), self.block_mm / np.sin(phi[up]))
        wall = outer - self.inner_mm
        radius = (self.inner_mm + self.outer_mm) / 2
        step = np.diff(phi)

        def running(values: Floats) -> Floats:
            return np.concatenate([[0.0], np.cumsum((values[1:] + values[:-1]) / 2 * step)])

        # Pressure of unit resultant over both halves.
        push = np.cos(phi) / pi
        force_x, force_z = running(push * np.cos(phi)), running(push * np.sin(phi))
        moment = radius * (np.sin(phi) * force_x - np.cos(phi) * force_z)
        # Columns: from the pressure, from a unit shear force at the lowest point.
        bend = np.stack([moment, radius * np.cos(phi)])
        along = np.stack([-np.sin(phi) * force_x + np.cos(phi) * force_z, np.cos(phi)])
        across = np.stack([np.cos(phi) * force_x + np.sin(phi) * force_z, np.sin(phi)])

        def work(a: int, b: int) -> float:
            density = bend[a] * bend[b] * 12.0 / (material.modulus_MPa * wall**3)
            density += along[a] * along[b] / (material.modulus_MPa * wall)
            density += across[a] * across[b] / (_SHEAR_FACTOR * material.shear_MPa * wall)
            return float(radius * running(density)[-1])

        # The shear force does no work, since the lowest point does not leave the mirror plane.
        return 2.0 * (work(0, 0) - work(0, 1) ** 2 / work(1, 1))

    def work_Nmm(self, at_mm: Floats, force_N: Floats, material: Isotropic) -> float:
        """f . u of lateral forces (n,) of bearings at places (n,) along the axis: the ring moves sideways and shears.

        Slices of the ring cannot bend independently: the lower arc connects them and must shear if they move unequally.
        """
        length, middle = self.to_mm - self.from_mm, (self.to_mm + self.from_mm) / 2
        slice_mm_N = self.slice_mm_N(material)
        arc_N = material.shear_MPa * (self.outer_mm**2 - self.inner_mm**2) / 2 * pi / 2
        shift = slice_mm_N / length * force_N.sum() ** 2
        tilt = float(force_N @ (at_mm - middle)) ** 2
        return float(shift + tilt / (length**3 / (12.0 * slice_mm_N) + arc_N * length))


# Twice the energy in N mm under the loads of 1 N m -> urad per N m.
URAD_NM = 1e3
# Points per shaft at which its moment is summed.
_POINTS = 400
# Length by which a thin shaft twists inside a much thicker one, or under a collar that holds its outside, over its
# diameter; and how that falls where the two are more alike: d (1 - (d / D)^2.6). An estimate after the usual curves for
# crankshafts, chosen on solid elements of six pulleys.
JUNCTION, JUNCTION_POWER = 0.125, 2.6
# Balls over the bearing's section, and their pitch over their diameter (usual in small deep-groove bearings).
_BALL_SHARE, _BALL_PITCH = 0.55, 1.45
# Contact angle of a deep-groove bearing of normal play under a light axial load (bearing makers: 10 to 15 degrees).
_CONTACT_DEG = 12.0
_LEAST_BALL_N = 0.5


@dataclass(frozen=True)
class Section:
    """A length of a round shaft along its axis, with its outer and bore radii."""

    start_mm: float
    end_mm: float
    radius_mm: float
    bore_mm: float = 0.0

    @property
    def second_moment_mm4(self) -> float:
        """Second moment of area about a diameter; half the polar one. ``ValueError`` without a wall."""
        found = pi / 4.0 * (self.radius_mm**4 - self.bore_mm**4)
        if found <= 0.0:
            raise ValueError(f"a shaft of radius {self.radius_mm:.4g} mm has a bore of radius {self.bore_mm:.4g} mm")
        return found

    def shear_area_mm2(self, poisson: float) -> float:
        """Area that carries a force across the shaft evenly (Cowper 1966, hollow circle)."""
        m2 = (self.bore_mm / self.radius_mm) ** 2
        even = 6.0 * (1.0 + poisson) * (1.0 + m2) ** 2
        even /= (7.0 + 6.0 * poisson) * (1.0 + m2) ** 2 + (20.0 + 12.0 * poisson) * m2
        return even * pi * (self.radius_mm**2 - self.bore_mm**2)


@dataclass(frozen=True, eq=False)
class Acting:
    """Force (3,) in N and couple (3,) in N mm on a shaft at a place along its axis."""

    at_mm: float
    force_N: Floats
    couple_Nmm: Floats


def bending_urad_Nm(axis: Floats, acting: Sequence[Acting], sections: Sequence[Section], material: Isotropic) -> float:
    """Turn by the bending and shear of a shaft under loads in equilibrium, its reactions among them.

    Where no section lies the shaft counts as rigid. ``axis``: unit vector along which places count.
    """
    low, high = min(a.at_mm for a in acting), max(a.at_mm for a in acting)
    step = (high - low) / _POINTS
    place = low + step * (np.arange(_POINTS) + 0.5)
    moment, force = np.zeros((_POINTS, 3)), np.zeros((_POINTS, 3))
    for a in acting:
        beyond = place > a.at_mm
        arm = np.cross(axis, a.force_N)
        moment[beyond] += (a.at_mm - place[beyond])[:, None] * arm + a.couple_Nmm
        force[beyond] += a.force_N
    bent, sheared = ((f - (f @ axis)[:, None] * axis) ** 2 for f in (moment, force))
    second, area = np.full(_POINTS, np.inf), np.full(_POINTS, np.inf)
    for s in sections:
        inside = (place >= s.start_mm) & (place <= s.end_mm)
        second[inside] = s.second_moment_mm4
        area[inside] = s.shear_area_mm2(material.poisson)
    give = bent.sum(axis=1) / (second * material.modulus_MPa) + sheared.sum(axis=1) / (area * material.shear_MPa)
    return float(give.sum() * step * URAD_NM)


def torsion_urad_Nm(torque_Nmm: float, sections: Sequence[Section], shear_MPa: float, *, collar: bool = False) -> float:
    """Turn by the torsion of a shaft that carries ``torque_Nmm`` over all its sections, which follow each other.

    Where the radius changes the thinner one twists a little inside the thicker one; ``collar``: the first section
    does so inside a collar that holds its outside.
    """
    give = sum((s.end_mm - s.start_mm) / (2.0 * s.second_moment_mm4) for s in sections)
    for a, b in pairwise(sections):
        thin, thick = sorted((a, b), key=lambda s: s.radius_mm)
        inside = JUNCTION * 2.0 * thin.radius_mm * (1.0 - (thin.radius_mm / thick.radius_mm) ** JUNCTION_POWER)
        give += inside / (2.0 * thin.second_moment_mm4)
    if collar and sections:
        give += JUNCTION * 2.0 * sections[0].radius_mm / (2.0 * sections[0].second_moment_mm4)
    return torque_Nmm**2 * give / shear_MPa * URAD_NM


def ball_bearing_N_mm(bore_mm: float, outer_mm: float, radial_N: float, axial_N: float = 0.0) -> float:
    """Radial stiffness of a deep-groove ball bearing without play, for small changes about the loads that it carries.

    Palmgren: a ball under Q N gives by 4.36e-4 (Q^2 / D_w)^(1/3) mm. Under a radial load F the most loaded one carries
    5 F / Z; an axial preload loads all of them by F / (Z sin a), with a the contact angle of a bearing of normal play.
    The stiffer of both counts. Catalogues give neither the balls' diameter D_w nor their number Z: usual proportions
    stand for them, so that the stiffness is known to some 30 %.
    """
    ball = _BALL_SHARE * (outer_mm - bore_mm) / 2.0
    count = max(floor(pi * (bore_mm + outer_mm) / 2.0 / (_BALL_PITCH * ball)), 5)

    def ball_N_mm(load_N: float) -> float:
        # Below a light load the balls carry what their fits press on them.
        load_N = max(load_N, _LEAST_BALL_N)
        return float(1.5 * load_N / (4.36e-4 * (load_N**2 / ball) ** (1.0 / 3.0)))

    sine = sin(radians(_CONTACT_DEG))
    pressed = 0.5 * count * (1.0 - sine**2) * ball_N_mm(axial_N / (count * sine))
    return max(0.2 * count * ball_N_mm(5.0 * radial_N / count), pressed if axial_N > 0.0 else 0.0)


def bearing_urad_Nm(reaction_N: float, stiffness_N_mm: float) -> float:
    """Turn by a bearing's radial give; ``reaction_N``: the change of its load for 1 N m on the drum."""
    return reaction_N**2 / stiffness_N_mm * URAD_NM
