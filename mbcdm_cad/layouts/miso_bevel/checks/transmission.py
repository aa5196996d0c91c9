"""Radii and ratios, bends, the bearings and the guide with its axle.

The paper prints the third row of Eq. (1) with r_g1 and r_g2; the right input runs on steps 3 and 4, so it must be r_g3
and r_g4. The cables pull each input pulley with well over 100 N, more than a gearhead of this size can carry, so each
has a bearing at both ends.
"""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.checks import bearings
from mbcdm_cad.checks.comparison import Check, Comparison, Findings, at_most, check, noted
from mbcdm_cad.checks.design_variables import ROPE_DIAMETER, down, up
from mbcdm_cad.checks.fixings import STRESS_SAFETY, bent_axle_Nmm, round_shaft_MPa
from mbcdm_cad.checks.ratios import BENDING, RATIO_TOLERANCE, anchor_bend, pair_mismatch, spread, surface_radius
from mbcdm_cad.design.paths import at
from mbcdm_cad.layouts.bevel_transfer import cut_at_pitch
from mbcdm_cad.layouts.miso_bevel.cable_path import GUIDE
from mbcdm_cad.layouts.miso_bevel.drive import BevelRun
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout

EQ1 = "paper Eq. (1)"


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


@check("Eq. (1) row 1: guide to drum", EQ1, advice=_surface_hint)
def eq1_guide_drum(s: BevelLayout) -> Comparison:
    """Row 1: r_g/r_o is the same for all four steps."""
    return spread("r_g/r_o", [c.guide_radius_mm / c.drum_radius_mm for c in s.steps], s.steps)


def _own(s: BevelLayout, index: int) -> list[BevelRun]:
    return [c for c in s.steps if c.input_name == s.drive.input_names[index]]


@check("Eq. (1) row 2: first input to guide", EQ1, advice=_surface_hint)
def eq1_first_input(s: BevelLayout) -> Comparison:
    """Row 2: r_m/r_g is the same for both cables of the first input."""
    own = _own(s, 0)
    return spread(f"{own[0].input_name} r_m/r_g", [c.input_radius_mm / c.guide_radius_mm for c in own], own)


@check("Eq. (1) row 3: second input to guide", EQ1 + ", its slip corrected: r_g3, r_g4", advice=_surface_hint)
def eq1_second_input(s: BevelLayout) -> Comparison:
    """Row 3, corrected: r_m/r_g is the same for both cables of the second input, with the guide steps of that input."""
    own = _own(s, 1)
    steps = " and ".join(f"r_g{c.step}" for c in own)
    note = f"over {steps}; the paper prints r_g1, r_g2"
    return spread(f"{own[0].input_name} r_m/r_g", [c.input_radius_mm / c.guide_radius_mm for c in own], own, note)


@check("Both inputs have one total ratio", "derived", advice=_surface_hint)
def equal_total_ratio(s: BevelLayout) -> Comparison:
    """i_c = r_o/r_m is the same for both inputs; otherwise the inputs work against each other through the drum."""
    mean = [float(np.mean([c.drum_radius_mm / c.input_radius_mm for c in _own(s, i)])) for i in (0, 1)]
    names = s.drive.input_names
    what = f"total ratio {mean[0]:.6g} of {names[0]}, {mean[1]:.6g} of {names[1]}: difference"
    return at_most(what, abs(mean[1] / mean[0] - 1.0), RATIO_TOLERANCE, "relative")


@check("Length added by helix and fleet angle", "derived")
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
    eq1_guide_drum,
    eq1_first_input,
    eq1_second_input,
    equal_total_ratio,
    pair_mismatch.but(advice=_surface_hint),
    path_length,
)


SURFACES = (surface_radius, cut_at_pitch)


def with_guide(checks: Iterable[Check]) -> tuple[Check, ...]:
    """Checks whose remedies change the ratio of input to guide in place of that of input to drum, after the rope."""
    to_drum, to_guide = at.transmission.input_to_drum, *down("transmission.ratios.input_to_guide")
    ways = [(c, [to_guide if a.path == to_drum else a for a in c.adjust]) for c in checks]
    return tuple(c.but(adjust=tuple(sorted(way, key=lambda a: a.path != ROPE_DIAMETER))) for c, way in ways)


BENDS = with_guide((*BENDING, anchor_bend))


