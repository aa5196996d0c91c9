"""Spans and wraps as functions of the lengths that a configuration may vary, for one design or for a batch.

A route describes one design. A search, a sensitivity study or a tolerance study needs thousands of designs that differ
in a few lengths; for these the configuration's :class:`Geometry` gives spans and wraps of all at once as arrays.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from mbcdm_cad.routes import Floats

if TYPE_CHECKING:
    from mbcdm_cad.routes.route import DriveRoutes

INPUT_RADIUS, DRUM_RADIUS = "input_radius_m", "drum_radius_m"


@dataclass(frozen=True)
class Varied:
    """A length of the whole design that studies vary: its label, values for a plot over it and a range, in m."""

    name: str
    label: str
    values_m: tuple[float, ...]
    range_m: tuple[float, float]


class Geometry(Protocol):
    """Cables and inputs of a drive, and how spans and wraps follow from its lengths.

    ``input_radius_m`` and ``drum_radius_m`` are always among the lengths of each cable. ``passed_radii`` gives for each
    passed body, from the drum on, the name of the length that is its radius.
    """

    @property
    def cable_names(self) -> tuple[str, ...]:
        """Names of the cables: axis 0 of every array."""

    @property
    def input_names(self) -> tuple[str, ...]:
        """Names of the inputs."""

    @property
    def input_of(self) -> tuple[int, ...]:
        """For each cable the index of its input."""

    @property
    def sense(self) -> tuple[int, ...]:
        """For each cable the sense (+1 or -1) in which its tension turns the drum."""

    @property
    def per_cable(self) -> tuple[str, ...]:
        """Names of the lengths that each cable has separately."""

    @property
    def varied(self) -> tuple[Varied, ...]:
        """The lengths of the whole design."""

    @property
    def passed_radii(self) -> dict[str, str]:
        """Passed body -> name of the length that is its radius."""

    def free_span_m(self, parameters: Mapping[str, Floats]) -> Floats:
        """Free length of each cable, (n_cables, *batch), NaN where there is no geometry.

        Lengths of cables are (n_cables, *batch), those of the whole design (*batch).
        """

    def passed_wrap_rad(self, parameters: Mapping[str, Floats]) -> tuple[Floats, ...]:
        """Wrap of each cable on each passed body, (n_cables, *batch); 0 where it does not run on it."""

    def through_wrap_rad(self, parameters: Mapping[str, Floats]) -> Floats | None:
        """Wrap of each cable over its input that friction alone holds there, (n, *batch); its two sides are neighbours.

        None where cables are anchored on their inputs. A cable without an anchor counts as two, one for each sense,
        from the point at which it sticks on the input; the ratio of their tensions is at most e^(mu wrap).
        """

    def fault(self, parameters: Mapping[str, Floats]) -> str:
        """Message for lengths without a geometry: problem, value, limit and remedy in one sentence."""

    def routes(self, parameters: Mapping[str, Floats]) -> DriveRoutes:
        """Bodies and cables of one design."""


class AnchoredGeometry:
    """What geometries share whose cables end on a drum's sides, are anchored on their inputs, and pass no body."""

    # Side to which each cable runs on the drum.
    drum_side: tuple[int, ...]

    @property
    def sense(self) -> tuple[int, ...]:
        """A cable that runs towards +x turns the drum negative about +Y."""
        return tuple(-side for side in self.drum_side)

    @property
    def passed_radii(self) -> dict[str, str]:
        """None."""
        return {}

    def passed_wrap_rad(self, parameters: Mapping[str, Floats]) -> tuple[Floats, ...]:
        """None."""
        return ()

    def through_wrap_rad(self, parameters: Mapping[str, Floats]) -> Floats | None:
        """None."""
        return None


def tangent_length_m(distance_m: Floats, radius_sum_m: Floats) -> Floats:
    """Length of the tangent common to two circles, NaN where there is none; Eq. (11).

    ``radius_sum_m`` is r_1 + r_2 where the tangent crosses the line of centres, |r_1 - r_2| where it does not.
    """
    square = np.asarray(distance_m) ** 2 - np.asarray(radius_sum_m) ** 2
    return np.asarray(np.sqrt(np.where(square > 0.0, square, np.nan)))


@dataclass(frozen=True, eq=False)
class RoutedDrive:
    """The routes of one design as a configuration supplies them: geometry, its lengths in m, and those of the file.

    ``parameters`` are (n_cables,) or scalar; ``shown`` are the lengths of the whole design by their names in the file.
    """

    geometry: Geometry
    parameters: dict[str, Floats]
    shown: dict[str, float]

    @property
    def routes(self) -> DriveRoutes:
        """Bodies and cables of this design."""
        return self.geometry.routes(self.parameters)
