"""Speed of the program as ratios of times of one run, which can be compared between machines.

    python benchmarks/speed.py [params/mbcdm.yaml] [--repeat N] [--json FILE]
    for layout in siso_spur miso_spur siso_bevel; do python benchmarks/speed.py params/$layout.yaml; done

Each time is the smallest of several runs, each in its own process. The two sides of a ratio run alternately, so that
other load on the machine slows both. Exit code 1 if a limit is exceeded.
"""

import json
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from timing import ROOT, Figure, arguments, finish, in_turns

from mbcdm_cad.layouts.registry import layout_of

CHECK_RATIO_LIMIT = 3.0
FAILING_LIMIT_S = 1.0
BUILD_RATIO_LIMIT = 2.0
UNCHANGED_LIMIT_S = 0.5
INTERFERENCE_LIMIT_S = 12.0
EDIT_LIMIT_S = 4.0
# Over the least bend ratio of a design: more than any of the reference designs has to spare.
BEND_FACTOR = 1.35
# Rounds in which the quick commands and the bare import take turns.
START_ROUNDS = 10
CORES = 2  # the interference limit is stated for two
# A dimension of the drum alone: after editing it, nothing else should be drawn anew.
EDITED_PARAMETER, EDIT_MM = "web_thickness_mm", 0.3
_BARE_IMPORT = "import numpy, yaml, pydantic"


class Bench:
    """Runs the command line with a cache and output folders of its own."""

    def __init__(self, design: Path, room: Path, repeat: int) -> None:
        self.design = design
        self.room = room
        self.repeat = repeat
        self.cache = room / "cache"
        self.environment = {**os.environ, "MBCDM_CACHE_DIR": str(self.cache), "PYTHONPATH": str(ROOT)}
        # As for a user: what was imported once is not compiled again.
        self.environment.pop("PYTHONDONTWRITEBYTECODE", None)
        self._runs = 0

    def python(self, *arguments: str) -> tuple[float, str]:
        """Wall time in s and standard output of one Python process. Exit code 1 (a check failed) is allowed."""
        start = time.perf_counter()
        done = subprocess.run(
            [sys.executable, *arguments], env=self.environment, cwd=ROOT, capture_output=True, text=True, check=False
        )
        elapsed = time.perf_counter() - start
        if done.returncode not in (0, 1) or "Traceback" in done.stderr:
            raise RuntimeError(f"{' '.join(arguments)} ended with {done.returncode}:\n{done.stderr[-3000:]}")
        return elapsed, done.stdout

    def least(self, once: Callable[[], float], repeat: int | None = None) -> float:
        return min(once() for _ in range(repeat or self.repeat))

    def command(self, name: str, design: Path) -> float:
        return self.python("-m", "mbcdm_cad", name, str(design))[0]

    def build(self, *options: str, design: Path | None = None, out: Path | None = None) -> tuple[float, str]:
        """One build, into a new folder unless ``out`` is given."""
        self._runs += 1
        target = out or self.room / f"out{self._runs}"
        command = ("-m", "mbcdm_cad", "build", str(design or self.design), "--out", str(target), "--force")
        return self.python(*command, "--jobs", str(CORES), *options)

    def kernel_imports(self, *arguments: str) -> int:
        """How many modules of the CAD library and its kernel a command imports."""
        code = (
            "import sys; from mbcdm_cad.cli import run; run(sys.argv[1:]); "
            "print('imports', sum(n.split('.')[0] in ('cadquery', 'OCP', 'vtkmodules') for n in sys.modules))"
        )
        return int(self.python("-c", code, *arguments)[1].split()[-1])

    def entries(self) -> set[Path]:
        """The entries of the cache."""
        return {path for path in self.cache.glob("*/*") if not path.name.startswith(".")}

    def answers(self) -> set[Path]:
        """The entry with the answers of interference runs: the names of what an entry holds stand at its head."""
        return {path for path in self.entries() if b'[["keys", ' in path.read_bytes()[:200]}


def prepare_bare_build(design: Path, built: Path, target: Path) -> None:
    """From a finished output: one BREP a part, and the plan that bare_build.py follows."""
    import cadquery as cq

    from mbcdm_cad.layouts.loader import load_design
    from mbcdm_cad.workshop.meshing import kernel_tolerances

    drive = load_design(design).drive
    assembly = layout_of(drive).bill()
    target.mkdir()
    for part in assembly.parts:
        solid = cq.importers.importStep(str(built / "parts" / f"{part}.step")).val()
        solid.exportBrep(str(target / f"{part}.brep"))
    linear_mm, angular_rad = kernel_tolerances(drive.export.mesh_tolerance_mm)
    items = [
        {
            "name": item.name,
            "part": item.part,
            "origin": item.location.shift_mm.tolist(),
            "x": item.location.rotation[:, 0].tolist(),
            "z": item.location.rotation[:, 2].tolist(),
        }
        for item in assembly.items
    ]
    plan = {"parts": list(assembly.parts), "items": items, "linear_mm": linear_mm, "angular_rad": angular_rad}
    (target / "parts.json").write_text(json.dumps(plan))


def edited(design: Path, target: Path) -> Path:
    """A copy of the design with one dimension larger by ``EDIT_MM``."""
    text, count = re.subn(
        rf"^(\s*{EDITED_PARAMETER}:\s*)([0-9.]+)",
        lambda match: f"{match[1]}{float(match[2]) + EDIT_MM:.6g}",
        design.read_text("utf-8"),
        count=1,
        flags=re.MULTILINE,
    )
    if not count:
        raise RuntimeError(f"{design} has no {EDITED_PARAMETER} to edit")
    target.write_text(text, "utf-8")
    return target


