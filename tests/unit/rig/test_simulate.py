"""A run from its file to its output files: same bytes, separate truth, no partial output.

The experiment files of the library: each is read, has a description, and runs.
"""

from __future__ import annotations

import ast
from dataclasses import dataclass, fields, replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import yaml

import mbcdm_cad.rig
from mbcdm_cad.cli import run as cli
from mbcdm_cad.design.blocks import TRAVEL_MAX_DEG, Loads, Payload
from mbcdm_cad.design.bought import Encoder
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.layouts.lumped import friction_of
from mbcdm_cad.measurement.schema import InertiaPlate
from mbcdm_cad.model.losses import Train
from mbcdm_cad.model.preload_ramp import HeldDrive, Ramp, SampleNoise, expected, fitted
from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.rig import chain
from mbcdm_cad.rig.bench import BenchLimits, BenchSensors, cables_of
from mbcdm_cad.rig.command import _overload
from mbcdm_cad.rig.dynamic.train import gearhead_of
from mbcdm_cad.rig.effects import AnyEffect
from mbcdm_cad.rig.effects.machine import BearingFriction, GearheadLash
from mbcdm_cad.rig.experiment import DynamicExperiment, Experiment, RigError, read_experiment
from mbcdm_cad.rig.library_page import added, effects_table
from mbcdm_cad.rig.quasistatic import simulate
from mbcdm_cad.routes import Floats

SHORT = """\
name: short
duration_s: 20.0
motion: {shape: triangle, amplitude_mrad: 50.0, period_s: 10.0}
load: {kind: brake, levels_Nm: [0.91]}
"""


@pytest.fixture
def files(project, tmp_path):
    experiment = tmp_path / "short.yaml"
    experiment.write_text(SHORT)
    return [str(project / "params" / "mbcdm.yaml"), str(experiment)]


def test_the_command_writes_run_measurement_truth_and_picture(files, tmp_path, capsys):
    assert cli(["simulate", *files, "--out", str(tmp_path / "out")]) == 0
    folder = tmp_path / "out" / "short"
    assert sorted(p.name for p in folder.iterdir()) == ["short.csv", "short.png", "short.truth.yaml", "short.yaml"]
    measurement = yaml.safe_load((folder / "short.yaml").read_text())
    header = (folder / measurement["data"]).read_text().split("\n")[0].split(",")
    assert [entry["column"] for entry in measurement["columns"].values()] == header
    truth = yaml.safe_load((folder / "short.truth.yaml").read_text())
    assert [entry["name"] for entry in truth["effects"]] == ["winding_history"]
    assert "winding" not in (folder / "short.yaml").read_text()
    assert "2000 samples" in capsys.readouterr().out


def test_same_seed_same_bytes_and_another_seed_others(files, tmp_path):
    def made(name):
        assert cli(["simulate", *files, "--out", str(tmp_path / name)]) == 0
        return {p.name: p.read_bytes() for p in (tmp_path / name / "short").iterdir()}

    first = made("a")
    assert first == made("b")
    Path(files[1]).write_text(SHORT + "seed: 2\n")
    assert made("c")["short.csv"] != first["short.csv"]


@pytest.mark.parametrize(("load_Nm", "said"), [(3.15, ""), (-3.2, "note: the load reaches 3.2 N m")])
def test_a_load_beyond_what_the_design_is_made_for_is_said(load_Nm, said, project):
    run = SimpleNamespace(load_Nm=np.array([0.0, load_Nm]))
    found = _overload(load_design(project / "params" / "mbcdm.yaml").drive, run)
    assert bool(found) is bool(said) and said in found


