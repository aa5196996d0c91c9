"""Dimensions of the drum sector: stepped lands, tensioners at both ends, web with the stop's slot, hub and shaft.

     y ->  8.75   9.45  10.05 10.65      13        lands of cables 1..4, each a step larger in radius
rim        |  1  |  2  |  3  |    4      |         walls at y_k+1 - edge margin: the edge of a land lies
web              |======|                          between a cable's flank and the next contact line
hub      |==============================......|    hub face: the output
"""

from math import asin, atan2, degrees, hypot, radians, sin, sqrt, tan

from mbcdm_cad.parts.drum_sector import dims
from mbcdm_cad.parts.drum_sector.design import InputLevels, SectorDrive, SectorRun
from mbcdm_cad.parts.terminal import Tensioner
from mbcdm_cad.parts.turned import FLAT_DEPTH_MM, DrumShaftDims, PreloadSpringDims

# Clamps the hub on the shaft, twice.
HUB_SCREW = "M3x5-set"
# Outside of the thicker web round the hub over the hub's; its distance from slot and set screws; least size worth it.
ROOT_SHARE, ROOT_GAP_MM, LEAST_ROOT_MM = 2.0, 0.5, 0.5
# Wave spring under the rear bearing's outer ring: height at its nominal force, play in the seat's bore, and force per
# mm of the bearing's bore (SKF: 5 to 10 N per mm keeps small bearings free of play and quiet).
SPRING_HEIGHT_MM = 0.6
SPRING_PLAY_MM = 0.15
SPRING_N_MM = 5.0
# Straight length of cable between the land's end and the swage.
SWAGE_START_MM = 0.5
# Solid end of the swage behind the cable's bore.
SWAGE_FLOOR_MM = 0.5
# Spigot between front bearing and hub.
SPIGOT_HEIGHT_MM = 0.5
# Swage to the pocket's corner with the terminal drawn in all the way.
END_GAP_MM = 0.1
# Play of the swage's flat at the pocket's inner wall, which keeps the terminal from turning with its nut.
FLAT_PLAY_MM = 0.1
# Wall of a lug beside the stud's hole.
LUG_WALL_MM = 0.75
# Stud and nuts must end this far before the sector's end face.
SECTOR_MARGIN_DEG = 0.6
# A floor under a pocket thinner than this is cut away.
MIN_FLOOR_MM = 1.0
# Edges nearer than this are a sliver.
SLIVER_MM = 0.02
# How far the tool of a pocket that is open to the outside reaches beyond the surface.
OPEN_MM = 0.05
# A wall behind a terminal, towards the sector's end, thinner than this is cut away.
MIN_GUARD_MM = 2.0
BEYOND_MM = 30.0
STOP_SLOT_PLAY_MM = 0.3
# Web beside the stop's slot, in multiples of the thinnest wall (estimate).
SLOT_WALLS = 2.0


# Take-up of all terminals, and the part of it that a cable of nominal length uses, mm.
TerminalWay = tuple[float, dict[str, float]]


def nut_corner_radius_mm(drive: SectorDrive) -> float:
    """Half the width across corners of the tensioner's hexagon nut, AF / sqrt(3), or of a wider spring."""
    spring = 0.0 if drive.spring is None else drive.spring.outside_mm / 2
    return max(drive.tensioner.nut_across_flats_mm / 3**0.5, spring)


def furthest_anchor_rad(drive: SectorDrive) -> float:
    """Largest angle, rad, from the transfer point at which a cable leaves its land, drum centred."""
    if drive.ring_anchor_rad is not None:
        return drive.ring_anchor_rad
    return radians(drive.drum.sector_half_angle_deg - SECTOR_MARGIN_DEG)


def lug_wall_mm(printed: bool, min_wall_mm: float) -> float:
    """Wall of a lug beside the stud's hole; ``min_wall_mm``: the thinnest that a printed drum's material allows."""
    return max(LUG_WALL_MM, min_wall_mm) if printed else LUG_WALL_MM


