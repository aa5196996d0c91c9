"""Joints that hold by friction or by a pin: clamp collar, set screws, stop pin; and stresses in pulley and shaft."""

from collections.abc import Sequence
from contextlib import suppress
from math import hypot, pi, sqrt
from typing import NamedTuple

import numpy as np

from mbcdm_cad.checks.bearings import carried_check, drum_reactions_N, reactions
from mbcdm_cad.checks.comparison import Comparison, Findings, check, noted
from mbcdm_cad.checks.design_variables import LESS_TORQUE, down, up
from mbcdm_cad.checks.drum_sector import stop_check
from mbcdm_cad.checks.strength import rated_input_Nm
from mbcdm_cad.design.bought import Material, Screw
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.model.equilibrium import BearingLoads, bearing_loads, solve_equilibrium
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.parts.fits import PLASTIC_SHARE, clamp_force_N
from mbcdm_cad.routes import Floats

# Steel on steel, dry (usual value).
FRICTION = 0.15
# Set screws have no head: with their small socket they reach about half of that (estimate).
SET_SCREW_SHARE = 0.5
SLIP_SAFETY = 1.2
# A third of the clamp's force may go into bending ring and slit journal (estimate).
CLAMP_SAFETY = 1.8
# Yield over bending stress (usual for steady loads on ductile metal).
STRESS_SAFETY = 1.5
# Friction of a greased small bearing, of its mean diameter (bearing makers).
BEARING_FRICTION = 0.0015


def lasting_MPa(material: Material) -> float:
    """Stress that a part bears for years: yield, of plastics the share that creep leaves."""
    return material.yield_MPa * (PLASTIC_SHARE if material.printed else 1.0)


def round_shaft_MPa(radius_mm: float, bending_Nmm: float, torque_Nmm: float = 0.0) -> float:
    """Equivalent stress on the outside of a round shaft that is bent and twisted (von Mises)."""
    modulus = pi * radius_mm**3 / 4
    return sqrt((bending_Nmm / modulus) ** 2 + 3 * (torque_Nmm / (2 * modulus)) ** 2)


def bent_axle_Nmm(forces_N: Floats, at_mm: Sequence[float], ends_mm: tuple[float, float]) -> tuple[float, Floats]:
    """Largest moment in an axle on two ends under forces (n, 3) at n places, and the force (3,) on its far end."""
    (start, end), at = ends_mm, np.asarray(at_mm)
    on_far = (at - start) @ forces_N / (end - start)
    on_near = forces_N.sum(axis=0) - on_far
    # The moment at each force: that of the near end less those of the forces before it.
    before = np.maximum(at[:, None] - at, 0.0) @ forces_N
    moments = np.linalg.norm(on_near * (at - start)[:, None] - before, axis=1)
    return float(moments.max()), on_far


@carried_check(
    "Clamp collars hold the torque",
    "mu N d; class 8.8 at 0.7 of yield, mu 0.15: usual values",
    *LESS_TORQUE,
    advice="choose a drive.gearhead with a thicker shaft",
    unit="times",
)
def collar_grip(s: SectorLayout) -> Findings:
    """Torque that a clamp collar holds, over the largest torque of an input.

    The ring bends like a hinge opposite its slit, so that the screw presses the bore with F (1 + a/h), a and h the
    distances of screw and hinge from the axis; two contact zones together carry mu N d. The part of the force that
    deforms ring and slit journal is covered by the safety factor.
    """
    drive, collar = s.drive, s.collar
    hinge = (collar.bore_radius + collar.radius) / 2
    clamp_N = clamp_force_N(drive.screw(collar.screw).thread_mm)
    holds = FRICTION * clamp_N * (1 + collar.screw_offset / hinge) * drive.clamped_mm
    needed = s.loads.highest_input_Nm * 1e3
    what = f"clamp collar holds {holds:.4g} N mm over the input's {needed:.4g} N mm"
    yield what, holds / max(needed, 1e-9), CLAMP_SAFETY


