"""The preload of a design and how the built drive measures it: text, plain data, and the files of the procedure."""

import csv
import io
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.layouts import preload
from mbcdm_cad.layouts.base import Layout, NoFigureError
from mbcdm_cad.layouts.preload import NutTurn, PreloadRule
from mbcdm_cad.model.preload_ramp import MeasuredPreloads, Ramp
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.report.table import TextReport, rendered, terminal_lines

HEAD = ("angle_rad", "torque_Nm")
# Column of a log that has the motor's torque, current times torque constant, in place of that on the input's shaft.
AT_MOTOR = "motor_torque_Nm"


def preload_shown(found: Mapping[str, Any] | None) -> dict[str, Any] | None:
    """What terminal, report and page show of the block ``preload``, a :class:`PreloadRule`: sentences and a table."""
    if found is None:
        return None
    rows = tuple(
        (
            f"{row['preload_N']:.3g}",
            f"{row['lowest_share']:.0%}",
            f"{row['swing_mrad']:.4f}",
            "none" if row["life_factor"] is None else f"{row['life_factor']:.2g}",
            f"{row['rope_Nm']:.4f}",
            f"{row['bearings_Nm']:.4f}",
        )
        for row in found["table"]
    )
    where = "above" if found["preload_N"] > found["knee_N"] else "below"
    return {
        # Where the preload stands among its limits.
        "sentence": (
            f"Preload {found['preload_N']:.4g} N: {found['slack_N']:.3g} N keep all cables taut at the peak torque, "
            f"beyond the knee at {found['knee_N']:.3g} N more buys little backlash (it stands {where} it), "
            f"limits.preload_share_max allows {found['most_N']:.4g} N"
        ),
        "words": (
            "lowest tension: at the peak torque, over it; swing: at a reversal of the test torque; life: over that at "
            "this preload; rope, bearings: friction at the drum without a load"
        ),
        "heads": ("preload N", "lowest tension", "swing mrad", "life, times", "rope N m", "bearings N m"),
        "rows": rows,
    }


@dataclass(frozen=True)
class PreloadReport(TextReport):
    """Shares of a preload, the expected ramps (none where ``no_ramps`` says why), and what logs of them gave.

    ``ramps``: torque on the input's shaft; ``at_motor``: that of the motor times the gearhead's ratio.
    ``files``: of the procedure, by name, for the output folder; ``folder``: where they were written.
    """

    rule: PreloadRule
    ramps: tuple[Ramp, ...]
    at_motor: tuple[Ramp, ...]
    no_ramps: str
    measured: tuple[MeasuredPreloads, ...]
    turns: tuple[NutTurn, ...]
    motor_Nm: float
    layout: Layout = field(repr=False)
    folder: Path | None = None

    def to_dict(self) -> dict[str, Any]:
        """Everything, ready for JSON."""
        names = self.layout.loads.si.cable_names
        return {
            "rule": asdict(self.rule),
            "no_ramps": self.no_ramps,
            "motor_reaches_Nm": self.motor_Nm,
            "ramps": [
                {
                    "input": r.input_name,
                    "cables": [names[j] for j in r.cables],
                    "knee_rad": list(r.knee_rad),
                    "knee_Nm": list(r.knee_Nm),
                    "slack_first": list(r.slack_first),
                    "sigma_N": r.sigma_N.tolist(),
                }
                for r in self.ramps
            ],
            "measured": [
                {
                    "cables": [names[j] for j in m.cables],
                    "preload_N": m.preload_N.tolist(),
                    "sigma_N": m.sigma_N.tolist(),
                    "stiffness_over_design": m.stiffness,
                    "friction_over_design": m.friction,
                    "rubbing_over_design": m.rubbing,
                    "gearhead_loss_over_design": m.gearhead,
                }
                for m in self.measured
            ],
            "nut_turns": [asdict(turn) for turn in self.turns],
            "folder": None if self.folder is None else str(self.folder),
        }

    def files(self) -> dict[str, bytes]:
        """Files of the procedure: the expected curves, the ramp in C, the evaluation in Python. None without ramps."""
        if not self.ramps:
            return {}
        ratio = self.layout.drive.reduction.ratio
        found = {
            f"expected-{r.input_name}.csv": _curve(r, m, ratio) for r, m in zip(self.ramps, self.at_motor, strict=True)
        }
        filled_in = {
            "DESIGN": self.layout.drive.name,
            "LARGEST_RAD": f"{max(float(np.abs(r.angle_rad).max()) for r in self.ramps):.5f}",
            "LARGEST_MOTOR_NM": f"{max(float(np.abs(r.torque_Nm).max()) for r in self.at_motor) / ratio:.4g}",
            "KNEE_NM": f"{self._least_knee_Nm:.4g}",
            "INPUTS": ", ".join(repr(r.input_name) for r in self.ramps),
        }
        for name in ("preload_ramp.c", "preload_ramp.py"):
            text = files("mbcdm_cad.report").joinpath(f"{name}.txt").read_text("utf-8")
            for key, value in filled_in.items():
                text = text.replace(f"@{key}@", value)
            found[name] = text.encode("utf-8")
        return found

    def text(self, width: int | None = None) -> str:
        """What ``mbcdm preload`` prints."""
        text = rendered(
            "preload.txt.j2",
            shares=preload_shown(asdict(self.rule)),
            cables=self.layout.loads.si.cable_names,
            least_Nm=self._least_knee_Nm,
            **vars(self),
        )
        return "\n".join(terminal_lines(text, width))

    @property
    def _least_knee_Nm(self) -> float:
        return min((float(np.abs(r.knee_Nm).min()) for r in self.ramps), default=0.0)


