"""A run from its file to its output files: same bytes, separate truth, no partial output.

The experiment files of the library: each is read, has a description, and runs.
"""

import ast
import pkgutil
from dataclasses import dataclass, fields, replace
from importlib import import_module
from math import pi, radians
from pathlib import Path

import numpy as np
import pytest
import yaml

import mbcdm_cad.rig
from mbcdm_cad.cli import run as cli
from mbcdm_cad.design.blocks import TRAVEL_MAX_DEG, Loads, Payload
from mbcdm_cad.design.bought import Encoder
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import layout_of, load_design, load_text
from mbcdm_cad.layouts.lumped import friction_of
from mbcdm_cad.measurement.schema import InertiaPlate
from mbcdm_cad.model.losses import Train
from mbcdm_cad.model.preload_ramp import HeldDrive, Ramp, SampleNoise, expected, fitted
from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.rig import chain, effects
from mbcdm_cad.rig.bench import BenchLimits, BenchSensors, cables_of
from mbcdm_cad.rig.dynamic.train import gearhead_of
from mbcdm_cad.rig.effects import AnyEffect
from mbcdm_cad.rig.effects.machine import BearingFriction, GearheadLash, RigEffect
from mbcdm_cad.rig.experiment import DynamicExperiment, Experiment, RigError, read_experiment
from mbcdm_cad.rig.library_page import added, effects_table
from mbcdm_cad.rig.quasistatic import simulate
from mbcdm_cad.routes import Floats
from tests.support.reference import PARAMS

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


@pytest.mark.parametrize(("load_Nm", "said"), [(3.15, False), (3.2, True)])
def test_a_load_beyond_what_the_design_is_made_for_is_said(load_Nm, said, files, tmp_path, capsys):
    Path(files[1]).write_text(SHORT.replace("0.91", str(load_Nm)))
    assert cli(["simulate", *files, "--out", str(tmp_path / "out")]) == 0
    assert ("note: the load reaches 3.2 N m" in capsys.readouterr().out) is said


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


PERFECT = {
    "input_resolution_rad": 0.0,
    "output_resolution_rad": 0.0,
    "torque_noise_Nm": 0.0,
    "temperature_noise_K": 0.0,
}
BRAKE = {"kind": "brake", "levels_Nm": [0.91]}
E_A = 54e9 * 0.3117e-6
SPUR = """\
name: plain
configuration: siso_spur
travel: {{half_angle_deg: 30.0}}
transmission: {{drum_radius_mm: 60.0, input_to_drum: {ratio}}}
loads: {{peak_torque_Nm: 5.0}}
"""


@pytest.fixture(scope="module")
def drive(project):
    return load_design(project / "params" / "mbcdm.yaml").drive


def run(drive, *effects, load=None, amplitude_mrad=50.0, sensors=None, transport=False, duration_s=20.0):
    return simulate(
        drive,
        Experiment.model_validate(
            {
                "name": "x",
                "duration_s": duration_s,
                "sample_rate_Hz": 50.0,
                "motion": {"shape": "sine", "amplitude_mrad": amplitude_mrad, "period_s": 10.0, "stray_urad": 0.0},
                "load": load or {"kind": "none"},
                "sensors": {**PERFECT, **(sensors or {})},
                "physics": {"cable_transport": transport},
                "effects": list(effects),
            }
        ),
    )


def change_urad(drive, *effects, **more):
    with_effect, without = run(drive, *effects, **more), run(drive, **more)
    return (with_effect.measured_output_rad - without.measured_output_rad) * 1e6, without


def fitted_curve(values, *columns):
    return np.linalg.lstsq(np.stack(columns, axis=1), values, rcond=None)[0]


def test_drum_eccentricity_turns_the_drum_by_its_offset_over_the_radius(drive):
    """The groove's centre goes ahead by e cos: all four cables see it alike, as -e_x (1/r_o) on the mean."""
    effect = {"effect": "eccentric_pulley", "stage": "drum", "eccentricity_um": 20.0, "phase_deg": 90.0}
    change, base = change_urad(drive, effect, amplitude_mrad=450.0)
    drum = base.drum_rad
    amplitude = fitted_curve(change, np.cos(drum + pi / 2) - np.cos(pi / 2), np.ones(drum.size))[0]
    stiff = np.array([1.0 / c.drum_radius_mm for c in drive.cables])
    assert abs(amplitude) == pytest.approx(20e-3 * stiff.mean() * 1e6, rel=0.05), f"{amplitude} urad"