def lug_half_width_mm(drive: SectorDrive) -> float:
    """Half the width of a lug along the drum's axis: the stud's hole and a wall, or as wide as the springs on it."""
    metal, spring = drive.drum_material, drive.spring
    wall = lug_wall_mm(metal.printed, metal.min_wall_mm)
    return max(drive.tensioner.clearance_mm / 2 + wall, 0.0 if spring is None else spring.outside_mm / 2)


def terminal_half_mm(drive: SectorDrive) -> float:
    """How far a terminal with its lug reaches from its axis: nut across corners, springs, or a printed lug's wall."""
    return max(nut_corner_radius_mm(drive), lug_half_width_mm(drive))


def lands(drive: SectorDrive, levels: InputLevels) -> tuple[dims.Land, ...]:
    """Lands in the order of the steps; the wall before step k+1 stands at y_k+1 less the edge margin."""
    cables = sorted(drive.cables, key=lambda c: c.step)
    walls = [levels.drum_inner_y, *(c.land_y_mm - drive.clearances.land_edge_mm for c in cables[1:])]
    ends = [*walls[1:], levels.drum_outer_y]
    flank = drive.cable.diameter_mm / 2
    return tuple(
        dims.Land(c.step, c.drum_radius_mm - flank, start, end)
        for c, start, end in zip(cables, walls, ends, strict=True)
    )


def half_width_mm(drive: SectorDrive) -> float:
    """Half the sector's width along x with the drum centred: R sin(min(angle, 90 deg))."""
    outer = max(c.drum_radius_mm for c in drive.cables) - drive.cable.diameter_mm / 2
    return outer * sin(radians(min(drive.drum.sector_half_angle_deg, 90.0)))


def _anchor_limit(drive: SectorDrive, cable: SectorRun, tip: float, nuts_end: float) -> float:
    """Largest anchor angle (rad) that keeps the terminal inside the sector's angle and its width.

    A sector of 90 degrees or more to each side is as wide as its disc, so that only its angle limits the anchor.
    """
    r = cable.drum_radius_mm
    if drive.ring_anchor_rad is not None:
        return max(drive.ring_anchor_rad, cable.terminal_angle_rad or 0.0)
    by_angle = radians(drive.drum.sector_half_angle_deg - SECTOR_MARGIN_DEG) - atan2(tip, r)
    if drive.drum.sector_half_angle_deg >= 90.0:
        return by_angle
    width = half_width_mm(drive) - 0.1
    # Corners, out from the axis and along the tangent, which reach this width at some angle.
    corners = ((r + nut_corner_radius_mm(drive), nuts_end), (r + drive.tensioner.thread_mm / 2, tip))
    within = [asin(width / hypot(*at)) - atan2(at[1], at[0]) for at in corners if width < hypot(*at)]
    return min([by_angle, *within])


def nut_pocket_mm(drive: SectorDrive) -> float:
    """Half width of the nuts' pocket: the end mill's corner must not lift the nut off its seat."""
    return nut_corner_radius_mm(drive) + drive.clearances.running_mm + drive.drum_material.min_internal_radius_mm


def _pocket_top(drive: SectorDrive, cable: SectorRun, anchor_rad: float, pocket_end: float) -> float:
    """Outward reach of a terminal's pockets, mm; no thin wall may remain below the surface of a land further out."""
    r = cable.drum_radius_mm
    left = max(0.0, radians(drive.drum.sector_half_angle_deg) - anchor_rad)
    end = min(pocket_end, r * tan(min(left, 1.0)))
    top = nut_pocket_mm(drive)
    surfaces = sorted(c.drum_radius_mm - drive.cable.diameter_mm / 2 for c in drive.cables)
    for surface in (s for s in surfaces if s > r):
        # The pocket is straight and the land round, so the wall is thinnest at the pocket's end.
        if surface > r + top and surface - hypot(r + top, end) < MIN_FLOOR_MM:
            top = surface - r + OPEN_MM
    return top if top < surfaces[-1] - r else BEYOND_MM


