"""What the model says of a design, as text for a terminal."""

from __future__ import annotations

import json
from collections.abc import Sequence

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.model import Analysis, analyse
from mbcdm_cad.report.paths import path_data_or_reason, path_lines


def _list(values: Sequence[float], digits: int = 2) -> str:
    return ", ".join(f"{v:.{digits}f}" for v in values)


def analysis_text(a: Analysis) -> str:
    """Figures by subject; the modulus in use and what the paper's backlash implies for it come first."""
    readings = ", ".join(f"{r.modulus_GPa:.1f} GPa ({r.reading}, {r.route})" for r in a.implied_modulus)
    lines = [
        f"{a.name}: E = {a.modulus_GPa:g} GPa on the {a.modulus_area} area {a.area_mm2:.4f} mm^2, "
        f"EA = {a.axial_stiffness_kN:.2f} kN, mu = {a.friction_coefficient:g}",
        f"  the paper's {a.measured_backlash_mrad:g} mrad at 70 N, 0.91 N m implies E = {readings}",
        f"  Eq. (1) is missed by {a.eq1_worst_residual:.3g} at most; over the travel the cables of a pair differ by "
        f"{_list(a.pair_mismatch_mm, 4)} mm ({', '.join(dict.fromkeys(c.input_name for c in a.cables))}), "
        f"tensions change by up to {a.pair_mismatch_N:.2f} N",
        *(
            f"  {t.cable_name:<10} drum {t.drum_deg:+g} deg: guide {t.guide_deg:+.2f}, input {t.input_deg:+.2f}, motor "
            f"{t.motor_deg:+.1f} deg"
            for t in a.shaft_turns
        ),
        "",
        "cable      input  preload N   span mm  T_h N    T_l N    backlash mrad (exact, simplified)",
    ]
    lines += [
        f"{c.name:<10} {c.input_name:<6} {c.preload_N:9.2f} {c.free_span_mm:9.2f} {c.high_tension_N:8.3f} "
        f"{c.low_tension_N:8.3f} {c.backlash_mrad:9.5f} {c.backlash_simplified_mrad:9.5f}"
        for c in a.cables
    ]
    lines += ["", "all cables, inputs locked:"]
    for case in (*a.test, *a.peak):
        slack = f", slack: {sum(case.slack)} cable(s)" if any(case.slack) else ""
        lines.append(
            f"  {case.load_Nm:+.2f} N m: turn {case.turn_mrad:+.4f} mrad, tensions {_list(case.tension_N)} N, "
            f"shares {_list(case.load_share, 3)}, inputs {_list(case.input_torque_mNm, 1)} mN m, "
            f"stiffness {case.tangent_stiffness_Nm_rad:.0f} tangent, {case.secant_stiffness_Nm_rad:.0f} secant N m/rad"
            f"{slack}"
        )
    lines += [
        f"  swing at a reversal {a.reversal_swing_mrad:.4f} mrad",
        "",
        f"preload alone loads the inputs by {_list(a.input_bias_mNm, 1)} mN m",
        f"peak torque + / -: {_list(a.peak_torque_Nm, 3)} N m (gearhead lossless, as in the paper), "
        f"{_list(a.peak_torque_with_efficiency_Nm, 3)} N m with its efficiency",
        f"  with preloads T ~ 1/r ({_list(a.balanced_preload_N)} N): {_list(a.balanced_peak_torque_Nm, 3)} N m",
    ]
    lines += [
        f"  limit {limit.direction:+d}: {limit.cause} of {limit.limiting} at {limit.torque_Nm:.3f} N m"
        for limit in a.limits
    ]
    lines.append(f"torque to weight at the target mass: {a.torque_to_weight_Nm_kg:.3f} N m/kg")
    lines += [
        f"bearings at {b.load_Nm:+.2f} N m: inputs {_list(b.input_radial_N, 1)} N, guide {b.guide_radial_N:.1f} N and "
        f"{b.guide_moment_Nm:.3f} N m, drum {b.drum_radial_N:.1f} N"
        for b in a.bearings
    ]
    if a.intervals:
        lines += ["", "95 % intervals from the sigmas in the design file:"]
    lines += [
        f"  {x.name:<22} {x.value:9.4f} {x.unit:<4}  {x.low:9.4f} to {x.high:9.4f}  (sigma {x.sigma:.4f})"
        for x in a.intervals
    ]
    lines += ["", *(f"note: {note}" for note in a.notes)]
    return "\n".join(lines)


def analysis_outputs(drive: Drive) -> dict[str, bytes]:
    """What the analyse command prints, plain and as JSON."""
    analysis = analyse(drive)
    paths, why = path_data_or_reason(drive)
    lines = [analysis_text(analysis), "", *(path_lines(paths) if paths else [f"cable paths: {why}"])]
    return {
        "plain": "\n".join(lines).encode(),
        "json": json.dumps(analysis.to_dict() | {"paths": paths}, indent=1, allow_nan=False).encode(),
    }
