"""Frequency responses: two masses in closed form on benches that differ from what a file declares, and the rig."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from scipy.signal import chirp, cont2discrete, lfilter

import mbcdm_cad as mc
from mbcdm_cad.cli import run as mbcdm
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.lumped import compliance_of
from mbcdm_cad.loop.judge import LoopReport
from mbcdm_cad.loop.result import LoopResult
from mbcdm_cad.model.si import to_si
from mbcdm_cad.model.stiffness import sticking_stiffness_Nm_rad
from mbcdm_cad.planning.plan import plan_of

ROOT = Path(__file__).parents[3]
DESIGN, EXPERIMENT = ROOT / "params/mbcdm.yaml", ROOT / "params/experiments/response/chirp-plate.yaml"
PLATE_KG_M2, RATE_HZ, FINE, RATIO = 0.05, 1000.0, 5, 9.0


@cache
def reference() -> mc.DriveDesign:
    return mc.load(DESIGN)


@dataclass(frozen=True)
class TwoMasses:
    """A payload on a spring and a damper behind inputs that are moved by a chirp of 4 to 120 Hz; SI, at the output."""

    frequency_Hz: float = 47.3
    damping: float = 0.05
    inertia_kg_m2: float = PLATE_KG_M2
    delay_s: float = 0.0
    filter_s: float = 0.0
    wander_rad: float = 0.0
    torque_drift_Nm: float = 0.0
    jitter: float = 0.0
    size_rad_s2: float = 0.02
    noise_rad: float = 4e-10

    def table(self, seed: int) -> dict[str, np.ndarray]:
        """Columns of a log of 20 s. The servo lags behind its command, by a filter of 10 ms."""
        rng, dt = np.random.default_rng(seed), 1.0 / RATE_HZ / FINE
        t = np.arange(round(20.0 / dt)) * dt
        rate = 2.0 * np.pi * (4.0 + 116.0 * t / t[-1])
        command = chirp(t, 4.0, t[-1], 120.0, phi=-90.0) * self.size_rad_s2 / rate**2 * np.minimum(1.0, 2.0 * t)
        moved = command + lfilter([dt / 0.01], [1.0, dt / 0.01 - 1.0], command)
        w, z = 2.0 * np.pi * self.frequency_Hz, self.damping

        def through(top: list[float], bottom: list[float], values: np.ndarray) -> np.ndarray:
            b, a, _ = cont2discrete((top, bottom), dt, "foh")
            return np.asarray(lfilter(b.ravel(), a, values))

        output = through([2.0 * z * w, w**2], [1.0, 2.0 * z * w, w**2], moved)
        twist = moved - output
        torque = self.inertia_kg_m2 * (w**2 * twist + 2.0 * z * w * np.gradient(twist, dt))
        read = through([1.0], [self.filter_s, 1.0], output) if self.filter_s else output
        at = t[::FINE] * (
            1.0 + self.jitter * rng.uniform(0.0, 1.0 / RATE_HZ, t[::FINE].size) / np.maximum(t[::FINE], 1.0)
        )
        walk = np.cumsum(rng.normal(0.0, 1.0, at.size))
        return {
            "t": at,
            "command": np.interp(at, t, command),
            "q_in": RATIO * np.interp(at, t, moved) + rng.normal(0.0, RATIO * self.noise_rad, at.size),
            "q_out": np.interp(at - self.delay_s, t, read)
            + rng.normal(0.0, self.noise_rad, at.size)
            + self.wander_rad * walk,
            "tau": np.interp(at, t, torque) + rng.normal(0.0, 4e-5, at.size) + self.torque_drift_Nm * walk,
        }


def judged(folder: Path, bench: TwoMasses, *without: str, design: bool = False, seed: int = 1) -> LoopReport:
    """Judge a log of the bench, with or without the reference design and without some of its columns."""
    table = {name: values for name, values in bench.table(seed).items() if name not in without}
    np.savetxt(
        folder / "log.csv", np.stack(list(table.values()), axis=1), "%.14g", ",", header=",".join(table), comments=""
    )
    units = {"t": "s", "tau": "N*m"}
    keys = {"t": "time", "command": "excitation", "q_out": "output", "tau": "load_torque"}
    inputs = ("input_left", "input_right") if design else ("input",)
    columns = {keys[name]: {"column": name, "unit": units.get(name, "rad")} for name in table if name in keys}
    columns |= {name: {"column": "q_in", "unit": "rad"} for name in inputs}
    content: dict[str, Any] = {"data": "log.csv", "kind": "frequency_response", "columns": columns}
    if design:
        content |= {"parts": {"output_at": "payload"}, "inertia_plate": {"inertia_kg_m2": PLATE_KG_M2}}
    else:
        content["ratio"] = RATIO
    (folder / "log.yaml").write_text(yaml.safe_dump(content))
    return mc.close_loop(reference() if design else None, folder / "log.yaml")


def designed(give: float = 1.0, inertia: float = 1.0) -> TwoMasses:
    """The bench with the small-motion mode of the reference design, whose compliance and payload differ by factors."""
    drive = reference().loaded.drive
    whole = 1.0 / float(sticking_stiffness_Nm_rad(to_si(drive))) + compliance_of(drive).land_to_payload
    payload = inertia * PLATE_KG_M2
    return TwoMasses(1.0 / np.sqrt(give * whole * payload) / (2.0 * np.pi), inertia_kg_m2=payload)


def forms(result: LoopResult) -> set[str]:
    """Names of what was found, with the members of sets."""
    return {one.name for one in (*result.effects, *(one for group in result.one_of for one in group))}


@pytest.mark.parametrize(
    ("bench", "without"),
    [
        (TwoMasses(), ()),
        (TwoMasses(frequency_Hz=71.0, damping=0.012), ("command", "tau")),
        (TwoMasses(delay_s=0.00037, wander_rad=4e-8), ("tau",)),  # a third of a sample; coherence poor below 15 Hz
        (TwoMasses(filter_s=0.0008), ()),
        (TwoMasses(delay_s=-0.0011, noise_rad=4e-9), ()),
        (TwoMasses(damping=0.09, jitter=0.3), ()),
    ],
)
def test_the_mode_of_two_masses_and_the_delay_of_the_bench(
    bench: TwoMasses, without: tuple[str, ...], tmp_path: Path
) -> None:
    report = judged(tmp_path, bench, *without)
    result = report.result
    assert result.verdict == "explained", result.sentence
    found = {one.name: next(iter(one.parameters.values())) for one in result.effects}
    assert set(found) == {"torsional_mode"} | ({"delay"} if bench.delay_s or bench.filter_s else set()), result.sentence
    assert found["torsional_mode"].value == pytest.approx(bench.frequency_Hz, rel=0.003)
    (mode,) = result.modes
    assert mode.frequency_Hz.low - 0.1 < bench.frequency_Hz < mode.frequency_Hz.high + 0.1, mode.words
    assert mode.damping_share.value == pytest.approx(bench.damping, rel=0.06), mode.words
    if "delay" in found:
        assert found["delay"].value == pytest.approx(bench.delay_s or bench.filter_s, abs=2e-5), result.sentence
    assert ("interpolated: high frequencies" in report.text()) == (bench.jitter > 0.0)
    assert b"data:image/png" in report.page()
    assert f"{mode.frequency_Hz.value:.4g} Hz" in report.text()


def test_a_drive_as_designed_gets_no_name(tmp_path: Path) -> None:
    for seed in range(3):
        result = judged(tmp_path, replace(designed(), torque_drift_Nm=2e-5), design=True, seed=seed).result
        assert result.verdict == "none", result.sentence
        (mode,) = result.modes
        assert mode.declared_Hz == pytest.approx(mode.frequency_Hz.value, rel=0.01), mode.words


def test_inertia_and_stiffness_are_a_set_until_the_torque_is_logged(tmp_path: Path) -> None:
    heavy, soft = designed(inertia=1.2), designed(give=1.5)
    alike = judged(tmp_path, heavy, "tau", design=True).result
    assert {"payload_inertia", "stiffness_error"} <= forms(alike), alike.sentence
    assert not alike.effects
    report = judged(tmp_path, heavy, design=True)
    assert "as_built: []" in report.as_built_text()  # no field of a design file holds it
    told = report.result
    (one,) = told.effects
    assert one.name == "payload_inertia", told.sentence
    assert one.parameters["share"].value == pytest.approx(0.2, abs=0.02)
    softer = judged(tmp_path, soft, design=True).result
    assert forms(softer) == {"stiffness_error"}, softer.sentence


def test_the_plan_says_from_which_delay_on_it_is_named(tmp_path: Path) -> None:
    """And that without a torque stiffness and inertia are not told apart at any size near the smallest."""
    (one,) = judged(tmp_path, designed(), design=True).runs
    drive = reference().loaded.drive
    foreseen = {each.label: each for each in plan_of(drive, one.run).effects}
    least = foreseen["delay (late sensor)"].smallest
    assert least is not None
    for size, named in ((2.0 * least, True), (0.3 * least, False)):
        found = judged(tmp_path, replace(designed(), delay_s=size), design=True).result
        assert ("delay" in forms(found)) == named, (size, found.sentence)
    blind = {each.label: each for each in plan_of(drive, replace(one.run, load_Nm=None)).effects}
    for plan, apart in ((foreseen, True), (blind, False)):
        inertia = plan["payload_inertia (all that the output turns)"]
        rivals = [rival.label for rival in inertia.rivals if rival.label.startswith("stiffness_error")]
        assert (not rivals) == apart, inertia


def test_responses_that_say_nothing(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="averages of 8 lines"):
        judged(tmp_path, TwoMasses(noise_rad=1.0))
    report = judged(tmp_path, designed())
    assert any("only the ratio" in words for words in report.result.not_testable)
    (tmp_path / "log.yaml").write_text(
        (tmp_path / "log.yaml").read_text().replace("column: q_in", "column: q_in\n    scale: 0.0001")
    )
    slow = mc.close_loop(None, tmp_path / "log.yaml").result
    assert "ratio_error" in forms(slow) or slow.unknown is not None, slow.sentence


@pytest.mark.slow
def test_the_rig_s_chirps_at_two_amplitudes(tmp_path: Path) -> None:
    """The mode falls with the amplitude as the design says; less preload lowers it more at the larger one."""

    def runs(name: str, **more: Any) -> LoopResult:
        files = []
        for size in (4.0, 16.0):
            content = yaml.safe_load(EXPERIMENT.read_text()) | {"name": f"{name}-{size:g}"} | more
            content["motion"]["acceleration_rad_s2"] = size
            content["duration_s"] = 10.0
            (tmp_path / "e.yaml").write_text(yaml.safe_dump(content))
            assert mbcdm(["simulate", str(DESIGN), str(tmp_path / "e.yaml"), "--out", str(tmp_path)]) == 0
            files.append(tmp_path / content["name"] / f"{content['name']}.yaml")
        return mc.close_loop(reference(), files).result

    sound = runs("sound")
    assert sound.verdict == "none", sound.sentence
    small, large = sound.modes
    assert small.frequency_Hz.value > 1.05 * large.frequency_Hz.value
    for mode in sound.modes:
        assert mode.frequency_Hz.value == pytest.approx(mode.declared_Hz, rel=0.015), mode.words
    loose = runs("loose", effects=[{"effect": "preload", "share": -0.4}])
    (one,) = loose.effects
    assert one.name == "preload_error", loose.sentence
    assert one.parameters["share"].low < -0.4 < one.parameters["share"].high
