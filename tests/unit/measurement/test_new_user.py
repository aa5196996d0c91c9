"""A new user's bench without a design: a stepper, a belt of 4:1, magnetic encoders on motor and arm, a weight on it.

The log is written as three loggers write it. What the bench is made of is computed here by hand: magnets off centre, a
play that follows the side of the weight, a compliance; counts of 4096 a turn that begin again.
"""

from __future__ import annotations

from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

import mbcdm_cad as mc
from mbcdm_cad.cli import run as mbcdm
from mbcdm_cad.errors import InputError

RATIO, MASS_KG, ARM_M = 4.0, 0.5, 0.2
PLAY, COMPLIANCE, MAGNET = 6e-3, 4e-3, 14e-3
ZERO = 1.2  # rad: what the arm's encoder shows where the weight hangs straight down


def bench(mass_kg: float = MASS_KG, seed: int = 5) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Time, steps, counts of motor and arm."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 120.0, 0.02) + rng.normal(0.0, 2e-4, 6000)
    arm = np.radians(150.0) * np.sin(2.0 * np.pi * t / 12.0)
    torque = mass_kg * 9.80665 * ARM_M * np.sin(arm)
    true = arm - COMPLIANCE * torque - 0.5 * PLAY * (np.sign(torque) if mass_kg else 0.0)
    read = true + MAGNET * np.sin(true + 1.0) + ZERO
    motor = RATIO * arm + 5e-3 * np.sin(RATIO * arm + 0.4) + 2.0

    def counts(angle: np.ndarray) -> np.ndarray:
        return np.asarray(np.round(angle / (2.0 * np.pi) * 4096 + rng.normal(0.0, 0.4, t.size)) % 4096)

    return t, np.round(RATIO * arm / (2.0 * np.pi) * 3200), counts(motor), counts(read)


def csv(folder: Path, rows: tuple[np.ndarray, ...]) -> Path:
    lines = ["time_s,steps,motor_as5600,arm_as5600"]
    lines += [f"{t:.5f},{steps:.0f},{motor:.0f},{arm:.0f}" for t, steps, motor, arm in zip(*rows, strict=True)]
    (folder / "run.csv").write_text("\n".join(lines) + "\n")
    return folder / "run.csv"


def monitor(folder: Path, rows: tuple[np.ndarray, ...]) -> Path:
    """A serial monitor with time stamps, of a sketch that writes labels for the plotter."""
    lines = ["AS5600 x2, stepper bench v2", "homing... done"]
    for t, steps, motor, arm in zip(*rows, strict=True):
        at = datetime(2026, 3, 1, 14) + timedelta(milliseconds=round(1e3 * float(t) + 10.0))
        stamp = f"{at:%H:%M:%S}.{at.microsecond // 1000:03d}"
        lines.append(f"{stamp} -> steps:{steps:.0f}\tmotor:{motor:.0f}\tarm:{arm:.0f}")
    (folder / "monitor.txt").write_bytes("\r\n".join(lines).encode() + b"\r\n")
    return folder / "monitor.txt"


def table(folder: Path, rows: tuple[np.ndarray, ...]) -> Path:
    """German settings: semicolons, decimal commas, degrees without counts of turns."""
    t, _, motor, arm = rows
    degrees = [np.degrees(np.unwrap(counts, period=4096) * 2.0 * np.pi / 4096) for counts in (motor, arm)]
    lines = ["Zeit [ms];Motorwinkel [°];Armwinkel [°]"]
    lines += [f"{1e3 * a:.2f};{b:.3f};{c:.3f}".replace(".", ",") for a, b, c in zip(t, *degrees, strict=True)]
    (folder / "labor.csv").write_text("\n".join(lines) + "\n")
    return folder / "labor.csv"


def load(mass_kg: float = MASS_KG) -> str:
    """What the user adds to the draft."""
    return f"load: {{pendulum: {{mass_kg: {mass_kg}, arm_mm: {1e3 * ARM_M}, vertical_deg: {np.degrees(ZERO):.3f}}}}}\n"


