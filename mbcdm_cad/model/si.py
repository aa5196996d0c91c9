"""The drive in SI units: the only place where N, GPa, mm^2 and degrees of the design file are converted.

Arrays carry the cable on axis 0; further axes are a batch of designs. A single design has arrays of shape
(n_cables,) and scalars; a batch of n designs has (n_cables, n) and (n,), so that every formula of this room works on
both without a loop. How the cables run is the configuration's matter (:mod:`mbcdm_cad.routes`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.route import DRUM_RADIUS, INPUT_RADIUS, DriveRoutes, Geometry, RoutedDrive


class ModelError(MbcdmError):
    """A question the model cannot answer; the text says what, the value, the limit and the remedy."""


# The fields that a batch of designs may vary, by shape; the geometry's lengths besides.
PER_CABLE = ("preload_N", "input_wrap_rad", "drum_wrap_rad", "anchor_m_N")
PER_DESIGN = ("friction_coefficient", "modulus_Pa", "area_m2")

MM = 1e-3
GPA = 1e9
MM2 = 1e-6


@dataclass(frozen=True, eq=False)
class DriveSI:
    """What the analytic model needs of a drive, in m, N, Pa and rad.

    Shapes: per-cable arrays (n_cables, *batch), the rest (*batch) or scalar. ``parameters`` are the lengths from which
    ``geometry`` gives spans and passed wraps. Wraps are the live angles between the free span (or the transfer point)
    and the anchor; infinite by default, i.e. longer than any slip zone. ``passed_wrap_rad`` has for each passed body
    the wrap on which a cable may slip: 0 unless the design counts it, so that the tension does not change there.
    ``anchor_m_N``: how far the cable's end on the drum gives way for each newton there, by springs.
    """

    geometry: Geometry
    parameters: Mapping[str, Floats]
    preload_N: Floats
    friction_coefficient: Floats
    modulus_Pa: Floats
    area_m2: Floats
    input_wrap_rad: Floats
    drum_wrap_rad: Floats
    passed_wrap_rad: tuple[Floats, ...]
    anchor_m_N: Floats

    def __post_init__(self) -> None:
        """Add axes to fields of shape (n_cables,), which do not vary in a batch, so that they broadcast."""
        columns = self._columns
        most = max(value.ndim for value in columns)
        if any(value.ndim == 1 < most for value in columns):
            wide = self._each_cable(lambda v: v.reshape(-1, *(1,) * (most - 1)) if v.ndim == 1 < most else v)
            for name, value in wide.items():
                object.__setattr__(self, name, value)

    @property
    def _columns(self) -> list[Floats]:
        lengths = [self.parameters[name] for name in self.geometry.per_cable]
        return [*lengths, *(getattr(self, name) for name in PER_CABLE), *self.passed_wrap_rad]

    def _each_cable(self, change: Callable[[Floats], Floats]) -> dict[str, Any]:
        """The fields that hold per-cable arrays, each array changed."""
        own = self.geometry.per_cable
        lengths = {name: change(value) if name in own else value for name, value in self.parameters.items()}
        fields: dict[str, Any] = {name: change(getattr(self, name)) for name in PER_CABLE}
        return fields | {"parameters": lengths, "passed_wrap_rad": tuple(change(w) for w in self.passed_wrap_rad)}

    def mapped(self, per_cable: Callable[[Floats], Floats], per_design: Callable[[Floats], Floats]) -> DriveSI:
        """A copy with every per-cable array changed by one function and every value of the design by the other."""
        fields = self._each_cable(per_cable)
        own = self.geometry.per_cable
        lengths = {k: value if k in own else per_design(value) for k, value in fields["parameters"].items()}
        rest = {name: per_design(getattr(self, name)) for name in PER_DESIGN}
        return replace(self, **(fields | rest | {"parameters": lengths}))

    @cached_property
    def law_key(self) -> tuple[Any, ...]:
        """Shapes and values of all that the stretch of the cables follows from."""
        per_body = (self.input_radius_m, self.drum_radius_m, self.input_wrap_rad, self.drum_wrap_rad)
        own = (self.preload_N, self.axial_stiffness_N, self.free_span_m, self.friction_coefficient, self.anchor_m_N)
        return content_of(*own, *per_body, *self.passed_radii_m, *self.passed_wrap_rad)

    def is_same(self, other: DriveSI) -> bool:
        """Whether the other one holds the same values."""
        mine, its = self._values, other._values
        return (
            self.geometry == other.geometry
            and self.parameters.keys() == other.parameters.keys()
            and len(mine) == len(its)
            and all(np.array_equal(a, b) for a, b in zip(mine, its, strict=True))
        )

    @property
    def _values(self) -> list[Floats]:
        own = [getattr(self, name) for name in (*PER_CABLE, *PER_DESIGN)]
        return [*self.parameters.values(), *own, *self.passed_wrap_rad]

    @property
    def cable_names(self) -> tuple[str, ...]:
        """Names of the cables."""
        return self.geometry.cable_names

    @property
    def input_names(self) -> tuple[str, ...]:
        """Names of the inputs."""
        return self.geometry.input_names

    @property
    def input_of(self) -> tuple[int, ...]:
        """For each cable the index of its input."""
        return self.geometry.input_of

    @cached_property
    def sigma(self) -> Floats:
        """Sense in which each cable's tension turns the drum about its axis, shape (n_cables,)."""
        return np.array(self.geometry.sense, dtype=float)

    @property
    def input_radius_m(self) -> Floats:
        """Lever of each cable at its input."""
        return self.parameters[INPUT_RADIUS]

    @property
    def drum_radius_m(self) -> Floats:
        """Lever of each cable at the drum."""
        return self.parameters[DRUM_RADIUS]

    @property
    def passed_radii_m(self) -> tuple[Floats, ...]:
        """Radius of each cable on each body that it passes, from the drum on."""
        return tuple(self.parameters[name] for name in self.geometry.passed_radii.values())

    @property
    def n_cables(self) -> int:
        """Number of cables, the length of axis 0."""
        return len(self.cable_names)

    @property
    def n_inputs(self) -> int:
        """Number of input pulleys."""
        return len(self.input_names)

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Shape of the batch of designs; () for a single one."""
        own = self.geometry.per_cable
        lengths = [v.shape[1:] if name in own else np.shape(v) for name, v in self.parameters.items()]
        shapes = (self.preload_N.shape[1:], np.shape(self.friction_coefficient), np.shape(self.modulus_Pa))
        return np.broadcast_shapes(*lengths, *shapes)

    @cached_property
    def routes(self) -> DriveRoutes:
        """Bodies and cables of a single design. Errors: ``ModelError`` where the geometry leaves no free span."""
        _ = self.free_span_m
        return self.geometry.routes(self.parameters)

    @cached_property
    def axial_stiffness_N(self) -> Floats:
        """E A of the rope in N."""
        return np.asarray(self.modulus_Pa * self.area_m2)

    @cached_property
    def free_span_m(self) -> Floats:
        """L_free, all spans of each cable, Eq. (11). Errors: ``ModelError`` where there is no geometry."""
        span = self.geometry.free_span_m(self.parameters)
        if np.isnan(span).any():
            raise ModelError(self.geometry.fault(self.parameters))
        return span

    @cached_property
    def passed_wraps(self) -> tuple[tuple[Floats, Floats], ...]:
        """(radius, wrap) of each slip zone on passed bodies: slip from both ends gives two zones of half the wrap."""
        return tuple(
            (2.0 * radius, 0.5 * wrap) for radius, wrap in zip(self.passed_radii_m, self.passed_wrap_rad, strict=True)
        )

    @cached_property
    def endless_wraps(self) -> bool:
        """True where every wrap is longer than any slip zone, so that the closed forms hold."""
        passed = all(bool((np.isinf(wrap) | (wrap == 0.0)).all()) for wrap in self.passed_wrap_rad)
        return bool(np.isinf(self.input_wrap_rad).all() and np.isinf(self.drum_wrap_rad).all() and passed)

    @cached_property
    def slip_reach_m(self) -> Floats:
        """(r_i + r_o)/mu in m, 2 r/mu more for each body passed with slip. Errors: ``ModelError`` unless endless."""
        if not self.endless_wraps:
            raise ModelError("a wrap is finite: this form needs wraps longer than any slip zone; leave them infinite")
        if not np.all(self.friction_coefficient > 0.0):
            raise ModelError("friction_coefficient 0 with unlimited wraps: slip zones have no end; give the wraps")
        reach = self.input_radius_m + self.drum_radius_m
        for radius, wrap in zip(self.passed_radii_m, self.passed_wrap_rad, strict=True):
            reach = reach + np.where(wrap > 0.0, 2.0, 0.0) * radius
        return np.asarray(reach / self.friction_coefficient)

    @cached_property
    def through_wrap_rad(self) -> Floats | None:
        """Wrap of each cable over its input that friction alone holds, (n, *batch); None where cables are anchored."""
        return self.geometry.through_wrap_rad(self.parameters)

    @cached_property
    def through_sides(self) -> tuple[tuple[int, int], ...]:
        """Both sides of each cable of :attr:`through_wrap_rad`; they follow each other."""
        n = 0 if self.through_wrap_rad is None else len(self.through_wrap_rad)
        return tuple((2 * k, 2 * k + 1) for k in range(n))

    @cached_property
    def through_names(self) -> tuple[str, ...]:
        """Names of these cables: that of the input, with a number where several cables lie side by side on it."""
        of = [self.input_of[one] for one, _ in self.through_sides]
        return tuple(
            self.input_names[i] + (f"_{of[:k].count(i) + 1}" if of.count(i) > 1 else "") for k, i in enumerate(of)
        )

    @property
    def kappa(self) -> Floats:
        """kappa = mu L_free / (r_o + r_i), the number that Eq. (15) sets to zero."""
        return np.asarray(self.friction_coefficient * self.free_span_m / (self.drum_radius_m + self.input_radius_m))

    @property
    def total_ratio(self) -> Floats:
        """i_c = r_o / r_i of each cable."""
        return np.asarray(self.drum_radius_m / self.input_radius_m)

    @cached_property
    def input_turns(self) -> Floats:
        """Turns of each input for one of the drum, by its first cable; shape (n_inputs, *batch)."""
        return np.asarray(self.total_ratio[[self.input_of.index(i) for i in range(self.n_inputs)]])

    @cached_property
    def springs(self) -> bool:
        """Whether the end of a cable on the drum gives way."""
        return bool(np.any(self.anchor_m_N > 0.0))

    @property
    def slips_on_passed(self) -> bool:
        """Whether a cable may slip on a body that it passes."""
        return any(bool(np.any(wrap > 0.0)) for wrap in self.passed_wrap_rad)

    @cached_property
    def without_passed_slip(self) -> DriveSI:
        """The same where the tension passes every body unchanged; the same object each time."""
        return self.with_(passed_wrap_rad=[np.zeros_like(wrap) for wrap in self.passed_wrap_rad])

    @cached_property
    def with_passed_slip(self) -> DriveSI:
        """The same with slip on passed bodies, from each end of a wrap up to half of it; the same object each time."""
        return self.with_(passed_wrap_rad=self.geometry.passed_wrap_rad(self.parameters))

    def of_input(self, index: int) -> Floats:
        """1.0 for the cables that run from input ``index``, else 0.0; shape (n_cables,)."""
        return np.array([1.0 if i == index else 0.0 for i in self.input_of])

    def value(self, name: str) -> Floats:
        """A field or one of the geometry's lengths, by name."""
        found: Floats = self.parameters[name] if name in self.parameters else getattr(self, name)
        return found

    def with_(self, **changes: Any) -> DriveSI:
        """A copy with some fields, or some of the geometry's lengths, replaced."""
        lengths = dict(self.parameters)
        fields: dict[str, Any] = {}
        for name, value in changes.items():
            if name in lengths:
                lengths[name] = np.asarray(value, float)
            elif name == "passed_wrap_rad":
                fields[name] = tuple(np.asarray(wrap, float) for wrap in value)
            else:
                fields[name] = value if name == "geometry" else np.asarray(value, float)
        return replace(self, **fields, parameters=lengths)

    def lifted(self, shape: tuple[int, ...]) -> DriveSI:
        """The same drive with singleton axes put between cable and batch, so that it broadcasts against ``shape``."""
        extra = len(shape) - len(self.batch_shape)
        if extra <= 0:
            return self
        return replace(self, **self._each_cable(lambda v: v.reshape(v.shape[0], *(1,) * extra, *v.shape[1:])))

    def spread(self, n: int) -> DriveSI:
        """A batch of ``n`` designs with every array at full size, from one design or from a batch of ``n``."""
        return self.mapped(
            lambda v: np.broadcast_to(v.reshape(self.n_cables, -1), (self.n_cables, n)),
            lambda v: np.broadcast_to(v, (n,)),
        )

    def column(self, per_cable: Floats, ndim: int) -> Floats:
        """``per_cable`` (n_cables, ...) with trailing axes up to ``ndim`` in all, to multiply arrays of that many."""
        return per_cable.reshape(per_cable.shape + (1,) * (ndim - per_cable.ndim))


