"""Figures of many designs at once, by the same formulas as for one design: about 1e5 designs a second.

Nothing here is approximate: every figure equals that of :func:`mbcdm_cad.model.analyse` for that design to rounding.

The preload table gives torque capability and backlash as functions of the preload that can be reached. A terminal at
the end of its thread, or a rope that must not be pulled so far, leaves less preload than the design states; the table
shows the effect. All preloads are lowered by the same share.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from mbcdm_cad.model.capability import Modelled, Requirements, requirements, slip_weight, torque_at_slack_Nm
from mbcdm_cad.model.equations import eq1_residuals
from mbcdm_cad.model.equilibrium import Equilibrium, solve_equilibrium, solve_weighted
from mbcdm_cad.model.si import PER_CABLE, PER_DESIGN, DriveSI, ModelError
from mbcdm_cad.model.stiffness import cable_backlash, drum_backlash
from mbcdm_cad.model.wrap import slip_angle_rad
from mbcdm_cad.parallel.forks import Crew
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.curves import axial_walk_m, fleet_angle_rad

# Designs worked on at a time: their arrays then stay in the processor's cache.
BLOCK = 4096


@dataclass(frozen=True, eq=False)
class BulkFigures:
    """Figures of n designs. ``valid`` is False, and every other figure NaN, where there is no free span.

    Shapes: (n,), (n_cables, n), or (2, n) for a load of either sign, + (opposing positive rotation) first.
    ``drum_wrap_needed_rad`` is the wrap at the middle of the travel that still holds the slip zone of the test load at
    its end; ``input_wrap_needed_rad`` what an input winds over the whole travel. ``fleet_angle_rad`` is that at the end
    of travel: the helix's advance over the free span; ``passed_wrap_rad`` the wrap on all passed bodies together.
    """

    valid: Any
    eq1_residual: Floats
    bend_ratio: Floats
    free_span_m: Floats
    passed_wrap_rad: Floats
    fleet_angle_rad: Floats
    input_wrap_needed_rad: Floats
    drum_wrap_needed_rad: Floats
    cable_backlash_rad: Floats
    turn_rad: Floats
    reversal_swing_rad: Floats
    highest_tension_N: Floats
    lowest_tension_N: Floats
    peak_torque_Nm: Floats


def stack_designs(designs: list[DriveSI]) -> DriveSI:
    """One batch from single designs. Errors: ``ModelError`` if there are none, or cables run from different inputs."""
    if not designs:
        raise ModelError("no designs to stack; give at least one")
    first = designs[0]
    for other in designs[1:]:
        if other.geometry != first.geometry:
            raise ModelError(
                "designs differ in which input a cable runs from or which way it turns; stack them by kind"
            )
    lengths = {name: np.stack([d.parameters[name] for d in designs], axis=-1) for name in first.parameters}
    passed = zip(*(d.passed_wrap_rad for d in designs), strict=True)
    return first.with_(
        **lengths,
        **{name: np.stack([getattr(d, name) for d in designs], axis=-1) for name in PER_CABLE + PER_DESIGN},
        passed_wrap_rad=[np.stack(wraps, axis=-1) for wraps in passed],
    )


def analyse_many(d: DriveSI, need: Requirements, workers: Crew | None = None) -> BulkFigures:
    """Figures of a batch: per-cable arrays of ``d`` are (n_cables, n) or (n_cables, 1), the others (n,) or scalar.

    ``workers`` that call :func:`block_figures` share the blocks; the figures are the same on any number of them.
    """
    if len(d.batch_shape) != 1:
        raise ModelError(f"the batch has shape {d.batch_shape}; give one axis of designs")
    n = d.batch_shape[0]
    wide = d.spread(n)
    asked = Requirements(*(np.broadcast_to(np.asarray(getattr(need, f.name), float), (n,)) for f in fields(need)))
    spans = wide.geometry.free_span_m(wide.parameters)
    valid = ~np.isnan(spans).any(axis=0) & (wide.friction_coefficient > 0.0)
    asked_blocks = []
    for start in range(0, n, BLOCK):
        here = slice(start, min(start + BLOCK, n))
        good = valid[here]
        part, want = _taken(wide, here), Requirements(*(getattr(asked, f.name)[here] for f in fields(asked)))
        asked_blocks.append((part, want, good))
    blocks = list(map(block_figures, asked_blocks) if workers is None else workers.results(asked_blocks))
    return BulkFigures(*(np.concatenate([getattr(b, f.name) for b in blocks], axis=-1) for f in fields(BulkFigures)))


def block_figures(asked: tuple[DriveSI, Requirements, Any]) -> BulkFigures:
    """Figures of one block of designs, what is asked of each, and which of them have a free span."""
    d, need, good = asked
    if good.all():
        return _block(d, need, good)
    full = _missing(d, good)
    if good.any():
        want = Requirements(*(getattr(need, f.name)[good] for f in fields(need)))
        some = _block(_taken(d, good), want, good[good])
        for f in fields(BulkFigures):
            getattr(full, f.name)[..., good] = getattr(some, f.name)
    return full


def merged(parts: Sequence[tuple[Sequence[int], BulkFigures]], n: int) -> BulkFigures:
    """Figures of parts of a batch of n put together; each comes with its designs' places. NaN where there is none."""
    first, found = parts[0][1], []
    for f in fields(BulkFigures):
        value = getattr(first, f.name)
        whole = np.zeros(n, dtype=bool) if value.dtype == bool else np.full((*value.shape[:-1], n), np.nan)
        for places, figures in parts:
            whole[..., places] = getattr(figures, f.name)
        found.append(whole)
    return BulkFigures(*found)


