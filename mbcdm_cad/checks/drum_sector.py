"""Drum sector: rim, web, hub, and the slot that the stop pin runs in."""

from math import asin, degrees, radians

from mbcdm_cad.checks.comparison import TOLERANCE, Comparison, Findings, at_least, at_most, check, check_for, worst
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.design.paths import at
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.parts.drum_sector.sizes import SLOT_WALLS

# Rim under a pocket's floor, in multiples of the thinnest wall: it carries the root of the lug (estimate).
RIM_WALLS = 1.5
# Hub over the shaft's diameter (usual: 1 to 1.5). A wide ring is guided by its face, so that no hub must be longer than
# HUB_MOST_MM (estimate).
HUB_DIAMETERS, HUB_MOST_MM = 1.0, 20.0
# Largest angle beyond the travel at which the stops may engage (the paper's stops are between 35.0 and 35.5 degrees).
STOP_WINDOW_DEG = 0.5
# Shafts of this diameter or more are thick enough for the set screws of any hub.
THIN_SHAFT_MM = 5.0
# Height of the spigot over the shaft, so that it rests on the bearing's inner ring.
SPIGOT_MM = 0.3
_WALL = "material: min_wall_mm"
stop_check = check_for(lambda drive: drive.stopped)


@check("Rim under pockets and lands", _WALL + " x 1.5: estimate", *down(at.drum.rim_inner_radius_mm))
def rim_height(s: SectorLayout) -> Comparison:
    """Height of the rim below the deepest pocket and the smallest land."""
    d = s.drum
    floors = [(f"pocket of {t.cable_name}", t.radius_mm - d.nut_pocket) for t in d.tensioners]
    floors += [(f"lug of {t.cable_name}", t.radius_mm - d.lug_root(t)) for t in d.tensioners]
    floors.append(("land of step 1", d.lands[0].surface_radius_mm))
    limit = RIM_WALLS * s.drive.drum_material.min_wall_mm
    return worst(at_least(f"rim under the {name}", floor - d.rim_inner_radius, limit, "mm") for name, floor in floors)


@check(
    "Web lies within the rim",
    _WALL,
    *up(at.drum.outer_face_y_mm),
    *down(at.drum.web_thickness_mm),
    *up(at.drum.web_thickness_mm),
)
def web_in_rim(s: SectorLayout) -> Findings:
    """The web lies within the width of the rim and is at least as thick as the material allows."""
    d = s.drum
    yield "rim's outer face beyond the web", s.drive.drum.outer_face_y_mm - d.web_end_y, 0.0
    yield "web's thickness over the thinnest wall", d.web_end_y - d.web_start_y - s.drive.drum_material.min_wall_mm, 0.0


@check(
    "Every land is half a cable wide",
    "derived",
    *down(at.clearances.land_edge_mm),
    *up("all radii of transmission", at.drum.outer_face_y_mm),
)
def land_thickness(s: SectorLayout) -> Findings:
    """Width of every land along y, at least half a cable."""
    for land in s.drum.lands:
        yield f"width of the land of step {land.step}", land.y_end - land.y_start, s.flank_mm


@check("Hub's walls round threads and screws", _WALL, *up(at.drum.hub_diameter_mm))
def hub_walls(s: SectorLayout) -> Findings:
    """Walls of the hub round the payload's threads and round the threads of its set screws."""
    d = s.drum
    screw = s.drive.screw(d.set_screw)
    insert = d.payload_insert
    what = "inserts" if insert else "threads"
    least = insert.wall_mm if insert else s.drive.drum_material.min_wall_mm
    beside = min(d.hub_radius - d.payload_circle_radius, d.payload_circle_radius - d.bore_radius) - d.payload_hole / 2
    yield f"wall beside the payload's {what}", beside, least
    yield "hub outside the set screws", d.hub_radius - d.set_screw_radius - screw.length_mm, 0.0


@check(
    "Hub is long enough", "usual rule: one shaft diameter", *up(at.drum.hub_face_y_mm), *down(at.drum.web_thickness_mm)
)
def hub_length(s: SectorLayout) -> Findings:
    """The hub holds the shaft over at least one diameter, and has room for the set screws in front of the web.

    Where more than four of the payload's screws come near the set screws, these stand behind their holes.
    """
    d = s.drum
    screw = s.drive.screw(d.set_screw)
    beyond = d.hub_face_y - d.web_end_y
    behind = (d.web_end_y + d.hub_face_y) / 2 - d.set_screw_y
    where = " behind the payload's holes" if behind > 0.0 else ""
    least = min(HUB_DIAMETERS * 2 * d.bore_radius, HUB_MOST_MM)
    over = "the shaft's diameter" if least < HUB_MOST_MM else f"{HUB_MOST_MM:g} mm"
    yield f"hub's length over {over}", d.hub_face_y - d.hub_start_y - least, 0.0
    what = f"hub beyond the web, over set screws{where} and walls"
    yield what, beyond - 2 * behind - screw.thread_mm - 2 * s.drive.drum_material.min_wall_mm, 0.0
    yield "hub beyond the web, over the payload's threads", beyond - d.payload_depth, 0.0


@check(
    "Hub bears on the front bearing",
    "bearing catalogue; 0.3 mm: estimate; material: min_wall_mm",
    *up(at.drum.hub_diameter_mm),
    advice="choose another drum.bearing",
)
def hub_spigot(s: SectorLayout) -> Findings:
    """The spigot presses on the inner ring of the front bearing only, and stays inside the hub.

    A printed one widens towards the hub up to the thinnest wall of its material.
    """
    d, drum = s.drum, s.drive.drum_material
    yield "hub's spigot over the shaft", d.spigot_radius - d.bore_radius, SPIGOT_MM
    yield "hub over its spigot", d.hub_radius - d.spigot_radius, SPIGOT_MM
    if drum.printed:
        yield "wall of the printed spigot, at the hub", d.spigot_root_radius - d.bore_radius, drum.min_wall_mm


