"""Drives for the tests of this layout: the reference design, and random variations of its numbers."""

from dataclasses import replace
from functools import cache

from hypothesis import strategies as st

from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive, BevelRun
from tests.support.reference import ROOT


@cache
def reference() -> BevelDrive:
    """The drive of params/mbcdm.yaml."""
    return load_design(ROOT / "params" / "mbcdm.yaml").drive


def mirrored(drive: BevelDrive) -> BevelDrive:
    """The drive with every cable on the other side of the drum: its mirror image in x as far as cables go."""
    cables = tuple(replace(c, drum_side=-c.drum_side, input_side=-c.input_side) for c in drive.cables)
    return replace(drive, cables=cables, input_sides=tuple(-s for s in drive.input_sides))


@st.composite
def drives(draw: st.DrawFn) -> BevelDrive:
    """Radii, centre distance, lead, travel, rope and sides drawn at random; Eq. (1) holds for every cable."""
    first = reference()
    smallest = draw(st.floats(3.0, 20.0))
    growth = draw(st.floats(0.01, 0.2))
    input_to_guide, guide_to_drum = draw(st.floats(0.7, 3.0)), draw(st.floats(1.5, 8.0))
    sides = draw(st.sampled_from([(1, -1, -1, 1), (-1, 1, 1, -1), (1, -1, 1, -1), (-1, 1, -1, 1)]))
    flip = draw(st.sampled_from([1, -1]))
    cables: list[BevelRun] = []
    for k, (run, side) in enumerate(zip(first.cables, sides, strict=True)):
        r_m = smallest * (1 + growth * k)
        r_g = r_m * input_to_guide
        cables.append(
            replace(
                run,
                drum_side=side,
                input_side=run.input_side * flip,
                input_radius_mm=r_m,
                guide_radius_mm=r_g,
                drum_radius_mm=r_g * guide_to_drum,
            )
        )
    # Thin enough to be bent inward on the smallest pulley, as the checks demand.
    diameter = min(draw(st.floats(0.3, 2.0)), smallest / 8)
    reach = cables[-1].input_radius_mm + cables[-1].guide_radius_mm
    return replace(
        first,
        cables=tuple(cables),
        input_sides=tuple(s * flip for s in first.input_sides),
        cable=replace(first.cable, diameter_mm=diameter),
        centre_distance_mm=reach * draw(st.floats(1.05, 4.0)),
        helix_lead_mm=diameter * draw(st.floats(1.01, 1.4)),
        dead_turns=draw(st.floats(0.2, 2.5)),
        half_travel_deg=draw(st.floats(3.0, 60.0)),
    )
