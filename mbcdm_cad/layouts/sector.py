"""What layouts share whose cables end on a drum sector, and those of them that have motor heads."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Sequence
from functools import cached_property
from math import degrees, radians, tau
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from mbcdm_cad.layouts.base import Layout, dimensions
from mbcdm_cad.model.losses import BearingPair, body_bearings
from mbcdm_cad.parts.coupling import CollarDims, StageDims, collar, collar_width_mm
from mbcdm_cad.parts.drum_sector.design import InputLevels, SectorDrive, SectorRun
from mbcdm_cad.parts.drum_sector.dims import DrumDims
from mbcdm_cad.parts.drum_sector.sizes import TerminalWay, drum, drum_shaft, furthest_anchor_rad, preload_spring
from mbcdm_cad.parts.fits import MOUNT_SCREWS, MountScrew, MountThread
from mbcdm_cad.parts.input_pulley.dims import ENCODER_INSERTION_MM, GROOVE_RADIUS, JOURNAL_SLIT_MM, InputPulleyDims
from mbcdm_cad.parts.motor_head.dims import DOWEL_MM, HeadDims, dowel_length_mm, flange_screw
from mbcdm_cad.parts.terminal import Tensioner, terminal_travel_mm
from mbcdm_cad.parts.turned import DrumShaftDims, PreloadSpringDims
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.curves import CablePath, CableWraps, over_travel
from mbcdm_cad.routes.route import input_body

if TYPE_CHECKING:
    from mbcdm_cad.design.bought import Material
    from mbcdm_cad.model.si import DriveSI


# Thread of the encoder's screws in its housing, in diameters.
ENCODER_GRIP = 1.25


def coupled_pulley(drive: SectorDrive, levels: InputLevels, **own: Any) -> InputPulleyDims:
    """An input pulley between gearhead and encoder, along the input's levels: journals in its bearings, bore and slit.

    ``own``: its lands, necks and slots, and what is another than of a shaft in a slit journal.
    """
    lower, upper, gear = drive.bearings.input_lower, drive.bearings.input_upper, drive.gearhead
    bottom = levels.motor_shelf_top_z + drive.screw(gear.screw).head_height_mm + 0.5
    journals = {
        "journal_bottom_z": bottom,
        "lower_journal_radius": lower.bore_mm / 2,
        "lower_neck_bottom_z": levels.bearing_shelf_top_z,
        "upper_neck_top_z": levels.upper_neck_top_z,
        "upper_journal_radius": upper.bore_mm / 2,
        "journal_top_z": levels.top_plate_top_z + ENCODER_INSERTION_MM,
        "bore_radius": gear.shaft_diameter_mm / 2,
        "bore_top_z": levels.motor_shelf_bottom_z + gear.shaft_length_mm + 0.5,
        "slit_width": JOURNAL_SLIT_MM,
        "slit_top_z": bottom + collar_width_mm(drive) + 1.0,
    }
    return InputPulleyDims(**journals | own)


def head_frame(drive: SectorDrive) -> dict[str, Any]:
    """The fields of :class:`~mbcdm_cad.parts.motor_head.dims.HeadFrameDims` that follow from bearing, encoder
    and screws alone, by their names.
    """
    upper, encoder, screw = drive.bearings.input_upper, drive.encoder, flange_screw(drive)
    encoder_screw, insert = drive.screw(encoder.screw), drive.insert(drive.frame_material, screw.thread_mm)
    beside = drive.support.encoder_shelf_mm - encoder_screw.length_mm
    return {
        "seat_radius": upper.outer_diameter_mm / 2,
        "seat_depth": upper.width_mm,
        "seat_shoulder_radius": upper.outer_shoulder_mm / 2,
        "encoder_screw_clearance": encoder_screw.clearance_mm / 2,
        "encoder_head_radius": encoder_screw.head_diameter_mm / 2 + 0.1,
        "encoder_head_depth": beside + ENCODER_GRIP * encoder_screw.thread_mm,
        "encoder_circle_radius": encoder.bolt_circle_mm / 2,
        "stop_pin_radius": drive.drum.stop_pin_mm / 2 if drive.stopped else 0.0,
        "flange_screw_radius": (insert.hole_mm if insert else screw.thread_mm) / 2,
        "flange_insert": insert,
        "dowel_radius": DOWEL_MM / 2,
        "dowel_depth": dowel_length_mm(drive) - drive.support.bearing_shelf_mm + 0.5,
    }


class SectorLayout(Layout):
    """A design with a drum sector, its terminals, and an input pulley in two bearings for each input."""

    drive: SectorDrive
    # The part that the drum turns in front of.
    frame_name: ClassVar[str] = "frame"
    # The body on which the cables run before the drum.
    before_drum: ClassVar[str] = "input pulley"

    def __init__(self, drive: SectorDrive, **given: Any) -> None:
        super().__init__(drive, **given)
        # The cables in the order of their steps.
        self.steps: tuple[SectorRun, ...] = tuple(sorted(drive.cables, key=lambda cable: cable.step))

    @property
    def mounting(self) -> MountScrew:
        """The screw that holds the frame on what it is mounted on."""
        return MOUNT_SCREWS[self.drive.support.mount_screw]

    @property
    def mount_washers(self) -> bool:
        """Whether washers are under the heads of these screws."""
        return False

    @property
    def mount_thread(self) -> MountThread | None:
        """Their thread in the frame; None where their heads lie on it."""
        return None

    @property
    def softer_ends(self) -> float:
        """See the base class; the longest cable is softest by itself, so that a spring adds least to it."""
        if self.drive.anchor_m_N == 0.0:
            return 1.0
        longest = max(self.tensioned_lengths_mm()) * 1e-3
        return 1.0 + self.drive.anchor_m_N * self.drive.cable.axial_stiffness_N / longest

    @property
    def printed_frame(self) -> bool:
        """See the base class."""
        return self.frame_material.printed

    @property
    def frame_material(self) -> Material:
        """See the base class."""
        found: Material = self.drive.frame_material
        return found

    @property
    @abstractmethod
    def levels(self) -> InputLevels:
        """Heights and depths."""

    @cached_property
    def terminal_way(self) -> TerminalWay:
        """Take-up of all terminals, and the part of it that each uses, mm, for cables anchored as far out as possible.

        Raises ValueError where a cable has no way.
        """
        longest, furthest = self.module("cable_path").longest_mm, furthest_anchor_rad(self.drive)
        return terminal_travel_mm(self.drive, {c.name: longest(self.drive, c, furthest) for c in self.drive.cables})

    @property
    def stop_pin_z(self) -> float:
        """Height of the stop pin over the drum's axis."""
        return float(self.frame.stop_pin_z)

    @dimensions
    def drum(self) -> DrumDims:
        """Drum sector."""
        return drum(self.drive, self.levels, self.stop_pin_z, self.terminal_way)

    @dimensions
    def drum_shaft(self) -> DrumShaftDims:
        """Shaft of the drum."""
        return drum_shaft(self.drive, self.levels)

    @dimensions
    def preload_spring(self) -> PreloadSpringDims:
        """Wave spring of the drum's bearings."""
        return preload_spring(self.drive, self.drum_shaft)

    @property
    @abstractmethod
    def inputs(self) -> tuple[InputPulleyDims, ...]:
        """The input pulleys, in the order of the design's inputs."""

    @dimensions
    def collar(self) -> CollarDims:
        """Clamp collar of each input pulley."""
        return collar(self.drive, self.input_levels.motor_shelf_top_z)

    @property
    def stage(self) -> StageDims | None:
        """Belt or gears between motor and input, of a layout that has room for them."""
        return None

    @property
    @abstractmethod
    def frame(self) -> Any:
        """The frame."""

    @property
    @abstractmethod
    def steps_before_drum(self) -> tuple[tuple[float, float], ...]:
        """(surface radius, lowest height along Z) of the steps of that body, mm."""

    @property
    def motor_shelf_mm(self) -> float:
        """Thickness of the shelf that carries a gearhead."""
        return float(self.drive.support.motor_shelf_mm)

    @property
    def encoder_plate_mm(self) -> float:
        """Thickness of the plate that carries an input's encoder."""
        return float(self.drive.support.encoder_shelf_mm)

    def groove_ratio(self, body: str) -> float | None:
        """See the base class."""
        on_input = any(body == input_body(name) for name in self.drive.input_names)
        return GROOVE_RADIUS if on_input and self.drive.input_pulleys.grooved else None

    @property
    def terminals(self) -> tuple[Tensioner, ...]:
        """Terminals of all cables, in the order of the design's cables."""
        return self.drum.tensioners

    @property
    def levels_sense(self) -> int:
        """+1 if the levels are measured along the axes of the inputs' routes, -1 if against them."""
        return 1

    @property
    def input_levels(self) -> InputLevels:
        """Heights along an input's axis from its gearhead to its encoder, as the dimensions of its pulley have them."""
        return self.levels

    @property
    def hubs_in_line(self) -> int:
        """Number of equal sectors, hub bonded on hub, of which the last one's face is the output."""
        return 1

    def levels_of(self, index: int) -> InputLevels:
        """Heights along the axis of the input with this index; here all inputs have the same."""
        return self.input_levels

    def input_bearings_mm(self, index: int) -> tuple[float, float]:
        """Middles of the bearings next to the gearhead and to the encoder of an input, in its levels."""
        levels, bearings = self.levels_of(index), self.drive.bearings
        return (
            levels.bearing_shelf_top_z - bearings.input_lower.width_mm / 2,
            levels.top_plate_bottom_z + bearings.input_upper.width_mm / 2,
        )

    @property
    def drum_bearings_mm(self) -> tuple[float, float]:
        """Middles of the drum's rear and front bearings along its axis."""
        shaft, half = self.drum_shaft, self.drive.bearings.drum.width_mm / 2
        return shaft.rear_bearing_y + half, shaft.front_bearing_y + half

    def anchor_rad(self, cable: SectorRun) -> float:
        """Drum angle in rad at which the cable leaves its land, drum centred."""
        return float(self.terminal_of(cable).anchor_rad)

    def terminal_of(self, cable: SectorRun) -> Tensioner:
        """The terminal that a cable ends in."""
        return next(t for t in self.terminals if t.cable_name == cable.name)

    def tensioned_lengths_mm(self) -> Sequence[float]:
        """Length in mm that each terminal tensions, drum centred, in the order of the design's cables."""
        return [path.length_mm for path in self.cable_paths(0.0)]

    def input_wrap_rad(self, cable: SectorRun, drum_angle_rad: float) -> float:
        """Wrap of a cable on its input at a drum angle."""
        return float(self.module("cable_path").input_wrap_rad(self.drive, cable, drum_angle_rad))

    @property
    def most_wrap_rad(self) -> float:
        """Largest wrap that can lie on the drum."""
        return tau

    def wraps_rad(self, drum_angle_rad: float) -> tuple[Floats, Floats]:
        """See the base class."""
        cables = self.drive.cables
        on_input = [self.input_wrap_rad(c, drum_angle_rad) for c in cables]
        on_drum = [self.anchor_rad(c) + c.drum_side * drum_angle_rad for c in cables]
        return np.maximum(on_input, 0.0), np.clip(on_drum, 0.0, self.most_wrap_rad)

    def smallest_wrap_rad(self, cable: SectorRun) -> float:
        """Wrap on the drum, rad, at the end of travel at which most of it is unwound."""
        return self.anchor_rad(cable) - self.half_travel_rad

    def bends_mm(self) -> Sequence[tuple[str, str, float]]:
        """See the base class: each body of a cable's route."""
        found = self.routes_in(1.0).routes
        routes = {route.cable: route for route in found.cables}
        inputs = {body.name: "input pulley" for body in found.inputs}
        return [(c.name, inputs.get(w.body, w.body), w.radius_m) for c in self.steps for w in routes[c.name].wraps]

    def cable_paths(self, drum_angle_rad: float) -> tuple[CablePath, ...]:
        """Centre lines of all cables at a drum angle, from the stop in the pulley to the bottom of the swage's bore."""
        path, ends = self.module("cable_path").cable_path, [(c, self.terminal_of(c)) for c in self.drive.cables]
        return tuple(path(self.drive, c, t.anchor_rad, t.cable_end, drum_angle_rad) for c, t in ends)

    def bearing_friction(self, d: DriveSI) -> Iterable[BearingPair]:
        """See the base class."""
        self.require_geometry()
        routes, bearings = d.routes, self.drive.bearings
        ends, both = (bearings.input_lower, bearings.input_upper), (bearings.drum, bearings.drum)
        for i, body in enumerate(routes.inputs):
            lower, upper = (z * self.levels_sense for z in self.input_bearings_mm(i))
            yield body_bearings(d, body, "input pulleys' bearings", ends, (lower, upper), input_index=i)
        yield body_bearings(d, routes.drum, "drum's bearings", both, self.drum_bearings_mm, self.preload_spring.force_N)
        yield from (pair for each in self.attachments for pair in each.bearings(d))

    @cached_property
    def extreme_paths(self) -> tuple[tuple[float, tuple[CablePath, ...]], ...]:
        """Cable paths at one end of travel, centred, and at the other end, with the drum angles in rad."""
        half = self.half_travel_rad
        return tuple((angle, self.cable_paths(angle)) for angle in (-half, 0.0, half))


