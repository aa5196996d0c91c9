"""Input pulley and its sheet: two steps, smooth or grooved, journals, slit bore for the gearhead's shaft."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import asin, cos, degrees, hypot, pi, sin, sqrt, tau

from mbcdm_cad.parts.fits import FITS, GeometricTolerance
from mbcdm_cad.parts.input_pulley.dims import (
    CHAMFER_MM,
    SET_SCREWS_DEG,
    STOP_PLAY_MM,
    Groove,
    InputPulleyDims,
    StopSlot,
)
from mbcdm_cad.parts.part import MadePart, Ring, cq, ring_mm3, rings_mm3
from mbcdm_cad.parts.sheet import FitLine, Holes, Label, Linear, Sheet, Table, Vector, View, X, Y, Z, minus, mm, mm3
from mbcdm_cad.parts.sheet_blocks import ALONG_Z, MAIN, THROUGH, hole_labels, hole_table, position_table


def _strip_mm2(radius: float, width: float) -> float:
    """Area of a strip through the middle of a circle."""
    h = min(width / 2, radius)
    return 2 * (h * sqrt(radius**2 - h**2) + radius**2 * asin(h / radius)) if radius > 0.0 else 0.0


def _slot_mm3(slot: StopSlot) -> float:
    """Slot of a cable's stop: a quarter of a ring and a straight piece of the slot's depth, the pocket deeper."""
    depth = abs(slot.end_z - slot.face_z) + slot.width / 2
    reach = slot.stop_radius + STOP_PLAY_MM
    pocket = abs(slot.chord_z - slot.face_z) + reach
    length = slot.stop_start - slot.stop_end + 2 * STOP_PLAY_MM
    straight = max(slot.pitch_radius - slot.bend_radius - slot.stop_start, 0.0)
    return slot.width * depth * (pi / 2 * slot.bend_radius + straight) + 2 * reach * length * pocket


def _groove_ring(groove: Groove) -> Ring:
    inner, outer = groove.root_radius, groove.root_radius + groove.depth
    half, middle = groove.volume_mm3 / (2 * pi * (outer**2 - inner**2)), (groove.start_z + groove.end_z) / 2
    return (inner, outer, middle - half, middle + half)


@dataclass(frozen=True)
class InputPulley(MadePart):
    """Input pulley about its own axis, heights as in the assembly, turned as with the drum centred."""

    dims: InputPulleyDims
    # With a ring for each turn of its helical grooves, as the views of its sheet show them.
    rings: bool = False

    def solid(self) -> cq.Solid:
        """Drawn by ``draw.py`` beside this module."""
        from mbcdm_cad.parts.input_pulley.draw import create_input_pulley

        return create_input_pulley(self.dims, self.rings)

    def in_rings(self) -> tuple[Ring, ...]:
        """Journals, necks and steps less bore and grooves; a groove is as long as a ring of its depth and volume."""
        d = self.dims
        return (
            (d.lower_journal_radius, 0.0, d.journal_bottom_z, d.lower_neck_bottom_z),
            (d.lower_neck_radius, 0.0, d.lower_neck_bottom_z, d.land_bottom_z),
            (d.lower_land_radius, 0.0, d.land_bottom_z, d.wall_z),
            (d.upper_land_radius, 0.0, d.wall_z, d.land_top_z),
            (d.upper_neck_radius, 0.0, d.land_top_z, d.upper_neck_top_z),
            (d.upper_journal_radius, 0.0, d.upper_neck_top_z, d.journal_top_z),
            (0.0, d.bore_radius, d.journal_bottom_z, d.bore_top_z),
            *map(_groove_ring, d.grooves),
        )

    def volume_mm3(self) -> float:
        """Journals, necks and steps less bore, slit, slots and grooves."""
        d = self.dims
        both = _strip_mm2(d.lower_journal_radius, d.slit_width)
        slit = both * (d.slit_top_z - d.journal_bottom_z)
        slit -= _strip_mm2(d.bore_radius, d.slit_width) * max(d.bore_top_z - d.journal_bottom_z, 0.0)
        if d.horn is not None:
            thick = d.lower_neck_bottom_z - d.journal_bottom_z
            slit = len(d.horn.places) * ring_mm3(d.horn.clearance, 0.0, thick)
        if d.hub is not None:
            slit = ring_mm3(d.hub.thread / 2, 0.0, 2 * (d.lower_journal_radius - d.bore_radius))
        return rings_mm3(self.in_rings()) - slit - sum(map(_slot_mm3, d.slots))

    def in_views(self) -> InputPulley:
        """With rings in place of helical grooves, whose hidden lines take minutes to compute."""
        return replace(self, rings=bool(self.dims.grooves))

    def sheet(self, part: str) -> Sheet:
        """Views along and across its axis, and tables of its slots and grooves."""
        plain = self.dims.hub is None and self.dims.horn is None
        return (input_pulley_sheet if plain else overhung_pulley_sheet)(part, self.dims)


_NAMES = ("S1", "S2")
_GROOVES = "Crests of the grooves broken by 0.02, floors Ra 0.8."
_SLOTS = "Slots after turning and grooving, edges that the cable touches rounded to R0.2 and polished."
_SLOTS_FROM = "X of the slots is the direction of the slit."


def _land_lengths(d: InputPulleyDims) -> tuple[Linear, ...]:
    """Of both steps, or of the one land."""
    lower, upper = d.lower_land_radius, d.upper_land_radius
    if not d.stepped:
        return (ALONG_Z.length(d.land_bottom_z, d.land_top_z, "below", (lower, upper), decimals=3),)
    return (
        ALONG_Z.length(d.land_bottom_z, d.wall_z, "below", (lower, upper), decimals=3),
        ALONG_Z.length(d.wall_z, d.land_top_z, "below", (upper, upper), decimals=3),
    )


def _lengths(d: InputPulleyDims) -> tuple[Linear, ...]:
    """Lengths, one after the other up to the last neck, and the whole."""
    low, c = d.journal_bottom_z, CHAMFER_MM
    return (
        ALONG_Z.length(low, d.lower_neck_bottom_z, "below", (d.lower_journal_radius - c, d.lower_neck_radius)),
        ALONG_Z.length(
            d.lower_neck_bottom_z, d.land_bottom_z, "below", (d.lower_neck_radius, d.lower_land_radius), decimals=3
        ),
        *_land_lengths(d),
        ALONG_Z.length(
            d.land_top_z, d.upper_neck_top_z, "below", (d.upper_land_radius, d.upper_neck_radius), decimals=3
        ),
        ALONG_Z.length(
            low, d.journal_top_z, "below", (d.lower_journal_radius - c, d.upper_journal_radius - c), decimals=3
        ),
        *(
            (
                ALONG_Z.length(low, d.bore_top_z, "above", (d.lower_journal_radius - c, d.bore_radius)),
                ALONG_Z.length(low, d.slit_top_z, "above", (d.lower_journal_radius - c, d.lower_journal_radius)),
            )
            if d.bore_radius
            else ()
        ),
        ALONG_Z.chamfer(c, d.upper_journal_radius, d.journal_top_z, -1.0, "above", count=2),
    )


def _diameters(d: InputPulleyDims) -> tuple[Linear, ...]:
    journal, bore = (FITS[role].code for role in ("input_journal", "gear_shaft_bore"))
    # The cables lie on the land, or in grooves whose roots the table gives.
    land = "" if d.grooves else FITS["land"].code
    low, c = d.journal_bottom_z, CHAMFER_MM
    return (
        *((ALONG_Z.diameter(d.bore_radius, low, "left", fit=bore),) if d.bore_radius else ()),
        ALONG_Z.diameter(d.lower_journal_radius, low + c, "left", fit=journal, datum="D"),
        ALONG_Z.diameter(d.lower_neck_radius, d.lower_neck_bottom_z, "left"),
        ALONG_Z.diameter(d.lower_land_radius, d.land_bottom_z, "left", fit=land, decimals=3),
        *([ALONG_Z.diameter(d.upper_land_radius, d.land_top_z, "right", fit=land, decimals=3)] if d.stepped else ()),
        ALONG_Z.diameter(d.upper_neck_radius, d.upper_neck_top_z, "right"),
        ALONG_Z.diameter(d.upper_journal_radius, d.journal_top_z - c, "right", fit=journal, datum="E"),
    )


def _slot_table(d: InputPulleyDims) -> Table:
    """All that a slot needs, a line each: u and v are the axes drawn in the end views, through the pulley's axis."""

    def column(slot: StopSlot) -> tuple[str, ...]:
        lower = slot.face_z < slot.end_z
        half, r = slot.width / 2, slot.stop_radius + STOP_PLAY_MM
        surface = d.lower_land_radius if lower else d.upper_land_radius
        floor = abs(slot.end_z - slot.face_z) + half
        pocket = abs(slot.chord_z - slot.face_z) + r
        return (
            slot.cable_name,
            "lower" if lower else "upper",
            mm(degrees(slot.end_angle_rad) % 360.0, 3),
            "+90" if slot.away > 0 else "-90",
            mm3(slot.width),
            mm3(floor),
            mm3(slot.pitch_radius - slot.bend_radius),
            mm3(slot.bend_radius),
            mm(slot.open_deg(surface), 2),
            mm3(slot.stop_start - slot.stop_end + 2 * STOP_PLAY_MM),
            mm3((slot.stop_start + slot.stop_end) / 2),
            mm3(2 * r),
            mm3(pocket),
            mm3(2 * slot.cutter_radius),
        )

    heads = (
        "cable",
        "milled from land face",
        "u from X, deg (seen from +Z, anticlockwise)",
        "v from u, deg (same sense)",
        "width",
        "depth from land face",
        "bend: centre on u",
        "bend: radius to middle of slot, to u = 0",
        "bend: outside open from u to deg",
        "pocket: length along u",
        "pocket: middle on u",
        "pocket: width, about v = bend radius",
        "pocket: depth from land face",
        "pocket: corner reliefs %%c, on the diagonals",
    )
    columns = [column(slot) for slot in d.slots]
    rows = tuple((head, *(c[n] for c in columns)) for n, head in enumerate(heads))
    return Table("Slots of the cable stops", ("", *_NAMES[: len(columns)]), rows)


