"""A drum's shaft as output behind the frame, and a first cable stage that turns the input with it."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from math import pi
from typing import Any

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, at_most, worst
from mbcdm_cad.checks.design_variables import down
from mbcdm_cad.checks.fixings import FRICTION, SLIP_SAFETY, STRESS_SAFETY, stalled_Nm
from mbcdm_cad.checks.geometry import drum_zones
from mbcdm_cad.checks.run import Budget, remedy
from mbcdm_cad.layouts.siso_spur.checks.stage import BOND_MPA
from mbcdm_cad.layouts.siso_spur.first_stage import shaft_urad_Nm
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.parts.motor_head.dims import body_radius_mm
from mbcdm_cad.parts.threads import clamp_force_N

# Checks of a first stage that say nothing: its hub carries nothing, its frame has no base, its motor's day is that of
# the whole drive.
NOT_OF_A_FIRST = (
    "payload_screws",
    "mounting_screws",
    "hub_set_screws",
    "duty",
    "seat_temperature",
    "backdrive",
    "gearhead_continuous",
    "speed",
)


def shaft_end_stress(s: SpurLayout) -> Comparison:
    """Torsion of the drum's shaft behind its hub, von Mises, against the yield stress."""
    shaft, strength, load = s.drum_shaft, s.drive.shaft_material.yield_MPa, stalled_Nm(s)
    shear = 2e3 * load * shaft.radius / (pi * (shaft.radius**4 - shaft.bore_radius**4))
    stress = 3**0.5 * shear
    what = f"yield {strength:g} MPa over {stress:.4g} MPa in the drum's shaft at {load:.4g} N m"
    return at_least(what, strength / max(stress, 1e-9), STRESS_SAFETY, "times")


def shaft_end_twist(s: SpurLayout) -> Comparison:
    """Turn of the end of the drum's shaft against the hub at the test torque; limit is the turn of the cables."""
    shaft, torque = s.drum_shaft, s.drive.loads.test_torque_Nm
    length = shaft.flat_y - shaft.y_start
    turned = shaft_urad_Nm(s, length) * torque * 1e-3
    what = f"twist of {length:.4g} mm of the drum's shaft at {torque:g} N m"
    return at_most(what, turned, s.loads.test_urad_Nm * torque * 1e-3, "mrad")


def shaft_end_bond(s: SpurLayout) -> Comparison:
    """Torque that the bond of the hub on the drum's shaft holds, over the one that passes."""
    shaft, drum, load = s.drum_shaft, s.drum, stalled_Nm(s)
    holds = 2.0 * pi * shaft.radius**2 * (drum.hub_face_y - drum.hub_start_y) * BOND_MPA * 1e-3
    what = f"bond of the hub on the drum's shaft holds {holds:.4g} N m over {load:.4g} N m"
    return at_least(what, holds / max(load, 1e-9), SLIP_SAFETY, "times")


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


def _beside(s: SpurLayout, first: SpurLayout) -> Iterator[tuple[str, float]]:
    """Gaps between the motor of the first stage, or its head, and what stands round the input; mm."""
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
            yield f"{name} of the first stage from the {other} of the second", max(apart - reach - out, along)


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


def first_stage_room(s: SpurLayout) -> Comparison:
    """Room of both stages beside each other: motor and plate of the first one from the frame of the second."""
    first = s.first_stage_unit
    assert isinstance(first, SpurLayout)
    running = s.drive.clearances.running_mm
    return worst(at_least(what, gap, running, "mm") for what, gap in (*_beside(s, first), *_behind(s, first)))


def motor_beside_mm(s: SpurLayout, first: SpurLayout) -> float:
    """How much further from its drum the input of the first stage must stand, mm; 0 or less where it has room."""
    return s.drive.clearances.running_mm - min(gap for _, gap in _beside(s, first))


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

    return tuple(as_whole(check) for check in checks_of(first.drive) if check.id not in NOT_OF_A_FIRST)


def _advice(check: Check, s: SpurLayout) -> str:
    assert s.first_stage_unit is not None
    text = remedy(check, s.first_stage_unit, Budget())
    return f"in first_stage.design: {text}" if text else ""


def _has_end(drive: Any) -> bool:
    return bool(drive.drum.shaft_end_mm > 0.0)


def _has_first(drive: Any) -> bool:
    return drive.first_stage is not None


CHECKS = (
    Check(
        "shaft_end_stress",
        "Drum's shaft carries the output torque",
        "material: yield_MPa",
        shaft_end_stress,
        adjust=(down("drum.shaft_bore_mm"), down("loads.peak_torque_Nm")),
        advice="choose a drum.bearing of larger bore",
        applies=_has_end,
    ),
    Check(
        "shaft_end_twist",
        "Drum's shaft stiff against torsion",
        "the turn of the cables: choice",
        shaft_end_twist,
        adjust=(down("drum.shaft_bore_mm"),),
        advice="choose a drum.bearing of larger bore, or lower drum.shaft_end_mm",
        applies=_has_end,
    ),
    Check(
        "shaft_end_bond",
        "Hub holds on the drum's shaft",
        "makers of retaining compounds: 15 to 25 MPa, half counted",
        shaft_end_bond,
        adjust=(down("loads.peak_torque_Nm"),),
        advice="choose a drum.bearing of larger bore, or raise drum.hub_face_y_mm",
        applies=_has_end,
    ),
    Check(
        "shaft_end_flange",
        "Flange of the boss does not slip",
        "friction of tightened screws, as mounting_screws",
        shaft_end_flange,
        adjust=(down("loads.peak_torque_Nm"),),
        advice="choose a larger drum.bearing, round which the screws stand further out",
        applies=_has_end,
    ),
    Check(
        "first_stage_room",
        "Both stages have room",
        "clearances.running_mm",
        first_stage_room,
        advice="raise first_stage.design.transmission.centre_distance_mm, or choose a smaller motor",
        applies=_has_first,
    ),
)
