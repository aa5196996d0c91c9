"""Eq. (1) row by row, equal total ratio of both inputs, and the tension that a difference causes.

The paper prints the third row with r_g1 and r_g2; the right input runs on steps 3 and 4, so it must be r_g3 and r_g4.
The checks use nominal radii, with a tolerance far below that of machining: they find errors of the design, not of
parts.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mbcdm_cad.checks.bending import anchor_check, bending_checks
from mbcdm_cad.checks.comparison import Check, Comparison, at_most, noted, worst
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.checks.ratios import RATIO_TOLERANCE, SURFACE_RADIUS, SURFACE_TOLERANCE_MM, pair_mismatch, spread
from mbcdm_cad.layouts.miso_bevel.cable_path import stop_of
from mbcdm_cad.layouts.miso_bevel.drive import BevelRun
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.parts.input_pulley.dims import InputPulleyDims

EQ1 = "paper Eq. (1)"


def guide_to_drum(s: BevelLayout) -> Comparison:
    """Row 1: r_g/r_o is the same for all four steps."""
    return spread("r_g/r_o", [c.guide_radius_mm / c.drum_radius_mm for c in s.steps], s.steps)


def _own(s: BevelLayout, index: int) -> list[BevelRun]:
    return [c for c in s.steps if c.input_name == s.drive.input_names[index]]


def first_input(s: BevelLayout) -> Comparison:
    """Row 2: r_m/r_g is the same for both cables of the first input."""
    own = _own(s, 0)
    return spread(f"{own[0].input_name} r_m/r_g", [c.input_radius_mm / c.guide_radius_mm for c in own], own)


def second_input(s: BevelLayout) -> Comparison:
    """Row 3, corrected: r_m/r_g is the same for both cables of the second input, with the guide steps of that input."""
    own = _own(s, 1)
    steps = " and ".join(f"r_g{c.step}" for c in own)
    note = f"over {steps}; the paper prints r_g1, r_g2"
    return spread(f"{own[0].input_name} r_m/r_g", [c.input_radius_mm / c.guide_radius_mm for c in own], own, note)


def equal_total_ratio(s: BevelLayout) -> Comparison:
    """i_c = r_o/r_m is the same for both inputs; otherwise the inputs work against each other through the drum."""
    mean = [float(np.mean([c.drum_radius_mm / c.input_radius_mm for c in _own(s, i)])) for i in (0, 1)]
    names = s.drive.input_names
    return at_most(
        f"total ratio {mean[0]:.6g} of {names[0]}, {mean[1]:.6g} of {names[1]}: difference",
        abs(mean[1] / mean[0] - 1.0),
        RATIO_TOLERANCE,
        "relative",
    )


def _surface_hint(s: BevelLayout) -> str:
    """Whether the radii would satisfy Eq. (1) with half a cable added: then surface radii were entered."""
    half = s.flank_mm
    pitch = [(c.drum_radius_mm + half, c.guide_radius_mm + half, c.input_radius_mm + half) for c in s.steps]
    rows = [g / o for o, _, g in pitch]
    if max(abs(r / rows[0] - 1.0) for r in rows) <= RATIO_TOLERANCE:
        return (
            f"with d/2 = {half:g} mm added to every radius the ratios agree: these look like surface radii; "
            "give pitch radii, to the cable's centre line"
        )
    ratio = s.steps[0]
    i_g, i_c = ratio.drum_radius_mm / ratio.guide_radius_mm, ratio.drum_radius_mm / ratio.input_radius_mm
    guide = ", ".join(f"{c.drum_radius_mm / i_g:.5g}" for c in s.steps)
    pulley = ", ".join(f"{c.drum_radius_mm / i_c:.5g}" for c in s.steps)
    return f"with step 1 kept, guide_radii_mm: [{guide}] and input_radii_mm: [{pulley}] satisfy Eq. (1)"


def path_length(s: BevelLayout) -> Comparison:
    """Length that helix and fleet angle add to a cable at the ends of travel; no choice of radii removes it."""
    (_, back), (_, centred), (_, forward) = s.extreme_paths
    drift = [[end[k].length_mm - centred[k].length_mm for end in (back, forward)] for k in range(len(centred))]
    # The odd part turns the drum, the same for all cables; only the even part stretches the cables.
    even = [abs(sum(d)) / 2 for d in drift]
    k = int(np.argmax(even))
    stiffness = s.drive.cable.axial_stiffness_N / max(centred[k].length_mm, 1e-9)
    return noted(
        f"{s.drive.cables[k].name} is longer at the ends of travel than centred by",
        even[k],
        "mm",
        f"{even[k] * stiffness:.3g} N if spread over its whole length; from the fleet angle, not the radii",
    )


RATIOS = (
    Check("eq1_guide_drum", "Eq. (1) row 1: guide to drum", EQ1, guide_to_drum, advice=_surface_hint),
    Check("eq1_first_input", "Eq. (1) row 2: first input to guide", EQ1, first_input, advice=_surface_hint),
    Check(
        "eq1_second_input",
        "Eq. (1) row 3: second input to guide",
        EQ1 + ", its slip corrected: r_g3, r_g4",
        second_input,
        advice=_surface_hint,
    ),
    Check("equal_total_ratio", "Both inputs have one total ratio", "derived", equal_total_ratio, advice=_surface_hint),
    Check(
        "pair_mismatch",
        "Cables of one input agree over the travel",
        "derived; a tenth of the preload: estimate",
        pair_mismatch,
        advice=_surface_hint,
    ),
    Check("path_length", "Length added by helix and fleet angle", "derived", path_length),
)


def cut_at_pitch(s: BevelLayout) -> Comparison:
    """The layout cuts every surface at the pitch radius less d/2, so that all cables keep one ratio."""
    cut: list[tuple[str, float, float]] = []
    for k, c in enumerate(s.steps):
        cut.append((f"guide, {c.name}", s.guide.surface_radii[k], c.guide_radius_mm))
        cut.append((f"drum, {c.name}", s.drum.lands[k].surface_radius_mm, c.drum_radius_mm))
    for pulley in s.inputs:
        own = [c for c in s.steps if c.input_name == pulley.name]
        for c, surface in zip(own, _surfaces(s, pulley), strict=True):
            cut.append((f"input pulley, {c.name}", surface, c.input_radius_mm))
    ratios = ", ".join(
        f"{(land.surface_radius_mm + s.flank_mm) / (surface + s.flank_mm):.6g}"
        for land, surface in zip(s.drum.lands, _input_surfaces(s), strict=True)
    )
    return worst(
        at_most(
            f"surface of {name} from pitch radius less d/2",
            abs(surface + s.flank_mm - pitch),
            SURFACE_TOLERANCE_MM,
            "mm",
            f"total ratios at the cables' centre lines {ratios}",
        )
        for name, surface, pitch in cut
    )


def _input_surfaces(s: BevelLayout) -> list[float]:
    by_name = {p.name: p for p in s.inputs}
    found = []
    for c in s.steps:
        own = [o.step for o in s.steps if o.input_name == c.input_name]
        pulley = by_name[c.input_name]
        found.append(_surfaces(s, pulley)[c.step != min(own)])
    return found


def _surfaces(s: BevelLayout, pulley: InputPulleyDims) -> tuple[float, float]:
    """Surface radii of the pulley's two steps by their place along Z, the lower first."""
    radii = (pulley.lower_surface_radius, pulley.upper_surface_radius)
    return (radii[1], radii[0]) if s.drive.motors_above else radii


SURFACES = (
    SURFACE_RADIUS,
    Check(
        "cut_at_pitch",
        "Surfaces are cut half a cable inside the pitch radii",
        "derived from paper Table 2, which gives pitch radii",
        cut_at_pitch,
        advice="the layout room cuts at r - d/2; this fails only if that is changed",
    ),
)


def _stop_bends_mm(s: BevelLayout) -> Iterator[tuple[str, float]]:
    s.levels  # noqa: B018 - without levels there is no winding, hence no stop
    for c in s.steps:
        yield c.name, stop_of(s.drive, c).bend_radius_mm


_THINNER = (down("rope diameter_mm"), down("transmission.ratios.input_to_guide"), up("all radii of transmission"))
BENDING = (*bending_checks(_THINNER), anchor_check(_stop_bends_mm, _THINNER))
