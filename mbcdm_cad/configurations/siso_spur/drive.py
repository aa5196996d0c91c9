"""What a siso_spur drive has beyond what all drives with a drum sector have: the winding of its input, its frame."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import acos, hypot, pi, radians, sqrt, tan, tau
from typing import TypeVar

from mbcdm_cad.design.bought import Bearing, Material
from mbcdm_cad.design.drive import Drive, Limits, Sigmas
from mbcdm_cad.parts.drum_sector.design import SectorRun, WoundPulleySpec
from mbcdm_cad.parts.input_pulley.dims import GROOVE_DEPTH, GROOVE_RADIUS
from mbcdm_cad.parts.motor_head.dims import HeadedDrive

_Spur = TypeVar("_Spur", bound="SpurDrive")
# Just past the last point that ever leaves the drum the cable changes from its helix to the plane of its terminal, over
# twice this angle.
CHANGE_RAD = 0.01
# Land of the input between what two anchored cables take of it, walk included (estimate: a crest that can be turned).
BETWEEN_MM = 0.3


@dataclass(frozen=True)
class SpurRun(SectorRun):
    """One side of the cable, or one of two anchored ones, from the input to its terminal.

    Step 1 lies at the smaller y on the input.
    """

    terminal_y_mm: float

    @property
    def land_y_mm(self) -> float:
        """Plane of the terminal, outside all that winds on and off."""
        return self.terminal_y_mm

    @property
    def outward(self) -> int:
        """Sense along y in which this side leaves the input, from its middle."""
        return 1 if self.step == 2 else -1


@dataclass(frozen=True)
class SpurBearings:
    """The bearing chosen for each role."""

    drum: Bearing
    input_lower: Bearing  # next to the gearhead
    input_upper: Bearing  # next to the encoder

    def all(self) -> tuple[Bearing, ...]:
        """The three roles in the order drum, gearhead's end, encoder's end (types may repeat)."""
        return (self.drum, self.input_lower, self.input_upper)


@dataclass(frozen=True)
class YokeSpec:
    """Frame and motor head."""

    material: Material
    back_y_mm: float
    plate_mm: float
    bridge_mm: float
    side_wall_mm: float
    motor_shelf_mm: float
    coupling_space_mm: float
    bearing_shelf_mm: float
    encoder_shelf_mm: float


@dataclass(frozen=True)
class SpurLimitValues(Limits):
    """Adds what friction on the input must hold over the peak torque."""

    slip_margin_min: float


@dataclass(frozen=True, kw_only=True)
class SpurSigmas(Sigmas):
    """Standard deviations of this configuration's own lengths too."""

    input_radius_mm: tuple[float, ...]
    drum_radius_mm: tuple[float, ...]
    centre_distance_mm: float


