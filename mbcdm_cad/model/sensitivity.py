"""Sensitivity of backlash and torque to the parameters, and their intervals where parameters have a sigma."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from string import ascii_lowercase
from typing import Any

import numpy as np

from mbcdm_cad.model.bulk import BulkFigures, analyse_many
from mbcdm_cad.model.capability import Requirements
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.parallel.forks import Crew
from mbcdm_cad.routes import Floats

# Parameters that may have a sigma besides the geometry's lengths, and the field of the drive or requirements of each.
PARAMETERS = ("friction_coefficient", "modulus_Pa", "area_m2", "load_Nm", "input_rating_Nm")
STEP_SIGMA = 0.1


@dataclass(frozen=True)
class Interval:
    """A figure, its 95 % interval by Monte Carlo, and the standard deviation by Monte Carlo and by linear theory."""

    value: float
    low: float
    high: float
    sigma: float
    linear_sigma: float


def figures_of(bulk: BulkFigures) -> dict[str, Floats]:
    """The figures of the whole drive that carry an interval, each (n,): rad and N m."""
    return {
        "turn_rad": np.abs(bulk.turn_rad[0]),
        "reversal_swing_rad": bulk.reversal_swing_rad,
        "peak_torque_plus_Nm": bulk.peak_torque_Nm[0],
        "peak_torque_minus_Nm": bulk.peak_torque_Nm[1],
    }


def by_cable(d: DriveSI) -> tuple[str, ...]:
    """Names of the parameters that are drawn for each cable independently."""
    return ("preload_N", *d.geometry.per_cable)


def parameters(d: DriveSI) -> tuple[str, ...]:
    """Names of all parameters of this drive that may have a sigma."""
    return (*by_cable(d), *PARAMETERS, *(v.name for v in d.geometry.varied))


def _all_figures(bulk: BulkFigures, cables: tuple[str, ...]) -> dict[str, Floats]:
    each = {f"backlash_{name}_rad": row for name, row in zip(cables, bulk.cable_backlash_rad, strict=True)}
    return each | figures_of(bulk)


def intervals(
    d: DriveSI,
    need: Requirements,
    sigma: Mapping[str, Any],
    draws: int = 20_000,
    seed: int = 0,
    workers: Crew | None = None,
) -> dict[str, Interval]:
    """Intervals of backlash and torque for one design whose parameters are normal with standard deviations ``sigma``.

    Keys of ``sigma`` are among :func:`parameters`, in their SI units; those :func:`by_cable` take one value or one
    for each cable, and are drawn for each cable independently. Impossible draws (no free span, friction not above zero)
    are left out. ``workers`` as in :func:`analyse_many`. Raises ``ModelError`` for an unknown name, a negative sigma,
    or if over 1 % of the draws are impossible.
    """
    sizes: dict[str, Floats] = {}
    known, own = parameters(d), by_cable(d)
    for name, given in sigma.items():
        if name not in known:
            raise ModelError(f"sigma of {name!r}: no such parameter; use one of {', '.join(known)}")
        # One row a cable where each is drawn on its own, else one row.
        sizes[name] = np.array(np.broadcast_to(given, (d.n_cables if name in own else 1,)), dtype=float)
        if not np.all(sizes[name] >= 0.0):
            raise ModelError(f"sigma of {name}: {np.min(sizes[name]):g} is below 0")
    rng = np.random.default_rng(seed)
    random = {k: size[:, None] * rng.standard_normal((size.size, draws)) for k, size in sizes.items()}
    drawn = analyse_many(*shifted(d, need, random, draws), workers)
    lost = 1.0 - float(np.mean(drawn.valid))
    if lost > 0.01:
        raise ModelError(
            f"{lost:.0%} of the draws have no free span or no friction (limit 1 %): the sigmas are too wide for a "
            "normal law; lower those of centre distance, radii or friction"
        )
    # Columns: nominal, then each parameter (of each cable) a small step up and a small step down.
    steps = [(k, row) for k, size in sizes.items() for row in range(size.size)]
    shift = {k: np.zeros((size.size, 1 + 2 * len(steps))) for k, size in sizes.items()}
    for at, (name, row) in enumerate(steps):
        step = STEP_SIGMA * sizes[name][row]
        shift[name][row, 1 + 2 * at], shift[name][row, 2 + 2 * at] = step, -step
    around = _all_figures(analyse_many(*shifted(d, need, shift, 1 + 2 * len(steps))), d.cable_names)
    found = {}
    for name, values in _all_figures(drawn, d.cable_names).items():
        values = values[drawn.valid]
        low, high = np.quantile(values, [0.025, 0.975])
        slopes = (around[name][1::2] - around[name][2::2]) / (2 * STEP_SIGMA)
        found[name] = Interval(
            float(around[name][0]), float(low), float(high), float(values.std()), float(np.sqrt((slopes**2).sum()))
        )
    return found


def shifted(d: DriveSI, need: Requirements, shift: Mapping[str, Floats], n: int) -> tuple[DriveSI, Requirements]:
    """``n`` designs from one: ``shift`` has the changes of parameters by name, (n_cables, n) or (1, n)."""
    fields, asked = {}, {}
    own = by_cable(d)
    for name, change in shift.items():
        if name in own:
            fields[name] = d.value(name)[:, None] + change
        elif hasattr(need, name):
            asked[name] = np.asarray(getattr(need, name)) + change[0]
        else:
            fields[name] = d.value(name) + change[0]
    return d.spread(n).with_(**fields), Requirements(**(vars(need) | asked))


# The ranges of Fig. 5 are not legible in the paper's text; these are chosen around the case study.
PRELOAD_RANGE_N = (30.0, 120.0)
PANELS = (
    ("load_Nm", "external torque", "N m", 1.0, (0.3, 0.6, 0.91, 1.5, 3.0)),
    ("friction_coefficient", "friction coefficient", "-", 1.0, (0.05, 0.1, 0.15, 0.3, 0.5)),
    ("modulus_Pa", "tensile modulus", "GPa", 1e-9, (30e9, 45e9, 54e9, 75e9, 100e9)),
)
GLOBAL_RANGES = {
    "preload_N": (50.0, 90.0),
    "load_Nm": (0.5, 1.5),
    "friction_coefficient": (0.10, 0.20),
    "modulus_Pa": (45e9, 65e9),
}
INPUT_RATING_RANGE_NM = (0.15, 0.25)
ELASTICITY_STEP = 1e-4
# The paper's case, and the range around it in Fig. 5.
_PAPER_PRELOAD_N = (70.0, *PRELOAD_RANGE_N)
_PAPER_LOAD_NM = (0.91, 0.3, 3.0)


@dataclass(frozen=True, eq=False)
class Panel:
    """One panel of Fig. 5, named by a letter from "a" on.

    Backlash (rad, (k, n)) over preload (N, (n,)) for k values of one parameter, in ``unit``.
    """

    letter: str
    parameter: str
    unit: str
    preload_N: Floats
    value: Floats
    backlash_rad: Floats

    def rows(self) -> list[list[float]]:
        """Preload in N, then the backlash in mrad for each value: the lines of the CSV file."""
        return [
            [float(t), *map(float, column * 1e3)] for t, column in zip(self.preload_N, self.backlash_rad.T, strict=True)
        ]

    def header(self) -> list[str]:
        """Column names of :meth:`rows`, with units."""
        unit = "" if self.unit == "-" else f" {self.unit}"
        return ["preload_N", *(f"backlash_mrad at {self.parameter} {v:g}{unit}" for v in self.value)]


def figure_5(d: DriveSI, load_Nm: float, points: int = 46) -> tuple[Panel, ...]:
    """The panels, by all cables at once on first loading; every other parameter as in ``d``.

    The last panels are over lengths of the whole design that the configuration names, in the paper the centre distance.
    If a drive's preload or load lies outside the paper's range, or it has no free span at one of the paper's distances,
    the range is scaled to its own value.
    """
    preload = np.linspace(*PRELOAD_RANGE_N, points) * _scale(float(np.mean(d.preload_N)), *_PAPER_PRELOAD_N)
    load_scale = _scale(load_Nm, *_PAPER_LOAD_NM)
    panels = []
    lengths = [(v.name, v.label, "mm", 1e3, _possible(d, v.name, v.values_m)) for v in d.geometry.varied]
    for letter, (name, label, unit, factor, values) in zip(ascii_lowercase, [*PANELS, *lengths], strict=False):
        lines = []
        if name == "load_Nm":
            values = tuple(value * load_scale for value in values)
        for value in values:
            one = d if name == "load_Nm" else d.with_(**{name: value})
            many = one.spread(points).with_(preload_N=np.broadcast_to(preload, (d.n_cables, points)))
            load = value if name == "load_Nm" else load_Nm
            lines.append(np.abs(solve_equilibrium(many, load).drum_angle_rad))
        panels.append(Panel(letter, label, unit, preload, np.array(values) * factor, np.array(lines)))
    return tuple(panels)


def _scale(own: float, paper: float, low: float, high: float) -> float:
    """1 if the drive's value lies in the paper's range, else its ratio to the paper's value."""
    return 1.0 if low <= own <= high else own / paper