def _groove_table(d: InputPulleyDims) -> Table:
    """Helical grooves, a column each; angles as in the end views."""
    heads = (
        "cable",
        "hand of the helix",
        "lead",
        "root %%c",
        "fit of the root %%c",
        "radius of the floor",
        "depth from land",
        "middle of the groove at one end, from the lower end",
        "there at deg from X (seen from +Z, anticlockwise)",
        "middle of the groove at its other end, from the lower end",
        "turns",
    )

    def column(g: Groove) -> tuple[str, ...]:
        return (
            g.cable_name,
            "right" if g.right_handed else "left",
            mm3(g.lead),
            mm3(2 * g.root_radius),
            FITS["land"].code,
            mm3(g.radius),
            mm3(g.depth),
            mm3(g.start_z - d.journal_bottom_z),
            mm(degrees(g.start_angle_rad) % 360.0, 3),
            mm3(g.end_z - d.journal_bottom_z),
            mm(abs(g.end_angle_rad - g.start_angle_rad) / tau, 3),
        )

    columns = [column(groove) for groove in d.grooves]
    rows = tuple((head, *(c[n] for c in columns)) for n, head in enumerate(heads))
    return Table("Helical grooves", ("", *(f"G{n}" for n in range(1, len(columns) + 1))), rows)


