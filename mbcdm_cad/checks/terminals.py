"""Terminals on the drum: room, strength of studs and lugs, and their adjustment."""

from collections.abc import Iterator
from itertools import combinations
from math import acos, atan2, degrees, hypot
from typing import Any

import numpy as np

from mbcdm_cad.checks.comparison import Comparison, Family, Findings, at_most, check, noted
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.checks.geometry import Points, box_gap, polygon_gap
from mbcdm_cad.checks.springs import led
from mbcdm_cad.design.catalogue import package_entries, smallest_entry
from mbcdm_cad.design.paths import at
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.parts.drum_sector.dims import LUG_ROOT_MM, POCKET_LEAD_MM, DrumDims
from mbcdm_cad.parts.drum_sector.sizes import SWAGE_FLOOR_MM, nut_corner_radius_mm
from mbcdm_cad.parts.terminal import CHAMFER_MM, Tensioner, take_up_of

# Gap between two terminals, and between terminal and cable (estimate: no tool between them, nothing moves).
TERMINAL_GAP_MM = 0.1
# Straight wall left between two rounded corners of a pocket (estimate).
CORNER_ROOM_MM = 0.1
# Yield over stress (usual for steady loads on ductile metal).
STUD_SAFETY = 2.0
LUG_SAFETY = 2.0
# A nut engages with all its threads if the stud projects by this many pitches (usual rule).
THREAD_OUT_PITCHES = 1.0
# Thread run-out behind the sleeve, in pitches, on which no nut can run.
RUN_OUT_PITCHES = 2.0
# A terminal that turns further than this twists the rope while its nut is turned (estimate).
TWIST_DEG = 20.0
# Reason why checks between terminals do not apply if each side of the drum has one terminal.
_ALONE = noted("terminals beside another one", 0.0, "")
_ROOM = up("all radii of transmission", at.drum.outer_face_y_mm)
_SMALLER = "choose a smaller drum.tensioner"

ON_THE_DRUM = Family(
    "Terminals on the drum: distance to each other, lands and lugs on solid rim, strength of studs and lugs."
)


def bodies_of(s: SectorLayout, t: Tensioner, moved: bool = True) -> list[tuple[str, Points, float, float]]:
    """(name, outline in x, z, lowest y, highest y) of the pieces of a terminal and of its lug.

    ``moved``: the space that they need over the whole travel of the terminal, as a polygon; else what bounds them at
    preload, without the stud's chamfered edge.
    """
    start, end, tip = (t.slack_start, t.last_end, t.last_tip) if moved else (t.swage_start, t.swage_end, t.tip)
    spec, d = s.drive.tensioner, s.drum
    nut = nut_corner_radius_mm(s.drive)
    swage, stud, lug = spec.swage_diameter_mm / 2, spec.thread_mm / 2, d.lug_half_width

    def outline(start: float, end: float, low: float, high: float) -> Points:
        return np.array([t.at(start, low), t.at(end, low), t.at(end, high), t.at(start, high)])

    def chamfered(start: float, end: float, half: float) -> Points:
        c = CHAMFER_MM
        return np.concatenate([outline(start, end - c, -half, half), outline(start, end, c - half, half - c)])

    stud_outline = outline(end, tip, -stud, stud) if moved else chamfered(end, tip, stud)
    return [
        ("swage", outline(start, end, -swage, swage), t.y_mm - swage, t.y_mm + swage),
        ("stud", stud_outline, t.y_mm - stud, t.y_mm + stud),
        ("nuts", outline(t.lug_end, t.nuts_end, -nut, nut), t.y_mm - nut, t.y_mm + nut),
        ("lug", outline(t.lug_start, t.lug_end, -d.lug_root(t), lug), *d.lug_y(t)),
    ]


def _pairs(d: DrumDims) -> Iterator[tuple[Tensioner, Tensioner]]:
    """(inner, outer) terminals of one side."""
    for a, b in combinations(sorted(d.tensioners, key=lambda t: t.radius_mm), 2):
        if a.side == b.side:
            yield a, b