class HeadLayout(SectorLayout):
    """A design with a motor head for each input."""

    drive: SectorDrive

    @property
    @abstractmethod
    def head(self) -> HeadDims:
        """Motor head."""


def wraps_over_travel(layout: SectorLayout) -> tuple[tuple[float, ...], tuple[CableWraps, ...]]:
    """``STATIONS`` drum angles (deg) evenly over the travel, and each cable or side at them; sides share a path."""
    drive = layout.drive
    angles, posed = over_travel(layout.cable_paths, drive.half_travel_deg)
    centred = layout.cable_paths(0.0)
    share = len(centred) / len(drive.cables)
    return angles, tuple(
        CableWraps(
            name=run.name,
            length_mm=centred[k].length_mm * share,
            input_wrap_deg=tuple(degrees(layout.input_wrap_rad(run, radians(a))) for a in angles),
            drum_wrap_deg=tuple(degrees(layout.anchor_rad(run)) + run.drum_side * a for a in angles),
            length_um=tuple((paths[k].length_mm - centred[k].length_mm) * 1e3 for paths in posed),
        )
        for k, run in ((j * len(centred) // len(drive.cables), run) for j, run in enumerate(drive.cables))
    )


def key(layout: SectorLayout, screw: str) -> str:
    """The key that fits a screw, for instructions."""
    return f"{layout.drive.screw(screw).key_mm:g} mm key"
