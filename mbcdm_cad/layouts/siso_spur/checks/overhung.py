"""Input pulley on the motor's shaft: load of its bearings, stress and sag of the shaft, grip, the motor's seat."""

import numpy as np

from mbcdm_cad.checks.bearings import LESS, input_reactions
from mbcdm_cad.checks.comparison import Comparison, Findings, at_least, at_most, check_for
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.checks.fixings import FRICTION, SLIP_SAFETY, STRESS_SAFETY, round_shaft_MPa, set_screws_hold_Nmm
from mbcdm_cad.checks.geometry import HOLE_WEB_MM, web_between
from mbcdm_cad.checks.input_pulley import GRIP_DIAMETERS
from mbcdm_cad.design.bought import Servo
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.siso_spur.pulley import MotorSeat, without_bearings
from mbcdm_cad.layouts.structure import lash_rad, overhung_sag_mm, structure_of
from mbcdm_cad.parts.fits import clamp_force_N

# Share of the gap between drum and pulley that the shaft's sag may take (estimate).
SAG_SHARE = 0.5
_SHAFT = (
    "choose a motor, gearhead or servo with a stronger shaft, or, without a servo, input_pulleys.carried_by: bearings"
)
_SMALLER = "choose a servo with a larger horn"


_on_shaft = check_for(lambda drive: drive.overhung)
_without_horn = check_for(lambda drive: drive.overhung and drive.servo is None)
_on_horn = check_for(lambda drive: drive.servo is not None)


def _pull(s: SpurLayout) -> tuple[float, float, float]:
    """Largest pull of the cables in N, at no load and peak torque; its distance from the face in mm; the load in N of
    the shaft's front bearing under it. At the end of the travel at which the cables have walked away from the motor, at
    the input where that bearing carries most."""
    span, found = s.drive.gearhead.span_mm, []
    for i, (_, _, centred) in enumerate(s.once("input_reactions", input_reactions)):
        force = max(float(np.linalg.norm(loads.inputs[i].force_N)) for loads in s.loads.on_bodies)
        front = centred + force * s.drive.walk_mm / 2 / span
        found.append((force, span * (front / max(force, 1e-9) - 1.0), front))
    return max(found, key=lambda pull: pull[2])


@_on_shaft(
    "Motor's bearings carry the cables",
    "catalogue: radial load at its distance; statics",
    *LESS,
    *up("transmission.turns"),
    advice=_SHAFT,
)
def motor_shaft_load(s: SpurLayout) -> Comparison:
    """Radial load that the shaft of motor or gearhead can take at the cables' distance, over their pull."""
    gear = s.drive.gearhead
    force, at, front = _pull(s)
    takes = gear.permitted_N(at)
    what = f"{takes:.4g} N that the {s.drive.mounted}'s shaft takes {at:.3g} mm from its face over the cables'"
    note = f"{gear.radial_load_N:g} N of the catalogue, by the load of the shaft's front bearing"
    return at_least(f"{what} {force:.4g} N", gear.front_reaction_N / max(front, 1e-9), 1.0, "times", note)


@_on_shaft("Stress in the motor's shaft", "beam theory; 1.5 on yield: usual rule", *LESS, advice=_SHAFT)
def motor_shaft_stress(s: SpurLayout) -> Comparison:
    """Bending and torsion of the shaft at the face, against the yield stress of steel."""
    force, at, _ = _pull(s)
    radius, strength = s.drive.gearhead.shaft_diameter_mm / 2, s.drive.material("steel").yield_MPa
    stress = round_shaft_MPa(radius, force * at, s.loads.highest_input_Nm * 1e3)
    what = f"yield {strength:g} MPa over {stress:.4g} MPa in the {s.drive.mounted}'s shaft at its face"
    return at_least(what, strength / max(stress, 1e-9), STRESS_SAFETY, "times")


@_on_shaft(
    "Sag of the motor's shaft under the cables",
    "beam theory; half of clearances.running_mm: estimate",
    *LESS,
    advice=_SHAFT,
    warn=True,
)
def motor_shaft_sag(s: SpurLayout) -> Comparison:
    """Distance by which the cables bend the shaft aside at the middle of the land, and its bearings give."""
    limit = SAG_SHARE * s.drive.clearances.running_mm
    return at_most("pulley pulled aside on the motor's shaft", overhung_sag_mm(s), limit, "mm")


