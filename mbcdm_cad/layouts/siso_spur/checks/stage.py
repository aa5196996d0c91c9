"""Stages before the drive: belt or gears between motor and input; and a first cable stage, with the shaft it turns."""

from collections.abc import Iterator
from functools import partial
from math import ceil, degrees, pi

import numpy as np

from mbcdm_cad.checks import fixings, motors, structure
from mbcdm_cad.checks.bearings import stage_torque_Nm
from mbcdm_cad.checks.comparison import Check, Comparison, Family, Findings, at_least, at_most, check, check_for, noted
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.checks.fixings import FRICTION, SLIP_SAFETY, STRESS_SAFETY, round_shaft_MPa, stalled_Nm
from mbcdm_cad.checks.geometry import HOLE_WEB_MM, drum_zones
from mbcdm_cad.checks.run import Budget, remedy, rounded
from mbcdm_cad.design.paths import at
from mbcdm_cad.design.stage import SERVICE, TEETH_IN_MESH, WHEEL_WALL_MM
from mbcdm_cad.layouts.siso_spur.first_stage import shaft_urad_Nm
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.structure import input_play_rad, lash_rad
from mbcdm_cad.parts.coupling import StageDims, collar_sweep_mm
from mbcdm_cad.parts.fits import clamp_force_N
from mbcdm_cad.parts.motor_head.dims import body_radius_mm

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


def _stronger(s: SpurLayout, found: Comparison) -> str:
    stage = _of(s).stage
    width = rounded(stage.width_mm * SERVICE / max(found.actual, 1e-9), ceil)
    larger = "a larger belt (2GT, 3GT, 5GT)" if stage.is_belt else "a larger stage.module_mm"
    return f"raise stage.width_mm to about {width}, or stage.driver_teeth, or choose {larger}"


_stage_check = check_for(lambda drive: drive.stage is not None)
_belt_check = check_for(lambda drive: drive.stage is not None and drive.stage.is_belt)
_end_check = check_for(lambda drive: drive.drum.shaft_end_mm > 0.0)


@_stage_check(
    "Belt or teeth carry the peak torque",
    "belt: makers' allowable working tension; gears: Lewis; service factor 1.5: belt makers",
    *up("stage.width_mm"),
    advice_on=_stronger,
)
def stage_strength(s: SpurLayout) -> Comparison:
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


@_belt_check(
    "Enough teeth in the belt",
    "six teeth: belt makers",
    *up("stage.belt_teeth"),
    advice="raise stage.belt_teeth, which moves the axes apart, or stage.driver_teeth, or lower stage.ratio",
)
def stage_mesh(s: SpurLayout) -> Comparison:
    """Teeth of the small pulley in the belt: with fewer it may jump a tooth below its allowed tension."""
    stage = _of(s).stage
    return at_least("teeth of the driving pulley in the belt", stage.driver_in_mesh, TEETH_IN_MESH, "teeth")


@_stage_check(
    "Wheels of belt or gears have room",
    "clearances.running_mm; 0.8 mm round the bore: makers' smallest wheels",
    *up("stage.belt_teeth"),
    advice="raise stage.driver_teeth, or stage.belt_teeth, or stage.module_mm, which move the axes apart",
)
def stage_room(s: SpurLayout) -> Findings:
    """Wheels clear each other, their shafts, hub clamp and flange."""
    dims, drive, head = _of(s), s.drive, s.head
    stage, running, gear = dims.stage, drive.clearances.running_mm, drive.gearhead
    clamp = collar_sweep_mm(drive)
    yield "hub's clamp from the motor's shaft", stage.centre_mm - clamp - gear.shaft_diameter_mm / 2, running
    yield "flange before its bearing", head.flange.front_y - head.seat_radius, HOLE_WEB_MM + running
    what = "teeth of the driver over its bore"
    yield (what, stage.root_mm(stage.driver_mm) - gear.shaft_diameter_mm / 2, WHEEL_WALL_MM)
    yield "teeth of the driven wheel over its hub", stage.root_mm(stage.driven_mm) - dims.driven.hub_radius, 0.0
    if stage.is_belt:
        flanges = dims.driven.flange + dims.driver.outside
        yield "flanges of the pulleys from each other", stage.centre_mm - flanges, running


