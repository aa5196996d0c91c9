"""Belt or gears between motor and input: strength, room, shafts, lash."""

from __future__ import annotations

from math import ceil, degrees, pi
from typing import Any

import numpy as np

from mbcdm_cad.checks.bearings import stage_torque_Nm
from mbcdm_cad.checks.comparison import Check, Comparison, at_least, at_most, noted, worst
from mbcdm_cad.checks.design_variables import up
from mbcdm_cad.checks.fixings import STRESS_SAFETY, round_shaft_MPa
from mbcdm_cad.checks.geometry import HOLE_WEB_MM
from mbcdm_cad.checks.run import rounded
from mbcdm_cad.design.stage import SERVICE, TEETH_IN_MESH, WHEEL_WALL_MM
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.structure import input_play_rad, lash_rad
from mbcdm_cad.parts.collar import collar_sweep_mm
from mbcdm_cad.parts.stage import StageDims

# Bending stress that a tooth stands, over the yield stress of its steel: reversed for ever (usual rule).
TOOTH_SHARE = 0.4
# Shear strength of a retaining compound on steel, with a half of it for speed and heat, MPa (makers state 15 to 25).
BOND_MPA = 10.0
# How far the ratio of whole teeth may be from the one asked for.
RATIO_SHARE = 0.01

_LEWIS = (
    *((12, 0.245), (14, 0.277), (16, 0.296), (18, 0.309), (20, 0.322), (24, 0.337), (30, 0.359), (34, 0.371)),
    *((43, 0.397), (50, 0.409), (60, 0.422), (75, 0.435), (100, 0.447), (150, 0.460), (300, 0.472)),
)


def _of(s: SpurLayout) -> StageDims:
    assert s.stage is not None, "checks of a stage run on drives that have one"
    return s.stage


def lewis_factor(teeth: int) -> float:
    """Form factor Y of a tooth of 20 degrees, full depth (Shigley, Mechanical Engineering Design, table 14-2)."""
    return float(np.interp(teeth, [z for z, _ in _LEWIS], [y for _, y in _LEWIS]))


def strength(s: SpurLayout) -> Comparison:
    """Strength of belt or teeth over the load at peak torque.

    Belt: its allowed tension over the effective one, fewer teeth in mesh carrying less. Gears: a share of the yield
    stress over the bending stress of the driver's teeth by Lewis.
    """
    stage, torque = _of(s).stage, s.once("stage_torque", stage_torque_Nm)
    force = stage.force_N(torque)
    if stage.is_belt:
        carried = min(1.0, stage.driver_in_mesh / TEETH_IN_MESH)
        allowed = stage.type.force_N_mm * stage.width_mm * carried
        what = f"{allowed:.4g} N allowed in {stage.width_mm:g} mm of {stage.belt} over {force:.4g} N"
        return at_least(f"belt: {what} at {torque:.4g} N m on the input", allowed / max(force, 1e-9), SERVICE, "times")
    stress = force / (stage.width_mm * stage.module_mm * lewis_factor(stage.driver_teeth))
    allowed = TOOTH_SHARE * s.drive.material("steel").yield_MPa
    what = f"{allowed:.4g} MPa over the {stress:.4g} MPa in the teeth of the driver"
    return at_least(f"gears: {what} at {torque:.4g} N m on the input", allowed / max(stress, 1e-9), SERVICE, "times")


def _stronger(s: SpurLayout) -> str:
    found, stage = strength(s), _of(s).stage
    width = rounded(stage.width_mm * SERVICE / max(found.actual, 1e-9), ceil)
    larger = "a larger belt (2GT, 3GT, 5GT)" if stage.is_belt else "a larger stage.module_mm"
    return f"raise stage.width_mm to about {width}, or stage.driver_teeth, or choose {larger}"


def ratio(s: SpurLayout) -> Comparison:
    """Ratio of whole teeth against the one asked for."""
    stage = _of(s).stage
    off = abs(stage.ratio / stage.asked_ratio - 1.0)
    what = (
        f"{stage.driven_teeth}/{stage.driver_teeth} teeth = {stage.ratio:.5g} from the {stage.asked_ratio:g} asked for"
    )
    return at_most(what, 100.0 * off, 100.0 * RATIO_SHARE, "%")


