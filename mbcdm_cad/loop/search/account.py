"""What the result reports of a fit: errors on data held back, intervals, limits of the runs, next steps, traces."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.optimize import bisect

from mbcdm_cad.loop.effect import Effect, Figure
from mbcdm_cad.loop.prepare.prepared import Prepared, held_out
from mbcdm_cad.loop.prepare.setup import order_spectrum
from mbcdm_cad.loop.readable import INTERVAL, Value, readable
from mbcdm_cad.loop.result import ONLY_RATIO, CandidateRow, Errors, Named, Noise, Traces, ways_apart
from mbcdm_cad.loop.search.evidence import LEAST_FALL, NoiseModel
from mbcdm_cad.loop.search.fit import Fit, Fitter
from mbcdm_cad.loop.search.unknown import Unknown, rms_value
from mbcdm_cad.measurement.run import TorqueClass
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.routes import Floats

TRACE_POINTS = 4000


def errors(fitter: Fitter, bare: Fit, fit: Fit, floor_rad: float) -> Errors:
    """Held-out error before and after; intervals from the scatter between held-out sweeps."""
    first, last = (float(np.abs(one.residual[fitter.test]).max()) for one in (bare, fit))
    before, after = (rms_value(one.residual[fitter.test], fitter.sweep[fitter.test]) for one in (bare, fit))
    return errors_of(before, after, first, last, floor_rad, held_out(fitter.runs))


def errors_of(before: Value, after: Value, first: float, last: float, floor_rad: float, held: str) -> Errors:
    """Errors before and after, RMS and the largest, with the share of what lies above the floor that went."""
    could, did = before.value**2 - floor_rad**2, before.value**2 - after.value**2
    share = float(np.clip(did / could, 0.0, 1.0)) if could > 0.0 else 1.0
    return Errors(before, after, first, last, floor_rad, share, held)


def interval(figure: Figure, values: Floats, covariance: Floats, effect: Effect) -> Value:
    """A figure's value and interval, by linear propagation with differences of the parameters' own sizes."""
    value = figure.of(values)
    slope = np.zeros(values.size)
    for i, parameter in enumerate(effect.parameters):
        step = 1e-3 * max(abs(float(values[i])), parameter.size)
        moved = values.copy()
        moved[i] += step
        slope[i] = (figure.of(moved) - value) / step
    half = INTERVAL * float(np.sqrt(max(0.0, float(slope @ covariance @ slope))))
    return Value(value, value - half, value + half)


def time_interval_s(fitter: Fitter, fit: Fit, effect: Effect, noise: NoiseModel) -> tuple[float, float]:
    """The earliest and the latest time of a change, 95 %, s from the beginning of its run.

    The prediction depends on the time only through the samples between two times, so its slope says nothing. The sum of
    squares is compared instead with the ``noise``, white and coloured.
    """
    k = fit.effects.index(effect)
    at = next(i for i, p in enumerate(effect.parameters) if p.role == "place")
    parameter, best = effect.parameters[at], float(fit.values[k][at])
    memory = 1.0 + 2.0 * noise.memory_s / min(p.step_s for p in fitter.runs)
    square = noise.white_rad**2 + memory * noise.coloured_rad**2
    used = fitter.used
    # Between two samples nothing tells one time from another.
    step = max(p.step_s for p in fitter.runs)
    least = float(np.sum(fit.residual[used] ** 2))

    def unlikely(time: float) -> float:
        """Above zero where the log-likelihood is below that at the ends of an interval."""
        values = [v.copy() for v in fit.values]
        values[k][at] = time
        moved = fitter.centred_on(used, fitter.output - fitter.predict(fit.effects, values, fit.offsets))
        return float(np.sum(moved**2)) - least - INTERVAL**2 * square

    def end(towards: float) -> float:
        return towards if unlikely(towards) <= 0.0 else float(bisect(unlikely, best, towards, xtol=step))

    return max(parameter.low, end(parameter.low) - step), min(parameter.high, end(parameter.high) + step)


def as_named(effect: Effect, values: Floats, block: Floats, fall_rad: float, run: str) -> Named:
    """An effect with its figures; ``block`` is the covariance of its values, ``run`` the data that alone has it."""
    figures = {figure.name: interval(figure, values, block, effect) for figure in effect.reported()}
    words, half = effect.words_of(values), INTERVAL * np.sqrt(np.maximum(np.diag(block), 0.0))
    return Named(
        effect.name,
        effect.form,
        effect.stage,
        effect.cables,
        figures,
        {figure.name: figure.of(values) for figure in effect.physical},
        (),
        words.where_to_look,
        effect.separate_by,
        words.physics,
        fall_rad,
        {p.name: float(v) for p, v in zip(effect.parameters, values, strict=True)},
        {figure.name: figure.meaning for figure in effect.reported() if figure.meaning},
        words.plain,
        run,
        half_widths=dict(zip([p.name for p in effect.parameters], half.tolist(), strict=True)),
    )


def not_testable(d: DriveSI | None, runs: Sequence[Prepared]) -> tuple[str, ...]:
    """What these runs cannot show."""
    words = []
    if all(p.load_Nm is not None and not p.load_Nm.any() for p in runs):
        words.append("no load: stiffness, preload, friction of the cables and winding history")
    if any(p.load_Nm is None for p in runs):
        words.append("no torque column: stiffness, preload, friction of the cables, lash and winding history")
    if d is None:
        words.append(ONLY_RATIO)
    if all(p.few for p in runs):
        words.append("too few half sweeps: none can be held back to judge a fit on the others")
    if all(p.temperature_C is None for p in runs):
        words.append("no temperature: warming and settling look alike")
    return tuple(words)


def next_steps(named: Sequence[Named], sets: Sequence[Sequence[Named]], unknown: Unknown | None) -> tuple[str, ...]:
    """What to look at, and what would separate the members of a set."""
    steps = [f"{one.words}: look at {one.where_to_look}" for one in named]
    for group in sets:
        ways = ways_apart(group)
        steps.append(f"to tell {' from '.join(one.words for one in group)}: {ways}")
    if unknown is not None:
        steps.append(f"something unknown: {unknown.repeat}")
    return tuple(steps)


def chain_orders(d: DriveSI | None, ratio: float) -> dict[str, float]:
    """Cycles a turn of the drum of everything that turns once."""
    orders = {"drum": 1.0, "input": ratio}
    if d is not None:
        orders |= {body.name: abs(body.turns_per_drum) for body in d.routes.passed}
    return orders


def traces(fitter: Fitter, bare: Fit, fit: Fit) -> tuple[Traces, ...]:
    """Signals for the page, thinned, and the order spectra before and after."""
    found = []
    for part, p in zip(fitter.parts, fitter.runs, strict=True):
        both = [one.residual[part] for one in (bare, fit)]
        (orders, before), (_, after) = (order_spectrum(p.output_rad[p.used], one[p.used]) for one in both)
        signals = (p.time_s, p.output_rad, p.load_Nm, *both, 1.0 * p.held, 1.0 * p.used)
        every = max(1, p.time_s.size // TRACE_POINTS)
        thinned: list[Any] = [None if one is None else one[::every] for one in signals]
        found.append(Traces(*[*thinned, orders, before, after]))
    return tuple(found)


def left_out(label: str, rms_rad: float, fall_rad2: float, floor_rad: float) -> CandidateRow:
    """A candidate that was not taken: it lowers the mean square too little, or something else does as much."""
    fall_rad = float(np.sqrt(max(0.0, fall_rad2)))
    why = "too small to name" if fall_rad < LEAST_FALL * floor_rad else "not likely enough"
    return CandidateRow(label, rms_rad, fall_rad, why)


def within_words(sizes: Sequence[tuple[Effect, float]], torque_class: TorqueClass) -> str:
    """Errors of the torque sensor within the class that allows them, and of the design's figures, for people."""
    own, others = list[str](), list[str]()
    for effect, size in sizes:
        name = effect.parameters[0].name
        is_part = effect.name in ("structure", "losses")  # figures of the design
        figure = f"{effect.name}_{name}" if is_part else f"{effect.name[5:]}_{name.rsplit('_', 1)[-1]}"
        word, shown = readable(figure, [size])
        (own if is_part else others).append(f"{word} {shown[0]}")
    sensor = f"errors of the {torque_class.what} within its class ({torque_class.words}): {', '.join(others)}"
    parts = f"figures of the design within their uncertainty: {', '.join(own)}"
    return " and ".join([*([sensor] if others else []), *([parts] if own else [])])


def stated(noise: NoiseModel, declared_rad: float) -> Noise:
    """The noise of a search as a result has it."""
    source = "white noise and AR(1) of most likelihood in what no cause does"
    return Noise(noise.floor_rad, noise.white_rad, noise.coloured_rad, noise.memory_s, declared_rad, source)
