"""Input pulley, its stops and its coupling: bores, walls, and room for the parts on and around it."""

from mbcdm_cad.checks.bearings import carried_check, coupled_check
from mbcdm_cad.checks.comparison import Comparison, Findings, at_least, at_most, check, noted
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.checks.ratios import GENTLER
from mbcdm_cad.design.paths import at
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.parts.coupling import collar_width_mm
from mbcdm_cad.parts.input_pulley.dims import ENCODER_INSERTION_MM, STOP_PLAY_MM, InputPulleyDims, StopSlot

# Height of the shoulder for an inner ring: the bearing's fillet of 0.15 mm and a contact face.
SHOULDER_MM = 0.3
# Bore and shaft must have the same nominal size.
FIT_MM = 0.01
# Metal left behind a blind hole (estimate).
FLOOR_MM = 1.0
# Shaft held by a clamp over at least its own diameter (usual rule).
GRIP_DIAMETERS = 1.0
# Turns left on the pulley when all is unwound: the span never pulls at the bend before the stop (estimate).
DEAD_TURNS = 0.5
# Clearance for a part during assembly (estimate).
PASSAGE_MM = 0.1
# What makes the input pulleys larger, or the rope thinner, under the names that it has in the layouts.
_WIDER = (*up(at.transmission.input_radii_mm), *GENTLER)
_CHOOSE = "choose another input_pulleys.lower_bearing or drive.gearhead, or an input_pulleys.material of thinner walls"


def _slots(s: SectorLayout) -> list[tuple[InputPulleyDims, StopSlot, float]]:
    """(pulley, slot, surface radius of the land round it)."""
    return [(p, slot, slot.pitch_radius - s.flank_mm) for p in s.inputs for slot in p.slots]


@check("Dead turns protect the stop", "half a turn: estimate")
def dead_turns(s: SectorLayout) -> Comparison:
    """Number of turns that stay on the input pulley at the unwound end of the travel."""
    return at_least("dead turns on the input pulleys", s.drive.dead_turns, DEAD_TURNS, "turns")


def _of_thinner_walls(s: SectorLayout) -> str:
    """Advice to choose steel or brass, if the pulleys are of a material that needs thicker walls."""
    own, steel = s.drive.pulley_material, s.drive.material("steel")
    return "choose steel or brass for input_pulleys.material" if own.min_wall_mm > steel.min_wall_mm else ""


@check("Wall outside the stops' pockets", "material: min_wall_mm", *_WIDER, advice=_of_thinner_walls)
def stop_pocket_wall(s: SectorLayout) -> Findings:
    """Wall between the corner of a stop's pocket and the surface of the land."""
    limit = s.drive.pulley_material.min_wall_mm
    for _, slot, surface in _slots(s):
        yield f"wall outside the stop of {slot.cable_name}", surface - slot.pocket_reach, limit


@check(
    "Metal between the stops' pockets",
    "material: min_wall_mm",
    *up(at.rope.helix_lead_mm, at.rope.dead_turns, "all radii of transmission"),
)
def stop_pocket_floor(s: SectorLayout) -> Findings:
    """Wall between the pockets that are milled from both end faces of a pulley."""
    limit = s.drive.pulley_material.min_wall_mm
    for p in s.inputs:
        low, high = sorted(p.slots, key=lambda slot: slot.face_z)
        deep = low.stop_radius + STOP_PLAY_MM
        yield f"metal between the stops of {p.name}", high.chord_z - deep - (low.chord_z + deep), limit


@check("Metal between stops and shaft bore", "material: min_wall_mm", *_WIDER)
def stop_pocket_bore(s: SectorLayout) -> Findings:
    """Wall between a stop's pocket and the bore for the gearhead's shaft, or between the pockets and the bore's end."""
    limit = s.drive.pulley_material.min_wall_mm
    for p, slot, _ in _slots(s):
        beside = slot.pocket_inner - p.bore_radius
        below = min(slot.face_z, slot.chord_z - slot.stop_radius) - p.bore_top_z
        yield f"stop of {slot.cable_name} from the shaft's bore", max(beside, below), limit