@pytest.mark.parametrize("stage", ["guide", "input_left", "input_right"])
def test_eccentric_pulley_changes_tension_by_newtons(drive, stage):
    effect = {"effect": "eccentric_pulley", "stage": stage, "eccentricity_um": 10.0}
    faulty, base = run(drive, effect, amplitude_mrad=450.0), run(drive, amplitude_mrad=450.0)
    swing = np.abs(faulty.tension_N - base.tension_N).max(axis=1)
    touched = [stage in ("guide", f"input_{c.input_name}") for c in drive.cables]
    assert 2.0 < max(swing) < 10.0, f"{swing} N for 10 um"
    assert all(s > 0.01 for s, t in zip(swing, touched, strict=True) if t)


def test_encoder_errors_come_out_as_they_are(drive):
    scale, base = change_urad(drive, {"effect": "encoder_scale", "stage": "drum", "share_ppm": 1000.0})
    assert np.allclose(scale, 1e3 * base.drum_rad, atol=1e-9)
    once, base = change_urad(
        drive, {"effect": "eccentric_encoder", "stage": "drum", "amplitude_urad": 30.0, "phase_deg": 20.0}
    )
    assert np.allclose(once, 30.0 * np.cos(base.drum_rad + radians(20.0)), atol=1e-9)
    fine, base = change_urad(
        drive, {"effect": "encoder_subdivision", "stage": "drum", "amplitude_urad": 2.0, "cycles_per_rev": 18000.0}
    )
    assert np.allclose(fine, 2.0 * np.sin(18000.0 * base.drum_rad), atol=1e-8)
    faulty = run(drive, {"effect": "encoder_scale", "stage": "input_left", "share_ppm": 1000.0})
    assert np.allclose(faulty.measured_input_rad[0], 1.001 * faulty.input_rad[0], rtol=1e-12)
    assert np.array_equal(faulty.measured_input_rad[1], faulty.input_rad[1])


def test_radius_error_of_the_drum_changes_the_ratio(drive):
    change, base = change_urad(drive, {"effect": "radius_error", "stage": "drum", "error_um": 50.0})
    slope = fitted_curve(change * 1e-6, base.drum_rad)[0]
    assert slope == pytest.approx(-np.mean([50e-3 / c.drum_radius_mm for c in drive.cables]), rel=0.02), f"{slope}"


def test_modulus_preload_and_friction_change_the_loop_as_they_should(drive):
    def swing(*effects):
        found = run(drive, *effects, load=BRAKE)
        ideal = np.mean([a / 9.0 for a in found.input_rad], axis=0)
        return np.ptp((ideal - found.drum_rad)[500:]) * 1e6

    base = swing()
    assert swing({"effect": "modulus", "share": 0.2}) == pytest.approx(base / 1.2, rel=1e-3)
    less = swing({"effect": "preload", "share": 0.2})
    slick = swing({"effect": "rope_friction", "share": 0.2})
    assert base * 0.9 < less < base * 0.99, f"{less} of {base} urad: the slip part goes with 1/T_pre"
    # mu T_pre is what counts, to second order
    assert slick == pytest.approx(less, rel=2e-3), f"{slick} against {less} urad"


def test_output_shaft_and_friction_work_by_compliance(drive):
    change, base = change_urad(drive, {"effect": "shaft_compliance", "compliance_urad_Nm": 40.0}, load=BRAKE)
    assert np.allclose(change, -40.0 * base.load_Nm, atol=1e-9)
    # Hidden torque acts as the same torque of a brake does, and the sensor does not feel it.
    hidden = run(drive, {"effect": "bearing_friction", "drum_mNm": 200.0, "presliding_urad": 500.0})
    open_ = run(drive, load={"kind": "brake", "levels_Nm": [0.2], "flank_mrad": 0.5})
    assert np.allclose(hidden.drum_rad, open_.drum_rad, atol=1e-12)
    assert np.all(hidden.load_Nm == 0.0)
    guide = run(drive, {"effect": "bearing_friction", "guide_mNm": 200.0 / 6.0, "presliding_urad": 500.0})
    assert np.allclose(guide.drum_rad, hidden.drum_rad, atol=1e-10)
    # A Stribeck part that no speed of the run ends is constant, one that ends at once is not there.
    for fades, drum in ((1e5, 150.0), (1e-3, 200.0)):
        law = {"drum_mNm": drum, "stribeck_mNm": 50.0, "stribeck_mrad_s": fades, "presliding_urad": 500.0}
        both = run(drive, {"effect": "bearing_friction"} | law)
        off = np.abs(both.drum_rad - hidden.drum_rad).max()
        assert off < 1e-6, f"{off:.3g} rad; 50 mN m turn the drum by some 10 urad"