def mesh(s: SpurLayout) -> Comparison:
    """Teeth of the small pulley in the belt: with fewer it may jump a tooth below its allowed tension."""
    stage = _of(s).stage
    return at_least("teeth of the driving pulley in the belt", stage.driver_in_mesh, TEETH_IN_MESH, "teeth")


def room(s: SpurLayout) -> Comparison:
    """Wheels clear each other, their shafts, hub clamp and flange."""
    dims, drive, head = _of(s), s.drive, s.head
    stage, running, gear = dims.stage, drive.clearances.running_mm, drive.gearhead
    clamp = collar_sweep_mm(drive, *drive.collar_seat)
    found = [
        at_least(
            "hub's clamp from the motor's shaft", stage.centre_mm - clamp - gear.shaft_diameter_mm / 2, running, "mm"
        ),
        at_least("flange before its bearing", head.flange.front_y - head.seat_radius, HOLE_WEB_MM + running, "mm"),
        at_least(
            "teeth of the driver over its bore",
            stage.root_mm(stage.driver_mm) - gear.shaft_diameter_mm / 2,
            WHEEL_WALL_MM,
            "mm",
        ),
        at_least(
            "teeth of the driven wheel over its hub", stage.root_mm(stage.driven_mm) - dims.driven.hub_radius, 0.0, "mm"
        ),
    ]
    if stage.is_belt:
        flanges = dims.driven.flange + dims.driver.outside
        found.append(at_least("flanges of the pulleys from each other", stage.centre_mm - flanges, running, "mm"))
    return worst(found)


def key_beside(s: SpurLayout) -> Comparison:
    """A key reaches the screws of motor or gearhead beside driver and belt: they are tightened with the belt on."""
    stage, head = _of(s).stage, s.head
    gap = min(stage.beside_belt_mm(x, y) for x, y in head.gear_screws) - head.key_hole_radius
    return at_least(f"key for the screws of the {s.drive.mounted} from the belt", gap, 0.0, "mm")


def shaft_load(s: SpurLayout) -> Comparison:
    """Force of belt or teeth across the shaft of motor or gearhead, against what its bearings may carry."""
    stage, torque = _of(s).stage, s.once("stage_torque", stage_torque_Nm)
    return at_most(
        f"force across the {s.drive.mounted}'s shaft at peak torque",
        stage.across_N(torque),
        s.drive.gearhead.radial_load_N,
        "N",
        "of the belt's set tension" if stage.is_belt else "normal to the teeth",
    )


def bond(s: SpurLayout) -> Comparison:
    """Torque that the retaining compound in the driver's bore holds."""
    dims, gear, torque = _of(s), s.drive.gearhead, s.once("stage_torque", stage_torque_Nm)
    end = s.levels.motor_shelf_bottom_z + gear.shaft_length_mm
    length = max(min(end, dims.top_z) - dims.bottom_z, 0.0)
    holds = pi / 2 * gear.shaft_diameter_mm**2 * length * BOND_MPA
    needed = torque * 1e3 / dims.stage.ratio / dims.stage.efficiency
    what = f"bond of the driver holds {holds:.4g} N mm over {needed:.4g} N mm"
    return at_least(what, holds / max(needed, 1e-9), STRESS_SAFETY, "times")


def journal(s: SpurLayout) -> Comparison:
    """Stress of the journal in its bearing, bent and twisted by the wheel beyond it (von Mises)."""
    dims, torque, pulley = _of(s), s.once("stage_torque", stage_torque_Nm), s.inputs[0]
    lever = s.input_bearings_mm(0)[0] - dims.middle_z
    stress = round_shaft_MPa(pulley.lower_journal_radius, dims.stage.across_N(torque) * lever, torque * 1e3)
    allowed = s.drive.pulley_material.yield_MPa
    return at_least(
        f"yield {allowed:g} MPa over the journal's {stress:.4g} MPa beside the driven wheel",
        allowed / max(stress, 1e-9),
        STRESS_SAFETY * SERVICE,
        "times",
    )


