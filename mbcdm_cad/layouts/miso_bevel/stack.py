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
from math import radians, sqrt

from mbcdm_cad.layouts.miso_bevel.cable_path import axial_walk_mm, guide_landing_walk_mm
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive, BevelRun
from mbcdm_cad.layouts.miso_bevel.plate_screws import Edges, beside_box_mm
from mbcdm_cad.parts.coupling import collar_sweep_mm
from mbcdm_cad.parts.drum_sector.design import END_PLAY_MM, SHELF_GAP_MM, InputLevels
from mbcdm_cad.parts.drum_sector.sizes import terminal_half_mm
from mbcdm_cad.parts.input_pulley.dims import helix_stop_land_mm
from mbcdm_cad.parts.motor_head.dims import TOOL_SLENDERNESS

# Land of the guide beyond the flank of the outermost cable at its widest walk.
GUIDE_MARGIN_MM = 0.8


@dataclass(frozen=True)
class Band:
    """Heights a cable covers on its input pulley: ``low`` and ``high`` to the flanks, ``dead_end`` at the last turn."""

    low_mm: float
    high_mm: float
    dead_end_mm: float


def band(drive: BevelDrive, cable: BevelRun, outward: int) -> Band:
    """Band of one cable on its input pulley: +-walk about the step plane, dead turns on the outward side."""
    walk = abs(axial_walk_mm(drive, cable, radians(drive.half_travel_deg)))
    flank = drive.cable.diameter_mm / 2
    dead_end = cable.drum_radius_mm + outward * (walk + drive.dead_turns * drive.helix_lead_mm)
    other = cable.drum_radius_mm - outward * walk
    return Band(min(dead_end, other) - flank, max(dead_end, other) + flank, dead_end)


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
        return replace(
            self,
            motor_bottom_z=-self.motor_top_z,
            motor_top_z=-self.motor_bottom_z,
            gearhead_bottom_z=-self.gearhead_top_z,
            gearhead_top_z=-self.gearhead_bottom_z,
            motor_shelf_bottom_z=-self.motor_shelf_top_z,
            motor_shelf_top_z=-self.motor_shelf_bottom_z,
            bearing_shelf_bottom_z=-self.top_plate_top_z,
            bearing_shelf_top_z=-self.top_plate_bottom_z,
            guide_bottom_z=-self.guide_top_z,
            guide_top_z=-self.guide_bottom_z,
            top_plate_bottom_z=-self.bearing_shelf_top_z,
            top_plate_top_z=-self.bearing_shelf_bottom_z,
            encoder_bottom_z=-self.encoder_top_z,
            encoder_top_z=-self.encoder_bottom_z,
            pocket_floor_z=-self.pocket_floor_z,
        )

    @property
    def height_mm(self) -> float:
        """Box along Z of drives and encoders."""
        return max(self.encoder_top_z, self.motor_top_z) - min(self.encoder_bottom_z, self.motor_bottom_z)

    @property
    def depth_mm(self) -> float:
        """Box along Y from the back of the frame to the hub's face."""
        return self.hub_face_y - self.back_y


def outward_of(drive: BevelDrive, cable: BevelRun) -> int:
    """+1 if this cable's dead turn lies above its step plane: the upper step of a pulley winds up, the lower down."""
    steps = [c.step for c in drive.cables if c.input_name == cable.input_name]
    return 1 if cable.step == max(steps) else -1


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
    bands = {c.name: band(drive, c, outward_of(drive, c)) for c in drive.cables}
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
    low_steps = [c for c in drive.cables if outward_of(drive, c) < 0]
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
    s, gear, motor = drive.support, drive.gearhead.length_mm, drive.motor.length_mm
    bearing_bottom, plate_top = between
    if drive.motors_above:
        shelf_bottom = plate_top + s.coupling_space_mm
        face = shelf_bottom + s.motor_shelf_mm
        return {
            "motor_bottom_z": face + gear,
            "motor_top_z": face + gear + motor,
            "gearhead_bottom_z": face,
            "gearhead_top_z": face + gear,
            "motor_shelf_bottom_z": shelf_bottom,
            "motor_shelf_top_z": face,
            "encoder_bottom_z": bearing_bottom - drive.encoder.length_mm,
            "encoder_top_z": bearing_bottom,
            "pocket_floor_z": bearing_bottom - drive.encoder.length_mm - drive.clearances.running_mm,
        }
    shelf_top = bearing_bottom - s.coupling_space_mm
    face = shelf_top - s.motor_shelf_mm
    return {
        "motor_bottom_z": face - gear - motor,
        "motor_top_z": face - gear,
        "gearhead_bottom_z": face - gear,
        "gearhead_top_z": face,
        "motor_shelf_bottom_z": face,
        "motor_shelf_top_z": shelf_top,
        "encoder_bottom_z": plate_top,
        "encoder_top_z": plate_top + drive.encoder.length_mm,
        "pocket_floor_z": shelf_top,
    }