@coupled_check("Journal's wall round the gearhead's shaft", "material: min_wall_mm", advice=_CHOOSE)
def bore_wall(s: SectorLayout) -> Findings:
    """Wall of the slit journal round the gearhead's shaft."""
    p = s.inputs[0]
    limit = s.drive.pulley_material.min_wall_mm
    yield f"journal's wall round the {s.drive.mounted}'s shaft", p.lower_journal_radius - p.bore_radius, limit


@carried_check(
    "Shoulders for the input pulleys' bearings",
    "bearing catalogue; 0.3 mm: estimate",
    *_WIDER,
    advice="choose a smaller input_pulleys.lower_bearing or upper_bearing",
)
def bearing_shoulders(s: SectorLayout) -> Findings:
    """The necks are higher than the journals, so that the bearings' inner rings rest on them."""
    for p in s.inputs:
        for end, neck, journal in (
            ("lower", p.lower_neck_radius, p.lower_journal_radius),
            ("upper", p.upper_neck_radius, p.upper_journal_radius),
        ):
            yield f"{end} neck of {p.name} over its journal", neck - journal, SHOULDER_MM


@check(
    "Encoders fit their shafts",
    "encoder and bearing catalogue",
    advice="choose drive.encoder and input_pulleys.upper_bearing, or drive.drum_encoder and drum.bearing, of one bore",
    none=noted("no encoder: bore", 0.0, "mm"),
)
def encoder_fit(s: SectorLayout) -> Findings:
    """The bore of each encoder equals the diameter of the shaft that it sits on."""
    drive = s.drive
    pairs = (
        ("input encoder's bore from the upper journal", drive.encoder, drive.bearings.input_upper),
        ("drum encoder's bore from the drum's shaft", drive.drum_encoder, drive.bearings.drum),
    )
    for name, encoder, bearing in pairs:
        if not encoder.absent:
            yield at_most(name, abs(encoder.bore_mm - bearing.bore_mm), FIT_MM, "mm")


@check(
    "Bought parts are deep enough for their holes",
    "catalogue; 1 mm: estimate",
    *up(at.support.motor_shelf_mm, at.support.top_plate_mm),
    advice="choose a drive.gearhead or drive.encoder with a shorter screw",
    none=noted("no threaded holes in bought parts: depth", 0.0, "mm"),
)
def bought_depth(s: SectorLayout) -> Findings:
    """Material behind the threaded holes that the drive uses in bought parts."""
    drive = s.drive
    gear_screw, encoder_screw = drive.screw(drive.gearhead.screw), drive.screw(drive.encoder.screw)
    ring_screw = drive.screw(drive.drum_encoder.screw)
    in_gear = gear_screw.length_mm - s.motor_shelf_mm + 1.0
    in_encoder = encoder_screw.length_mm - (s.encoder_plate_mm - encoder_screw.head_height_mm - 0.2) + 0.5
    grip = ring_screw.length_mm - s.frame.boss.screw_depth + 0.5
    if drive.servo is None:
        yield f"{drive.mounted} behind its screws", drive.face_depth_mm - in_gear, FLOOR_MM
    if not drive.encoder.absent:
        above = drive.encoder.length_mm - ENCODER_INSERTION_MM - 0.5
        yield "encoder above its screws", drive.encoder.length_mm - in_encoder, FLOOR_MM
        yield "encoder above its shaft", above, FLOOR_MM / 2
    if not drive.drum_encoder.absent:
        over = drive.drum_encoder.length_mm - grip - ring_screw.head_height_mm
        yield "drum encoder over its screws' heads", over, 0.0


