"""The transfer point: four step planes on one pitch line, lands wide enough, bodies close but clear.

Step k's transfer point is (0, +r_gk, r_ok): the guide's step is the plane z = r_ok, the drum's step the plane y = r_gk.
By Eq. (1) all four lie on a line through the apex, the pitch line of a bevel pair. Half planes x = 0 decide, since both
bodies are round and reach furthest there.
"""

from __future__ import annotations

from math import hypot

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, at_most, worst
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.configurations.miso_bevel.design_under_test import BevelUnderTest

# A tenth of what good turning holds on a step plane: rounding of the drawing, not of the part.
PITCH_LINE_MM = 0.001
# Edges of lands are broken by no more than this, so the contact line must lie further from them (derived).
EDGE_BREAK_MM = 0.1
# Run-out of guide and drum together: 0.02 mm each and what their bearings add (estimate).
RUN_OUT_MM = 0.05


def pitch_line(s: BevelUnderTest) -> Comparison:
    """Distance of each transfer point from the line through the apex and the outermost transfer point."""
    outer = s.steps[-1]
    length = hypot(outer.guide_radius_mm, outer.drum_radius_mm)
    return worst(
        at_most(
            f"transfer point of step {c.step} (y {c.guide_radius_mm:g}, z {c.drum_radius_mm:g}) off the pitch line",
            abs(c.guide_radius_mm * outer.drum_radius_mm - c.drum_radius_mm * outer.guide_radius_mm) / length,
            PITCH_LINE_MM,
            "mm",
        )
        for c in s.steps[:-1]
    )


def radii_rise(s: BevelUnderTest) -> Comparison:
    """Guide and drum radii rise together from step to step."""
    return worst(
        at_least(f"{body} radius of step {b.step} over step {a.step}", rise, EDGE_BREAK_MM, "mm")
        for a, b in zip(s.steps[:-1], s.steps[1:], strict=True)
        for body, rise in (
            ("guide", b.guide_radius_mm - a.guide_radius_mm),
            ("drum", b.drum_radius_mm - a.drum_radius_mm),
        )
    )


def land_width(s: BevelUnderTest) -> Comparison:
    """Step of the guide's radius against half a cable plus the edge margin: what is left is the flank's gap.

    The land's edge must lie between a cable's flank and the next cable's contact line: delta r_g >= d/2 + edge margin.
    """
    need = s.flank_mm + s.drive.clearances.land_edge_mm
    return worst(
        at_least(
            f"drum land of step {a.step}: delta r_g",
            b.guide_radius_mm - a.guide_radius_mm,
            need,
            "mm",
            f"d/2 {s.flank_mm:g} + edge margin {s.drive.clearances.land_edge_mm:g}; flank gap "
            f"{b.guide_radius_mm - a.guide_radius_mm - need:.4g} mm along the whole wrap",
        )
        for a, b in zip(s.steps[:-1], s.steps[1:], strict=True)
    )


def land_edge(s: BevelUnderTest) -> Comparison:
    """Contact line of every cable clear of the broken edge of its land."""
    lands = s.layout.drum.lands
    return worst(
        at_least(
            f"contact line of {c.name} from its land's edge", c.guide_radius_mm - land.y_start, EDGE_BREAK_MM, "mm"
        )
        for c, land in zip(s.steps, lands, strict=True)
    )


def outermost_land(s: BevelUnderTest) -> Comparison:
    """The last land carries its cable's whole flank before the drum's outer face."""
    c = s.steps[-1]
    return at_least(
        f"drum's outer face beyond the flank of {c.name}",
        s.drive.drum.outer_face_y_mm - c.guide_radius_mm - s.flank_mm,
        EDGE_BREAK_MM,
        "mm",
    )


def body_gaps_mm(s: BevelUnderTest) -> list[tuple[str, int, float]]:
    """Gap of every guide step to every drum land in the half plane x = 0: along y or along z, whichever parts them.

    What it is between, the place of the guide's step among the steps, the gap.
    """
    lands, guide = s.layout.drum.lands, s.layout.guide
    starts = [guide.bottom_z, *guide.walls_z]
    return [
        (
            f"guide step {j + 1} to drum land {k + 1}",
            j,
            max(land.y_start - surface, bottom - land.surface_radius_mm),
        )
        for j, (surface, bottom) in enumerate(zip(guide.surface_radii, starts, strict=True))
        for k, land in enumerate(lands)
    ]


def bodies_clear(s: BevelUnderTest) -> Comparison:
    """Guide and drum never touch, walls included."""
    return worst(at_least(name, gap, RUN_OUT_MM, "mm") for name, _, gap in body_gaps_mm(s))


def transfer_gap(s: BevelUnderTest) -> Comparison:
    """At every transfer point guide and drum stand closer than half a cable, so that none slips in between."""
    lands, guide = s.layout.drum.lands, s.layout.guide
    return worst(
        at_most(f"gap at the transfer of step {land.step}", land.y_start - surface, s.flank_mm, "mm")
        for land, surface in zip(lands, guide.surface_radii, strict=True)
    )


CHECKS = (
    Check(
        "pitch_line",
        "Transfer points on one pitch line",
        "derived from paper Eq. (1): pitch cone",
        pitch_line,
        advice="keep r_o/r_g equal for all steps, as transmission.ratios does",
    ),
    Check(
        "radii_rise",
        "Radii of guide and drum rise together",
        "derived: pitch cone",
        radii_rise,
        advice="order the radii from step 1, the smallest, to step 4",
    ),
    Check(
        "land_width",
        "Drum lands wide enough for half a cable and the edge",
        "derived: delta r_g >= d/2 + edge margin",
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
        "Guide and drum do not touch",
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
        "Guide and drum closer than half a cable",
        "derived: a wider gap lets a cable slip in",
        transfer_gap,
        adjust=(down("clearances.transfer_gap_mm"), up("clearances.land_edge_mm"), up("rope diameter_mm")),
    ),
)
