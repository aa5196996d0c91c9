"""The layout of Fig. 1 (a): one input beside the drum, one cable round it with crossed or open spans to the drum."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property, partial
from math import atan2, ceil, degrees, floor, hypot, inf, pi, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from mbcdm_cad.checks import design_variables as dv
from mbcdm_cad.checks.fixings import STRESS_SAFETY
from mbcdm_cad.layouts.base import Conventions, dimensions
from mbcdm_cad.layouts.sector import HeadLayout
from mbcdm_cad.layouts.siso_spur.cable_path import cable_paths, longest_mm, side_length_mm
from mbcdm_cad.layouts.siso_spur.drive import MOST_SPREAD, PITCH_SPREAD, SpurDrive, SpurRun, laid, spur
from mbcdm_cad.layouts.siso_spur.first_stage import FirstStageUnit
from mbcdm_cad.layouts.siso_spur.idlers import Idler, Idlers, idlers
from mbcdm_cad.layouts.siso_spur.pulley import BeltOrGears, ServoHorn, input_pulley
from mbcdm_cad.layouts.siso_spur.routes import DISTANCE, IDLER_RADIUS, SpurGeometry, no_strand
from mbcdm_cad.layouts.siso_spur.schema import IdlerBlock, YokeSupport
from mbcdm_cad.layouts.siso_spur.support import SpurStack, YokeDims, flange, spur_stack, yoke
from mbcdm_cad.parts import coupling, making
from mbcdm_cad.parts.drum_sector.design import SectorRun
from mbcdm_cad.parts.drum_sector.dims import SET_SCREW_ANGLES_DEG, DrumDims, HubDowels
from mbcdm_cad.parts.drum_sector.sizes import TerminalWay, drum, furthest_anchor_rad
from mbcdm_cad.parts.fits import SHEAR_SHARE, MountThread
from mbcdm_cad.parts.input_pulley.dims import InputPulleyDims
from mbcdm_cad.parts.motor_head.dims import Flange, HeadDims, head
from mbcdm_cad.parts.terminal import Tensioner, tensioned_rope, terminal_travel_mm
from mbcdm_cad.parts.turned import DrumShaftDims
from mbcdm_cad.routes.curves import CablePath, turned_about_y
from mbcdm_cad.routes.route import DRUM_RADIUS, INPUT_RADIUS, RoutedDrive

if TYPE_CHECKING:
    from mbcdm_cad.model.si import DriveSI
    from mbcdm_cad.parts.milled import Milled


# Least turn of a nut that a spanner sets: a quarter of a flat (estimate).
NUT_TURN = 1.0 / 24.0
# Dowels between the hubs, beside the payload's threads: radii, depth in a face over the radius, play at their ends.
DOWEL_RADII_MM, DOWEL_RADII, DOWEL_PLAY_MM = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0), 3.0, 0.5
# Opposite the set screws.
_FACE_DEG = (225.0, 315.0)


def _turns(drive: SpurDrive, value: float) -> SpurDrive:
    return replace(drive, turns=max(1, round(value)))


def _belt_teeth(drive: SpurDrive, value: float) -> SpurDrive:
    assert drive.stage is not None
    return replace(drive, stage=replace(drive.stage, belt_teeth=round(value)))


def _with_lands(variable: dv.DesignVariable) -> dv.DesignVariable:
    """The design variable; a drive with a new value gets new planes of its terminals."""
    return variable._replace(put=lambda drive, value: laid(spur(variable.put(drive, value))))


VARIABLES: dict[str, dv.DesignVariable] = dv.by_path(
    _with_lands(variable)
    for variable in (
        *dv.SHARED,
        dv.radii(dv.ALL_RADII, ("drum_radius_mm", "input_radius_mm")),
        dv.radii("transmission.input_radius_mm", ("input_radius_mm",))._replace(applies=lambda d: d.radii_explicit),
        dv.INPUT_TO_DRUM,
        dv.field("transmission.centre_distance_mm", "centre_distance_mm"),
        dv.DesignVariable("transmission.turns", lambda drive: float(drive.turns), _turns),
        dv.field("rope.helix_lead_mm", "helix_lead_mm"),
        dv.field("clearances.land_edge_mm"),
        *dv.DRUM,
        *dv.lengths("support", YokeSupport),
        dv.field("stage.width_mm")._replace(applies=lambda d: d.stage is not None),
        dv.DesignVariable(
            "stage.belt_teeth",
            lambda drive: float(drive.stage.belt_teeth),
            _belt_teeth,
            applies=lambda d: d.stage is not None and d.stage.is_belt,
        ),
        *(one._replace(applies=lambda d: d.idlers is not None) for one in dv.lengths("idlers", IdlerBlock)),
    )
)


class SpurLayout(HeadLayout):
    """One design; heights of pulley and collar are along +Y.

    The drum is that of a cable at level 0, for any ``level_mm`` of the drive. Of several sectors, which are equal, it
    is the first, ``steps`` are the runs on it, and most checks use it. A unit is a layout inside this one: of one of
    its cables (``units``, the first of them ``unit``), of one of its inputs, or of its first stage.
    """

    name = "siso_spur"
    title = "one input beside the drum, one cable round it, axes parallel (Fig. 1 a)"
    variables = VARIABLES
    takes = (Idlers, BeltOrGears, ServoHorn, FirstStageUnit)
    frame_name = "plate"
    levels_sense = -1
    conventions = Conventions(
        frame="Frame: origin on the drum axis (Y), in the middle of the cable; the input stands at +Z; lengths in mm.",
        cables="The cable is a round rod at the nominal diameter; its turns walk along the input as the drum turns.",
    )

    drive: SpurDrive
    steps: tuple[SpurRun, ...]

    def __init__(self, drive: SpurDrive, **given: Any) -> None:
        super().__init__(drive, **given)
        self.steps = tuple(cable for cable in self.steps if cable in drive.cables[:2])

    @cached_property
    def unit(self) -> SpurLayout:
        """The first cable with its sector and its input, as a drive of one cable."""
        unit = self.drive.unit(0)
        return self if unit is self.drive else SpurLayout(unit)

    @dimensions
    def units(self) -> tuple[SpurLayout, ...]:
        """Each cable with its sector as a drive of one cable, the input above the drum; few checks need them."""
        return self.unit, *(SpurLayout(self.drive.unit(k)) for k in range(1, len(self.drive.angles_rad)))

    def routes_in(self, unit: float) -> RoutedDrive:
        """See the base class."""
        drive = self.drive
        geometry = SpurGeometry(
            cable_names=tuple(run.name for run in drive.cables),
            input_names=tuple(drive.input_names),
            input_of=tuple(drive.input_names.index(run.input_name) for run in drive.cables),
            angle_rad=drive.angles_rad[: len(drive.input_names)],
            level_m=tuple((drive.level_mm + level) * unit for level in drive.levels_mm),
            drum_side=tuple(run.drum_side for run in drive.cables),
            outward=tuple(run.outward for run in drive.cables),
            turns=drive.turns,
            lead_m=drive.helix_lead_mm * unit,
            apart_m=drive.leave_mm * unit if drive.anchored else None,
            idlers=tuple((p.x_mm * unit, p.z_mm * unit) for p in drive.idler_places),
            input_sense=drive.input_sense,
        )
        parameters = {
            INPUT_RADIUS: np.array([run.input_radius_mm * unit for run in drive.cables]),
            DRUM_RADIUS: np.array([run.drum_radius_mm * unit for run in drive.cables]),
            DISTANCE: np.asarray(drive.centre_distance_mm * unit),
        }
        if drive.idlers:
            parameters[IDLER_RADIUS] = np.full(len(drive.cables), drive.idlers.radius_mm * unit)
        return RoutedDrive(geometry, parameters, {"centre_distance_mm": drive.centre_distance_mm})

    @property
    def input_units(self) -> tuple[SpurLayout, ...]:
        """Each input with its cable and sector as a drive of this layout, the input above the drum."""
        return (self,)

    def refuse_impossible(self) -> None:
        """Refuses pulleys that overlap."""
        self.unit.terminal_way  # noqa: B018 - raises where there is none

    @cached_property
    def terminal_way(self) -> TerminalWay:
        """Take-up of the terminals. Raises ValueError for pulleys that overlap."""
        drive = self.drive
        if drive.free_span_mm <= 0.0 and drive.idlers:
            raise ValueError(no_strand(drive.strand))
        if drive.free_span_mm <= 0.0:
            reach = drive.drum_radius_mm + drive.input_radius_mm
            raise ValueError(
                f"centre distance {drive.centre_distance_mm:g} mm does not exceed r_o + r_i = {reach:.4g} mm; raise "
                "transmission.centre_distance_mm"
            )
        longest = longest_mm(drive, furthest_anchor_rad(drive))
        return terminal_travel_mm(drive, {c.name: longest for c in drive.cables})

    @cached_property
    def levels(self) -> SpurStack:
        """Levels along Y, at the first of several inputs."""
        return spur_stack(self.drive)

    def levels_of(self, index: int) -> SpurStack:
        """See the base class."""
        return self.input_units[index].levels

    @dimensions
    def drum(self) -> DrumDims:
        """One drum sector."""
        if self.unit is self:
            drive = self.drive
            level = drive if drive.level_mm == 0.0 else laid(replace(drive, level_mm=0.0))
            return drum(level, self.levels, self.frame.stop_pin_z, self.terminal_way)
        return replace(self.unit.drum, dowels=_dowels(self.drive, self.unit.drum))

    @property
    def hubs_in_line(self) -> int:
        """See the base class."""
        return len(self.drive.angles_rad)

    @dimensions
    def dowels(self) -> HubDowels:
        """Dowels between neighbouring hubs."""
        assert self.drum.dowels is not None
        return self.drum.dowels

    @dimensions
    def inputs(self) -> tuple[InputPulleyDims, ...]:
        """The input pulleys; each is longer by the distance of its cable from the first along the drum's axis."""
        return tuple(input_pulley(unit.drive, unit.levels) for unit in self.input_units)

    @dimensions
    def drum_shaft(self) -> DrumShaftDims:
        """Shaft of the drum, with the end that stands out behind the frame, if it has one.

        It ends in the last hub, whose set screws hold all of them.
        """
        shaft, (near, far) = super().drum_shaft, SET_SCREW_ANGLES_DEG
        last, turned = self.drive.levels_mm[-1], degrees(self.drive.angles_rad[-1])
        return replace(
            shaft,
            y_start=shaft.y_start - self.drive.drum.shaft_end_mm,
            y_end=shaft.y_end + last,
            flat_y=shaft.flat_y + last,
            flat_angles_deg=(near + turned, far + turned),
        )

    @dimensions
    def collar(self) -> coupling.CollarDims:
        """Clamp collar of the pulley."""
        drive, stage = self.drive, self.stage
        found = coupling.collar(drive, self.levels.motor_shelf_top_z)
        if stage is None:
            return found
        # On the hub of the driven wheel.
        bottom = stage.top_z + coupling.HUB_EDGE_MM
        return replace(found, bottom_z=bottom, top_z=bottom + found.top_z - found.bottom_z)

    @dimensions
    def stage(self) -> coupling.StageDims | None:
        """Belt or gears between motor and input; None without."""
        drive = self.drive
        if drive.stage is None:
            return None
        return coupling.stage_dims(
            drive.stage,
            self.levels.motor_shelf_top_z + coupling.collar_over_shelf_mm(drive),
            drive.bearings.input_lower.bore_mm,
            coupling.collar_width_mm(drive),
            drive.gearhead.shaft_diameter_mm,
        )

    @dimensions
    def frame(self) -> YokeDims:
        """The frame: boss, and the arm at the first input."""
        first = self.input_units[0]
        return yoke(first.drive, self.levels, self.drum_shaft, self._flange)

    @property
    def frame_part(self) -> Milled:
        """The frame with the arms of all inputs, as a part."""
        from mbcdm_cad.layouts.siso_spur.support.parts import Yoke

        return Yoke(self.frame)

    @dimensions
    def head(self) -> HeadDims:
        """Motor head."""
        return head(self.drive, self.levels, self._flange)

    @cached_property
    def _flange(self) -> Flange:
        return flange(self.drive)

    def input_bearings_mm(self, index: int) -> tuple[float, float]:
        """See the base class; of a pulley on the motor's shaft those of the shaft, the front one at its face.

        A servo's front bearing is at the front of its housing.
        """
        if not self.drive.overhung:
            return super().input_bearings_mm(index)
        servo = self.drive.servo
        face = self.levels_of(index).motor_shelf_bottom_z + (servo.before_mm if servo is not None else 0.0)
        return face - self.drive.gearhead.span_mm, face

    @property
    def mount_thread(self) -> MountThread:
        """See the base class."""
        return MountThread(self.drive.support.plate_mm, self.frame.mount_insert)

    @property
    def anchors(self) -> dict[str, tuple[float, float]]:
        """Angle at which each side leaves its land, drum centred, and straight length from there, by its name."""
        return {t.cable_name: (t.anchor_rad, t.cable_end) for t in self.terminals}

    @property
    def terminals(self) -> tuple[Tensioner, ...]:
        """See the base class."""
        if self.unit is self:
            return self.drum.tensioners
        return tuple(t for unit in self.units for t in unit.drum.tensioners)

    def terminal_of(self, cable: SectorRun) -> Tensioner:
        """See the base class; those of the first cable are known before the others."""
        on_first = (t for t in self.drum.tensioners if t.cable_name == cable.name)
        return next(on_first, None) or super().terminal_of(cable)

    def cable_paths(self, drum_angle_rad: float) -> tuple[CablePath, ...]:
        """Centre line of each cable at a drum angle, to the bottom of the bore of each swage."""
        if self.unit is self:
            return cable_paths(self.drive, self.anchors, drum_angle_rad)
        angles = zip(self.units, self.drive.angles_rad, strict=True)
        paths = tuple(
            path.each(partial(turned_about_y, angle_rad=angle))
            for unit, angle in angles
            for path in unit.cable_paths(drum_angle_rad)
        )
        if self.drive.parallel == 1:
            return paths
        names = zip(paths, self.drive.cable_names, strict=True)
        return tuple(replace(path, cable=replace(path.cable, name=name)) for path, name in names)

    def bends_mm(self) -> Sequence[tuple[str, str, float]]:
        """Input pulley, idlers and drum."""
        name, drive = self.drive.input_names[0], self.drive
        idlers = [(name, "idlers", drive.idlers.radius_mm)] if drive.idlers else []
        return [(name, "input pulley", drive.input_radius_mm), *idlers, (name, "drum", drive.drum_radius_mm)]

    @property
    def steps_before_drum(self) -> tuple[tuple[float, float], ...]:
        """See the base class."""
        pulley = self.inputs[0]
        return ((pulley.lower_surface_radius, pulley.land_bottom_z),)

    def anchor_rad(self, cable: SectorRun) -> float:
        """Wrap on the drum with the drum centred: from where the cable lands to where it leaves its land."""
        return super().anchor_rad(cable) - self.drive.landing_rad

    @dimensions
    def idlers(self) -> tuple[Idler, ...]:
        """Each idler."""
        return tuple(each for unit in self.input_units for each in idlers(unit.drive))

    @dimensions
    def pins(self) -> tuple[Sequence[Idler], ...]:
        """The idlers by the axles on which they turn."""
        by_axle: dict[tuple[int, int], list[Idler]] = {}
        for one in self.idlers:
            by_axle.setdefault((one.cable.drum_side, one.number), []).append(one)
        return tuple(by_axle.values())

    def tensioned_lengths_mm(self) -> Sequence[float]:
        """Length that each terminal tensions: half of the one cable, or its own cable."""
        return [side_length_mm(unit.drive, c, *unit.anchors[c.name]) for unit in self.units for c in unit.drive.cables]

    def as_set(self, si: DriveSI) -> DriveSI:
        """See the base class: of cables in parallel the first is as tight, the last as loose as the spread allows."""
        if self.drive.parallel == 1:
            return si
        off = self.preload_spread
        spread = np.repeat(np.linspace(off, -off, self.drive.parallel), 2)
        return self.once("as set", lambda _: si.with_(preload_N=si.preload_N * (1.0 + spread)))

    @cached_property
    def preload_spread(self) -> float:
        """How far the preloads of parallel cables are to be expected from the stated one, over it, without load.

        Nuts and lands are independent (RSS); a nut is turned until the pitch of the span is right.
        """
        return min(hypot(max(self.by_nut, PITCH_SPREAD), self.by_lands), MOST_SPREAD)

    @cached_property
    def by_nut(self) -> float:
        """What the least turn of a nut changes of a preload, over it; rope and spring give way."""
        rope, pitch_m = tensioned_rope(self.drive), self.drive.tensioner.pitch_mm * 1e-3
        give = min(self.tensioned_lengths_mm()) * 1e-3 / rope.axial_stiffness_N + rope.anchor_m_N
        return NUT_TURN * pitch_m / give / min(c.preload_N for c in self.drive.cables)

    @cached_property
    def by_lands(self) -> float:
        """What lands of unequal radii change of a preload at the end of the travel, over it, after some cycles.

        Cables whose ratios differ wind against each other, since one input and one drum turn them all. What lies on the
        wraps comes back as it went, so that a ratio off by e of the mean stretches the span by all of e R theta
        (derived). Slip takes a part: the wraps' slip zones stretch by a^2 (R + r) / (2 mu) for a change by a of the
        preload (the model's law, small a), of which a third counts, as rope arrives on them with the span's tension
        (fitted to a simulation in cells of rope, which gives 0.8 to 1.2 of the result).
        """
        drive, span = self.drive, self.drive.strand_mm
        strain = self.lands_off * drive.drum_radius_mm * self.half_travel_rad / span
        sticking = drive.cable.axial_stiffness_N * strain / min(c.preload_N for c in drive.cables)
        slip = (drive.drum_radius_mm + drive.input_radius_mm) / (2.0 * drive.friction_coefficient * span) / 3.0
        return 2.0 * sticking / (1.0 + sqrt(1.0 + 4.0 * slip * sticking))

    @cached_property
    def lands_off(self) -> float:
        """How far the ratio of a cable may be from the mean of all, over it."""
        drive = self.drive
        radii = (drive.drum_radius_mm, drive.input_radius_mm)
        drum, pulley = (making.land_band_mm(drive, radii[0], "drum"), making.land_band_mm(drive, radii[1], "pulley"))
        return hypot(drum / radii[0], pulley / radii[1]) * sqrt(1.0 - 1.0 / drive.parallel)

    @property
    def passing_deg(self) -> tuple[float, ...]:
        """See the base class: the studs of a whole drum's terminals at the input, first and last in the travel."""
        half, found = self.drive.half_travel_deg, set[float]()
        for t in self.drum.tensioners if self.drive.whole_drum else ():
            at = -t.side * degrees(t.anchor_rad + atan2(t.tip, t.radius_mm))
            passes = np.arange(ceil((-half - at) / 360.0), floor((half - at) / 360.0) + 1)
            found |= {float(at + 360.0 * k) for k in (passes[0], passes[-1])} if len(passes) else set()
        return tuple(sorted(found.union(*(each.passing_deg for each in self.attachments))))

    @property
    def most_wrap_rad(self) -> float:
        """See the base class; a cable may lie on a whole drum in more than one turn."""
        return inf if self.drive.whole_drum else super().most_wrap_rad


def _dowels(drive: SpurDrive, sector: DrumDims) -> HubDowels:
    """The next sector may be turned about the axis, so its holes are turned back in its own frame."""
    between_deg = 0.0 if drive.parallel > 1 else 360.0 / len(drive.angles_rad)
    circle = sector.payload_circle_radius
    radius, steel = DOWEL_RADII_MM[0], drive.material("steel").yield_MPa
    if drive.parallel > 1:
        force = drive.between_hubs_Nm * 1e3 / circle / len(_FACE_DEG)
        holds = (r for r in DOWEL_RADII_MM if force * STRESS_SAFETY <= SHEAR_SHARE * steel * pi * r**2)
        radius = next(holds, DOWEL_RADII_MM[-1])
    pressed = DOWEL_RADII * radius
    return HubDowels(
        radius=radius,
        length=2 * pressed,
        circle_radius=circle,
        face_depth=pressed,
        # The hub begins behind the spigot, which rests on the face of the next hub.
        back_depth=pressed - (sector.hub_start_y - sector.spigot_y) + DOWEL_PLAY_MM,
        face_angles_deg=_FACE_DEG,
        back_angles_deg=tuple((a - between_deg) % 360.0 for a in _FACE_DEG),
    )


LAYOUT = SpurLayout
