"""Torque capability and backlash of a drive as functions of the preload that can be reached.

A terminal at the end of its thread, or a rope that must not be pulled so far, leaves less preload than the design
states; the table shows the effect. All preloads are lowered by the same share.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.model.bulk import analyse_many
from mbcdm_cad.model.equilibrium import solve_weighted
from mbcdm_cad.model.ratings import requirements
from mbcdm_cad.model.si import DriveSI, to_si

# Shares of the design's preloads; the last is too low for any use.
SHARES = (1.1, 1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3)
# A cable under a hundredth of its preload counts as slack, as in the check no_slack.
SLACK_SHARE = 0.01


@dataclass(frozen=True)
class ReachedPreload:
    """One row: what is left at a share of the preloads.

    ``at_inputs_Nm``: torque both ways at which an input reaches its rating; ``slack_Nm``: torque both ways at which the
    first cable goes slack; the drive holds the lesser of the two. Turn and swing are at the test torque.
    """

    share: float
    preload_N: tuple[float, ...]
    at_inputs_Nm: tuple[float, float]
    slack_Nm: tuple[float, float]
    turn_mrad: float
    reversal_swing_mrad: float

    @property
    def holds_Nm(self) -> tuple[float, float]:
        """Torque held, + and -."""
        return (min(self.at_inputs_Nm[0], self.slack_Nm[0]), min(self.at_inputs_Nm[1], self.slack_Nm[1]))


def preload_table(drive: Drive, shares: tuple[float, ...] = SHARES) -> tuple[ReachedPreload, ...]:
    """The rows for ``shares`` of the design's preloads. Errors: ``ModelError`` where the model has no answer."""
    si, need = to_si(drive), requirements(drive)
    found = analyse_many(
        si.spread(len(shares)).with_(preload_N=si.preload_N[:, None] * np.array(shares)[None, :]), need
    )
    rows = []
    for k, share in enumerate(shares):
        less = si.with_(preload_N=si.preload_N * share)
        rows.append(
            ReachedPreload(
                share=share,
                preload_N=tuple(float(v) for v in less.preload_N),
                at_inputs_Nm=(float(found.peak_torque_Nm[0, k]), float(found.peak_torque_Nm[1, k])),
                slack_Nm=(torque_at_first_slack_Nm(less, 1), torque_at_first_slack_Nm(less, -1)),
                turn_mrad=float(np.abs(found.turn_rad[:, k]).max()) * 1e3,
                reversal_swing_mrad=float(found.reversal_swing_rad[k]) * 1e3,
            )
        )
    return tuple(rows)


def torque_at_first_slack_Nm(d: DriveSI, direction: int) -> float:
    """Largest torque (N m, >= 0) in ``direction`` at which every cable keeps a hundredth of its preload.

    The drum's angle at which one cable is left with that tension gives the torque by the tensions of all (derived);
    of the cables that a torque in ``direction`` relieves, the first one counts.
    """
    relieved = [j for j, sense in enumerate(d.sigma) if sense == -direction]
    shape = (len(relieved),)
    wide = d.lifted(shape)
    alone = np.zeros((d.n_cables, len(relieved)))
    alone[relieved, range(len(relieved))] = -direction
    left = -direction * SLACK_SHARE * np.asarray(d.preload_N)[relieved]
    found = solve_weighted(wide, alone, left)
    return max(0.0, float((direction * found.drum_torque_by_input_Nm(wide).sum(axis=0)).min()))