def _taken(d: DriveSI, which: Any) -> DriveSI:
    def taken(value: Floats) -> Floats:
        return np.ascontiguousarray(value[..., which])

    return d.mapped(taken, taken)


def _missing(d: DriveSI, good: Any) -> BulkFigures:
    per_cable = (
        "free_span_m",
        "passed_wrap_rad",
        "fleet_angle_rad",
        "input_wrap_needed_rad",
        "drum_wrap_needed_rad",
        "cable_backlash_rad",
    )
    rows = dict.fromkeys(per_cable, (d.n_cables, good.size)) | dict.fromkeys(
        ("turn_rad", "peak_torque_Nm"), (2, good.size)
    )
    return BulkFigures(good & False, *(np.full(rows.get(f.name, good.size), np.nan) for f in fields(BulkFigures)[1:]))


def _block(d: DriveSI, need: Requirements, good: Any) -> BulkFigures:
    backlash = cable_backlash(d, need.load_Nm)
    drum = drum_backlash(d, need.load_Nm)
    other_way = solve_equilibrium(d, -need.load_Nm)
    tension = np.concatenate([drum.loaded.tension_N, other_way.tension_N])
    slip = np.maximum(
        slip_angle_rad(drum.loaded.tension_N, d.preload_N, d.friction_coefficient),
        slip_angle_rad(other_way.tension_N, d.preload_N, d.friction_coefficient),
    )
    smallest = np.minimum.reduce([d.input_radius_m, *d.passed_radii_m])
    return BulkFigures(
        valid=good,
        eq1_residual=eq1_residuals(d).by_design,
        bend_ratio=2.0 * smallest.min(axis=0) / need.rope_diameter_m,
        free_span_m=d.free_span_m,
        passed_wrap_rad=sum(d.geometry.passed_wrap_rad(d.parameters), np.zeros_like(d.free_span_m)),
        fleet_angle_rad=fleet_angle_rad(
            axial_walk_m(need.half_travel_rad * d.total_ratio, need.helix_lead_m), d.free_span_m
        ),
        input_wrap_needed_rad=2.0 * need.half_travel_rad * d.total_ratio,
        drum_wrap_needed_rad=need.half_travel_rad + slip,
        cable_backlash_rad=backlash.backlash_rad,
        turn_rad=np.stack([drum.loaded.drum_angle_rad, other_way.drum_angle_rad]) - drum.idle.drum_angle_rad,
        reversal_swing_rad=drum.reversal_swing_rad,
        highest_tension_N=tension.max(axis=0),
        lowest_tension_N=tension.min(axis=0),
        peak_torque_Nm=np.stack([_peak_torque(d, need, drum.idle, way) for way in (1, -1)]),
    )


