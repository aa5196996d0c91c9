"""Dimensions of the input pulley. Heights count along +Y from the gearhead to the encoder; angles seen in +Y direction.

    gearhead's shaft in a slit journal |neck|  land with its groove  |neck|journal| encoder

Each of several cables in parallel has its own groove. Each of two anchored ones has it too, and a slot for its stop in
the end face next to the end of its winding.

In the assembly the part is turned about X by a quarter turn: (x, y, z) of the part are (x, z, -y) there.
"""

from math import pi
from typing import Any

from mbcdm_cad.design.bought import Bearing
from mbcdm_cad.layouts.sector import coupled_pulley
from mbcdm_cad.layouts.siso_spur.cable_path import stop_of
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive, contact_rad, groove_depth_mm, groove_run_out_rad
from mbcdm_cad.layouts.siso_spur.overhung import overhung_pulley
from mbcdm_cad.layouts.siso_spur.stack import SpurStack
from mbcdm_cad.parts.coupling import collar_over_shelf_mm
from mbcdm_cad.parts.input_pulley import dims


def _through_groove(drive: SpurDrive, name: str, level_mm: float) -> dims.Groove:
    """Groove of a continuous cable: its turns, the walk in both directions, and the run-out at both spans.

    Right-handed, left-handed with open spans, so that the turns walk along the input as the cable does on the drum.
    """
    beyond = drive.input_travel_rad / 2 + groove_run_out_rad(drive)
    start = contact_rad(drive, 1) - pi / 2
    per_rad = drive.input_radius_mm * drive.slope
    return dims.Groove(
        cable_name=name,
        root_radius=drive.input_radius_mm - drive.cable.diameter_mm / 2,
        radius=dims.GROOVE_RADIUS * drive.cable.diameter_mm,
        depth=groove_depth_mm(drive),
        start_angle_rad=start - drive.input_sense * beyond,
        end_angle_rad=start + drive.input_sense * (drive.wrap_rad + beyond),
        start_z=level_mm - drive.leave_mm - per_rad * beyond,
        end_z=level_mm + drive.leave_mm + per_rad * beyond,
    )


def _slots(drive: SpurDrive, levels: SpurStack) -> tuple[dims.StopSlot, ...]:
    """Stop slots of both anchored cables, the lower first."""
    return tuple(
        dims.stop_slot(
            drive,
            c.name,
            c.input_radius_mm,
            stop_of(drive, c),
            drive.level_mm + c.outward * drive.dead_end_mm,
            levels.land_bottom_z if c.outward < 0 else levels.land_top_z,
        )
        for c in sorted(drive.cables, key=lambda c: c.step)
    )


def _grooves(drive: SpurDrive, slots: tuple[dims.StopSlot, ...]) -> tuple[dims.Groove, ...]:
    if not drive.input_pulleys.grooved:
        return ()
    if not drive.anchored:
        levels = (drive.level_mm + level for level in drive.levels_mm)
        return tuple(_through_groove(drive, *each) for each in zip(drive.cable_names, levels, strict=True))
    most = drive.wound_rad + drive.input_travel_rad / 2
    runs = sorted(drive.cables, key=lambda c: c.step)
    return tuple(
        dims.anchored_groove(drive, slot, stop_of(drive, c), most) for c, slot in zip(runs, slots, strict=True)
    )


def input_pulley(drive: SpurDrive, levels: SpurStack) -> dims.InputPulleyDims:
    """Dimensions of the pulley: one land."""
    slots = _slots(drive, levels) if drive.anchored else ()
    bearings, wheel = drive.bearings, drive.stage is not None
    surface = drive.input_radius_mm - drive.cable.diameter_mm / 2

    def neck(bearing: Bearing) -> float:
        if not drive.anchored:
            return bearing.inner_shoulder_mm / 2
        return dims.neck_radius_mm(bearing.inner_shoulder_mm, stop_of(drive, drive.cables[0]))

    own: dict[str, Any] = {}
    if wheel:
        # The journal ends with the wheel that it carries.
        bottom = levels.motor_shelf_top_z + collar_over_shelf_mm(drive)
        own = {
            "journal_bottom_z": bottom,
            "bore_radius": 0.0,
            "bore_top_z": bottom,
            "slit_width": 0.0,
            "slit_top_z": bottom,
        }
    if drive.encoder.absent:
        own["journal_top_z"] = levels.top_plate_bottom_z + bearings.input_upper.width_mm
    plain = coupled_pulley(
        drive,
        levels,
        name=drive.input_names[0],
        x=0.0,
        lower_neck_radius=neck(bearings.input_lower),
        land_bottom_z=levels.land_bottom_z,
        lower_surface_radius=surface,
        wall_z=drive.level_mm,
        upper_surface_radius=surface,
        land_top_z=levels.land_top_z,
        upper_neck_radius=neck(bearings.input_upper),
        slots=slots,
        grooves=_grooves(drive, slots),
        **own,
    )
    return overhung_pulley(drive, levels, plain) if drive.overhung else plain