def set_screws_hold_Nmm(screw: Screw, shaft_radius_mm: float) -> float:
    """Torque that two set screws at right angles hold on a shaft: mu F r at each point, and at the bore opposite, which
    carries both thrusts together, mu sqrt(2) F r (statics)."""
    return FRICTION * SET_SCREW_SHARE * clamp_force_N(screw.thread_mm) * (2.0 + sqrt(2.0)) * shaft_radius_mm


@check(
    "Hub's set screws hold the shaft",
    "mu F r (2 + sqrt 2), screws at right angles; half of a cap screw's force: estimate",
    advice="choose a smaller drum.bearing",
    unit="times",
)
def hub_set_screws(s: SectorLayout) -> Findings:
    """The set screws turn the drum's shaft against bearing friction only; the load does not pass through the shaft."""
    holds = set_screws_hold_Nmm(s.drive.screw(s.drum.set_screw), s.drum_shaft.radius)
    needed = (
        BEARING_FRICTION * sum(s.once("drum_reactions", drum_reactions_N)) * s.drive.bearings.drum.outer_diameter_mm / 2
    )
    what = f"two set screws hold {holds:.4g} N mm over bearing friction of {needed:.3g} N mm"
    yield what, holds / max(needed, 1e-3), SLIP_SAFETY, "output is taken at the hub"


def stalled_Nm(s: SectorLayout) -> float:
    """Torque on the drum at its stop with all motors stalled at their rated torque, not less than the peak torque.

    Gearheads count without losses; of a servo the torque at its horn is known, which has lost in its gears.
    """
    ratio = sum(o.drum_radius_mm / o.input_radius_mm for o in s.steps) / len(s.steps)
    torque = rated_input_Nm(s) if s.drive.servo is None else s.drive.reduction.rated_torque_mNm * 1e-3
    return max(s.drive.loads.peak_torque_Nm, torque * ratio * len(s.inputs))


class Strongest(NamedTuple):
    """The largest loads that a drive meets: no load, peak torque and motors stalled at the stop, both ways.

    ``over_peak``: the torque of the stalled motors over the peak torque.
    """

    on_bodies: tuple[BearingLoads, ...]
    input_Nm: float
    over_peak: float


def strongest(s: SectorLayout) -> Strongest:
    """Those of a design. Cables that do not carry the stalled motors slip: then no more than the peak torque counts."""
    stalled, si = stalled_Nm(s), s.loads.si
    over = stalled / s.drive.loads.peak_torque_Nm
    if over > 1.0:
        with suppress(ModelError):
            found = solve_equilibrium(si, np.array([stalled, -stalled]))
            held = tuple(bearing_loads(si, tension) for tension in found.tension_N.T)
            most = max(s.loads.highest_input_Nm, float(np.abs(found.input_torque_Nm(si)).max()))
            return Strongest((*s.loads.on_bodies, *held), most, over)
    return Strongest(s.loads.on_bodies, s.loads.highest_input_Nm, 1.0)


@stop_check(
    "Stop pin holds stalled motors",
    "beam theory; 1.5 on yield: usual rule",
    *down("drum.web_thickness_mm", "loads.peak_torque_Nm"),
    *up("all radii of transmission"),
    unit="times",
)
def stop_pin(s: SectorLayout) -> Findings:
    """Bending of the pin between the frame's front and the web, with both motors stalled against it."""
    stall = stalled_Nm(s)
    lever = (s.drum.web_start_y + s.drum.web_end_y) / 2 - s.levels.front_y
    stress = round_shaft_MPa(s.frame.stop_pin_radius, stall * 1e3 / s.drum.stop_radius * lever)
    strength = s.drive.material("steel").yield_MPa
    what = f"yield {strength:g} MPa over the stop pin's {stress:.4g} MPa at {stall:.4g} N m"
    yield what, strength / max(stress, 1e-9), STRESS_SAFETY


