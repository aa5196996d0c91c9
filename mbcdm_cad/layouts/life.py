"""Life of a design's cables: their zones, tensions and pulleys from the layout, and what helps most."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from math import degrees, radians

import numpy as np

from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.layouts.base import Layout, NoFigureError
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.rope_bendings import GROOVES, RopeKind
from mbcdm_cad.model.rope_zones import Level, RopeInUse, RopeLife, Tangent, rope_life
from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.model.tensioning import WIRES
from mbcdm_cad.parts.terminal import tensioned_rope
from mbcdm_cad.routes.curves import axial_walk_m, fleet_angle_rad
from mbcdm_cad.routes.route import CableRoute, DriveRoutes

# Drum angles at which the tensions are solved, over a move.
_ANGLES = 9
# Radii that are tried as larger ones.
LARGER = 1.25
# Construction with thinner wires than the usual one.
FINER = "7x19"
# A cable under a hundredth of its preload counts as slack, as in the check.
SLACK_SHARE = 0.01
# Speed of the rope for which its heat is told, and what still air takes from it (estimate: 20 W/(m2 K)).
HEAT_SPEED_M_S, HEAT_FILM_W_M2K = 0.1, 20.0


@dataclass(frozen=True)
class Help:
    """A change that makes the cables last longer, by a factor of N50; ``note``: what it costs or needs."""

    change: str
    factor: float
    note: str = ""


@dataclass(frozen=True, eq=False)
class Life:
    """Life of all cables of a design in a duty. ``duty``: in words."""

    ropes: tuple[RopeLife, ...]
    duty: str
    layout: Layout

    @cached_property
    def first(self) -> RopeLife | None:
        """The rope that breaks first; None where none has a figure."""
        known = [rope for rope in self.ropes if not rope.refused]
        return min(known, key=lambda rope: rope.cycles) if known else None

    @property
    def refused(self) -> str:
        """Why there is no figure; empty where one rope has one."""
        return "" if self.first is not None else self.ropes[0].refused

    @property
    def longer(self) -> bool:
        """Whether the ropes without a figure have none because they outlive the data, and no other has one."""
        return self.first is None and all(rope.longer for rope in self.ropes)

    @property
    def generic(self) -> bool:
        """Whether it follows from no test of the rope itself."""
        return self.layout.drive.cable.life_anchor is None

    @property
    def told(self) -> str:
        """What the figure is worth and what it was made for, in words."""
        first, anchor = self.first, self.layout.drive.cable.life_anchor
        if anchor is not None:
            return f"from the life_anchor's {anchor.count} ropes, {anchor.bendings:g} bendings; {self.duty}"
        rough = "only its order of magnitude, " if first is not None and first.rough else ""
        return f"generic figure, {rough}oiled rope (run dry a fifth) without corrosion; {self.duty}"

    @property
    def cycles_per_h(self) -> float | None:
        """Cycles an hour; None where the design file states no duty."""
        duty = self.layout.duty
        return duty.cycles_per_h if duty.stated and duty.cycles_per_h > 0.0 else None

    @property
    def wanted_cycles(self) -> float | None:
        """Cycles that the design file wants, by number or by hours of its duty; None where it wants none."""
        targets, per_h = self.layout.drive.targets, self.cycles_per_h
        if targets.life_h is None:
            return targets.life_cycles
        return 0.0 if per_h is None else targets.life_h * per_h

    @cached_property
    def governs(self) -> tuple[str, ...]:
        """What ends the life of a fibre rope of which no figure is known; empty for all others."""
        rope = self.layout.drive.cable
        if rope.construction in WIRES or rope.life_anchor is not None:
            return ()
        d, share = self.layout.losses.d, self.layout.losses.rope_share
        lost_W = float(np.max(share * d.preload_N)) * HEAT_SPEED_M_S
        area = np.pi * rope.diameter_mm * 1e-3 * float(np.max(d.free_span_m))
        return (
            "creep, after which the cables must be tensioned again (check retension)",
            "chafe on edges and in the turns that lie side by side",
            f"its own heat: at {HEAT_SPEED_M_S:g} m/s of rope its bends take {lost_W:.2g} W at the preload, some "
            f"{lost_W / (HEAT_FILM_W_M2K * area):.0f} K if a free span alone gives it to the air (estimate)",
        )

    @cached_property
    def helps(self) -> tuple[Help, ...]:
        """What helps most, the largest factor first; empty without a figure."""
        if self.first is None:
            return ()
        return tuple(sorted(_helps(self.layout, self.first), key=lambda help: -help.factor))


def life_of(layout: Layout) -> Life:
    """Cycles of the output until the cables break, worked out once.

    Raises ``NoFigureError`` where the cables have no tensions or no places.
    """
    return layout.once("life", _life)


def _life(layout: Layout) -> Life:
    si = layout.loads.si
    levels, words = _levels(layout, si)
    return Life(tuple(rope_life(rope, levels) for rope in ropes_in_use(layout, si)), words, layout)


def life_with(layout: Layout, si: DriveSI) -> float | None:
    """Median cycles of the cable that breaks first, with other preloads; None where one of them has no figure.

    A rope that outlives what the data show counts with what the formula gives.
    """
    levels, _ = _levels(layout, si)
    found = [rope_life(rope, levels) for rope in ropes_in_use(layout, si)]
    if any(rope.refused and not rope.longer for rope in found):
        return None
    return min(1.0 / float(rope.damage.max()) for rope in found)


def _levels(layout: Layout, si: DriveSI) -> tuple[tuple[Level, ...], str]:
    """The loads of a cycle, and the duty in words.

    A stated duty: its movements there and back about the centre, a cycle being one of them on average. Without one the
    test torque against the motion over the whole travel, to and fro, or the payload's weight where it is larger.
    """
    duty, half = layout.duty, layout.half_travel_rad
    if not duty.stated:
        torque, weight = layout.drive.loads.test_torque_Nm, layout.drive.loads.carried.weight_torque_Nm
        if weight > torque:
            words = (
                f"the payload's weight, {weight:.4g} N m, over the whole travel of +-{degrees(half):g} deg, to and fro"
            )
            return (_level(layout, si, half, weight, weight, 1.0),), words
        words = f"{torque:g} N m against the motion over the whole travel of +-{degrees(half):g} deg, to and fro"
        return (_level(layout, si, half, torque, -torque, 1.0),), words
    levels = tuple(
        _level(layout, si, radians(0.5 * s.range_deg), s.torque_Nm, s.torque_Nm, s.per_h / duty.cycles_per_h)
        for s in duty.strokes
    )
    return levels, f"loads.duty, {duty.cycles_per_h:.4g} movements there and back an hour"


def _level(layout: Layout, si: DriveSI, reach_rad: float, there_Nm: float, back_Nm: float, count: float) -> Level:
    """Tensions over a move about the centre, with the wraps that are left at each angle."""
    reach_rad = min(reach_rad, layout.half_travel_rad)
    angles = np.linspace(-reach_rad, reach_rad, _ANGLES)
    try:
        wraps = [np.stack(side, axis=1) for side in zip(*(layout.wraps_rad(float(a)) for a in angles), strict=True)]
        wound = si.spread(len(angles)).with_(input_wrap_rad=wraps[0], drum_wrap_rad=wraps[1])
        there, back = (solve_equilibrium(wound, load).tension_N for load in (there_Nm, back_Nm))
    except ModelError as error:
        raise NoFigureError(f"the model has no answer: {error}") from None
    return Level(angles, there, back, count)


def ropes_in_use(layout: Layout, si: DriveSI) -> Iterator[RopeInUse]:
    """Each rope with its tangent points; a cable that passes through its input is one rope with two sides."""
    spec, routes = layout.drive.cable, si.routes
    rope = RopeKind(spec.construction, spec.diameter_mm, spec.material, "oiled", spec.life_anchor)
    wound = layout.wraps_rad(0.0)[0]
    stiff = tensioned_rope(layout.drive).loose_N_m2
    ropes: dict[str, tuple[int, ...]] = {route.cable: (j,) for j, route in enumerate(routes.cables)}
    if si.through_sides:
        ropes = dict(zip(si.through_names, si.through_sides, strict=True))
    for name, sides in ropes.items():
        points: list[Tangent] = []
        for j, along in zip(sides, (1, -1), strict=False):
            points += _tangents(layout, routes, j, float(wound[j]), along, len(points))
        yield RopeInUse(name, rope, spec.breaking_load_N, stiff, tuple(points))


def _tangents(
    layout: Layout, routes: DriveRoutes, index: int, wound_rad: float, along: int, first: int
) -> Iterator[Tangent]:
    """Tangent points of one cable from its input on; ``first``: the number of the first one in its rope."""
    route = routes.cables[index]
    spoken = {body.name: f"{name} input" for body, name in zip(routes.inputs, layout.drive.input_names, strict=True)}
    place, moves, fleet = route.input_radius_m * wound_rad, route.sense * route.drum_radius_m, _fleet_deg(route)
    number = first
    for at in route.contacts():
        body, groove = routes.body(at.wrap.body), layout.groove_ratio(at.wrap.body)
        for direction, before in ((at.arriving, True), (at.leaving, False)):
            if direction is None:
                if before:
                    continue
                break
            normal = at.wrap.turning * np.cross(body.axis, direction)
            yield Tangent(
                cable=index,
                body=spoken.get(at.wrap.body, at.wrap.body),
                radius_m=at.wrap.radius_m,
                place_m=along * place,
                moves_m=along * moves,
                normal=(float(normal[0]), float(normal[1]), float(normal[2])),
                spans_to=number - 1 if before else number + 1,
                groove=groove,
                fleet_deg_per_rad=fleet if at.wrap is route.wraps[0] or at.wrap is route.wraps[1] else 0.0,
            )
            number += 1
            if before and at.leaving is not None:
                place += at.wrap.radius_m * at.wrap.angle_rad
            elif not before:
                place += route.spans[route.wraps.index(at.wrap)].length_m


def _fleet_deg(route: CableRoute) -> float:
    """Fleet angle of the first span for a rad of the drum, deg: the walk of its helix on the input over its length.

    None where the cable walks as far along the drum, on a helix of the same slope.
    """
    first, last, span = route.wraps[0], route.wraps[-1], route.spans[0].length_m
    if span == 0.0 or first.lead_m == 0.0:
        return 0.0
    walk = axial_walk_m(route.drum_radius_m / first.radius_m, first.lead_m) - axial_walk_m(1.0, last.lead_m)
    return degrees(float(fleet_angle_rad(walk, span)))


def _helps(layout: Layout, first: RopeLife) -> Iterator[Help]:
    """Each change tried on the design: the first rope's N50 over what it was."""
    si, pulley = layout.loads.si, first.pulleys[0]
    rope = next(r for r in ropes_in_use(layout, si) if r.name == first.name)
    levels, _ = _levels(layout, si)

    def tried(change: str, changed: RopeInUse, at: tuple[Level, ...] = levels, note: str = "") -> Iterator[Help]:
        found = rope_life(changed, at)
        if not found.refused or found.longer:
            notes = [note, "beyond what the data show" if found.longer else ""]
            yield Help(change, float(first.damage.max() / found.damage.max()), "; ".join(n for n in notes if n))

    def on_pulley(change: Callable[[Tangent], Tangent]) -> RopeInUse:
        return replace(rope, tangents=tuple(change(t) if t.body == pulley.body else t for t in rope.tangents))

    finer = _finer(rope)
    if finer is not None:
        yield from tried(f"{FINER} rope of the same diameter", finer)
    if not rope.rope.fibre and pulley.groove is None:
        yield from tried(
            f"a groove of {GROOVES[0]} d on the {pulley.body}", on_pulley(lambda t: replace(t, groove=GROOVES[0]))
        )
    larger = on_pulley(lambda t: replace(t, radius_m=LARGER * t.radius_m))
    yield from tried(f"the {pulley.body} {LARGER:g} times as large", larger, note="at the same tensions")
    half = si.with_(preload_N=0.5 * si.preload_N)
    try:
        peak = layout.drive.loads.peak_torque_Nm
        slack = bool(
            (solve_equilibrium(half, np.array([peak, -peak])).tension_N < SLACK_SHARE * half.preload_N[:, None]).any()
        )
        less, _ = _levels(layout, half)
    except (ModelError, NoFigureError):
        return
    yield from tried("half the preload", rope, less, "a cable then goes slack at the peak torque" if slack else "")


def _finer(rope: RopeInUse) -> RopeInUse | None:
    """The catalogue's rope of the same diameter with thinner wires; None if there is none or it has them."""
    if rope.rope.fibre or rope.rope.anchor is not None or rope.rope.over_wire >= WIRES[FINER][1]:
        return None
    same = [
        float(entry["breaking_load_N"])
        for entry in package_entries("ropes").values()
        if entry["construction"] == FINER and abs(entry["diameter_mm"] - rope.rope.diameter_mm) < 1e-6
    ]
    return replace(rope, rope=replace(rope.rope, construction=FINER), breaking_N=same[0]) if same else None