def test_a_folder_of_something_else_is_left_alone(files, tmp_path, capsys):
    folder = tmp_path / "out" / "short"
    folder.mkdir(parents=True)
    (folder / "thesis.tex").write_text("mine")
    assert cli(["simulate", *files, "--out", str(tmp_path / "out")]) == 2
    assert [p.name for p in folder.iterdir()] == ["thesis.tex"]
    assert [p.name for p in folder.parent.iterdir()] == ["short"]
    assert "another folder" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("motion: {shape: sawtooth, amplitude_mrad: 50.0, period_s: 10.0}", ["motion.shape", "'sawtooth'"]),
        ("motion: {shape: sine, amplitude_mrad: -5.0, period_s: 10.0}", ["motion.amplitude_mrad", "-5.0", "over 0"]),
        ("motion: {shape: sine, amplitude_mrad: .nan, period_s: 10.0}", ["not a finite number"]),
        ("motion: {shape: sine, amplitude_mrad: 50, period_s: 10, speed: 3}", ["motion.speed", "unknown field"]),
        ("duration_s: 1e4\nsample_rate_Hz: 5000.0\n" + SHORT.split("\n")[2], ["duration_s", "steps"]),
        ("effects: [{effect: gremlin}]\n" + SHORT.split("\n")[2], ["effects[0]", "gremlin", "modulus"]),
        ("effects: [{effect: modulus}]\n" + SHORT.split("\n")[2], ["effects[0].share", "missing"]),
        ("effects: [{effect: modulus, share: much}]\n" + SHORT.split("\n")[2], ["effects[0].share", "'much'"]),
    ],
)
def test_bad_experiments_are_told_with_line_and_remedy(tmp_path, change, words):
    path = tmp_path / "bad.yaml"
    lines = [
        line for line in SHORT.split("\n") if not line.startswith(("motion", "duration" if "1e4" in change else "#"))
    ]
    path.write_text("\n".join(lines) + change + "\n")
    with pytest.raises(InputError) as caught:
        read_experiment(path)
    text = str(caught.value)
    assert all(word in text for word in words), text
    assert f"{path}:" in text and ";" in text


def most_of(block, field):
    """The upper bound of a field of the design file."""
    return next(f.metadata["le"] for f in fields(block) if f.name == field)


def test_the_largest_drive_that_a_design_file_accepts_can_be_loaded_and_measured():
    for most in (most_of(Loads, "peak_torque_Nm"), most_of(Loads, "test_torque_Nm")):
        load = {"kind": "brake", "levels_Nm": [most]}
        Experiment.model_validate({"name": "x", "motion": {"amplitude_mrad": 1.0, "period_s": 9.0}, "load": load})
        dynamic = {"brake_Nm": most, "torque_Nm": -most, "inertia_kg_m2": most_of(Payload, "inertia_kg_m2")}
        DynamicExperiment.model_validate({"name": "x", "rig": "dynamic", "load": dynamic})
        BenchLimits(torque_Nm=most, half_travel_deg=TRAVEL_MAX_DEG)
        BearingFriction(effect="bearing_friction", drum_mNm=1e3 * most)
        GearheadLash(effect="gearhead_lash", stage="x", play_urad=0.0, stiffness_Nm_rad=1e-3)
    coarse = 1e-6 * most_of(Encoder, "resolution_urad")
    BenchSensors(input_resolution_rad=coarse, output_resolution_rad=coarse)
    InertiaPlate(inertia_kg_m2=most_of(Payload, "inertia_kg_m2"))


def test_what_cannot_be_run_is_refused_in_words(project):
    drive = load_design(project / "params" / "mbcdm.yaml").drive
    base = {"name": "x", "duration_s": 4.0, "motion": {"shape": "sine", "amplitude_mrad": 5.0, "period_s": 4.0}}
    with pytest.raises(RigError, match="cable_9"):
        simulate(
            drive,
            Experiment.model_validate(
                {**base, "effects": [{"effect": "preload", "share": 0.1, "cables": ["cable_9"]}]}
            ),
        )
    with pytest.raises(RigError, match="winds off"):
        simulate(drive, Experiment.model_validate({**base, "physics": {"drum_wrap_rad": 0.004}}))


def test_the_drum_balances_its_load_at_every_sample(project):
    drive = load_design(project / "params" / "mbcdm.yaml").drive
    run = simulate(drive, Experiment.model_validate(yaml.safe_load(SHORT)))
    pull = sum(c.sense * c.drum_radius_mm * 1e-3 * t for c, t in zip(drive.cables, run.tension_N, strict=True))
    assert np.abs(pull - run.load_Nm).max() < 1e-9