def _fits(diameters: tuple[Linear, ...], names: dict[str, str], d: InputPulleyDims) -> tuple[FitLine, ...]:
    """Those of the drawn diameters, by the names of their codes, and of the grooves' roots, which set the ratio."""
    roots = (FitLine(round(2 * g.root_radius, 6), FITS["land"].code, "root of the grooves") for g in d.grooves)
    return (*(FitLine(round(x.value, 6), x.fit, names[x.fit]) for x in diameters if x.fit), *roots)


def _end_view(d: InputPulleyDims, lower: bool) -> View:
    right: Vector = Y if lower else minus(Y)
    radius = d.lower_land_radius if lower else d.upper_land_radius
    z = d.land_bottom_z if lower else d.land_top_z
    axes: list[tuple[Vector, Vector]] = [((-radius, 0.0, z), (radius, 0.0, z)), ((0.0, -radius, z), (0.0, radius, z))]
    for slot in d.slots:
        if (slot.face_z < slot.end_z) == lower:
            u, v = _directions(slot, radius)
            axes += [((0.0, 0.0, z), (u[0], u[1], z)), ((0.0, 0.0, z), (v[0], v[1], z))]
    # The end views are beside the section; those of a slender pulley are drawn larger, to show the slots.
    slender = 4.0 * max(d.lower_land_radius, d.upper_land_radius) < d.journal_top_z - d.journal_bottom_z
    name, larger = "lower end" if lower else "upper end", 2.5 if slender else 1.0
    return View(
        name, right, X, column=1, row=0 if lower else -1, title=f"View of the {name}", magnify=larger, axes=tuple(axes)
    )


