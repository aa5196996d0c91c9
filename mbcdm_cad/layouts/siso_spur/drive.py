"""A siso_spur drive: the shared values of drives with a drum sector, the winding of its input and its frame."""

from dataclasses import dataclass, replace
from functools import cached_property
from math import acos, hypot, inf, pi, radians, sqrt, tan, tau
from typing import TypeVar

import numpy as np

from mbcdm_cad.design.bought import Bearing
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.sector_blocks import WoundPulleys
from mbcdm_cad.layouts.siso_spur.routes import SENSE, Circle, Strand, flange_radius_mm, taut
from mbcdm_cad.layouts.siso_spur.schema import IdlerBlock, IdlerPlace, SpurDrum, SpurLimits, YokeSupport
from mbcdm_cad.parts.drum_sector.design import SectorBearings, SectorDrive, SectorRun
from mbcdm_cad.parts.drum_sector.dims import WHOLE_DEG
from mbcdm_cad.parts.input_pulley.dims import GROOVE_DEPTH, GROOVE_RADIUS

_Spur = TypeVar("_Spur", bound="SpurDrive")
# Angle of half the transition from the cable's helix to the plane of its terminal, which follows the last point that
# ever leaves the drum.
CHANGE_RAD = 0.01
# Largest travel from the centre for which rules take a sector.
MOST_SECTOR_TRAVEL_DEG = 120.0
# Wrap of a cable that is left on a whole drum at the end of the travel (estimate: the change of plane, and some rest).
RING_WRAP_DEG = 5.0
# Largest angle from the centre at which a pin stops the drum: beyond, the web beside its slot would be narrow.
MOST_STOP_DEG = 165.0
# Half the range of the preloads of parallel cables that are set by the pitch of a span, over their mean (estimate: 5 %
# of the pitch are 10 % of the tension).
PITCH_SPREAD = 0.1
# The largest spread that a file may state.
MOST_SPREAD = 0.5
# Land of the input between two anchored cables, their walk included (estimate: a crest that can be turned).
BETWEEN_MM = 0.3


@dataclass(frozen=True)
class SpurRun(SectorRun):
    """One side of the cable, or one of two anchored ones, from the input to its terminal.

    Step 1 lies at the smaller y on the input.
    """

    terminal_y_mm: float

    @property
    def land_y_mm(self) -> float:
        """Plane of the terminal, outside the part of the drum on which the cable winds."""
        return self.terminal_y_mm

    @property
    def outward(self) -> int:
        """Sense along y from the middle of the winding to the point where this side leaves the input."""
        return 1 if self.step == 2 else -1


@dataclass(frozen=True, kw_only=True)
class SpurBearings(SectorBearings):
    """The bearing chosen for each role, that of idlers too."""

    idler: Bearing | None = None  # in both ends of each idler