def test_a_motion_of_more_than_a_turn_has_the_wraps_that_it_winds_off():
    physics = Experiment.model_validate(
        {"name": "turns", "motion": {"amplitude_mrad": 9000.0, "period_s": 50.0}}
    ).physics
    on_input, on_drum = physics.wraps_rad(9.0, 6.0)
    assert on_input > 54.0 and 9.0 < on_drum < 9.2
    # What the rig had before for the travel of a sector, and what a file states.
    assert physics.wraps_rad(1.2, 6.0) == (16.0, 3.0)
    assert physics.model_copy(update={"drum_wrap_rad": 0.5}).wraps_rad(9.0, 6.0) == (on_input, 0.5)


def test_the_rig_uses_nothing_of_the_model():
    """Only the design room, the errors' and the rig's own modules; no code of model, checks, layout or loop."""
    folder = Path(mbcdm_cad.rig.__path__[0])
    modules = sorted(folder.rglob("*.py"))
    assert len(modules) > 10
    for module in modules:
        for node in ast.walk(ast.parse(module.read_text())):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom):
                assert node.level == 0, module
                names = [f"{node.module}.{a.name}" for a in node.names]
            for name in (name for name in names if name.startswith("mbcdm_cad")):
                room = name.split(".")[1]
                assert room in {"storage", "design", "rig", "routes", "layouts", "errors", "__version__"}, (
                    f"{module.name} imports {name}"
                )


@pytest.fixture(scope="module")
def library(project):
    read = {path: read_experiment(path) for path in sorted((project / "params" / "experiments").glob("*.yaml"))}
    return {path: experiment for path, experiment in read.items() if isinstance(experiment, Experiment)}


def test_names_are_those_of_the_files_and_seeds_differ(library):
    assert len(library) >= 60
    assert [e.name for e in library.values()] == [path.stem for path in library]
    assert all(e.about for e in library.values())
    assert len({e.seed for e in library.values()}) == len(library)


def test_the_library_holds_every_effect(library, project):
    # Effects that miso_bevel's cables cannot have are in the folder of a drive that can, slow ones in that of readings.
    folders = [project / "params" / "experiments" / name for name in ("siso_spur", "by-hand")]
    others = (read_experiment(path) for folder in folders for path in folder.glob("*.yaml"))
    used = {effect.effect for e in (*library.values(), *others) for effect in e.effects}
    assert used == {cls.model_fields["effect"].annotation.__args__[0] for cls in AnyEffect.__args__[0].__args__}


def test_the_page_names_every_experiment_and_lists_every_effect_as_it_is(library, project):
    page = (project / "docs" / "experiments.md").read_text()
    missing = [e.name for e in library.values() if f"| `{e.name}` | {e.about} |" not in page]
    assert not missing, f"{missing}; run python -m mbcdm_cad.rig.library_page params/mbcdm.yaml params/experiments docs"
    assert effects_table() in page


def test_what_an_experiment_adds_is_nothing_for_a_null_and_its_physics_else(library, project):
    drive = load_design(project / "params" / "mbcdm.yaml").drive
    named = {e.name: e for e in library.values()}
    assert np.ptp(added(drive, named["null-short-sine"]).added_urad) == 0.0
    # 40 urad a N m at up to 2 N m, both ways
    assert np.ptp(added(drive, named["stiffness-shaft"]).added_urad) == pytest.approx(160.0, abs=1.0)


@pytest.mark.slow
def test_every_experiment_runs(library, project):
    drive = load_design(project / "params" / "mbcdm.yaml").drive
    for experiment in library.values():
        run = simulate(drive, experiment)
        assert np.all(np.isfinite(run.measured_output_rad)), experiment.name
        assert run.tension_N.min() > 20.0, f"{experiment.name}: {run.tension_N.min()} N"
        assert np.abs(run.drum_rad - run.measured_output_rad).max() < 1e-2, experiment.name


