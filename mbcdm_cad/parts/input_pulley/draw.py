"""Input pulley: two steps, smooth or grooved, journals for bearings and encoder, slit bore for the gearhead's shaft."""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from math import ceil, cos, degrees, pi, radians, sin, sqrt, tau

from mbcdm_cad.parts.input_pulley.dims import (
    CHAMFER_MM,
    SET_SCREWS_DEG,
    STOP_PLAY_MM,
    Groove,
    InputPulleyDims,
    StopSlot,
)
from mbcdm_cad.parts.milled import Point2, block, cut, cylinder, cylinder_z, fuse, one_solid, turned
from mbcdm_cad.parts.part import cq
from mbcdm_cad.parts.rod import edge_of


@dataclass(frozen=True)
class InputLand:
    """A cylinder that cables are wound on."""

    radius: float
    bottom_z: float
    top_z: float


# The tool of a groove extends beyond the land by this share of its depth, so that no edge of it lies on the surface.
_BEYOND_DEPTHS = 0.13
# Longest piece of a groove that is one face, in turns; the second is tried if the first fails. Longer faces are drawn
# faster, but a face of six turns takes the kernel up to a minute to test against the others.
_PIECE_TURNS = (2.5, 1.0)
# Allowed difference between the cut volume and that of the groove: more than rounding, less than a turn.
_GROOVE_SHARE = 0.04


def _below(d: InputPulleyDims) -> list[Point2]:
    """Half the outline of what is below the lands, from the axis to the lands."""
    c, r, low = CHAMFER_MM, d.lower_journal_radius, d.journal_bottom_z
    foot = [(0.0, low), (r - c, low), (r, low + c)]
    if d.hub is not None:
        return [*foot, (r, d.land_bottom_z)]
    neck, start = d.lower_neck_radius, d.lower_neck_bottom_z
    return [*foot, (r, start), (neck, start), (neck, d.land_bottom_z)]


def _above(d: InputPulleyDims) -> list[Point2]:
    """Half the outline of what is above the lands, from the lands to the axis."""
    c = CHAMFER_MM
    return [
        (d.upper_neck_radius, d.land_top_z),
        (d.upper_neck_radius, d.upper_neck_top_z),
        (d.upper_journal_radius, d.upper_neck_top_z),
        (d.upper_journal_radius, d.journal_top_z - c),
        (d.upper_journal_radius - c, d.journal_top_z),
        (0.0, d.journal_top_z),
    ]


def _lands(d: InputPulleyDims) -> list[InputLand]:
    """The two lands, or one where both have the same radius and a groove may run over both."""
    if d.lower_land_radius == d.upper_land_radius:
        return [InputLand(d.lower_land_radius, d.land_bottom_z, d.land_top_z)]
    return [
        InputLand(d.lower_land_radius, d.land_bottom_z, d.wall_z),
        InputLand(d.upper_land_radius, d.wall_z, d.land_top_z),
    ]


def _body(d: InputPulleyDims, rings: bool) -> cq.Solid:
    """The pulley without bore, slit and slots; with ``rings`` in place of its helical grooves.

    Grooves are cut into the plain cylinder of their land, which is then joined to the rest: the kernel takes less
    than half the time of a cut into the whole body, and that cut often fails.
    """
    name = f"input pulley {d.name}"
    lands, land_of = _lands(d), _ringed if rings else _grooved
    if d.hub is not None or d.horn is not None:
        below = turned([*_below(d), (0.0, d.land_bottom_z)], name)
        return fuse([below, *(land_of(land, d, name) for land in lands)], name)
    if not d.grooves:
        steps = [point for land in lands for point in ((land.radius, land.bottom_z), (land.radius, land.top_z))]
        return turned([*_below(d), *steps, *_above(d)], name)
    below = turned([*_below(d), (0.0, d.land_bottom_z)], name)
    above = turned([(0.0, d.land_top_z), *_above(d)], name)
    return fuse([below, *(land_of(land, d, name) for land in lands), above], name)