def failing(design: Path, target: Path) -> Path:
    """A copy of the design that fails checks: ropes may be bent far less than they are."""
    text, count = re.subn(
        r"(?m)^(\s*bend_ratio_min:\s*)([0-9.]+)",
        lambda match: f"{match[1]}{BEND_FACTOR * float(match[2]):.6g}",
        design.read_text("utf-8"),
        count=1,
    )
    if not count:
        raise RuntimeError(f"{design} has no bend_ratio_min to edit")
    target.write_text(text, "utf-8")
    return target


def start_figures(bench: Bench) -> Iterator[Figure]:
    """``check`` and ``analyse`` over the bare import; nothing is remembered of a design, so every run is a first."""
    fails = failing(bench.design, bench.room / "failing.yaml")
    for name in ("check", "analyse"):
        bench.command(name, bench.design)  # compiled from here on
    times = in_turns(
        START_ROUNDS,
        bare=lambda: bench.python("-c", _BARE_IMPORT)[0],
        check=lambda: bench.command("check", bench.design),
        analyse=lambda: bench.command("analyse", bench.design),
        failing=lambda: bench.command("check", fails),
    )
    bare = times["bare"]
    yield Figure(f"bare {_BARE_IMPORT}", bare, "s")
    for name in ("check", "analyse"):
        yield Figure(f"{name} over the bare import", times[name] / bare, "x", CHECK_RATIO_LIMIT)
    yield Figure("check of a design that fails, with remedies", times["failing"], "s", FAILING_LIMIT_S)


def edit_figures(bench: Bench) -> Iterator[Figure]:
    """One dimension of the drum edited, everything else known: with the interference run and without it."""
    changed = edited(bench.design, bench.room / "edited.yaml")
    known = bench.entries()
    answers = {path: path.read_bytes() for path in bench.answers()}

    def edit(answers_known: bool) -> float:
        """Time of the build, all that an earlier round stored of the edit forgotten but, if they are, the answers."""
        for path in bench.entries() - known:
            path.unlink()
        if not answers_known:
            for path, content in answers.items():
                path.write_bytes(content)
        return bench.build(design=changed)[0]

    times = in_turns(
        bench.repeat,
        bare=lambda: bench.python("-c", "import cadquery")[0],
        run=lambda: edit(answers_known=False),
        known=lambda: edit(answers_known=True),
    )
    bare = times["bare"]
    name = f"{EDITED_PARAMETER} + {EDIT_MM:g} mm, beyond the import of cadquery"
    yield Figure("bare import cadquery", bare, "s")
    yield Figure(f"{name}, interference run included", times["run"] - bare, "s", EDIT_LIMIT_S)
    yield Figure("  the same over the import", times["run"] / bare - 1.0, "x")
    yield Figure(f"{name}, interference known (aim 1 s)", times["known"] - bare, "s")
    yield Figure("  the same over the import", times["known"] / bare - 1.0, "x")


def measured(bench: Bench) -> list[Figure]:
    """All figures, each printed as soon as it is there."""
    figures: list[Figure] = []

    def note(figure: Figure) -> None:
        figures.append(figure)
        print(figure, flush=True)

    for figure in start_figures(bench):
        note(figure)

    built = bench.room / "built"
    full = bench.build(out=built)[0]
    (folder,) = (path for path in built.iterdir() if not path.name.startswith("."))
    note(Figure("build from nothing, interference run included", full, "s"))

    same = ("build", str(bench.design), "--out", str(built), "--force")
    imported = bench.kernel_imports("check", str(bench.design)) + bench.kernel_imports(*same)
    note(Figure("modules of the CAD library imported by check, and with nothing changed", imported, "", 0))
    unchanged = bench.least(lambda: bench.build(out=built)[0], 5)
    note(Figure("build, nothing changed", unchanged, "s", UNCHANGED_LIMIT_S))
    elsewhere = bench.least(lambda: bench.build()[0])
    note(Figure("build, nothing changed, into a new folder", elsewhere, "s"))

    def only_interference() -> float:
        for path in bench.answers():
            path.unlink()
        return bench.build()[0] - elsewhere

    interference = bench.least(only_interference)
    note(Figure(f"interference run over the travel, {CORES} cores", interference, "s", INTERFERENCE_LIMIT_S))

    def without_interference() -> float:
        for path in bench.entries() - bench.answers():
            path.unlink()
        return bench.build()[0]

    plan = bench.room / "plan"
    prepare_bare_build(bench.design, folder, plan)
    script = str(ROOT / "benchmarks" / "bare_build.py")
    pairs = [
        (without_interference(), bench.python(script, str(plan), str(bench.room / f"bare{n}"))[0])
        for n in range(bench.repeat)
    ]
    own, bare = (min(times) for times in zip(*pairs, strict=True))
    note(Figure("bare process that loads the solids and writes the same files", bare, "s"))
    note(Figure("build from nothing, interference known", own, "s"))
    note(Figure("build from nothing over the bare process", own / bare, "x", BUILD_RATIO_LIMIT))

    for figure in edit_figures(bench):
        note(figure)
    return figures


def main() -> int:
    """Measure, print, and tell whether all limits hold."""
    options = arguments(__doc__, repeat=3).parse_args()
    with tempfile.TemporaryDirectory() as room:
        print("Ratios are between processes of this run; limits are those of the project.")
        figures = measured(Bench(options.design.resolve(), Path(room), options.repeat))
    return finish(figures, options.json)


if __name__ == "__main__":
    sys.exit(main())
