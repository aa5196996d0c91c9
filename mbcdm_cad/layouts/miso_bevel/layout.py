"""The layout of Fig. 1 (d): two inputs, a guide, and a bevel transfer to the drum."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

from mbcdm_cad.checks.design_variables import ALL_RADII, DRUM, SHARED, DesignVariable, by_path, field, lengths, radii
from mbcdm_cad.design.paths import at
from mbcdm_cad.layouts.base import Attachment, Conventions, NoFigureError, dimensions
from mbcdm_cad.layouts.miso_bevel.cable_path import GUIDE
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive, BevelRun, Support
from mbcdm_cad.layouts.miso_bevel.stack import Stack, input_pulley, stack, stop_pin_z
from mbcdm_cad.layouts.miso_bevel.support import FrameDims, TopPlateDims, frame, top_plate
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.model.losses import BearingPair, body_bearings
from mbcdm_cad.parts.input_pulley.dims import InputPulleyDims
from mbcdm_cad.parts.turned import AxleDims, IdlerDims
from mbcdm_cad.routes import Floats

if TYPE_CHECKING:
    from mbcdm_cad.model.si import DriveSI
    from mbcdm_cad.model.structure.causes import Cause


def _input_ratio(drive: BevelDrive, value: float) -> BevelDrive:
    return replace(drive, cables=tuple(replace(c, input_radius_mm=c.guide_radius_mm / value) for c in drive.cables))


def _radii_explicit(drive: BevelDrive) -> bool:
    return drive.radii_explicit


# Whether the radii are explicit: what a remedy scales, and what it adds.
_SHOWN = {True: (ALL_RADII, ""), False: (at.transmission.drum_radii_mm, " (the others follow)")}
VARIABLES: dict[str, DesignVariable] = by_path(
    (
        *SHARED,
        field(at.transmission.centre_distance_mm, "centre_distance_mm"),
        field(at.transmission.input_setback_mm, "input_setback_mm"),
        radii(ALL_RADII, ("drum_radius_mm", "guide_radius_mm", "input_radius_mm"))._replace(
            shown=lambda drive: _SHOWN[drive.radii_explicit],
            short=(at.transmission.drum_radius_mm, lambda drive: drive.cables[0].drum_radius_mm),
        ),
        radii(at.transmission.input_radii_mm, ("input_radius_mm",))._replace(applies=_radii_explicit),
        radii(at.transmission.guide_radii_mm, ("guide_radius_mm",))._replace(applies=_radii_explicit),
        DesignVariable(
            "transmission.ratios.input_to_guide",
            lambda drive: drive.cables[0].guide_radius_mm / drive.cables[0].input_radius_mm,
            _input_ratio,
            applies=lambda drive: not drive.radii_explicit,
            asked=True,
            short=(
                at.transmission.ratio,
                lambda drive: drive.cables[0].drum_radius_mm / drive.cables[0].input_radius_mm,
            ),
        ),
        field(at.rope.helix_lead_mm, "helix_lead_mm"),
        field(at.rope.dead_turns, "dead_turns"),
        field(at.clearances.transfer_gap_mm),
        field(at.clearances.land_edge_mm),
        *DRUM,
        *lengths("support", Support),
    )
)


class GuideOnAxle(Attachment):
    """The guide on its axle between shelf and top plate, which every design has."""

    block = "guide_material"

    def bearings(self, d: DriveSI) -> Iterator[BearingPair]:
        """See the base class."""
        spec = self.layout.drive.bearings.guide
        yield body_bearings(d, d.routes.body(GUIDE), "guide's bearings", (spec, spec), self.layout.guide_bearings_mm)

    def structure(self, unit_tension_N: Floats) -> Iterator[Cause]:
        """The axle, and the bearings on it."""
        from mbcdm_cad.layouts.structure import axle_causes, elastic
        from mbcdm_cad.model.structure.causes import Section

        lay = self.layout
        spec, supports = lay.drive.bearings.guide, lay.axle_supports_mm
        section, material = Section(supports[0], supports[1], lay.axle.radius), elastic(lay.drive.axle_material)
        return axle_causes(lay, {GUIDE: lay.guide_bearings_mm}, unit_tension_N, supports, spec, section, material)


class BevelLayout(SectorLayout):
    """One design."""

    name = "miso_bevel"
    title = "two inputs, a guide and a bevel transfer to the drum (Fig. 1 d)"
    variables = VARIABLES
    takes = (GuideOnAxle,)
    before_drum = "guide"
    conventions = Conventions(
        frame="Frame: origin where drum axis (Y) and guide axis (Z) meet; input pulleys at x = -L and +L; "
        "lengths in mm.",
        cables="Cables are round rods at the nominal diameter; on the guide they lie in their step planes.",
    )

    drive: BevelDrive
    steps: tuple[BevelRun, ...]

    def refuse_impossible(self) -> None:
        """Refuses pulleys that have no place, and shelves below the drum's axis."""
        levels = self.levels
        if levels.shelf_bottom_z <= 0.0:
            shelf, between = ("lowest", "encoders") if levels.motors_above else ("motor", "coupling space")
            raise NoFigureError(
                f"the {shelf} shelf comes to z = {levels.shelf_bottom_z:.4g} mm, below the drum's axis (limit 0): "
                f"pulleys, {between} and shelves are higher than the drum's radius"
            )

    @property
    def mount_washers(self) -> bool:
        """See the base class."""
        return self.printed_frame

    @cached_property
    def levels(self) -> Stack:
        """Heights and depths."""
        try:
            return stack(self.drive)
        except ValueError as error:
            raise NoFigureError(f"the pulleys have no place: {error}") from None

    @property
    def stop_pin_z(self) -> float:
        """See the base class: low in the web between the shelves, with metal below it."""
        return stop_pin_z(self.drive, self.levels)

    @dimensions
    def inputs(self) -> tuple[InputPulleyDims, ...]:
        """The input pulleys."""
        return tuple(input_pulley(self.drive, self.levels, name) for name in self.drive.input_names)

    @dimensions
    def guide(self) -> IdlerDims:
        """Guide pulley: walls in the middle between the steps, so that the landing point may move both ways."""
        v, bearing = self.levels, self.drive.bearings.guide
        return IdlerDims(
            bottom_z=v.guide_bottom_z,
            top_z=v.guide_top_z,
            surface_radii=tuple(c.guide_radius_mm - self.flank_mm for c in self.steps),
            walls_z=tuple((a.drum_radius_mm + b.drum_radius_mm) / 2 for a, b in pairwise(self.steps)),
            seat_radius=bearing.outer_diameter_mm / 2,
            seat_depth=bearing.width_mm,
            shoulder_radius=bearing.outer_shoulder_mm / 2,
        )

    @property
    def axle_supports_mm(self) -> tuple[float, float]:
        """Heights of the middles of bearing shelf and top plate, which hold the guide's axle."""
        v = self.levels
        return (v.bearing_shelf_bottom_z + v.bearing_shelf_top_z) / 2, (v.top_plate_bottom_z + v.top_plate_top_z) / 2

    @property
    def guide_bearings_mm(self) -> tuple[float, float]:
        """Heights of the middles of the guide's bearings."""
        levels, half = self.levels, self.drive.bearings.guide.width_mm / 2.0
        return levels.guide_bottom_z + half, levels.guide_top_z - half

    @dimensions
    def axle(self) -> AxleDims:
        """Fixed axle of the guide between bearing shelf and top plate, with the spacer above the upper bearing."""
        v, bearing = self.levels, self.drive.bearings.guide
        return AxleDims(
            radius=bearing.bore_mm / 2,
            bottom_z=v.bearing_shelf_bottom_z,
            top_z=v.top_plate_top_z,
            collar_radius=bearing.inner_shoulder_mm / 2,
            collar_bottom_z=v.bearing_shelf_top_z,
            collar_top_z=v.guide_bottom_z,
            spacer_bottom_z=v.guide_top_z,
            spacer_top_z=v.top_plate_bottom_z,
        )

    @dimensions
    def frame(self) -> FrameDims:
        """The frame."""
        return frame(self.drive, self.levels)

    @dimensions
    def top_plate(self) -> TopPlateDims:
        """The plate that carries the upper bearings."""
        return top_plate(self.drive, self.levels)

    @property
    def steps_before_drum(self) -> tuple[tuple[float, float], ...]:
        """See the base class."""
        guide = self.guide
        return tuple(zip(guide.surface_radii, (guide.bottom_z, *guide.walls_z), strict=True))

    @property
    def encoder_plate_mm(self) -> float:
        """See the base class."""
        return self.drive.encoder_plate_mm

    @property
    def levels_sense(self) -> int:
        """See the base class."""
        return -1 if self.drive.motors_above else 1

    @property
    def input_levels(self) -> Stack:
        """See the base class."""
        return self.levels.from_gearhead

    @property
    def slips_on_passed(self) -> bool:
        """See the base class."""
        return self.drive.guide_slips


LAYOUT = BevelLayout