def _peak_torque(d: DriveSI, need: Requirements, idle: Equilibrium, way: int) -> Floats:
    """Lowest load in one direction at which an input reaches its rating, a cable its tension limit or slips there.

    The load is solved for the limit of the first input. Where another input, or a cable, is beyond its limit at that
    load, it is solved again for that limit: all grow with the load, so the last limit solved for is reached first.
    """
    everything = np.arange(d.batch_shape[0])
    rating, strength = need.input_rating_Nm, need.tension_limit_N
    found = solve_weighted(d, _input_weight(d, 0), way * rating)
    # A copy, since others may get the same solution.
    at = Equilibrium(found.drum_angle_rad.copy(), found.tension_N.copy(), found.stretch_m)
    for i in range(1, d.n_inputs):
        over = everything[way * at.input_torque_Nm(d)[i] > rating]
        if over.size:
            part = _taken(d, over)
            _put(at, over, solve_weighted(part, _input_weight(part, i), way * rating[over]))
    for j in range(d.n_cables):
        over = everything[at.tension_N[j] > strength]
        if over.size and d.sigma[j] == way:
            part = _taken(d, over)
            weight = d.column(d.sigma * (np.arange(d.n_cables) == j), 2) * np.ones(over.size)
            _put(at, over, solve_weighted(part, weight, way * strength[over]))
    for i in range(len(d.through_sides)):
        over = everything[way * (slip_weight(d, i, way) * at.tension_N).sum(axis=0) > 0.0]
        if over.size:
            part = _taken(d, over)
            _put(at, over, solve_weighted(part, slip_weight(part, i, way), np.zeros(over.size)))
    load = way * np.einsum("jn,jn->n", d.sigma[:, None] * d.drum_radius_m, at.tension_N)
    biased = (way * idle.input_torque_Nm(d) >= rating).any(axis=0)
    return np.where(biased, 0.0, np.maximum(load, 0.0))


def _input_weight(d: DriveSI, index: int) -> Floats:
    return np.asarray(d.column(d.sigma * d.of_input(index), 2) * d.input_radius_m)


def _put(at: Equilibrium, which: Any, found: Equilibrium) -> None:
    at.drum_angle_rad[which] = found.drum_angle_rad
    at.tension_N[:, which] = found.tension_N


# Shares of the design's preloads; the last is too low for any use.
SHARES = (1.1, 1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3)


@dataclass(frozen=True)
class ReachedPreload:
    """One row: what is left at a share of the preloads.

    ``at_inputs_Nm``: torque both ways at which an input reaches its rating; ``slack_Nm``: torque both ways at which the
    first cable goes slack; the drive holds the lesser of the two. Turn and swing are at the test torque.
    """

    share: float
    preload_N: tuple[float, ...]
    at_inputs_Nm: tuple[float, float]
    slack_Nm: tuple[float, float]
    turn_mrad: float
    reversal_swing_mrad: float

    @property
    def holds_Nm(self) -> tuple[float, float]:
        """Torque held, + and -."""
        return (min(self.at_inputs_Nm[0], self.slack_Nm[0]), min(self.at_inputs_Nm[1], self.slack_Nm[1]))


def preload_table(design: Modelled, shares: tuple[float, ...] = SHARES) -> tuple[ReachedPreload, ...]:
    """The rows for ``shares`` of the design's preloads. Errors: ``ModelError`` where the model has no answer."""
    si, need, ends = design.si, requirements(design), design.wraps_at_ends_rad
    found = analyse_many(
        si.spread(len(shares)).with_(preload_N=si.preload_N[:, None] * np.array(shares)[None, :]), need
    )
    rows = []
    for k, share in enumerate(shares):
        less = si.with_(preload_N=si.preload_N * share)
        rows.append(
            ReachedPreload(
                share=share,
                preload_N=tuple(float(v) for v in less.preload_N),
                at_inputs_Nm=(float(found.peak_torque_Nm[0, k]), float(found.peak_torque_Nm[1, k])),
                slack_Nm=(
                    float(torque_at_slack_Nm(less, 1, ends).min()),
                    float(torque_at_slack_Nm(less, -1, ends).min()),
                ),
                turn_mrad=float(np.abs(found.turn_rad[:, k]).max()) * 1e3,
                reversal_swing_mrad=float(found.reversal_swing_rad[k]) * 1e3,
            )
        )
    return tuple(rows)