def _directions(slot: StopSlot, reach: float) -> tuple[tuple[float, float], tuple[float, float]]:
    a = slot.end_angle_rad
    return ((reach * cos(a), reach * sin(a)), (-slot.away * reach * sin(a), slot.away * reach * cos(a)))


def _tolerances(d: InputPulleyDims) -> tuple[GeometricTolerance, ...]:
    """Lands run true to the common axis of the journals, and the steps for the bearings are square to it."""
    middle = (d.land_bottom_z + d.land_top_z) / 2
    lands = ((d.lower_land_radius, (d.land_bottom_z + middle) / 2), (d.upper_land_radius, (middle + d.land_top_z) / 2))
    steps = (
        ALONG_Z.square((d.lower_journal_radius, d.lower_neck_radius), (d.lower_neck_bottom_z,), 0.01, "D-E"),
        ALONG_Z.square((d.upper_journal_radius, d.upper_neck_radius), (d.upper_neck_top_z,), 0.01, "D-E"),
    )
    return (ALONG_Z.run_out(lands if d.stepped else lands[:1], 0.01, "D-E"), *steps)


def input_pulley_sheet(part: str, d: InputPulleyDims) -> Sheet:
    """Section along the axis, both ends with the slots of the cables' stops, slots and grooves as tables."""
    low, high = d.journal_bottom_z, d.journal_top_z
    diameters = _diameters(d)
    labels = []
    for slot, name in zip(d.slots, _NAMES, strict=False):
        lower = slot.face_z < slot.end_z
        radius = d.lower_land_radius if lower else d.upper_land_radius
        view, z = ("lower end", d.land_bottom_z) if lower else ("upper end", d.land_top_z)
        u, v = _directions(slot, radius + 0.6)
        labels += [Label(view, (*u, z), "u"), Label(view, (*v, z), "v")]
        pocket = _directions(slot, slot.bend_radius)[1]
        labels.append(Label(view, (*pocket, z), name, clear_mm=0.3, leader=True))
    slit = d.slit_width / 2
    named = {FITS["input_journal"].code: "journal", FITS["land"].code: "land", FITS["gear_shaft_bore"].code: "bore"}
    return Sheet(
        part=part,
        title=f"Input pulley {d.name}",
        paper="A3",
        views=(
            View(
                MAIN,
                right=Z,
                up=X,
                cut=(0.0, 0.0, 0.0),
                title="Section through the slit" if d.bore_radius else "Section",
                axes=(((0.0, 0.0, low), (0.0, 0.0, high)),),
            ),
            _end_view(d, True),
            _end_view(d, False),
        ),
        dimensions=(
            *_lengths(d),
            *diameters,
            *(
                [
                    Linear(
                        "lower end",
                        (d.lower_journal_radius - CHAMFER_MM, -slit, low),
                        (d.lower_journal_radius - CHAMFER_MM, slit, low),
                        d.slit_width,
                        "above",
                    )
                ]
                if d.bore_radius
                else ()
            ),
        ),
        labels=tuple(labels),
        tolerances=_tolerances(d),
        tables=(*([_slot_table(d)] if d.slots else ()), *([_groove_table(d)] if d.grooves else ())),
        fits=_fits(diameters, named, d),
        notes=(
            *((_GROOVES,) if d.grooves else ()),
            "Lands Ra 0.8.",
            *((_SLOTS, _SLOTS_FROM) if d.slots else ()),
            "+Z points from the slit's end, the lower one, to the upper. Slit along X, sawn through both sides of it."
            if d.bore_radius
            else "+Z points from the end that carries the driven wheel, the lower one, to the upper.",
            "Corners of the steps at most R0.1.",
        ),
    )


