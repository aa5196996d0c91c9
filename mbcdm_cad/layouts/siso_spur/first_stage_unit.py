"""The attachment of a first cable stage: a whole drive of this layout whose drum's shaft turns the input."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from mbcdm_cad.layouts.base import Attachment
from mbcdm_cad.parts.bill import CABLE, FIXED, AssemblyStep, BillBuilder, MovingBody, PartSpec, Placement
from mbcdm_cad.routes.cable_path import CablePath
from mbcdm_cad.routes.curves import Helix, carried

if TYPE_CHECKING:
    from mbcdm_cad.checks.comparison import Check

FIRST = "first_"
# Beginnings of the names of parts that are the same in both stages.
_STANDARD = ("screw_", "insert_", "bearing_")


class FirstStageUnit(Attachment):
    """Stands back to back with the second stage, its drum's axis the input's, its input turned away from the drum."""

    block = "first_stage"

    @cached_property
    def unit(self) -> Any:
        """See the base class."""
        first = self.layout.drive.first_stage
        assert first is not None
        return type(self.layout)(first)

    @cached_property
    def place(self) -> Placement:
        """Where it stands: its boss on the motor shelf."""
        lay = self.layout
        y = lay.levels.motor_shelf_bottom_z + self.unit.levels.back_y
        return Placement.translation(0.0, y, lay.drive.centre_distance_mm) @ Placement.about((0.0, 0.0, 1.0), 180.0)

    @property
    def _bodies(self) -> dict[str, str]:
        """The bodies of the whole drive with which those of the first stage turn."""
        name, inputs = self.layout.drive.input_names[0], self.unit.drive.input_names
        return {"drum": f"input_{name}", **{f"input_{i}": f"driver_{name}" for i in inputs}}

    @property
    def checks(self) -> tuple[Check, ...]:
        """See the base class."""
        found: tuple[Check, ...] = self.layout.module("checks.stage").checks_of_first(self.unit)
        return found

    @property
    def passing_deg(self) -> Iterator[float]:
        """See the base class."""
        return (angle / self.layout.drive.total_ratio for angle in self.unit.passing_deg)

    def moving_bodies(self) -> Iterator[MovingBody]:
        """Its input, about +Y as it stands back to back."""
        drive, first = self.layout.drive, self.unit.drive
        turns = drive.drum_radius_mm * first.drum_radius_mm, drive.input_radius_mm * first.input_radius_mm
        at = (0.0, 0.0, drive.centre_distance_mm + first.centre_distance_mm)
        yield MovingBody(f"driver_{drive.input_names[0]}", "stage", at, (0.0, 1.0, 0.0), *turns)

    def add_items(self, b: BillBuilder, drum_angle_deg: float) -> None:
        """All its parts, their names with ``first_`` before them; its drum turns with the input."""
        own, groups = self.unit.bill(drum_angle_deg * self.layout.drive.total_ratio), {FIXED: FIXED, **self._bodies}
        for item in own.items:
            stem, what = first_name(item.part), own.parts[item.part]
            b.parts.setdefault(stem, PartSpec(stem, what.part, what.drilled))
            at, group = self.place @ item.location, groups[item.group]
            b.items.append(replace(item, name=first_name(item.name), part=stem, location=at, group=group))

    def cable_paths(self, drum_angle_rad: float) -> Iterator[CablePath]:
        """See the base class."""
        place, first = self.place, self.unit
        for path in first.cable_paths(drum_angle_rad * self.layout.drive.total_ratio):
            pieces = []
            for name, piece in path.pieces:
                assert not isinstance(piece, Helix)
                pieces.append((name, carried(piece, place.rotation, place.shift_mm)))
            stretches = tuple(replace(s, body=self._bodies.get(s.body or "")) for s in path.stretches)
            cable = replace(path.cable, name=f"{FIRST}{path.cable.name}")
            yield CablePath(cable, drum_angle_rad, tuple(pieces), stretches, first.drive.cable.diameter_mm)

    def steps_before(self) -> Iterator[AssemblyStep]:
        """The whole of it; what it is screwed on holds it in place of a base."""
        for step in self.unit.module("assembly_order").own_steps(self.unit, based=False):
            yield AssemblyStep(f"First stage: {step.text}", tuple(first_name(name) for name in step.items))


def first_name(name: str) -> str:
    """Name of an item or a part of the first stage; parts of a standard, and cables, keep their beginning."""
    if name.startswith(CABLE):
        return f"{CABLE}{FIRST}{name.removeprefix(CABLE)}"
    return name if name.startswith(_STANDARD) else FIRST + name
