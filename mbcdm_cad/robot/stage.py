"""The cables of one input as a spring and elastic-slip elements in parallel: their hysteresis for other simulators.

Between a motor and the drum gearhead, pulley and cables in series carry a torque that depends on the course of g, the
drum's angle less that of the motor over its ratio. The model gives it (:mod:`mbcdm_cad.model.hysteresis`); a spring and
elements that are springs up to a limit, where they slip, follow it in loops of any size, since the loops are nearly
twice the curve of first loading (Masing). The limits are chosen, the stiffnesses follow by least squares above zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.model.si import DriveSI, to_si
from mbcdm_cad.routes import Floats

# Twist at which each element slips, over the turn under the test torque.
SLIP_TURNS = (0.1, 0.22, 0.45, 0.9, 1.8)
# Loads of the loops that are fitted, over the test torque; never above the peak torque.
_LEVELS = (0.3, 1.0, 2.0)
_SAMPLES = 300


@dataclass(frozen=True)
class SlipElement:
    """A spring that slips at its limit, both at the drum."""

    stiffness_Nm_rad: float
    limit_Nm: float


@dataclass(frozen=True)
class CableStage:
    """Gearhead and cables of one input, at the drum: torque that turns the drum = preload - spring g - elements.

    ``preload_Nm``: torque of the preload on the drum, which acts on the input too, through its ratio.
    """

    input_index: int
    preload_Nm: float
    spring_Nm_rad: float
    slips: tuple[SlipElement, ...]

    @property
    def sticking_Nm_rad(self) -> float:
        """Stiffness while nothing slips."""
        return self.spring_Nm_rad + sum(slip.stiffness_Nm_rad for slip in self.slips)


def cable_stages(drive: Drive, before_inputs_Nm_rad: float) -> tuple[CableStage, ...]:
    """A stage for each input, fitted to loops; ``before_inputs_Nm_rad``: stiffness between motor and input's encoder.

    Raises ``ModelError`` where there is no loop.
    """
    d = to_si(drive)
    test = drive.loads.test_torque_Nm
    levels = [min(level * test, max(test, drive.loads.peak_torque_Nm)) for level in _LEVELS]
    loops = [_loop(d, level) for level in levels]
    give = 1.0 / (before_inputs_Nm_rad * np.asarray(d.input_turns) ** 2)
    return tuple(_stage(d, i, float(give[i]), list(zip(levels, loops, strict=True))) for i in range(d.n_inputs))


def slipping(twist_rad: Floats, limit_rad: float) -> Floats:
    """Deflection of an elastic-slip element over a course of twists that begins at rest, rad."""
    found = np.zeros(twist_rad.size)
    for k, (before, now) in enumerate(pairwise(twist_rad), 1):
        found[k] = min(max(found[k - 1] + now - before, -limit_rad), limit_rad)
    return found


def _loop(d: DriveSI, load_Nm: float) -> tuple[Floats, Floats]:
    """Drum angles (n,) and tensions (n_cables, n) from the preload on, up to the load, to its opposite and back."""
    corners = [(0.0, load_Nm), (load_Nm, -load_Nm), (-load_Nm, load_Nm)]
    load = np.concatenate([np.linspace(a, b, _SAMPLES) for a, b in corners])
    run = simulate(d, np.zeros((d.n_inputs, load.size)), load)
    return np.append(0.0, run.drum_angle_rad), np.column_stack([d.preload_N, run.tension_N])


def _stage(d: DriveSI, i: int, give_rad_Nm: float, loops: list[tuple[float, tuple[Floats, Floats]]]) -> CableStage:
    from scipy.optimize import nnls

    own = np.array(d.input_of) == i
    lever = (d.sigma * d.drum_radius_m)[own]
    torques = [lever @ (d.preload_N[own, None] - tension[own]) for _, (_, tension) in loops]
    # The torque that the cables take twists the gearhead too.
    twists = [drum + give_rad_Nm * torque for (_, (drum, _)), torque in zip(loops, torques, strict=True)]
    limits_rad = np.array(SLIP_TURNS) * 0.5 * float(np.ptp(twists[1]))
    rows, wanted = [], []
    for (level, _), twist, torque in zip(loops, twists, torques, strict=True):
        rows.append(np.stack([twist, *(slipping(twist, limit) for limit in limits_rad)], axis=1) / level)
        wanted.append(torque / level)
    scale = float(limits_rad[-1])  # so that the unknowns are torques
    scaled, _ = nnls(np.concatenate(rows) / scale, np.concatenate(wanted))
    spring, *stiff = scaled / scale
    slips = tuple(
        SlipElement(float(k), float(k * limit)) for k, limit in zip(stiff, limits_rad, strict=True) if k > 0.0
    )
    return CableStage(i, float(lever @ d.preload_N[own]), float(spring), slips)
