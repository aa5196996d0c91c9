"""Centre line of each cable at a given drum angle, and figures that follow from it.

A cable runs: chord through the input pulley (swaged stop) - inward bend - helix on the input pulley - free span,
joined to helix and guide by short parabolas - arc on the guide - transfer - arc on the drum - straight into the
tensioner. Geometry derived from the pitch cone (transfer of step k at (0, r_gk, r_ok)).

Drawn state: the guide's arc lies in the plane z = r_ok, as it does after a move that winds the cable onto the input
pulley; `guide_landing_walk_mm` gives how far it moves in a full sweep.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import acos, atan2, cos, degrees, exp, hypot, log, pi, radians, sin, sqrt, tau

import numpy as np

from mbcdm_cad.layouts.bevel_transfer import ON_DRUM, on_drum
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive, BevelRun
from mbcdm_cad.parts.drum_sector.design import SectorRun
from mbcdm_cad.parts.input_pulley.dims import STOP_PIECES, StopGeometry, stop_geometry, stop_pieces
from mbcdm_cad.routes import Floats, route
from mbcdm_cad.routes.curves import Arc, CablePath, Helix, Line, Parabola, Piece, Stretch, triple

# The rope's bending stiffness rounds the change of slope between span and pulley over a few sqrt(EI/T), about 0.7 mm
# for 49 free wires of 0.09 mm at 70 N; this transition is drawn 2.5 diameters long.
BLEND_DIAMETERS = 2.5


@dataclass(frozen=True)
class Winding:
    """Tangent points of a cable on input pulley and guide; angles in rad about Z, seen from +z, for any drum angle."""

    guide_sense: int  # +1: the cable, followed towards the drum, goes anticlockwise round the guide
    guide_landing_rad: float
    guide_wrap_rad: float
    input_contact_rad: float
    free_span_mm: float
    outward: int  # +1: the dead turn lies at larger z than the step plane
    reduction: float  # r_o / r_m


def winding(drive: BevelDrive, cable: BevelRun) -> Winding:
    """Tangent points of the figure-eight span between an input pulley and the guide.

    Free span sqrt(L^2 - (r_g + r_m)^2), paper Eq. (11). Raises ValueError if L <= r_g + r_m (pulleys overlap).
    """
    length, r_g, r_m = drive.centre_distance_mm, cable.guide_radius_mm, cable.input_radius_mm
    if length <= r_g + r_m:
        raise ValueError(f"centre distance {length} mm must exceed r_g + r_m = {r_g + r_m} mm for {cable.name}")
    sense = -cable.drum_side
    towards_input = pi + drive.input_turn_rad if cable.input_side < 0 else 0.0 - drive.input_turn_rad
    beta = acos((r_g + r_m) / length)
    # Of the two internal tangents, the one whose direction of travel agrees with the sense of rotation.
    landing = towards_input + sense * beta
    wrap = (sense * (pi / 2 - landing)) % tau
    others = [c for c in drive.cables if c.input_name == cable.input_name and c.name != cable.name]
    outward = 1 if all(cable.step > c.step for c in others) else -1
    return Winding(
        guide_sense=sense,
        guide_landing_rad=landing % tau,
        guide_wrap_rad=wrap,
        input_contact_rad=(landing + pi) % tau,
        free_span_mm=sqrt(length**2 - (r_g + r_m) ** 2),
        outward=outward,
        reduction=cable.drum_radius_mm / cable.input_radius_mm,
    )


def input_wrap_rad(drive: BevelDrive, cable: SectorRun, drum_angle_rad: float) -> float:
    """Wrap on the input pulley: dead turns and i (half travel - q theta)."""
    ratio = cable.drum_radius_mm / cable.input_radius_mm
    return tau * drive.dead_turns + ratio * (radians(drive.half_travel_deg) - cable.drum_side * drum_angle_rad)


def stop_of(drive: BevelDrive, cable: BevelRun) -> StopGeometry:
    """The cable's end in its input pulley."""
    w = winding(drive, cable)
    end = w.input_contact_rad + w.guide_sense * input_wrap_rad(drive, cable, 0.0)
    return stop_geometry(drive, cable.input_radius_mm, end, w.guide_sense)


# The stretches of a cable by what carries them: wound on the input pulley, free and on the guide, on the drum.
WOUND = (*STOP_PIECES, "helix")
FREE = ("span_in", "span", "span_out", "guide")


def axial_walk_mm(drive: BevelDrive, cable: BevelRun, drum_angle_rad: float) -> float:
    """Offset of the input contact from the step plane, positive away from the dead turn. p (r_o/r_m) theta / 2 pi."""
    return -cable.drum_side * winding(drive, cable).reduction * drum_angle_rad * drive.helix_lead_mm / tau


