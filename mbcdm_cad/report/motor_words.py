"""The motor's figures in words and as a table, for terminal and report."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mbcdm_cad.report.table import ReportTable


def motor_lines(m: Mapping[str, Any]) -> tuple[str, ...]:
    """Sentences on ``analysis.motor``: its torque, the torque that the design requires, the inertia of its rotors."""
    return (
        f"Motor at {m['bus_voltage_V']:g} V: {m['continuous_torque_mNm']:.4g} mN m continuous with "
        f"{m['continuous_loss_W']:.3g} W lost in the copper, {m['peak_torque_mNm']:.4g} mN m short-time with "
        f"{m['peak_loss_W']:.3g} W; no load {m['no_load_speed_rad_s']:.4g} rad/s, which turns the drum at "
        f"{m['drum_no_load_speed_deg_s']:.4g} deg/s",
        f"At the required peak torque: {m['at_peak_load_torque_mNm']:.4g} mN m, {m['at_peak_load_current_A']:.3g} A, "
        f"{m['at_peak_load_loss_W']:.3g} W for each motor; the drum at most "
        f"{m['at_peak_load_drum_speed_deg_s']:.4g} deg/s",
        f"Rotors reflected to the drum {m['reflected_inertia_kg_m2'] * 1e3:.4g} g m^2; lowest mode "
        f"{m['mode_inputs_held_Hz']:.4g} Hz with the inputs held, {m['mode_inputs_free_Hz']:.4g} Hz against the free "
        "rotors",
    )


def curve_table(m: Mapping[str, Any]) -> ReportTable:
    """Torque at the drum over its speed."""
    rows = tuple(
        (f"{p['drum_speed_deg_s']:.0f}", f"{p['continuous_Nm']:.3f}", f"{p['peak_Nm']:.3f}") for p in m["curve"]
    )
    return ReportTable(("drum deg/s", "continuous N m", "short-time N m"), rows)
