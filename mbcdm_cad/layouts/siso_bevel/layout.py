"""The layout of Fig. 1 (c): one stepped input pulley, straight onto the drum by a bevel transfer."""

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from math import degrees, radians
from typing import Any

from mbcdm_cad.checks import design_variables
from mbcdm_cad.design.paths import at
from mbcdm_cad.layouts.base import Conventions, dimensions
from mbcdm_cad.layouts.bevel_transfer import TravelFigures, ends_at_drum, tensioned
from mbcdm_cad.layouts.sector import HeadLayout, coupled_pulley, wraps_over_travel
from mbcdm_cad.layouts.siso_bevel.cable_path import full_input_turn_deg, input_wrap_rad, stop_of
from mbcdm_cad.layouts.siso_bevel.design_file import ColumnSupport, DirectDrive, DirectRun
from mbcdm_cad.layouts.siso_bevel.support import ColumnDims, DirectStack, column, direct_stack, flange
from mbcdm_cad.model.tensioning import TensioningPlan, tensioning_plan
from mbcdm_cad.parts.input_pulley import dims
from mbcdm_cad.parts.motor_head.dims import HeadDims, head
from mbcdm_cad.parts.terminal import tensioned_rope
from mbcdm_cad.routes.curves import EndOfTravel, by_sense, wrap_lines


def _reserve(drive: DirectDrive, value: float) -> DirectDrive:
    return replace(drive, reserve_deg=value, dead_turns=value / 360.0)


VARIABLES: dict[str, design_variables.DesignVariable] = design_variables.by_path(
    (
        *design_variables.SHARED,
        design_variables.radii(design_variables.ALL_RADII, ("drum_radius_mm", "input_radius_mm")),
        design_variables.radii(at.transmission.input_radii_mm, ("input_radius_mm",))._replace(
            applies=lambda d: d.radii_explicit
        ),
        design_variables.INPUT_TO_DRUM,
        design_variables.DesignVariable(at.transmission.reserve_deg, lambda drive: drive.reserve_deg, _reserve),
        design_variables.field(at.clearances.transfer_gap_mm),
        design_variables.field(at.clearances.land_edge_mm),
        *design_variables.DRUM,
        *design_variables.lengths("support", ColumnSupport),
    )
)


def _slot(drive: DirectDrive, cable: DirectRun, face_z: float) -> dims.StopSlot:
    stop = stop_of(drive, cable)
    turned = replace(stop, end_angle_rad=-stop.end_angle_rad, away=-stop.away)
    return dims.stop_slot(drive, cable.name, cable.input_radius_mm, turned, -cable.drum_radius_mm, face_z)


class DirectLayout(HeadLayout):
    """One design; pulley and collar have their heights along -Z."""

    name = "siso_bevel"
    title = "one input straight onto the drum by a bevel transfer (Fig. 1 c)"
    variables = VARIABLES
    conventions = Conventions(
        frame="Frame: origin where drum axis (Y) and input axis (Z) meet; the motor stands above; lengths in mm.",
        cables="Cables are round rods at the nominal diameter; on the input each lies in the plane of its step.",
    )

    drive: DirectDrive
    steps: tuple[DirectRun, ...]

    def refuse_impossible(self) -> None:
        """Refuses a pulley too small for a stop."""
        self.terminal_way  # noqa: B018 - raises where there is none

    @cached_property
    def levels(self) -> DirectStack:
        """Heights and depths."""
        return direct_stack(self.drive)

    @dimensions
    def frame(self) -> ColumnDims:
        """The frame."""
        return column(self.drive, self.levels, self.drum_shaft)

    @dimensions
    def inputs(self) -> tuple[dims.InputPulleyDims, ...]:
        """The one input pulley; its slots are milled from both end faces."""
        drive, v, (small, large) = self.drive, self.levels, self.steps
        pulley = coupled_pulley(
            drive,
            v,
            name=drive.input_names[0],
            x=0.0,
            lower_neck_radius=drive.bearings.input_lower.inner_shoulder_mm / 2,
            land_bottom_z=v.land_bottom_z,
            lower_surface_radius=large.input_radius_mm - self.flank_mm,
            wall_z=-(small.drum_radius_mm + large.drum_radius_mm) / 2,
            upper_surface_radius=small.input_radius_mm - self.flank_mm,
            land_top_z=v.land_top_z,
            upper_neck_radius=drive.bearings.input_upper.inner_shoulder_mm / 2,
            slots=(_slot(drive, large, v.land_bottom_z), _slot(drive, small, v.land_top_z)),
        )
        return (pulley,)

    @dimensions
    def head(self) -> HeadDims:
        """Motor head."""
        return head(self.drive, self.levels, flange(self.levels))

    @property
    def steps_before_drum(self) -> tuple[tuple[float, float], ...]:
        """See the base class."""
        pulley = self.inputs[0]
        return (pulley.upper_surface_radius, -pulley.land_top_z), (pulley.lower_surface_radius, -pulley.wall_z)

    @cached_property
    def path_figures(self) -> TravelFigures:
        """See the base class."""
        return TravelFigures(*wraps_over_travel(self), *by_sense(self._ends()))

    def _ends(self) -> Iterator[EndOfTravel]:
        drive, half = self.drive, self.half_travel_rad
        stop = drive.half_travel_deg + drive.stop_clearance_deg
        yield from (EndOfTravel(way * stop, "hard stop") for way in (1, -1))
        for run in drive.cables:
            ratio, off = run.drum_radius_mm / run.input_radius_mm, -run.drum_side
            yield from ends_at_drum(self, run, "input")
            unwound = -half - radians(drive.reserve_deg) / ratio
            yield EndOfTravel(off * degrees(unwound), f"{run.name} is all off the input")
            full = radians(360.0 - full_input_turn_deg(drive, run)) / ratio
            yield EndOfTravel(off * degrees(half + full), f"the input has taken up a whole turn of {run.name}")

    @classmethod
    def path_lines(cls, cable: dict[str, Any]) -> Iterator[str]:
        """See the base class."""
        return wrap_lines(cable)

    @cached_property
    def tensioning(self) -> TensioningPlan:
        """See the base class; no free span can be plucked."""
        drive, cables = self.drive, []
        for c, path in zip(drive.cables, self.cable_paths(0.0), strict=True):
            wound = input_wrap_rad(drive, c, 0.0)
            cables.append(tensioned(self, path, ((c.input_radius_mm * wound * 1e-3, wound),)))
        return tensioning_plan(cables, tensioned_rope(drive), drive.tensioner.pitch_mm * 1e-3)


LAYOUT = DirectLayout
