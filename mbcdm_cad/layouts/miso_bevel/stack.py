"""Heights along Z (guide axis) and depths along Y (drum axis) that all parts share.

From top to bottom along Z:

    encoder | top plate (upper bearings inside) | pulleys and guide | bearing shelf (lower bearings inside)
            | coupling space | motor shelf | gearhead | motor

or, with motors above,

    motor | gearhead | motor shelf | coupling space | top plate | pulleys and guide | bearing shelf
            | encoder | lowest shelf

All levels follow from the cable steps: the pulleys end just beyond their bands of cable, the shelves follow from the
pulleys, the drives from the shelves. All mm.
"""

from dataclasses import dataclass, replace
from math import hypot, pi, radians, sqrt, tau
from typing import NamedTuple

from mbcdm_cad.design.bought import Screw
from mbcdm_cad.layouts.miso_bevel.cable_path import axial_walk_mm, guide_landing_walk_mm, stop_of, winding
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive, BevelRun
from mbcdm_cad.layouts.sector import coupled_pulley
from mbcdm_cad.parts.coupling import collar_sweep_mm
from mbcdm_cad.parts.drum_sector.design import END_PLAY_MM, SHELF_GAP_MM, InputLevels
from mbcdm_cad.parts.drum_sector.sizes import terminal_half_mm
from mbcdm_cad.parts.input_pulley import dims
from mbcdm_cad.parts.input_pulley.dims import helix_stop_land_mm
from mbcdm_cad.parts.motor_head.dims import TOOL_SLENDERNESS, body_radius_mm, outer_half_width_mm

# Screws and dowels of the top plate; the shortest that engage over one diameter are used.
PLATE_SCREWS = ("M2x6", "M2x8", "M2x10", "M2x12")
# Distance of the top plate's screws from its front and back edges.
PLATE_SCREW_INSET_MM = 3.5
# Radius of the counterbore over that of the head.
HEAD_PLAY_MM = 0.2


class Edges(NamedTuple):
    """Front and back edge of the top plate, and the radius of its corners; mm."""

    front_y: float
    back_y: float
    corner_mm: float

    @property
    def screws_y(self) -> tuple[float, float]:
        """y of the front and back screws, clear of the rounded corners."""
        inset = max(PLATE_SCREW_INSET_MM, self.corner_mm)
        return self.front_y - inset, self.back_y + inset


def plate_screw_of(drive: BevelDrive) -> Screw:
    """The top plate's screw: the shortest that engages over its diameter, else the longest."""
    screws = [drive.screw(name) for name in PLATE_SCREWS]
    sunk = [
        screw
        for screw in screws
        if screw.length_mm - drive.support.top_plate_mm + screw.head_height_mm >= screw.thread_mm
    ]
    return sunk[0] if sunk else screws[-1]


def counterbore_radius_mm(drive: BevelDrive) -> float:
    """Radius of the counterbore for a head of these screws."""
    return plate_screw_of(drive).head_diameter_mm / 2 + HEAD_PLAY_MM


def key_reach_mm(drive: BevelDrive) -> float:
    """Distance from an input's axis to the middle of a screw whose key passes the motor on the plate."""
    return body_radius_mm(drive) + plate_screw_of(drive).key_mm / 3**0.5 + drive.clearances.running_mm


def beside_box_mm(drive: BevelDrive, edges: Edges) -> float:
    """Least distance in x from an input's axis to the screws beside its coupling box: for counterbore and key."""
    counterbore = outer_half_width_mm(drive) + counterbore_radius_mm(drive) + drive.clearances.running_mm
    across = min(abs(y - drive.input_y_mm) for y in edges.screws_y)
    return max(counterbore, sqrt(max(key_reach_mm(drive) ** 2 - across**2, 0.0)))


def key_gap_mm(drive: BevelDrive, x_mm: float, y_mm: float) -> float:
    """Gap between the key of a screw at (x, y) and the motors on the plate."""
    reach = key_reach_mm(drive) - drive.clearances.running_mm
    return min(hypot(x_mm - side * drive.input_x_mm, y_mm - drive.input_y_mm) for side in (-1, 1)) - reach