def _fitting_tensioner(s: SectorLayout) -> str:
    """The smallest tensioner of the package whose sleeve takes the rope, and springs that its stud leads."""
    end, d = s.drive.termination, s.drive.cable.diameter_mm

    def fits(entry: dict[str, Any]) -> bool:
        grip = entry["swage_length_mm"] - SWAGE_FLOOR_MM >= end.grip_ratio * d
        return grip and bool(entry["swage_diameter_mm"] >= end.sleeve_ratio * d)

    if name := smallest_entry("tensioners", "swage_diameter_mm", fits):
        spring = s.drive.spring
        if spring is None or led(spring, thread_mm := package_entries("tensioners")[name]["thread_mm"]):
            return f"choose drum.tensioner: {name}"
        springs = [e.name for e in s.drive.springs if led(e, thread_mm) and e.usable_N >= s.loads.highest_N]
        return f"choose drum.tensioner: {name}, with drum.spring: {' or '.join(springs) or 'left out'}"
    return "add a tensioner with a larger sleeve to catalogue: tensioners:, or choose a thinner rope"


@check("Sleeves of the terminals take the rope", "catalogue of terminations", advice=_fitting_tensioner, unit="d")
def sleeve_fits(s: SectorLayout) -> Findings:
    """The terminal's sleeve has enough wall round the rope, and is long enough to hold it."""
    end, spec, d = s.drive.termination, s.drive.tensioner, s.drive.cable.diameter_mm
    yield f"sleeve of {spec.name} over the rope's diameter", spec.swage_diameter_mm / d, end.sleeve_ratio
    what = f"rope in the sleeve of {spec.name} over its diameter"
    yield what, (spec.swage_length_mm - SWAGE_FLOOR_MM) / d, end.grip_ratio


@check("Terminals of one side do not touch", "derived; 0.1 mm: estimate", *_ROOM, advice=_SMALLER, none=_ALONE)
def terminals_apart(s: SectorLayout) -> Findings:
    """Gap between neighbouring terminals and lugs on one side, including the corners of the nuts."""
    nearest = np.inf
    for a, b in _pairs(s.drum):
        others = bodies_of(s, b)
        for name, outline, low, high in bodies_of(s, a):
            for other, other_outline, other_low, other_high in others:
                along_y = max(other_low - high, low - other_high)
                if max(along_y, box_gap(outline, other_outline)) > nearest:
                    continue
                gap = along_y if along_y >= TERMINAL_GAP_MM else max(along_y, polygon_gap(outline, other_outline))
                nearest = min(nearest, gap)
                what = f"{name} of {a.cable_name} to {other} of {b.cable_name}"
                yield what, gap, TERMINAL_GAP_MM


@check(
    "Stated angles of terminals are inside the sector",
    "derived",
    *up(at.drum.sector_half_angle_deg),
    advice="state a smaller terminal_angle_deg for this cable, or leave it out",
    none=noted("no angle of a terminal is stated", 0.0, ""),
)
def terminal_angles(s: SectorLayout) -> Findings:
    """Angles at which the file asks for terminals, against the furthest at which they are inside the sector."""
    for c in s.drive.cables:
        if c.terminal_angle_rad is not None:
            what = f"terminal of {c.name}, from the direction of {s.before_drum}"
            yield at_most(what, degrees(c.terminal_angle_rad), degrees(s.terminal_of(c).furthest_rad), "deg")


