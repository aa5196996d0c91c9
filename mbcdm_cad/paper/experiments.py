"""The paper's three experiments on the dynamic rig, with the rig's figures and the paper's.

driving capability  Fig. 7: the controllers hold the drum, a torque motor ramps up to failure   3.3 N m
positioning         Fig. 8: 0.05 Hz, 100 mrad, spectrum of the error over the drum's angle     24.67 urad at 694.3 /rad
backlash            Fig. 9: 0.1 Hz, 50 mrad against a powder brake of 0.91 N m, preload 70 N   0.33 mrad

Values that the paper does not state are chosen here and listed in the result: slope of the ramp, bandwidth of the
controllers, inertia of the plate, ripple of the motor. Nothing is fitted to the paper's figures.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.paper.experiments_analysis import (
    angle_spectrum,
    first_saturated_Nm,
    given_way_Nm,
    highest_peak,
    left_angle_Nm,
    reversal_swings_rad,
)
from mbcdm_cad.rig.dynamic.load import LoadSpec
from mbcdm_cad.rig.dynamic.motion import sine, standstill
from mbcdm_cad.rig.dynamic.rig import DynamicRig, rig_of
from mbcdm_cad.rig.dynamic.run import DynamicRun, run_dynamic

RAMP_Nm_s = 0.2
RAMP_TO_Nm = 9.0
PLATE_kg_m2 = 2e-3
RIPPLE_SHARE = 0.03
BRAKE_NM = 0.91
FINE_LOG_HZ = 1000.0


@dataclass(frozen=True)
class Compared:
    """One figure of the rig; ``paper`` is None if the paper states none."""

    quantity: str
    unit: str
    rig: float
    paper: float | None = None
    note: str = ""


@dataclass(frozen=True, eq=False)
class PaperResult:
    """An experiment: its figures, its runs by name, and the values that were chosen."""

    name: str
    figure: str
    compared: tuple[Compared, ...]
    runs: dict[str, DynamicRun]
    chosen: dict[str, float | str]


def driving_capability(drive: Drive, seed: int = 0) -> PaperResult:
    """Ramp the torque on the drum in both directions, with a lossless gearhead (as in the paper) and with losses."""
    compared, runs = [], {}
    for ideal, word in ((True, "lossless"), (False, f"efficiency {drive.gearhead.efficiency:g}")):
        rig = rig_of(drive, ideal_gearhead=ideal)
        if ideal:
            rig = replace(rig, motors=tuple(replace(motor, coulomb_Nm=0.0, viscous_Nms=0.0) for motor in rig.motors))
        for sign, way in ((1.0, "+"), (-1.0, "-")):
            run = ramp(rig, sign, seed)
            runs[f"{word}, {way}"] = run
            limits = [loop.torque_limit_Nm for loop in rig.loops]
            compared += [
                Compared(f"first input at its limit: {word}, {way}", "N m", first_saturated_Nm(run, limits), 3.3),
                Compared(f"an input is off by 1 mrad: {word}, {way}", "N m", left_angle_Nm(run, drive), 3.3),
                Compared(f"drum is off by 20 mrad: {word}, {way}", "N m", given_way_Nm(run), 3.3),
            ]
    chosen: dict[str, float | str] = {"ramp_Nm_s": RAMP_Nm_s, "bandwidth_Hz": 5.0}
    return PaperResult("driving-capability", "Fig. 7", tuple(compared), runs, chosen)


def ramp(rig: DynamicRig, sign: float, seed: int = 0) -> DynamicRun:
    """Hold the drum while the torque of the torque motor increases from zero."""
    rate = rig.loops[0].rate_Hz
    reference = standstill(RAMP_TO_Nm / RAMP_Nm_s, rate)
    torque = sign * RAMP_Nm_s / rate * np.arange(reference.shape[0], dtype=float)
    return run_dynamic(rig, reference, torque, seed=seed)


def positioning(drive: Drive, seed: int = 0) -> PaperResult:
    """Sine of 100 mrad at 0.05 Hz with an inertia plate; the motors have a torque ripple once a turn."""
    rig = rig_of(drive, LoadSpec(inertia_kg_m2=PLATE_kg_m2))
    ripple = RIPPLE_SHARE * drive.motor.rated_torque_mNm * 1e-3
    # Different phases, because the motors are not aligned when they are mounted.
    motors = tuple(replace(m, cogging_Nm=ripple, cogging_phase_rad=2.0 * i) for i, m in enumerate(rig.motors))
    rig = replace(rig, motors=motors)
    run = run_dynamic(rig, sine(0.1, 0.05, 3, rig.loops[0].rate_Hz), seed=seed, log_rate_Hz=FINE_LOG_HZ)
    settled = run.time_s > 20.0
    error = (run.reference_rad - run.measured_drum_rad)[settled]
    order, amplitude = angle_spectrum(run.reference_rad[settled], error)
    at, peak = highest_peak(order, amplitude)
    motor_order = drive.gearhead.ratio * drive.cables[0].drum_radius_mm / drive.cables[0].input_radius_mm
    compared = (
        Compared("largest tracking error", "mrad", float(np.abs(error).max()) * 1e3, 0.3),
        Compared(
            "highest peak, where",
            "cycle/rad",
            at,
            694.3,
            "the rig's motor turns once per "
            f"{motor_order / 2.0 / np.pi:.1f} cycle/rad = {motor_order:.0f} per turn of the drum",
        ),
        Compared("highest peak, where", "cycle/turn", at * 2.0 * np.pi, 694.3, "if the paper's axis is per turn"),
        Compared(
            "highest peak, amplitude",
            "urad",
            peak * 1e6,
            24.67,
            f"proportional to the chosen ripple, {ripple * 1e3:.3f} mN m at the motor",
        ),
        Compared("ripple that would give the paper's peak", "mN m", ripple * 1e3 * 24.67e-6 / peak),
    )
    chosen: dict[str, float | str] = {
        "bandwidth_Hz": 5.0,
        "plate_kg_m2": PLATE_kg_m2,
        "ripple_share_of_rated_torque": RIPPLE_SHARE,
    }
    return PaperResult("positioning", "Fig. 8", compared, {"positioning": run}, chosen)


def backlash(drive: Drive, seed: int = 0) -> PaperResult:
    """Sine of 50 mrad at 0.1 Hz against the brake; the swing of the output minus input/9 at each reversal."""
    rig = rig_of(drive, LoadSpec())
    run = run_dynamic(rig, sine(0.05, 0.1, 4, rig.loops[0].rate_Hz), brake_Nm=BRAKE_NM, seed=seed)
    swings = reversal_swings_rad(run, drive)[1:]
    if not swings.size:
        raise ValueError(f"the drum never reversed under the brake, the run ended at {run.time_s[-1]:.2f} s")
    compared = (
        Compared(
            "swing of the transmission error at a reversal",
            "mrad",
            float(np.mean(swings)) * 1e3,
            0.33,
            f"mean of {swings.size}, {swings.min() * 1e3:.4f} to {swings.max() * 1e3:.4f}",
        ),
    )
    chosen: dict[str, float | str] = {"bandwidth_Hz": 5.0, "brake_Nm": BRAKE_NM}
    return PaperResult("backlash", "Fig. 9", compared, {"backlash": run}, chosen)


EXPERIMENTS: dict[str, Callable[[Drive, int], PaperResult]] = {
    "driving-capability": driving_capability,
    "positioning": positioning,
    "backlash": backlash,
}