# Land of the guide beyond the flank of the outermost cable at its widest walk.
GUIDE_MARGIN_MM = 0.8


@dataclass(frozen=True)
class Band:
    """Heights a cable covers on its input pulley: ``low`` and ``high`` to the flanks, ``dead_end`` at the last turn."""

    low_mm: float
    high_mm: float
    dead_end_mm: float


def band(drive: BevelDrive, cable: BevelRun) -> Band:
    """Band of one cable on its input pulley: +-walk about the step plane, dead turns on the outward side."""
    walk, outward = abs(axial_walk_mm(drive, cable, radians(drive.half_travel_deg))), winding(drive, cable).outward
    flank = drive.cable.diameter_mm / 2
    dead_end = cable.drum_radius_mm + outward * (walk + drive.dead_turns * drive.helix_lead_mm)
    other = cable.drum_radius_mm - outward * walk
    return Band(min(dead_end, other) - flank, max(dead_end, other) + flank, dead_end)


# What is called otherwise, or stands the other way round, as seen from the gearhead with motors above.
_FROM_GEARHEAD = (
    *((name, name) for name in ("motor", "gearhead", "motor_shelf", "guide", "encoder")),
    *(("bearing_shelf", "top_plate"), ("top_plate", "bearing_shelf")),
)


@dataclass(frozen=True, kw_only=True)
class Stack(InputLevels):
    """Levels along Z and Y; the gearhead's face is ``motor_shelf_bottom_z`` with motors below."""

    guide_bottom_z: float
    guide_top_z: float
    pocket_floor_y: float  # front surface of the back plate
    side_inner_x: float
    side_outer_x: float
    motor_top_z: float
    gearhead_top_z: float
    encoder_bottom_z: float
    pocket_floor_z: float  # of the frame's lower pockets: the motor shelf, or with motors above a shelf as thick

    @property
    def shelf_bottom_z(self) -> float:
        """Lower face of the frame's lowest shelf, on which its column ends."""
        if not self.motors_above:
            return self.motor_shelf_bottom_z
        return self.pocket_floor_z - (self.motor_shelf_top_z - self.motor_shelf_bottom_z)

    @property
    def shelf_top_z(self) -> float:
        """Upper face of the frame's lowest shelf: floor of the pockets for couplings, or for encoders."""
        return self.pocket_floor_z if self.motors_above else self.motor_shelf_top_z

    @property
    def motors_above(self) -> bool:
        """Whether the motors are on the top plate."""
        return self.motor_bottom_z > self.top_plate_top_z

    @property
    def from_gearhead(self) -> "Stack":
        """The same levels with heights along an input's axis, from its gearhead to its encoder.

        With motors above, z is reversed, and shelf and plate change their names: the bearing shelf is next to the
        gearhead.
        """
        if not self.motors_above:
            return self
        ends = (("bottom", "top"), ("top", "bottom"))
        turned = {f"{name}_{end}_z": -getattr(self, f"{of}_{to}_z") for name, of in _FROM_GEARHEAD for end, to in ends}
        return replace(self, **turned, pocket_floor_z=-self.pocket_floor_z)

    @property
    def height_mm(self) -> float:
        """Box along Z of drives and encoders."""
        return max(self.encoder_top_z, self.motor_top_z) - min(self.encoder_bottom_z, self.motor_bottom_z)

    @property
    def depth_mm(self) -> float:
        """Box along Y from the back of the frame to the hub's face."""
        return self.hub_face_y - self.back_y


def milled_corner_mm(drive: BevelDrive, depth_mm: float) -> float:
    """Corner radius of a pocket of the frame: an end mill no longer than four diameters reaches its floor."""
    return max(drive.frame_material.min_internal_radius_mm, depth_mm / TOOL_SLENDERNESS / 2)


def _beside_corner_mm(corner_mm: float, above_mm: float, gap_mm: float) -> float:
    """Least distance of an edge from a wall, mm, to keep a gap to the rounded corner between wall and floor."""
    if above_mm >= corner_mm:
        return gap_mm
    inner = (corner_mm - gap_mm) ** 2 - (corner_mm - above_mm) ** 2
    return max(gap_mm, corner_mm - sqrt(max(inner, 0.0)))