def content_of(*arrays: Floats | float) -> tuple[Any, ...]:
    """Shapes and values of arrays, to look up what follows from them."""
    return tuple((np.shape(a), np.asarray(a, float).tobytes()) for a in arrays)


def to_si(drive: Drive, routed: Callable[[], RoutedDrive], slips_on_passed: bool) -> DriveSI:
    """A design in SI, its cables on the routes that ``routed`` gives; ``Layout.si`` keeps it.

    ``slips_on_passed``: whether it counts the rope's creep on the bodies that cables pass. Raises ``ModelError`` if a
    cable names an input that the drive does not have, or if there are no routes.
    """
    for run in drive.cables:
        if run.input_name not in drive.input_names:
            raise ModelError(
                f"cable {run.name}: runs from input {run.input_name!r}, the drive has {', '.join(drive.input_names)}; "
                "correct cables[].input"
            )
    try:
        found = routed()
    except MbcdmError as error:
        raise ModelError(str(error)) from None
    n = len(found.geometry.cable_names)
    unlimited = np.full(n, np.inf)
    return DriveSI(
        geometry=found.geometry,
        parameters=found.parameters,
        preload_N=np.array([run.preload_N for run in drive.cables], dtype=float),
        friction_coefficient=np.asarray(drive.friction_coefficient, dtype=float),
        modulus_Pa=np.asarray(drive.cable.modulus_GPa * GPA),
        area_m2=np.asarray(drive.cable.area_mm2 * MM2),
        input_wrap_rad=unlimited,
        drum_wrap_rad=unlimited,
        passed_wrap_rad=found.geometry.passed_wrap_rad(found.parameters)
        if slips_on_passed
        else (np.zeros(n),) * len(found.geometry.passed_radii),
        anchor_m_N=np.full(n, drive.anchor_m_N),
    )
