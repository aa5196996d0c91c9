"""A few random designs that pass the checks are built; more of them: benchmarks/studies/random_designs.py."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import islice

import pytest

from benchmarks.studies import random_designs
from mbcdm_cad.layouts import registry
from mbcdm_cad.layouts.check_design import run_checks
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from tests.support.random_generator import Passing, passing, requirements

SEEDS = range(1, 25)
# All that draw are slow: finding one design that passes and building it takes half a minute.
BUILT = 3


sized = cache(passing)


def found_first(count: int) -> list[Passing]:
    """The first designs that pass, by seed."""
    drawn = (sized(seed) for seed in SEEDS)
    found = list(islice((p for p in drawn if isinstance(p, Passing)), count))
    assert len(found) == count, f"only {len(found)} of {len(SEEDS)} seeds pass the checks"
    return found


def builds(found: Passing, poses: int) -> None:
    assert not [c.id for c in run_checks(found.loaded) if c.status == "fail"]
    failures = list(random_designs.exercise(found, poses))
    assert not failures, "\n".join(f"seed {f.seed}, {f.stage}: {f.what}" for f in failures)


@pytest.mark.slow
@pytest.mark.parametrize("number", range(BUILT))
def test_a_design_that_passes_the_checks_builds(number: int) -> None:
    builds(found_first(number + 1)[number], 3)


@pytest.mark.slow
def test_the_workshop_can_make_a_random_design() -> None:
    """A hundred: ``python -m benchmarks.studies.random_designs --count 100 --workshop``, with the longest drawing."""
    (found,) = found_first(1)
    failures = list(random_designs.exercise_workshop(found, ("drum",)))
    assert not failures, "\n".join(f"seed {f.seed}, {f.stage}: {f.what}" for f in failures)


def test_a_seed_is_a_design() -> None:
    assert requirements(7) == requirements(7) and requirements(7) != requirements(8)
    (found,) = found_first(1)
    again = passing(found.seed)
    assert isinstance(again, Passing) and again.loaded.sha256 == found.loaded.sha256


@pytest.mark.slow
def test_most_seeds_pass_and_vary_widely() -> None:
    drawn = [sized(seed) for seed in range(1, 13)]
    found = [p for p in drawn if isinstance(p, Passing)]
    assert len(found) >= 11, f"{len(found)} of 12 pass: {[p for p in drawn if isinstance(p, str)]}"
    values = [random_designs.figures(p) for p in found]
    for name, ratio in {
        "rope diameter, mm": 2.0,
        "largest drum radius, mm": 1.6,
        "total ratio": 2.0,
        "half travel, deg": 1.5,
        "preload, N": 3.0,
    }.items():
        span = max(v[name] for v in values) / min(v[name] for v in values)
        assert span > ratio, f"{name} varies by {span:.2f} only"


@pytest.mark.slow
def test_a_design_that_clashes_is_reported_by_stage(monkeypatch: pytest.MonkeyPatch) -> None:
    """The stop pin moved by 2 mm: drawn soundly, but it stands in the drum's web."""
    (found,) = found_first(1)

    def shifted(drive: BevelDrive) -> BevelLayout:
        dims = BevelLayout(drive)
        return dims.with_dimensions(drum=replace(dims.drum, stop_radius=dims.drum.stop_radius + 2.0))

    monkeypatch.setattr(registry, "layout_named", lambda name: shifted)
    vars(found.loaded.drive).pop("_kept")  # the layout that the checks have seen
    failures = list(random_designs.exercise(found, 1))
    assert {f.stage for f in failures} == {"interference"} and all("stop_pin" in f.what for f in failures), failures
    outcome = random_designs.Outcome(found.seed, "", random_designs.figures(found), tuple(failures))
    text = random_designs.report([outcome])
    assert f"interference                   1  {found.seed}\n" in text, text
