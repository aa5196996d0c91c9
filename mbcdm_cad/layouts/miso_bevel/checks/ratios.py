"""Eq. (1) row by row, equal total ratio of both inputs, and the tension that a difference causes.

The paper prints the third row with r_g1 and r_g2; the right input runs on steps 3 and 4, so it must be r_g3 and r_g4.
The checks use nominal radii, with a tolerance far below that of machining: they find errors of the design, not of
parts.
"""

from __future__ import annotations

import numpy as np

from mbcdm_cad.checks.comparison import Check, Comparison, at_most, noted
from mbcdm_cad.checks.ratios import RATIO_TOLERANCE, pair_mismatch, spread
from mbcdm_cad.layouts.miso_bevel.drive import BevelRun
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout

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


CHECKS = (
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