def _groove_tool(groove: Groove) -> cq.Solid:
    """Tool of a groove, swept along its helix: the arc of its floor, extended beyond the land, and the chord."""
    reach = groove.depth + _BEYOND_DEPTHS * groove.depth
    half = sqrt(2 * groove.radius * reach - reach**2)
    a = groove.start_angle_rad

    def at(height: float, along: float) -> cq.Vector:
        radius = groove.root_radius + height
        return cq.Vector(radius * cos(a), radius * sin(a), groove.start_z + along)

    profile = cq.Wire.assembleEdges(
        [
            cq.Edge.makeThreePointArc(at(reach, -half), at(0.0, 0.0), at(reach, half)),
            cq.Edge.makeLine(at(reach, half), at(reach, -half)),
        ]
    )
    middle = groove.root_radius + groove.radius
    path = cq.Wire.assembleEdges([cq.Edge(edge_of(groove.helix(middle)))])
    return one_solid(cq.Solid.sweep(profile, [], path, True, True, None, "right"), f"groove of {groove.cable_name}")


def _ringed(land: InputLand, dims: InputPulleyDims, name: str) -> cq.Solid:
    """A land as its section along X shows it: for each half a ring where a groove passes X, in place of the helix.

    The groove's profile lies in the plane of the axis, so this section is the true one; its hidden lines take no time.
    """
    up, halves = cq.Vector(0, 0, 1), []
    for angle in (0.0, pi):
        half = cq.Solid.makeCylinder(land.radius, land.top_z - land.bottom_z, cq.Vector(0, 0, land.bottom_z), up, 180.0)
        rings = [
            cq.Solid.makeTorus(groove.root_radius + groove.radius, groove.radius, cq.Vector(0, 0, z), up)
            for groove in _on(land, dims)
            for z in groove.crossings_z(angle)
        ]
        halves.append(cut(half.rotate(cq.Vector(0, 0, 0), up, degrees(angle) - 90.0), rings, name))
    return fuse(halves, name)


def _on(land: InputLand, dims: InputPulleyDims) -> list[Groove]:
    return [g for g in dims.grooves if land.bottom_z <= (g.start_z + g.end_z) / 2 <= land.top_z]


def _grooved(land: InputLand, dims: InputPulleyDims, name: str) -> cq.Solid:
    """A land with its grooves, each cut in short pieces, and in shorter ones if the kernel cuts those incompletely.

    Raises ValueError if none of these removes the volume that follows from the groove's cross section and length.
    """
    body = cylinder_z(land.radius, 0, 0, land.bottom_z, land.top_z)
    for groove in _on(land, dims):
        wanted = groove.volume_mm3
        for turns in _PIECE_TURNS:
            left = body
            # The kernel may also cut a groove through the whole land.
            with suppress(ValueError):
                for piece in _pieces(groove, turns):
                    left = cut(left, [_groove_tool(piece)], name)
            if abs(body.Volume() - left.Volume() - wanted) <= _GROOVE_SHARE * wanted:
                body = left
                break
        else:
            raise ValueError(f"{name}: the groove of {groove.cable_name} could not be cut")
    return body


def _pieces(groove: Groove, turns: float) -> Iterator[Groove]:
    """The groove in equal pieces of no more than ``turns``."""
    count = ceil(abs(groove.end_angle_rad - groove.start_angle_rad) / (tau * turns))
    angle, rise = (
        (end - start) / count
        for start, end in ((groove.start_angle_rad, groove.end_angle_rad), (groove.start_z, groove.end_z))
    )
    for k in range(count):
        yield replace(
            groove,
            start_angle_rad=groove.start_angle_rad + k * angle,
            end_angle_rad=groove.start_angle_rad + (k + 1) * angle,
            start_z=groove.start_z + k * rise,
            end_z=groove.start_z + (k + 1) * rise,
        )


