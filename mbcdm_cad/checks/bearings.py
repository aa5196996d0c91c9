"""Bearing loads against static ratings, and the deflection at the gearhead that the pulley's own bearings leave.

A deep-groove bearing runs normally at a static safety of 1 and quietly at 2 (bearing makers). Each input pulley has
one at both ends: its cables pull with well over 100 N, more than a gearhead of this size can carry.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from mbcdm_cad.checks.comparison import Check, Comparison, Findings, at_least, at_most, check, check_for
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.design.bought import Bearing
from mbcdm_cad.design.catalogue import smallest_entry
from mbcdm_cad.design.paths import at
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.layouts.structure import pulley_sections
from mbcdm_cad.model.equilibrium import BearingLoads
from mbcdm_cad.routes.route import two_bearing_reactions_N

STATIC_SAFETY = 1.0
QUIET_SAFETY = 2.0
# Radial play of a small deep-groove bearing, normal class, and of a gearhead's output shaft (catalogues).
BEARING_PLAY_MM = 0.01
GEARHEAD_PLAY_MM = 0.02
# Lengths of a pulley between its bearings whose bending is added up.
_PLACES = 400
LESS = down(at.rope.preload_N, at.loads.peak_torque_Nm)
RATING = "bearing catalogue; static safety 1: bearing makers, normal running"
# Of a drive whose input pulleys have bearings of their own, and couple to the motor without belt or gears.
carried_check = check_for(lambda drive: not drive.overhung)
coupled_check = check_for(lambda drive: drive.stage is None and not drive.overhung)


def safety(bearing: Bearing, name: str, load_N: float, limit: float) -> Comparison:
    what = f"{name}: {bearing.name}, static rating {bearing.static_rating_N:g} N over {load_N:.4g} N"
    return at_least(what, bearing.static_rating_N / max(load_N, 1e-9), limit, "times")


def input_reactions(s: SectorLayout) -> list[tuple[str, float, float]]:
    """(input, lower, upper) largest radial loads in N, at no load and at peak torque both ways."""
    return reactions(s, s.loads.on_bodies)


def reactions(s: SectorLayout, on_bodies: Sequence[BearingLoads], wheel: float = 1.0) -> list[tuple[str, float, float]]:
    """As :func:`input_reactions` under these loads, with ``wheel`` times the stage's load at the peak torque."""
    found = []
    for i, name in enumerate(s.drive.input_names):
        most, places = np.zeros(2), s.input_bearings_mm(i)
        axis = s.loads.si.routes.inputs[i].axis
        along = 1e-3 * s.levels_sense
        for loads in on_bodies:
            load, (lower, upper) = loads.inputs[i], (z * along for z in places)
            pair = two_bearing_reactions_N(load.force_N, load.moment_Nm, load.height_m, lower, upper, axis)
            most = np.maximum(most, np.linalg.norm(pair, axis=1))
        if s.stage is not None:
            # The wheel is beyond the lower bearing and pulls in the direction of the cables.
            force = s.stage.stage.across_N(s.once("stage_torque", stage_torque_Nm))
            over = (places[0] - s.stage.middle_z) / (places[1] - places[0])
            most += wheel * np.array([force * (1.0 + over), force * over])
        found.append((name, float(most[0]), float(most[1])))
    return found


def stage_torque_Nm(s: SectorLayout) -> float:
    """Largest torque on an input at the peak torque, with what cables and bearings lose on the way."""
    train, peak = s.losses.with_drive(s.loads.si), s.drive.loads.peak_torque_Nm
    motor = float(train.moving(np.array([peak, -peak]), 1).motor_Nm.max()) - train.motor_idle_Nm
    return max(float(train.output_Nm(motor)), s.loads.highest_input_Nm)


def drum_reactions_N(s: SectorLayout) -> tuple[float, float]:
    """Largest radial loads of the drum's (rear, front) bearings, the payload pulling the way the cables do."""
    payload, (rear_mm, front_mm) = s.drive.loads.carried, s.drum_bearings_mm
    apart = (front_mm - rear_mm) or 1e-9  # two bearings in one place carry no moment: the load is beyond any limit
    # The payload is in front of both.
    behind, before = (
        (payload.across_N * (s.levels.hub_face_y - other) + payload.tilt_Nm * 1e3) / apart
        for other in (front_mm, rear_mm)
    )
    rear, front, most = rear_mm * 1e-3, front_mm * 1e-3, [0.0, 0.0]
    for on_bodies in s.loads.on_bodies:
        force, moment = on_bodies.drum.force_N, on_bodies.drum.moment_Nm
        # Moments about the rear bearing, with y x F = (y Fz, 0, -y Fx): the front bearing balances them.
        about_x, about_z = moment[0] - rear * force[2], moment[2] + rear * force[0]
        on_front = np.array([-about_z, 0.0, about_x]) / (front - rear)
        on_rear = force - on_front
        loads = (float(np.hypot(on_rear[0], on_rear[2])), float(np.hypot(on_front[0], on_front[2])))
        most = [max(a, b) for a, b in zip(most, loads, strict=True)]
    return most[0] + behind, most[1] + before


def input_safety(s: SectorLayout, limit: float) -> list[Comparison]:
    bearings = s.drive.bearings
    return [
        safety(bearing, f"{end} bearing of the {name} input", load, limit)
        for name, low, high in s.once("input_reactions", input_reactions)
        for end, bearing, load in (("lower", bearings.input_lower, low), ("upper", bearings.input_upper, high))
    ]


