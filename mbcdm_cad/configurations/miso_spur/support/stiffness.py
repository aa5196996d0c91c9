"""How far the elastic frame lets the drum turn: arms in line as one mesh, others each by themselves.

Two arms that stand opposite each other are one frame of two yokes, on which the pulls on the drum cancel. Of four
inputs there are two such pairs; of three every arm counts alone. Each takes its share of the load. Joined to the others
it can only bend less (a structure with more constraints stores less energy under the same forces), so that with more
than two inputs the sum is an upper bound.
"""

from __future__ import annotations

from collections import Counter

from mbcdm_cad.configurations.interface import FrameCompliance, FrameStudy
from mbcdm_cad.configurations.miso_spur.layout import RoundDrumLayout
from mbcdm_cad.configurations.siso_spur.support.stiffness import Arm, arms_compliance, frame_study_of


def frame_compliance(layout: RoundDrumLayout) -> FrameCompliance:
    """Windup of the drum by the frame per N m of external torque. Raises ``ValueError`` if there is no frame."""
    units = [Arm(unit) for unit in layout.units]
    half = len(units) // 2
    parts = [[unit] for unit in units]
    if len(units) % 2 == 0:
        parts = [[units[k], Arm(layout.units[k + half], -1)] for k in range(half)]
    shares = Counter[str]()
    for arms in parts:
        # What a part turns the drum by under its share of the load, times that share, is its work.
        shares.update(arms_compliance(arms, 1.0 / len(units)).shares_urad_Nm)
    return FrameCompliance(sum(shares.values()), dict(shares))


def frame_study(layout: RoundDrumLayout) -> FrameStudy:
    """The compliance as a study for the cache; infinite where the frame has no metal to carry a load."""
    return frame_study_of(__name__, layout.units, lambda: frame_compliance(layout))
