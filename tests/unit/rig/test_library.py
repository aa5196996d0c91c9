"""The experiment files of the library: each is read, has a description, and runs."""

from __future__ import annotations

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.rig.effects import AnyEffect
from mbcdm_cad.rig.experiment import Experiment, read_experiment
from mbcdm_cad.rig.library_page import added, effects_table
from mbcdm_cad.rig.quasistatic import simulate


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
