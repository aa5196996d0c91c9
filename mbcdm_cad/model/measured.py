"""Figures of the paper, each with its place in the paper, for comparison only: the model uses none of them."""

from __future__ import annotations

BACKLASH_RAD = 0.33e-3  # section 5.3, at the next two
BACKLASH_TORQUE_NM = 0.91
BACKLASH_PRELOAD_N = 70.0
BACKLASH_ERROR = 0.097  # section 5.3, difference of Eq. (20) from the measurement; the sign is not given
PEAK_TORQUE_NM = 3.3  # section 5.1 and Fig. 7
DESIGN_TORQUE_NM = 3.9  # section 5.1, called theoretical
DESIGN_MASS_G = 350.0  # section 4.1
PROTOTYPE_MASS_G = 342.0  # section 5
DESIGN_TORQUE_TO_WEIGHT_NM_KG = 11.14  # section 4.1
TORQUE_TO_WEIGHT_NM_KG = 9.649  # section 5.1
RIPPLE_CYCLES_PER_RAD = 694.3  # section 5.2, Fig. 8 (b)
BEND_RATIO = 14.8  # Table 1
EFFECTIVE_AREA_MM2 = 0.3117  # Table 1
ENCODER_A_RAD = 191.74e-6  # section 5
ENCODER_B_RAD = 1.364e-6  # section 5
MOTOR_TORQUE_MNM = 2.9  # section 4.1
GEAR_RATIO = 76.0  # section 4.1
RMSE_SHARE = 0.0414  # section 5.3
FLAT_FRICTION = 0.3  # section 4.2: the backlash flattens out from here on


def papers_test(load_Nm: float) -> bool:
    """Whether a turn or swing under ``load_Nm`` may stand beside the paper's: only the same load compares."""
    return abs(load_Nm - BACKLASH_TORQUE_NM) < 1e-9
