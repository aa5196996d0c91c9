"""Zeros of the input encoders that a measurement file does not give: a counter begins anywhere.

The cables are strained by the difference of the inputs, and wound by their angle. Where the difference of the columns
would take more than a share of the preload from a cable, or the angle lies outside the travel, it is the counters' and
not the drive's.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbcdm_cad.measurement.run import Run, ZerosFound
from mbcdm_cad.model.si import DriveSI

# A difference of the inputs that changes the tension of a cable by this share of its preload is taken for one of zeros.
STRAINED_SHARE = 0.5
# Angles beyond this multiple of the half travel are taken for those of a counter.
BEYOND = 1.2


def zeroed(run: Run, d: DriveSI, half_travel_rad: float) -> Run:
    """The run with zeros of its inputs from the data where those of the file are impossible; else the run itself.

    The inputs then agree in the median over the run, since servos follow their targets on average, and the middle of
    their range is angle zero. ``half_travel_rad``: of the drum.
    """
    angle = run.input_rad
    common = angle.mean(axis=0)
    apart = angle - common
    typical = np.median(apart, axis=1, keepdims=True)
    stretch = float(np.min(d.preload_N * d.free_span_m / d.input_radius_m)) / float(d.axial_stiffness_N)
    zeros = float(np.ptp(typical)) if angle.shape[0] > 1 else 0.0
    removed = np.zeros_like(typical)
    unsure = 0.0
    if zeros > 2.0 * STRAINED_SHARE * stretch:
        removed += typical
        unsure = float(np.quantile(np.abs(apart - typical), 0.99))
    else:
        zeros = 0.0
    middle = 0.5 * float(common.min() + common.max())
    centre = middle if np.abs(common).max() > BEYOND * half_travel_rad * float(np.mean(d.total_ratio)) else 0.0
    if not zeros and not centre:
        return run
    return replace(run, input_rad=angle - removed - centre, zeros=ZerosFound(zeros, unsure, centre))
