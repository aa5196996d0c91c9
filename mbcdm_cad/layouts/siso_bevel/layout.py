"""The layout of Fig. 1 (c): one stepped input pulley, straight onto the drum by a bevel transfer."""

from dataclasses import replace
from functools import cached_property

from mbcdm_cad.checks import design_variables
from mbcdm_cad.design.paths import at
from mbcdm_cad.layouts.base import Conventions, dimensions
from mbcdm_cad.layouts.sector import HeadLayout, coupled_pulley
from mbcdm_cad.layouts.siso_bevel.cable_path import stop_of
from mbcdm_cad.layouts.siso_bevel.drive import ColumnSupport, DirectDrive, DirectRun
from mbcdm_cad.layouts.siso_bevel.support import ColumnDims, DirectStack, column, direct_stack, flange
from mbcdm_cad.parts.input_pulley import dims
from mbcdm_cad.parts.motor_head.dims import HeadDims, head


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


def input_pulley(drive: DirectDrive, levels: DirectStack) -> dims.InputPulleyDims:
    """Dimensions of the pulley; its slots are milled from both end faces."""
    small, large = sorted(drive.cables, key=lambda c: c.step)
    flank = drive.cable.diameter_mm / 2
    bearings = drive.bearings
    return coupled_pulley(
        drive,
        levels,
        name=drive.input_names[0],
        x=0.0,
        lower_neck_radius=bearings.input_lower.inner_shoulder_mm / 2,
        land_bottom_z=levels.land_bottom_z,
        lower_surface_radius=large.input_radius_mm - flank,
        wall_z=-(small.drum_radius_mm + large.drum_radius_mm) / 2,
        upper_surface_radius=small.input_radius_mm - flank,
        land_top_z=levels.land_top_z,
        upper_neck_radius=bearings.input_upper.inner_shoulder_mm / 2,
        slots=(_slot(drive, large, levels.land_bottom_z), _slot(drive, small, levels.land_top_z)),
    )


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
        """The one input pulley."""
        return (input_pulley(self.drive, self.levels),)

    @dimensions
    def head(self) -> HeadDims:
        """Motor head."""
        return head(self.drive, self.levels, flange(self.levels))

    @property
    def steps_before_drum(self) -> tuple[tuple[float, float], ...]:
        """See the base class."""
        pulley = self.inputs[0]
        return (pulley.upper_surface_radius, -pulley.land_top_z), (pulley.lower_surface_radius, -pulley.wall_z)


LAYOUT = DirectLayout