def _possible(d: DriveSI, name: str, values_m: tuple[float, ...]) -> tuple[float, ...]:
    """The values; if the least leaves no free span, they are scaled so that the least is the design's own value."""
    least = min(values_m)
    try:
        _ = d.with_(**{name: least}).free_span_m
    except ModelError:
        own = float(d.value(name))
        return tuple(own * value / least for value in values_m)
    return values_m


def elasticities(d: DriveSI, need: Requirements) -> dict[str, dict[str, float]]:
    """d ln(figure)/d ln(parameter) by central differences, for each figure and parameter; ``preload_N`` all together.

    ``radii`` scales all radii together. By similarity, scaling tensions and EA together, or lengths and torques
    together, leaves the angles unchanged.
    """
    varied = (v.name for v in d.geometry.varied)
    names = ("preload_N", "load_Nm", "friction_coefficient", "modulus_Pa", *varied, "radii", "input_rating_Nm")
    answers = {}
    for name in names:
        ends = []
        for sign in (1.0, -1.0):
            factor = float(np.exp(sign * ELASTICITY_STEP))
            changed, asked = d, need
            if name == "radii":
                changed = d.with_(**{k: d.parameters[k] * factor for k in d.geometry.per_cable})
            elif hasattr(need, name):
                asked = replace(need, **{name: np.asarray(getattr(need, name)) * factor})
            else:
                changed = d.with_(**{name: d.value(name) * factor})
            ends.append(figures_of(analyse_many(changed.spread(1), asked)))
        answers[name] = {
            f: float((np.log(ends[0][f]) - np.log(ends[1][f]))[0] / (2 * ELASTICITY_STEP)) for f in ends[0]
        }
    return {figure: {name: answers[name][figure] for name in names} for figure in answers[names[0]]}