@carried_check(
    "Stress in the input pulleys' necks",
    "beam theory; 1.5 on yield: usual rule",
    *LESS_TORQUE,
    *down("rope.preload_N"),
    advice="choose an input_pulleys.lower_bearing and upper_bearing of larger bore",
    unit="times",
)
def pulley_stress(s: SectorLayout) -> Findings:
    """Stress in the input pulley's necks from bending and torsion, against the yield stress.

    At no load, at the peak torque and with the motors stalled at the stop. Printed pulleys count with the strength that
    creep leaves.
    """
    strength, most = lasting_MPa(s.drive.pulley_material), s.once("strongest", strongest)
    torque = most.input_Nm * 1e3
    carried_N = reactions(s, most.on_bodies, most.over_peak)
    for i, (p, (name, low, high)) in enumerate(zip(s.inputs, carried_N, strict=True)):
        lower, upper = s.input_bearings_mm(i)
        ends = (
            ("lower", p.lower_neck_radius, low * (p.land_bottom_z - lower), torque),
            ("upper", p.upper_neck_radius, high * (upper - p.land_top_z), 0.0),
        )
        for end, radius, bending, twist in ends:
            if radius <= 0.0:
                raise NoFigureError(f"nothing is left of the {end} neck of {name} (radius {radius:.4g} mm)")
            stress = round_shaft_MPa(radius, bending, twist)
            what = f"yield {strength:g} MPa over {stress:.4g} MPa in the {end} neck of {name}"
            yield what, strength / max(stress, 1e-9), STRESS_SAFETY


@check(
    "Stress in the drum's shaft",
    "beam theory; 1.5 on yield: usual rule",
    *down("drum.shaft_bore_mm"),
    *LESS_TORQUE,
    *down("rope.preload_N"),
    advice="choose a larger drum.bearing, whose bore the shaft has",
    unit="times",
)
def shaft_stress(s: SectorLayout) -> Findings:
    """Bending of the drum's shaft at its front bearing, by the cables and the payload, against the yield stress.

    At no load, at the peak torque and with the motors stalled at the stop. The shaft only carries forces across its
    axis: the torque passes from the lands to the hub's face.
    """
    shaft, front = s.drum_shaft, s.drum_bearings_mm[1]
    payload, strength = s.drive.loads.carried, s.drive.shaft_material.yield_MPa
    cables = 0.0
    for loads in s.once("strongest", strongest).on_bodies:
        # Moment about the front bearing, whose middle is at (0, front, 0).
        about = loads.drum.moment_Nm * 1e3 - np.cross([0.0, front, 0.0], loads.drum.force_N)
        cables = max(cables, hypot(about[0], about[2]))
    by_payload = payload.across_N * (s.levels.hub_face_y - front) + payload.tilt_Nm * 1e3
    modulus = pi / 4 * (shaft.radius**4 - shaft.bore_radius**4) / shaft.radius
    stress = (cables + by_payload) / max(modulus, 1e-9)
    what = (
        f"yield {strength:g} MPa over {stress:.4g} MPa in the drum's shaft at its front bearing, bent by "
        f"{cables * 1e-3:.3g} N m of the cables and {by_payload * 1e-3:.3g} of the payload:"
    )
    yield what, strength / max(stress, 1e-9), STRESS_SAFETY


@check("Twist of the drum's shaft", "derived: torsion of a tube")
def shaft_twist(s: SectorLayout) -> Comparison:
    """Twist of the drum's shaft for a load at its far end."""
    shaft, metal = s.drum_shaft, s.drive.shaft_material
    length = shaft.y_end - shaft.y_start
    shear = metal.youngs_modulus_GPa * 1e3 / (2 * (1 + metal.poisson_ratio))
    polar = pi / 2 * (shaft.radius**4 - shaft.bore_radius**4)
    twist = 1e3 * length / (shear * max(polar, 1e-9)) * 1e3
    what = "twist of the whole drum shaft if the output were taken at its far end"
    return noted(what, twist, "mrad per N m", "which would add to the backlash: the output is taken at the hub")
