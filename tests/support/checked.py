"""Designs of params/, sized once, and results of all checks without remedies; a rig that is held."""

from functools import cache
from typing import Any

import numpy as np

from mbcdm_cad.checks.comparison import CheckResult
from mbcdm_cad.checks.run import Budget, run_check
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.layouts.base import Layout
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.rig.experiment import Experiment
from mbcdm_cad.rig.quasistatic import simulate
from mbcdm_cad.routes import Floats
from tests.support.reference import PARAMS


@cache
def of_params(name: str) -> LoadedDesign:
    """The design of a file of params/: short files take seconds to size, and many tests look at the same."""
    return load_design(PARAMS / f"{name}.yaml")


def short_file(
    layout: str, half_deg: float, ratio: float | None, radius_mm: float | None, peak_Nm: float, **more: dict[str, Any]
) -> dict[str, Any]:
    """Travel, ratio, radius and torque of a short file, as far as stated; fields of further blocks are added."""
    stated = {"ratio" if layout == "miso_bevel" else "input_to_drum": ratio, "drum_radius_mm": radius_mm}
    data: dict[str, Any] = {
        "name": "short",
        "configuration": layout,
        "travel": {"half_angle_deg": half_deg},
        "transmission": {name: value for name, value in stated.items() if value is not None},
        "loads": {"peak_torque_Nm": peak_Nm},
    }
    return data | {block: data.get(block, {}) | fields for block, fields in more.items()}


def _layout(design: Layout | Drive | LoadedDesign) -> Layout:
    if isinstance(design, LoadedDesign):
        return layout_of(design.drive)
    return layout_of(design) if isinstance(design, Drive) else design


def results(design: Layout | Drive | LoadedDesign) -> list[CheckResult]:
    """Every check that is asked of the design."""
    layout = _layout(design)
    with np.errstate(all="ignore"):
        return [run_check(check, layout, Budget(0)) for check in checks_of(layout.drive)]


def result(design: Layout | Drive | LoadedDesign, name: str) -> CheckResult:
    """One check, with its remedy."""
    layout = _layout(design)
    return run_check(layout.checks_by_id()[name], layout)


def statuses(design: Layout | Drive | LoadedDesign) -> dict[str, str]:
    """Status by check."""
    return {found.id: found.status for found in results(design)}


def failing(design: Layout | Drive | LoadedDesign) -> dict[str, str]:
    """Message of each check that fails."""
    return {found.id: found.message for found in results(design) if found.status == "fail"}


def held_rad(drive: Drive, load_Nm: float, structure: bool = True) -> Floats:
    """Angle of the drum in a run without cable transport.

    ``structure``: with what gives besides the cables, the motors being held, in place of the input pulleys.
    """
    data = {
        "name": "held",
        "seed": 1,
        "duration_s": 4.0,
        "sample_rate_Hz": 50.0,
        "motion": {"shape": "triangle", "amplitude_mrad": 0.1, "period_s": 4.0},
        "load": {"kind": "torque_motor", "wave": "sine", "levels_Nm": [load_Nm], "wave_period_s": 4.0},
        "sensors": {"input_at": "motor" if structure else "pulley"},
        "physics": {"cable_transport": False, "structure": structure},
    }
    return np.asarray(simulate(drive, Experiment.model_validate(data)).drum_rad)
