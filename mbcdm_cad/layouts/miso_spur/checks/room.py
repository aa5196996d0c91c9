"""Gaps between turning and fixed parts, and the box of all inputs compared with its target."""

from __future__ import annotations

import numpy as np

from mbcdm_cad.checks.size import box_checks, mass_check
from mbcdm_cad.layouts.miso_spur.bill import bill
from mbcdm_cad.layouts.miso_spur.layout import RoundDrumLayout
from mbcdm_cad.layouts.siso_spur.checks.room import BOX_ADJUSTMENTS, ROOM, outline


def box_mm(s: RoundDrumLayout) -> tuple[float, float, float]:
    """Box (X, Z, Y) of all parts with the drum centred, computed from the layout; mm."""
    drive = s.drive
    # All sectors have the terminals of the first, except for their take-up.
    own = outline(s, s.frame, s.drum)
    cloud = np.concatenate(
        [
            np.stack(
                [own[:, 0] * np.cos(a) + own[:, 1] * np.sin(a), own[:, 1] * np.cos(a) - own[:, 0] * np.sin(a)], axis=1
            )
            for a in drive.angles_rad
        ]
    )
    wide, high = cloud.max(axis=0) - cloud.min(axis=0)
    v, levels = s.levels, drive.levels_mm
    front = max(v.hub_face_y + levels[-1], v.encoder_top_z + levels[-1])
    return float(wide), float(high), front - min(v.motor_bottom_z, v.back_y)


CHECKS = (*ROOM, *box_checks(box_mm, "targets.envelope_mm", BOX_ADJUSTMENTS), mass_check(bill))
