"""How far the terminals of the drum are drawn in, from slack to the highest preload, and how the preloads are set."""

from __future__ import annotations

from math import ceil, hypot, pi, radians, tau
from typing import TYPE_CHECKING

from mbcdm_cad.configurations.miso_bevel.cable_path import winding
from mbcdm_cad.configurations.miso_bevel.drive import BevelDrive, BevelRun
from mbcdm_cad.model.tensioning import TakeUp, take_up
from mbcdm_cad.model.tensioning_plan import (
    TensionedCable,
    TensionedRope,
    TensioningPlan,
    rope_stiffnesses,
    tensioning_plan,
)

if TYPE_CHECKING:  # the layout asks this module for the terminals' travel
    from mbcdm_cad.configurations.miso_bevel.layout import Layout

# Travel is rounded up to this, as a drawing would.
_STEP_MM = 0.1


def highest_preload_N(drive: BevelDrive, cable: BevelRun) -> float:
    """Preload of a cable with two of its standard deviations, where it has one."""
    return cable.preload_N + 2.0 * drive.sigmas.preload_N[drive.cables.index(cable)]


def longest_mm(drive: BevelDrive, cable: BevelRun, anchor_rad: float) -> float:
    """Length of a cable that leaves its land at ``anchor_rad``, by its pieces; a little more than the drawn path."""
    w = winding(drive, cable)
    turns = tau * drive.dead_turns + w.reduction * radians(drive.half_travel_deg)
    helix = turns * hypot(cable.input_radius_mm, drive.helix_lead_mm / tau)
    # The bend inward to the stop and the straight end in the terminal: a quarter turn and three diameters each.
    ends = pi / 2 * cable.input_radius_mm + 6.0 * drive.cable.diameter_mm
    return helix + w.free_span_mm + cable.guide_radius_mm * w.guide_wrap_rad + cable.drum_radius_mm * anchor_rad + ends


def take_up_of(drive: BevelDrive, cable: BevelRun, length_mm: float) -> TakeUp:
    """What a cable ``length_mm`` long asks of its terminal, m."""
    rope = drive.cable
    return take_up(
        length_mm * 1e-3,
        highest_preload_N(drive, cable),
        rope.axial_stiffness_N,
        rope.bedding_in_share,
        drive.cut_tolerance_mm * 1e-3,
    )


def terminal_travel_mm(drive: BevelDrive, furthest_rad: float) -> tuple[float, dict[str, float]]:
    """(travel of all terminals, how far each is drawn in by a cable of nominal length), no anchor beyond an angle."""
    needed = {c.name: take_up_of(drive, c, longest_mm(drive, c, furthest_rad)) for c in drive.cables}
    longest = max(t.total_m for t in needed.values()) * 1e3
    return ceil(longest / _STEP_MM - 1e-9) * _STEP_MM, {name: t.nominal_m * 1e3 for name, t in needed.items()}


def plan(layout: Layout) -> TensioningPlan:
    """How the preloads of this design are set, cables in the order of the file."""
    drive, rope = layout.drive, layout.drive.cable
    wire = drive.material(rope.material)
    loose, bonded = rope_stiffnesses(
        rope.construction, rope.diameter_mm * 1e-3, rope.axial_stiffness_N, wire.youngs_modulus_GPa * 1e9
    )
    terminals = {t.cable_name: t for t in layout.drum.tensioners}
    slots = {slot.cable_name: slot for pulley in layout.inputs for slot in pulley.slots}
    cables = []
    for c, path in zip(drive.cables, layout.cable_paths(0.0), strict=True):
        w = winding(drive, c)
        t, slot = terminals[c.name], slots[c.name]
        turned = tau * drive.dead_turns + w.reduction * radians(drive.half_travel_deg)
        # Along the cable from the nut: straight end, drum, guide (it turns freely), free span, input pulley.
        pieces = (
            (t.swage_start * 1e-3, 0.0),
            (c.drum_radius_mm * t.anchor_rad * 1e-3, t.anchor_rad),
            ((c.guide_radius_mm * w.guide_wrap_rad + w.free_span_mm) * 1e-3, 0.0),
            (c.input_radius_mm * turned * 1e-3, turned),
        )
        ends = slot.stop_start - slot.stop_end + t.cable_end - t.swage_start
        cables.append(
            TensionedCable(
                name=c.name,
                preload_N=c.preload_N,
                highest_preload_N=highest_preload_N(drive, c),
                length_m=path.length_mm * 1e-3,
                ends_m=ends * 1e-3,
                lever_m=-c.drum_side * c.drum_radius_mm * 1e-3,
                pieces=pieces,
                spans_m=(w.free_span_mm * 1e-3,),
                travel_m=t.travel * 1e-3,
            )
        )
    return tensioning_plan(
        cables,
        TensionedRope(
            axial_stiffness_N=rope.axial_stiffness_N,
            mass_kg_m=rope.mass_g_m * 1e-3,
            loose_N_m2=loose,
            bonded_N_m2=bonded,
            bedding_share=rope.bedding_in_share,
            cut_tolerance_m=drive.cut_tolerance_mm * 1e-3,
            friction=drive.friction_coefficient,
        ),
        drive.tensioner.pitch_mm * 1e-3,
    )