@_without_horn(
    "Set screws hold the pulley on the motor's shaft",
    "mu F r (2 + sqrt 2), screws at right angles; half of a cap screw's force: estimate",
    *down("loads.peak_torque_Nm", "transmission.input_to_drum"),
    advice=_SHAFT,
    unit="times",
)
def pulley_set_screws(s: SpurLayout) -> Findings:
    """Torque that the pulley's two set screws hold on the round shaft, over the largest torque of the input."""
    screw, radius = without_bearings(s.drive).set_screw, s.drive.gearhead.shaft_diameter_mm / 2
    holds = set_screws_hold_Nmm(screw, radius)
    needed = s.loads.highest_input_Nm * 1e3
    yield (
        f"two set screws {screw.name} hold {holds:.4g} N mm over the input's {needed:.4g} N mm",
        holds / max(needed, 1e-9),
        SLIP_SAFETY,
        "they press the shaft on the bore opposite; a flat under one holds more",
    )


@_without_horn(
    "Walls of the pulley on the motor's shaft",
    "material: min_wall_mm",
    *down("transmission.input_to_drum"),
    *up("all radii of transmission"),
)
def hub_walls_of_pulley(s: SpurLayout) -> Findings:
    """Walls of the pulley round its bore, and whole set screws in the hub."""
    drive, pulley = s.drive, s.inputs[0]
    screw, limit = without_bearings(drive).set_screw, drive.pulley_material.min_wall_mm
    wall = pulley.lower_surface_radius - pulley.bore_radius
    yield "wall of the land round the bore, or root of its groove", wall, limit
    what = f"hub's wall over the length of an {screw.name}"
    yield (what, pulley.lower_journal_radius - pulley.bore_radius - screw.length_mm, 0.0)


@_without_horn(
    "Motor's shaft reaches into the pulley",
    "one diameter: usual rule",
    *down("support.plate_mm", "support.motor_shelf_mm"),
    advice="choose a motor or gearhead with a longer shaft",
)
def motor_shaft_grip(s: SpurLayout) -> Findings:
    """The shaft is in the pulley over its diameter, and past the set screws."""
    drive, pulley = s.drive, s.inputs[0]
    assert pulley.hub is not None
    end = min(without_bearings(drive).shaft_end_z_mm(s.levels), pulley.journal_top_z)
    what = f"{drive.mounted}'s shaft"
    yield f"{what} inside the pulley", end - pulley.journal_bottom_z, GRIP_DIAMETERS * drive.gearhead.shaft_diameter_mm
    yield f"{what} past its set screws", end - pulley.hub.screw_z - pulley.hub.thread / 2, 0.0


@_on_horn(
    "Screws hold the pulley on the servo's horn",
    "mu F r; class 8.8 at 0.7 of yield, mu 0.15: usual values",
    *down("loads.peak_torque_Nm", "transmission.input_to_drum"),
    advice=_SMALLER,
)
def horn_screws(s: SpurLayout) -> Comparison:
    """Torque that the screws hold between flange and horn by friction, over the largest torque of the input."""
    drive, servo = s.drive, _servo(s)
    screw, wanted = drive.screw(servo.horn_screw), s.loads.highest_input_Nm * 1e3
    holds = servo.horn_screws * FRICTION * clamp_force_N(screw.thread_mm) * servo.horn_circle_mm / 2
    what = f"{servo.horn_screws} {screw.name} hold {holds:.4g} N mm over the input's {wanted:.4g} N mm"
    return at_least(what, holds / max(wanted, 1e-9), SLIP_SAFETY, "times")


@_on_horn(
    "Pulley's flange fits the servo's horn",
    "usual rule: one diameter, or the horn's thickness",
    *up("transmission.input_to_drum"),
    *down("all radii of transmission"),
    advice=_SMALLER,
)
def horn_flange(s: SpurLayout) -> Findings:
    """The horn's screws go past the land, engage in the horn and do not reach through it; the flange's walls."""
    drive, servo, pulley = s.drive, _servo(s), s.inputs[0]
    screw, limit = drive.screw(servo.horn_screw), drive.pulley_material.min_wall_mm
    head, circle = screw.head_diameter_mm / 2, servo.horn_circle_mm / 2
    into = screw.length_mm - (pulley.lower_neck_bottom_z - pulley.journal_bottom_z)
    on_land = max(pulley.lower_land_radius, drive.input_radius_mm + s.flank_mm)
    yield "heads of the horn's screws beside land and cable", circle - head - on_land, 0.1
    yield "these heads inside the flange", servo.horn_mm / 2 - circle - head, -head / 2
    yield "horn's screws engaged", into, min(servo.horn_thickness_mm, screw.thread_mm)
    what = "end of the horn's screws before the servo's housing"
    yield (what, servo.horn_face_mm - servo.before_mm - into, drive.clearances.running_mm)
    yield "flange between the horn's screws and the recess", circle - screw.clearance_mm / 2 - pulley.bore_radius, limit