def cable_path(
    drive: BevelDrive, cable: BevelRun, anchor_rad: float, tail_mm: float, drum_angle_rad: float
) -> CablePath:
    """Centre line at ``drum_angle_rad``.

    ``anchor_rad``: angle on the drum, from +Z towards the cable's side, where the cable leaves its land with the drum
    centred; ``tail_mm``: straight length from there into the tensioner.
    """
    w = winding(drive, cable)
    r_m, r_g, r_o = cable.input_radius_mm, cable.guide_radius_mm, cable.drum_radius_mm
    z_step = r_o
    inward = -w.outward
    walk = axial_walk_mm(drive, cable, drum_angle_rad)
    z_contact = z_step + inward * walk
    lead = drive.helix_lead_mm
    wound = input_wrap_rad(drive, cable, drum_angle_rad)
    away = w.guide_sense  # sense from the contact into the winding; towards the guide it is opposite
    a_contact = w.input_contact_rad
    a_end = a_contact + away * wound
    z_end = z_contact + w.outward * lead * wound / tau
    x, y = cable.input_side * drive.input_x_mm, drive.input_y_mm
    helix = Helix((x, y), r_m, a_end, a_contact, z_end, z_contact)

    pieces: list[tuple[str, Piece]] = []
    # Inward bend and chord, in the plane of the helix's end tangent and the radius there.
    radial = np.array([cos(a_end), sin(a_end), 0.0])
    start = np.array([x + r_m * radial[0], y + r_m * radial[1], z_end])
    back = -helix.tangent(0.0)
    ends = stop_pieces(start, radial, back, r_m, stop_of(drive, cable))
    pieces.extend(zip(STOP_PIECES, ends, strict=True))
    pieces.append(("helix", helix))

    contact = helix.points(np.array([1.0]))[0]
    a_land = w.guide_landing_rad
    landing = np.array([r_g * cos(a_land), r_g * sin(a_land), z_step])
    plan = (landing - contact) * np.array([1.0, 1.0, 0.0]) / w.free_span_mm
    slope_helix = helix.tangent(1.0)
    slope_helix = slope_helix[2] / hypot(slope_helix[0], slope_helix[1])
    blend = min(BLEND_DIAMETERS * drive.cable.diameter_mm, 0.3 * w.free_span_mm)
    up = np.array([0.0, 0.0, 1.0])
    first_mid = contact + blend / 2 * (plan + slope_helix * up)
    last_mid = landing - blend / 2 * plan
    chord = last_mid - first_mid
    chord_rate = chord / hypot(chord[0], chord[1])
    first_end = first_mid + blend / 2 * chord_rate
    last_start = last_mid - blend / 2 * chord_rate
    pieces.append(("span_in", Parabola(triple(contact), triple(first_mid), triple(first_end))))
    pieces.append(("span", Line(triple(first_end), triple(last_start))))
    pieces.append(("span_out", Parabola(triple(last_start), triple(last_mid), triple(landing))))
    a_transfer = a_land + w.guide_sense * w.guide_wrap_rad
    pieces.append(("guide", Arc((0.0, 0.0, z_step), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), r_g, a_land, a_transfer)))

    pieces.extend(on_drum(cable, anchor_rad + cable.drum_side * drum_angle_rad, tail_mm))
    stretches = (Stretch(f"input_{cable.input_name}", WOUND), Stretch(None, FREE), Stretch("drum", ON_DRUM))
    return CablePath(cable, drum_angle_rad, tuple(pieces), stretches)


def fleet_angle_at_deg(drive: BevelDrive, cable: BevelRun, drum_angle_rad: float) -> float:
    """Fleet angle at a drum angle, with the sign of the walk: atan(walk / free span)."""
    return degrees(atan2(axial_walk_mm(drive, cable, drum_angle_rad), winding(drive, cable).free_span_mm))


def fleet_angle_deg(drive: BevelDrive, cable: BevelRun) -> float:
    """Largest fleet angle over the travel, at both of its ends (the walk is symmetric)."""
    return abs(fleet_angle_at_deg(drive, cable, radians(drive.half_travel_deg)))


