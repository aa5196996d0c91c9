"""Rotation of the drum by the elastic frame: arms in line as one mesh, other arms separately.

Two opposite arms are one frame with two yokes, on which the forces on the drum cancel. Four inputs are two such pairs;
with three inputs every arm is computed alone. Each carries its share of the load. Connected to the others an arm can
only bend less (a structure with more constraints stores less energy under the same forces), so that with more than two
inputs the sum is an upper bound.
"""

from collections import Counter

from mbcdm_cad.layouts.base import FrameCompliance, FrameStudy
from mbcdm_cad.layouts.miso_spur.layout import RoundDrumLayout
from mbcdm_cad.layouts.siso_spur.support.stiffness import Arm, arms_compliance, frame_study_of


def frame_compliance(layout: RoundDrumLayout) -> FrameCompliance:
    """Windup of the drum by the frame per N m of external torque. Raises ``ValueError`` if there is no frame."""
    units = [Arm(unit) for unit in layout.units]
    half = len(units) // 2
    parts = [[unit] for unit in units]
    if len(units) % 2 == 0:
        parts = [[units[k], Arm(layout.units[k + half], -1)] for k in range(half)]
    shares = Counter[str]()
    for arms in parts:
        # The work of a part is its rotation of the drum under its share of the load, times that share.
        shares.update(arms_compliance(arms, 1.0 / len(units)).shares_urad_Nm)
    return FrameCompliance(sum(shares.values()), dict(shares))


def frame_study(layout: RoundDrumLayout) -> FrameStudy:
    """The compliance as a study for the cache."""
    return frame_study_of(__name__, layout.units, lambda: frame_compliance(layout))
