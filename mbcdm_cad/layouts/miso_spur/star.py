"""Frame: plate with boss, and an arm with a yoke for each input, milled from one block, bored from behind."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import cos, inf, pi, radians, sin, tan
from typing import TYPE_CHECKING

from mbcdm_cad.layouts.siso_spur.support import YokeDims
from mbcdm_cad.layouts.siso_spur.support.parts import Yoke, arm_bodies, arm_taken, centre_bodies, centre_taken
from mbcdm_cad.parts.fits import FITS
from mbcdm_cad.parts.milled import Bores, Feature, Form, Milled
from mbcdm_cad.parts.sheet import CuttingLine, FitLine, Sheet, Table, X, minus, mm, mm3
from mbcdm_cad.parts.sheet_blocks import hole_labels, hole_table, position_table

if TYPE_CHECKING:
    import cadquery as cq


_FROM_BEHIND = "ABCDEH"


def _turned(feature: Feature, angle_deg: float) -> Form:
    """A feature of the arm at Z where another arm has it."""

    def drawn() -> list[cq.Shape]:
        import cadquery as cq

        origin, y = cq.Vector(0.0, 0.0, 0.0), cq.Vector(0.0, 1.0, 0.0)
        return [shape.rotate(origin, y, angle_deg) for shape in feature.shapes()]

    return Form(feature.volume_mm3(), drawn)


def _arms_taken(d: Star) -> list[Feature]:
    """What is taken from all arms; equal holes are one group, with the letter of the first arm."""
    found: list[Feature] = []
    for alike in zip(*(arm_taken(arm) for arm in d.arms), strict=True):
        places = []
        for k, feature in enumerate(alike):
            if isinstance(feature, Bores):
                c, s = cos(radians(d.angles_deg[k])), sin(radians(d.angles_deg[k]))
                places += [(x * c + z * s, y, z * c - x * s) for x, y, z in feature.places]
            else:
                found.append(_turned(feature, d.angles_deg[k]))
        if isinstance(alike[0], Bores):
            found.append(replace(alike[0], places=tuple(places)))
    return found


def _arms_table(d: Star) -> Table:
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
class Star(Milled):
    """Frame where it stands in the assembly: ``arms`` as at the first input, each with its angle from +Z towards +X.

    The arms differ in the reach of their yokes from the plate. Boss and stop pin of the first are shared by all.
    """

    arms: tuple[YokeDims, ...]
    angles_deg: tuple[float, ...]

    def bodies(self) -> Sequence[Feature]:
        """Arms less what neighbours share near the axis, and the boss. The round end lies within the arms."""
        first, n = self.arms[0], len(self.arms)
        # Half the angle between two arms; two opposite arms are in line and share nothing.
        slope = tan(pi / n) if n > 2 else inf
        shared = n * first.half_width**2 / slope * (first.levels.front_y - first.levels.plate_back_y)
        arms = zip(self.arms, self.angles_deg, strict=True)
        return (
            centre_bodies(first),
            Form(-shared, lambda: []),
            *(_turned(body, angle) for arm, angle in arms for body in arm_bodies(arm)),
        )

    def taken(self) -> Sequence[Feature]:
        """Bores and holes of boss and arms."""
        return *centre_taken(self.arms[0]), *_arms_taken(self)

    def sheet(self, part: str) -> Sheet:
        """Rear, middle section and front."""
        first = self.arms[0]
        one, holes = Yoke(first).sheet(part), self.bores()
        places = position_table(holes, (0, 2), "Positions from the drum's axis")
        behind = tuple(group for group in holes if group.letter in _FROM_BEHIND)
        y, reach = first.levels.plate_back_y, first.plate_top_z + 2.0
        return replace(
            one,
            labels=(*hole_labels(behind, "rear"),),
            cutting_lines=(CuttingLine("rear", (0.0, y, -reach), (0.0, y, reach), "A", minus(X)),),
            holes=holes,
            tables=(hole_table(holes), _arms_table(self), places),
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