def test_delay_and_viscous_drag_go_with_speed(drive):
    change, base = change_urad(drive, {"effect": "sensor_delay", "delay_ms": 20.0})
    speed = np.gradient(base.drum_rad, base.time_s)
    assert fitted_curve(change[50:] * 1e-6, speed[50:])[0] == pytest.approx(-0.02, rel=0.01)
    drag, base = change_urad(drive, {"effect": "viscous_drag", "drag_Nms": 10.0})
    speed = np.gradient(base.drum_rad, base.time_s)
    assert np.corrcoef(drag, -speed)[0, 1] > 0.98


def test_lash_follows_the_sign_of_the_torque_the_bias_included(drive):
    """Equal preloads pull each input by 28 mN m one way: an idle drive never changes flank, a loaded one does."""
    effect = {"effect": "gearhead_lash", "stage": "input_left", "play_urad": 1000.0}
    idle = run(drive, effect, sensors={"input_at": "motor"})
    gap = idle.measured_input_rad[0] - idle.input_rad[0]
    assert np.ptp(gap) < 20e-6, f"{np.ptp(gap)} rad"
    loaded = run(drive, effect, sensors={"input_at": "motor"}, load=BRAKE)
    gap = (loaded.measured_input_rad[0] - loaded.input_rad[0])[500:]
    assert np.ptp(gap) == pytest.approx(1000e-6, rel=0.1), f"{np.ptp(gap)} rad"
    seen = run(drive, effect, load=BRAKE)
    assert np.array_equal(seen.measured_input_rad, seen.input_rad), "an encoder on the pulley sees it all"
    assert seen.truth[0]["seen"] is False


@pytest.mark.parametrize("transport", [False, True])
@pytest.mark.parametrize(("play_urad", "stiffness_Nm_rad"), [(300.0, 5000.0), (1000.0, 5000.0), (3000.0, 500.0)])
def test_lash_of_one_input_swings_the_drum_by_the_play_over_the_ratio(transport, play_urad, stiffness_Nm_rad):
    """One input has no bias: where the load changes its sign, the pulley crosses its play, and the drum with it."""
    ratio = 2.95
    spur = load_text(SPUR.format(ratio=ratio), "plain.yaml").drive
    load = {"kind": "torque_motor", "wave": "sine", "levels_Nm": [1.5], "wave_period_s": 13.0}
    effect = {"effect": "gearhead_lash", "stage": "input_main", "stiffness_Nm_rad": stiffness_Nm_rad}
    more = {"load": load, "sensors": {"input_at": "motor"}, "transport": transport}
    swings = [np.ptp(turned_rad(spur, {**effect, "play_urad": play}, **more)) for play in (play_urad, 0.0)]
    assert swings[0] - swings[1] == pytest.approx(play_urad * 1e-6 / ratio, rel=2e-3), swings


def turned_rad(drive, effect, **more):
    found = run(drive, effect, **more)
    return found.drum_rad - found.measured_input_rad[0] / drive.total_ratio


def test_gear_mesh_and_cogging_move_the_pulleys(drive):
    mesh = {"effect": "gear_mesh", "stage": "input_right", "amplitude_urad": 100.0, "cycles_per_input_rev": 30.0}
    found = run(drive, mesh, sensors={"input_at": "motor"})
    gap = found.input_rad[1] - found.measured_input_rad[1]
    assert np.allclose(gap, 100e-6 * np.sin(30.0 * found.measured_input_rad[1]), atol=1e-12)
    cogging = run(drive, {"effect": "motor_cogging", "stage": "input_left", "torque_mNm": 0.05})
    moved = cogging.input_rad[0] - run(drive).input_rad[0]
    assert np.abs(moved).max() == pytest.approx(0.05 / 2.0 / 76.0, rel=0.02)
    assert np.array_equal(cogging.measured_input_rad, cogging.input_rad)


def test_rope_lay_ripples_once_a_lay_of_rope(drive):
    change, base = change_urad(
        drive, {"effect": "rope_lay", "amplitude_um": 30.0, "lay_mm": 6.5, "cables": ["cable_2"]}, amplitude_mrad=450.0
    )
    order = 2 * pi * 57.6 / 6.5
    phase = order * base.drum_rad
    sin, cos, _, _ = fitted_curve(change, np.sin(phase), np.cos(phase), np.ones(phase.size), base.drum_rad)
    # On the input lambda/2pi/r_i of the height, less on the drum; one cable of four moves the drum by a quarter or so.
    path_um = 30.0 * 6.5 / (2 * pi) * (1 / 6.4 + 1 / 57.6)
    assert np.hypot(sin, cos) == pytest.approx(path_um / 57.6e-3 / 4.0, rel=0.2), f"{np.hypot(sin, cos)} urad"


