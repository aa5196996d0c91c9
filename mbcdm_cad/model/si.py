"""The drive in SI units: the only place where mm, degrees, GPa and mN m of the design file are converted.

Arrays carry the cable on axis 0; further axes are a batch of designs. A single design has arrays of shape
(n_cables,) and scalars; a batch of n designs has (n_cables, n) and (n,), so that every formula of this room works on
both without a loop.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mbcdm_cad.model.errors import ModelError

if TYPE_CHECKING:
    from mbcdm_cad.design.drive import Drive

Floats = NDArray[np.float64]

# The fields that a batch of designs may vary, by shape.
PER_CABLE = (
    "input_radius_m", "guide_radius_m", "drum_radius_m", "preload_N", "input_wrap_rad", "drum_wrap_rad",
    "guide_wrap_rad",
)  # fmt: skip
PER_DESIGN = ("centre_distance_m", "friction_coefficient", "modulus_Pa", "area_m2")

MM = 1e-3
GPA = 1e9
MM2 = 1e-6


@dataclass(frozen=True, eq=False)
class DriveSI:
    """What the analytic model needs of a drive, in m, N, Pa and rad.

    Shapes: per-cable arrays (n_cables, *batch), the rest (*batch) or scalar. ``sigma`` and ``input_of`` are
    (n_cables,): the sense in which a cable's tension turns the drum about +Y, and the index of its input.
    Wraps are the live angles between the free span (or the transfer point) and the anchor; infinite by default,
    i.e. longer than any slip zone. ``guide_wrap_rad`` is the wrap on which the guide lets a cable slip: 0 by default,
    nothing lost or gained there (see :func:`mbcdm_cad.model.kinematics.with_guide_slip`).
    """

    cable_names: tuple[str, ...]
    input_names: tuple[str, ...]
    input_of: tuple[int, ...]
    input_side: tuple[int, ...]
    sigma: Floats
    input_radius_m: Floats
    guide_radius_m: Floats
    drum_radius_m: Floats
    preload_N: Floats
    centre_distance_m: Floats
    friction_coefficient: Floats
    modulus_Pa: Floats
    area_m2: Floats
    input_wrap_rad: Floats
    drum_wrap_rad: Floats
    guide_wrap_rad: Floats

    def __post_init__(self) -> None:
        """Give fields that a batch does not vary, of shape (n_cables,), the axes to broadcast with those it does."""
        most = max(getattr(self, name).ndim for name in PER_CABLE)
        for name in PER_CABLE:
            value = getattr(self, name)
            if value.ndim == 1 < most:
                object.__setattr__(self, name, value.reshape(-1, *(1,) * (most - 1)))

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
        shapes = (
            self.input_radius_m.shape[1:],
            self.drum_radius_m.shape[1:],
            self.preload_N.shape[1:],
            np.shape(self.centre_distance_m),
            np.shape(self.friction_coefficient),
            np.shape(self.modulus_Pa),
        )
        return np.broadcast_shapes(*shapes)

    @cached_property
    def axial_stiffness_N(self) -> Floats:
        """E A of the rope in N."""
        return np.asarray(self.modulus_Pa * self.area_m2)

    @cached_property
    def free_span_m(self) -> Floats:
        """L_free = sqrt(L^2 - (r_g + r_i)^2), the internal tangent of guide and input pulley, Eq. (11)."""
        reach = self.guide_radius_m + self.input_radius_m
        square = self.centre_distance_m**2 - reach**2
        if not np.all(square > 0.0):
            raise ModelError(
                f"free span: centre distance {np.min(self.centre_distance_m):.6g} m does not exceed r_g + r_i = "
                f"{np.max(reach):.6g} m, so the cable has no straight span; raise centre_distance_mm or cut the radii"
            )
        return np.asarray(np.sqrt(square))

    @cached_property
    def endless_wraps(self) -> bool:
        """True where every wrap is longer than any slip zone, so that the closed forms hold."""
        guide = np.isinf(self.guide_wrap_rad) | (self.guide_wrap_rad == 0.0)
        return bool(np.isinf(self.input_wrap_rad).all() and np.isinf(self.drum_wrap_rad).all() and guide.all())

    @cached_property
    def slip_reach_m(self) -> Floats:
        """(r_i + r_o)/mu in m, 2 r_g/mu more where cables slip on the guide. Errors: ``ModelError`` unless endless."""
        if not self.endless_wraps:
            raise ModelError("a wrap is finite: this form needs wraps longer than any slip zone; leave them infinite")
        if not np.all(self.friction_coefficient > 0.0):
            raise ModelError("friction_coefficient 0 with unlimited wraps: slip zones have no end; give the wraps")
        on_guide = np.where(self.guide_wrap_rad > 0.0, 2.0, 0.0) * self.guide_radius_m
        return np.asarray((self.input_radius_m + self.drum_radius_m + on_guide) / self.friction_coefficient)

    @property
    def kappa(self) -> Floats:
        """kappa = mu L_free / (r_o + r_i), the number that Eq. (15) sets to zero."""
        return np.asarray(self.friction_coefficient * self.free_span_m / (self.drum_radius_m + self.input_radius_m))

    @property
    def total_ratio(self) -> Floats:
        """i_c = r_o / r_i of each cable."""
        return np.asarray(self.drum_radius_m / self.input_radius_m)

    def of_input(self, index: int) -> Floats:
        """1.0 for the cables that run from input ``index``, else 0.0; shape (n_cables,)."""
        return np.array([1.0 if i == index else 0.0 for i in self.input_of])

    def with_(self, **changes: Any) -> DriveSI:
        """A copy with some fields replaced."""
        fields: dict[str, Any] = {k: v if isinstance(v, tuple) else np.asarray(v, float) for k, v in changes.items()}
        return replace(self, **fields)

    def lifted(self, shape: tuple[int, ...]) -> DriveSI:
        """The same drive with singleton axes put between cable and batch, so that it broadcasts against ``shape``."""
        extra = len(shape) - len(self.batch_shape)
        if extra <= 0:
            return self
        changes = {}
        for name in PER_CABLE:
            value = getattr(self, name)
            changes[name] = value.reshape(value.shape[0], *(1,) * extra, *value.shape[1:])
        return replace(self, **changes)

    def spread(self, n: int) -> DriveSI:
        """A batch of ``n`` designs with every array at full size, from one design or from a batch of ``n``."""
        columns = {k: getattr(self, k).reshape(self.n_cables, -1) for k in PER_CABLE}
        wide = {k: np.broadcast_to(value, (self.n_cables, n)) for k, value in columns.items()}
        return self.with_(**wide, **{k: np.broadcast_to(getattr(self, k), (n,)) for k in PER_DESIGN})

    def column(self, per_cable: Floats, ndim: int) -> Floats:
        """``per_cable`` (n_cables, ...) with trailing axes up to ``ndim`` in all, to multiply arrays of that many."""
        return per_cable.reshape(per_cable.shape + (1,) * (ndim - per_cable.ndim))


def to_si(drive: Drive) -> DriveSI:
    """Convert a design to SI. Errors: ``ModelError`` if a cable names an input that the drive has not."""
    for run in drive.cables:
        if run.input_name not in drive.input_names:
            raise ModelError(
                f"cable {run.name}: runs from input {run.input_name!r}, the drive has {', '.join(drive.input_names)}; "
                "correct cables[].input"
            )

    def column(attribute: str, unit: float) -> Floats:
        return np.array([getattr(run, attribute) * unit for run in drive.cables], dtype=float)

    unlimited = np.full(len(drive.cables), np.inf)
    return DriveSI(
        cable_names=tuple(run.name for run in drive.cables),
        input_names=tuple(drive.input_names),
        input_of=tuple(drive.input_names.index(run.input_name) for run in drive.cables),
        input_side=tuple(drive.input_sides),
        sigma=np.array([float(run.sigma) for run in drive.cables]),
        input_radius_m=column("input_radius_mm", MM),
        guide_radius_m=column("guide_radius_mm", MM),
        drum_radius_m=column("drum_radius_mm", MM),
        preload_N=column("preload_N", 1.0),
        centre_distance_m=np.asarray(drive.centre_distance_mm * MM),
        friction_coefficient=np.asarray(float(drive.friction_coefficient)),
        modulus_Pa=np.asarray(drive.cable.modulus_GPa * GPA),
        area_m2=np.asarray(drive.cable.area_mm2 * MM2),
        input_wrap_rad=unlimited,
        drum_wrap_rad=unlimited,
        guide_wrap_rad=np.zeros(len(drive.cables)),
    )