@check(
    "Hub's set screws do not meet in the shaft",
    "derived",
    advice="choose a larger drum.bearing",
    applies=lambda drive: drive.bearings.drum.bore_mm < THIN_SHAFT_MM,
)
def set_screw_tips(s: SectorLayout) -> Comparison:
    """The two set screws, at right angles to each other, do not meet in a thin shaft."""
    screw = s.drive.screw(s.drum.set_screw)
    gap = s.drum.set_screw_radius - screw.thread_mm / 2
    return at_least("end of a set screw from the side of the other", gap, 0.0, "mm")


def _wider_bearing(s: SectorLayout) -> str:
    """The lightest bearing of the package in whose bore a shaft with this bore and its wall fits.

    Where a ring encoder sits on the shaft, one that has a ring of its bore; if there is none, a drive without a ring.
    """
    least = 2.0 * (s.drum_shaft.bore_radius + s.drive.shaft_material.min_wall_mm)
    fitting = {
        name: entry for name, entry in package_entries("bearings").items() if entry["bore_mm"] >= least - TOLERANCE
    }
    rings = {entry["bore_mm"] for name, entry in package_entries("encoders").items() if "ring" in name}
    with_ring = {name: entry for name, entry in fitting.items() if entry["bore_mm"] in rings}
    found = fitting if s.drive.drum_encoder.absent else with_ring
    if found:
        lightest = min(found, key=lambda name: (found[name]["mass_g"], name))
        return f"choose a drum.bearing of {least:.4g} mm bore or more (such as {lightest})"
    if fitting:
        return f"set drive.drum_encoder to none (no ring encoder has a bore of {least:.4g} mm or more; spur layouts)"
    return ""


@check("Wall of the drum shaft", _WALL, *down(at.drum.shaft_bore_mm), advice=_wider_bearing)
def shaft_wall(s: SectorLayout) -> Findings:
    """Wall thickness of the hollow drum shaft."""
    shaft = s.drum_shaft
    yield "wall of the drum shaft", shaft.radius - shaft.bore_radius, s.drive.shaft_material.min_wall_mm


def _larger_drum(s: SectorLayout) -> str:
    """The drum in which a hub as wide as this one leaves the slot its room."""
    d = s.drum
    room = d.stop_slot_width + 2.0 * SLOT_WALLS * s.drive.drum_material.min_wall_mm
    least = d.hub_radius + room + s.steps[0].drum_radius_mm - d.rim_inner_radius
    if least <= s.steps[0].drum_radius_mm:
        return ""
    return f"choose a drum of {least:.4g} mm radius or more, for its hub of {2 * d.hub_radius:g} mm"


@stop_check(
    "Stop slot lies in the web",
    _WALL + " x 2: estimate",
    *up(at.drum.rim_inner_radius_mm),
    *down(at.drum.hub_diameter_mm),
    *up(at.drum.sector_half_angle_deg),
    *down(at.travel.half_angle_deg, at.travel.stop_clearance_deg, at.support.coupling_space_mm),
    advice=_larger_drum,
)
def stop_slot(s: SectorLayout) -> Findings:
    """The slot for the stop pin lies in the web between hub and rim, inside the ends of the sector."""
    d = s.drum
    half, limit = d.stop_slot_width / 2, SLOT_WALLS * s.drive.drum_material.min_wall_mm
    if d.stop_radius <= 0.0:
        raise NoFigureError("the stop pin would lie beyond the drum's axis: a larger drum makes room for it")
    end = d.stop_slot_end_deg + degrees(asin(min(1.0, half / d.stop_radius)))
    # A rim beyond the lands holds nothing.
    outer = min(d.rim_inner_radius, d.lands[0].surface_radius_mm)
    yield "web between stop slot and rim", outer - d.stop_radius - half, limit
    yield "web between stop slot and hub", d.stop_radius - half - d.hub_radius, limit
    what = "web between both ends of the stop slot" if d.whole else "web between stop slot and the sector's end"
    yield what, radians(d.half_angle_deg - end) * (d.stop_radius - half) * (2.0 if d.whole else 1.0), limit


def _stop_angle_deg(s: SectorLayout) -> float:
    """Drum angle at which the pin meets the slot's end, beyond the travel."""
    d = s.drum
    play = d.stop_slot_width / 2 - s.frame.stop_pin_radius
    return float(d.stop_slot_end_deg + degrees(play / d.stop_radius) - s.drive.half_travel_deg)


@stop_check("Stops engage after the travel", "derived", *up(at.travel.stop_clearance_deg))
def stop_after_travel(s: SectorLayout) -> Comparison:
    """Angle between the end of the travel and the stop: not less than zero."""
    return at_least("stops engage beyond the travel by", _stop_angle_deg(s), 0.0, "deg")


@stop_check(
    "Stops engage within half a degree",
    "derived: the reference's 35.0 to 35.5 deg",
    *down(at.travel.stop_clearance_deg),
)
def stop_within_half_degree(s: SectorLayout) -> Comparison:
    """Angle between the end of the travel and the stop: at most half a degree."""
    return at_most("stops engage beyond the travel by", _stop_angle_deg(s), STOP_WINDOW_DEG, "deg")