@dataclass(frozen=True)
class SpurDrive(SectorDrive):
    """A drive with an input beside the drum: one cable round the input, both ends on the drum, or two anchored cables.

    ``turns``: number of times that the one cable passes the line of centres on the input, or that each of two
    ``anchored`` cables does at the end of the travel where it is wound up. ``level_mm``: position of the middle of the
    winding along y; input pulley and encoder shelf are that much further from the frame's plate. ``frame_angle_rad``:
    angle round the drum's axis in which this input's part of the frame lies. ``idlers``: those that lead the cable to
    an input away from the drum; None where it runs straight to the drum. ``first_stage``: the drive of a first
    cable stage, whose drum's shaft turns the input; the gearhead is then what that is to this stage.
    ``open_spans``: the spans do not cross, so that the input turns with the drum. ``parallel``: equal cables side
    by side round the input, each with a sector of its own; ``cables`` has both sides of each, one cable after the
    other. After tightening, their preloads differ from the stated one by up to :attr:`SpurLayout.preload_spread` of
    it.
    """

    cables: tuple[SpurRun, ...]
    centre_distance_mm: float
    turns: int
    anchored: bool
    limits: SpurLimits
    radii_explicit: bool
    input_pulleys: WoundPulleys
    drum: SpurDrum
    bearings: SpurBearings
    support: YokeSupport
    level_mm: float = 0.0
    frame_angle_rad: float = tau
    idlers: IdlerBlock | None = None
    first_stage: "SpurDrive | None" = None
    open_spans: bool = False
    parallel: int = 1

    @property
    def angles_rad(self) -> tuple[float, ...]:
        """Angles of the sectors and of their inputs about Y, from +Z towards +X."""
        count = len(self.input_names)
        return tuple(tau * k / count for k in range(count)) if count > 1 else (0.0,) * self.parallel

    @cached_property
    def pitch_mm(self) -> float:
        """Distance between sectors along the axis, hub on hub."""
        return self.drum.hub_face_y_mm - boss_front_y_mm(self)

    @property
    def levels_mm(self) -> tuple[float, ...]:
        """Distance of each sector and its cable from ``level_mm`` along the axis."""
        return tuple(k * self.pitch_mm for k in range(len(self.angles_rad)))

    @property
    def band_mm(self) -> float:
        """Distance along an input from its first cable to its last one."""
        return (self.parallel - 1) * self.pitch_mm if self.parallel > 1 else 0.0

    @property
    def sector_names(self) -> tuple[str, ...]:
        """Names of the sectors, each of which has one cable: of the inputs, or its number, from the back."""
        several = len(self.input_names) > 1
        return tuple(self.input_names) if several else tuple(str(k + 1) for k in range(self.parallel))

    @property
    def between_hubs_Nm(self) -> float:
        """Largest torque between the last two hubs, motors stalled: that of all other sectors."""
        stalled = self.motor.rated_torque_mNm * 1e-3 * self.reduction.ratio * len(self.input_names) * self.total_ratio
        count = len(self.angles_rad)
        return max(self.loads.peak_torque_Nm, stalled) * (count - 1) / count

    def unit(self, index: int) -> "SpurDrive":
        """The cable with this index, its sector and its input as a separate drive, the input above the drum."""
        return self if len(self.angles_rad) == 1 else self.once(f"unit {index}", lambda whole: whole._made_unit(index))

    def _made_unit(self, index: int) -> "SpurDrive":
        places = (2 * index, 2 * index + 1)
        cables = [self.cables[j] for j in places]
        level = self.level_mm + self.levels_mm[index]
        return replace(
            self,
            configuration="siso_spur",
            input_names=(cables[0].input_name,),
            cables=tuple(replace(c, terminal_y_mm=level + c.outward * self.terminal_mm) for c in cables),
            sigmas=self.sigmas.of_cables(places),
            level_mm=level,
            frame_angle_rad=tau / len(self.input_names),
            parallel=1,
        )

    @property
    def cable_names(self) -> tuple[str, ...]:
        """Names of the continuous cables: their input's, with their number where several lie side by side."""
        numbers = [""] if self.parallel == 1 else [f"_{k + 1}" for k in range(self.parallel)]
        return tuple(f"{name}{number}" for name in self.input_names for number in numbers)

    @property
    def leading(self) -> IdlerBlock:
        """The block of the idlers of a drive that has them."""
        assert self.idlers is not None
        return self.idlers

    @property
    def idler_bearing(self) -> Bearing:
        """Bearing in both ends of each idler of a drive that has them."""
        assert self.bearings.idler is not None
        return self.bearings.idler

    @property
    def idler_places(self) -> tuple[IdlerPlace, ...]:
        """Places of the idlers of the side +x, from the input to the drum."""
        return self.idlers.places if self.idlers else ()

    @property
    def idler_mm(self) -> float:
        """Pitch radius of the idlers; 0 without any."""
        return self.idlers.radius_mm if self.idlers else 0.0

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
    def strand(self) -> Strand:
        """Path of the side +x from the input to the drum in the plane of X and Z, mm."""
        return taut(
            [
                Circle(0.0, self.centre_distance_mm, self.input_radius_mm, -self.input_sense),
                *(Circle(p.x_mm, p.z_mm, self.idler_mm, SENSE) for p in self.idler_places),
                Circle(0.0, 0.0, self.drum_radius_mm, 1),
            ]
        )

    @property
    def input_sense(self) -> int:
        """+1 if the spans cross, so that the cable is wound on the input towards the side of the drum that it runs to.

        -1 if they are open.
        """
        return -1 if self.open_spans else 1

    @cached_property
    def landing_rad(self) -> float:
        """Angle from the line of centres at which the cable lands on the drum; without idlers cos = (r_o +- r_i) / L.

        0 where the pulleys touch or overlap.
        """
        return float(np.nan_to_num(self.strand.landing_rad))

    @cached_property
    def leaving_rad(self) -> float:
        """Angle from the line of centres at which the cable leaves the input, whichever way it is wound there.

        Without idlers that of the landing, with open spans the rest of a half turn.
        """
        return float(np.nan_to_num(self.strand.leaving_rad))

    @property
    def free_span_mm(self) -> float:
        """L_free of each side, all straight pieces: without idlers sqrt(L^2 - (r_o +- r_i)^2), minus if open.

        0 if pulleys overlap, or if the cable does not touch an idler.
        """
        touched = bool((self.strand.wraps > 0.0).all())
        return float(np.nan_to_num(self.strand.length.sum())) if touched else 0.0

    @cached_property
    def led_mm(self) -> tuple[float, ...]:
        """Lengths of each side from the input to the drum, without the slope: spans and, between them, idlers."""
        if self.free_span_mm == 0.0:
            return (0.0,)
        arcs = self.idler_mm * self.strand.wraps
        between = (float(length) for pair in zip(arcs, self.strand.length[1:], strict=True) for length in pair)
        return (float(self.strand.length[0]), *between)

    @property
    def strand_mm(self) -> float:
        """Length of each side between input and drum along the pitch line, idlers included, without the slope."""
        return sum(self.led_mm)

    @property
    def idler_levels_mm(self) -> tuple[float, ...]:
        """Distance along y from the middle to the middle of the cable on each idler, from the input on, drum centred.

        Negative if the cable has crossed the middle. Its walk and its rise on the idler are on both sides of that.
        """
        way = self.led_mm
        before = (sum(way[:k]) + way[k] / 2 for k in range(1, len(way), 2))
        return tuple(self.leave_mm + length * self._away for length in before)

    @property
    def idler_band_mm(self) -> float:
        """Length of an idler along its axis that the cable uses over the travel.

        It is the walk, the rise on the wrap and past both flanges, and the diameter.
        """
        if self.idlers is None:
            return 0.0
        d, r = self.cable.diameter_mm, self.idlers.radius_mm
        past = sqrt((flange_radius_mm(r, d) + d / 2) ** 2 - r**2)
        return self.walk_mm + (max(self.led_mm[1::2], default=0.0) + 2 * past) * self.slope + d

    @property
    def wrap_rad(self) -> float:
        """Wrap on the input from one span to the other, constant over the travel: 2 pi N - 2 leaving."""
        return tau * self.turns - 2 * self.leaving_rad

    @property
    def whole_drum(self) -> bool:
        """Whether the drum is closed all round."""
        return self.drum.sector_half_angle_deg >= WHOLE_DEG

    @property
    def ring_anchor_rad(self) -> float | None:
        """See the base class; the turns that the travel needs, and a rest of wrap."""
        if not self.whole_drum:
            return None
        return self.landing_rad + radians(self.half_travel_deg + RING_WRAP_DEG)

    def turn_beside_mm(self, end_rad: float) -> float:
        """See the base class; the helix on the drum has the slope of the turns on the input."""
        first = self.landing_rad - radians(self.half_travel_deg)
        if not self.whole_drum or end_rad - tau <= first:
            return inf
        rest = end_rad - (self.landing_rad + radians(self.half_travel_deg) + 2 * CHANGE_RAD)
        return self.helix_lead_mm * self.total_ratio * (1.0 - rest / tau) - self.cable.diameter_mm / 2

    @property
    def stopped(self) -> bool:
        """See the base class; a pin in a slot of the web leaves no room for a whole turn."""
        return self.half_travel_deg + self.stop_clearance_deg <= MOST_STOP_DEG

    @property
    def ends_per_run(self) -> int:
        """Ends of rope of each of ``cables``: the terminal alone on a side of the one cable."""
        return 2 if self.anchored else 1

    @property
    def wound_rad(self) -> float:
        """Wrap of each side with the drum centred: to the middle of the one cable, or to the end of an anchored one."""
        if self.anchored:
            return tau * self.turns - self.input_travel_rad / 2
        return self.wrap_rad / 2

    @property
    def input_travel_rad(self) -> float:
        """Angle through which the input turns over the whole travel."""
        return 2 * radians(self.half_travel_deg) * self.total_ratio

    @property
    def walk_mm(self) -> float:
        """Walk of both spans along the axes over the travel: lead x ratio x travel / 360 degrees."""
        return self.helix_lead_mm * self.input_travel_rad / tau

    @property
    def slope(self) -> float:
        """Slope of the cable, the same on input, span and drum: rise along the axes per length, lead / (2 pi r_i)."""
        return self.helix_lead_mm / (tau * self.input_radius_mm)

    @property
    def leave_mm(self) -> float:
        """Distance along y from the middle of the input to the point where each span leaves it, drum centred.

        Two anchored cables are wound outwards from there; it leaves a crest between their grooves over the whole walk.
        """
        if self.anchored:
            return self.walk_mm / 2 + run_out_mm(self) + BETWEEN_MM / 2
        return self.helix_lead_mm * self.wrap_rad / (2 * tau)

    @property
    def dead_end_mm(self) -> float:
        """Distance along y from the middle of the input to the end of an anchored cable's winding."""
        return self.leave_mm + self.helix_lead_mm * self.wound_rad / tau

    @property
    def _away(self) -> float:
        """Slope away from the middle, from the input to the terminal; negative for two anchored cables."""
        return -self.slope if self.anchored else self.slope

    @property
    def land_mm(self) -> float:
        """Distance along y from the middle to the point where each span lands on the drum, drum centred."""
        return self.leave_mm + self.strand_mm * self._away

    @cached_property
    def terminal_mm(self) -> float:
        """Distance along y from the middle to the planes of the terminals, past the helix on which the cable winds.

        Negative if a cable has crossed the middle.
        """
        turned = radians(self.half_travel_deg) + CHANGE_RAD + tan(CHANGE_RAD)
        return self.land_mm + self.drum_radius_mm * self._away * turned

    @property
    def on_drum_mm(self) -> float:
        """Largest distance along y from the middle at which a cable lies on the drum over the travel."""
        return max(self.land_mm + self.walk_mm / 2, abs(self.terminal_mm))

    @property
    def stretched(self) -> float:
        """Ratio of the length of a turn of the helix to that of its circle."""
        return hypot(1.0, self.slope)


