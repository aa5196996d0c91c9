"""The transfer point: step planes on one pitch line, lands wide enough, bodies close but not touching.

Step k's transfer point is (0, +r_k, r_ok), r_k the radius of the pulley before the drum: its step is the plane
z = r_ok, the drum's step the plane y = r_k. By Eq. (1) all lie on a line through the apex, the pitch line of a bevel
pair. Gaps are computed in the half planes x = 0, where the two round bodies are nearest.
"""

from __future__ import annotations

from math import hypot

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, at_most, worst
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.layouts.sector import SectorLayout

# A tenth of the tolerance of good turning on a step plane: allows for rounding of nominal dimensions only.
PITCH_LINE_MM = 0.001
# Largest chamfer of the edges of lands; the contact line must lie further from the edge (derived).
EDGE_BREAK_MM = 0.1
# Run-out of both bodies together: 0.02 mm each and that of their bearings (estimate).
RUN_OUT_MM = 0.05


def pitch_line(s: SectorLayout) -> Comparison:
    """Distance of each transfer point from the line through the apex and the outermost transfer point."""
    outer = s.steps[-1]
    length = hypot(outer.land_y_mm, outer.drum_radius_mm)
    return worst(
        at_most(
            f"transfer point of step {c.step} (y {c.land_y_mm:g}, z {c.drum_radius_mm:g}) off the pitch line",
            abs(c.land_y_mm * outer.drum_radius_mm - c.drum_radius_mm * outer.land_y_mm) / length,
            PITCH_LINE_MM,
            "mm",
        )
        for c in s.steps[:-1]
    )


def radii_rise(s: SectorLayout) -> Comparison:
    """From step to step the radii of both bodies increase together."""
    return worst(
        at_least(f"{body} radius of step {b.step} over step {a.step}", rise, EDGE_BREAK_MM, "mm")
        for a, b in zip(s.steps[:-1], s.steps[1:], strict=True)
        for body, rise in ((s.before_drum, b.land_y_mm - a.land_y_mm), ("drum", b.drum_radius_mm - a.drum_radius_mm))
    )


def land_width(s: SectorLayout) -> Comparison:
    """The radius increases from step to step by at least half a cable plus the edge margin; the rest is a gap.

    The land's edge must lie between a cable's flank and the next cable's contact line: delta r_k >= d/2 + edge margin.
    """
    need = s.flank_mm + s.drive.clearances.land_edge_mm
    return worst(
        at_least(
            f"drum land of step {a.step}: delta r_{s.before_drum[0]}",
            b.land_y_mm - a.land_y_mm,
            need,
            "mm",
            f"d/2 {s.flank_mm:g} + edge margin {s.drive.clearances.land_edge_mm:g}; flank gap "
            f"{b.land_y_mm - a.land_y_mm - need:.4g} mm along the whole wrap",
        )
        for a, b in zip(s.steps[:-1], s.steps[1:], strict=True)
    )


def land_edge(s: SectorLayout) -> Comparison:
    """Distance from the contact line of every cable to the broken edge of its land."""
    lands = s.drum.lands
    return worst(
        at_least(f"contact line of {c.name} from its land's edge", c.land_y_mm - land.y_start, EDGE_BREAK_MM, "mm")
        for c, land in zip(s.steps, lands, strict=True)
    )


def outermost_land(s: SectorLayout) -> Comparison:
    """The outermost land is wide enough for its cable up to the drum's outer face."""
    c = s.steps[-1]
    return at_least(
        f"drum's outer face beyond the flank of {c.name}",
        s.drive.drum.outer_face_y_mm - c.land_y_mm - s.flank_mm,
        EDGE_BREAK_MM,
        "mm",
    )


def body_gaps_mm(s: SectorLayout) -> list[tuple[str, int, float]]:
    """Gaps between every step before the drum and every drum land in the half plane x = 0, along y or z, in mm.

    Each with its description, the index of the step and the gap.
    """
    return [
        (
            f"{s.before_drum} step {j + 1} to drum land {k + 1}",
            j,
            max(land.y_start - surface, bottom - land.surface_radius_mm),
        )
        for j, (surface, bottom) in enumerate(s.steps_before_drum)
        for k, land in enumerate(s.drum.lands)
    ]


def bodies_clear(s: SectorLayout) -> Comparison:
    """The smallest gap between the two bodies, including the walls of their steps."""
    return worst(at_least(name, gap, RUN_OUT_MM, "mm") for name, _, gap in body_gaps_mm(s))


def transfer_gap(s: SectorLayout) -> Comparison:
    """At every transfer point the gap between the bodies is less than half a cable, so that no cable slips into it."""
    return worst(
        at_most(f"gap at the transfer of step {land.step}", land.y_start - surface, s.flank_mm, "mm")
        for land, (surface, _) in zip(s.drum.lands, s.steps_before_drum, strict=True)
    )


def transfer_checks(body: str, keep_on_line: str) -> tuple[Check, ...]:
    """The family; ``body``: the body before the drum, ``keep_on_line``: how its radii stay on the pitch line."""
    return (
        Check(
            "pitch_line",
            "Transfer points on one pitch line",
            "derived from paper Eq. (1): pitch cone",
            pitch_line,
            advice=keep_on_line,
        ),
        Check(
            "radii_rise",
            f"Radii of {body} and drum rise together",
            "derived: pitch cone",
            radii_rise,
            advice="order the radii from step 1, the smallest, upwards",
        ),
        Check(
            "land_width",
            "Drum lands wide enough for half a cable and the edge",
            f"derived: delta r_{body[0]} >= d/2 + edge margin",
            land_width,
            adjust=(down("rope diameter_mm"), down("clearances.land_edge_mm"), up("all radii of transmission")),
        ),
        Check(
            "land_edge",
            "Contact lines clear of the lands' edges",
            "derived: edges broken by up to 0.1 mm",
            land_edge,
            adjust=(up("clearances.land_edge_mm"), down("clearances.transfer_gap_mm")),
        ),
        Check(
            "outermost_land",
            "Outermost land carries its cable",
            "derived",
            outermost_land,
            adjust=(up("drum.outer_face_y_mm"),),
        ),
        Check(
            "bodies_clear",
            f"{body.capitalize()} and drum do not touch",
            "paper section 2.2 (placed closely); run-out of 0.05 mm: estimate",
            bodies_clear,
            adjust=(
                up("clearances.transfer_gap_mm"),
                down("clearances.land_edge_mm"),
                up("rope diameter_mm"),
                up("all radii of transmission"),
            ),
        ),
        Check(
            "transfer_gap",
            f"{body.capitalize()} and drum closer than half a cable",
            "derived: a wider gap lets a cable slip in",
            transfer_gap,
            adjust=(down("clearances.transfer_gap_mm"), up("clearances.land_edge_mm"), up("rope diameter_mm")),
        ),
    )
