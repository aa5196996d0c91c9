"""A belt or a pair of gears between the motor, or its gearhead, and the input: fields of the file, and its figures.

Values that a file leaves out are estimates by kind, each with its source beside it. Torques, stiffness and lash count
at the driven wheel, which sits on the input pulley's shaft.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import asin, ceil, cos, hypot, pi, radians, sin
from typing import Literal

from mbcdm_cad.design.fields import Integer, Number, PlainBlock, choice, quantity


@dataclass(frozen=True)
class BeltType:
    """A toothed belt with round teeth, mm. ``below_mm``: from the pitch line to the outside of the pulley.

    ``force_N_mm``: effective tension allowed per mm of width (table of allowable working tensions of a belt maker's
    handbook, sdp-si.com, D265 T15: 25, 114 and 160 lbf an inch). ``stiffness_N_mm``: tension per strain and mm of
    width; an estimate from makers' elongation of 0.2 % at that tension, known to ``STIFFNESS_FACTOR``.
    """

    pitch_mm: float
    below_mm: float
    thickness_mm: float
    force_N_mm: float
    widths_mm: tuple[float, ...]

    @property
    def stiffness_N_mm(self) -> float:
        """See the class."""
        return self.force_N_mm / BELT_STRAIN

    @property
    def tooth_mm(self) -> float:
        """Height of a tooth, 0.38 of the pitch for round teeth."""
        return 0.38 * self.pitch_mm

    @property
    def back_mm(self) -> float:
        """Belt above the outside of the pulleys, its teeth aside."""
        return self.thickness_mm - self.tooth_mm


BELT_STRAIN = 2e-3
BELTS = {
    "2GT": BeltType(2.0, 0.254, 1.52, 4.38, (4.0, 6.0, 9.0)),
    "3GT": BeltType(3.0, 0.381, 2.41, 19.96, (6.0, 9.0, 15.0)),
    "5GT": BeltType(5.0, 0.572, 3.81, 28.0, (9.0, 15.0, 25.0)),
}
# Modules of stock gears, mm.
MODULES_MM = (0.4, 0.5, 0.8, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0)
USUAL_RATIO = 3.0
# Fewest teeth of the small wheel: makers' least number for belts, undercut for gears.
LEAST_TEETH = {"belt": 16, "gears": 18}
# Least wall of a wheel between bore and teeth, mm (makers' smallest pulleys).
WHEEL_WALL_MM = 0.8
# Load over that of a smooth one, for small drives that reverse: 1.5 to 2 (belt makers).
SERVICE = 1.5
# Teeth of the small wheel that carry the belt's load as makers reckon it.
TEETH_IN_MESH = 6
# Efficiency: 95 to 98 % of belt drives (makers); one open pair of spur gears with grease.
EFFICIENCY = {"belt": 0.97, "gears": 0.97}
# Standard deviation of the logarithm of the share that is lost.
EFFICIENCY_SIGMA = 0.4
# Play at the pitch line, mm: of the belt's teeth in their grooves under its tension; of stock gears at their nominal
# centre distance, a part for the centre distance and one that grows with the module (estimates).
BELT_PLAY_MM, GEAR_PLAY_MM, GEAR_PLAY_MODULES = 0.01, 0.02, 0.04
# Mesh of two steel gears, N per mm of width and mm of deflection (ISO 6336-1: 20 N/(mm um)), and the share of it that
# wheels, bores and shafts of small gears leave (estimate).
MESH_N_MM2, MESH_SHARE = 20e3, 0.25
# One standard deviation of an estimated stiffness, as a factor.
STIFFNESS_FACTOR = 1.5
# Tension that a belt is set to, over its effective tension at the peak torque: the slack side keeps a tenth of it.
SET_TENSION = 0.6
PRESSURE_ANGLE = radians(20.0)
DENSITY_G_CM3 = {"belt": 2.8, "gears": 7.85}


@dataclass(frozen=True, kw_only=True)
class StageBlock(PlainBlock):
    """A belt or a pair of gears between the motor, or its gearhead, and the input (siso_spur and miso_spur)."""

    kind: Literal["belt", "gears"] = choice("toothed belt, or a pair of spur gears")
    ratio: Number | None = quantity(
        "turns of the motor's or gearhead's shaft for one of the input; teeth give the nearest they can", "[1, 12]"
    )
    driver_teeth: Integer | None = quantity("teeth of the small wheel", ge=10, le=200)
    belt: Literal["2GT", "3GT", "5GT"] | None = choice("profile and pitch of the belt, in mm")
    belt_teeth: Integer | None = quantity("teeth of the belt, which give the distance of the axes", ge=20, le=1000)
    module_mm: Number | None = quantity("module of the gears", "[0.2, 6]")
    width_mm: Number | None = quantity("width of belt or teeth", "[1, 100]")
    efficiency: Number | None = quantity("power given over power taken; left out, an estimate by kind", "(0.5, 1]")
    stiffness_Nm_rad: Number | None = quantity(
        "torsional stiffness at the input, motor held; left out, an estimate from belt or teeth", "(0, 1e7]"
    )
    lash_arcmin: Number | None = quantity(
        "play at the input, motor held, from one flank to the other; left out, an estimate from the teeth", "[0, 600]"
    )


@dataclass(frozen=True)
class Stage:
    """A stage with all its values; radii in mm are those of the pitch circles."""

    kind: Literal["belt", "gears"]
    asked_ratio: float
    driver_teeth: int
    driven_teeth: int
    pitch_mm: float  # along the pitch circle
    belt: str
    belt_teeth: int
    width_mm: float
    stated_efficiency: float | None
    stated_stiffness_Nm_rad: float | None
    stated_lash_arcmin: float | None

    @property
    def is_belt(self) -> bool:
        """Whether a belt runs round both wheels."""
        return self.kind == "belt"

    @property
    def words(self) -> str:
        """One word for it in texts."""
        return "belt stage" if self.is_belt else "gear stage"

    @property
    def sense(self) -> int:
        """+1 where both wheels turn the same way, -1 for a pair of gears."""
        return 1 if self.is_belt else -1

    @property
    def ratio(self) -> float:
        """Turns of the driver for one of the driven wheel, by their teeth."""
        return self.driven_teeth / self.driver_teeth

    @property
    def module_mm(self) -> float:
        """Diameter of a pitch circle over its teeth."""
        return self.pitch_mm / pi

    @property
    def driver_mm(self) -> float:
        """Pitch radius of the driver."""
        return self.pitch_mm * self.driver_teeth / (2 * pi)

    @property
    def driven_mm(self) -> float:
        """Pitch radius of the driven wheel."""
        return self.pitch_mm * self.driven_teeth / (2 * pi)

    @property
    def type(self) -> BeltType:
        """The belt's. ``KeyError`` for gears."""
        return BELTS[self.belt]

    def outside_mm(self, pitch_radius_mm: float) -> float:
        """Radius over the teeth of a wheel: less than that of the pitch circle for belts, a module more for gears."""
        return pitch_radius_mm - self.type.below_mm if self.is_belt else pitch_radius_mm + self.module_mm

    def root_mm(self, pitch_radius_mm: float) -> float:
        """Radius of a wheel at the bottom of its teeth."""
        if self.is_belt:
            return self.outside_mm(pitch_radius_mm) - self.type.tooth_mm
        return pitch_radius_mm - 1.25 * self.module_mm

    def reach_mm(self, pitch_radius_mm: float) -> float:
        """Furthest that a wheel with its belt or its flanges reaches from its axis."""
        outside = self.outside_mm(pitch_radius_mm)
        return outside + max(self.type.back_mm, FLANGE_MM) if self.is_belt else outside

    def beside_belt_mm(self, x: float, y: float) -> float:
        """Distance of a point from the belt on its spans and on the driver; the driver's axis is at (0, ``centre_mm``).

        Below zero inside the belt; the driven pulley does not count.
        """
        back, lean = self.type.back_mm - self.type.below_mm, self.slant_rad
        beyond = hypot(x, y - self.centre_mm) - self.driver_mm - back
        along = y * cos(lean) - abs(x) * sin(lean)
        if not 0.0 <= along <= self.span_mm:
            return beyond
        across = abs(x) * cos(lean) + y * sin(lean) - self.driven_mm
        of_span = max(across - back, -across - self.type.below_mm - self.type.tooth_mm)
        return min(of_span, beyond) if beyond > 0.0 else beyond

    @property
    def wheel_width_mm(self) -> float:
        """Length of a wheel along its axis: belts run between two flanges."""
        return self.width_mm + 2 * (BELT_SIDE_MM + FLANGE_WIDTH_MM) if self.is_belt else self.width_mm

    @cached_property
    def centre_mm(self) -> float:
        """Distance of the axes: of the belt's length, or the sum of the gears' pitch radii.

        Pitch radii touching where the belt is too short for its pulleys.
        """
        touching = self.driver_mm + self.driven_mm
        if not self.is_belt:
            return touching
        length = self.belt_teeth * self.pitch_mm
        low, high = touching, max(length / 2, touching)
        if belt_length_mm(self.driver_mm, self.driven_mm, low) >= length:
            return touching
        for _ in range(80):
            middle = (low + high) / 2
            if belt_length_mm(self.driver_mm, self.driven_mm, middle) < length:
                low = middle
            else:
                high = middle
        return round((low + high) / 2, 6)

    @property
    def slant_rad(self) -> float:
        """Angle of the belt's spans to the line of the axes; 0 for gears."""
        return asin(min(1.0, (self.driven_mm - self.driver_mm) / self.centre_mm)) if self.is_belt else 0.0

    @property
    def span_mm(self) -> float:
        """Length of each free span of the belt."""
        return self.centre_mm * cos(self.slant_rad)

    @property
    def driver_in_mesh(self) -> float:
        """Teeth of the driver in the belt, or one pair for gears."""
        return self.driver_teeth * (pi - 2 * self.slant_rad) / (2 * pi) if self.is_belt else 1.0

    @property
    def efficiency(self) -> float:
        """As stated, else the estimate of its kind."""
        return EFFICIENCY[self.kind] if self.stated_efficiency is None else self.stated_efficiency

    @property
    def stiffness_Nm_rad(self) -> float:
        """At the driven wheel, the driver held: as stated, else two spans of the belt, or the mesh of the gears.

        r2^2 (k + k): the tight span stretches, and the slack one as much less.
        """
        if self.stated_stiffness_Nm_rad is not None:
            return self.stated_stiffness_Nm_rad
        if self.is_belt:
            along = 2.0 * self.type.stiffness_N_mm * self.width_mm / max(self.span_mm, 1e-3)
            return along * self.driven_mm**2 * 1e-3
        base = self.driven_mm * cos(PRESSURE_ANGLE)
        return MESH_SHARE * MESH_N_MM2 * self.width_mm * base**2 * 1e-3

    @property
    def lash_rad(self) -> float:
        """Play at the driven wheel from one flank to the other: as stated, else the estimate."""
        if self.stated_lash_arcmin is not None:
            return radians(self.stated_lash_arcmin / 60.0)
        play = BELT_PLAY_MM if self.is_belt else GEAR_PLAY_MM + GEAR_PLAY_MODULES * self.module_mm
        return play / self.driven_mm

    def force_N(self, input_Nm: float) -> float:
        """Effective tension of the belt, or force along the line of the teeth's pitch circles."""
        return abs(input_Nm) * 1e3 / self.driven_mm

    def across_N(self, input_Nm: float) -> float:
        """Force across each shaft at a torque on the input: the belt's set tension, or the gears' normal force."""
        force = self.force_N(input_Nm)
        return 2.0 * SET_TENSION * force * cos(self.slant_rad) if self.is_belt else force / cos(PRESSURE_ANGLE)