# Preloads measured by ramps of an input's torque on the rig, with sensor noise and a rope that differs.


PARAMS = Path(__file__).parents[3] / "params"
INPUT_RAD, DRUM_RAD = 9.0, 2.0


@dataclass(frozen=True)
class Built:
    """How the drive on the rig differs from its design: factors on each figure; ``seal`` friction at the shaft, N m."""

    preload: tuple[float, ...] = (1.0,) * 4
    stiffness: float = 1.0
    wraps: float = 1.0
    rope: float = 0.0
    bearings: float = 0.0
    seal_Nm: float = 0.0
    gearhead: float = 1.0
    idle: float = 1.0


def drive_of(name: str) -> Drive:
    return load_design(PARAMS / f"{name}.yaml").drive


def wound(name: str) -> DriveSI:
    """A reference with the wraps of the rig."""
    d = layout_of(drive_of(name)).si
    n = d.n_cables
    return d.with_(input_wrap_rad=np.full(n, INPUT_RAD), drum_wrap_rad=np.full(n, DRUM_RAD))


def held(d: DriveSI, train: Train | None = None, at_motor: bool = False) -> HeldDrive:
    wraps = (d.input_wrap_rad, d.drum_wrap_rad)
    return HeldDrive(d, wraps, wraps, train, at_motor)


def there_and_back(ramp: Ramp, samples: int) -> Floats:
    """Angles in the order of time: from 0 to one end and back, then to the other end and back."""
    out = [np.linspace(0.0, end, samples) for end in (ramp.angle_rad[-1], ramp.angle_rad[0])]
    return np.concatenate([np.concatenate([way, way[-2::-1]]) for way in out])


def ramped(name: str, index: int, angle: Floats, built: Built, at_motor: bool = False) -> Floats:
    """Torque at an input of the rig, turned sample by sample with the drum held; each stop starts with fresh cables.

    Friction as the rig has it: rope and bearings by :func:`friction_of`, the gearhead's as in ``rig/dynamic/train``.
    """
    drive = drive_of(name)
    parts, gear = friction_of(drive), gearhead_of(drive)
    cables = tuple(
        replace(
            c, preload_N=c.preload_N * f, stiffness_N=c.stiffness_N * built.stiffness, friction=c.friction * built.wraps
        )
        for c, f in zip(cables_of(drive), built.preload, strict=False)
    )
    own = [j for j, c in enumerate(cables) if c.input_index == index]
    found, state = np.empty(angle.size), None
    for k, now in enumerate(angle):
        before = angle[k - 1] if k else 0.0
        if state is None or (before == 0.0 and now != 0.0) or before * now < 0.0:
            state = chain.chains(
                cables, transport=False, input_wrap_rad=INPUT_RAD, drum_wrap_rad=DRUM_RAD, piece_rad=0.02
            )
        tension = {j: chain.advance(state, j, float(now), 0.0, 0.0) for j in own}
        pulled = sum(cables[j].sigma * cables[j].input_radius_m * t for j, t in tension.items())
        rubs = sum(built.rope * parts.input_share[j] * cables[j].input_radius_m * t for j, t in tension.items())
        rubs += built.bearings * parts.input_bearings_Nm[index] + built.seal_Nm
        way = float(np.sign(now - before)) or 1.0
        found[k] = pulled + way * rubs
        if at_motor:
            idle = built.idle * (parts.gear_idle_Nm + gear.ratio * parts.motor_Nm)
            found[k] += way * (built.gearhead * gear.loss_share * abs(found[k]) + idle)
    return found


