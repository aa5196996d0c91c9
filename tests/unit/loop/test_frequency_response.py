"""Frequency responses: two masses in closed form on benches that differ from what a file declares, and the rig."""

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from scipy.linalg import eigvalsh
from scipy.signal import chirp, cont2discrete, csd, detrend, lfilter

import mbcdm_cad as mc
from mbcdm_cad.cli import run as mbcdm
from mbcdm_cad.errors import InputError
from mbcdm_cad.jobs.outputs import plan_run
from mbcdm_cad.layouts.lumped import compliance_of
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.loop.judge import LoopReport
from mbcdm_cad.loop.result import LoopResult
from mbcdm_cad.model.stiffness import sticking_stiffness_Nm_rad
from mbcdm_cad.planning.plan import plan_of
from tests.support.reference import ROOT

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

    def over_inputs(self, s: np.ndarray) -> np.ndarray:
        """Output over inputs, both as angles of the output."""
        w = 2.0 * np.pi * self.frequency_Hz
        damper = 2.0 * self.damping * w * s
        return np.asarray((damper + w**2) / (s**2 + damper + w**2))


@dataclass(frozen=True)
class ThreeMasses(TwoMasses):
    """With an arm on the payload, a frame that swings, or a mass in front, which splits the spring; as matrices."""

    what: str = "arm"
    second_Hz: float = 95.0
    share: float = 0.1

    def matrices(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Mass, damping, stiffness, and what reads the output; the first body is driven by the input's spring."""
        spring = self.inertia_kg_m2 * (2.0 * np.pi * self.frequency_Hz) ** 2
        payload, w = self.inertia_kg_m2, 2.0 * np.pi * self.second_Hz
        if self.what == "arm":
            part = self.share * payload
            own = part * w**2
            mass, stiff = np.diag([payload - part, part]), np.array([[spring + own, -own], [-own, own]])
            return (
                mass,
                0.02 * own / w * np.array([[1, -1], [-1, 1]]) + self._damper(spring, [1, 0]),
                stiff,
                np.array([1, 0]),
            )
        if self.what == "frame":  # turned by the reaction; encoders read against it
            frame = payload / self.share
            mass = np.diag([payload, frame])
            stiff = spring * np.array([[1, -1], [-1, 1]]) + np.diag([0.0, frame * w**2])
            return mass, self._damper(spring, [1, -1]) + np.diag([0.0, 0.02 * frame * w]), stiff, np.array([1, -1])
        first, second = spring / self.share, spring / (1.0 - self.share)
        mass = np.diag([(first + second) / w**2, payload])
        stiff = np.array([[first + second, -second], [-second, second]])
        return mass, 2.0 * self.damping / (2.0 * np.pi * self.frequency_Hz) * stiff, stiff, np.array([0, 1])

    def _damper(self, spring: float, ends: list[int]) -> np.ndarray:
        return 2.0 * self.damping * spring / (2.0 * np.pi * self.frequency_Hz) * np.outer(ends, ends)

    def over_inputs(self, s: np.ndarray) -> np.ndarray:
        mass, damping, stiff, reads = self.matrices()
        spring = self.inertia_kg_m2 * (2.0 * np.pi * self.frequency_Hz) ** 2
        driven = np.array([1, -1]) if self.what == "frame" else np.array([1, 0])
        held = spring / self.share if self.what == "front" else spring
        force = held * (1.0 + 2.0 * self.damping * s / (2.0 * np.pi * self.frequency_Hz))
        at = s[:, None, None] ** 2 * mass + s[:, None, None] * damping + stiff
        return np.asarray(force * (np.linalg.solve(at, driven[:, None].astype(complex))[:, :, 0] @ reads))

    @property
    def modes_Hz(self) -> np.ndarray:
        """Of small damping."""
        mass, _, stiff, _ = self.matrices()
        return np.sqrt(np.sort(eigvalsh(stiff, mass))) / (2.0 * np.pi)


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
    whole = 1.0 / float(sticking_stiffness_Nm_rad(layout_of(drive).si)) + compliance_of(drive).land_to_payload
    payload = inertia * PLATE_KG_M2
    return TwoMasses(1.0 / np.sqrt(give * whole * payload) / (2.0 * np.pi), inertia_kg_m2=payload)


def tabled(folder: Path, bench: TwoMasses, design: bool = True, seed: int = 1, **how: Any) -> LoopReport:
    """Judge an analyser's table of the bench, beside others where they are given."""
    files = [table_of(folder, bench, design, seed, **how), *how.get("beside", [])]
    return mc.close_loop(reference() if design else None, files)


def table_of(folder: Path, bench: TwoMasses, design: bool, seed: int = 1, **how: Any) -> Path:
    """An analyser's table of the bench in closed form, with 1 % of noise in the gain that nothing declares.

    ``how``: over, rows, and more of the block response.
    """
    rng, over, n = np.random.default_rng(seed), how.get("over", "inputs"), how.get("rows", 180)
    f = np.geomspace(4.0, 150.0, n)
    s, w = 2j * np.pi * f, 2.0 * np.pi * bench.frequency_Hz
    damper = 2.0 * bench.damping * w * s
    value = bench.over_inputs(s) / RATIO
    if over == "torque":
        value = 1.0 / (s**2 + damper + w**2) / bench.inertia_kg_m2
    value = value * np.exp(-s * bench.delay_s)
    value = value * (1.0 + 0.01 * (rng.normal(size=n) + 1j * rng.normal(size=n)))
    name = f"{over}-{n}-{seed}"
    table = [f, 20.0 * np.log10(np.abs(value)), np.degrees(np.angle(value)), np.full(n, 0.999)]
    np.savetxt(folder / f"{name}.csv", np.stack(table, axis=1), "%.9g", ",", header="f,mag,ph,coh", comments="")
    units = {"frequency": "Hz", "gain": "dB", "phase": "deg", "coherence": "-"}
    columns = {key: {"column": at, "unit": units[key]} for at, key in enumerate(units, 1)}
    block = {"over": over} | {key: how[key] for key in ("turns", "amplitude_rad", "amplitude_Nm") if key in how}
    content: dict[str, Any] = {
        "data": f"{name}.csv",
        "kind": "frequency_response",
        "columns": columns,
        "response": block,
    }
    if design:
        content |= {"parts": {"output_at": "payload"}, "inertia_plate": {"inertia_kg_m2": PLATE_KG_M2}}
    else:
        content["ratio"] = RATIO
    (folder / f"{name}.yaml").write_text(yaml.safe_dump(content))
    return folder / f"{name}.yaml"


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


SMALL, PUSHED = {"amplitude_rad": 1e-6}, {"over": "torque", "amplitude_Nm": 1e-5}


def test_a_table_of_an_analyser(tmp_path: Path) -> None:
    """In closed form, with a noise that only its rows show: mode, damping and delay."""
    report = tabled(tmp_path, TwoMasses(delay_s=0.0004), design=False)
    found = {one.name: next(iter(one.parameters.values())) for one in report.result.effects}
    assert found["torsional_mode"].value == pytest.approx(47.3, rel=0.003), report.result.sentence
    assert found["delay"].value == pytest.approx(0.0004, abs=3e-5), report.result.sentence
    (mode,) = report.result.modes
    assert mode.frequency_Hz.low - 0.05 < 47.3 < mode.frequency_Hz.high + 0.05, mode.words
    assert mode.damping_share.value == pytest.approx(0.05, rel=0.06), mode.words
    assert "scatter by 1 %" in report.text() and "no amplitude" in report.text(), report.text()


@pytest.mark.parametrize("what", ["arm", "frame", "front"])
def test_a_second_mode_is_no_cause_of_the_drive(what: str, tmp_path: Path) -> None:
    """Three masses as matrices: an arm on the payload, a frame that swings, a mass in front of the drum."""
    two = designed()
    shape = {"arm": (95.0, 0.1), "frame": (80.0, 0.15), "front": (100.0, 0.3)}[what]
    bench = ThreeMasses(
        two.frequency_Hz, inertia_kg_m2=two.inertia_kg_m2, what=what, second_Hz=shape[0], share=shape[1]
    )
    report = tabled(tmp_path, bench, amplitude_rad=1e-7)  # so small that nothing slips, as in the matrices
    assert forms(report.result) == {"second_mode"}, report.result.sentence
    (one,) = report.result.effects
    second = bench.modes_Hz[1]
    found = one.parameters["natural_frequency_Hz"]
    assert found.value == pytest.approx(second, rel=0.03), (found, bench.modes_Hz, report.result.sentence)
    assert one.form == ("mass in front of the drum" if what == "front" else "arm or frame"), one
    assert "the design has no mode near it" in one.physics, one
    (mode,) = report.result.modes
    assert mode.declared_Hz == pytest.approx(two.frequency_Hz, rel=0.01), mode.words


@pytest.mark.slow
def test_tables_of_an_analyser_beside_a_design(tmp_path: Path) -> None:
    """As designed, soft, heavy; what the plan says of a table: a delay is named at twice its least size."""
    for how in (SMALL, PUSHED, {}):
        sound = tabled(tmp_path, designed(), seed=3, **how)
        assert sound.result.verdict == "none", sound.result.sentence
        (mode,) = sound.result.modes
        assert mode.declared_Hz == pytest.approx(mode.frequency_Hz.value, rel=0.01), mode.words
        assert mode.declared_damping is not None and mode.declared_damping < 0.005, mode.words  # nothing slips
    soft = tabled(tmp_path, designed(give=1.5), **PUSHED).result
    assert forms(soft) == {"stiffness_error"}, soft.sentence
    alike = tabled(tmp_path, designed(inertia=1.2), **SMALL).result
    assert {"payload_inertia", "stiffness_error"} <= forms(alike) and not alike.effects, alike.sentence
    told = tabled(tmp_path, designed(inertia=1.2), beside=[tmp_path / "inputs-180-1.yaml"], **PUSHED)
    (one,) = told.result.effects
    assert one.name == "payload_inertia", told.result.sentence
    assert one.parameters["share"].low < 0.2 < one.parameters["share"].high, told.result.sentence
    assert b"data:image/png" in told.page()
    plan = plan_run(reference().loaded.drive, table_of(tmp_path, designed(), True, **SMALL), None)
    least = next(one.smallest for one in plan.effects if one.label == "delay (late sensor)")
    assert least is not None and 1e-6 < least < 5e-4, least
    for size, named in ((2.0 * least, True), (0.3 * least, False)):
        found = tabled(tmp_path, replace(designed(), delay_s=size), seed=2, **SMALL).result
        assert ("delay" in forms(found)) == named, (size, found.sentence)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"kind": "motion"}, "a table over frequency is of another kind"),
        ({"ratio": 9.0, "response": {"over": "torque"}}, "of a ratio alone nothing says what the torque turns"),
        ({"response": {"amplitude_Nm": 1.0}}, "amplitude_Nm: given beside over: inputs"),
        ({"response": {"over": "torque", "turns": 9}}, "turns: given beside over: torque"),
        ({"response": {"turns": 1.0}}, "it is over the inputs' encoders; set response.turns: 9"),
        ({"sample_rate_Hz": 100.0}, "sample_rate_Hz: given beside columns.frequency"),
        ({"columns": {"load_torque": {"column": 2, "unit": "N*m"}}}, "load_torque: given beside columns.frequency"),
        ({"columns": {"gain": {"column": 2, "unit": "-"}}}, "set unit: dB if the figures are decibels"),
        ({"columns": {"gain": {"column": 2, "unit": "rad/Nm"}}}, "not of a gain over inputs"),
        ({"columns": {"phase": {"column": 3, "unit": "deg", "zero": 180}}}, "set zero: 180 on phase"),
        ({"columns": {"phase": None}}, "columns.phase: missing"),
    ],
)
def test_mistakes_in_a_table_are_told(change: dict[str, Any], words: str, tmp_path: Path) -> None:
    path = table_of(tmp_path, TwoMasses(), False, rows=60)
    content = yaml.safe_load(path.read_text())
    columns = content["columns"] | change.get("columns", {})
    content |= change | {"columns": {key: one for key, one in columns.items() if one is not None}}
    path.write_text(yaml.safe_dump(content))
    with pytest.raises(InputError, match=words):
        mc.close_loop(None, path)


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