@_belt_check(
    "A key reaches the motor's screws beside the belt",
    "derived",
    *up("stage.belt_teeth"),
    advice="choose a motor or gearhead whose screws stand further from its shaft, or kind: gears",
)
def stage_key(s: SpurLayout) -> Comparison:
    """A key reaches the screws of motor or gearhead beside driver and belt: they are tightened with the belt on."""
    stage, head = _of(s).stage, s.head
    gap = min(stage.beside_belt_mm(x, y) for x, y in head.gear_screws) - head.key_hole_radius
    return at_least(f"key for the screws of the {s.drive.mounted} from the belt", gap, 0.0, "mm")


@_stage_check(
    "Shaft of motor or gearhead carries belt or teeth",
    "gearhead or motor catalogue: radial_load_N",
    advice="raise stage.driver_teeth, which pulls less for the same torque, or choose a drive.gearhead with a "
    "larger radial_load_N",
)
def stage_shaft(s: SpurLayout) -> Comparison:
    """Force of belt or teeth across the shaft of motor or gearhead, against what its bearings may carry."""
    stage, torque = _of(s).stage, s.once("stage_torque", stage_torque_Nm)
    return at_most(
        f"force across the {s.drive.mounted}'s shaft at peak torque",
        stage.across_N(torque),
        s.drive.gearhead.radial_load_N,
        "N",
        "of the belt's set tension" if stage.is_belt else "normal to the teeth",
    )


@_stage_check(
    "Driving wheel holds on its shaft",
    "makers of retaining compounds: 15 to 25 MPa, half counted",
    *up("stage.width_mm"),
    advice="choose a motor or gearhead with a longer or thicker shaft, or raise stage.width_mm",
)
def stage_bond(s: SpurLayout) -> Comparison:
    """Torque that the retaining compound in the driver's bore holds."""
    dims, gear, torque = _of(s), s.drive.gearhead, s.once("stage_torque", stage_torque_Nm)
    end = s.levels.motor_shelf_bottom_z + gear.shaft_length_mm
    length = max(min(end, dims.top_z) - dims.bottom_z, 0.0)
    holds = pi / 2 * gear.shaft_diameter_mm**2 * length * BOND_MPA
    needed = torque * 1e3 / dims.stage.ratio / dims.stage.efficiency
    what = f"bond of the driver holds {holds:.4g} N mm over {needed:.4g} N mm"
    return at_least(what, holds / max(needed, 1e-9), STRESS_SAFETY, "times")


@_stage_check(
    "Journal carries the driven wheel",
    "material: yield_MPa; 1.5 times the service factor",
    advice="choose a larger input_pulleys.lower_bearing, whose journal is thicker, or lower stage.width_mm",
    unit="times",
)
def stage_journal(s: SpurLayout) -> Findings:
    """Stress of the journal in its bearing, bent and twisted by the wheel beyond it (von Mises)."""
    dims, torque, pulley = _of(s), s.once("stage_torque", stage_torque_Nm), s.inputs[0]
    lever = s.input_bearings_mm(0)[0] - dims.middle_z
    stress = round_shaft_MPa(pulley.lower_journal_radius, dims.stage.across_N(torque) * lever, torque * 1e3)
    allowed = s.drive.pulley_material.yield_MPa
    what = f"yield {allowed:g} MPa over the journal's {stress:.4g} MPa beside the driven wheel"
    yield (what, allowed / max(stress, 1e-9), STRESS_SAFETY * SERVICE)


@_stage_check(
    "Ratio of whole teeth",
    "1 %: choice",
    advice="set stage.ratio to the ratio of the teeth, or raise stage.driver_teeth",
    warn=True,
)
def stage_ratio(s: SpurLayout) -> Comparison:
    """Ratio of whole teeth against the one asked for."""
    stage = _of(s).stage
    off = abs(stage.ratio / stage.asked_ratio - 1.0)
    what = (
        f"{stage.driven_teeth}/{stage.driver_teeth} teeth = {stage.ratio:.5g} from the {stage.asked_ratio:g} asked for"
    )
    return at_most(what, 100.0 * off, 100.0 * RATIO_SHARE, "%")


@_stage_check(
    "Play of belt or gears at the drum",
    "estimate by kind, or stage.lash_arcmin",
    advice="name a drive.encoder on the input, choose kind: belt, or state a measured stage.lash_arcmin",
    warn=True,
)
def stage_lash(s: SpurLayout) -> Comparison:
    """Turn of the drum by the stage's play. Encoders on the inputs see it; motors' own encoders do not."""
    arcmin = degrees(input_play_rad(s.drive, motors_held=True)) * 60
    found, turn = lash_rad(s.drive, motors_held=True) * 1e3, s.loads.test_urad_Nm * 1e-3 * s.drive.loads.test_torque_Nm
    what = f"turn of the drum by {arcmin:.3g} arcmin of play at the input, motors held"
    if s.drive.encoder.absent:
        return at_most(
            what, found, turn, "mrad", "only the motor's own encoder tells the angle: limit is the cables' turn"
        )
    return noted(what, found, "mrad", "the encoder on the input sees it")


