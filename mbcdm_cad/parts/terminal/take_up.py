"""Take-up of the terminals of a drum, from slack to the highest preload."""

from __future__ import annotations

from collections.abc import Mapping
from math import ceil

from mbcdm_cad.design.drive import CableRun, Drive
from mbcdm_cad.model.tensioning import TakeUp, TensionedRope, rope_stiffnesses, take_up

# Travel is rounded up to this, as a drawing would.
_STEP_MM = 0.1


def highest_preload_N(drive: Drive, cable: CableRun) -> float:
    """Preload of a cable with two of its standard deviations, where it has one."""
    return cable.preload_N + 2.0 * drive.sigmas.preload_N[drive.cables.index(cable)]


def take_up_of(drive: Drive, cable: CableRun, length_mm: float) -> TakeUp:
    """Take-up, m, that a cable of ``length_mm`` needs from its terminal."""
    rope = drive.cable
    return take_up(
        length_mm * 1e-3,
        highest_preload_N(drive, cable),
        rope.axial_stiffness_N,
        rope.bedding_in_share,
        drive.cut_tolerance_mm * 1e-3,
        drive.setting_mm * 1e-3,
    )


def terminal_travel_mm(drive: Drive, longest_mm: Mapping[str, float]) -> tuple[float, dict[str, float]]:
    """(travel of all terminals, take-up of each with a cable of nominal length), mm, from the cables' lengths."""
    needed = {c.name: take_up_of(drive, c, longest_mm[c.name]) for c in drive.cables}
    longest = max(t.total_m for t in needed.values()) * 1e3
    return ceil(longest / _STEP_MM - 1e-9) * _STEP_MM, {name: t.nominal_m * 1e3 for name, t in needed.items()}


def tensioned_rope(drive: Drive) -> TensionedRope:
    """The rope's properties that are needed to set preloads."""
    rope = drive.cable
    wire = drive.material(rope.material)
    loose, bonded = rope_stiffnesses(
        rope.construction, rope.diameter_mm * 1e-3, rope.axial_stiffness_N, wire.youngs_modulus_GPa * 1e9
    )
    return TensionedRope(
        axial_stiffness_N=rope.axial_stiffness_N,
        mass_kg_m=rope.mass_g_m * 1e-3,
        loose_N_m2=loose,
        bonded_N_m2=bonded,
        bedding_share=rope.bedding_in_share,
        cut_tolerance_m=drive.cut_tolerance_mm * 1e-3,
        friction=drive.friction_coefficient,
        setting_m=drive.setting_mm * 1e-3,
        anchor_m_N=drive.anchor_m_N,
        tails_m=drive.ends_per_run * drive.termination.tail_ratio * rope.diameter_mm * 1e-3,
    )