@carried_check(
    "Clamp collar grips the gearhead's shaft",
    "one diameter: usual rule",
    *down(at.support.motor_shelf_mm),
    advice="choose a drive.gearhead with a longer shaft",
)
def shaft_grip(s: SectorLayout) -> Findings:
    """Length over which the collar clamps journal and shaft."""
    gear, stage = s.drive.gearhead, s.stage
    end = s.input_levels.motor_shelf_bottom_z + gear.shaft_length_mm
    if stage is not None:
        what = f"{s.drive.mounted} shaft inside its {'pulley' if stage.stage.is_belt else 'gear'}"
        yield what, min(end, stage.top_z) - stage.bottom_z, GRIP_DIAMETERS * gear.shaft_diameter_mm
        return
    start = max(s.collar.bottom_z, max(p.journal_bottom_z for p in s.inputs))
    yield (
        f"{s.drive.mounted} shaft inside the clamp collar",
        min(end, s.collar.top_z) - start,
        GRIP_DIAMETERS * gear.shaft_diameter_mm,
    )


@carried_check("Gearhead's pilot clears pulley and screws", at.clearances.running_mm, *up(at.support.motor_shelf_mm))
def pilot_room(s: SectorLayout) -> Findings:
    """Gap between the gearhead's centring boss and the pulley's journal, the shelf and the screws' heads."""
    gear, running = s.drive.gearhead, s.drive.clearances.running_mm
    top = s.input_levels.motor_shelf_bottom_z + gear.pilot_height_mm
    bottom = min(p.journal_bottom_z for p in s.inputs)
    head = s.drive.screw(gear.screw).head_diameter_mm
    beside = (gear.bolt_circle_mm - head - gear.pilot_diameter_mm) / 2
    inside = s.motor_shelf_mm - gear.pilot_height_mm
    yield f"journal above the {s.drive.mounted}'s pilot", bottom - top, running
    yield f"{s.drive.mounted}'s pilot under the shelf's top, or beside the screws' heads", max(inside, beside), 0.0


@carried_check(
    "Coupling space is high enough",
    "clearances.running_mm; 0.1 mm: estimate",
    *up(at.support.coupling_space_mm, at.support.motor_shelf_mm),
)
def coupling_height(s: SectorLayout) -> Findings:
    """The coupling space has room for collar and slit below the bearing, and to insert gearhead screws and collar."""
    v, drive = s.input_levels, s.drive
    shaft_end = v.motor_shelf_bottom_z + drive.gearhead.shaft_length_mm
    screw = drive.screw(drive.gearhead.screw)
    bearing_bottom = v.bearing_shelf_top_z - drive.bearings.input_lower.width_mm
    gap, slit_top = drive.clearances.running_mm, max(p.slit_top_z for p in s.inputs)
    space = v.bearing_shelf_bottom_z - v.motor_shelf_top_z
    if s.stage is not None:
        yield "bearing shelf above the driven wheel's hub", v.bearing_shelf_bottom_z - s.stage.hub_top_z, gap
        yield f"bearing shelf above the end of the {drive.mounted}'s shaft", v.bearing_shelf_bottom_z - shaft_end, gap
        return
    yield "bearing shelf above the clamp collar", v.bearing_shelf_bottom_z - s.collar.top_z, gap
    yield "lower bearing above the journal's slit", bearing_bottom - slit_top, gap
    what = f"coupling space beyond the length of a {screw.name} with its head"
    yield what, space - screw.length_mm - screw.head_height_mm, gap
    yield (
        f"coupling space for the clamp collar on its way over the end of the {drive.mounted}'s shaft",
        v.bearing_shelf_bottom_z - max(shaft_end, v.motor_shelf_top_z) - collar_width_mm(drive),
        PASSAGE_MM,
    )


STOPS = (stop_pocket_wall, stop_pocket_floor, stop_pocket_bore)
# Of a pulley without stops: journals, bearings, encoder and coupling.
COUPLING = (bore_wall, bearing_shoulders, encoder_fit, bought_depth, shaft_grip, pilot_room, coupling_height)
CHECKS = (*STOPS, *COUPLING)