@pytest.mark.parametrize("at_motor", [False, True], ids=["shaft", "motor"])
@pytest.mark.parametrize(("name", "index"), [("mbcdm", 0), ("mbcdm", 1), ("siso_bevel", 0)])
def test_each_preload_is_found_within_5_percent(name: str, index: int, at_motor: bool) -> None:
    """With noise and all losses, each of them another than the design says, read at the shaft and at the motor."""
    d, rng = wound(name), np.random.default_rng(7)
    believed = held(d, layout_of(drive_of(name)).losses.with_drive(d), at_motor)
    noise = SampleNoise(angle_rad=50e-6, torque_Nm=0.004)
    built = Built((1.25, 0.8, 0.85, 1.15), 0.93, 1.15, 1.5, 1.3, 0.004, 1.25, 1.5)
    angle = there_and_back(expected(believed, index, noise), 60)
    torque = ramped(name, index, angle, built, at_motor)
    found = fitted(
        believed,
        index,
        angle + noise.angle_rad * rng.standard_normal(angle.size),
        torque + noise.torque_Nm * rng.standard_normal(angle.size),
        noise,
    )
    true = d.preload_N[list(found.cables)] * np.array(built.preload)[list(found.cables)]
    assert found.preload_N == pytest.approx(true, rel=0.05), (found.preload_N, true, found.sigma_N)
    assert np.all(found.sigma_N < 0.05 * true), found.sigma_N


def test_friction_that_the_evaluation_leaves_out_shifts_what_it_finds() -> None:
    """The same log, read as if it were without friction, misses by more than 5 %: the test above can fail."""
    d = wound("mbcdm")
    train = layout_of(drive_of("mbcdm")).losses.with_drive(d)
    noise = SampleNoise(angle_rad=50e-6, torque_Nm=0.004)
    angle = there_and_back(expected(held(d, train), 0, noise), 60)
    torque = ramped("mbcdm", 0, angle, Built(rope=1.0, bearings=1.0), at_motor=True)
    blind = fitted(held(d), 0, angle, torque, noise)
    seeing = fitted(held(d, train, at_motor=True), 0, angle, torque, noise)
    true = d.preload_N[list(blind.cables)]
    assert np.abs(blind.preload_N / true - 1.0).max() > 0.1, blind.preload_N
    assert seeing.preload_N == pytest.approx(true, rel=0.02), seeing.preload_N


def test_the_curve_of_springs_without_friction_has_its_knee_where_a_cable_is_slack() -> None:
    """By hand: two springs EA/L; at the knee the slack one has lost its preload, the tight one gained as much r k."""
    d = wound("siso_bevel").with_(friction_coefficient=1e-9)
    length = d.free_span_m + d.input_radius_m * INPUT_RAD + d.drum_radius_m * DRUM_RAD
    k = d.axial_stiffness_N / length
    ramp = expected(held(d), 0, SampleNoise(1e-5, 1e-3))
    for knee, torque, name in zip(ramp.knee_rad, ramp.knee_Nm, ramp.slack_first, strict=True):
        j = d.cable_names.index(name)
        other = 1 - j
        by_hand = 0.95 * d.preload_N[j] / (k[j] * d.input_radius_m[j])
        assert abs(knee) == pytest.approx(float(by_hand), rel=1e-3)
        tight = d.preload_N[other] + k[other] * d.input_radius_m[other] * abs(knee)
        expected_Nm = d.input_radius_m[other] * tight - d.input_radius_m[j] * 0.05 * d.preload_N[j]
        assert abs(torque) == pytest.approx(float(expected_Nm), rel=1e-3)


def test_the_rig_and_the_model_agree_on_the_curve() -> None:
    d = wound("mbcdm")
    angle = expected(held(d), 0, SampleNoise(1e-5, 1e-3)).angle_rad[::6]
    rising, falling = np.sort(angle[angle >= 0.0]), np.sort(angle[angle < 0.0])[::-1]
    angle = np.concatenate([rising, falling])
    rig = ramped("mbcdm", 0, angle, Built())
    assert held(d).torque_Nm(0, angle) == pytest.approx(rig, abs=0.01 * float(np.abs(rig).max()))


def test_a_short_log_is_refused() -> None:
    with pytest.raises(ModelError, match="at least 8 samples"):
        fitted(held(wound("mbcdm")), 0, np.zeros(5), np.zeros(5), SampleNoise(1e-5, 1e-3))
