"""Dimensions of the idlers, of their axles, and of posts and strap that hold the axles' front ends.

In section through the axis of a pair, y to the right (front), z up; the cables come down between the two idlers:

     plate      post            strap
      | |=======================| |
      | |  collar               | |
      |=|===| idler      |=====||=|  axle
      | |                       | |
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from mbcdm_cad.design.bought import Screw
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive, SpurRun
from mbcdm_cad.layouts.siso_spur.idlers import flange_radius_mm, idler_body
from mbcdm_cad.layouts.siso_spur.stack import FLANGE_MM, SpurStack
from mbcdm_cad.model.inertia import disc_kg_m2
from mbcdm_cad.parts.axle import AxleDims
from mbcdm_cad.parts.idler_pulley import IdlerDims

# Gap between the spacer on an axle and the strap.
END_PLAY_MM = 0.1
# Depth and least width of a post in diameters of its screw: the wall round the thread.
POST_DIAMETERS = 2.4
# Strap beside the bores of the axles, in their diameters.
STRAP_WALL = 1.0


@dataclass(frozen=True)
class StandDims:
    """Posts, which are part of the frame, and strap of one pair of idlers where they stand in the assembly; mm."""

    x: float  # of the axle at +x
    z: float
    axle_radius: float
    post_x: tuple[float, float]  # of the post at +x
    post_z: tuple[float, float]
    front_y: float  # of the plate
    strap_back_y: float
    strap_front_y: float
    half_width: float  # of the strap
    low_z: float
    thread_radius: float
    thread_depth: float
    clearance_radius: float

    @property
    def screw_x(self) -> float:
        """Axis of the screw in the post at +x."""
        return (self.post_x[0] + self.post_x[1]) / 2

    @property
    def screw_z(self) -> float:
        """Axis of the screws."""
        return (self.post_z[0] + self.post_z[1]) / 2


def idlers(drive: SpurDrive) -> Iterator[tuple[str, IdlerDims, tuple[SpurRun, int]]]:
    """Each idler: its body in the routes, its dimensions along y, its cable and its number from 0 on."""
    for n, level in enumerate(drive.idler_levels_mm):
        for cable in drive.cables:
            middle = drive.level_mm + cable.outward * level
            yield idler_body(n + 1, cable.name), idler(drive, middle), (cable, n)


def idler(drive: SpurDrive, middle_mm: float) -> IdlerDims:
    """Idler with flanges whose middle is at ``middle_mm`` along y."""
    block, bearing = drive.leading, drive.idler_bearing
    d, half = drive.cable.diameter_mm, block.width_mm / 2
    flange = flange_radius_mm(block.radius_mm, d)
    return IdlerDims(
        bottom_z=middle_mm - half - FLANGE_MM,
        top_z=middle_mm + half + FLANGE_MM,
        surface_radii=(flange, block.radius_mm - d / 2, flange),
        walls_z=(middle_mm - half, middle_mm + half),
        seat_radius=bearing.outer_diameter_mm / 2,
        seat_depth=bearing.width_mm,
        shoulder_radius=bearing.outer_shoulder_mm / 2,
    )


def strap_screw(drive: SpurDrive) -> Screw:
    """Screw of a strap: of the thread that mounts the frame, the shortest that engages by its diameter."""
    thread = drive.screw(drive.support.mount_bolt).thread_mm
    long = [s for s in drive.screws if s.thread_mm == thread and s.head_height_mm > 0.0]
    needed = drive.support.encoder_shelf_mm + thread
    return min(long, key=lambda s: (s.length_mm < needed, abs(s.length_mm - needed)))


def stands(drive: SpurDrive, levels: SpurStack) -> tuple[StandDims, ...]:
    """Posts and straps of all pairs, from the input on."""
    if drive.idlers is None:
        return ()
    block, bearing = drive.idlers, drive.idler_bearing
    d, running, screw = drive.cable.diameter_mm, drive.clearances.running_mm, strap_screw(drive)
    flange, wide = flange_radius_mm(block.radius_mm, d), POST_DIAMETERS * screw.thread_mm
    found = []
    for place, level in zip(block.places, drive.idler_levels_mm, strict=True):
        back = drive.level_mm + abs(level) + block.width_mm / 2 + FLANGE_MM + END_PLAY_MM + running
        # Beside the cables, which run between the posts towards the input.
        inner = max(abs(place.x_mm - block.radius_mm), drive.input_radius_mm) + d / 2 + 2 * running
        outer = max(place.x_mm + flange, inner + wide)
        low = place.z_mm + flange + running
        found.append(
            StandDims(
                x=place.x_mm,
                z=place.z_mm,
                axle_radius=bearing.bore_mm / 2,
                post_x=(inner, outer),
                post_z=(low, low + wide),
                front_y=levels.front_y,
                strap_back_y=back,
                strap_front_y=back + drive.support.encoder_shelf_mm,
                half_width=outer,
                low_z=place.z_mm - (0.5 + STRAP_WALL) * bearing.bore_mm,
                thread_radius=screw.thread_mm / 2,
                thread_depth=screw.length_mm - drive.support.encoder_shelf_mm + 0.5 * screw.thread_mm,
                clearance_radius=screw.clearance_mm / 2,
            )
        )
    return tuple(found)


def axle(drive: SpurDrive, stand: StandDims, levels: SpurStack, own: IdlerDims) -> AxleDims:
    """Axle of one idler from the back of the plate to the front of the strap, with collar and spacer."""
    bearing = drive.idler_bearing
    return AxleDims(
        radius=stand.axle_radius,
        bottom_z=levels.plate_back_y,
        top_z=stand.strap_front_y,
        collar_radius=bearing.inner_shoulder_mm / 2,
        collar_bottom_z=levels.front_y,
        collar_top_z=own.bottom_z,
        spacer_bottom_z=own.top_z,
        spacer_top_z=stand.strap_back_y - END_PLAY_MM,
    )


def idler_inertia_kg_m2(drive: SpurDrive, own: IdlerDims) -> float:
    """Inertia of one idler about its axis, bored for its bearings over the whole length, kg m2."""
    ends = (own.bottom_z, *own.walls_z, own.top_z)
    density = drive.drum_material.density_g_cm3
    return sum(
        disc_kg_m2(density, high - low, radius, own.seat_radius)
        for radius, low, high in zip(own.surface_radii, ends[:-1], ends[1:], strict=True)
    )
