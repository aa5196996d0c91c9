"""A change during the run: a figure of the drive that is another one from some time on, or that drifts.

Before and after the change the cables are simulated over the whole run, and the reading goes from one to the other. So
the friction's memory is that of the new figure from the start, which holds from the first half sweep after the change.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from mbcdm_cad.loop.effect import Effect, Figure, Parameter, best_step, elapsed_s
from mbcdm_cad.loop.effects import cable_state, friction, lash, ratio_error, stiffness_error
from mbcdm_cad.loop.effects.slip_step import step
from mbcdm_cad.loop.prepare.setup import Floats, Prepared, Setup, Simulator
from mbcdm_cad.model.si import DriveSI, ModelError

NAME = "change"
AT_ONCE, EVENLY = "at once", "evenly"
# Forms that may change, each with what it is a figure of, and the place to look at.
CHANGEABLE = {
    "modulus of the rope": ("the rope's stiffness", "strands and terminals of the ropes: a strand may have broken"),
    "compliance in series": ("the twist between drum and torque sensor", "screws of hub, coupling and output shaft"),
    "all cables": ("the tension of all cables", "tensioners and anchors: a rope may have slipped or settled"),
    "rope on pulley": ("the friction between rope and pulleys", "dirt, oil or wear on the wraps"),
    "bearing torque": ("the friction of the bearings", "bearings and seals of the drum"),
    "shift with the sense of motion": (
        "the shift with the sense of motion",
        "bearings and seals between input and output",
    ),
    "pitch radius or encoder scale": (
        "the ratio of output to inputs",
        "counters and couplings of the encoders: lost counts, a slipped clamp",
    ),
    "play at the output": ("the play between drum and load", "coupling and key between drum and load"),
    "play taken up by motion": ("the play between input and output", "gears and couplings between input and output"),
}
Weight = Callable[[Setup, Floats], Floats]


def _applied(base: Effect, weight: Weight, setup: Setup, values: Floats, simulate: Simulator) -> Setup:
    """The reading with ``values[0]`` of the first figure of ``base`` in proportion to ``weight``."""
    if values[0] == 0.0:
        return setup
    # A play has no sign: less of it than before is the opposite of more.
    sign = float(np.sign(values[0])) if base.name == "lash" else 1.0
    rest = [p.default or 0.0 for p in base.parameters[1:]]
    full = np.array([sign * values[0], *rest])
    turned = simulate.turned_by((base, full.tobytes()), setup, lambda: base.apply(setup, full, simulate))
    return setup.with_added(sign * weight(setup, values) * turned)


class _Times:
    """First guesses of the time of a step; the effect's own signature is computed once for each run."""

    def __init__(self, base: Effect) -> None:
        self.base = base
        self._known: list[tuple[Setup, Floats | None]] = []

    def __call__(self, setup: Setup, residual: Floats) -> list[list[float]]:
        shape = self._shape(setup)
        used = np.flatnonzero(setup.p.used)
        if shape is None or not used.size or not np.ptp(shape[used]):
            return []
        return [[0.0, best_step(elapsed_s(setup)[used], residual[used], shape[used])]]

    def _shape(self, setup: Setup) -> Floats | None:
        """What the whole run does under a small size of the effect, rad (n,); None if it cannot be simulated."""
        for known, shape in self._known:
            if known is setup:
                return shape
        values = np.array([self.base.parameters[0].size, *(p.default or 0.0 for p in self.base.parameters[1:])])
        found: Floats | None = None
        try:
            simulate = Simulator()
            found = simulate(self.base.apply(setup, values, simulate)) - simulate(setup)
        except ModelError:
            pass
        self._known.append((setup, found))
        return found


def changed(base: Effect, duration_s: float) -> list[Effect]:
    """A step and an even drift of the first figure of an effect."""
    size = replace(base.parameters[0], low=-np.inf if base.parameters[0].low == 0.0 else base.parameters[0].low)
    what, where_to_look = CHANGEABLE[base.form]
    other = f"{{{size.name}}} {{way_{size.name}}}"
    common = Effect(
        NAME,
        AT_ONCE,
        f"{what} is another one from some time on",
        where_to_look,
        "run again: a change that stays is then there from the start",
        (size, Parameter("at_s", 0.02, 0.0, duration_s, role="place")),
        partial(_applied, base, lambda s, v: step(s, float(v[1]))),
        stage=base.name,
        starts=_Times(base),
        figures=(Figure(size.name, lambda v: float(v[0])), Figure("at_s", lambda v: float(v[1]))),
        hangs_on="time",
        once=True,
        last=True,
        base=base,
        later=partial(_applied, base, lambda s, v: np.ones_like(s.p.time_s)),
        plain=f"from {{at_s}} on {what} is {other} than before",
    )
    drift = replace(
        common,
        form=EVENLY,
        physics=f"{what} becomes another one in the course of the run",
        parameters=(size,),
        apply=partial(_applied, base, lambda s, v: elapsed_s(s) / elapsed_s(s)[-1]),
        starts=None,
        figures=(Figure(size.name, lambda v: float(v[0]), "from the beginning of the run to its end"),),
        once=False,
        plain=f"at the end of the run {what} is {other} than at its beginning",
    )
    return [common, drift]


def offer(d: DriveSI | None, p: Prepared) -> list[Effect]:
    """For the figures of ``CHANGEABLE`` that the run can show."""
    if p.few:
        return []
    duration = float(p.time_s[-1] - p.time_s[0])
    files = (stiffness_error, cable_state, friction, ratio_error, lash)
    bases = [effect for file in files for effect in file.offer(d, p) if effect.form in CHANGEABLE]
    return [effect for base in bases for effect in changed(base, duration)]