# Room of a belt between the flanges of its pulleys on each side, a flange's width, and its height over the teeth, mm.
BELT_SIDE_MM, FLANGE_WIDTH_MM, FLANGE_MM = 0.3, 0.8, 1.0


def belt_length_mm(driver_mm: float, driven_mm: float, centre_mm: float) -> float:
    """Length along the pitch line of an open belt: two spans and two arcs."""
    slant = asin(min(1.0, (driven_mm - driver_mm) / centre_mm))
    return 2 * centre_mm * cos(slant) + pi * (driver_mm + driven_mm) + 2 * slant * (driven_mm - driver_mm)


def least_driver_teeth(kind: str, pitch_mm: float, below_mm: float, shaft_mm: float) -> int:
    """Fewest teeth of a driver on a shaft of this diameter; ``below_mm``: from the pitch line to the root."""
    return max(LEAST_TEETH[kind], ceil(2 * pi * (shaft_mm / 2 + WHEEL_WALL_MM + below_mm) / pitch_mm))


def carrying_belt(force_N: Callable[[float], float], width_mm: float | None) -> str:
    """The finest belt that carries ``force_N``, which is given the pitch in mm; the largest where none does."""
    for name, kind in BELTS.items():
        if kind.force_N_mm * (width_mm or kind.widths_mm[-1]) >= force_N(kind.pitch_mm):
            return name
    return list(BELTS)[-1]


