"""Compute every figure of the model that the report prints, in one call."""

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.model import capability, equations, stiffness
from mbcdm_cad.model.creep import preload_left
from mbcdm_cad.model.equilibrium import bearing_loads, solve_equilibrium
from mbcdm_cad.model.figures import (
    Analysis,
    BearingFigures,
    CableFigures,
    LoadCase,
    ModulusReading,
    PassedLoad,
    ShaftTurns,
    UncertainFigure,
    readable_figure,
)
from mbcdm_cad.model.sensitivity import intervals
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.model.wrap import slip_angle_rad

# Ratings of what stands between the motor and the input.
_PASSED_ON = (capability.GEARHEAD, capability.GEARHEAD_PEAK)


def analyse(design: capability.Modelled, wraps_rad: tuple[Any, Any] | None = None) -> Analysis:
    """Every figure of the model for one design.

    ``wraps_rad`` are the live wraps (input, drum) of each cable at the pose of interest, both (n_cables,); without them
    wraps are assumed to be longer than any slip zone. Raises ``ModelError`` where the geometry leaves no free span.
    """
    drive, d = design.drive, design.si
    if wraps_rad is not None:
        d = d.with_(input_wrap_rad=wraps_rad[0], drum_wrap_rad=wraps_rad[1])
    test, peak = drive.loads.test_torque_Nm, drive.loads.peak_torque_Nm
    endless = _endless(d)
    strength, balanced = capability.tension_limit_N(drive), capability.balanced_preload_N(d)
    torques = _peak_torques(design, d, strength)
    balanced_torques = _peak_torques(design, d.with_(preload_N=balanced), strength)
    peaks = (load_case(d, peak), load_case(d, -peak))
    mismatch_mm, mismatch_N = pair_mismatch(d, np.radians(drive.half_travel_deg))
    of_an_input_Nm = max(abs(torque) for case in peaks for torque in case.input_torque_mNm) * 1e-3
    no_motor = (limit.torque_Nm for limit in torques.limits if limit.cause in ("strength", "slack", capability.SLIP))
    return Analysis(
        name=drive.name,
        friction_coefficient=float(d.friction_coefficient),
        modulus_GPa=drive.cable.modulus_GPa,
        modulus_area=drive.cable.modulus_area,
        area_mm2=drive.cable.area_mm2,
        axial_stiffness_kN=float(d.axial_stiffness_N) / 1e3,
        lengths=design.routed.shown,
        shaft_turns=shaft_turns(d, drive),
        eq1_worst_residual=equations.eq1_residuals(d).worst,
        pair_mismatch_mm=mismatch_mm,
        pair_mismatch_N=mismatch_N,
        cables=cable_figures(d, test),
        test=(load_case(d, test), load_case(d, -test)),
        peak=peaks,
        reversal_swing_mrad=_swing_mrad(endless, test),
        sticking_stiffness_Nm_rad=float(stiffness.sticking_stiffness_Nm_rad(d)),
        input_bias_mNm=_floats(capability.input_bias_Nm(d) * 1e3),
        limits=torques.limits,
        losses_counted=drive.limits.counts_losses,
        peak_torque_Nm=torques.counted_Nm,
        peak_torque_lossless_Nm=torques.lossless_Nm,
        peak_torque_with_losses_Nm=torques.with_losses_Nm,
        balanced_preload_N=_floats(balanced),
        balanced_peak_torque_Nm=balanced_torques.counted_Nm,
        torque_to_weight_Nm_kg=(
            None
            if drive.targets.mass_g is None
            else capability.torque_to_weight_Nm_kg(min(torques.counted_Nm), drive.targets.mass_g)
        ),
        bearings=tuple(bearing_figures(d, load) for load in (0.0, peak, -peak)),
        creep=preload_left(drive.cable, max(c.preload_N for c in drive.cables), design.softer_ends),
        motor=capability.motor_figures(design, d, of_an_input_Nm, min(no_motor, default=np.inf)),
        measured_backlash_mrad=equations.BACKLASH_RAD * 1e3,
        implied_modulus=modulus_readings(endless),
        intervals=uncertain_figures(endless, design),
        notes=notes(drive, d),
    )


@dataclass(frozen=True)
class PeakTorques:
    """Limits of the torque, and (for +, for -) the lowest of them in N m.

    ``counted_Nm``: losses as the design's ``limits.losses`` says.
    """

    limits: tuple[capability.TorqueLimit, ...]
    counted_Nm: tuple[float, float]
    lossless_Nm: tuple[float, float]
    with_losses_Nm: tuple[float, float]


def peak_torques(design: capability.Modelled) -> PeakTorques:
    """The peak torques of :func:`analyse` alone. Raises ``ModelError`` as it does."""
    return _peak_torques(design, design.si, capability.tension_limit_N(design.drive))


def reversal_swing_mrad(design: capability.Modelled) -> float:
    """The swing of :func:`analyse` alone. Raises ``ModelError`` as it does."""
    return _swing_mrad(_endless(design.si), design.drive.loads.test_torque_Nm)


