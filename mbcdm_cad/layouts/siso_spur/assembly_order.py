"""The order of assembly: figures for ``assembly.md.j2``."""

from __future__ import annotations

from math import tau
from typing import Any

from mbcdm_cad.checks.bearings import stage_torque_Nm
from mbcdm_cad.design.stage import SET_TENSION
from mbcdm_cad.layouts.assembly import steps
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.siso_spur.overhung import set_screw
from mbcdm_cad.layouts.siso_spur.support.idlers import strap_screw
from mbcdm_cad.parts.bill import AssemblyStep
from mbcdm_cad.parts.motor_head.dims import flange_screw


def assembly_order(layout: SpurLayout) -> tuple[AssemblyStep, ...]:
    """Steps with the sizes of this design. Each item is added in one step; each screw is accessible in its step."""
    before = (step for each in layout.attachments for step in each.steps_before())
    return (*before, *own_steps(layout, based=True))


def own_steps(layout: SpurLayout, based: bool) -> tuple[AssemblyStep, ...]:
    """Those without its attachments; ``based``: with the one that screws the frame to a base."""
    return steps(layout, based=based, **figures(layout))


def figures(layout: SpurLayout) -> dict[str, Any]:
    """What the steps of a layout with parallel axes name besides its dimensions."""
    drive = layout.drive
    return {
        "tau": tau,
        "flange": flange_screw(drive).name,
        "strap_screw": strap_screw(drive).name if drive.idlers else "",
        "set_screw": set_screw(drive).name if drive.overhung else "",
        "span_N": lambda unit: SET_TENSION * unit.drive.stage.force_N(stage_torque_Nm(unit)),
    }
