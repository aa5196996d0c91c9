"""A wheel of the package works by itself: installed into an empty environment, run in a folder outside the tree.

Nothing comes from the network: the libraries that the package needs are those of the running Python.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import pytest

TREE = Path(__file__).parents[2]
LAYOUTS = ("miso_bevel", "siso_bevel", "siso_spur", "miso_spur")
# A quick run of the test rig, and the layouts whose loop finds its effect in a second or two: the spur layouts have no
# file of their own in rig and loop, and tests of each close the loop from the tree.
EXPERIMENT, QUICK = "winding-short-brake", LAYOUTS[:2]

pytestmark = pytest.mark.slow


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
