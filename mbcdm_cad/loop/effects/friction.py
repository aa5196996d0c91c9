"""Friction against the motion: one effect whose forms are sums of terms, the forms M1 to M6 of BAM among them.

With the speed w, the load M (N m at the drum) and e = exp(-(w/w_s)^2) a friction is

    c + v |w| + s e + k |M| + k_s |M| e + q M^2 e

at once after a reversal, or built up over a path of the output as P. R. Dahl has it. k may be one share for a load that
the drive moves against and another for one that moves the drive. Terms: M. Duclusaud, G. Passault, V. Padois, O. Ly,
Extended friction models for the physics simulation of servo actuators (arXiv 2410.08650): M1 has c and v, M2 s too, M3
c, v and k, M4 all but q, M5 two shares k, M6 all. There the two shares are of the motor's and of the load's torque; as
these differ by the friction alone, shares by the sense of power say the same.

The search ranks c alone; forms of one term more are tried in its place, see
:mod:`mbcdm_cad.loop.search.by_evidence`.
A friction of v alone is the viscous drag of ``delay``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from math import exp
from typing import TYPE_CHECKING

import numpy as np

from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.loop.effect import Effect, Figure, Parameter, Words
from mbcdm_cad.loop.effects import lash
from mbcdm_cad.loop.prepare.prepared import slid
from mbcdm_cad.loop.prepare.setup import DriveSI, Floats, Prepared, Setup, Simulator
from mbcdm_cad.loop.readable import readable

if TYPE_CHECKING:
    from mbcdm_cad.design.drive import Drive
    from mbcdm_cad.loop.result import LoopResult, Named

NAME, WOUND = "friction", "what is soft winds up"
# Terms in the order of their parameters. The speed at which a term fades comes last where one of FADING is there.
CONSTANT, VISCOUS, STRIBECK, LOAD, DRIVING, DRIVEN, SLOW_LOAD, SQUARE, BUILT_UP = range(9)
FADING = {STRIBECK, SLOW_LOAD, SQUARE}
Terms = tuple[int, ...]
# Names of BAM.
BAM = {
    (CONSTANT, VISCOUS): "M1",
    (CONSTANT, VISCOUS, STRIBECK): "M2",
    (CONSTANT, VISCOUS, LOAD): "M3",
    (CONSTANT, VISCOUS, STRIBECK, LOAD, SLOW_LOAD): "M4",
    (CONSTANT, VISCOUS, STRIBECK, DRIVING, DRIVEN, SLOW_LOAD): "M5",
    (CONSTANT, VISCOUS, STRIBECK, DRIVING, DRIVEN, SLOW_LOAD, SQUARE): "M6",
}
SPOKEN = {
    CONSTANT: "constant",
    VISCOUS: "viscous",
    STRIBECK: "Stribeck",
    LOAD: "in proportion to the load",
    DRIVING: "by the sense of power",
    SLOW_LOAD: "more of the load at a crawl",
    SQUARE: "square of the load at a crawl",
    BUILT_UP: "built up over a path",
}
# The speed w_s, over the largest speed of the run: bounds, and where fits begin.
FADES, BEGINNINGS = (0.02, 1.0), (0.1, 0.35)
# The exponent of w/w_s, and others that real contacts have: the intervals hold what the figures would be with them.
EXPONENT, EXPONENTS = 2.0, (1.0, 3.0)
# The path over which a friction builds up after a reversal, over the travel: bounds, and where fits begin.
PATHS, FIRST_PATH = (2e-5, 0.05), 1e-3
BIAS = "a constant bias torque: friction keeps to the speed, lash and the cables to the torque"
TWO = "runs at two speeds that differ threefold and under two loads, one of them a weight that drives the drum one way"


def bases(
    terms: Terms,
    sense: Floats,
    speed_rad_s: Floats,
    load_Nm: Floats | None,
    fades_rad_s: float,
    exponent: float = EXPONENT,
) -> Floats:
    """What each term of a friction does against the motion for a coefficient of one, (terms, n)."""
    load = np.zeros_like(sense) if load_Nm is None else load_Nm
    slow = np.exp(-((np.abs(speed_rad_s) / fades_rad_s) ** exponent)) if FADING & {*terms} else np.zeros_like(sense)
    forward = 0.5 * (1.0 + np.tanh(4.0 * sense * load / max(float(np.abs(load).max()) * 0.1, 1e-12)))
    rows = {
        CONSTANT: np.ones_like(sense),
        VISCOUS: np.abs(speed_rad_s),
        STRIBECK: slow,
        LOAD: np.abs(load),
        DRIVING: np.abs(load) * forward,
        DRIVEN: np.abs(load) * (1.0 - forward),
        SLOW_LOAD: np.abs(load) * slow,
        SQUARE: load**2 * slow,
    }
    return np.stack([rows[term] * sense for term in terms])


@dataclass(frozen=True)
class FrictionPlace:
    """Where a friction sits: the names of its parameters and their sizes by term, its form, and how it changes a run.

    ``what`` begins the sentence for a person, ``where`` the place to look at.
    """

    form: str
    parameters: dict[int, tuple[str, float]]
    moved: Callable[[Setup, Floats], Setup]
    physics: str
    where: str
    plain: str
    what: str

    def applied(self, terms: Terms, exponent: float, setup: Setup, values: Floats, _: Simulator) -> Setup:
        """The run with a friction of these terms."""
        p, sizes = setup.p, sizes_of(terms)
        fades, sense = float(values[len(sizes)]) if FADING & {*terms} else 1.0, p.sense
        if BUILT_UP in terms:
            path = float(values[-1]) * setup.ratio
            sense = slid(p.common_rad, path)
            setup = replace(setup, p=p.building_up(path))
        own = bases(sizes, sense, p.speed_rad_s, p.load_Nm, fades, exponent)
        return self.moved(setup, values[: len(sizes)] @ own)


def sizes_of(terms: Terms) -> Terms:
    """The terms that have a size each."""
    return tuple(term for term in terms if term != BUILT_UP)


_TORQUES = {
    CONSTANT: ("torque_Nm", 0.01),
    VISCOUS: ("drag_Nm_s", 0.05),
    STRIBECK: ("stribeck_Nm", 0.01),
    LOAD: ("load_share", 0.01),
    DRIVING: ("driving_share", 0.01),
    DRIVEN: ("driven_share", 0.01),
    SLOW_LOAD: ("slow_load_share", 0.01),
    SQUARE: ("square_share", 0.01),
}
BEYOND = FrictionPlace(
    "bearing torque",
    _TORQUES,
    lambda s, torque_Nm: s.with_rubbed(torque_Nm),
    "a torque against the motion that the sensor does not see",
    "drum bearings and seals: turn the drum by hand with the cables off",
    "the bearings hold back {torque_Nm} that the torque sensor does not see",
    "against the motion, unseen by the torque sensor,",
)
BEFORE = FrictionPlace(
    "friction in the measured torque",
    _TORQUES,
    lambda s, torque_Nm: replace(s, load_Nm=s.load - torque_Nm),
    "the torque was taken before a friction, as from the motor's current: the drum bears less than it says",
    "friction of motor, gearhead and seals before the drum: current of the motor without a load",
    "the measured torque contains {torque_Nm} of friction that the drum does not bear",
    "in the measured torque, and not borne by the drum,",
)
SHIFT = FrictionPlace(
    "shift with the sense of motion",
    {
        CONSTANT: ("half_width_rad", 1e-5),
        STRIBECK: ("stribeck_rad", 1e-5),
        LOAD: ("half_width_rad_Nm", 1e-5),
        DRIVING: ("driving_rad_Nm", 1e-5),
        DRIVEN: ("driven_rad_Nm", 1e-5),
    },
    lambda s, angle_rad: s.with_added(-angle_rad),
    "friction behind a stiffness that is not known",
    "bearings and seals between input and output",
    "friction holds the output back by {half_width_rad} in both directions",
    "the output is held back, against the motion,",
)
_CLAUSES = {
    CONSTANT: "{%s}",
    VISCOUS: "{%s} times the speed",
    STRIBECK: "{%s} more at a crawl, gone well above {fades_rad_s}",
    LOAD: "{%s} of the load",
    DRIVING: "{%s} of a load that it moves against",
    DRIVEN: "{%s} of a load that moves it",
    SLOW_LOAD: "{%s} more of the load at a crawl",
    SQUARE: "{%s} of the load at a crawl and 1 N m, in proportion to it",
}


def form_name(place: FrictionPlace, terms: Terms) -> str:
    """The form's name: the place, its terms, and BAM's name where it has one."""
    if terms == (CONSTANT,):
        return place.form
    words = ", ".join(SPOKEN[term] for term in terms if term != DRIVEN)
    return f"{place.form}: {words}" + (f" (BAM {BAM[sizes_of(terms)]})" if sizes_of(terms) in BAM else "")


def all_terms(place: FrictionPlace, loaded: bool) -> list[Terms]:
    """Every sum of terms that is a form, fewest terms first; without those of the load where none was measured."""
    found = []
    fades = [(), (STRIBECK,), (STRIBECK, SLOW_LOAD), (STRIBECK, SLOW_LOAD, SQUARE)]
    loads: list[Terms] = [(), (LOAD,), (DRIVING, DRIVEN)]
    for constant, viscous, load, slow in product([(), (CONSTANT,)], [(), (VISCOUS,)], loads, fades):
        alone = (not constant and (slow or not load)) or (SLOW_LOAD in slow and not load)
        terms = tuple(sorted((*constant, *viscous, *load, *slow)))
        if not alone and {*terms} <= {*place.parameters} and (loaded or not load):
            found += [terms, (*terms, BUILT_UP)]
    return sorted(found, key=len)


def friction(place: FrictionPlace, terms: Terms, p: Prepared, exponent: float = EXPONENT) -> Effect:
    """A friction of these terms at a place."""
    sizes, travel = sizes_of(terms), float(np.ptp(p.output_rad))
    parameters = [Parameter(name, size, 0.0) for name, size in (place.parameters[term] for term in sizes)]
    parts = p.run.parts
    if parts is not None and parts.friction_Nm and place is BEYOND and terms[0] == CONSTANT:
        # The prediction counts the design's losses, and less than these may rub.
        parameters[0] = replace(parameters[0], low=-parts.friction_Nm)
    most = float(np.quantile(np.abs(p.speed_rad_s), 0.99))
    clauses = [_CLAUSES[term] % place.parameters[term][0] for term in sizes]
    begun = [[0.0] * len(sizes)]
    if FADING & {*terms}:
        parameters.append(Parameter("fades_rad_s", 0.05 * most, FADES[0] * most, FADES[1] * most, role="place"))
        begun = [[*start, share * most] for start in begun for share in BEGINNINGS]
    if BUILT_UP in terms:
        low, high = (share * travel for share in PATHS)
        parameters.append(Parameter("built_up_rad", 2e-4 * travel, low, high, role="place"))
        begun = [[*start, FIRST_PATH * travel] for start in begun]
    more, loaded = terms != (CONSTANT,), p.load_Nm is not None and bool(p.load_Nm.any())
    built = ", built up over {built_up_rad} after each reversal" if BUILT_UP in terms else ""
    return Effect(
        NAME,
        form_name(place, terms),
        place.physics,
        place.where,
        TWO if more else BIAS,
        tuple(parameters),
        partial(place.applied, terms, exponent),
        starts=lambda setup, residual: begun,
        hangs_on="speed" if {*terms} & {VISCOUS, *FADING} else "",
        plain=f"{place.what} there are {_listed(clauses)}" + built if more else place.plain,
        richer=None if more else lambda: [friction(place, one, p) for one in all_terms(place, loaded)],
        shapes=(lambda: [friction(place, terms, p, one) for one in EXPONENTS]) if FADING & {*terms} else None,
        figures=tuple(
            Figure(q.name, lambda v, k=k: float(v[k]), _MEANINGS.get(q.name, ""))  # type: ignore[misc]
            for k, q in enumerate(parameters)
        ),
    )


_MEANINGS = {
    "built_up_rad": "path of the output after a reversal over which 63 % of the change are there",
    "fades_rad_s": "speed of the output at which a third of the Stribeck part is left",
    "square_share": "share of the load at 1 N m, near standstill",
}


def _listed(words: list[str]) -> str:
    return words[0] if len(words) == 1 else ", ".join(words[:-1]) + " and " + words[-1]


def _wound_up(shift: Effect) -> Effect:
    """The same friction behind what is soft, which winds up and unwinds: as a play that motion takes up."""
    return replace(
        shift,
        form=WOUND,
        physics="friction holds the output until what is soft has wound up; half width over compliance is its torque",
        where_to_look="bearings and seals at the output, and what is soft before them",
        apply=lambda s, v, simulator: lash.by_motion(s, 2.0 * v, simulator),
        starts=lambda s, residual: [[0.5 * size for size in start] for start in lash.width(s, residual)],
        plain="friction holds the output back by {half_width_rad}, until what is soft has wound up",
        richer=None,
    )


def offer(d: DriveSI | None, p: Prepared) -> list[Effect]:
    """Through the cables' stiffness where it is known, else as a shift with the sense of motion.

    Without a torque column a friction is no more than a torque that was not measured.
    """
    if d is None:
        shift = friction(SHIFT, (CONSTANT,), p)
        # Under a load a play rests on one flank, so that an output which stays behind the motion may be wound up.
        return [shift, _wound_up(shift)] if p.load_Nm is not None and p.load_Nm.any() else [shift]
    if p.load_Nm is None:
        return [
            Effect(
                NAME,
                "torque that was not measured",
                "a load or a friction against the motion, through the cables",
                "brake, bearings and seals of the drum",
                "log the load's torque, or run without a load",
                (Parameter("torque_Nm", 0.05, 0.0),),
                lambda s, v, _: replace(s, load_Nm=v[0] * s.p.sense),
                unmeasured=True,
                plain="{torque_Nm} against the motion, which no sensor measured, would explain the error",
            )
        ]
    bearing, inside = friction(BEYOND, (CONSTANT,), p), friction(BEFORE, (CONSTANT,), p)
    expected = p.run.parts.friction_Nm if p.run.parts is not None else 0.0
    if expected:
        bearing = replace(
            bearing,
            physics="a torque against the motion besides the losses that the design states",
            plain="cables and bearings hold back {torque_Nm} more than the design's losses",
            reversed_words=Words(
                "cables and bearings rub less than the design's losses say",
                "lubrication and run-in of cables and bearings",
                "cables and bearings hold back less than the design's losses, by {torque_Nm}",
            ),
        )
    return [bearing, inside]


def beside_design(result: LoopResult, drive: Drive) -> LoopResult:
    """The result with the figure of the design's losses beside each friction that was found through the cables."""
    if all(one.name != NAME for one in (*result.effects, *(one for group in result.one_of for one in group))):
        return result
    from mbcdm_cad.layouts.lumped import axis_friction  # loads the layouts' losses: only where a friction was found
    from mbcdm_cad.measurement.loads import drum_friction_Nm

    expected, sigma = drum_friction_Nm(drive)
    spread = exp(sigma / expected) if expected else 1.0
    turns = [abs(body.turns_per_drum) for body in layout_of(drive).routed.routes.inputs]
    before = expected + sum(n * own for n, own in zip(turns, axis_friction(drive).inputs_Nm, strict=True))

    def beside(named: Named) -> Named:
        of = {BEYOND.form: expected, BEFORE.form: before}.get(named.form.split(":")[0])
        if named.name != NAME or not of:
            return named
        _, (middle, low, high) = readable("_Nm", [of, of / spread, of * spread])
        words = f"{named.physics}; the design's losses are {middle} there ({low} to {high} is one standard deviation)"
        return replace(named, physics=words, physical={**named.physical, "design_torque_Nm": of})

    sets = tuple(tuple(map(beside, group)) for group in result.one_of)
    return replace(result, effects=tuple(map(beside, result.effects)), one_of=sets)