def _curve(ramp: Ramp, at_motor: Ramp, ratio: float) -> bytes:
    """The way out of one input as CSV: torque on its shaft and at the motor, each with its standard deviation."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow((*HEAD, "sigma_Nm", AT_MOTOR, "motor_sigma_Nm"))
    motor = at_motor.torque_Nm / ratio, at_motor.sigma_Nm / ratio
    for row in zip(ramp.angle_rad, ramp.torque_Nm, ramp.sigma_Nm, *motor, strict=True):
        writer.writerow([f"{value:.6g}" for value in row])
    return text.getvalue().encode("utf-8")


# Angles and torques of the log in a file, and whether they are the motor's.
ReadLog = Callable[[Path], tuple[np.ndarray, np.ndarray, bool]]


def preload_report(layout: Layout, logs: Mapping[str, Path], read_log: ReadLog) -> PreloadReport:
    """The report; ``logs``: files of measured ramps by input. Raises ``MbcdmError`` for a log that does not do."""
    try:
        rule = preload.preload_rule(layout)
    except NoFigureError as missing:
        raise MbcdmError(f"no figures of the preload: {missing}") from None
    drive = layout.drive
    ramps: tuple[Ramp, ...] = ()
    at_motor: tuple[Ramp, ...] = ()
    reason, turns = "", tuple[Any, ...]()
    try:
        ramps, at_motor = (preload.ramps(layout, motor) for motor in (False, True))
    except NoFigureError as missing:
        reason = str(missing)
    found = []
    for input_name, path in logs.items():
        if reason:
            raise MbcdmError(f"{path}: no ramps to compare with: {reason}")
        try:
            angle, torque, motors = read_log(path)
            ratio = drive.reduction.ratio if motors else 1.0
            found.append(preload.measured(layout, input_name, angle, ratio * torque, motors))
        except ModelError as error:
            raise MbcdmError(f"{path}: {error}") from None
    if found:
        turns = preload.nut_turns(layout, tuple(found))
    motor = drive.motor.peak_torque_mNm * 1e-3 * drive.reduction.ratio * drive.reduction.efficiency
    return PreloadReport(rule, ramps, at_motor, reason, tuple(found), turns, motor, layout)