@pytest.mark.parametrize("write", [csv, monitor, table], ids=lambda write: write.__name__)
def test_the_draft_of_each_logger_gives_the_same_finding(
    write: object, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = write(tmp_path, bench())  # type: ignore[operator]
    assert mbcdm(["measurement-init", str(data), "--ratio", str(RATIO)]) == 0
    file = data.with_suffix(".yaml")
    assert capsys.readouterr().out.endswith(f"then: mbcdm loop {file}\n")
    text = file.read_text()
    assert "counts_per_turn: 4096" in text or write is table, text
    file.write_text(text + load())
    found = mc.close_loop(None, file).result
    play = next(one for one in found.effects if one.name == "lash").parameters["play_rad"]
    assert play.low < PLAY < play.high and play.high - play.low < 1e-3, found.sentence
    assert {one.name for one in found.effects} <= {"lash", "once_per_rev"}, found.sentence
    assert found.verdict == "explained" and found.errors.explained_share > 0.98, found.sentence


def test_another_weight_tells_the_compliance_from_the_magnet(tmp_path: Path) -> None:
    """With one weight alone a compliance and an encoder off centre are the same wave, as vetting says."""
    files = []
    for mass_kg in (MASS_KG, 2.0 * MASS_KG):
        folder = tmp_path / f"{mass_kg}"
        folder.mkdir()
        data = csv(folder, bench(mass_kg, seed=9))
        files.append(data.with_suffix(".yaml"))
        files[-1].write_text(mc.draft_measurement(data, ratio=RATIO) + load(mass_kg))
    alone = mc.close_loop(None, files[0])
    assert "a compliance in series looks like once_per_rev drum" in alone.text()
    # So neither is named alone, and nothing bounds the compliance from above.
    (either,) = (group for group in alone.result.one_of if group[0].stage == "drum")
    assert [one.name for one in either] == ["once_per_rev", "stiffness_error"], alone.result.sentence
    bound = either[1].parameters["compliance_rad_Nm"]
    assert bound.low == 0.0 and bound.high == np.inf, bound
    both = mc.close_loop(None, files).result
    named = {(one.name, one.stage): one for one in both.effects}
    magnet = named["once_per_rev", "drum"].parameters["amplitude_rad"]
    soft = named["stiffness_error", None].parameters["compliance_rad_Nm"]
    assert magnet.value == pytest.approx(MAGNET, abs=2e-4), both.sentence
    assert soft.value == pytest.approx(COMPLIANCE, rel=0.05), both.sentence


def test_what_is_soft_and_wound_up_by_friction_is_not_named_a_play(tmp_path: Path) -> None:
    """Without a sensor of the torque the two differ in nothing that a run of one bench shows."""
    rng = np.random.default_rng(2)
    t = np.arange(0.0, 100.0, 0.03)
    arm = np.radians(60.0) * np.sin(2.0 * np.pi * t / 12.0)
    held, half = np.zeros(t.size), 1.5e-3
    for k in range(1, t.size):  # the output waits until the spring has turned to the friction's torque
        held[k] = min(max(held[k - 1], arm[k] - half), arm[k] + half)
    step = 2.0 * np.pi / 16384
    read = np.round((held + step * rng.normal(0.0, 0.4, t.size)) / step) * step
    rows = [f"{a:.3f},{RATIO * b:.6f},{c:.6f}" for a, b, c in zip(t, arm, read, strict=True)]
    (tmp_path / "run.csv").write_text("\n".join(["t_s,motor_rad,arm_rad", *rows]) + "\n")
    file = tmp_path / "run.yaml"
    file.write_text(mc.draft_measurement(tmp_path / "run.csv", ratio=RATIO) + load().replace("68.755", "0.0"))
    result = mc.close_loop(None, file).result
    ((first, second),) = result.one_of
    assert {first.name, second.name} == {"friction", "lash"} and not result.effects, result.sentence
    friction = next(one for one in (first, second) if one.name == "friction").parameters["half_width_rad"]
    assert friction.low < half < friction.high, friction


def test_a_ratio_in_place_of_the_design(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = csv(tmp_path, bench())
    file = tmp_path / "run.yaml"
    text = mc.draft_measurement(data, ratio=RATIO).replace("ratio: 4\n", "")
    file.write_text(text)
    assert mbcdm(["loop", str(file)]) == 2
    assert "run.yaml:1: ratio: neither a design nor a ratio" in capsys.readouterr().err
    assert mbcdm(["loop", str(file), "--ratio", "4", "--json", str(tmp_path / "found.json")]) == 0
    said = capsys.readouterr().out
    assert "only the ratio is known: pulleys, preload and ropes" in said
    assert mbcdm(["loop", str(file), "--ratio", "4", "--apply", str(tmp_path / "built.yaml")]) == 2
    assert "leave --apply out" in capsys.readouterr().err
    file.write_text(text + "ratio: 4\n")
    assert mbcdm(["loop", str(file)]) == 0
    assert capsys.readouterr().out == said.replace(f"{tmp_path / 'found.json'} written\n", "")
    with pytest.raises(InputError, match="another ratio than --ratio"):
        mc.close_loop(None, file, ratio=5.0)
    # A design alone is not enough.
    assert mbcdm(["loop", str(tmp_path / "drive.yaml")]) == 2