@_on_horn(
    "Play of the servo's gears",
    "catalogue; derived: lash over the ratio",
    *up("transmission.input_to_drum"),
    advice="choose a servo whose sensor is on its horn's shaft",
    warn=True,
)
def servo_lash(s: SpurLayout) -> Comparison:
    """Play of the drum by the servo's own gears that its sensor does not see, against the turn by cables and parts."""
    drive = s.drive
    play = lash_rad(drive, motors_held=False) * 1e3
    unheld = lash_rad(drive, motors_held=True) * 1e3
    limit = (structure_of(s).payload_urad_Nm + structure_of(s).cables_urad_Nm) * drive.loads.test_torque_Nm * 1e-3
    sees = "sees the horn" if _servo(s).sensor == "output" else "sees its motor alone"
    note = f"its sensor {sees}; {unheld:.3g} mrad while its motor stands still"
    return at_most("play of the drum by the servo's gears", play, limit, "mrad", note)


def _servo(s: SpurLayout) -> Servo:
    assert s.drive.servo is not None
    return s.drive.servo


def _servo_seat(s: SpurLayout, seat: MotorSeat, window: tuple[float, float, float]) -> Findings:
    """Window, threads for the ears and those of the frame's screws apart from each other and from the plate's edges."""
    drive, f, v, servo = s.drive, s.frame, s.levels, _servo(s)
    limit, screw = drive.frame_material.min_wall_mm, drive.screw(drive.gearhead.screw)
    half, low, high = window
    holes: list[tuple[str, float, float, float, float, float]] = [
        *(("ear's screw", x, z, seat.screw_clearance, v.plate_back_y, v.front_y) for x, z in seat.screws),
        *(("mount", x, z, f.mount_radius, v.plate_back_y, v.front_y) for x, z in f.mounts),
    ]
    into = screw.length_mm - servo.ear_mm
    for name, web in web_between(holes):
        yield f"plate, {name}", web, HOLE_WEB_MM
    between = min(max(low - z, z - high) for _, z in seat.screws) - screw.thread_mm / 2
    yield "plate, window from the screws of the ears", between, limit
    own = min(abs(x) for x, _ in f.mounts) - half - f.mount_radius
    yield "plate, window from the frame's own threads", own, limit
    yield "plate, window from the edge of the plate", f.half_width - half, limit
    below = min(low, *(z for _, z in seat.screws)) - f.boss.seat_radius
    yield "plate, boss's bearings from the window", below, limit
    yield "plate behind the ears' screws", drive.support.plate_mm - into, 0.0


@_on_shaft(
    "Plate takes the motor's pilot and screws",
    "material: min_wall_mm",
    *up("support.plate_mm", "transmission.centre_distance_mm"),
)
def motor_seat(s: SpurLayout) -> Findings:
    """The heads of the motor's screws are sunk in the plate, with metal under them and round all holes."""
    drive, f, v = s.drive, s.frame, s.levels
    if f.motor is not None and f.motor.window is not None:
        yield from _servo_seat(s, f.motor, f.motor.window)
        return
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
    for name, web in (*web_between(holes), *web_between(pocket)):
        yield f"plate, {name}", web, HOLE_WEB_MM
    yield "plate between pocket and the boss's bearings", boss, limit
    what = "heads of the motor's screws under the plate's front"
    yield (what, drive.support.plate_mm - seat.shelf - screw.head_height_mm, 0.0)
    yield "plate under these heads", seat.shelf, limit


@_on_shaft("Hub of the input pulley clears the drum", "clearances.running_mm", *up("transmission.centre_distance_mm"))
def hub_and_drum(s: SpurLayout) -> Comparison:
    """Gap between the hub with its set screws and the drum's rim with its cables."""
    drive = s.drive
    gap = drive.centre_distance_mm - drive.drum_radius_mm - s.flank_mm - without_bearings(drive).hub_radius_mm
    if drive.servo is not None:
        # Flange, horn and the heads on it are behind the rim.
        heads = s.inputs[0].lower_neck_bottom_z + drive.screw(drive.servo.horn_screw).head_height_mm
        gap = max(gap, min(s.levels.drum_inner_y, *(t.y_mm - s.drum.nut_pocket for t in s.drum.tensioners)) - heads)
    return at_least("drum's rim from the hub of the input pulley", gap, drive.clearances.running_mm, "mm")
