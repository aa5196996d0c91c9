"""Bearing loads against static ratings, and what reaches the gearhead in spite of the pulley's own bearings.

A deep-groove bearing runs normally at a static safety of 1 and quietly at 2 (bearing makers). The cable's pull of well
over 100 N on each input pulley is more than a gearhead of this size takes, so each pulley has a bearing at both ends.
"""

from __future__ import annotations

from math import pi

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, at_most, worst
from mbcdm_cad.checks.design_variables import Adjustment, down
from mbcdm_cad.configurations.miso_bevel.design_under_test import BevelUnderTest
from mbcdm_cad.configurations.miso_bevel.routes import GUIDE
from mbcdm_cad.design.bought import Bearing
from mbcdm_cad.model.bearing_loads import bearing_loads, two_bearing_reactions_N

STATIC_SAFETY = 1.0
QUIET_SAFETY = 2.0
# Radial play of a small deep-groove bearing, normal class, and what a gearhead's output shaft has (catalogues).
BEARING_PLAY_MM = 0.01
GEARHEAD_PLAY_MM = 0.02


def _safety(bearing: Bearing, name: str, load_N: float, limit: float) -> Comparison:
    what = f"{name}: {bearing.name}, static rating {bearing.static_rating_N:g} N over {load_N:.4g} N"
    return at_least(what, bearing.static_rating_N / max(load_N, 1e-9), limit, "times")


def input_reactions(s: BevelUnderTest) -> list[tuple[str, float, float]]:
    """(input, lower, upper) largest radial loads in N, at no load and at peak torque both ways."""
    v, bearings = s.levels, s.drive.bearings
    lower = (v.bearing_shelf_top_z - bearings.input_lower.width_mm / 2) * 1e-3
    upper = (v.top_plate_bottom_z + bearings.input_upper.width_mm / 2) * 1e-3
    found = []
    for i, name in enumerate(s.drive.input_names):
        most = np.zeros(2)
        for _, tension in s.loads.states:
            at = bearing_loads(s.loads.si, tension)
            load = at.inputs[i]
            pair = two_bearing_reactions_N(load.force_N, load.moment_Nm, load.height_m, lower, upper)
            most = np.maximum(most, np.linalg.norm(pair, axis=1))
        found.append((name, float(most[0]), float(most[1])))
    return found


def guide_forces_N(s: BevelUnderTest) -> list[NDArray[np.float64]]:
    """Forces on the axle at the guide's (lower, upper) bearing, shape (2, 3), in each state of the loads."""
    g = s.layout.guide
    apart = (g.top_z - g.bottom_z - g.seat_depth) * 1e-3
    middle = 0.5 * (s.steps[0].drum_radius_mm + s.steps[-1].drum_radius_mm)
    shift = (0.5 * (g.top_z + g.bottom_z) - middle) * 1e-3
    found = []
    for _, tension in s.loads.states:
        at = bearing_loads(s.loads.si, tension).bodies[GUIDE]
        # About the middle of the bearings, which need not be that of the steps.
        moment = at.moment_Nm - np.cross([0.0, 0.0, shift], at.force_N)
        couple = np.array([moment[1], -moment[0], 0.0]) / apart
        found.append(np.stack([at.force_N / 2 - couple, at.force_N / 2 + couple]))
    return found


def guide_reaction_N(s: BevelUnderTest) -> float:
    """Largest radial load on one of the guide's bearings."""
    return max(float(np.linalg.norm(pair, axis=1).max()) for pair in s.once("guide_forces", guide_forces_N))


def drum_reactions_N(s: BevelUnderTest) -> tuple[float, float]:
    """Largest radial loads of the drum's (rear, front) bearings."""
    shaft, width = s.layout.drum_shaft, s.drive.bearings.drum.width_mm
    rear, front = ((y + width / 2) * 1e-3 for y in (shaft.rear_bearing_y, shaft.front_bearing_y))
    most = [0.0, 0.0]
    for _, tension in s.loads.states:
        at = bearing_loads(s.loads.si, tension).drum
        force, moment = at.force_N, at.moment_Nm
        # About the rear bearing, with y x F = (y Fz, 0, -y Fx): the front bearing takes what is left of the moment.
        about = moment - np.cross([0.0, rear, 0.0], force)
        on_front = np.array([-about[2], 0.0, about[0]]) / (front - rear)
        on_rear = force - on_front
        loads = (float(np.hypot(on_rear[0], on_rear[2])), float(np.hypot(on_front[0], on_front[2])))
        most = [max(a, b) for a, b in zip(most, loads, strict=True)]
    return most[0], most[1]


def _input_safety(s: BevelUnderTest, limit: float) -> list[Comparison]:
    bearings = s.drive.bearings
    return [
        _safety(bearing, f"{end} bearing of the {name} input", load, limit)
        for name, low, high in s.once("input_reactions", input_reactions)
        for end, bearing, load in (("lower", bearings.input_lower, low), ("upper", bearings.input_upper, high))
    ]


