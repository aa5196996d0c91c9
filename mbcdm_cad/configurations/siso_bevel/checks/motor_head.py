"""Motor head: gearhead screws engaged and within reach, coupling collar with room to turn."""

from __future__ import annotations

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, at_most, worst
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.checks.geometry import corner_gap
from mbcdm_cad.configurations.siso_bevel.checks.support import HOLE_WEB_MM
from mbcdm_cad.configurations.siso_bevel.design_under_test import DirectUnderTest
from mbcdm_cad.parts.collar.dims import collar_sweep_mm

# The parts are drilled for this many screws, one on each side.
SCREWS_DRAWN = 2


def engagement(s: DirectUnderTest) -> Comparison:
    """Every screw is engaged over its own diameter at least."""
    drive, lay, f = s.drive, s.layout, s.layout.frame
    gear, encoder, ring = (drive.screw(item.screw) for item in (drive.gearhead, drive.encoder, drive.drum_encoder))
    hub, collar, c = drive.screw(lay.drum.set_screw), drive.screw(lay.collar.screw), lay.collar
    engaged = (
        ("gearhead screw", gear, gear.length_mm - drive.support.motor_shelf_mm),
        ("encoder screw", encoder, encoder.length_mm - (drive.support.encoder_shelf_mm - f.encoder_head_depth)),
        ("drum encoder's screw", ring, f.encoder_screw_depth - 0.5),
        ("hub's set screw", hub, min(hub.length_mm, lay.drum.hub_radius - lay.drum.set_screw_radius)),
        ("collar's screw", collar, collar.length_mm - c.head_seat - c.slit_width / 2),
    )
    return worst(
        at_least(f"engaged length of the {name} over its diameter", length - screw.thread_mm, 0.0, "mm")
        for name, screw, length in engaged
    )


def screw_counts(s: DirectUnderTest) -> Comparison:
    """Gearhead and encoders are held by the two screws that the parts are drilled for."""
    drive = s.drive
    items = (("gearhead", drive.gearhead), ("encoder", drive.encoder), ("drum encoder", drive.drum_encoder))
    return worst(
        at_most(f"screws of the {name}, off the two drilled", abs(item.screw_count - SCREWS_DRAWN), 0.0, "screws")
        for name, item in items
    )


def key_access(s: DirectUnderTest) -> Comparison:
    """Key holes for the gearhead's screws lie inside the bearing's seat, or clear of it."""
    h = s.layout.head
    inside = h.seat_radius - h.gear_bolt_circle - h.key_hole_radius
    outside = h.gear_bolt_circle - h.key_hole_radius - h.seat_radius - HOLE_WEB_MM
    return at_least("gearhead screws' key holes from the wall of the bearing's seat", max(inside, outside), 0.0, "mm")


def collar_space(s: DirectUnderTest) -> Comparison:
    """Collar and gearhead screws' heads stand clear of the coupling space's walls and rounded corners."""
    v, h, c, drive = s.levels, s.layout.head, s.layout.collar, s.drive
    reach = collar_sweep_mm(drive, *drive.collar_seat)
    head = h.gear_bolt_circle + drive.screw(drive.gearhead.screw).head_diameter_mm / 2
    corner = min(h.corner_radius, 0.49 * (v.bearing_shelf_bottom_z - v.motor_shelf_top_z))
    low = corner_gap(reach, c.bottom_z, v.head_inner_x, v.motor_shelf_top_z, corner)
    high = corner_gap(reach, -c.top_z, v.head_inner_x, -v.bearing_shelf_bottom_z, corner)
    return worst(
        at_least(name, gap, drive.clearances.running_mm, "mm")
        for name, gap in (
            ("clamp collar from walls and motor shelf", low),
            ("clamp collar from walls and bearing shelf", high),
            ("gearhead screws' heads from the corner", v.head_inner_x - corner - head),
        )
    )


CHECKS = (
    Check(
        "engagement",
        "Screws engage over their diameter",
        "usual rule: one diameter",
        engagement,
        adjust=(down("support.motor_shelf_mm"), up("drum.hub_diameter_mm")),
        advice="choose longer screws",
    ),
    Check(
        "screw_counts",
        "Gearhead and encoders have two screws",
        "the parts are drilled for two",
        screw_counts,
        advice="choose a gearhead and encoders held by two screws",
    ),
    Check(
        "key_access",
        "Key holes for the gearhead's screws",
        "derived: assembly order",
        key_access,
        advice="choose a larger input_pulleys.lower_bearing, or a gearhead of smaller bolt circle",
    ),
    Check(
        "collar_space",
        "Clamp collar turns freely",
        "clearances.running_mm",
        collar_space,
        adjust=(up("support.coupling_space_mm"),),
    ),
)
