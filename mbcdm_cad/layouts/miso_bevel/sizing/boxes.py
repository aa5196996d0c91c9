"""Coupling boxes of motors above, as far as they are known before the frame is."""

from __future__ import annotations

from dataclasses import dataclass

from mbcdm_cad.design.bought import Gearhead, Material, Motor, Screw
from mbcdm_cad.design.sector_blocks import Clearances
from mbcdm_cad.layouts.miso_bevel.plate_screws import HEAD_PLAY_MM, PLATE_SCREWS
from mbcdm_cad.layouts.miso_bevel.sizing.known import BevelKnown
from mbcdm_cad.parts.motor_head.dims import outer_half_width_mm
from mbcdm_cad.sizing.rule import Found, largest


@dataclass(frozen=True)
class _Walls:
    side_wall_mm: float


@dataclass(frozen=True)
class _Boxed:
    """What is known of a drive that the width of its coupling boxes depends on."""

    gearhead: Gearhead
    motor: Motor
    clearances: Clearances
    support: _Walls
    frame_material: Material
    collar_seat: tuple[float, float, str]
    screws: dict[str, dict[str, object]]
    stage: None = None

    def screw(self, name: str) -> Screw:
        return Screw(name=name, **self.screws[name])  # type: ignore[arg-type]


def side_wall(given: BevelKnown) -> Found:
    """Thickness of the side walls, mm, with its driver."""
    sunk = given.screw(PLATE_SCREWS[0]).head_diameter_mm + 2 * HEAD_PLAY_MM
    needs = {"side_wall": sunk + 2 * given.wall_mm("support")}
    insert = given.insert("support", given.screw(PLATE_SCREWS[0]).thread_mm)
    if insert is not None:
        needs["top plate's inserts"] = insert.hole_mm + 2 * insert.wall_mm
    return raised(given, needs)


def raised(given: BevelKnown, needs: dict[str, float]) -> Found:
    """The largest of the needs of a wall, mm, or more of it where the frame would bend too much."""
    stiff = {"frame_windup": given.frame.shelves * max(needs.values())} if given.frame.shelves > 1.0 else {}
    return largest({**needs, **stiff}, 0.1)


def box_mm(given: BevelKnown) -> float:
    """Half the width of a coupling box, and its reach to the back."""
    metal = Material(name="", **given.entry("materials", "support.material"))
    journal = given.entry("bearings", "input_pulleys.lower_bearing")["bore_mm"]
    wall = given.get("support.side_wall_mm")
    return outer_half_width_mm(
        _Boxed(
            gearhead=given.gearhead,
            motor=Motor(name="", **given.entry("motors", "drive.motor")),
            clearances=Clearances(land_edge_mm=0.0, running_mm=given["clearances.running_mm"]),
            support=_Walls(side_wall(given).value if wall is None else wall),
            frame_material=metal,
            collar_seat=(journal, given.wall_mm("support"), given["input_pulleys.collar_screw"]),
            screws=given.entries("screws"),
        )
    )