def stack(drive: BevelDrive) -> Stack:
    """Compute the levels of a design without tests; the checks find impossible levels."""
    bands = {c.name: band(drive, c) for c in drive.cables}
    walk_on_guide = max(guide_landing_walk_mm(drive, c) for c in drive.cables)
    flank = drive.cable.diameter_mm / 2
    steps = sorted(c.drum_radius_mm for c in drive.cables)
    guide_bottom = steps[0] - walk_on_guide - flank - GUIDE_MARGIN_MM
    guide_top = steps[-1] + walk_on_guide + flank + GUIDE_MARGIN_MM
    beyond = helix_stop_land_mm(drive)
    pulleys_low = min(b.low_mm for b in bands.values()) - beyond
    pulleys_high = max(b.high_mm for b in bands.values()) + beyond

    s = drive.support
    bearing_top = min(pulleys_low, guide_bottom) - SHELF_GAP_MM
    bearing_bottom = bearing_top - s.bearing_shelf_mm
    plate_bottom = max(pulleys_high, guide_top) + SHELF_GAP_MM + END_PLAY_MM
    plate_top = plate_bottom + s.top_plate_mm

    low_nut = min(c.guide_radius_mm for c in drive.cables) - terminal_half_mm(drive)
    drum_inner = min(c.guide_radius_mm for c in drive.cables) - flank + drive.clearances.transfer_gap_mm
    front = min(low_nut, drum_inner) - drive.clearances.running_mm
    corner = milled_corner_mm(drive, front - s.back_y_mm - s.back_plate_mm)
    # Radius of the parts that turn just above the shelf: the lower land of each pulley, and the cable on it.
    low_steps = [c for c in drive.cables if winding(drive, c).outward < 0]
    turning = [(c.input_radius_mm - flank, pulleys_low) for c in low_steps]
    turning += [(c.input_radius_mm + flank, bands[c.name].low_mm) for c in low_steps]
    beside = max(r + _beside_corner_mm(corner, z - bearing_top, drive.clearances.running_mm) for r, z in turning)
    edges = Edges(front, s.back_y_mm, corner)
    side_inner = drive.input_x_mm + max(beside, _widest_mm(drive, edges))
    return Stack(
        **_drive_levels(drive, (bearing_bottom, plate_top)),
        bearing_shelf_bottom_z=bearing_bottom,
        bearing_shelf_top_z=bearing_top,
        guide_bottom_z=guide_bottom,
        guide_top_z=guide_top,
        top_plate_bottom_z=plate_bottom,
        top_plate_top_z=plate_top,
        back_y=s.back_y_mm,
        pocket_floor_y=s.back_y_mm + s.back_plate_mm,
        front_y=front,
        drum_inner_y=drum_inner,
        drum_outer_y=drive.drum.outer_face_y_mm,
        hub_face_y=drive.drum.hub_face_y_mm,
        boss_front_y=drum_inner - 3 * drive.clearances.running_mm,
        side_inner_x=side_inner,
        side_outer_x=side_inner + s.side_wall_mm,
    )


def _widest_mm(drive: BevelDrive, edges: Edges) -> float:
    """Least distance of a side wall from the input's axis, mm, for what stands between the walls and on them."""
    running = drive.clearances.running_mm
    pulley = max(c.input_radius_mm for c in drive.cables) + drive.cable.diameter_mm / 2
    if not drive.motors_above:
        drives = max(drive.gearhead.diameter_mm / 2, drive.motor.diameter_mm / 2)
        return max(drives, pulley, collar_sweep_mm(drive)) + running
    # The encoder lies on the underside of the shelf, where the pocket's corner is.
    encoder = drive.encoder.diameter_mm / 2 + _beside_corner_mm(edges.corner_mm, 0.0, running)
    return max(pulley + running, encoder, beside_box_mm(drive, edges) - drive.support.side_wall_mm / 2)


