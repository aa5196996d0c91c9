"""Input pulley on the motor's shaft: load of its bearings, stress and sag of the shaft, grip, the motor's seat."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np

from mbcdm_cad.checks.bearings import LESS, input_reactions
from mbcdm_cad.checks.comparison import Check, Comparison, at_least, at_most, worst
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.checks.fixings import FRICTION, SET_SCREW_SHARE, SLIP_SAFETY, STRESS_SAFETY
from mbcdm_cad.checks.geometry import HOLE_WEB_MM, web_between
from mbcdm_cad.checks.input_pulley import GRIP_DIAMETERS
from mbcdm_cad.layouts.siso_spur.drive import is_overhung
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.siso_spur.overhung import hub_radius_mm, set_screw, shaft_end_z_mm
from mbcdm_cad.layouts.structure import overhung_sag_mm
from mbcdm_cad.parts.threads import clamp_force_N

# Share of the gap between drum and pulley that the shaft's sag may take (estimate).
SAG_SHARE = 0.5


def _pull(s: SpurLayout) -> tuple[float, float, float]:
    """Largest pull of the cables in N, at no load and peak torque; its distance from the face in mm; the load in N of
    the shaft's front bearing under it. At the end of the travel at which the cables have walked away from the motor."""
    span = s.drive.gearhead.span_mm
    force = max(float(np.linalg.norm(loads.inputs[0].force_N)) for loads in s.loads.on_bodies)
    ((_, _, centred),) = s.once("input_reactions", input_reactions)
    front = centred + force * s.drive.walk_mm / 2 / span
    return force, span * (front / max(force, 1e-9) - 1.0), front


def motor_shaft_load(s: SpurLayout) -> Comparison:
    """Radial load that the shaft of motor or gearhead can take at the cables' distance, over their pull."""
    gear = s.drive.gearhead
    force, at, front = _pull(s)
    takes = gear.permitted_N(at)
    what = f"{takes:.4g} N that the {s.drive.mounted}'s shaft takes {at:.3g} mm from its face over the cables'"
    note = f"{gear.radial_load_N:g} N of the catalogue, by the load of the shaft's front bearing"
    return at_least(f"{what} {force:.4g} N", gear.front_reaction_N / max(front, 1e-9), 1.0, "times", note)


def motor_shaft_stress(s: SpurLayout) -> Comparison:
    """Bending and torsion of the shaft at the face, against the yield stress of steel."""
    force, at, _ = _pull(s)
    radius, strength = s.drive.gearhead.shaft_diameter_mm / 2, s.drive.material("steel").yield_MPa
    section = pi * radius**3 / 4
    stress = sqrt((force * at / section) ** 2 + 3 * (s.loads.highest_input_Nm * 1e3 / (2 * section)) ** 2)
    what = f"yield {strength:g} MPa over {stress:.4g} MPa in the {s.drive.mounted}'s shaft at its face"
    return at_least(what, strength / max(stress, 1e-9), STRESS_SAFETY, "times")


def motor_shaft_sag(s: SpurLayout) -> Comparison:
    """Distance by which the cables bend the shaft aside at the middle of the land, and its bearings give."""
    limit = SAG_SHARE * s.drive.clearances.running_mm
    return at_most("pulley pulled aside on the motor's shaft", overhung_sag_mm(s), limit, "mm")


def pulley_set_screws(s: SpurLayout) -> Comparison:
    """Torque that the pulley's two set screws hold on the round shaft, over the largest torque of the input."""
    screw, radius = set_screw(s.drive), s.drive.gearhead.shaft_diameter_mm / 2
    holds = 2 * FRICTION * SET_SCREW_SHARE * clamp_force_N(screw.thread_mm) * 2 * radius
    needed = s.loads.highest_input_Nm * 1e3
    return at_least(
        f"two set screws {screw.name} hold {holds:.4g} N mm over the input's {needed:.4g} N mm",
        holds / max(needed, 1e-9),
        SLIP_SAFETY,
        "times",
        "each presses the shaft on the bore opposite; a flat under one holds more",
    )


def hub_walls(s: SpurLayout) -> Comparison:
    """Walls of the pulley round its bore, and whole set screws in the hub."""
    drive, pulley = s.drive, s.inputs[0]
    screw, limit = set_screw(drive), drive.pulley_material.min_wall_mm
    wall = pulley.lower_surface_radius - pulley.bore_radius
    return worst(
        (
            at_least("wall of the land round the bore, or root of its groove", wall, limit, "mm"),
            at_least(
                f"hub's wall over the length of an {screw.name}",
                pulley.lower_journal_radius - pulley.bore_radius - screw.length_mm,
                0.0,
                "mm",
            ),
        )
    )