@check("Lands and lugs stand on solid rim", "derived", *_ROOM, advice=_SMALLER, none=_ALONE)
def lands_intact(s: SectorLayout) -> Findings:
    """No pocket cuts into a land, into the root of a lug, or into the path of a neighbouring cable."""
    d, half, wall = s.drum, s.flank_mm, s.drive.drum_material.min_wall_mm
    lands = {c.name: d.lands[k] for k, c in enumerate(s.steps)}
    for a, b in _pairs(d):
        inner, outer = lands[a.cable_name], lands[b.cable_name]
        # Along the rim: where the inner pocket begins, and where the outer lug ends.
        apart = (a.anchor_rad - (b.anchor_rad + atan2(b.lug_end, b.radius_mm))) * b.radius_mm
        pocket_top = hypot(a.radius_mm + a.pocket_top, a.last_tip)
        above = -np.inf if a.cut_through else outer.surface_radius_mm - pocket_top
        names = f"{a.cable_name} and {b.cable_name}"
        yield f"land of {b.cable_name} over the pocket of {a.cable_name}", max(apart, above - wall), 0.0
        what = f"pocket of {b.cable_name} over the land of {a.cable_name}"
        yield what, b.radius_mm - d.nut_pocket - inner.surface_radius_mm, TERMINAL_GAP_MM
        yield (
            f"lug of {b.cable_name} over {a.cable_name}",
            max(b.radius_mm - d.lug_root(b) - a.radius_mm, b.y_mm - d.lug_half_width - a.y_mm) - half,
            TERMINAL_GAP_MM,
        )
        if apart < 0.0:
            yield f"cable over terminal where they pass, {names}", b.radius_mm - half - pocket_top, TERMINAL_GAP_MM


@check("Rim reaches beyond the terminals", "derived", *up(at.drum.outer_face_y_mm), advice=_SMALLER)
def outer_face(s: SectorLayout) -> Findings:
    """Distance from the rim's outer face to the outermost nut or lug."""
    d = s.drum
    half = max(nut_corner_radius_mm(s.drive), d.stud_hole_radius + s.drive.drum_material.min_wall_mm)
    for t in d.tensioners:
        if not t.front:
            yield f"rim beyond the terminal of {t.cable_name}", d.lands[-1].y_end - t.y_mm - half, 0.0


@check(
    "Cutter fits into the pockets",
    "material: min_internal_radius_mm",
    advice="choose a drum.material of smaller internal radius, or a larger drum.tensioner",
)
def pocket_corners(s: SectorLayout) -> Findings:
    """The pockets for swage and nuts are longer and wider than the rounded corners that the cutter leaves."""
    d = s.drum
    rooms = [
        (f"{name} of {t.cable_name}", min(length, half + t.pocket_top))
        for t in d.tensioners
        for name, length, half in (
            ("swage", t.lug_start - t.slack_start + POCKET_LEAD_MM, d.flat_wall),
            ("nuts", t.pocket_end - t.lug_end, d.nut_pocket),
        )
    ]
    for name, room in rooms:
        yield f"room for the {name} over two corner radii", room - 2 * d.pocket_radius, CORNER_ROOM_MM


@check(
    "Stress in the tensioner studs",
    "material: yield_MPa; 2: usual rule",
    *down(at.loads.peak_torque_Nm, at.rope.preload_N),
    advice="choose a larger drum.tensioner",
    unit="times",
)
def stud_stress(s: SectorLayout) -> Findings:
    """Tensile stress of the stud at the largest cable force, against the yield stress."""
    spec = s.drive.tensioner
    strength = s.drive.material(spec.material).yield_MPa
    stress = s.loads.highest_N / spec.stress_area_mm2
    yield f"yield {strength:g} MPa of {spec.material} over the stud's {stress:.4g} MPa", strength / stress, STUD_SAFETY


@check(
    "Stress in the lugs",
    "material: yield_MPa; 2: usual rule",
    *up(at.drum.outer_face_y_mm),
    *down(at.loads.peak_torque_Nm, at.rope.preload_N),
    unit="times",
)
def lug_stress(s: SectorLayout) -> Findings:
    """Bending stress at the root of the lug; only the metal between the slot and the outer face counts.

    A lug of a whole drum, which no wider rim makes wider, has its full width where it is rooted below its slot.
    """
    d = s.drum
    strength = s.drive.drum_material.yield_MPa
    for t in d.tensioners:
        back, front = d.lug_y(t)
        width = (t.y_mm - back if t.front else front - t.y_mm) - d.stud_hole_radius
        if width <= 0.0:
            slot = t.y_mm - d.stud_hole_radius if t.front else t.y_mm + d.stud_hole_radius
            raise NoFigureError(
                f"the rim ends before the lug of {t.cable_name} has any metal: at y = {d.lands[-1].y_end:.4g} mm, "
                f"and the slot for the stud reaches to {slot:.4g} mm"
            )
        root = d.lug_root(t)
        least = min(root, d.flat_wall + LUG_ROOT_MM)
        per_mm2 = max(least / width, root / (front - back)) if d.whole else root / width
        stress = s.loads.highest_N * 6 * per_mm2 / (t.lug_end - t.lug_start) ** 2
        what = f"yield {strength:g} MPa over the bending stress {stress:.4g} MPa in the lug of {t.cable_name}"
        yield what, strength / stress, LUG_SAFETY


