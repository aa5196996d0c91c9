"""A user's own bench: counts before the gearhead, degrees, a load cell in N with a tare, `measurement-init`, `loop`.

The logger is written apart from bench_real.py: it starts at any count, jitters, has a column of its own, and the
measurement file is the draft of ``mbcdm measurement-init`` with the one figure that the draft asks for.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.cli import run as mbcdm
from mbcdm_cad.layouts.loader import load_design
from tests.support.bench_data import drum_angle
from tests.support.bench_effects import Effect
from tests.support.bench_geometry import chain_of
from tests.support.bench_motion import Bench

DESIGN = Path(__file__).resolve().parents[2] / "params" / "mbcdm.yaml"
DRIVE = load_design(DESIGN).drive
COUNTS, DRUM_STEP_DEG, ARM_M, TARE_N = 4096, 7.8e-5, 0.080, 1.9
RUNOUT = Effect("once_per_rev", "output_encoder", {"amplitude_rad": 80e-6, "phase_rad": 0.7}, stage="drum")
LASH = Effect("lash", "input_play", {"play_rad": float(np.radians(0.3))}, stage="input_left")


def write_csv(path: Path, effects: tuple[Effect, ...], pendulum_Nm: float, brake_Nm: float) -> None:
    """160 s at 200 Hz under a pendulum and a brake; the two servos follow unlike and give way under load."""
    rng, chain = np.random.default_rng(1), chain_of(DRIVE)
    ratio = float(np.mean(chain.r_drum / chain.r_in))
    t = np.arange(0.0, 160.0, 0.005)
    target = 0.55 * np.sin(2.0 * np.pi * 0.05 * t)
    speed = np.gradient(target, t)
    load = pendulum_Nm * np.sin(target + 0.3) + brake_Nm * np.tanh(speed / 0.01)
    load -= load[0] * np.exp(-t / 0.3)
    servos = zip((12e-6, 22e-6), (0.7, 1.3), strict=True)
    inputs = np.array([ratio * (target - k * load + 8e-6 * np.sin(2.0 * np.pi * f * t + f)) for k, f in servos])
    bench = Bench(t, inputs, load, speed, np.full(t.size, 21.0))
    drum = drum_angle(chain, DRIVE.input_names, bench, effects, rng)
    turns = (inputs + rng.normal(0.0, 3e-5, inputs.shape)) * DRIVE.gearhead.ratio / (2.0 * np.pi)
    counts = np.round(turns * COUNTS) + np.array([[151234.0], [-88321.0]])
    degrees = np.round(np.degrees(drum + rng.normal(0.0, 4e-6, t.size) + 0.0123) / DRUM_STEP_DEG) * DRUM_STEP_DEG
    cell_N = load / ARM_M + TARE_N + rng.normal(0.0, 0.06, t.size)
    stamp = 1000.0 + t + rng.uniform(-2e-4, 2e-4, t.size)
    table = np.column_stack([stamp, *counts, degrees, cell_N, np.arange(t.size) % 7])
    header = "t_s,enc_left,enc_right,drum_deg,cell_N,state"
    forms = ["%.5f", "%d", "%d", "%.6f", "%.3f", "%d"]
    np.savetxt(path, table, fmt=forms, delimiter=",", header=header, comments="")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("effects", "loads_Nm", "name"),
    [((), (0.45, 0.35), None), ((RUNOUT,), (0.45, 0.35), "once_per_rev"), ((LASH,), (1.5, 0.5), "lash")],
    ids=["no effect", "80 urad of runout", "0.3 degrees of play"],
)
def test_from_the_csv_to_the_finding(
    effects: tuple[Effect, ...], loads_Nm: tuple[float, float], name: str | None, tmp_path: Path
) -> None:
    write_csv(tmp_path / "run.csv", effects, *loads_Nm)
    assert mbcdm(["measurement-init", str(tmp_path / "run.csv"), str(DESIGN)]) == 0
    draft = (tmp_path / "run.yaml").read_text()
    assert draft.count("side: motor") == 2 and draft.count("unit: deg") == 1 and "?" in draft, draft
    (tmp_path / "run.yaml").write_text(draft.replace("lever_arm_mm: '?'", f"lever_arm_mm: {1e3 * ARM_M}"))
    assert mbcdm(["loop", str(DESIGN), str(tmp_path / "run.yaml"), "--json", str(tmp_path / "found.json")]) == 0
    found = json.loads((tmp_path / "found.json").read_text())
    assert [one["name"] for one in found["effects"]] == ([name] if name else []), found["sentence"]
    assert not found["one_of"], found["sentence"]
    left, floor = (found["error"][key] for key in ("after_rad", "floor_rad"))
    assert left < 1.05 * floor, f"{1e6 * left:.2f} urad left, floor {1e6 * floor:.2f} urad"
    if name == "once_per_rev":
        size = found["effects"][0]["parameters"]["amplitude_rad"]
        assert size["ci95"][0] < 80e-6 < size["ci95"][1], size
        assert found["effects"][0]["stage"] == "drum", found["sentence"]
    if name == "lash":
        assert found["effects"][0]["stage"] == "input_left", found["sentence"]
        # The pulley does not reach the far face: a lower bound.
        assert found["effects"][0]["parameters"]["play_rad"]["value"] < np.radians(0.3), found["sentence"]
