"""A change during the run: a figure of the drive that is another one from some time on, or that drifts.

Before and after the change the cables are simulated over the whole run, and the reading goes from one to the other. So
the friction's memory is that of the new figure from the start, which holds from the first half sweep after the change.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from mbcdm_cad.loop.effect import Effect, Figure, Parameter, elapsed_s
from mbcdm_cad.loop.effects import cable_state, lash, ratio_error, speed, stiffness_error
from mbcdm_cad.loop.effects.slip_step import step
from mbcdm_cad.loop.prepare.prepared import Prepared
from mbcdm_cad.loop.prepare.setup import Setup, Simulator
from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.routes import Floats

NAME = "change"
AT_ONCE, EVENLY = "at once", "evenly"
# Forms that may change, each with the words for the place to look at.
CHANGEABLE = {
    "modulus of the rope": "strands and terminals of the ropes: a strand may have broken",
    "compliance in series": "screws of hub, coupling and output shaft",
    "all cables": "tensioners and anchors: a rope may have slipped or settled",
    "rope on pulley": "dirt, oil or wear on the wraps",
    "bearing torque": "bearings and seals of the drum",
    "shift with the sense of motion": "bearings and seals between input and output",
    "pitch radius or encoder scale": "counters and couplings of the encoders: lost counts, a slipped clamp",
    "play at the output": "coupling and key between drum and load",
    "play taken up by motion": "gears and couplings between input and output",
}
# Times that are tried as the start of a step, first over the whole run, then around the best.
COARSE_TIMES, FINE_TIMES, EDGE_SHARE = 60, 60, 0.04

Weight = Callable[[Setup, Floats], Floats]


def _at_once(setup: Setup, values: Floats) -> Floats:
    return step(setup, float(values[1]))


def _evenly(setup: Setup, values: Floats) -> Floats:
    passed = elapsed_s(setup)
    return np.asarray(passed / passed[-1])


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
        if shape is None or not np.ptp(shape[used]) or used.size < COARSE_TIMES:
            return []
        t, c, r = elapsed_s(setup)[used], shape[used], residual[used]
        low, high = (float(np.quantile(t, q)) for q in (EDGE_SHARE, 1.0 - EDGE_SHARE))
        apart = (high - low) / COARSE_TIMES
        at = _best_step(t, c, r, np.linspace(low, high, COARSE_TIMES))
        at = _best_step(t, c, r, np.linspace(max(low, at - apart), min(high, at + apart), FINE_TIMES))
        return [[0.0, at]]

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


def _best_step(t: Floats, c: Floats, r: Floats, times: Floats) -> float:
    """The time after which ``c`` explains the residual best, beside a constant and ``c`` throughout."""
    sums = {k: np.concatenate([[0.0], np.cumsum(v)]) for k, v in {"c": c, "cc": c * c, "rc": r * c}.items()}
    whole = {k: float(v[-1]) for k, v in sums.items()}
    best, found = -np.inf, float(times[0])
    for time in times:
        k = int(np.searchsorted(t, time))
        after = {name: whole[name] - float(v[k]) for name, v in sums.items()}
        gram = np.array(
            [
                [t.size, whole["c"], after["c"]],
                [whole["c"], whole["cc"], after["cc"]],
                [after["c"], after["cc"], after["cc"]],
            ]
        )
        side = np.array([r.sum(), whole["rc"], after["rc"]])
        explained = float(side @ np.linalg.pinv(gram, rcond=1e-10, hermitian=True) @ side)
        if explained > best:
            best, found = explained, float(time)
    return found


def changed(base: Effect, duration_s: float) -> list[Effect]:
    """A step and an even drift of the first figure of an effect."""
    size = replace(base.parameters[0], low=-np.inf if base.parameters[0].low == 0.0 else base.parameters[0].low)
    common = Effect(
        NAME,
        AT_ONCE,
        f"{base.physics}: from some time on",
        CHANGEABLE[base.form],
        "run again: a change that stays is then there from the start",
        (size, Parameter("at_s", 0.02, 0.0, duration_s, role="place")),
        partial(_applied, base, _at_once),
        stage=base.name,
        starts=_Times(base),
        figures=(Figure(size.name, lambda v: float(v[0])), Figure("at_s", lambda v: float(v[1]))),
        hangs_on="time",
        once=True,
        last=True,
        base=base,
        plain=f"from {{at_s}} on, compared with before, {base.plain}",
    )
    drift = replace(
        common,
        form=EVENLY,
        physics=f"{base.physics}: more and more during the run",
        parameters=(size,),
        apply=partial(_applied, base, _evenly),
        starts=None,
        figures=(Figure(size.name, lambda v: float(v[0]), "from the beginning of the run to its end"),),
        once=False,
        plain=f"at the end of the run, compared with its beginning, {base.plain}",
    )
    return [common, drift]


def offer(d: DriveSI | None, p: Prepared) -> list[Effect]:
    """For the figures of ``CHANGEABLE`` that the run can show."""
    if p.few:
        return []
    duration = float(p.time_s[-1] - p.time_s[0])
    files = (stiffness_error, cable_state, speed, ratio_error, lash)
    bases = [effect for file in files for effect in file.offer(d, p) if effect.form in CHANGEABLE]
    return [effect for base in bases for effect in changed(base, duration)]