def drum_safety(s: SectorLayout, limit: float) -> list[Comparison]:
    axial = s.preload_spring.force_N
    return [
        # Static equivalent load of a deep-groove bearing, ISO 76.
        safety(s.drive.bearings.drum, f"{end} drum bearing", max(load, 0.6 * load + 0.5 * axial), limit)
        for end, load in zip(("rear", "front"), s.once("drum_reactions", drum_reactions_N), strict=True)
    ]


# By the first word of a finding: the bearing's name in the drive, and the field of the file that states it.
_NAMED = {
    "lower": ("input_lower", at.input_pulleys.lower_bearing),
    "upper": ("input_upper", at.input_pulleys.upper_bearing),
    "rear": ("drum", at.drum.bearing),
    "front": ("drum", at.drum.bearing),
    "bearings": ("idler", "idlers.bearing"),
}


def larger(s: SectorLayout, finding: Comparison) -> str:
    """Advice: the field of the bearing that is found, and the rating that gives it the safety asked for."""
    if finding.actual <= 0.0:
        return "lower the load on it: no bearing carries one that has no bound"
    word = finding.subject.split()[0].rstrip(":")
    own, field = _NAMED.get(word, (word, f"{word}.bearing"))
    chosen = getattr(s.drive.bearings, own)
    needed = chosen.static_rating_N / finding.actual * finding.limit
    same = smallest_entry(
        "bearings", "mass_g", lambda e: e["bore_mm"] == chosen.bore_mm and e["static_rating_N"] >= needed
    )
    such = f", such as {same} of the same bore" if same else ""
    return f"choose {'an' if field[0] in 'aeiou' else 'a'} {field} of static rating {needed:.4g} N or more{such}"


def quiet(measure: Callable[[Any], Findings]) -> Check:
    """The check that all bearings run quietly, of the function that yields all bearings of the layout."""
    source = "static safety 2: bearing makers, quiet running"
    return check("All bearings run quietly", source, advice_on=larger, warn=True)(measure)


@carried_check("Input pulleys' bearings carry the cables", RATING, *LESS, advice_on=larger)
def input_bearings(s: SectorLayout) -> Findings:
    """Static safety of the bearings at both ends of the input pulleys."""
    yield from input_safety(s, STATIC_SAFETY)


@check("Drum's bearings carry cables and payload", RATING, *LESS, *down(at.support.back_y_mm), advice_on=larger)
def drum_bearings(s: SectorLayout) -> Findings:
    """Static safety of the bearings of the drum's shaft."""
    yield from drum_safety(s, STATIC_SAFETY)


@quiet
def quiet_running(s: SectorLayout) -> Findings:
    """All bearings of a drive that has bearings only at its inputs and its drum; not a motor's own."""
    if not s.drive.overhung:
        yield from input_safety(s, QUIET_SAFETY)
    yield from drum_safety(s, QUIET_SAFETY)


@check("Distance between the drum's bearings", "usual rule: one bearing width", *down(at.support.back_y_mm))
def drum_bearing_spacing(s: SectorLayout) -> Comparison:
    """Distance between the drum's bearings, without the spring between them: at least one bearing width."""
    shaft = s.drum_shaft
    width = s.drive.bearings.drum.width_mm
    between = shaft.front_bearing_y - shaft.rear_bearing_y - width - s.preload_spring.height
    return at_least("space between the drum's bearings", between, width, "mm")


@coupled_check(
    "Deflection of the input pulleys at the coupling",
    "play of gearheads: 0.02 mm, estimate",
    *LESS,
    *up("all radii of transmission"),
    advice="choose an input_pulleys.lower_bearing of larger bore, which makes the pulley's journal stiffer",
    warn=True,
)
def coupling_runout(s: SectorLayout) -> Findings:
    """Sideways movement of the pulley at the coupling from the cables; beyond its play it loads the gearhead."""
    drive = s.drive
    for i, p in enumerate(s.inputs):
        lower = s.input_bearings_mm(i)[0]
        overhang = lower - (s.collar.bottom_z + s.collar.top_z) / 2
        pull = max(float(np.linalg.norm(loads.inputs[i].force_N)) for loads in s.loads.on_bodies)
        moved = BEARING_PLAY_MM / 2 + pull * _slope_N(s, i) * max(overhang, 0.0)
        note = f"its bearings carry {pull:.4g} N; the {drive.mounted} may carry {drive.gearhead.radial_load_N:g} N"
        yield at_most(f"{p.name} pulley pushed aside at the coupling", moved, GEARHEAD_PLAY_MM, "mm", note)


def _slope_N(s: SectorLayout, index: int) -> float:
    """Slope of a pulley in its lower bearing for 1 N across its land, where it bends it most; rad per N.

    By reciprocity the bend under a couple of 1 N mm on that bearing.
    """
    pulley, (lower, upper) = s.inputs[index], s.input_bearings_mm(index)
    step = (upper - lower) / _PLACES
    middle = lower + step * (np.arange(_PLACES) + 0.5)
    stiff = np.full(_PLACES, np.inf)
    try:
        for part in pulley_sections(pulley):
            inside = (middle >= part.start_mm) & (middle <= part.end_mm)
            stiff[inside] = part.second_moment_mm4 * s.drive.pulley_material.youngs_modulus_GPa * 1e3
    except ValueError as error:
        raise NoFigureError(f"the bore takes the pulley's wall: {error}") from None
    turned = np.cumsum((upper - middle) / (upper - lower) / stiff) * step
    bent = np.cumsum(turned) * step
    bent -= bent[-1] * np.arange(1, _PLACES + 1) / _PLACES
    on_land = (middle >= pulley.land_bottom_z) & (middle <= pulley.land_top_z)
    return float(np.abs(bent[on_land]).max(initial=0.0))