def lash(s: SpurLayout) -> Comparison:
    """Turn of the drum by the stage's play. Encoders on the inputs see it; motors' own encoders do not."""
    arcmin = degrees(input_play_rad(s.drive, motors_held=True)) * 60
    found, turn = lash_rad(s.drive, motors_held=True) * 1e3, s.loads.test_urad_Nm * 1e-3 * s.drive.loads.test_torque_Nm
    what = f"turn of the drum by {arcmin:.3g} arcmin of play at the input, motors held"
    if s.drive.encoder.absent:
        return at_most(
            what, found, turn, "mrad", "only the motor's own encoder tells the angle: limit is the cables' turn"
        )
    return noted(what, found, "mrad", "the encoder on the input sees it")


def _has_stage(drive: Any) -> bool:
    return drive.stage is not None


def _has_belt(drive: Any) -> bool:
    return drive.stage is not None and drive.stage.is_belt


CHECKS = (
    Check(
        "stage_strength",
        "Belt or teeth carry the peak torque",
        "belt: makers' allowable working tension; gears: Lewis; service factor 1.5: belt makers",
        strength,
        adjust=(up("stage.width_mm"),),
        advice=_stronger,
        applies=_has_stage,
    ),
    Check(
        "stage_mesh",
        "Enough teeth in the belt",
        "six teeth: belt makers",
        mesh,
        adjust=(up("stage.belt_teeth"),),
        advice="raise stage.belt_teeth, which moves the axes apart, or stage.driver_teeth, or lower stage.ratio",
        applies=_has_belt,
    ),
    Check(
        "stage_room",
        "Wheels of belt or gears have room",
        "clearances.running_mm; 0.8 mm round the bore: makers' smallest wheels",
        room,
        adjust=(up("stage.belt_teeth"),),
        advice="raise stage.driver_teeth, or stage.belt_teeth, or stage.module_mm, which move the axes apart",
        applies=_has_stage,
    ),
    Check(
        "stage_key",
        "A key reaches the motor's screws beside the belt",
        "derived",
        key_beside,
        adjust=(up("stage.belt_teeth"),),
        advice="choose a motor or gearhead whose screws stand further from its shaft, or kind: gears",
        applies=_has_belt,
    ),
    Check(
        "stage_shaft",
        "Shaft of motor or gearhead carries belt or teeth",
        "gearhead or motor catalogue: radial_load_N",
        shaft_load,
        advice="raise stage.driver_teeth, which pulls less for the same torque, or choose a drive.gearhead with a "
        "larger radial_load_N",
        applies=_has_stage,
    ),
    Check(
        "stage_bond",
        "Driving wheel holds on its shaft",
        "makers of retaining compounds: 15 to 25 MPa, half counted",
        bond,
        adjust=(up("stage.width_mm"),),
        advice="choose a motor or gearhead with a longer or thicker shaft, or raise stage.width_mm",
        applies=_has_stage,
    ),
    Check(
        "stage_journal",
        "Journal carries the driven wheel",
        "material: yield_MPa; 1.5 times the service factor",
        journal,
        advice="choose a larger input_pulleys.lower_bearing, whose journal is thicker, or lower stage.width_mm",
        applies=_has_stage,
    ),
    Check(
        "stage_ratio",
        "Ratio of whole teeth",
        "1 %: choice",
        ratio,
        "warn",
        advice="set stage.ratio to the ratio of the teeth, or raise stage.driver_teeth",
        applies=_has_stage,
    ),
    Check(
        "stage_lash",
        "Play of belt or gears at the drum",
        "estimate by kind, or stage.lash_arcmin",
        lash,
        "warn",
        advice="name a drive.encoder on the input, choose kind: belt, or state a measured stage.lash_arcmin",
        applies=_has_stage,
    ),
)
