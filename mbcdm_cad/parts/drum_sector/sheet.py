"""Sheet of the drum sector."""

from math import cos, degrees, radians, sin, tau

from mbcdm_cad.parts import sheet
from mbcdm_cad.parts.drum_sector.dims import CHAMFER_MM, POCKET_LEAD_MM, SET_SCREW_ANGLES_DEG, DrumDims
from mbcdm_cad.parts.fits import FITS, GeometricTolerance
from mbcdm_cad.parts.sheet_blocks import hole_labels, hole_table, position_table

_REAR, _SECTION, _HUB = "rear", "section", "hub"
# How far beyond the rim the sector's angle is drawn, over the rim's radius: the cutting line ends below it.
_ANGLE_BEYOND = 0.15


def _polar(radius: float, deg: float, y: float) -> sheet.Vector:
    return (radius * sin(radians(deg)), y, radius * cos(radians(deg)))


def _turned(d: DrumDims) -> list[tuple[str, float, float, float]]:
    """Steps, radius, start and end of each surface that is turned: lands of one radius side by side are one."""
    found: list[tuple[str, float, float, float]] = []
    for land in d.lands:
        steps, start = str(land.step), land.y_start
        if found and (found[-1][1], found[-1][3]) == (land.surface_radius_mm, start):
            before, _, start, _ = found.pop()
            steps = f"{before}, {steps}"
        found.append((steps, land.surface_radius_mm, start, land.y_end))
    return found


def _lands(d: DrumDims) -> sheet.Table:
    fit = FITS["land"].code
    rows = tuple(
        (steps, sheet.mm3(radius), fit, sheet.mm3(start - d.spigot_y), sheet.mm3(end - d.spigot_y))
        for steps, radius, start, end in _turned(d)
    )
    return sheet.Table("Lands (fit for the diameter), depths from face A", ("Step", "R", "Fit", "from", "to"), rows)


def _windows(d: DrumDims) -> sheet.Table:
    rows = tuple(
        (f"W{n}", sheet.mm(w.r_inner), sheet.mm(w.r_outer), sheet.mm(w.start_deg), sheet.mm(w.end_deg))
        for n, w in enumerate(d.windows, 1)
    )
    head = f"Windows, corners R{sheet.mm(d.corner_radius)}, angles from Z to X"
    return sheet.Table(head, ("", "R inner", "R outer", "from deg", "to deg"), rows)


def _terminals(d: DrumDims) -> sheet.Table:
    """A column for each terminal; s along the tangent from where the cable leaves its land, n outward from there."""
    ends = d.lands[-1].surface_radius_mm
    columns = []
    for t in d.tensioners:
        depth, lug = t.y_mm - d.spigot_y, d.lug_y(t)
        swage, nuts = (
            "through"
            if t.cut_through
            else sheet.mm3(t.deeper(half) - d.spigot_y) + (", from the front" if t.front else "")
            for half in (d.swage_pocket, d.nut_pocket)
        )
        columns.append(
            (
                t.cable_name,
                # On a whole drum it may lie more than a turn further.
                sheet.mm(t.side * degrees(t.anchor_rad % tau), 3),
                sheet.mm3(t.radius_mm),
                sheet.mm3(depth),
                sheet.mm3(t.slack_start - POCKET_LEAD_MM),
                sheet.mm3(t.lug_start),
                sheet.mm3(t.lug_end),
                "open" if t.pocket_end > t.last_tip + 2.0 else sheet.mm3(t.pocket_end),
                "open" if t.radius_mm + t.pocket_top > ends else sheet.mm3(t.pocket_top),
                swage,
                nuts,
                f"{sheet.mm3(lug[0] - d.spigot_y)} to {sheet.mm3(lug[1] - d.spigot_y)}",
            )
        )
    heads = (
        "cable",
        "angle from Z to X, deg",
        "pitch radius",
        "depth of axis from A",
        "swage pocket from s",
        "swage pocket to, lug from s",
        "lug to, nut pocket from s",
        "nut pocket to s",
        "pockets up to n",
        "swage pocket depth from A",
        "nut pocket depth from A",
        "lug depth from A",
    )
    rows = tuple((head, *(c[n] for c in columns)) for n, head in enumerate(heads))
    return sheet.Table("Terminals", ("", *(f"T{n}" for n in range(1, len(columns) + 1))), rows)