# Checks of a first stage that say nothing: its hub carries nothing, its frame has no base, its motor's day is that of
# the whole drive.
NOT_OF_A_FIRST = (
    structure.payload_screws,
    structure.mounting_screws,
    fixings.hub_set_screws,
    motors.duty,
    motors.seat_temperature,
    motors.backdrive,
    motors.gearhead_continuous,
    motors.speed,
)


@_end_check(
    "Drum's shaft carries the output torque",
    "material: yield_MPa",
    *down(at.drum.shaft_bore_mm, at.loads.peak_torque_Nm),
    advice="choose a drum.bearing of larger bore",
)
def shaft_end_stress(s: SpurLayout) -> Comparison:
    """Torsion of the drum's shaft behind its hub, von Mises, against the yield stress."""
    shaft, strength, load = s.drum_shaft, s.drive.shaft_material.yield_MPa, stalled_Nm(s)
    shear = 2e3 * load * shaft.radius / (pi * (shaft.radius**4 - shaft.bore_radius**4))
    stress = 3**0.5 * shear
    what = f"yield {strength:g} MPa over {stress:.4g} MPa in the drum's shaft at {load:.4g} N m"
    return at_least(what, strength / max(stress, 1e-9), STRESS_SAFETY, "times")


@_end_check(
    "Drum's shaft stiff against torsion",
    "the turn of the cables: choice",
    *down(at.drum.shaft_bore_mm),
    advice="choose a drum.bearing of larger bore, or lower drum.shaft_end_mm",
)
def shaft_end_twist(s: SpurLayout) -> Comparison:
    """Turn of the end of the drum's shaft against the hub at the test torque; limit is the turn of the cables."""
    shaft, torque = s.drum_shaft, s.drive.loads.test_torque_Nm
    length = shaft.flat_y - shaft.y_start
    turned = shaft_urad_Nm(s, length) * torque * 1e-3
    what = f"twist of {length:.4g} mm of the drum's shaft at {torque:g} N m"
    return at_most(what, turned, s.loads.test_urad_Nm * torque * 1e-3, "mrad")


@_end_check(
    "Hub holds on the drum's shaft",
    "makers of retaining compounds: 15 to 25 MPa, half counted",
    *down(at.loads.peak_torque_Nm),
    advice="choose a drum.bearing of larger bore, or raise drum.hub_face_y_mm",
)
def shaft_end_bond(s: SpurLayout) -> Comparison:
    """Torque that the bond of the hub on the drum's shaft holds, over the one that passes."""
    shaft, drum, load = s.drum_shaft, s.drum, stalled_Nm(s)
    holds = 2.0 * pi * shaft.radius**2 * (drum.hub_face_y - drum.hub_start_y) * BOND_MPA * 1e-3
    what = f"bond of the hub on the drum's shaft holds {holds:.4g} N m over {load:.4g} N m"
    return at_least(what, holds / max(load, 1e-9), SLIP_SAFETY, "times")


@_end_check(
    "Flange of the boss does not slip",
    "friction of tightened screws, as mounting_screws",
    *down(at.loads.peak_torque_Nm),
    advice="choose a larger drum.bearing, round which the screws stand further out",
)
def shaft_end_flange(s: SpurLayout) -> Comparison:
    """Torque at which the flange of the boss slips on what it is screwed on, over the one on the drum's shaft.

    The motor stands on the same frame, so that its torque and the bearings' leave the frame that of the shaft alone.
    """
    flange, load = s.frame.boss.flange, stalled_Nm(s)
    assert flange is not None
    clamp = clamp_force_N(2.0 * flange.screw_radius)
    holds = FRICTION * clamp * sum((x**2 + z**2) ** 0.5 for x, z in flange.screws) * 1e-3
    what = f"{len(flange.screws)} x M{2 * flange.screw_radius:g} at {clamp:.4g} N hold {holds:.4g} N m by friction over"
    return at_least(f"{what} {load:.4g} N m", holds / max(load, 1e-9), SLIP_SAFETY, "times")