def tabled_by_scipy(log: Path) -> None:
    """Write an analyser's table of a rig's log beside it: cross-spectra over 8 lines, with coherence."""
    given = yaml.safe_load(log.read_text())
    data = np.genfromtxt(log.parent / given["data"], delimiter=",", names=True)
    at = {key: data[column["column"]] for key, column in given["columns"].items()}
    rate = 1.0 / float(np.median(np.diff(at["time"])))
    inputs = 0.5 * (at["input_left"] + at["input_right"])
    inputs, output = (detrend(row) for row in (inputs, at["output"]))
    how = {"fs": rate, "nperseg": inputs.size, "window": ("tukey", 0.04)}
    pairs = ((inputs, inputs), (output, output), (inputs, output))
    n = inputs.size // 16 * 8
    f = np.fft.rfftfreq(inputs.size, 1.0 / rate)[:n].reshape(-1, 8).mean(axis=1)
    below, above, cross = (csd(*pair, **how)[1][:n].reshape(-1, 8).mean(axis=1) for pair in pairs)
    value, gamma, kept = cross / below, np.abs(cross) ** 2 / (below * above).real, (f > 8.0) & (f < 140.0)
    # A chirp that crosses k hertz a second has the spectrum of its amplitude over 2 sqrt(k).
    duration = inputs.size / rate
    amplitude = 2.0 * np.sqrt(145.0 / duration * below.real[kept] * duration / 2.0)
    rows = [f[kept], np.abs(value[kept]), np.angle(value[kept]), gamma[kept], amplitude]
    np.savetxt(log.parent / "table.csv", np.stack(rows, axis=1), "%.9g", ",", header="f,g,p,c,a", comments="")
    units = {"frequency": "Hz", "gain": "-", "phase": "rad", "coherence": "-", "amplitude": "rad"}
    columns = {key: {"column": k, "unit": unit} for k, (key, unit) in enumerate(units.items(), 1)}
    content = {"data": "table.csv", "columns": columns} | {k: given[k] for k in ("kind", "parts", "inertia_plate")}
    (log.parent / "table.yaml").write_text(yaml.safe_dump(content))


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
    for name in ("sound-4", "sound-16"):
        tabled_by_scipy(tmp_path / name / f"{name}.yaml")
    files = [tmp_path / name / "table.yaml" for name in ("sound-4", "sound-16")]
    table = mc.close_loop(reference(), files).result
    assert table.verdict == "none", table.sentence
    for mode, of_log in zip(table.modes, sound.modes, strict=True):
        assert mode.frequency_Hz.value == pytest.approx(of_log.frequency_Hz.value, rel=0.015), (
            mode.words,
            of_log.words,
        )
    loose = runs("loose", effects=[{"effect": "preload", "share": -0.4}])
    (one,) = loose.effects
    assert one.name == "preload_error", loose.sentence
    assert one.parameters["share"].low < -0.4 < one.parameters["share"].high