def tensioners(drive: SectorDrive, way: TerminalWay) -> tuple[Tensioner, ...]:
    """Place the terminals where the file asks, else as far out as the sector allows; neighbours are staggered.

    Where two cables of one side lie close in radius, the outer one's lug must end before the inner one's pocket
    begins: then it stands on solid rim, and a spanner reaches both nuts.
    """
    t = drive.tensioner
    travel, drawn_in = way
    swage_end = SWAGE_START_MM + t.swage_length_mm
    # Gap from swage to lug, drawn in: the pocket's rounded corner must not lift the swage's flat.
    corner = drive.drum_material.min_internal_radius_mm + drive.clearances.running_mm
    gap = corner - sqrt(corner**2 - max(corner - FLAT_PLAY_MM, 0.0) ** 2) + END_GAP_MM
    lug_start = swage_end + travel + gap
    lug_end = lug_start + t.lug_thickness_mm
    # Before the cable is tensioned the springs under the nut have their free height.
    nuts_end = lug_end + drive.spring_free_mm + 2 * t.nut_height_mm
    slack_tip = SWAGE_START_MM + t.stud_length_mm + drive.spring_free_mm
    # With the terminal drawn in completely.
    tip = slack_tip + travel
    nut = nut_corner_radius_mm(drive)
    # Nearer than this, the inner one's pocket would reach the outer cable's land.
    reach = nut_pocket_mm(drive) + drive.cable.diameter_mm / 2 + MIN_FLOOR_MM
    placed: list[Tensioner] = []
    for side in (-1, 1):
        inner: Tensioner | None = None
        for cable in sorted((c for c in drive.cables if c.drum_side == side), key=lambda c: c.drum_radius_mm):
            limit = _anchor_limit(drive, cable, tip, nuts_end)
            near = max(2 * nut + 2.0, reach + (tip + 1.0) ** 2 / (2 * cable.drum_radius_mm))
            if inner is not None and (
                cable.drum_radius_mm - inner.radius_mm < near
                # The pockets of the inner terminal reach the outer cable, so that it cannot pass over them.
                or hypot(inner.radius_mm + inner.pocket_top, inner.last_tip)
                > cable.drum_radius_mm - drive.cable.diameter_mm / 2 - MIN_FLOOR_MM
            ):
                pocket = inner.anchor_rad - radians(0.3)
                limit = min(limit, pocket - atan2(lug_end, cable.drum_radius_mm))
            furthest = limit
            if cable.terminal_angle_rad is not None:
                limit = min(limit, cable.terminal_angle_rad)
            floor = drive.drum.outer_face_y_mm - cable.land_y_mm - nut - drive.clearances.running_mm
            # Turns beside a terminal of a whole drum leave no room for pockets that cross them.
            ring = drive.ring_anchor_rad is not None
            least, metal = MIN_FLOOR_MM, drive.drum_material
            if metal.printed:
                floor, least = floor - metal.min_internal_radius_mm, max(least, metal.min_wall_mm)
            through = floor < least and not ring
            pocket_end = tip + 1.0
            if drive.ring_anchor_rad is None:
                left = radians(drive.drum.sector_half_angle_deg) - limit - atan2(pocket_end, cable.drum_radius_mm)
                pocket_end += 0.0 if left * cable.drum_radius_mm > MIN_GUARD_MM else BEYOND_MM
            moved = drawn_in[cable.name]
            inner = Tensioner(
                cable_name=cable.name,
                side=side,
                radius_mm=cable.drum_radius_mm,
                y_mm=cable.land_y_mm,
                anchor_rad=limit,
                furthest_rad=furthest,
                swage_start=SWAGE_START_MM + moved,
                cable_end=swage_end - SWAGE_FLOOR_MM + moved,
                swage_end=swage_end + moved,
                lug_start=lug_start,
                lug_end=lug_end,
                nuts_end=nuts_end,
                spring=drive.spring_height_mm(cable.preload_N),
                tip=slack_tip + moved,
                pocket_end=pocket_end,
                # A pocket through the whole rim must be open outwards, else the metal above it would be loose.
                pocket_top=BEYOND_MM if through else _pocket_top(drive, cable, limit, pocket_end),
                cut_through=through,
                travel=travel,
                drawn_in=moved,
                front=ring and cable.land_y_mm > 0.0,
            )
            placed.append(inner)
    order = {c.name: c.step for c in drive.cables}
    return tuple(sorted(placed, key=lambda p: order[p.cable_name]))


