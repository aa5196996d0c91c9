"""Frame: plate with boss, arms and yokes, milled from one block, with bores from behind for drum and inputs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, pi, tan
from typing import TYPE_CHECKING

from mbcdm_cad.layouts.miso_spur.support.dims import StarDims
from mbcdm_cad.layouts.siso_spur.support.parts import (
    Yoke,
    arm_mm3,
    boss_mm3,
    centre_bodies,
    centre_tools,
    frame_holes,
    yoke_bodies,
    yoke_tools,
)
from mbcdm_cad.parts.fits import FITS
from mbcdm_cad.parts.part import MadePart
from mbcdm_cad.parts.shapes import cut, fuse
from mbcdm_cad.parts.sheets.description import CuttingLine, FitLine, Holes, Sheet, Table, X, minus, mm, mm3
from mbcdm_cad.parts.sheets.holes import hole_labels, hole_table, position_table

if TYPE_CHECKING:
    import cadquery as cq


# Holes that exist once, about the drum's axis.
_IN_THE_MIDDLE = "EH"
_FROM_BEHIND = "ABCDEH"


def _holes(d: StarDims) -> tuple[Holes, ...]:
    """The holes of all arms, with the letters of the first arm."""
    groups = []
    for alike in zip(*(frame_holes(arm) for arm in d.arms), strict=True):
        first = alike[0]
        if first.letter not in _IN_THE_MIDDLE:
            places = tuple(
                (x, y, z)
                for k, group in enumerate(alike)
                for (_, y, _), (x, z) in zip(
                    group.places, d.turned(k, tuple((x, z) for x, _, z in group.places)), strict=True
                )
            )
            first = replace(first, places=places)
        groups.append(first)
    return tuple(groups)


def _arms(d: StarDims) -> Table:
    first, rows = d.arms[0], []
    has_shelf = first.motor is None
    for n, (arm, angle) in enumerate(zip(d.arms, d.angles_deg, strict=True), 1):
        v = arm.levels
        back = v.plate_back_y
        shelf = (mm3(v.top_plate_bottom_z - back), mm3(v.top_plate_top_z - back)) if has_shelf else ()
        rows.append((str(n), mm(angle), *shelf, *(mm3(stand.strap_back_y - back) for stand in arm.stands)))
    posts = tuple(f"posts {n} to" for n in range(1, len(first.stands) + 1))
    parts = [*(["the shelf"] if has_shelf else []), *(["the idlers' posts"] if posts else [])]
    title = f"Arms: equal except for {' and '.join(parts)}, from the plate's back" if parts else "Arms: equal"
    return Table(title, ("Arm", "deg from Z to X", *(("shelf from", "to") if has_shelf else ()), *posts), tuple(rows))


@dataclass(frozen=True)
class Star(MadePart):
    """Frame where it stands in the assembly."""

    dims: StarDims

    def solid(self) -> cq.Solid:
        """Frame in its position in the assembly."""
        import cadquery as cq

        dims, origin, y = self.dims, cq.Vector(0.0, 0.0, 0.0), cq.Vector(0.0, 1.0, 0.0)
        bodies, tools = centre_bodies(dims.arms[0]), centre_tools(dims.arms[0])
        for arm, angle in zip(dims.arms, dims.angles_deg, strict=True):
            bodies += [body.rotate(origin, y, angle) for body in yoke_bodies(arm)]
            tools += [tool.rotate(origin, y, angle) for tool in yoke_tools(arm)]
        return cut(fuse(bodies, "frame"), tools, "frame")

    def volume_mm3(self) -> float:
        """Arms less what neighbours share near the axis, and the boss. The round end lies within the arms."""
        d = self.dims
        first, n = d.arms[0], len(d.arms)
        # Half the angle between two arms; two opposite arms are in line and share nothing.
        slope = tan(pi / n) if n > 2 else inf
        shared = n * first.half_width**2 / slope * (first.levels.front_y - first.levels.plate_back_y)
        return sum(arm_mm3(arm) for arm in d.arms) - shared + boss_mm3(first)

    def sheet(self, part: str) -> Sheet:
        """Rear, middle section and front."""
        d = self.dims
        first = d.arms[0]
        one, holes = Yoke(first).sheet(part), _holes(d)
        behind = tuple(group for group in holes if group.letter in _FROM_BEHIND)
        y, reach = first.levels.plate_back_y, first.plate_top_z + 2.0
        return replace(
            one,
            labels=(*hole_labels(behind, "rear"),),
            cutting_lines=(CuttingLine("rear", (0.0, y, -reach), (0.0, y, reach), "A", minus(X)),),
            holes=holes,
            tables=(hole_table(holes), _arms(d), position_table(holes, (0, 2), "Positions from the drum's axis")),
            fits=(
                FitLine(2 * first.boss.seat_radius, FITS["drum_seat"].code, "drum bearing seats"),
                *(line for group in holes for line in group.fit_lines()),
            ),
            notes=(
                "Milled from one block. X to the right in the rear view, Y to the front, Z up from the drum's axis. "
                "Dimensions of the first arm, at Z; the other arms are equal, turned about the drum's axis.",
                f"Outer corners of plates and yokes R{mm(first.corner_radius)}.",
                *one.notes[2:],
            ),
        )