def _holding(d: InputPulleyDims) -> Holes:
    """Threads of a hub's set screws, or the holes for the screws of a servo's horn."""
    if d.horn is not None:
        places = tuple((x, y, d.journal_bottom_z) for x, y in d.horn.places)
        return Holes("S", 2 * d.horn.clearance, THROUGH, places, "lower end", "screws of the horn")
    assert d.hub is not None
    r, angles = d.lower_journal_radius, (tau * deg / 360.0 for deg in SET_SCREWS_DEG)
    places = tuple((r * cos(a) + 0.0, r * sin(a) + 0.0, d.hub.screw_z) for a in angles)
    return Holes("S", d.hub.thread, "to bore", places, "hub, radial", "set screws", threaded=True)


def overhung_pulley_sheet(part: str, d: InputPulleyDims) -> Sheet:
    """Of a pulley on the shaft of a motor or the horn of a servo: section through the bore, the grooves as a table."""
    low, high, c = d.journal_bottom_z, d.journal_top_z, CHAMFER_MM
    hub, land, on_horn = d.lower_journal_radius, d.lower_land_radius, d.horn is not None
    bore, fit = "" if on_horn else FITS["gear_shaft_bore"].code, "" if d.grooves else FITS["land"].code
    through, holes = d.bore_top_z >= high, (_holding(d),)
    diameters = (
        ALONG_Z.diameter(d.bore_radius, low, "left", fit=bore, datum="D"),
        ALONG_Z.diameter(hub, low + c, "left"),
        ALONG_Z.diameter(land, high, "right", fit=fit, decimals=3),
    )
    step = (
        ALONG_Z.length(low, d.lower_neck_bottom_z, "below", (hub - c, hub), suffix=" flange")
        if d.hub is None
        else ALONG_Z.length(low, d.hub.screw_z, "below", (hub - c, hub), suffix=" S")
    )
    circles = ((((0.0, 0.0, low), hypot(*d.horn.places[0])),)) if d.horn is not None else ()
    return Sheet(
        part=part,
        title=f"Input pulley {d.name}",
        paper="A3",
        views=(
            View(
                MAIN, right=Z, up=X, cut=(0.0, 0.0, 0.0), title="Section", axes=(((0.0, 0.0, low), (0.0, 0.0, high)),)
            ),
            View(
                "lower end",
                Y,
                X,
                column=1,
                axes=(((-hub, 0.0, low), (hub, 0.0, low)), ((0.0, -hub, low), (0.0, hub, low))),
                circles=circles,
                title="View of the lower end",
            ),
        ),
        dimensions=(
            step,
            ALONG_Z.length(low, d.land_bottom_z, "below", (hub - c, land), decimals=3),
            ALONG_Z.length(low, high, "below", (hub - c, land), decimals=3),
            *(() if through else (ALONG_Z.length(low, d.bore_top_z, "above", (hub - c, d.bore_radius)),)),
            ALONG_Z.chamfer(c, hub, low, 1.0, "above"),
            *diameters,
        ),
        labels=hole_labels(holes, "lower end") if on_horn else (),
        tolerances=(ALONG_Z.run_out(((land, (d.land_bottom_z + high) / 2),), 0.02, "D"),),
        tables=(
            hole_table(holes),
            *([position_table(holes, (0, 1), "Positions from the axis")] if on_horn else []),
            *([_groove_table(d)] if d.grooves else ()),
        ),
        holes=holes,
        fits=_fits(diameters, {FITS["land"].code: "land", bore: "bore"}, d),
        notes=(
            *((_GROOVES,) if d.grooves else ()),
            "Land Ra 0.8. +Z points from the lower end to the land."
            + (
                " Set screws along +X and +Y." if d.hub is not None else " Recess for the head of the horn's own screw."
            ),
            *(("Bored through.",) if through else ()),
        ),
    )
