"""How the cables run: input pulley, crossed free span, stepped guide, transfer point, drum (Fig. 1 d).

Origin: the apex, where drum axis (Y) and guide axis (Z) meet; input pulleys at x = -L and +L, axes parallel to Z. The
cable of step k changes from guide to drum at (0, r_gk, r_ok), along q x, q the side of the drum it runs to. The free
span is an internal tangent: seen along Z it leaves the line of centres by beta = asin((r_g + r_i)/L).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import cos, sin

import numpy as np

from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.geometry import DRUM_RADIUS, INPUT_RADIUS, AnchoredGeometry, RoutedDrive, Varied, tangent_length_m
from mbcdm_cad.routes.route import Anchor, Body, CableRoute, DriveRoutes, Span, Terminal, Wrap, input_body

GUIDE_RADIUS, DISTANCE = "guide_radius_m", "centre_distance_m"
DRUM, GUIDE = "drum", "guide"
_MM = 1e-3
_X, _Y, _Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class BevelGeometry(AnchoredGeometry):
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
    per_cable: tuple[str, ...] = (INPUT_RADIUS, GUIDE_RADIUS, DRUM_RADIUS)
    varied: tuple[Varied, ...] = (
        Varied(DISTANCE, "centre distance", (26e-3, 30e-3, 34.6e-3, 45e-3, 60e-3), (33e-3, 40e-3)),
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
        return tangent_length_m(parameters[DISTANCE], parameters[GUIDE_RADIUS] + parameters[INPUT_RADIUS])

    def passed_wrap_rad(self, parameters: Mapping[str, Floats]) -> tuple[Floats, ...]:
        """Wrap on the guide, rad: beta, or half a turn more; a setback lengthens the short wrap, shortens the long."""
        reach = (parameters[GUIDE_RADIUS] + parameters[INPUT_RADIUS]) / parameters[DISTANCE]
        with np.errstate(invalid="ignore"):
            long_way = self._long_way.reshape(-1, *(1,) * (reach.ndim - 1))
            turn = np.where(long_way > 0.0, -1.0, 1.0) * self._turn_rad(parameters[DISTANCE])
            return (np.asarray(np.arcsin(reach) + long_way + turn),)

    def fault(self, parameters: Mapping[str, Floats]) -> str:
        """Message for pulleys that overlap."""
        reach = parameters[GUIDE_RADIUS] + parameters[INPUT_RADIUS]
        return (
            f"free span: centre distance {np.min(parameters[DISTANCE]):.6g} m does not exceed r_g + r_i = "
            f"{np.max(reach):.6g} m, so the cable has no straight span; raise centre_distance_mm or cut the radii"
        )

    def routes(self, parameters: Mapping[str, Floats]) -> DriveRoutes:
        """Bodies and cables of one design. If pulleys overlap, its spans are NaN."""
        span, wrap = self.free_span_m(parameters), self.passed_wrap_rad(parameters)[0]
        cables = tuple(self._cable(parameters, j, float(span[j]), float(wrap[j])) for j in range(len(self.cable_names)))
        return DriveRoutes(self._bodies(parameters), cables)

    def _bodies(self, parameters: Mapping[str, Floats]) -> tuple[Body, ...]:
        drum, distance = parameters[DRUM_RADIUS], float(parameters[DISTANCE])
        found = [
            Body(DRUM, "drum", (0.0, 0.0, 0.0), _Y, _X, 1.0),
            Body(GUIDE, "passed", (0.0, 0.0, 0.0), _Z, _X, -float(np.mean(drum / parameters[GUIDE_RADIUS]))),
        ]
        turns = drum / parameters[INPUT_RADIUS]
        across = distance * float(np.cos(self._turn_rad(parameters[DISTANCE])))
        for i, (name, side) in enumerate(zip(self.input_names, self.input_side, strict=True)):
            own = [float(turns[j]) for j, of in enumerate(self.input_of) if of == i]
            body = Body(
                input_body(name),
                "input",
                (side * across, 0.0 - self.setback_m, 0.0),
                _Z,
                _X,
                sum(own) / len(own) if own else 1.0,
            )
            found.append(body)
        return tuple(found)

    def _cable(self, parameters: Mapping[str, Floats], j: int, span_m: float, wrap_rad: float) -> CableRoute:
        side, towards = self.input_side[self.input_of[j]], self.drum_side[j]
        r_i, r_g, r_o = (float(parameters[key][j]) for key in (INPUT_RADIUS, GUIDE_RADIUS, DRUM_RADIUS))
        sine = (r_g + r_i) / float(parameters[DISTANCE])
        cosine = float(np.sqrt(max(1.0 - sine**2, 0.0)))
        # The span seen along Z, before and after the rotation of the line of centres.
        plain = (-side * cosine, -side * towards * sine)
        turn = -side * float(self._turn_rad(parameters[DISTANCE]))
        along = (plain[0] * cos(turn) - plain[1] * sin(turn), plain[0] * sin(turn) + plain[1] * cos(turn), 0.0)
        name = self.input_names[self.input_of[j]]
        # A crossed span reverses the sense; the guide turns against the drum.
        return CableRoute(
            self.cable_names[j],
            name,
            self.sense[j],
            (
                Anchor(input_body(name)),
                Wrap(input_body(name), r_i, np.inf, r_o, towards, lead_m=self.lead_m),
                Span(span_m, along),
                Wrap(GUIDE, r_g, wrap_rad, r_o, -towards, passed=True),
                Span(0.0, (float(towards), 0.0, 0.0)),
                Wrap(DRUM, r_o, np.inf, r_g, towards),
                Terminal(DRUM),
            ),
        )


def routed(drive: BevelDrive, unit: float = _MM) -> RoutedDrive:
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
        INPUT_RADIUS: column("input_radius_mm"),
        GUIDE_RADIUS: column("guide_radius_mm"),
        DRUM_RADIUS: column("drum_radius_mm"),
        DISTANCE: np.asarray(drive.centre_distance_mm * unit),
    }
    return RoutedDrive(geometry, parameters, {"centre_distance_mm": drive.centre_distance_mm})