def belt_reach_mm(belt: str, shaft_mm: float, teeth: int | None) -> float:
    """Radius of a driving pulley with its belt, with the fewest teeth for its shaft where none are stated."""
    kind = BELTS[belt]
    driver = teeth or least_driver_teeth("belt", kind.pitch_mm, kind.below_mm + kind.tooth_mm, shaft_mm)
    return driver * kind.pitch_mm / (2 * pi) - kind.below_mm + kind.back_mm


def driven_teeth(driver_teeth: int, ratio: float) -> int:
    """Teeth of the driven wheel that come nearest to the ratio."""
    return max(driver_teeth, round(driver_teeth * ratio))


def stage_of(block: StageBlock) -> Stage:
    """The stage of a block whose teeth and sizes are filled."""
    driver, ratio = block.driver_teeth or LEAST_TEETH[block.kind], block.ratio or USUAL_RATIO
    pitch = BELTS[block.belt or "3GT"].pitch_mm if block.kind == "belt" else pi * (block.module_mm or 1.0)
    return Stage(
        kind=block.kind,
        asked_ratio=ratio,
        driver_teeth=driver,
        driven_teeth=driven_teeth(driver, ratio),
        pitch_mm=pitch,
        belt=block.belt or "",
        belt_teeth=block.belt_teeth or 0,
        width_mm=block.width_mm or 0.0,
        stated_efficiency=block.efficiency,
        stated_stiffness_Nm_rad=block.stiffness_Nm_rad,
        stated_lash_arcmin=block.lash_arcmin,
    )