def _pocket_radius(drive: SectorDrive, placed: tuple[Tensioner, ...], flat_wall: float) -> float:
    """Radius of the pockets' corners, mm: the least that the material allows, or a little more.

    If a corner ended very near a land's edge, a sliver would remain that neither the kernel nor a mill can make.
    """
    least, nuts = drive.drum_material.min_internal_radius_mm, nut_pocket_mm(drive)
    surfaces = [c.drum_radius_mm - drive.cable.diameter_mm / 2 for c in drive.cables]

    def nearest(radius: float) -> float:
        """Least distance from a corner's end to the surface of a land."""
        ends = [
            hypot(t.radius_mm + n, s)
            for t in placed
            for half, s in (
                (flat_wall, t.slack_start - dims.POCKET_LEAD_MM),
                (flat_wall, t.lug_start),
                (nuts, t.lug_end),
                (nuts, t.pocket_end),
            )
            for n in (radius - half, t.pocket_top - radius)
        ]
        return min(abs(end - surface) for end in ends for surface in surfaces)

    tried = [least + k * drive.clearances.running_mm / 12 for k in range(13)]
    found = next((radius for radius in tried if nearest(radius) >= SLIVER_MM), None)
    return max(tried, key=nearest) if found is None else found


def _windows(drive: SectorDrive, stop_radius: float, slot_end_deg: float) -> tuple[dims.Window, ...]:
    """Windows outside the stop's slot only, where the web carries little; none without one.

    The shear of a web falls with the square of its radius. Windows between hub and slot saved 6 g of the reference of
    miso_bevel and made its web nine times as soft, because the spokes that they leave bend (docs/structure.md).
    """
    if drive.drum.windows == "none" or not drive.stopped:
        return ()
    outer = drive.drum.rim_inner_radius_mm - 2.5
    above = stop_radius + drive.drum.stop_pin_mm / 2 + 2.4
    spoke = degrees(asin(min(0.9, 1.5 / (drive.drum.hub_diameter_mm / 2 + 3.0))))
    window = dims.Window(above, outer, spoke, slot_end_deg - spoke)
    radius = 2 * drive.drum_material.min_internal_radius_mm
    wide = radians(window.end_deg - window.start_deg) * window.r_inner
    if min(outer - above, wide) <= 2 * radius + 1.0:
        return ()
    return window, dims.Window(above, outer, -window.end_deg, -window.start_deg)


def _root(drive: SectorDrive, levels: InputLevels, stop_radius: float) -> tuple[float, float]:
    """Radius and front of the thicker web round the hub: twice the web, behind set screws and inside the stop's slot.

    The shear of a web falls with the square of its radius: metal there stiffens the drum twice as much for its mass as
    a web that is thicker everywhere (docs/structure.md).
    """
    d, thread = drive.drum, drive.screw(HUB_SCREW).thread_mm
    web_end, hub = _web_start_y(drive, levels) + d.web_thickness_mm, d.hub_diameter_mm / 2
    end = min(web_end + d.web_thickness_mm, _set_screw_y(drive, levels) - thread / 2 - ROOT_GAP_MM)
    slot = stop_radius - (d.stop_pin_mm + STOP_SLOT_PLAY_MM) / 2 - ROOT_GAP_MM
    radius = min(ROOT_SHARE * hub, slot)
    if radius - hub < LEAST_ROOT_MM or end - web_end < LEAST_ROOT_MM:
        return hub, web_end
    return radius, end


