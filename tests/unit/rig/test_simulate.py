"""A run from its file to its output files: same bytes, separate truth, no partial output.

The experiment files of the library: each is read, has a description, and runs.
"""

from __future__ import annotations

import ast
from dataclasses import fields
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import yaml

import mbcdm_cad.rig
from mbcdm_cad.cli import run as cli
from mbcdm_cad.design.blocks import TRAVEL_MAX_DEG, Loads, Payload
from mbcdm_cad.design.bought import Encoder
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.measurement.schema import InertiaPlate
from mbcdm_cad.rig.bench import BenchLimits, BenchSensors
from mbcdm_cad.rig.command import _overload
from mbcdm_cad.rig.effects import AnyEffect
from mbcdm_cad.rig.effects.machine import BearingFriction, GearheadLash
from mbcdm_cad.rig.experiment import DynamicExperiment, Experiment, RigError, read_experiment
from mbcdm_cad.rig.library_page import added, effects_table
from mbcdm_cad.rig.quasistatic import simulate

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
