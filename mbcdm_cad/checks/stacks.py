"""Gaps against the sum of the tolerances of the parts, and the transmission error that the tolerances cause.

Run-out counts half its reading on each radius, play half its size to either side; the drum's bearings have no play,
because a spring presses them apart.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from mbcdm_cad.checks.comparison import Check, Comparison, at_least, check, noted
from mbcdm_cad.checks.transfer import EDGE_BREAK_MM, body_gaps_mm
from mbcdm_cad.layouts.base import Layout
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.model.stack_up import Contribution, StackUp, tightest
from mbcdm_cad.parts.drum_sector.design import SectorDrive, SectorRun
from mbcdm_cad.parts.making import Body, body_accuracy, land_band_mm, model_tolerances, rope_band_mm

# Its argument is a configuration's design under test.
Stacks = Callable[[Any], list[StackUp]]
# Standard deviations on either side that hold 95 % of all drives.
MOST_DRIVES = 1.96


class TransferStacks(NamedTuple):
    """Gaps at the transfer from a body to the drum with the tolerances that change them; ``place``: what holds it."""

    body: str
    place: str

    def contributions(self, drive: SectorDrive, cable: SectorRun, per_rope: float = 0.0) -> tuple[Contribution, ...]:
        """Distance along y between the body's surface and the wall of a drum land, and ``per_rope`` of the rope."""
        own: Body = "pulley" if drive.passed_material is None else "passed"
        body, drum, frame = (body_accuracy(drive, part) for part in (own, "drum", "frame"))
        bodies = (
            Contribution(f"radius of the {self.body}'s step", land_band_mm(drive, cable.land_y_mm, own)),
            Contribution(f"run-out of the {self.body}", body.run_out_mm, 0.5),
            Contribution(f"play of the {self.body}'s bearings", body.bearing_play_mm, 0.5),
            Contribution(f"place of the {self.body}'s {self.place}", frame.position_mm),
            Contribution("place of the drum's bearings in the frame", frame.position_mm),
            Contribution("place of the land's wall on the drum", drum.position_mm),
            Contribution("run-out of the drum's faces", drum.run_out_mm, 0.5),
        )
        return (*bodies, Contribution("rope's diameter", rope_band_mm(drive), per_rope)) if per_rope else bodies

    def gap(self, s: SectorLayout) -> list[StackUp]:
        """Half a cable minus the gap at each transfer point."""
        return [
            StackUp(
                f"half a cable over the gap at the transfer of step {c.step}, mm",
                s.flank_mm - (land.y_start - surface),
                self.contributions(s.drive, c, 0.5),
            )
            for c, land, (surface, _) in zip(s.steps, s.drum.lands, s.steps_before_drum, strict=True)
        ]

    def bodies_clear(self, s: SectorLayout) -> list[StackUp]:
        """Gap between body and drum."""
        return [
            StackUp(f"{what}, mm", gap, self.contributions(s.drive, s.steps[step]))
            for what, step, gap in body_gaps_mm(s)
        ]

    def land_edge(self, s: SectorLayout) -> list[StackUp]:
        """Distance of the contact lines, half a rope over the surface, from the broken edges of their lands."""
        return [
            StackUp(
                f"contact line of {c.name} from its land's broken edge, mm",
                c.land_y_mm - land.y_start - EDGE_BREAK_MM,
                self.contributions(s.drive, c, 0.5),
            )
            for c, land in zip(s.steps, s.drum.lands, strict=True)
        ]


def ratio_contributions(drive: SectorDrive, cable: SectorRun) -> tuple[Contribution, ...]:
    """Contributions to the total ratio r_o / r_m, relative to it."""
    r_o, r_m = cable.drum_radius_mm, cable.input_radius_mm
    return (
        Contribution("drum radius", land_band_mm(drive, r_o, "drum"), 1.0 / r_o),
        Contribution("input radius", land_band_mm(drive, r_m, "pulley"), -1.0 / r_m),
        Contribution("rope's diameter", rope_band_mm(drive), (1.0 / r_o - 1.0 / r_m) / 2.0),
    )


def _against_stack(of: Stacks, s: Any) -> Comparison:
    """The smallest gap is compared with the root sum of squares of the tolerances that change it."""
    stack = tightest(of(s))
    note = f"sum of the tolerances (RSS); worst case {stack.worst_case:.3g} mm; largest share: {stack.costliest.name}"
    return at_least(stack.figure.removesuffix(", mm"), stack.margin, stack.rss, "mm", note)


@check("Transmission error by the tolerances", "linear theory, two sigma")
def transmission_error(s: Layout) -> Comparison:
    """Largest error of the drum's angle over the travel that the tolerances cause: linear theory, two sigma."""
    from mbcdm_cad.model.tolerance import linear_error

    names, error = linear_error(s.loads.si, s.half_travel_rad, model_tolerances(s.drive))
    whole = np.sqrt((error**2).sum(axis=0))
    pose = int(np.argmax(whole))
    most = names[int(np.argmax(np.abs(error[:, pose])))]
    return noted(
        "drum off by at most, over the travel, in 95 % of drives",
        MOST_DRIVES * float(whole[pose]) * 1e3,
        "mrad",
        f"zero at the centred drum; most by the {most}",
    )


def stack_check(name: str, title: str, of: Stacks, advice: str | Callable[[Any], str]) -> Check:
    """The check that warns if the margin of ``of`` is smaller than its tolerance stack."""
    return Check(
        f"{name}_stack",
        title,
        "root sum of squares of the tolerances in parts/fits.py and making",
        partial(_against_stack, of),
        "warn",
        advice=advice,
    )
