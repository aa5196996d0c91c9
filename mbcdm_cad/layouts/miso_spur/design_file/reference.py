"""The reference design of miso_spur: two inputs of siso_spur's reference, except where their number matters."""

from __future__ import annotations

from collections.abc import Iterable

from mbcdm_cad.design.design_file import Given
from mbcdm_cad.layouts.siso_spur.design_file.reference import SHARED as OF_ONE_INPUT

INPUTS = [{"name": "upper"}, {"name": "lower"}]


def sides(inputs: Iterable[str]) -> list[dict[str, str]]:
    """Both sides of a cable for each of these inputs, as entries of ``cables``."""
    return [
        {"name": f"{name}_{n}", "input": name, "drum_side": side}
        for name in inputs
        for n, side in enumerate(("+x", "-x"), 1)
    ]


CABLES = sides(item["name"] for item in INPUTS)

SHARED = OF_ONE_INPUT | {
    "name": Given("miso_spur"),
    "support.plate_mm": Given(6.5, "the second yoke is one sector further from it than that of siso_spur"),
    "support.bridge_mm": Given(7.0, "as the plate"),
    "loads.test_torque_Nm": Given(1.24, "0.29 of the peak torque, as in miso_bevel"),
    "loads.peak_torque_Nm": Given(4.3, "two motors with gearheads: 4.36"),
    "limits.frame_windup_max_mrad": Given(0.03, "a choice: a seventh of the windup of the cables"),
    "targets.mass_g": Given(415.0, "as drawn"),
    "targets.envelope_mm": Given([124.0, 172.8, 107.1], "as drawn"),
}