def _shape(d: DrumDims) -> sheet.Table:
    """Sizes that all terminals and the stop's slot share."""
    slot = (
        ("stop slot: radius", sheet.mm3(d.stop_radius)),
        ("stop slot: width, round ends", sheet.mm3(d.stop_slot_width)),
        ("stop slot: ends at +- deg", sheet.mm(d.stop_slot_end_deg, 3)),
    )
    rows = (
        ("swage pocket n from", sheet.mm3(-d.flat_wall)),
        ("nut pocket n from", sheet.mm3(-d.nut_pocket)),
        ("lug n up to", sheet.mm3(d.lug_half_width)),
        ("stud slot of the lug, width, round end", sheet.mm3(2 * d.stud_hole_radius)),
        ("pocket corners R", sheet.mm3(d.pocket_radius)),
        *(slot if d.has_slot else ()),
        *(
            (("spigot: cone, at the hub %%c", sheet.mm3(2 * d.spigot_root_radius)),)
            if d.spigot_root_radius > d.spigot_radius
            else ()
        ),
        ("web thicker up to R", sheet.mm3(d.root_radius)),
        ("web thicker, in front up to", sheet.mm3(d.root_end_y - d.spigot_y)),
    )
    return sheet.Table("Pockets, lugs and stop slot", ("", "all"), rows)


def _holes(d: DrumDims, set_screw_thread: float) -> tuple[sheet.Holes, ...]:
    payload = tuple(_polar(d.payload_circle_radius, deg, d.hub_face_y) for deg in d.payload_angles_deg)
    radial = tuple(_polar(d.hub_radius, deg, d.set_screw_y) for deg in SET_SCREW_ANGLES_DEG)
    return (
        sheet.Holes(
            "P",
            d.payload_hole,
            d.payload_depth,
            payload,
            "hub face",
            "payload",
            threaded=d.payload_insert is None,
            insert=d.payload_insert,
        ),
        sheet.Holes("Q", set_screw_thread, "to bore", radial, "hub, radial", "set screws", threaded=True),
        *_dowel_holes(d),
    )


def _dowel_holes(d: DrumDims) -> tuple[sheet.Holes, ...]:
    pins = d.dowels
    if pins is None:
        return ()
    face = tuple((x, d.hub_face_y, z) for x, z in pins.places(pins.face_angles_deg))
    back = tuple((x, d.hub_start_y, z) for x, z in pins.places(pins.back_angles_deg))
    pressed, sliding = FITS["pin_press"].code, FITS["pin_slide"].code
    return (
        sheet.Holes("R", 2 * pins.radius, pins.face_depth, face, "hub face", "dowels", fit=pressed),
        sheet.Holes(
            "S", 2 * pins.radius, pins.back_depth, back, "hub back", "dowels of the sector behind", fit=sliding
        ),
    )


def _views(d: DrumDims) -> tuple[sheet.View, ...]:
    outer = d.lands[-1].surface_radius_mm
    half, face = radians(min(d.half_angle_deg, 90.0)), d.spigot_y
    tip = outer * sin(half)
    hub = d.hub_radius + 0.4
    return (
        sheet.View(
            _REAR,
            sheet.X,
            sheet.Z,
            axes=(((-tip, face, 0.0), (tip, face, 0.0)), ((0.0, face, -d.hub_radius), (0.0, face, outer))),
        ),
        sheet.View(
            _SECTION,
            sheet.minus(sheet.Y),
            sheet.Z,
            column=1,
            title="B-B",
            cut=(0.0, 0.0, 0.0),
            axes=(((0.0, d.spigot_y, 0.0), (0.0, d.hub_face_y, 0.0)),),
        ),
        sheet.View(
            _HUB,
            sheet.minus(sheet.X),
            sheet.Z,
            column=1,
            row=-1,
            title="Hub from the output side",
            magnify=2.0,
            window=((0.0, d.hub_face_y, 0.0), hub, hub),
            circles=(((0.0, d.hub_face_y, 0.0), d.payload_circle_radius),),
            axes=(
                ((-hub, d.hub_face_y, 0.0), (hub, d.hub_face_y, 0.0)),
                ((0.0, d.hub_face_y, -hub), (0.0, d.hub_face_y, hub)),
            ),
        ),
    )