def guide_landing_walk_mm(drive: BevelDrive, cable: BevelRun) -> float:
    """Largest offset of the landing point on the guide from its step plane in a full sweep towards the drum (mm).

    Cable that comes from the drum lies in the step plane; cable that comes from the input follows the input's walk with
    a lag whose space constant is the free span, dz/ds = (w - z)/L_free, without lateral slip (derived).
    """
    w = winding(drive, cable)
    amplitude = abs(w.reduction * radians(drive.half_travel_deg) * drive.helix_lead_mm / tau)
    stroke, span = 2 * cable.drum_radius_mm * radians(drive.half_travel_deg), w.free_span_mm
    if amplitude == 0.0:
        return 0.0
    slope = -2 * amplitude / stroke
    lagging = amplitude - slope * span

    def z(s: float) -> float:
        """Closed form of the first-order lag on a ramp that starts at +amplitude, from z(0) = 0."""
        return amplitude + slope * (s - span) - lagging * exp(-s / span)

    # It rises up to where its rate is zero, then falls.
    return max(abs(z(min(-span * log(-slope * span / lagging), stroke))), abs(z(stroke)))


GUIDE_RADIUS, DISTANCE = "guide_radius_m", "centre_distance_m"
DRUM, GUIDE = "drum", "guide"
_MM = 1e-3
_X, _Y, _Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class BevelGeometry(route.AnchoredGeometry):
    """Spans and guide wraps from radii and centre distance.

    ``input_side`` (n_inputs,) is -1 for an input at x = -L, +1 at +L; ``drum_side`` (n_cables,) the side to which a
    cable runs on the drum; ``setback_m`` the distance of the inputs' axes towards -y; ``lead_m`` the lead of the helix
    there.
    """

    cable_names: tuple[str, ...]
    input_names: tuple[str, ...]
    input_of: tuple[int, ...]
    input_side: tuple[int, ...]
    drum_side: tuple[int, ...]
    # With input axes behind the guide's, the line of centres is rotated from the X axis by asin(setback / L).
    setback_m: float = 0.0
    # Designs that differ only in the lead have the same spans and wraps.
    lead_m: float = field(default=0.0, compare=False)
    per_cable: tuple[str, ...] = (route.INPUT_RADIUS, GUIDE_RADIUS, route.DRUM_RADIUS)
    varied: tuple[route.Varied, ...] = (
        route.Varied(DISTANCE, "centre distance", (26e-3, 30e-3, 34.6e-3, 45e-3, 60e-3), (33e-3, 40e-3)),
    )

    @cached_property
    def _long_way(self) -> Floats:
        """Additional wrap on the guide, rad: half a turn for a cable that runs on the drum to its own input's side."""
        side = [self.input_side[i] for i in self.input_of]
        return np.where(np.array(side) * np.array(self.drum_side) > 0, np.pi, 0.0)

    def _turn_rad(self, distance_m: Floats) -> Floats:
        """Angle, rad, of the line of centres to the X axis, away from the drum; NaN if there is none."""
        with np.errstate(invalid="ignore"):
            return np.asarray(np.arcsin(self.setback_m / distance_m))

    @property
    def passed_radii(self) -> dict[str, str]:
        """Radii on the guide, the only body that cables pass, m."""
        return {GUIDE: GUIDE_RADIUS}

    def free_span_m(self, parameters: Mapping[str, Floats]) -> Floats:
        """L_free = sqrt(L^2 - (r_g + r_i)^2), Eq. (11)."""
        return route.tangent_length_m(parameters[DISTANCE], parameters[GUIDE_RADIUS] + parameters[route.INPUT_RADIUS])

    def passed_wrap_rad(self, parameters: Mapping[str, Floats]) -> tuple[Floats, ...]:
        """Wrap on the guide, rad: beta, or half a turn more; a setback lengthens the short wrap, shortens the long."""
        reach = (parameters[GUIDE_RADIUS] + parameters[route.INPUT_RADIUS]) / parameters[DISTANCE]
        with np.errstate(invalid="ignore"):
            long_way = self._long_way.reshape(-1, *(1,) * (reach.ndim - 1))
            turn = np.where(long_way > 0.0, -1.0, 1.0) * self._turn_rad(parameters[DISTANCE])
            return (np.asarray(np.arcsin(reach) + long_way + turn),)

    def fault(self, parameters: Mapping[str, Floats]) -> str:
        """Message for pulleys that overlap."""
        reach = parameters[GUIDE_RADIUS] + parameters[route.INPUT_RADIUS]
        return (
            f"free span: centre distance {np.min(parameters[DISTANCE]):.6g} m does not exceed r_g + r_i = "
            f"{np.max(reach):.6g} m, so the cable has no straight span; raise centre_distance_mm or cut the radii"
        )

    def routes(self, parameters: Mapping[str, Floats]) -> route.DriveRoutes:
        """Bodies and cables of one design. If pulleys overlap, its spans are NaN."""
        span, wrap = self.free_span_m(parameters), self.passed_wrap_rad(parameters)[0]
        cables = tuple(self._cable(parameters, j, float(span[j]), float(wrap[j])) for j in range(len(self.cable_names)))
        return route.DriveRoutes(self._bodies(parameters), cables)

    def _bodies(self, parameters: Mapping[str, Floats]) -> tuple[route.Body, ...]:
        drum, distance = parameters[route.DRUM_RADIUS], float(parameters[DISTANCE])
        found = [
            route.Body(DRUM, "drum", (0.0, 0.0, 0.0), _Y, _X, 1.0),
            route.Body(GUIDE, "passed", (0.0, 0.0, 0.0), _Z, _X, -float(np.mean(drum / parameters[GUIDE_RADIUS]))),
        ]
        turns = drum / parameters[route.INPUT_RADIUS]
        across = distance * float(np.cos(self._turn_rad(parameters[DISTANCE])))
        for i, (name, side) in enumerate(zip(self.input_names, self.input_side, strict=True)):
            own = [float(turns[j]) for j, of in enumerate(self.input_of) if of == i]
            body = route.Body(
                route.input_body(name),
                "input",
                (side * across, 0.0 - self.setback_m, 0.0),
                _Z,
                _X,
                sum(own) / len(own) if own else 1.0,
            )
            found.append(body)
        return tuple(found)

    def _cable(self, parameters: Mapping[str, Floats], j: int, span_m: float, wrap_rad: float) -> route.CableRoute:
        side, towards = self.input_side[self.input_of[j]], self.drum_side[j]
        r_i, r_g, r_o = (float(parameters[key][j]) for key in (route.INPUT_RADIUS, GUIDE_RADIUS, route.DRUM_RADIUS))
        sine = (r_g + r_i) / float(parameters[DISTANCE])
        cosine = float(np.sqrt(max(1.0 - sine**2, 0.0)))
        # The span seen along Z, before and after the rotation of the line of centres.
        plain = (-side * cosine, -side * towards * sine)
        turn = -side * float(self._turn_rad(parameters[DISTANCE]))
        along = (plain[0] * cos(turn) - plain[1] * sin(turn), plain[0] * sin(turn) + plain[1] * cos(turn), 0.0)
        name = self.input_names[self.input_of[j]]
        # A crossed span reverses the sense; the guide turns against the drum.
        return route.CableRoute(
            self.cable_names[j],
            name,
            self.sense[j],
            (
                route.Anchor(route.input_body(name)),
                route.Wrap(route.input_body(name), r_i, np.inf, r_o, towards, lead_m=self.lead_m),
                route.Span(span_m, along),
                route.Wrap(GUIDE, r_g, wrap_rad, r_o, -towards, passed=True),
                route.Span(0.0, (float(towards), 0.0, 0.0)),
                route.Wrap(DRUM, r_o, np.inf, r_g, towards),
                route.Terminal(DRUM),
            ),
        )


