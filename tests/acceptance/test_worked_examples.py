"""The worked examples of the docs give the figures of their tables."""

import json
import os
import re
import shutil
import subprocess
import sys
import venv
import zipfile
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
    assert strength.value == pytest.approx(1.0, abs=0.03) and strength.high - strength.low < 0.08, strength


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


TREE = Path(__file__).parents[2]
LAYOUTS = ("miso_bevel", "siso_bevel", "siso_spur", "miso_spur")
# A quick run of the test rig, and the layouts whose loop finds its effect in a second or two: the spur layouts have no
# file of their own in rig and loop, and tests of each close the loop from the tree.
EXPERIMENT, QUICK = "winding-short-brake", LAYOUTS[:2]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel of a copy of the tree in which the program has run, so that it holds compiled code."""
    copy, out = tmp_path_factory.mktemp("tree"), tmp_path_factory.mktemp("wheel")
    for name in ("pyproject.toml", "README.md"):
        shutil.copy(TREE / name, copy)
    shutil.copytree(TREE / "mbcdm_cad", copy / "mbcdm_cad", ignore=shutil.ignore_patterns("__pycache__"))
    compiled = copy / "mbcdm_cad" / "model" / "__pycache__" / "numba" / "hysteresis.nbc"
    compiled.parent.mkdir(parents=True)
    compiled.write_bytes(b"compiled")
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "wheel", "--quiet", "--no-index"]
    subprocess.run([*pip, "--no-deps", "--no-build-isolation", "--wheel-dir", str(out), str(copy)], check=True)
    return next(out.glob("*.whl"))


@pytest.fixture(scope="module")
def program(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The command ``mbcdm`` of a new environment that holds the wheel and sees the libraries of this one after it."""
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, symlinks=True)
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--python", str(folder / "bin" / "python")]
    subprocess.run([*pip, "install", "--quiet", "--no-index", "--no-deps", str(wheel)], check=True)
    libraries = [path for path in sys.path if Path(path).name == "site-packages"]
    next(folder.glob("lib/python*/site-packages")).joinpath("libraries.pth").write_text("\n".join(libraries))
    return folder / "bin" / "mbcdm"


def test_the_wheel_holds_every_file_of_the_package(wheel: Path) -> None:
    files = (path for path in (TREE / "mbcdm_cad").rglob("*") if path.is_file())
    wanted = {path.relative_to(TREE).as_posix() for path in files if "__pycache__" not in path.parts}
    held = {name for name in zipfile.ZipFile(wheel).namelist() if name.startswith("mbcdm_cad/")}
    assert held == wanted, f"not in the wheel: {sorted(wanted - held)}; only in it: {sorted(held - wanted)}"


def test_the_python_example_of_the_readme_runs_from_a_wheel(program: Path, tmp_path: Path) -> None:
    block = re.search(r"^```python\n(.*?)^```$", (TREE / "README.md").read_text("utf-8"), re.M | re.S)
    assert block is not None
    (tmp_path / "example.py").write_text(block[1], "utf-8")
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    command = [str(program.with_name("python")), "example.py"]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "passes every check as it is" in done.stdout and "torque to weight" in done.stdout, done.stdout
    assert (tmp_path / "finger.yaml").is_file() and (tmp_path / "out" / "wrist" / "report.md").is_file()


@pytest.mark.parametrize("layout", LAYOUTS)
def test_the_commands_work_from_a_wheel(program: Path, tmp_path: Path, layout: str) -> None:
    # No path of the tree may help the program to find the package.
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}

    def run(*arguments: str) -> str:
        done = subprocess.run(
            [str(program), *arguments], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, f"mbcdm {' '.join(arguments)}: {done.returncode}\n{done.stdout}\n{done.stderr}"
        return done.stdout

    python = program.with_name("python")
    where = subprocess.run(
        [str(python), "-c", "import mbcdm_cad; print(mbcdm_cad.__file__)"],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert Path(where).is_relative_to(python.parents[1]), f"not the installed package: {where}"

    run("init", "drive.yaml", "--reference", "--configuration", layout)
    run("check", "drive.yaml")
    assert json.loads(run("analyse", "drive.yaml", "--json"))["paths"]
    run("build", "drive.yaml", "--jobs", "1")
    run("page", "drive.yaml")
    built = next(path.parent for path in (tmp_path / "out").glob("*/report.html"))
    assert (built / "report.md").stat().st_size > 1000
    if layout in QUICK:
        shutil.copy(TREE / "params" / "experiments" / f"{EXPERIMENT}.yaml", tmp_path / "experiment.yaml")
        run("simulate", "drive.yaml", "experiment.yaml")
        run("loop", "drive.yaml", f"out/{EXPERIMENT}/{EXPERIMENT}.yaml", "--report", "loop")
        assert (tmp_path / "loop").is_dir()