@dataclass(frozen=True)
class SpurDrive(HeadedDrive):
    """A drive whose one cable goes round an input beside the drum, both ends on the drum; or two that end on both.

    ``turns``: how often the one cable comes round to the line of centres, or each of two ``anchored`` ones at the end
    of the travel that winds it up. ``level_mm``: where along y the middle of the winding lies; the input's pulley and
    its far shelf lie that much further from the frame's plate. ``frame_angle_rad``: angle round the drum's axis that
    this input's part of the frame has to itself.
    """

    cables: tuple[SpurRun, ...]
    sigmas: SpurSigmas
    centre_distance_mm: float
    turns: int
    anchored: bool
    limits: SpurLimitValues
    radii_explicit: bool
    input_pulleys: WoundPulleySpec
    bearings: SpurBearings
    support: YokeSpec
    level_mm: float = 0.0
    frame_angle_rad: float = tau

    @property
    def input_radius_mm(self) -> float:
        """Pitch radius of the input."""
        return self.cables[0].input_radius_mm

    @property
    def drum_radius_mm(self) -> float:
        """Pitch radius of the drum."""
        return self.cables[0].drum_radius_mm

    @property
    def total_ratio(self) -> float:
        """i = r_o / r_i."""
        return self.drum_radius_mm / self.input_radius_mm

    @cached_property
    def landing_rad(self) -> float:
        """Angle from the line of centres at which the cable lands on the drum: cos = (r_o + r_i) / L.

        0 where the pulleys touch or overlap.
        """
        return acos(min(1.0, (self.drum_radius_mm + self.input_radius_mm) / self.centre_distance_mm))

    @property
    def free_span_mm(self) -> float:
        """L_free = sqrt(L^2 - (r_o + r_i)^2) of each side; 0 where there is none."""
        reach = self.drum_radius_mm + self.input_radius_mm
        return sqrt(max(0.0, self.centre_distance_mm**2 - reach**2))

    @property
    def wrap_rad(self) -> float:
        """Wrap over the input, from one span to the other, the same at every angle of the drum: 2 pi N - 2 landing."""
        return tau * self.turns - 2 * self.landing_rad

    @property
    def wound_rad(self) -> float:
        """Wrap of each side with the drum centred: to the middle of the one cable, or to the end of its winding."""
        if self.anchored:
            return tau * self.turns - self.input_travel_rad / 2
        return self.wrap_rad / 2

    @property
    def input_travel_rad(self) -> float:
        """How far the input turns from one end of the travel to the other."""
        return 2 * radians(self.half_travel_deg) * self.total_ratio

    @property
    def walk_mm(self) -> float:
        """How far both spans walk along the axes over the travel: lead x ratio x travel / 360 degrees."""
        return self.helix_lead_mm * self.input_travel_rad / tau

    @property
    def slope(self) -> float:
        """Rise of the cable along the axes per length, the same on input, span and drum: lead / (2 pi r_i)."""
        return self.helix_lead_mm / (tau * self.input_radius_mm)

    @property
    def leave_mm(self) -> float:
        """Distance along y from the middle of the input to where each span leaves it, drum centred.

        Two anchored cables are wound outwards from there, and their grooves keep apart over the whole walk.
        """
        if self.anchored:
            return self.walk_mm / 2 + run_out_mm(self) + BETWEEN_MM / 2
        return self.helix_lead_mm * self.wrap_rad / (2 * tau)

    @property
    def dead_end_mm(self) -> float:
        """The same to the end of an anchored cable's winding."""
        return self.leave_mm + self.helix_lead_mm * self.wound_rad / tau

    @property
    def _away(self) -> float:
        """Rise of the cable away from the middle per length from the input to the terminal: spans of two converge."""
        return -self.slope if self.anchored else self.slope

    @property
    def land_mm(self) -> float:
        """The same to where each span lands on the drum."""
        return self.leave_mm + self.free_span_mm * self._away

    @cached_property
    def terminal_mm(self) -> float:
        """The same to the planes of the terminals, past what winds on and off the drum's helix.

        Negative where a cable has come past the middle.
        """
        turned = radians(self.half_travel_deg) + CHANGE_RAD + tan(CHANGE_RAD)
        return self.land_mm + self.drum_radius_mm * self._away * turned

    @property
    def on_drum_mm(self) -> float:
        """The same to the outermost that a cable ever lies on the drum."""
        return max(self.land_mm + self.walk_mm / 2, abs(self.terminal_mm))

    @property
    def stretched(self) -> float:
        """Length of a turn of the helix over that of its circle."""
        return hypot(1.0, self.slope)


def laid(drive: _Spur) -> _Spur:
    """The drive with the planes of its terminals where the winding asks for them, and the turns that stay on."""
    y = drive.terminal_mm
    cables = tuple(replace(c, terminal_y_mm=drive.level_mm + c.outward * y) for c in drive.cables)
    # No end of the one cable lies on an input.
    reserve = drive.turns - drive.input_travel_rad / tau if drive.anchored else 0.0
    return replace(drive, cables=cables, dead_turns=reserve)


def spur(drive: Drive) -> SpurDrive:
    """``drive`` as one of this configuration. Raises ``TypeError`` for a drive of another."""
    if not isinstance(drive, SpurDrive):
        raise TypeError(f"{drive.name}: a drive of configuration {drive.configuration}, not of siso_spur")
    return drive


def is_anchored(drive: SpurDrive) -> bool:
    """Whether two cables end on each input."""
    return drive.anchored


def is_continuous(drive: SpurDrive) -> bool:
    """Whether one cable goes round each input."""
    return not drive.anchored


def contact_rad(drive: SpurDrive, side: int) -> float:
    """Angle about Y, from +Z towards +X, at which the span of one side leaves the input."""
    return pi + side * drive.landing_rad


def groove_depth_mm(drive: SpurDrive) -> float:
    """How far the crests of the input's grooves stand over the surface that the cable lies on; 0 if smooth."""
    return GROOVE_DEPTH * drive.cable.diameter_mm if drive.input_pulleys.grooved else 0.0


def groove_run_out_rad(drive: SpurDrive) -> float:
    """Angle past its last contact at which the straight span has risen out of the groove."""
    r = drive.input_radius_mm
    return acos(r / (r + groove_depth_mm(drive)))


def run_out_mm(drive: SpurDrive) -> float:
    """What cable or groove take of the input's length beyond the cable's last contact."""
    flank = drive.cable.diameter_mm / 2
    if not drive.input_pulleys.grooved:
        return flank
    radius, depth = GROOVE_RADIUS * drive.cable.diameter_mm, groove_depth_mm(drive)
    wide = sqrt(2 * radius * depth - depth**2)
    return drive.input_radius_mm * drive.slope * groove_run_out_rad(drive) + max(flank, wide)