def test_warm_rope_goes_slack_by_its_strain_and_turns_the_drum(drive):
    heat = {"effect": "temperature", "rise_K": 10.0, "time_constant_s": 1.0}
    all_ropes = run(drive, heat, amplitude_mrad=0.01)
    assert all_ropes.tension_N[:, -1] == pytest.approx(70.0 - E_A * 160e-6, abs=0.1)
    assert abs(all_ropes.drum_rad[-1] - run(drive, amplitude_mrad=0.01).drum_rad[-1]) < 2e-6
    one = run(drive, {**heat, "cables": ["cable_1"]}, amplitude_mrad=0.01)
    assert one.drum_rad[-1] > 5e-6, "cable 1 pulls the drum back; it goes slack, so the drum goes ahead"
    assert one.measured_temperature_C[-1] == pytest.approx(32.0, abs=0.01)


def test_warm_body_without_warm_rope_tightens(drive):
    heat = {
        "effect": "temperature",
        "rise_K": 10.0,
        "time_constant_s": 1.0,
        "body_share": 1.0,
        "rope_ppm_K": 0.0,
        "frame_ppm_K": 20.0,
        "drum_ppm_K": 20.0,
        "input_ppm_K": 20.0,
    }
    assert run(drive, heat, amplitude_mrad=0.01).tension_N[:, -1] == pytest.approx(70.0 + E_A * 200e-6, rel=2e-3)


def test_creep_takes_tension_by_the_logarithm(drive):
    found = run(drive, {"effect": "creep", "strain_ppm": 20.0, "t0_s": 2.0}, amplitude_mrad=0.01)
    expected = 70.0 - E_A * 20e-6 * np.log1p(found.time_s / 2.0)
    assert np.abs(found.tension_N - expected).max() < 0.05


def test_anchor_slip_is_a_step_in_time(drive):
    change, base = change_urad(drive, {"effect": "anchor_slip", "cable": "cable_3", "at_s": 9.0, "slip_um": 20.0})
    assert np.abs(change[base.time_s < 8.9]).max() < 1e-6
    assert np.abs(change[base.time_s > 9.2]).min() > 20.0 / 61.2e-3 / 10.0


def test_local_faults_show_only_where_they_lie(drive):
    wear, base = change_urad(
        drive,
        {"effect": "land_wear", "cable": "cable_2", "depth_um": 50.0, "from_deg": 10.0, "to_deg": 16.0},
        amplitude_mrad=450.0,
    )
    before = (base.time_s < 10.0) & (-base.drum_rad < radians(10.0)) & (base.time_s < 5.0)
    assert np.abs(wear[before]).max() < 1e-6
    assert np.abs(wear).max() > 1.0
    climb, base = change_urad(
        drive, {"effect": "step_climb", "cable": "cable_1", "height_um": 50.0, "from_deg": 12.0}, amplitude_mrad=450.0
    )
    assert np.abs(climb[(base.time_s < 2.5) & (base.drum_rad < radians(12.0))]).max() < 1e-6
    assert np.abs(climb).max() > 3.0
    bump, base = change_urad(
        drive,
        {"effect": "strand_damage", "cable": "cable_2", "height_um": 100.0, "position_mm": 26.0},
        amplitude_mrad=450.0,
    )
    assert np.ptp(bump) > 3.0


def test_a_sticking_brake_saws_between_static_and_as_far_below(drive):
    found = run(drive, {"effect": "brake_stick_slip", "static_share": 1.2, "scatter": 0.0}, load=BRAKE)
    late = np.abs(found.load_Nm[300:])
    assert late.max() == pytest.approx(0.91 * 1.2, rel=0.03)
    assert np.sum(np.abs(np.diff(found.load_Nm)) > 0.2) > 10, "drops"


def test_many_effects_together_and_each_tells_the_truth(drive):
    effects = [
        {"effect": "eccentric_pulley", "stage": "guide", "eccentricity_um": 5.0},
        {"effect": "preload", "share": -0.2, "cables": ["cable_3"]},
        {"effect": "gearhead_lash", "stage": "input_right", "play_urad": 300.0, "stiffness_Nm_rad": 50.0},
        {"effect": "creep", "strain_ppm": 10.0},
        {"effect": "rope_lay", "amplitude_um": 5.0},
        {"effect": "anchor_slip", "cable": "cable_1", "at_s": 5.0, "slip_um": 5.0},
    ]
    found = run(drive, *effects, load=BRAKE, transport=True, sensors={"input_at": "motor"})
    names = [entry["name"] for entry in found.truth]
    assert names == ["once_per_rev", "preload_error", "lash", "creep", *["ripple"] * 4, "slip_step", "winding_history"]


def test_every_effect_is_in_the_registry():
    for module in pkgutil.iter_modules(effects.__path__, f"{effects.__name__}."):
        import_module(module.name)
    listed = set(effects.AnyEffect.__args__[0].__args__)
    assert set(RigEffect.__subclasses__()) == listed