def guide_forces_N(s: BevelLayout) -> list[NDArray[np.float64]]:
    """Forces on the axle at the guide's (lower, upper) bearing, shape (2, 3), in each state of the loads."""
    g = s.guide
    apart = (g.top_z - g.bottom_z - g.seat_depth) * 1e-3
    middle = 0.5 * (s.steps[0].drum_radius_mm + s.steps[-1].drum_radius_mm)
    shift = (0.5 * (g.top_z + g.bottom_z) - middle) * 1e-3
    found = []
    for loads in s.loads.on_bodies:
        at = loads.bodies[GUIDE]
        # Moments about the middle of the bearings, which need not be that of the steps.
        moment = at.moment_Nm - np.cross([0.0, 0.0, shift], at.force_N)
        couple = np.array([moment[1], -moment[0], 0.0]) / apart
        found.append(np.stack([at.force_N / 2 - couple, at.force_N / 2 + couple]))
    return found


def guide_reaction_N(s: BevelLayout) -> float:
    """Largest radial load on one of the guide's bearings."""
    return max(float(np.linalg.norm(pair, axis=1).max()) for pair in s.once("guide_forces", guide_forces_N))


def guide_safety(s: BevelLayout, limit: float) -> list[Comparison]:
    return [bearings.safety(s.drive.bearings.guide, "guide", guide_reaction_N(s), limit)]


@check("Guide's bearings carry the cables", bearings.RATING, *bearings.LESS, advice_on=bearings.larger)
def guide_bearings(s: BevelLayout) -> Findings:
    """Static safety of the bearings in the guide, from the resulting pull and its moment."""
    yield from guide_safety(s, bearings.STATIC_SAFETY)


@bearings.quiet
def quiet_running(s: BevelLayout) -> Findings:
    """Static safety of all bearings against the value for quiet running."""
    yield from (
        *bearings.input_safety(s, bearings.QUIET_SAFETY),
        *guide_safety(s, bearings.QUIET_SAFETY),
        *bearings.drum_safety(s, bearings.QUIET_SAFETY),
    )


BEARINGS = (
    bearings.input_bearings,
    guide_bearings,
    bearings.drum_bearings,
    quiet_running,
    bearings.drum_bearing_spacing,
    bearings.coupling_runout,
)


@check(
    "Guide's wall round its bearings",
    "material: min_wall_mm",
    *up("transmission.guide_radii_mm", "all radii of transmission"),
    advice="choose a smaller guide.bearing",
)
def guide_wall(s: BevelLayout) -> Findings:
    """Wall round the bearings in both ends of the guide."""
    g = s.guide
    limit = s.drive.guide_material.min_wall_mm
    starts, ends = [g.bottom_z, *g.walls_z], [*g.walls_z, g.top_z]
    seats = (("lower", g.bottom_z, g.bottom_z + g.seat_depth), ("upper", g.top_z - g.seat_depth, g.top_z))
    for name, low, high in seats:
        for radius, start, end in zip(g.surface_radii, starts, ends, strict=True):
            if start < high and end > low:
                yield f"guide's wall round the {name} bearing", radius - g.seat_radius, limit


@check(
    "Guide is long enough for two bearings",
    "material: min_wall_mm",
    *up("all radii of transmission"),
    advice="choose a narrower guide.bearing",
)
def guide_length(s: BevelLayout) -> Findings:
    """Length of the guide that is left between its two bearings for the shoulders."""
    g = s.guide
    what = "shoulder between the guide's bearings"
    yield (what, g.top_z - g.bottom_z - 2 * g.seat_depth, 2 * s.drive.guide_material.min_wall_mm)


@check(
    "Guide axle's bending stress",
    "beam theory; 1.5 on yield: usual rule",
    *down("rope.preload_N", "loads.peak_torque_Nm"),
    advice="choose a guide.bearing of larger bore",
    unit="times",
)
def axle_stress(s: BevelLayout) -> Findings:
    """Bending stress of the axle under the guide's two bearings, as a beam on shelf and top plate."""
    g, v = s.guide, s.levels
    ends = v.bearing_shelf_top_z, v.top_plate_bottom_z
    bending = max(bent_axle_Nmm(pair, g.bearings_mm, ends)[0] for pair in s.once("guide_forces", guide_forces_N))
    stress = round_shaft_MPa(s.axle.radius, bending)
    strength = s.drive.axle_material.yield_MPa
    what = f"yield {strength:g} MPa over the axle's bending stress {stress:.4g} MPa"
    yield (what, strength / max(stress, 1e-12), STRESS_SAFETY)


GUIDE_FITS = (guide_wall, guide_length, axle_stress)