def _beside(s: SpurLayout, first: SpurLayout) -> Iterator[tuple[str, float, float]]:
    """Gaps between the motor of the first stage, or its head, and what stands round the input, mm: beside each other
    and along the axes. One of both is enough.
    """
    v, f, w = s.levels, s.frame, first.levels
    apart, axis = first.drive.centre_distance_mm, s.drive.centre_distance_mm
    # Of the first stage, along its own y: the lowest and the highest level, and the reach towards its drum's axis.
    ours = [
        ("motor", w.motor_bottom_z, w.motor_shelf_bottom_z, body_radius_mm(first.drive)),
        *([] if first.frame.motor else [("motor head", w.motor_shelf_bottom_z, w.plate_back_y, -first.head.back_y)]),
    ]
    # Of the second stage, along the assembly's y, and the reach from the input's axis away from the drum.
    others = (
        ("motor head", v.motor_shelf_bottom_z, v.plate_back_y, s.head.front_y),
        ("plate and bridge", v.plate_back_y, v.top_plate_top_z, f.top_z - axis),
        ("encoder", v.top_plate_top_z, v.encoder_top_z, s.drive.encoder.diameter_mm / 2),
    )
    face = v.motor_shelf_bottom_z + w.back_y
    for name, low, high, reach in ours:
        for other, near, far, out in others:
            along = max(near - (face - low), (face - high) - far)
            yield f"{name} of the first stage from the {other} of the second", apart - reach - out, along


def _behind(s: SpurLayout, first: SpurLayout) -> Iterator[tuple[str, float]]:
    """Gaps between the first stage's plate and drum and the boss of the second one's drum; mm."""
    v, w, boss = s.levels, first.levels, s.frame.boss
    axis, face = s.drive.centre_distance_mm, v.motor_shelf_bottom_z + w.back_y
    end = min(boss.end_y, s.drum_shaft.y_start, v.back_y)
    behind = end - (face - w.plate_back_y)
    beside = max(boss.reach, s.drive.drum_encoder.diameter_mm / 2)
    yield "plate of the first stage from the drum's boss", max(behind, axis - beside - first.frame.half_width)
    swept = max(r.outer for r in drum_zones(first))
    behind = end - (face - w.front_y)
    yield "drum of the first stage from the boss of the second one's drum", max(behind, axis - beside - swept)


@check(
    "Both stages have room",
    at.clearances.running_mm,
    advice="raise first_stage.design.transmission.centre_distance_mm, or choose a smaller motor",
    applies=lambda drive: drive.first_stage is not None,
)
def first_stage_room(s: SpurLayout) -> Findings:
    """Room of both stages beside each other: motor and plate of the first one from the frame of the second."""
    first = s.first_stage_unit
    assert isinstance(first, SpurLayout)
    beside = ((what, max(gaps)) for what, *gaps in _beside(s, first))
    for what, gap in (*beside, *_behind(s, first)):
        yield what, gap, s.drive.clearances.running_mm


def motor_beside_mm(s: SpurLayout, first: SpurLayout) -> float:
    """How much further from its drum the input of the first stage must stand, mm; 0 or less where it has room."""
    least = s.drive.clearances.running_mm
    # Standing further away helps only beside, not along the axes.
    return max(
        least - (beside if max(beside, along) < least else max(beside, along)) for _, beside, along in _beside(s, first)
    )


def checks_of_first(first: SpurLayout) -> tuple[Check, ...]:
    """The checks of a first stage, as checks of the whole drive: their ids and titles say which stage they are of."""
    from mbcdm_cad.layouts.check_design import checks_of

    def as_whole(check: Check) -> Check:
        return check.but(
            id=f"first_stage_{check.id}",
            title=f"First stage: {check.title}",
            measure=lambda s: check.measure(s.first_stage_unit),
            adjust=(),
            advice=partial(_advice, check),
        )

    return tuple(as_whole(check) for check in checks_of(first.drive) if check not in NOT_OF_A_FIRST)


def _advice(check: Check, s: SpurLayout) -> str:
    assert s.first_stage_unit is not None
    text = remedy(check, s.first_stage_unit, Budget())
    return f"in first_stage.design: {text}" if text else ""


FAMILIES = (
    Family(
        "Belt or gears between motor and input: strength, room, shafts, lash.",
        (
            stage_strength,
            stage_mesh,
            stage_room,
            stage_key,
            stage_shaft,
            stage_bond,
            stage_journal,
            stage_ratio,
            stage_lash,
        ),
    ),
    Family(
        "A drum's shaft as output behind the frame, and a first cable stage that turns the input with it.",
        (shaft_end_stress, shaft_end_twist, shaft_end_bond, shaft_end_flange, first_stage_room),
    ),
)