ADJUSTMENT = Family(
    "Adjustment of the terminals: take-up from slack to the highest preload, thread under both nuts, twist of the rope."
)


def _longer_stud(s: SectorLayout) -> str:
    """A longer stud, and a rope that beds in less where that is most of what is asked."""
    needs = [take_up_of(s.drive, c, mm) for c, mm in zip(s.drive.cables, s.tensioned_lengths_mm(), strict=True)]
    beds = any(2 * need.bedding_m > need.total_m for need in needs)
    return "choose a drum.tensioner with a longer stud" + (", or a rope that beds in less" if beds else "")


@check(
    "Terminals reach the preload",
    "derived: T l / EA + bedding-in + cut length",
    *down(at.rope.preload_N),
    advice=_longer_stud,
)
def take_up(s: SectorLayout) -> Findings:
    """Adjustment length of each terminal with thread under nut and lock nut, against the length that its cable needs.

    Asked: stretch at the highest preload, bedding-in, both ends of the cut length's tolerance.
    """
    pitch = s.drive.tensioner.pitch_mm
    for c, length, t in zip(s.drive.cables, s.tensioned_lengths_mm(), s.terminals, strict=True):
        need = take_up_of(s.drive, c, length)
        # If the stud does not reach through both nuts at the start, the usable take-up begins later.
        short = max(0.0, t.nuts_end + THREAD_OUT_PITCHES * pitch - (t.tip - t.drawn_in))
        note = (
            f"stretch {need.elastic_m * 1e3:.3g} mm, bedding-in {need.bedding_m * 1e3:.3g} mm, "
            f"cut length {need.cut_m * 1e3:.3g} mm"
        ) + (f", ends that tighten {need.setting_m * 1e3:.3g} mm" if need.setting_m else "")
        yield f"take-up for {c.name}", t.travel - short, need.total_m * 1e3, note


@check(
    "Nut stays on the thread with the terminal drawn in",
    "two pitches of run-out: usual rule",
    advice="choose a drum.tensioner with a thicker lug",
)
def thread_at_end(s: SectorLayout) -> Findings:
    """Thread that is left at the lug for the nut when the terminal is drawn in completely."""
    spec = s.drive.tensioner
    for t in s.drum.tensioners:
        what = f"back of the lug to the sleeve of {t.cable_name}, drawn in"
        yield what, t.lug_end - t.last_end, RUN_OUT_PITCHES * spec.pitch_mm


@check(
    "Terminals cannot turn with their nuts",
    "derived; 20 degrees: estimate",
    advice="choose a drum.tensioner with deeper flats",
)
def terminal_twist(s: SectorLayout) -> Comparison:
    """Angle by which a terminal turns with its nut before the flat of its sleeve touches the wall of the pocket."""
    spec, wall = s.drive.tensioner, s.drum.flat_wall
    corner, flat = spec.swage_diameter_mm / 2, spec.swage_flats_mm / 2
    # After a rotation a, the corner of the flat lies corner cos(h - a) below the axis, h its angle from the flat's
    # middle.
    middle_to_corner = acos(min(1.0, flat / corner))
    turn = 180.0 if wall >= corner else degrees(middle_to_corner - acos(wall / corner))
    return at_most("turn of a terminal until its flat is held", turn, TWIST_DEG, "deg")