def _endless(d: DriveSI) -> DriveSI:
    return d.with_(input_wrap_rad=np.full(d.n_cables, np.inf), drum_wrap_rad=np.full(d.n_cables, np.inf))


def _swing_mrad(endless: DriveSI, load_Nm: float) -> float:
    return float(stiffness.drum_backlash(endless, load_Nm).reversal_swing_rad) * 1e3


def _peak_torques(design: capability.Modelled, d: DriveSI, strength_N: float) -> PeakTorques:
    drive = design.drive
    limits, lossless = _limits(design, d, strength_N), capability.motor_rating(drive)
    in_force = capability.MOTOR_LOSSY if drive.limits.counts_losses else lossless
    counted, free, lossy = (lowest_each_way(limits, cause) for cause in (in_force, lossless, capability.MOTOR_LOSSY))
    return PeakTorques(limits, counted, free, lossy)


def _limits(design: capability.Modelled, d: DriveSI, strength_N: float) -> tuple[capability.TorqueLimit, ...]:
    """Limits of the torque; those of the gearhead without losses only where these do not count."""
    drive = design.drive
    ratings, train = capability.input_ratings_Nm(drive), design.losses.with_drive(d)
    raised = {capability.MOTOR_LOSSY: partial(train.raised_Nm, train.output_Nm(drive.motor.rated_torque_mNm * 1e-3))}
    if drive.limits.counts_losses:
        raised |= {cause: partial(train.raised_Nm, ratings.pop(cause)) for cause in _PASSED_ON if cause in ratings}
    ends = design.wraps_at_ends_rad if np.isinf(d.drum_wrap_rad).all() else ()
    return capability.torque_limits(d, ratings, strength_N, raised, ends)


def shaft_turns(d: DriveSI, drive: Drive) -> tuple[ShaftTurns, ...]:
    """Angles of all shafts at the end of the travel, from each cable: they differ where Eq. (1) does not hold."""
    found = []
    for j, name in enumerate(d.cable_names):
        turned = equations.shaft_angles(d, d.routes.drum.name, np.radians(drive.half_travel_deg), j, drive.motor_turns)
        found.append(ShaftTurns(name, {shaft: float(np.degrees(angle)) for shaft, angle in turned.items()}))
    return tuple(found)


def uncertain_figures(d: DriveSI, design: capability.Modelled) -> tuple[UncertainFigure, ...]:
    """Backlash of each cable and of the drum, swing and peak torques with intervals; none where no sigma is given."""
    sigmas = capability.sigmas_si(design)
    if not sigmas:
        return ()
    found = []
    for name, x in intervals(d, capability.requirements(design), sigmas).items():
        plain, unit, scale = readable_figure(name)
        found.append(UncertainFigure(plain, unit, *(scale * v for v in (x.value, x.low, x.high, x.sigma))))
    return tuple(found)


def lowest_each_way(limits: tuple[capability.TorqueLimit, ...], rating: str) -> tuple[float, float]:
    """(for +, for -): the lowest of one rating, cable strength, slack and slip, N m."""

    def lowest(direction: int) -> float:
        causes = (rating, "strength", "slack", capability.SLIP)
        return min(limit.torque_Nm for limit in limits if limit.direction == direction and limit.cause in causes)

    return lowest(1), lowest(-1)


def cable_figures(d: DriveSI, load_Nm: float) -> tuple[CableFigures, ...]:
    """Each cable by the paper's formulas at ``load_Nm``."""
    figures = stiffness.cable_backlash(d, load_Nm)
    return tuple(
        CableFigures(
            name=name,
            input_name=d.input_names[d.input_of[j]],
            sigma=int(d.sigma[j]),
            total_ratio=float(d.total_ratio[j]),
            free_span_mm=float(d.free_span_m[j]) * 1e3,
            preload_N=float(d.preload_N[j]),
            kappa=float(d.kappa[j]),
            high_tension_N=float(figures.high_N[j]),
            low_tension_N=float(figures.low_N[j]),
            high_tension_simplified_N=float(figures.high_simplified_N[j]),
            low_tension_simplified_N=float(figures.low_simplified_N[j]),
            backlash_mrad=float(figures.backlash_rad[j]) * 1e3,
            backlash_simplified_mrad=float(figures.backlash_simplified_rad[j]) * 1e3,
        )
        for j, name in enumerate(d.cable_names)
    )


def load_case(d: DriveSI, load_Nm: float) -> LoadCase:
    """All cables at once under ``load_Nm``, not zero."""
    at = solve_equilibrium(d, load_Nm)
    idle = solve_equilibrium(d, 0.0)
    slip = slip_angle_rad(np.maximum(at.tension_N, 0.0), d.preload_N, d.friction_coefficient)
    return LoadCase(
        load_Nm=load_Nm,
        turn_mrad=float(at.drum_angle_rad - idle.drum_angle_rad) * 1e3,
        tension_N=_floats(at.tension_N),
        slip_angle_deg=_floats(np.degrees(slip)),
        slack=tuple(bool(is_slack) for is_slack in at.slack),
        input_torque_mNm=_floats(at.input_torque_Nm(d) * 1e3),
        load_share=_floats(at.load_share(d, load_Nm)),
        tangent_stiffness_Nm_rad=float(stiffness.tangent_stiffness_Nm_rad(d, load_Nm)),
        secant_stiffness_Nm_rad=float(stiffness.secant_stiffness_Nm_rad(d, load_Nm)),
    )