def drum_inner_y_mm(drive: SpurDrive) -> float:
    """Inner face of the drum's rim along y."""
    return -drive.on_drum_mm - drive.cable.diameter_mm / 2 - drive.clearances.land_edge_mm


def boss_front_y_mm(drive: SpurDrive) -> float:
    """Front of the drum's boss along y, on which the hub stands."""
    return drum_inner_y_mm(drive) - 3 * drive.clearances.running_mm


def laid(drive: _Spur) -> _Spur:
    """The drive with the planes of its terminals and its dead turns, both computed from the winding."""
    y = drive.terminal_mm
    cables = tuple(replace(c, terminal_y_mm=drive.level_mm + c.outward * y) for c in drive.cables)
    # A continuous cable has no end on an input.
    reserve = drive.turns - drive.input_travel_rad / tau if drive.anchored else 0.0
    return replace(drive, cables=cables, dead_turns=reserve)


def spur(drive: Drive) -> SpurDrive:
    """``drive`` as one of this configuration. Raises ``TypeError`` for a drive of another."""
    if not isinstance(drive, SpurDrive):
        raise TypeError(f"{drive.name}: a drive of configuration {drive.configuration}, not of siso_spur")
    return drive


def contact_rad(drive: SpurDrive, side: int) -> float:
    """Angle about Y, from +Z towards +X, at which the span of one side leaves the input."""
    return pi + drive.input_sense * side * drive.leaving_rad


def groove_depth_mm(drive: SpurDrive) -> float:
    """Height of the crests of the input's grooves above the surface under the cable; 0 if smooth."""
    return GROOVE_DEPTH * drive.cable.diameter_mm if drive.input_pulleys.grooved else 0.0


def groove_run_out_rad(drive: SpurDrive) -> float:
    """Angle past its last contact at which the straight span has risen out of the groove."""
    r = drive.input_radius_mm
    return acos(r / (r + groove_depth_mm(drive)))


def run_out_mm(drive: SpurDrive) -> float:
    """Length of the input that cable or groove use beyond the cable's last contact."""
    flank = drive.cable.diameter_mm / 2
    if not drive.input_pulleys.grooved:
        return flank
    radius, depth = GROOVE_RADIUS * drive.cable.diameter_mm, groove_depth_mm(drive)
    wide = sqrt(2 * radius * depth - depth**2)
    return drive.input_radius_mm * drive.slope * groove_run_out_rad(drive) + max(flank, wide)
