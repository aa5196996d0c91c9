"""What stands before an input as attachments: belt or gears between it and the motor, or a first cable stage."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

from mbcdm_cad.layouts.base import Attachment
from mbcdm_cad.layouts.siso_spur.cable_path import turned
from mbcdm_cad.parts.bill import ALONG_Y, CABLE, FIXED, AssemblyStep, BillBuilder, MovingBody, PartSpec, Placement
from mbcdm_cad.parts.coupling import Belt, Wheel, belt_bottom_mm
from mbcdm_cad.routes.curves import CablePath, carried

if TYPE_CHECKING:
    from mbcdm_cad.checks.comparison import Check

# Begins the names of what belongs to the first stage.
FIRST = "first_"
# Beginnings of the names of parts that are the same in both stages.
_STANDARD = ("screw_", "insert_", "bearing_")
# Linear RGB.
_RUBBER = (0.015, 0.015, 0.017)


class BeltOrGears(Attachment):
    """The driving wheel stands beyond the input, as seen from the drum."""

    block = "stage"

    def moving_bodies(self, body: MovingBody) -> Iterator[MovingBody]:
        """The driving wheel of an input."""
        drive = self.layout.drive
        if body.kind == "input":
            name = body.name.removeprefix("input_")
            angle = drive.angles_rad[drive.input_names.index(name)]
            at = turned(angle, 0.0, drive.centre_distance_mm + drive.stage.centre_mm)
            turns = body.numerator_mm * drive.stage.ratio * drive.stage.sense
            yield MovingBody(f"driver_{name}", "stage", at, body.axis, turns, body.denominator_mm)

    def add_on_input(self, b: BillBuilder, name: str, turn: Placement) -> None:
        """Both wheels, and the belt."""
        drive, dims = self.layout.drive, self.layout.stage
        metal = drive.material("aluminium-7075" if dims.stage.is_belt else "steel")
        at = turn @ ALONG_Y @ Placement.translation(0.0, 0.0, dims.bottom_z)
        for part, spec, body in (("driven", dims.driven, "input"), ("driver", dims.driver, "driver")):
            b.add(
                f"stage_{part}_{name}",
                Wheel(spec),
                part=f"stage_{part}",
                material=metal,
                group=f"{body}_{name}",
                place=at,
                mass_g=dims.mass_g(spec),
            )
        if dims.belt is not None:
            # The belt is drawn with the driver at +Y; turned, it is away from the drum.
            stand = turn @ Placement.translation(0.0, 0.0, drive.centre_distance_mm) @ ALONG_Y
            bottom = Placement.translation(0.0, 0.0, dims.bottom_z + belt_bottom_mm())
            b.add(
                f"stage_belt_{name}",
                Belt(dims.belt),
                part="stage_belt",
                material=replace(drive.material("stainless"), colour=_RUBBER),
                place=stand @ Placement.about((0.0, 0.0, 1.0), 180.0) @ bottom,
                mass_g=dims.mass_g(dims.belt),
            )


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

    def moving_bodies(self, body: MovingBody) -> Iterator[MovingBody]:
        """Its input, about +Y as it stands back to back."""
        if body.kind != "input":
            return
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
        first = self.unit
        carry = partial(carried, rotation=self.place.rotation, shift_mm=self.place.shift_mm)
        for path in first.cable_paths(drum_angle_rad * self.layout.drive.total_ratio):
            stretches = tuple(replace(s, body=self._bodies.get(s.body or "")) for s in path.stretches)
            cable = replace(path.cable, name=f"{FIRST}{path.cable.name}")
            own = {"stretches": stretches, "diameter_mm": first.drive.cable.diameter_mm}
            yield replace(path.each(carry), cable=cable, drum_angle_rad=drum_angle_rad, **own)

    def steps_before(self) -> Iterator[AssemblyStep]:
        """The whole of it; what it is screwed on holds it in place of a base."""
        for step in self.unit.own_steps(based=False):
            yield AssemblyStep(f"First stage: {step.text}", tuple(first_name(name) for name in step.items))


def first_name(name: str) -> str:
    """Name of an item or a part of the first stage; parts of a standard, and cables, keep their beginning."""
    if name.startswith(CABLE):
        return f"{CABLE}{FIRST}{name.removeprefix(CABLE)}"
    return name if name.startswith(_STANDARD) else FIRST + name
