"""What the sizing of both layouts with a bevel transfer shares: what is known of a drive, and the rules of the gap."""

from abc import abstractmethod
from collections.abc import Mapping
from itertools import pairwise
from typing import Any

from mbcdm_cad.checks.transfer import EDGE_BREAK_MM, RUN_OUT_MM, TransferStacks
from mbcdm_cad.design.paths import at
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.head_basis import counts_losses
from mbcdm_cad.layouts.trial_drives import TrialDrives
from mbcdm_cad.layouts.trial_sizing import MIDDLE_SIZE, TrialKnown
from mbcdm_cad.model.tolerance import StackUp
from mbcdm_cad.parts.drum_sector.design import SectorDrive
from mbcdm_cad.sizing import Found, driver_of, rounded_down, rounded_up, rule

RADII, LAND_EDGE = at.transmission.drum_radii_mm, at.clearances.land_edge_mm
# Half of it holds a broken edge, the run-out and the tolerances of milled and turned parts: 0.1, 0.05 and 0.039 mm.
LEAST_ROPE_MM = 0.38
# Least D/d of the catalogue's wire ropes, for a rope of the next size, at most 1.25 times as thick.
BENT_TO_NEXT = 28.0 * 1.25


# Of a drive of medium size, for fields that the first pass does not know yet.
GUESSES: Mapping[str, Any] = {
    **MIDDLE_SIZE,
    LAND_EDGE: 0.15,
    at.clearances.transfer_gap_mm: 0.1,
    at.drive.motor: "motor-2.9mNm-15",
    at.drive.gearhead: "gearhead-76-16",
    at.drum.tensioner: "M2",
    at.support.side_wall_mm: 5.0,
    at.support.mount_screw: "M3",
}


class TransferKnown(TrialKnown):
    """Adds the radii of a drum, and of the body before it, on which the cables lie beside each other."""

    def __init__(self, data: dict[str, Any], guesses: Mapping[str, Any], drives: TrialDrives | None = None) -> None:
        """See the base class; guessed radii, as of a similar drive, begin at the drum's own."""
        super().__init__(data, guesses, drives)
        radii = guesses.get(RADII)
        if radii and radii[0] != self.drum_mm and not self.has(RADII):
            self._filled = self._at_start = self._whole(RADII, [self.drum_mm + one - radii[0] for one in radii])

    @property
    def drum_mm(self) -> float:
        """Pitch radius of the drum's step 1."""
        return float(self[RADII][0] if self.has(RADII) else self[at.transmission.drum_radius_mm])

    @property
    @abstractmethod
    def before_drum_mm(self) -> list[float]:
        """Pitch radii of the body before the drum."""

    @property
    def states_lands(self) -> bool:
        """Whether the file states these radii."""
        return self.has(RADII)

    @property
    def least_rope_mm(self) -> float:
        """See the base class: milled parts' tolerances at the transfer ask for it, unless it bends more than it may."""
        if not counts_losses(self) or self.printed("drum") or self.printed("support"):
            return 0.0
        return min(LEAST_ROPE_MM, 2.0 * self.drum_mm / self.ratio / BENT_TO_NEXT) if self.has_ratio else LEAST_ROPE_MM

    def tolerance_mm(self, per_rope: float) -> float:
        """Sum of the tolerances (RSS) of a gap at the transfer; 0 for files that reckon as the paper does."""
        if not counts_losses(self):
            return 0.0
        try:
            drive = self.trial(LAND_EDGE, EDGE_BREAK_MM + RUN_OUT_MM).drive
        except NoFigureError:
            return 0.0
        assert isinstance(drive, SectorDrive)
        return StackUp("", 0.0, TransferStacks("", "").contributions(drive, drive.cables[-1], per_rope)).rss


@rule(LAND_EDGE, "a broken edge and the run-out or the tolerances, less for a thin rope or stated steps", "land_edge")
def land_edge(given: TransferKnown) -> Found:
    wanted = EDGE_BREAK_MM + max(RUN_OUT_MM, given.tolerance_mm(0.5))
    needs = {"land_edge": rounded_up(wanted, 0.001), "bodies_clear": given.d_mm / 2 - RUN_OUT_MM}
    if given.states_lands:
        rise = min(b - a for a, b in pairwise(given.before_drum_mm))
        needs["land_width"] = rounded_down(rise - given.d_mm / 2, 0.001)
    return Found(round(max(min(needs.values()), EDGE_BREAK_MM), 4), driver_of(needs, min))


@rule(
    at.clearances.transfer_gap_mm,
    "half the rope's diameter less the edge margin of the land and a broken edge, no less than the tolerances",
    "transfer_gap",
)
def transfer_gap(given: TransferKnown) -> Found:
    """As wide as that, but at least the run-out, and the tolerances where half a rope leaves room for them."""
    wide, least = given.d_mm / 2 - given[LAND_EDGE] - EDGE_BREAK_MM, rounded_up(given.tolerance_mm(0.0), 0.001)
    if least > given.d_mm / 2 - EDGE_BREAK_MM - RUN_OUT_MM:
        least = 0.0
    driver = driver_of({"bodies_clear": max(RUN_OUT_MM, least), "transfer_gap": wide}, max)
    return Found(round(max(wide, RUN_OUT_MM, least), 4), driver)


@rule(at.drum.outer_face_y_mm, "least width for lands and terminals", "outer_face")
def outer_face(given: TransferKnown) -> Found:
    checks = ("outermost_land", "land_thickness", "outer_face", "terminals_apart", "lands_intact", "lug_stress")
    return given.moved(at.drum.outer_face_y_mm, max(given.before_drum_mm), 0.1, (*checks, "web_in_rim"))