def _drive_levels(drive: BevelDrive, between: tuple[float, float]) -> dict[str, float]:
    """Levels of motors, gearheads, motor shelf and encoders outside the bearing shelf and the top plate."""
    s, (bearing_bottom, plate_top) = drive.support, between
    way, near, far = (1, plate_top, bearing_bottom) if drive.motors_above else (-1, bearing_bottom, plate_top)
    shelf = near + way * s.coupling_space_mm
    face = shelf + way * s.motor_shelf_mm
    gear = face + way * drive.gearhead.length_mm
    end, encoder = gear + way * drive.motor.length_mm, far - way * drive.encoder.length_mm
    bodies = {"motor_shelf": (shelf, face), "gearhead": (face, gear), "motor": (gear, end), "encoder": (far, encoder)}
    floor = encoder - drive.clearances.running_mm if drive.motors_above else shelf
    low, high = ({f"{name}_{to}_z": of(z) for name, z in bodies.items()} for to, of in (("bottom", min), ("top", max)))
    return {**low, **high, "pocket_floor_z": floor}


def smallest_lead_mm(drive: BevelDrive) -> float:
    """Least lead of the helix on the input pulleys: turns side by side, or grooves with crests between them."""
    d = drive.cable.diameter_mm
    return dims.GROOVE_LEAD * dims.GROOVE_RADIUS * d if drive.input_pulleys.grooved else d


@dataclass(frozen=True)
class _Wound:
    """One cable on its pulley, in the frame of the part."""

    cable: BevelRun
    band: Band
    stop: dims.StopGeometry
    wound_rad: float  # what it winds at most


def _wound(drive: BevelDrive, name: str) -> tuple[_Wound, _Wound]:
    """The cables of the input ``name``, the one towards its gearhead first."""
    found = []
    for cable in sorted((c for c in drive.cables if c.input_name == name), key=lambda c: c.step):
        on_pulley, stop = band(drive, cable), stop_of(drive, cable)
        if drive.motors_above:
            on_pulley = Band(-on_pulley.high_mm, -on_pulley.low_mm, -on_pulley.dead_end_mm)
            stop = replace(stop, end_angle_rad=pi - stop.end_angle_rad, away=-stop.away)
        wound = tau * drive.dead_turns + 2 * winding(drive, cable).reduction * radians(drive.half_travel_deg)
        found.append(_Wound(cable, on_pulley, stop, wound))
    low, high = reversed(found) if drive.motors_above else found
    return low, high


def input_pulley(drive: BevelDrive, in_assembly: Stack, name: str) -> dims.InputPulleyDims:
    """Dimensions of the input pulley called ``name``; its place is that in the assembly."""
    low, high = _wound(drive, name)
    levels = in_assembly.from_gearhead
    flank = drive.cable.diameter_mm / 2
    bearings = drive.bearings
    beyond = dims.helix_stop_land_mm(drive)
    land_bottom = low.band.low_mm - beyond
    land_top = high.band.high_mm + beyond
    slots = tuple(
        dims.stop_slot(drive, w.cable.name, w.cable.input_radius_mm, w.stop, w.band.dead_end_mm, face)
        for w, face in ((low, land_bottom), (high, land_top))
    )
    grooves = tuple(
        dims.anchored_groove(drive, slot, w.stop, w.wound_rad)
        for w, slot in zip((low, high), slots, strict=True)
        if drive.input_pulleys.grooved
    )
    return coupled_pulley(
        drive,
        levels,
        name=name,
        x=low.cable.input_side * drive.input_x_mm,
        y=drive.input_y_mm,
        lower_neck_radius=dims.neck_radius_mm(bearings.input_lower.inner_shoulder_mm, low.stop),
        land_bottom_z=land_bottom,
        lower_surface_radius=low.cable.input_radius_mm - flank,
        wall_z=(low.band.high_mm + high.band.low_mm) / 2,
        upper_surface_radius=high.cable.input_radius_mm - flank,
        land_top_z=land_top,
        upper_neck_radius=dims.neck_radius_mm(bearings.input_upper.inner_shoulder_mm, high.stop),
        slots=slots,
        grooves=grooves,
    )


STOP_PIN_WALL_MM = 1.5


def stop_pin_z(drive: BevelDrive, levels: Stack) -> float:
    """Height of the stop pin: low in the web between the shelves, with metal below it."""
    return levels.shelf_bottom_z + drive.drum.stop_pin_mm / 2 + STOP_PIN_WALL_MM
