"""The worked examples of the docs give the figures of their tables."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from mbcdm_cad.cli import run
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.loop import effects
from mbcdm_cad.loop.result import LoopResult
from mbcdm_cad.loop.search.engine import close_loop
from mbcdm_cad.measurement.reading import load_measurement

ROOT = Path(__file__).parents[2]
DESIGN = ROOT / "params" / "mbcdm.yaml"
pytestmark = pytest.mark.slow

# How far a figure may lie from what the docs print: they have two or three digits, and fits differ a little.
CLOSE = 0.15


@cache
def simulated(folder: Path, name: str) -> Path:
    """Measurement file of one of the shipped experiments."""
    experiment = ROOT / "params" / "experiments" / "worked" / f"{name}.yaml"
    assert run(["simulate", str(DESIGN), str(experiment), "--out", str(folder)]) == 0
    return folder / name / f"{name}.yaml"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("examples")


def closed(design: Path, measurement: Path) -> LoopResult:
    return close_loop(load_design(design).drive, [load_measurement(measurement)])


def row(page: str, first: str) -> list[float]:
    """Figures of the row of a table that begins with ``first``."""
    text = (ROOT / "docs" / page).read_text("utf-8")
    line = next(line for line in text.splitlines() if line.startswith(f"| {first} |"))
    return [float(figure) for figure in re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", line.removeprefix(f"| {first} |"))]


@pytest.mark.parametrize("name", ["winding-short", "winding-long"])
def test_winding_history_is_found_whole(folder: Path, name: str) -> None:
    result = closed(DESIGN, simulated(folder, name))
    assert result.verdict == "explained" and result.one_of == (), result.sentence
    assert [named.name for named in result.effects] == ["winding_history"], result.sentence
    strength = result.effects[0].parameters["strength"]
    errors = result.errors
    found = [1e6 * errors.before.value, 1e6 * errors.after.value, 1e6 * errors.floor_rad, strength.value]
    assert found == pytest.approx(row("worked-example-winding.md", name)[:4], rel=CLOSE), found
    assert strength.value == pytest.approx(1.0, abs=0.03) and strength.high - strength.low < 0.06, strength


def test_the_drive_as_built_leaves_nothing_in_either_run(folder: Path) -> None:
    built = folder / "as-built.yaml"
    assert run(["loop", str(DESIGN), str(simulated(folder, "winding-long")), "--apply", str(built)]) == 0
    for name in ("winding-long", "winding-short"):
        result = closed(built, simulated(folder, name))
        assert result.verdict == "none", f"{name}: {result.sentence}"


@pytest.fixture
def effect_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder whose files count as files of ``effects/``."""
    monkeypatch.setattr(effects, "__path__", [*effects.__path__, str(tmp_path)])
    yield tmp_path
    effects.offers.cache_clear()
    sys.modules.pop(f"{effects.__name__}.frame_bending", None)


def test_an_effect_kept_out_is_unknown_until_its_file_is_there(folder: Path, effect_folder: Path) -> None:
    from tests.support.bench_data import write_case

    path = write_case(folder, "out_square", 0, load_design(DESIGN).drive)
    before = closed(DESIGN, path)
    assert before.verdict == "unknown" and before.unknown is not None, before.sentence
    words = before.unknown.sentence()
    described = float(re.search(r"square of load: (\S+) ", words).group(1))  # type: ignore[union-attr]
    source = (ROOT / "docs" / "worked-example-new-effect.md").read_text("utf-8")
    (effect_folder / "frame_bending.py").write_text(re.findall(r"```python\n(.*?)```", source, re.DOTALL)[0])
    effects.offers.cache_clear()
    after = closed(DESIGN, path)
    assert after.verdict == "explained" and [e.name for e in after.effects] == ["frame_bending"], after.sentence
    found = after.effects[0].parameters["compliance_rad_Nm2"]
    assert -described == pytest.approx(found.value, rel=0.05), (described, found)
    truth = float(re.search(r"compliance_rad_Nm2: (\S+)", path.with_suffix(".truth.yaml").read_text()).group(1))  # type: ignore[union-attr]
    assert found.value == pytest.approx(truth, rel=0.03), (found, truth)
    errors = row("worked-example-new-effect.md", "error on held-out data")
    assert [1e6 * after.errors.before.value, 1e6 * after.errors.after.value] == pytest.approx(errors, rel=CLOSE)
