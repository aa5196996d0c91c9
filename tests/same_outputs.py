"""Compare the files that two states of the code write; for moves of code, which must not change any byte of output.

    python tests/same_outputs.py BASE [--designs 10] [--only siso_spur] [--no-build] [--work FOLDER]

Checks out the commit ``BASE`` in another folder, writes the reference design of each layout and some random designs
of it that pass BASE's checks, and runs check, analyse, build, simulate and loop on each of them with both states. Files
and ``--json`` output are compared byte for byte, after hashes of inputs and code and times of day are masked; text for
the terminal is not compared. Prints each file that differs; exit 1 if any does. ``--work`` keeps the outputs of BASE.
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

TREE = Path(__file__).resolve().parent.parent
# Runs of each layout, among them a rope that is carried along and several causes at once. The loop reads all but the
# last.
EXPERIMENTS = {
    "miso_bevel": ("winding-short-brake", "pair-left-lines", "dynamic/lash-and-cogging"),
    "siso_bevel": ("winding-short-brake", "preload-all-low", "dynamic/stick-slip"),
    "siso_spur": ("siso_spur/input-creep", "preload-all-low", "dynamic/stick-slip"),
    "miso_spur": ("siso_spur/input-creep", "friction-rope-slick", "dynamic/stick-slip"),
}
REFERENCES = {name: f"params/{'mbcdm' if name == 'miso_bevel' else name}.yaml" for name in EXPERIMENTS}
# Records where the design file is, which states before it did not.
_NEW_FILES = (".design-file",)
_HASH = re.compile(rb"[0-9a-f]{64}")

_WRITE_DESIGNS = """
import sys
from pathlib import Path
import yaml
from random_generator import LAYOUTS, USUAL, Passing, passing
folder = Path(sys.argv[1])
for layout, space in (LAYOUTS | {"miso_bevel": USUAL}).items():
    wanted, seed = int(sys.argv[2]), 0
    while wanted:
        seed += 1
        found = passing(seed, space)
        if isinstance(found, Passing):
            found.data["name"] = f"{layout}-{seed}"
            (folder / f"{layout}-{seed}.yaml").write_text(yaml.safe_dump(found.data, sort_keys=False))
            wanted -= 1
"""


def _environment(tree: Path, cache: Path) -> dict[str, str]:
    path = os.pathsep.join(str(tree / place) for place in (".", "tests", "tests/support"))
    return {**os.environ, "PYTHONPATH": path, "MBCDM_CACHE_DIR": str(cache)}


def write_designs(tree: Path, folder: Path, count: int) -> None:
    """The reference design of each layout and ``count`` random ones of it that pass the checks of ``tree``."""
    folder.mkdir(parents=True)
    for layout, reference in REFERENCES.items():
        (folder / f"{layout}.yaml").write_bytes((tree / reference).read_bytes())
    environment = _environment(tree, folder / ".cache")
    subprocess.run(
        [sys.executable, "-c", _WRITE_DESIGNS, str(folder), str(count)], env=environment, check=True, cwd=folder
    )


def capture(tree: Path, design: Path, experiments: Path, out: Path, build: bool) -> None:
    """Outputs of ``tree`` for one design, each command's in a file or folder of its own below ``out``."""
    out.mkdir(parents=True)
    with tempfile.TemporaryDirectory() as cache:
        environment = _environment(tree, Path(cache))

        def mbcdm(name: str, *arguments: str) -> None:
            done = subprocess.run(
                [sys.executable, "-m", "mbcdm_cad", *arguments],
                env=environment,
                cwd=out,
                capture_output=True,
                text=True,
            )
            (out / f"{name}.code").write_text(f"{done.returncode}\n{done.stderr if done.returncode == 2 else ''}")
            if "--json" in arguments and name in ("check", "analyse"):
                (out / f"{name}.json").write_text(done.stdout)

        mbcdm("check", "check", str(design), "--json")
        mbcdm("analyse", "analyse", str(design), "--json")
        runs = EXPERIMENTS[next(name for name in EXPERIMENTS if design.stem.startswith(name))]
        for experiment in runs:
            mbcdm(f"simulate-{Path(experiment).name}", "simulate", str(design), str(experiments / f"{experiment}.yaml"))
        for run in (Path(experiment).name for experiment in runs[:-1]):
            found = ["--json", f"{run}.json", "--apply", f"{run}-as-built.yaml", "--report", f"{run}-page"]
            mbcdm(f"loop-{run}", "loop", str(design), f"out/{run}/{run}.yaml", *found)
        if build:
            mbcdm("build", "build", str(design), "--force", "--jobs", "1")


def name_of(design: Path) -> str:
    """The design's name, which is that of its output folder."""
    return next(line.split()[1] for line in design.read_text("utf-8").splitlines() if line.startswith("name:"))


def differences(one: Path, other: Path) -> Iterator[str]:
    """Files below two folders that differ, or that only one of them has."""
    names = {str(path.relative_to(root)) for root in (one, other) for path in root.rglob("*") if path.is_file()}
    names = {name for name in names if Path(name).name not in _NEW_FILES}
    for name in sorted(names):
        files = one / name, other / name
        if not all(path.exists() for path in files):
            yield f"{name}: only in {files[0].parent if files[0].exists() else files[1].parent}"
        elif len({_HASH.sub(b"#", path.read_bytes()) for path in files}) > 1:
            yield f"{name}: differs"


def main() -> int:
    """Compare; 0 if all outputs are the same."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("base")
    parser.add_argument("--designs", type=int, default=10)
    parser.add_argument("--no-build", action="store_true")
    parser.add_argument("--work", type=Path, default=None)
    parser.add_argument("--only", default="", help="designs whose name begins with this")
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        work = (given.work or Path(temporary)).resolve()
        work.mkdir(parents=True, exist_ok=True)
        base = work / "base-tree"
        if not base.exists():
            subprocess.run(["git", "worktree", "prune"], cwd=TREE, check=True)
            subprocess.run(
                ["git", "worktree", "add", "--detach", "--force", str(base), given.base], cwd=TREE, check=True
            )
        if not (work / "designs").exists():
            write_designs(base, work / "designs", given.designs)
        designs = [path for path in sorted((work / "designs").glob("*.yaml")) if path.stem.startswith(given.only)]
        new = Path(tempfile.mkdtemp(prefix="new-", dir=work))

        def compare(design: Path) -> list[str]:
            kept = work / "base" / design.stem
            if not kept.exists():
                capture(base, design, base / "params/experiments", kept, True)
            capture(TREE, design, base / "params/experiments", new / design.stem, not given.no_build)
            found = differences(kept, new / design.stem)
            left_out = given.no_build and {f"out/{name_of(design)}/", "build.code"}
            return [f"{design.stem}/{line}" for line in found if not (left_out and line.startswith(tuple(left_out)))]

        with ThreadPoolExecutor(given.jobs) as pool:
            found = [line for lines in pool.map(compare, designs) for line in lines]
    print("\n".join(found) if found else f"all outputs of {len(designs)} designs are the same as at {given.base}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
