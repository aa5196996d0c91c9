"""A known weight on an arm in place of a torque sensor: its torque by closed form, what the loop finds with it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from mbcdm_cad.errors import InputError
from mbcdm_cad.loop.search.engine import close_loop
from mbcdm_cad.measurement.file import load_file
from mbcdm_cad.measurement.loads import acceleration_rad_s2
from mbcdm_cad.measurement.reading import load_measurement
from mbcdm_cad.measurement.reference import measurement_page

MASS_KG, ARM_M, INERTIA, VERTICAL = 1.5, 0.2, 0.01, 0.3
PENDULUM = {
    "mass_kg": MASS_KG,
    "arm_mm": 1e3 * ARM_M,
    "inertia_kg_m2": INERTIA,
    "vertical_deg": float(np.degrees(VERTICAL)),
}


def written(folder: Path, t: np.ndarray, motor: np.ndarray, out: np.ndarray, load: object) -> Path:
    table = np.column_stack([t, motor, out])
    np.savetxt(folder / "run.csv", table, delimiter=",", header="t,motor,out", comments="", fmt="%.9f")
    columns = {
        "time": {"column": "t", "unit": "s"},
        "input": {"column": "motor", "unit": "rad"},
        "output": {"column": "out", "unit": "rad"},
    }
    path = folder / "run.yaml"
    path.write_text(yaml.safe_dump({"data": "run.csv", "ratio": 5.0, "columns": columns, "load": load}))
    return path


def swung(hz: float, seconds: float, step_s: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time, angle, and the torque of the weight from the angle's own derivatives."""
    t = np.arange(0.0, seconds, step_s)
    w = 2.0 * np.pi * hz
    angle = 0.4 * np.sin(w * t)
    inertia = INERTIA + MASS_KG * ARM_M**2
    torque = MASS_KG * 9.80665 * ARM_M * np.sin(angle - VERTICAL) - inertia * 0.4 * w**2 * np.sin(w * t)
    return t, angle, torque


@pytest.mark.parametrize("hz", [0.1, 1.0, 10.0])
def test_the_torque_of_a_weight_is_that_of_the_closed_form(tmp_path: Path, hz: float) -> None:
    t, angle, torque = swung(hz, 12.0 / hz, 0.01 / max(hz, 0.5))
    noisy = angle + 2e-6 * np.random.default_rng(1).standard_normal(t.size)
    run = load_measurement(written(tmp_path, t, 5.0 * angle, noisy, {"pendulum": PENDULUM}))
    assert run.load_Nm is not None
    inside = slice(t.size // 12, -t.size // 12)
    inertia = (INERTIA + MASS_KG * ARM_M**2) * 0.4 * (2.0 * np.pi * hz) ** 2
    wrong = float(np.abs(run.load_Nm - torque)[inside].max()) / max(inertia, MASS_KG * 9.80665 * ARM_M)
    assert wrong < 0.01, f"{wrong:.2%} of the largest torque at {hz} Hz"


def test_the_acceleration_of_uneven_samples() -> None:
    t = np.cumsum(np.random.default_rng(2).uniform(0.8e-3, 1.2e-3, 4000))
    found = acceleration_rad_s2(0.3 * np.sin(20.0 * t), t)
    assert np.allclose(found[100:-100], -120.0 * np.sin(20.0 * t[100:-100]), atol=2.0), np.abs(found).max()


@pytest.mark.parametrize(("hz", "swings"), [(0.15, 12), (1.5, 40)])
def test_a_soft_shaft_is_found_with_a_weight_in_place_of_a_torque_sensor(
    tmp_path: Path, hz: float, swings: int
) -> None:
    """Slowly by the weight alone, fast with its inertia: at 1.5 Hz that is 9 times the weight's own change."""
    t, angle, torque = swung(hz, swings / hz, 0.02 / hz / 2.0)
    out = angle - 2e-3 * torque + 2e-5 * np.random.default_rng(3).standard_normal(t.size)
    run = load_measurement(written(tmp_path, t, 5.0 * angle, out, {"pendulum": PENDULUM}))
    result = close_loop(None, [run])
    names = [one.name for one in result.effects] + [one.name for group in result.one_of for one in group]
    assert "stiffness_error" in names, result.sentence
    found = next(one for one in (*result.effects, *sum(result.one_of, ())) if one.name == "stiffness_error")
    assert found.parameters["compliance_rad_Nm"].value == pytest.approx(2e-3, rel=0.05), result.sentence


def test_a_pendulum_is_refused_with_its_line(tmp_path: Path) -> None:
    t, angle, _ = swung(0.2, 20.0, 0.05)
    with pytest.raises(InputError, match=r"run.yaml:\d+: load.*mass_kg"):
        load_file(written(tmp_path, t, angle, angle, {"pendulum": {"mass_kg": -1.0, "arm_mm": 100.0}}))
    with pytest.raises(InputError, match=r"run.yaml:\d+: load"):
        load_file(written(tmp_path, t, angle, angle, "some"))


def test_the_reference_page_has_the_load() -> None:
    assert "| `vertical_deg` | deg |" in measurement_page() and "`load: none`" in measurement_page()
