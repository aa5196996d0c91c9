"""Idlers: wrap that turns them, walk of the cable on them, their bearings, the space round them, vibration of spans.

An idler turns freely, so that friction holds no load on it: the tensions on both sides differ by the friction of its
bearings alone, which the rope's friction on its wrap must overcome.
"""

from itertools import combinations
from math import exp, hypot
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.checks import bearings, geometry
from mbcdm_cad.checks.comparison import Findings, check_for
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.checks.fixings import FRICTION, SLIP_SAFETY, STRESS_SAFETY, bent_axle_Nmm, round_shaft_MPa
from mbcdm_cad.layouts.siso_spur.idlers import FLANGE_MM, StandDims, strap_screw
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.siso_spur.routes import flange_radius_mm
from mbcdm_cad.model.losses import BEARING_START, bearing_torque_Nm
from mbcdm_cad.model.tensioning import plucked_Hz
from mbcdm_cad.parts.fits import clamp_force_N
from mbcdm_cad.parts.terminal import tensioned_rope

# Friction that turns an idler over the friction of its bearings at the start: friction is known to a factor of two.
TURNED = 2.0
# Land beyond the cable at both ends of its walk (estimate).
EDGE_MM = 0.3
# Least space between the two bearings in an idler.
SPACE_MM = 1.0
# Lowest frequency of a span that hand or controller do not excite (estimate).
SPAN_HZ = 50.0


_idler_check = check_for(lambda drive: drive.idlers is not None)


@_idler_check(
    "Cable turns the idlers",
    "capstan equation against the bearings' friction; 2: friction is known to a factor of two",
    advice="move idlers.places across the cable, so that it wraps further",
    unit="times",
)
def idler_turns(s: SpurLayout) -> Findings:
    """Torque by which the rope turns an idler before it slips, over the friction of the idler's bearings."""
    drive = s.drive
    spec, radius = drive.idler_bearing, drive.leading.radius_mm
    tensions = {name: [state[j] for _, state in s.loads.states] for j, name in enumerate(s.loads.si.cable_names)}
    for body, _, cable, n in s.idlers:
        wrap = float(drive.strand.wraps[n])
        for tension in tensions[cable.name]:
            pull = 2.0 * float(tension) * np.sin(wrap / 2)
            drag = BEARING_START * float(bearing_torque_Nm(pull, 0.0, spec.bore_mm * 1e-3))
            able = float(tension) * (exp(drive.friction_coefficient * wrap) - 1.0) * radius * 1e-3
            note = f"wrap {np.degrees(wrap):.3g} deg; its bearings take {drag / radius * 1e3:.3g} N"
            yield f"torque of the rope on {body}, over its bearings'", able / drag, TURNED, note


@_idler_check(
    "Walk of the cable stays on the idlers",
    "derived: lead x ratio x travel / 360 deg, and the rise on the wrap; 0.3 mm: estimate",
    *up("idlers.width_mm"),
    *down("travel.half_angle_deg"),
)
def idler_walk(s: SpurLayout) -> Findings:
    """The cable stays on the land of each idler over the travel, and two bearings fit inside."""
    drive, wide = s.drive, s.drive.leading.width_mm
    edge = (wide - drive.idler_band_mm) / 2
    note = f"{drive.walk_mm:.3g} mm of walk, {drive.idler_band_mm:.3g} mm with rise and rope"
    yield "land of an idler beyond the cable at the ends of its walk", edge, EDGE_MM, note
    yield "space between the bearings of an idler", wide + 2 * FLANGE_MM - 2 * drive.idler_bearing.width_mm, SPACE_MM


class LoadedPin(NamedTuple):
    """Idlers on one axle, its stand, and in each state the forces (2 n, 3) at its bearings, which are ``at_mm``."""

    bodies: tuple[str, ...]
    at_mm: tuple[float, ...]
    stand: StandDims
    states_N: list[NDArray[np.float64]]

    @property
    def ends_mm(self) -> tuple[float, float]:
        """Where plate and strap hold the axle."""
        return self.stand.front_y, self.stand.strap_back_y


def bearing_forces_N(s: SpurLayout) -> list[LoadedPin]:
    """The axles under the pull of their cables: in each state of the loads, the cables at either end of their walk."""
    found = []
    for unit, pin in ((one, each) for one in s.input_units for each in one.pins):
        states = []
        for loads in s.loads.on_bodies:
            for walked in (-s.drive.walk_mm / 2, s.drive.walk_mm / 2):
                forces = list[NDArray[np.float64]]()
                for body, own, _, _ in pin:
                    rear, front = own.bearings_mm
                    force, at = loads.bodies[body].force_N, (own.bottom_z + own.top_z) / 2 + walked
                    on_front = force * (at - rear) / max(front - rear, 1e-9)
                    forces += [force - on_front, on_front]
                states.append(np.stack(forces))
        places = tuple(at for own in pin for at in own.dims.bearings_mm)
        bodies, stand = tuple(own.body for own in pin), unit.frame.stands[pin[0].number]
        found.append(LoadedPin(bodies, places, stand, states))
    return found


@_idler_check("Idlers' bearings carry the cables", bearings.RATING, *bearings.LESS, advice_on=bearings.larger)
def idler_bearings(s: SpurLayout) -> Findings:
    """Static safety of the idlers' bearings, the cable at either end of its walk."""
    spec = s.drive.idler_bearing
    for pin in s.once("idler_forces", bearing_forces_N):
        for k, body in enumerate(pin.bodies):
            yield bearings.safety(
                spec,
                f"bearings of {body}",
                max(float(np.linalg.norm(forces[2 * k : 2 * k + 2], axis=1).max()) for forces in pin.states_N),
                bearings.STATIC_SAFETY,
            )