def routed(drive: BevelDrive, unit: float = _MM) -> route.RoutedDrive:
    """Routes of the cables of ``drive``, and the lengths that follow from its file; ``unit``: a mm, in m."""

    def column(attribute: str) -> Floats:
        return np.array([getattr(run, attribute) * unit for run in drive.cables], dtype=float)

    geometry = BevelGeometry(
        cable_names=tuple(run.name for run in drive.cables),
        input_names=tuple(drive.input_names),
        input_of=tuple(drive.input_names.index(run.input_name) for run in drive.cables),
        input_side=tuple(drive.input_sides),
        drum_side=tuple(run.drum_side for run in drive.cables),
        setback_m=drive.input_setback_mm * unit,
        lead_m=drive.helix_lead_mm * unit,
    )
    parameters = {
        route.INPUT_RADIUS: column("input_radius_mm"),
        GUIDE_RADIUS: column("guide_radius_mm"),
        route.DRUM_RADIUS: column("drum_radius_mm"),
        DISTANCE: np.asarray(drive.centre_distance_mm * unit),
    }
    return route.RoutedDrive(geometry, parameters, {"centre_distance_mm": drive.centre_distance_mm})


def longest_mm(drive: BevelDrive, cable: BevelRun, anchor_rad: float) -> float:
    """Length of a cable that leaves its land at ``anchor_rad``, by its pieces; slightly more than the drawn path."""
    w = winding(drive, cable)
    turns = tau * drive.dead_turns + w.reduction * radians(drive.half_travel_deg)
    helix = turns * hypot(cable.input_radius_mm, drive.helix_lead_mm / tau)
    # The bend inward to the stop and the straight end in the terminal: a quarter turn and three diameters each.
    ends = pi / 2 * cable.input_radius_mm + 6.0 * drive.cable.diameter_mm
    return helix + w.free_span_mm + cable.guide_radius_mm * w.guide_wrap_rad + cable.drum_radius_mm * anchor_rad + ends
