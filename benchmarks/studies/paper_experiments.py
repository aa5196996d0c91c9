"""The paper's three experiments on the dynamic rig, evaluated and compared with the paper.

driving capability  Fig. 7: the controllers hold the drum, a torque motor ramps up to failure   3.3 N m
positioning         Fig. 8: 0.05 Hz, 100 mrad, spectrum of the error over the drum's angle     24.67 urad at 694.3 /rad
backlash            Fig. 9: 0.1 Hz, 50 mrad against a powder brake of 0.91 N m, preload 70 N   0.33 mrad

Values that the paper does not state are chosen here and listed in the result: slope of the ramp, bandwidth of the
controllers, inertia of the plate, ripple of the motor. Nothing is fitted to the paper's figures.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.rig.dynamic.run import DynamicRun, run_dynamic
from mbcdm_cad.rig.dynamic.train import DynamicRig, LoadSpec, input_turns, rig_of, sine, standstill
from mbcdm_cad.routes import Floats

# An input is saturated if its torque, averaged over a fifth of a second, is within 0.2 % of the limit.
SATURATED_SHARE = 0.998
AVERAGED_S = 0.2
# An input has left its angle if it is off by this much (five counts of its encoder), on the same average.
LEFT_RAD = 1e-3
# The drum has given way if it is off by this much, which is far more than its elastic deflection.
GIVEN_WAY_RAD = 0.02
LOWEST_ORDER = 20.0


def first_saturated_Nm(run: DynamicRun, limits_Nm: Sequence[float]) -> float:
    """Load torque at which the first input reaches its limit, N m; NaN if none does."""
    return _load_where(run, np.abs(run.motor_Nm) / np.asarray(limits_Nm)[:, None], SATURATED_SHARE)


def left_angle_Nm(run: DynamicRun, drive: Drive) -> float:
    """Load torque at which the first input has left its angle by :data:`LEFT_RAD`, N m; NaN if none does."""
    turns = np.array(input_turns(drive))
    return _load_where(run, np.abs(run.input_rad - turns[:, None] * run.reference_rad), LEFT_RAD)


def _load_where(run: DynamicRun, series: Floats, level: float) -> float:
    """Load at which the first row of ``series`` reaches ``level``, for running means of both."""
    window = np.full(max(int(AVERAGED_S / (run.time_s[1] - run.time_s[0])), 1), 1.0)
    load = np.convolve(np.abs(run.torque_Nm), window / window.size, mode="valid")
    reached = [np.flatnonzero(np.convolve(row, window / window.size, mode="valid") >= level) for row in series]
    first = min((int(over[0]) for over in reached if over.size), default=-1)
    return float(load[first]) if first >= 0 else float("nan")


def given_way_index(run: DynamicRun) -> int:
    """First sample at which the drum is off by :data:`GIVEN_WAY_RAD`; the length of the run if there is none."""
    over = np.flatnonzero(np.abs(run.reference_rad - run.drum_rad) > GIVEN_WAY_RAD)
    return int(over[0]) if over.size else int(run.time_s.size)


def given_way_Nm(run: DynamicRun) -> float:
    """Load torque at which the drum is off by :data:`GIVEN_WAY_RAD`, N m; NaN if it never is."""
    at = given_way_index(run)
    return float(abs(run.torque_Nm[at])) if at < run.time_s.size else float("nan")


def transmission_error_rad(run: DynamicRun, drive: Drive) -> Floats:
    """Measured output minus the mean of the measured inputs over the ratio, Eq. (2)."""
    turns = np.array(input_turns(drive))
    output: Floats = run.measured_drum_rad - (run.measured_input_rad / turns[:, None]).mean(axis=0)
    return output


def reversal_swings_rad(run: DynamicRun, drive: Drive, settle_s: float = 0.05, averaged_s: float = 0.1) -> Floats:
    """Change of the transmission error at each reversal of the load: difference of the means after and before it.

    A reversal lasts from the last sample above 95 % of the torque level to the first one above 95 % of the opposite
    level; ``settle_s`` before and after it is left out.
    """
    error, torque = transmission_error_rad(run, drive), run.torque_Nm
    level = np.abs(torque).max()
    side = np.where(torque > 0.95 * level, 1, np.where(torque < -0.95 * level, -1, 0))
    dt = run.time_s[1] - run.time_s[0]
    gap, mean = max(round(settle_s / dt), 1), max(round(averaged_s / dt), 1)
    swings, last = [], -1
    for k in np.flatnonzero(side).tolist():
        if last >= 0 and side[k] != side[last]:
            before, after = error[max(last - gap - mean, 0) : last - gap + 1], error[k + gap : k + gap + mean]
            if before.size and after.size:
                swings.append(abs(after.mean() - before.mean()))
        last = k
    return np.array(swings)


def angle_spectrum(angle_rad: Floats, error_rad: Floats, share: float = 0.8) -> tuple[Floats, Floats]:
    """Orders (cycles per rad) and amplitudes (rad) of the error over the angle, root mean square over the sweeps.

    The middle ``share`` of each sweep is interpolated on an even grid of angles, its linear trend is removed, and a
    Hann window is applied.
    """
    half = share * np.abs(angle_rad).max()
    turns = np.flatnonzero(np.diff(np.sign(np.diff(angle_rad))) != 0) + 1
    edges = [0, *turns.tolist(), angle_rad.size]
    count = 4096
    grid = np.linspace(-half, half, count)
    window = np.hanning(count)
    powers = []
    for start, end in pairwise(edges):
        angle, error = angle_rad[start:end], error_rad[start:end]
        if not half > 0.0 or angle.min() > -half or angle.max() < half:
            continue
        order = np.argsort(angle, kind="stable")
        even = np.interp(grid, angle[order], error[order])
        even -= np.polyval(np.polyfit(grid, even, 1), grid)
        powers.append((2.0 / window.sum() * np.abs(np.fft.rfft(even * window))) ** 2)
    if not powers:
        raise ValueError("the run contains no whole sweep; run more cycles")
    return np.fft.rfftfreq(count, grid[1] - grid[0]), np.sqrt(np.mean(powers, axis=0))


def highest_peak(order: Floats, amplitude: Floats, lowest: float = LOWEST_ORDER) -> tuple[float, float]:
    """(order, amplitude) of the highest line above ``lowest`` cycles per rad: vertex of a parabola through logarithms.

    The distance of two bins of the spectrum is one over the length of a sweep; near its maximum the logarithm of a Hann
    window's spectrum is nearly a parabola.
    """
    k = int(np.argmax(np.where(order >= lowest, amplitude, 0.0)))
    if not 0 < k < order.size - 1 or not amplitude[k - 1 : k + 2].min() > 0.0:
        return float(order[k]), float(amplitude[k])
    left, top, right = np.log(amplitude[k - 1 : k + 2])
    shift = 0.5 * (left - right) / (left - 2.0 * top + right)
    return float(order[k] + shift * (order[1] - order[0])), float(np.exp(top - 0.25 * (left - right) * shift))


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
    if not settled.any():
        raise ValueError(f"the run ended at {run.time_s[-1]:.2f} s, before the first sweeps were over")
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