@_idler_check(
    "Idlers' axles are strong enough",
    "beam theory; 1.5 on yield: usual rule",
    *bearings.LESS,
    advice="choose an idlers.bearing of larger bore",
    unit="times",
)
def idler_axles(s: SpurLayout) -> Findings:
    """Bending stress of the axles under their idlers' bearings, as beams on plate and strap."""
    strength = s.drive.shaft_material.yield_MPa
    for pin in s.once("idler_forces", bearing_forces_N):
        bent = max(bent_axle_Nmm(forces, pin.at_mm, pin.ends_mm)[0] for forces in pin.states_N)
        stress = round_shaft_MPa(pin.stand.axle_radius, bent)
        what = (
            f"yield {strength:g} MPa over the bending stress {stress:.4g} MPa of the axle of {' and '.join(pin.bodies)}"
        )
        yield what, strength / max(stress, 1e-12), STRESS_SAFETY


@_idler_check(
    "Strap of the idlers holds on its posts",
    "clamp force x 0.15; 1.2: usual rule; posts: beam theory, 1.5 on yield",
    *bearings.LESS,
    advice="choose a larger support.mount_screw",
    unit="times",
)
def idler_strap(s: SpurLayout) -> Findings:
    """Friction of a strap's screws on the posts, and the posts' strength, over the pull of both axles on the strap.

    Each post counts as a cantilever under half of the pull.
    """
    thread, metal = strap_screw(s.drive).thread_mm, s.drive.frame_material
    holds = 2 * FRICTION * clamp_force_N(thread)
    pins = s.once("idler_forces", bearing_forces_N)
    for unit, n in ((one, n) for one in s.input_units for n in range(len(one.frame.stands))):
        stand, of_input = unit.frame.stands[n], f" of {unit.drive.input_names[0]}" * (len(s.input_units) > 1)
        on_strap = [
            np.array([bent_axle_Nmm(forces, pin.at_mm, pin.ends_mm)[1] for forces in pin.states_N])
            for pin in pins
            if pin.stand is stand
        ]
        pulls = np.sum(on_strap, axis=0)
        pull = float(np.linalg.norm(pulls, axis=1).max())
        what = f"two screws of the strap of pair {n + 1}{of_input} hold {holds:.4g} N over {pull:.4g} N"
        yield what, holds / max(pull, 1e-9), SLIP_SAFETY
        wide, deep = np.ptp(stand.post_x), np.ptp(stand.post_z)
        sections = wide * deep / 6.0 * np.array([wide, deep])
        bent = float((np.abs(pulls[:, ::2]) * (stand.strap_back_y - stand.front_y) / 2.0 / sections).sum(axis=1).max())
        what = f"yield of {metal.name} over the {bent:.4g} MPa in the posts of pair {n + 1}{of_input}"
        yield what, metal.yield_MPa / max(bent, 1e-12), STRESS_SAFETY


@_idler_check(
    "Idlers clear drum, input and each other",
    "clearances.running_mm; material: min_wall_mm",
    *up("transmission.centre_distance_mm"),
    *down("idlers.radius_mm"),
    *up("idlers.radius_mm"),
    advice="move idlers.places away from the drum, or leave them out",
)
def idler_room(s: SpurLayout) -> Findings:
    """Gaps of the idlers to the drum with its terminals, to the input, and to each other; wall over their bearings."""
    drive, running = s.drive, s.drive.clearances.running_mm
    flange = flange_radius_mm(drive.leading.radius_mm, drive.cable.diameter_mm)
    own = s.idlers[0].dims
    pulley = max(s.inputs[0].lower_land_radius, drive.input_radius_mm + s.flank_mm)
    swept = max(geometry.drum_zones(s), key=lambda ring: ring.outer)
    yield "wall of an idler over its bearings", own.surface_radii[1] - own.seat_radius, drive.drum_material.min_wall_mm
    for place in drive.idler_places:
        to_drum = hypot(place.x_mm, place.z_mm) - flange - swept.outer
        yield f"idlers from the {swept.name}, as it turns", to_drum, running
        to_input = hypot(place.x_mm, drive.centre_distance_mm - place.z_mm) - flange - pulley
        yield "idlers from the input pulley", to_input, running
    # One of each axle; those on it are one pitch apart, as their sectors are.
    axles = [(one.body, one.cable.drum_side, drive.idler_places[one.number]) for one, *_ in s.input_units[0].pins]
    stand = [(body, side * place.x_mm, place.z_mm) for body, side, place in axles]
    for (one, x, z), (two, other_x, other_z) in combinations(stand, 2):
        gap = hypot(x - other_x, z - other_z) - 2 * flange
        yield f"{one} from {two}", gap, running


@_idler_check(
    "Spans between idlers do not swing",
    "string, f = sqrt(T/m)/(2 l); 50 Hz: estimate",
    *up("rope.preload_N"),
    advice="give idlers.places with another pair in the longest span",
    warn=True,
    unit="Hz",
)
def span_mode(s: SpurLayout) -> Findings:
    """Lowest frequency of the longest span, plucked sideways, in the slackest state; its rope without stiffness."""
    rope = tensioned_rope(s.drive)
    longest = max(s.drive.led_mm[::2]) * s.drive.stretched * 1e-3
    for state, tension in s.loads.states:
        low = max(float(np.min(tension)), 1e-3)
        sag = 9.81 * rope.mass_kg_m * longest**2 / (8.0 * low) * 1e3
        note = f"{longest * 1e3:.4g} mm, {low:.3g} N; it sags by {sag:.2g} mm under its weight where it lies level"
        yield f"first mode of the longest span, {state}", plucked_Hz(low, rope.mass_kg_m, longest), SPAN_HZ, note