def pocket_end_rad(t: Tensioner) -> float:
    """Angle at which a terminal's pocket ends, from the transfer point, drum centred."""
    return t.anchor_rad + atan2(t.pocket_end, t.radius_mm)


def drum(drive: SectorDrive, levels: InputLevels, stop_radius: float, way: TerminalWay) -> dims.DrumDims:
    """Dimensions of the drum; the stop pin stands in the frame at ``stop_radius`` from its axis."""
    d = drive.drum
    slot_width = d.stop_pin_mm + STOP_SLOT_PLAY_MM if drive.stopped else 0.0
    # The pin touches the slot's end after it has moved through its play.
    play_deg = degrees(STOP_SLOT_PLAY_MM / 2 / max(stop_radius, 1.0))
    slot_end = drive.half_travel_deg + drive.stop_clearance_deg - play_deg if drive.stopped else 0.0
    shaft_radius = drive.bearings.drum.bore_mm / 2
    screw = drive.screw(HUB_SCREW)
    hub_radius, spigot = d.hub_diameter_mm / 2, drive.bearings.drum.inner_shoulder_mm / 2
    spigot_root = spigot
    if drive.drum_material.printed:
        # A printed spigot, too thin as a ring, is a cone of at least 45 degrees.
        wanted = max(spigot + SPIGOT_HEIGHT_MM, shaft_radius + drive.drum_material.min_wall_mm)
        spigot_root = max(spigot, min(wanted, hub_radius - dims.CHAMFER_MM))
    web_start = _web_start_y(drive, levels)
    placed = tensioners(drive, way)
    joint, circle = _payload(drive)
    root_radius, root_end = _root(drive, levels, stop_radius)
    flat_wall = drive.tensioner.swage_flats_mm / 2 + FLAT_PLAY_MM
    # How far printed lugs on a whole drum may reach along y: to a wall before the turn beside them, and the middle.
    wall = drive.drum_material.min_wall_mm
    ends = [min(drive.turn_beside_mm(pocket_end_rad(t)) - wall, abs(t.y_mm) - wall / 2) for t in placed]
    lug_reach = min(ends, default=0.0) if drive.drum_material.printed else 0.0
    return dims.DrumDims(
        half_angle_deg=d.sector_half_angle_deg,
        rim_inner_radius=d.rim_inner_radius_mm,
        lands=lands(drive, levels),
        web_start_y=web_start,
        web_end_y=web_start + d.web_thickness_mm,
        hub_radius=hub_radius,
        hub_start_y=levels.boss_front_y + SPIGOT_HEIGHT_MM,
        hub_face_y=d.hub_face_y_mm,
        spigot_radius=spigot,
        spigot_root_radius=spigot_root,
        spigot_y=levels.boss_front_y,
        bore_radius=shaft_radius,
        windows=_windows(drive, stop_radius, slot_end),
        stop_radius=stop_radius,
        stop_slot_width=slot_width,
        stop_slot_end_deg=slot_end,
        tensioners=placed,
        stud_hole_radius=drive.tensioner.clearance_mm / 2,
        lug_half_width=lug_half_width_mm(drive),
        swage_pocket=drive.tensioner.swage_diameter_mm / 2 + drive.clearances.running_mm,
        flat_wall=flat_wall,
        nut_pocket=nut_pocket_mm(drive),
        pocket_radius=_pocket_radius(drive, placed, flat_wall),
        set_screw=screw.name,
        set_screw_y=_set_screw_y(drive, levels),
        set_screw_radius=shaft_radius - FLAT_DEPTH_MM,
        payload_screw_thread=joint.thread_mm,
        payload_circle_radius=circle,
        payload_angles_deg=joint.angles_deg(dims.SET_SCREW_ANGLES_DEG),
        payload_depth=joint.depth_mm,
        payload_insert=joint.insert,
        corner_radius=2 * drive.drum_material.min_internal_radius_mm,
        root_radius=root_radius,
        root_end_y=root_end,
        lug_reach=lug_reach,
    )