def _in_section(d: DrumDims) -> tuple[sheet.Linear, ...]:
    face = d.spigot_y
    low = -d.hub_radius

    def deep(start: float, end: float, z: tuple[float, float], side: sheet.Side, what: str = "") -> sheet.Linear:
        a, b = (0.0, start, z[0]), (0.0, end, z[1])
        return sheet.Linear(_SECTION, a, b, end - start, side, suffix=what, decimals=3)

    def round_(radius: float, y: float, side: sheet.Side, fit: str = "", datum: str = "") -> sheet.Linear:
        a, b = (0.0, y, -radius), (0.0, y, radius)
        return sheet.Linear(_SECTION, a, b, 2 * radius, side, "%%c", fit=fit, datum=datum)

    c = CHAMFER_MM
    return (
        deep(face, d.hub_start_y, (-d.spigot_radius, low), "below"),
        deep(face, d.hub_face_y, (-d.spigot_radius, low + c), "below"),
        deep(d.set_screw_y, d.hub_face_y, (low, low + c), "below", " Q"),
        deep(d.hub_face_y - c, d.hub_face_y, (low, low + c), "below", " x 45%%d"),
        deep(face, d.web_start_y, (d.spigot_radius, d.hub_radius + 6.0), "above"),
        deep(d.web_start_y, d.web_end_y, (d.hub_radius + 6.0, d.hub_radius + 6.0), "above", " web"),
        round_(d.bore_radius, d.hub_face_y, "left", FITS["drum_bore"].code, "D"),
        round_(d.hub_radius, d.hub_face_y - c, "left"),
        round_(d.spigot_radius, face, "right"),
    )


def drum_sheet(part: str, d: DrumDims, set_screw_thread: float) -> sheet.Sheet:
    """From behind, where the pockets are open, with a middle section, the hub from the front, and tables."""
    outer, face, half = d.lands[-1].surface_radius_mm, d.spigot_y, d.half_angle_deg
    holes = _holes(d, set_screw_thread)
    land, bore = FITS["land"].code, FITS["drum_bore"].code
    turned = _turned(d)
    lands = [(0.0, (start + end) / 2, radius) for _, radius, start, end in turned]
    labels = [
        sheet.Label(_REAR, (t.at(t.lug_end)[0], 0.0, t.at(t.lug_end)[1]), f"T{n}", clear_mm=2.0, leader=True)
        for n, t in enumerate(d.tensioners, 1)
    ]
    labels += [
        sheet.Label(_REAR, _polar((w.r_inner + w.r_outer) / 2, (w.start_deg + w.end_deg) / 2, face), f"W{n}")
        for n, w in enumerate(d.windows, 1)
    ]
    # A rim that is closed has no angle.
    angle = (
        []
        if d.whole
        else [
            sheet.Angle(
                _REAR,
                (0.0, face, 0.0),
                _polar(outer, half, face),
                _polar(outer, -half, face),
                2 * half,
                outer * (1.0 + _ANGLE_BEYOND),
            )
        ]
    )
    return sheet.Sheet(
        part=part,
        title="Drum" if d.whole else "Drum sector",
        paper="A2",
        views=_views(d),
        dimensions=(
            *_in_section(d),
            *angle,
            sheet.Radius(_REAR, (0.0, face, 0.0), _polar(d.rim_inner_radius, 35.0, face), d.rim_inner_radius),
            sheet.Linear(
                _HUB,
                _polar(d.payload_circle_radius, 90.0, d.hub_face_y),
                _polar(d.payload_circle_radius, -90.0, d.hub_face_y),
                2 * d.payload_circle_radius,
                "below",
                "%%c",
            ),
        ),
        # B, since A is the face from which depths are measured.
        cutting_lines=(
            sheet.CuttingLine(
                _REAR, (0.0, face, -(outer if d.whole else d.hub_radius) - 2.0), (0.0, face, outer), "B", sheet.X
            ),
        ),
        tolerances=(GeometricTolerance(_SECTION, lands[0], "run-out", 0.02, ("D",), tuple(lands[1:])),),
        labels=(
            *labels,
            *hole_labels((*holes[:1], *holes[2:3]), _HUB),
            *hole_labels(holes[3:], _REAR),
            sheet.Label(_SECTION, (0.0, face, d.spigot_radius), "A", leader=True),
        ),
        tables=(
            hole_table(holes),
            position_table(holes, (0, 2), "Positions from the axis"),
            _lands(d),
            *((_windows(d),) if d.windows else ()),
            _shape(d),
            _terminals(d),
        ),
        holes=holes,
        fits=(
            sheet.FitLine(2 * d.bore_radius, bore, "bore"),
            *(sheet.FitLine(round(2 * radius, 6), land, f"step {steps}") for steps, radius, *_ in turned),
            *(line for group in _dowel_holes(d) for line in group.fit_lines()),
        ),
        notes=(
            "The large view is from behind (face A's side), X to the right, Z up.",
            "Lands Ra 0.8. Terminals: s along the tangent, n outward, both from the point of "
            "the pitch circle at the given angle; pockets from behind (face A's side)"
            + (", on a whole drum from the face that the table names." if d.whole else "."),
            "Q: two set screws at 45 and 135 degrees from Z.",
        ),
    )