def global_ranges(d: DriveSI) -> dict[str, tuple[float, float]]:
    """Ranges for the global indices, SI: the model's, then the lengths that the configuration names."""
    lengths = {v.name: v.range_m for v in d.geometry.varied}
    return GLOBAL_RANGES | lengths | {"input_rating_Nm": INPUT_RATING_RANGE_NM}


@dataclass(frozen=True)
class GlobalIndices:
    """Sobol' indices: share of a figure's variance by a parameter alone (first), with interactions (total)."""

    parameter: tuple[str, ...]
    ranges: tuple[tuple[float, float], ...]
    first: dict[str, tuple[float, ...]]
    total: dict[str, tuple[float, ...]]


def global_indices(
    d: DriveSI,
    need: Requirements,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    n: int = 4096,
    seed: int = 0,
    workers: Crew | None = None,
) -> GlobalIndices:
    """Sobol' indices of backlash and torque over uniform ``ranges`` (SI; by default :func:`global_ranges`), by scipy.

    ``workers`` as in :func:`analyse_many`. Errors: ``ModelError`` for an empty or reversed range.
    """
    from scipy import stats  # takes a second to import

    chosen = dict(ranges or global_ranges(d))
    for name, (low, high) in chosen.items():
        if not low < high:
            raise ModelError(f"range of {name}: {low:g} to {high:g} is empty; give low < high")
    names = tuple(chosen)
    labels: list[str] = []

    def figures(x: Floats) -> Floats:
        asked, fields = need, {}
        for name, column in zip(names, x, strict=True):
            if hasattr(need, name):
                asked = replace(asked, **{name: column})
            else:
                fields[name] = np.broadcast_to(column, (d.n_cables, column.size)) if name == "preload_N" else column
        found = figures_of(analyse_many(d.spread(x.shape[1]).with_(**fields), asked, workers))
        labels[:] = list(found)
        return np.array(list(found.values()))

    laws = [stats.uniform(loc=low, scale=high - low) for low, high in chosen.values()]
    indices = stats.sobol_indices(func=figures, n=n, dists=laws, rng=np.random.default_rng(seed))
    return GlobalIndices(
        names,
        tuple((float(low), float(high)) for low, high in chosen.values()),
        {label: tuple(map(float, row)) for label, row in zip(labels, indices.first_order, strict=True)},
        {label: tuple(map(float, row)) for label, row in zip(labels, indices.total_order, strict=True)},
    )