def _web_start_y(drive: SectorDrive, levels: InputLevels) -> float:
    return levels.drum_inner_y + 3 * drive.clearances.running_mm


def _payload(drive: SectorDrive) -> tuple[dims.PayloadJoint, float]:
    """The payload's joint and the radius of its screws' circle, mm."""
    d, metal = drive.drum, drive.drum_material
    hub, shaft = d.hub_diameter_mm / 2, drive.bearings.drum.bore_mm / 2
    circle = dims.circle_radius_mm(d.output_circle_mm, hub, shaft)
    candidates = dims.joints(metal, lambda thread_mm: drive.insert(metal, thread_mm), d.output_screws)
    load = dims.joint_load(drive.loads.peak_torque_Nm, drive.loads.carried)
    return dims.payload_joint(candidates, load, circle, hub, shaft, metal.min_wall_mm), circle


def _set_screw_y(drive: SectorDrive, levels: InputLevels) -> float:
    """Depth of the set screws, mm: the middle of the hub in front of the web, or behind payload's holes near them."""
    middle = (_web_start_y(drive, levels) + drive.drum.web_thickness_mm + drive.drum.hub_face_y_mm) / 2
    if drive.drum.output_screws == dims.SCREWS:
        return middle
    joint, circle = _payload(drive)
    thread, wall = drive.screw(HUB_SCREW).thread_mm, drive.drum_material.min_wall_mm
    behind = joint.behind_mm(circle, dims.SET_SCREW_ANGLES_DEG, thread, wall)
    return min(middle, drive.drum.hub_face_y_mm - behind)


def drum_shaft(drive: SectorDrive, levels: InputLevels) -> DrumShaftDims:
    """Shaft through the boss: encoder, flange, rear bearing, front bearing, hub."""
    bearing = drive.bearings.drum
    encoder_front = levels.back_y + drive.drum_encoder.length_mm
    rear = encoder_front + 1.0
    return DrumShaftDims(
        radius=bearing.bore_mm / 2,
        bore_radius=drive.drum.shaft_bore_mm / 2,
        y_start=levels.back_y,
        y_end=levels.hub_face_y,
        flange_radius=bearing.inner_shoulder_mm / 2,
        flange_start_y=rear - 0.8,
        flange_end_y=rear,
        rear_bearing_y=rear,
        front_bearing_y=levels.boss_front_y - bearing.width_mm,
        flat_y=_set_screw_y(drive, levels),
        flat_length=drive.screw(HUB_SCREW).thread_mm + 1.0,
        flat_angles_deg=dims.SET_SCREW_ANGLES_DEG,
    )


def preload_spring(drive: SectorDrive, shaft: DrumShaftDims) -> PreloadSpringDims:
    """Wave spring between the boss's shoulder and the outer ring of the rear bearing, which it presses back."""
    bearing = drive.bearings.drum
    outer, inner = bearing.outer_diameter_mm / 2 - SPRING_PLAY_MM, bearing.outer_shoulder_mm / 2
    return PreloadSpringDims(
        inner_radius=inner,
        outer_radius=max(outer, inner + SPRING_PLAY_MM),
        height=SPRING_HEIGHT_MM,
        start_y=shaft.rear_bearing_y + bearing.width_mm,
        force_N=SPRING_N_MM * bearing.bore_mm,
        source="Wave spring for the bearing's outside diameter; force: bearing makers; sizes and mass: estimate.",
    )
