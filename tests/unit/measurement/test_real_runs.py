"""Runs that others recorded on real cable drives, if present: read as loggers wrote them; results of the loop."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.measurement.file import load_file
from mbcdm_cad.measurement.reading import read_run
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.measurement.vet import refusals, vet

ROOT = Path(__file__).parents[3]
MAPPINGS = sorted((ROOT / "params" / "measurements" / "davinci").glob("*.yaml"))
DATA = Path(os.environ.get("MBCDM_SHARED_DATA", ROOT.parent / "shared" / "data")) / "davinci"


def real_run(name: str, folder: Path) -> Run:
    """One run, its measurement file put beside the data by a link."""
    if not DATA.is_dir():
        pytest.skip(f"the real runs are not here ({DATA}); set MBCDM_SHARED_DATA to the folder that holds davinci/")
    mapping = folder / f"{name}.yaml"
    shutil.copy(ROOT / "params" / "measurements" / "davinci" / mapping.name, mapping)
    file = load_file(mapping)
    if not (data := folder / str(file.content.data)).exists():
        data.symlink_to((DATA / data.name).resolve())
    return read_run(file).run


@pytest.mark.parametrize("name", [path.stem for path in MAPPINGS])
def test_both_drives_of_each_run_are_read_and_vetted(name: str, tmp_path: Path) -> None:
    run = real_run(name, tmp_path)
    # Stroke of 30 degrees each way; 1 kHz for 20 s although the header says ms.
    assert 0.9 < np.ptp(run.output_rad) < 1.1, np.ptp(run.output_rad)
    assert run.time_s.size >= 19_977 and np.median(np.diff(run.time_s)) == pytest.approx(1e-3)
    found = vet(run, None)
    assert not refusals(found), [str(finding) for finding in found]
    assert not [f for f in found if f.kind in ("ratio", "gaps", "saturated")], [str(finding) for finding in found]


def test_friction_of_the_cable_grows_with_the_load_and_not_with_the_speed(tmp_path: Path) -> None:
    """From the torques on both sides of it, by the terms of the loop's friction: as an expert saw by hand."""
    from benchmarks.studies.real_drives import friction_of_cable

    pairs = [(real_run(f"run_{r}_gearbox", tmp_path), real_run(f"run_{r}_cable", tmp_path)) for r in ("00", "05", "20")]
    found, left = friction_of_cable(pairs)
    constant, viscous, share = zip(found.value[1:], found.half_width()[1:], strict=True)
    assert share[0] - share[1] > 0.1 and constant[0] > 3.0 * constant[1] > 0.0, found.value
    assert abs(viscous[0]) < viscous[1] < 0.01, found.value
    assert left < 0.2 * 0.06, f"{left * 1e3:.1f} mN m of 60 mN m"


def test_the_mappings_are_there() -> None:
    assert [path.stem for path in MAPPINGS] == [
        f"run_{r}_{d}" for r in ("00", "05", "20") for d in ("cable", "gearbox")
    ]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "seen_by_hand_rad", "width_rad"),
    [("run_00_gearbox", 0.031, 0.004), ("run_00_cable", 2 * 0.026, 2 * 0.004)],
)
def test_the_loop_finds_the_lost_motion_seen_by_hand(
    name: str, seen_by_hand_rad: float, width_rad: float, tmp_path: Path
) -> None:
    from mbcdm_cad.loop.search.engine import close_loop

    result = close_loop(None, [real_run(name, tmp_path)])
    said = [named for group in (result.effects, *result.one_of) for named in group]
    play = [named.parameters["play_rad"].value for named in said if named.name == "lash"]
    assert play and abs(play[0] - seen_by_hand_rad) < width_rad, (play, result.sentence)
    # Nobody gave radii, preload or rope: it must not claim that nothing else is there.
    assert result.verdict == "partly_explained", result.sentence
    assert result.errors.after.value < 0.25 * result.errors.before.value, result.sentence


@pytest.mark.slow
def test_three_runs_together_tell_the_lost_motion_of_the_cable(tmp_path: Path) -> None:
    from mbcdm_cad.loop.search.engine import close_loop

    result = close_loop(None, [real_run(f"run_{run}_cable", tmp_path) for run in ("00", "05", "20")])
    # Under their load a play and a friction that winds up what is soft are the same motion.
    assert not result.effects and len(result.one_of) == 1, result.sentence
    found = {named.name: named for named in result.one_of[0]}
    assert set(found) == {"lash", "friction"}, result.sentence
    play = found["lash"].parameters["play_rad"]
    assert abs(play.value - 0.052) < 0.006, (play, result.sentence)
    assert play.low < 0.052 < play.high and result.verdict == "partly_explained", result.sentence