def motor_shaft_grip(s: SpurLayout) -> Comparison:
    """The shaft is in the pulley over its diameter, and past the set screws."""
    drive, pulley = s.drive, s.inputs[0]
    assert pulley.hub is not None
    end = min(shaft_end_z_mm(drive, s.levels), pulley.journal_top_z)
    what = f"{drive.mounted}'s shaft"
    return worst(
        (
            at_least(
                f"{what} inside the pulley",
                end - pulley.journal_bottom_z,
                GRIP_DIAMETERS * drive.gearhead.shaft_diameter_mm,
                "mm",
            ),
            at_least(f"{what} past its set screws", end - pulley.hub.screw_z - pulley.hub.thread / 2, 0.0, "mm"),
        )
    )


def motor_seat(s: SpurLayout) -> Comparison:
    """The heads of the motor's screws are sunk in the plate, with metal under them and round all holes."""
    drive, f, v = s.drive, s.frame, s.levels
    seat, screw, limit = f.motor, drive.screw(drive.gearhead.screw), drive.frame_material.min_wall_mm
    assert seat is not None
    back, shelf = v.plate_back_y, v.plate_back_y + seat.shelf
    holes: list[tuple[str, float, float, float, float, float]] = [
        ("pilot", 0.0, f.axis_z, seat.pilot_radius, back, shelf),
        *(("motor's screw", x, z, seat.screw_clearance, back, shelf) for x, z in seat.screws),
        *(("mount", x, z, f.mount_radius, back, v.front_y) for x, z in f.mounts),
    ]
    pocket = [("pocket", 0.0, f.axis_z, seat.pocket_radius, shelf, v.front_y), *holes[-len(f.mounts) :]]
    boss = f.axis_z - seat.pocket_radius - f.boss.seat_radius
    return worst(
        (
            *(at_least(f"plate, {name}", web, HOLE_WEB_MM, "mm") for name, web in web_between(holes)),
            *(at_least(f"plate, {name}", web, HOLE_WEB_MM, "mm") for name, web in web_between(pocket)),
            at_least("plate between pocket and the boss's bearings", boss, limit, "mm"),
            at_least(
                "heads of the motor's screws under the plate's front",
                drive.support.plate_mm - seat.shelf - screw.head_height_mm,
                0.0,
                "mm",
            ),
            at_least("plate under these heads", seat.shelf, limit, "mm"),
        )
    )


def hub_and_drum(s: SpurLayout) -> Comparison:
    """Gap between the hub with its set screws and the drum's rim with its cables."""
    drive = s.drive
    gap = drive.centre_distance_mm - drive.drum_radius_mm - s.flank_mm - hub_radius_mm(drive)
    return at_least("drum's rim from the hub of the input pulley", gap, drive.clearances.running_mm, "mm")


_SHAFT = "choose a motor or gearhead with a thicker shaft, or input_pulleys.carried_by: bearings"
CHECKS = tuple(
    check._replace(applies=is_overhung)
    for check in (
        Check(
            "motor_shaft_load",
            "Motor's bearings carry the cables",
            "catalogue: radial load at its distance; statics",
            motor_shaft_load,
            adjust=(*LESS, up("transmission.turns")),
            advice=_SHAFT,
        ),
        Check(
            "motor_shaft_stress",
            "Stress in the motor's shaft",
            "beam theory; 1.5 on yield: usual rule",
            motor_shaft_stress,
            adjust=LESS,
            advice=_SHAFT,
        ),
        Check(
            "motor_shaft_sag",
            "Sag of the motor's shaft under the cables",
            "beam theory; half of clearances.running_mm: estimate",
            motor_shaft_sag,
            "warn",
            adjust=LESS,
            advice=_SHAFT,
        ),
        Check(
            "pulley_set_screws",
            "Set screws hold the pulley on the motor's shaft",
            "mu F d; half of a cap screw's force: estimate",
            pulley_set_screws,
            adjust=(down("loads.peak_torque_Nm"), down("transmission.input_to_drum")),
            advice=_SHAFT,
        ),
        Check(
            "hub_walls_of_pulley",
            "Walls of the pulley on the motor's shaft",
            "material: min_wall_mm",
            hub_walls,
            adjust=(down("transmission.input_to_drum"), up("all radii of transmission")),
        ),
        Check(
            "motor_shaft_grip",
            "Motor's shaft reaches into the pulley",
            "one diameter: usual rule",
            motor_shaft_grip,
            adjust=(down("support.plate_mm"), down("support.motor_shelf_mm")),
            advice="choose a motor or gearhead with a longer shaft",
        ),
        Check(
            "motor_seat",
            "Plate takes the motor's pilot and screws",
            "material: min_wall_mm",
            motor_seat,
            adjust=(up("support.plate_mm"), up("transmission.centre_distance_mm")),
        ),
        Check(
            "hub_and_drum",
            "Hub of the input pulley clears the drum",
            "clearances.running_mm",
            hub_and_drum,
            adjust=(up("transmission.centre_distance_mm"),),
        ),
    )
)