def bearing_figures(d: DriveSI, load_Nm: float) -> BearingFigures:
    """Magnitudes of the bearing loads under ``load_Nm``."""
    loads = bearing_loads(d, solve_equilibrium(d, load_Nm).tension_N)
    return BearingFigures(
        load_Nm=load_Nm,
        input_radial_N=tuple(float(np.linalg.norm(load.force_N)) for load in loads.inputs),
        passed=tuple(
            PassedLoad(
                body.name,
                float(np.linalg.norm(loads.bodies[body.name].force_N)),
                float(np.linalg.norm(loads.bodies[body.name].moment_Nm)),
            )
            for body in d.routes.passed
        ),
        drum_radial_N=float(np.linalg.norm(loads.drum.force_N)),
    )


def pair_mismatch(d: DriveSI, half_travel_rad: float) -> tuple[tuple[float, ...], float]:
    """Over the travel, drum unloaded: pair mismatch of each input in mm, largest change of a tension in N."""
    angle = half_travel_rad * d.input_turns
    length = np.abs(np.array([equations.pair_mismatch_m(d, angle[i])[i] for i in range(d.n_inputs)]))
    idle = solve_equilibrium(d, 0.0).tension_N
    ends = [solve_equilibrium(d, 0.0, input_angle_rad=sign * angle).tension_N for sign in (1.0, -1.0)]
    return _floats(length * 1e3), float(max(np.abs(tension - idle).max() for tension in ends))


def modulus_readings(d: DriveSI) -> tuple[ModulusReading, ...]:
    """E implied by the paper's 0.33 mrad at 0.91 N m under both readings and by both routes."""
    return tuple(
        ModulusReading(
            reading,
            route,
            stiffness.implied_modulus_Pa(d, equations.BACKLASH_RAD, equations.BACKLASH_TORQUE_NM, reading, route) / 1e9,
        )
        for reading in ("reversal", "single")
        for route in ("mean_radii", "all_cables")
    )


def notes(drive: Drive, d: DriveSI) -> tuple[str, ...]:
    """Notes that a reader must know before using the figures."""
    origin = (
        f"is calibrated: the paper prints no modulus, and its backlash of {equations.BACKLASH_RAD * 1e3:g} mrad "
        "implies a different one under each reading, and another where the structure counts"
        if equations.papers_test(drive.loads.test_torque_Nm)
        else "is a table value or the file's, not measured on this rope: what the cables stretch goes with 1/E"
    )
    return (
        f"E = {drive.cable.modulus_GPa:g} GPa on the {drive.cable.modulus_area} area {drive.cable.area_mm2:.4f} mm^2 "
        f"{origin}.",
        *_train(drive),
        _losses(drive, d),
    )


def _train(drive: Drive) -> tuple[str, ...]:
    """Motor and gearhead with their sources."""
    gear = drive.gearhead
    in_force = (
        "Peak torque counts all losses (limits.losses: counted)."
        if drive.limits.counts_losses
        else "Peak torque counts no losses, as the paper does (limits.losses: paper); with them it is printed too."
    )
    motor = f"Motor {drive.motor.name}: {drive.motor.rated_torque_mNm:g} mN m [{drive.motor.source}]."
    if gear.absent:
        return in_force, motor, "There is no gearhead: the motor's shaft turns the input."
    return (
        in_force,
        motor,
        f"Gearhead {gear.name}: {gear.ratio:g}:1, efficiency {gear.efficiency:g}, {gear.rated_torque_mNm:g} mN m "
        f"continuous, {gear.max_torque_mNm:g} at most [{gear.source}].",
    )


def _losses(drive: Drive, d: DriveSI) -> str:
    """Note on the losses along the rope that the model leaves out."""
    passed = [body.name for body in d.routes.passed]
    if not passed:
        return "The rope's bending stiffness is left out."
    names, test = " and the ".join(passed), np.array([0.0, drive.loads.test_torque_Nm])
    with_slip, without = (
        abs(float(np.diff(solve_equilibrium(each, test).drum_angle_rad)[0]))
        for each in (d.with_passed_slip, d.without_passed_slip)
    )
    more = f"about {100.0 * (with_slip / without - 1.0):.0f} % to the backlash"
    slip = f"adds {more}, as the design file counts it" if d.slips_on_passed else f"would add {more}"
    return (
        f"Turns and tensions leave out friction at the {names} and the rope's bending stiffness; slip on the {names}'s "
        f"wraps {slip}."
    )


def _floats(values: Any) -> tuple[float, ...]:
    return tuple(float(value) for value in np.ravel(values))