def _slot_tools(slot: StopSlot, surface: float) -> list[cq.Solid]:
    """Milled from the end face: an arc bending inward from the land, a straight piece, the pocket of the stop."""
    a = slot.end_angle_rad
    half = slot.width / 2
    # Local axes in the plane of rotation: u along the radius at the winding's end, v the way the winding runs on.
    u = (cos(a), sin(a))
    v = (-slot.away * sin(a), slot.away * cos(a))
    floor = slot.end_z + (half if slot.face_z < slot.end_z else -half)
    beyond = slot.face_z + (-1.0 if slot.face_z < slot.end_z else 1.0)

    def at(along_u: float, along_v: float) -> cq.Vector:
        return cq.Vector(along_u * u[0] + along_v * v[0], along_u * u[1] + along_v * v[1], floor)

    rho, centre = slot.bend_radius, slot.pitch_radius - slot.bend_radius

    def arc(radius: float, deg: float) -> cq.Vector:
        return at(centre + radius * cos(radians(deg)), radius * sin(radians(deg)))

    inner, outer = rho - half, rho + half
    # The straight piece reaches into the pocket, also where the pocket is near the bend.
    stem = max(0.0, slot.stop_end)
    band = cq.Wire.assembleEdges(
        [
            cq.Edge.makeThreePointArc(arc(inner, 0), arc(inner, 45), arc(inner, 90)),
            cq.Edge.makeLine(arc(inner, 90), at(stem, inner)),
            cq.Edge.makeLine(at(stem, inner), at(stem, outer)),
            cq.Edge.makeLine(at(stem, outer), arc(outer, 90)),
            cq.Edge.makeThreePointArc(arc(outer, 90), arc(outer, 45), arc(outer, 0)),
            cq.Edge.makeLine(arc(outer, 0), arc(inner, 0)),
        ]
    )
    opened = slot.open_deg(surface)
    reach = 2 * outer
    wedge = cq.Wire.assembleEdges(
        [
            cq.Edge.makeThreePointArc(arc(rho, 0), arc(rho, opened / 2), arc(rho, opened)),
            cq.Edge.makeLine(arc(rho, opened), arc(reach, opened)),
            cq.Edge.makeLine(arc(reach, opened), arc(reach, 0)),
            cq.Edge.makeLine(arc(reach, 0), arc(rho, 0)),
        ]
    )
    r = slot.stop_radius + STOP_PLAY_MM
    ends, sides = (slot.stop_end - STOP_PLAY_MM, slot.stop_start + STOP_PLAY_MM), (rho - r, rho + r)
    corners = [at(ends[0], sides[0]), at(ends[1], sides[0]), at(ends[1], sides[1]), at(ends[0], sides[1])]
    depth = cq.Vector(0, 0, beyond - floor)
    # The pocket is deeper than the slot, as the stop is thicker than the cable.
    deeper = cq.Vector(0, 0, (slot.chord_z + (r if slot.face_z < slot.end_z else -r)) - floor)
    pocket = cq.Wire.makePolygon([p + deeper for p in corners], close=True)
    cutter = slot.cutter_radius
    inset = cutter / sqrt(2)
    reliefs = [
        cq.Wire.makeCircle(cutter, at(x + dx * inset, y + dy * inset) + deeper, cq.Vector(0, 0, 1))
        for x, dx in zip(ends, (1, -1), strict=True)
        for y, dy in zip(sides, (1, -1), strict=True)
    ]
    return [
        fuse([cq.Solid.extrudeLinear(outline, [], depth) for outline in (band, wedge)], "slot"),
        fuse([cq.Solid.extrudeLinear(outline, [], depth - deeper) for outline in (pocket, *reliefs)], "pocket"),
    ]


def create_input_pulley(dims: InputPulleyDims, rings: bool = False) -> cq.Solid:
    """Input pulley about its own axis (x = y = 0), heights as in the assembly, turned as with the drum centred.

    With ``rings`` as the views of its sheet show it.
    """
    body = _body(dims, rings)
    tools: list[cq.Shape] = []
    reach = dims.lower_journal_radius + 1.0
    if dims.bore_radius > 0.0:
        bore_top = dims.bore_top_z + (1.0 if dims.bore_top_z == dims.journal_top_z else 0.0)
        tools.append(cylinder_z(dims.bore_radius, 0, 0, dims.journal_bottom_z - 1.0, bore_top))
    if dims.horn is not None:
        low, high = dims.journal_bottom_z - 1.0, dims.lower_neck_bottom_z + 1.0
        tools += [cylinder_z(dims.horn.clearance, x, y, low, high) for x, y in dims.horn.places]
    elif dims.hub is not None:
        for a in map(radians, SET_SCREWS_DEG):
            at = (0.0, 0.0, dims.hub.screw_z)
            tools.append(cylinder(dims.hub.thread / 2, at, (round(cos(a), 9), round(sin(a), 9), 0.0), reach))
    elif dims.bore_radius > 0.0:
        half = dims.slit_width / 2
        tools.append(block((-reach, reach), (-half, half), (dims.journal_bottom_z - 1.0, dims.slit_top_z)))
    for slot in dims.slots:
        lower = slot.face_z == dims.land_bottom_z
        tools += _slot_tools(slot, dims.lower_land_radius if lower else dims.upper_land_radius)
    return cut(body, tools, f"input pulley {dims.name}") if tools else body
