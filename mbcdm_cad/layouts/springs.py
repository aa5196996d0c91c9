"""What springs in the terminals do to the drum's turn: nothing until slip on the drum has reached a terminal."""

import numpy as np

from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.routes import Floats

_HALVINGS = 50


def spring_urad_Nm(layout: SectorLayout) -> float:
    """Further turn of the drum by the terminals' give at the test torque, over that torque; 0 for stiff ones.

    The largest at both ends of the travel: friction on the drum keeps small loads from the terminals. Raises
    ``NoFigureError`` where the model has no answer.
    """
    return 0.0 if layout.drive.anchor_m_N == 0.0 else layout.once("springs", spring_turn_urad_Nm)


def spring_turn_urad_Nm(layout: SectorLayout, give_m_N: float | None = None) -> float:
    """Turn by the springs at the test torque over that torque: the largest both ways and at both ends of the travel.

    With ``give_m_N`` of the springs of one cable in place of their own.
    """
    torque, most = layout.drive.loads.test_torque_Nm, 0.0
    give = layout.drive.anchor_m_N if give_m_N is None else give_m_N
    for wound in _at_ends(layout):
        turns = [_turn_rad(wound.with_(anchor_m_N=np.full(wound.n_cables, g)), torque) for g in (give, 0.0)]
        most = max(most, float((turns[0] - turns[1]).max()))
    return 1e6 * most / torque


def spring_start_Nm(layout: SectorLayout) -> float:
    """Torque on first loading at which slip reaches the first terminal; infinite where none moves below the limit.

    Found between no load and the limit, ten times the peak torque, by halving.
    """
    limit = 10.0 * layout.drive.loads.peak_torque_Nm
    least, below = np.inf, limit
    for wound in _at_ends(layout):
        for way in (1.0, -1.0):
            if not _moves(wound, way * below):
                continue  # no terminal moves here before those that were found
            low, high = 0.0, limit
            for _ in range(_HALVINGS):
                middle = 0.5 * (low + high)
                low, high = (low, middle) if _moves(wound, way * middle) else (middle, high)
            least, below = high, low
    return float(least)


def _at_ends(layout: SectorLayout) -> list[DriveSI]:
    return [layout.loads.si.with_(**wraps) for wraps in layout.wraps_at_ends_rad]


def _turn_rad(d: DriveSI, torque_Nm: float) -> Floats:
    """Turn of the drum both ways from no load."""
    try:
        angle = solve_equilibrium(d, np.array([0.0, torque_Nm, -torque_Nm])).drum_angle_rad
    except ModelError as error:
        raise NoFigureError(f"the model has no answer: {error}") from None
    return np.asarray(np.abs(angle[1:] - angle[0]))


def _moves(d: DriveSI, torque_Nm: float) -> bool:
    """Whether slip has reached a terminal; a torque that the cables do not hold moves it too."""
    try:
        tension = solve_equilibrium(d, torque_Nm).tension_N
    except ModelError:
        return True
    with np.errstate(divide="ignore"):
        return bool(np.any(np.abs(np.log(tension / d.preload_N)) >= d.friction_coefficient * d.drum_wrap_rad))