def _guide_safety(s: BevelUnderTest, limit: float) -> list[Comparison]:
    return [_safety(s.drive.bearings.guide, "guide", guide_reaction_N(s), limit)]


def _drum_safety(s: BevelUnderTest, limit: float) -> list[Comparison]:
    return [
        _safety(s.drive.bearings.drum, f"{end} drum bearing", load, limit)
        for end, load in zip(("rear", "front"), s.once("drum_reactions", drum_reactions_N), strict=True)
    ]


def input_bearings(s: BevelUnderTest) -> Comparison:
    """Bearings at both ends of the input pulleys."""
    return worst(_input_safety(s, STATIC_SAFETY))


def guide_bearings(s: BevelUnderTest) -> Comparison:
    """Bearings in the guide, net pull and moment."""
    return worst(_guide_safety(s, STATIC_SAFETY))


def drum_bearings(s: BevelUnderTest) -> Comparison:
    """Bearings of the drum's shaft."""
    return worst(_drum_safety(s, STATIC_SAFETY))


def quiet_running(s: BevelUnderTest) -> Comparison:
    """All bearings against the safety asked for quiet running."""
    return worst([*_input_safety(s, QUIET_SAFETY), *_guide_safety(s, QUIET_SAFETY), *_drum_safety(s, QUIET_SAFETY)])


def _rating_needed(s: BevelUnderTest) -> str:
    finding, rated = quiet_running(s), s.drive.bearings.all()
    name = finding.subject.split(",")[0].split(": ")[1]
    rating = next(b.static_rating_N for b in rated if b.name == name)
    return f"choose a bearing of static rating {rating / finding.actual * QUIET_SAFETY:.4g} N or more in its place"


def drum_bearing_spacing(s: BevelUnderTest) -> Comparison:
    """Drum bearings stand apart by their own width."""
    shaft = s.layout.drum_shaft
    width = s.drive.bearings.drum.width_mm
    between = shaft.front_bearing_y - shaft.rear_bearing_y - width
    return at_least("space between the drum's bearings", between, width, "mm")


def coupling_runout(s: BevelUnderTest) -> Comparison:
    """How far the cables push the pulley aside at the coupling: more than the gearhead's play would load its shaft."""
    v, lay, drive = s.levels, s.layout, s.drive
    lower = v.bearing_shelf_top_z - drive.bearings.input_lower.width_mm / 2
    upper = v.top_plate_bottom_z + drive.bearings.input_upper.width_mm / 2
    span, overhang = upper - lower, lower - (lay.collar.bottom_z + lay.collar.top_z) / 2
    found = []
    for i, p in enumerate(lay.inputs):
        # The thinnest neck along the whole span, on the safe side.
        second_moment = pi * min(p.lower_neck_radius, p.upper_neck_radius, p.lower_surface_radius) ** 4 / 4
        stiffness = drive.input_pulleys.material.youngs_modulus_GPa * 1e3 * second_moment
        pull = max(float(np.linalg.norm(bearing_loads(s.loads.si, t).inputs[i].force_N)) for _, t in s.loads.states)
        low = float(np.clip(min(slot.chord_z for slot in p.slots) - lower, 0.0, span))
        slope = pull * (span - low) * (span**2 - (span - low) ** 2) / (6 * span * stiffness)
        moved = BEARING_PLAY_MM / 2 + slope * max(overhang, 0.0)
        note = f"its bearings carry {pull:.4g} N; the gearhead may carry {drive.gearhead.radial_load_N:g} N"
        found.append(at_most(f"{p.name} pulley pushed aside at the coupling", moved, GEARHEAD_PLAY_MM, "mm", note))
    return worst(found)


_LESS: tuple[Adjustment, ...] = (down("rope.preload_N"), down("loads.peak_torque_Nm"))
_RATING = "bearing catalogue; static safety 1: bearing makers, normal running"
_LARGER = "choose a larger bearing"
CHECKS = (
    Check(
        "input_bearings",
        "Input pulleys' bearings carry the cables",
        _RATING,
        input_bearings,
        adjust=_LESS,
        advice=_LARGER,
    ),
    Check("guide_bearings", "Guide's bearings carry the cables", _RATING, guide_bearings, adjust=_LESS, advice=_LARGER),
    Check("drum_bearings", "Drum's bearings carry the cables", _RATING, drum_bearings, adjust=_LESS, advice=_LARGER),
    Check(
        "quiet_running",
        "All bearings run quietly",
        "static safety 2: bearing makers, quiet running",
        quiet_running,
        "warn",
        advice=_rating_needed,
    ),
    Check(
        "drum_bearing_spacing",
        "Drum's bearings stand apart",
        "usual rule: one bearing width",
        drum_bearing_spacing,
        adjust=(down("support.back_y_mm"),),
    ),
    Check(
        "coupling_runout",
        "Pulleys' bearings spare the gearhead",
        "play of gearheads: 0.02 mm, estimate",
        coupling_runout,
        "warn",
        _LESS,
        _LARGER,
    ),
)
