"""Drives that people built, from short files: the figures of each stand beside what is published.

    python -m benchmarks.studies.built_by_others params/built-by-others docs [NAME ...]

writes ``docs/built-by-others.md`` and, below ``docs/pictures/built-by-others``, a picture of each drive that passes and
is not too large; with names, those drives anew, and the others stay on the page as they are. The comments of a file say
what the drive is, what is published of it, what differs here and why, and what a look at the drawn drive shows.
"""

import re
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mbcdm_cad.checks.comparison import CheckResult, failed
from mbcdm_cad.checks.run import Budget, run_check
from mbcdm_cad.checks.size import estimated_mass_g
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.model.analysis import analyse
from mbcdm_cad.report.data import masses_by_item
from mbcdm_cad.report.losses import losses_report
from mbcdm_cad.report.table import ReportTable
from mbcdm_cad.storage.cache import Cache, cache_folder
from mbcdm_cad.storage.folders import write_whole
from mbcdm_cad.workshop.mass import combined
from mbcdm_cad.workshop.store import drawn

_PICTURE_PX = (360, 280)
# A drum of a larger radius is not drawn here: its parts take many minutes.
LARGEST_MM = 100.0
_COLUMNS = (
    "drive",
    "ratio",
    "travel, deg",
    "radii, mm",
    "rope, preload",
    "motor, gearhead",
    "torque, N m",
    "stiffness, N m/rad",
    "backdrive, N m",
    "mass, g",
    "fail of checks",
)
_HEAD = """# Drives that people built

Drives that other people built and published, written down from their published requirements in files of at most twelve
lines in `params/built-by-others/`. The sizing rules compute all other values. `make built-by-others` checks each drive,
draws those with a drum of at most 100 mm in radius, and writes this page; only `mbcdm build` tests a drive for
interference.

Torque: with the motor's continuous torque, in the weaker direction. Stiffness: at the payload at the test torque, the
inputs held. Backdrive: torque at the drum that turns the motors without current. A mass after "about" is computed
without drawing the parts. Seen: what a builder would change when he looks at the drive as it comes out.
"""
_LABEL = re.compile(r"\s*\b(Published|Differs|Seen): ")


@dataclass(frozen=True)
class BuiltDrive:
    """One drive: its file, its checks, its mass as drawn and its picture; None where it is not drawn."""

    loaded: LoadedDesign
    checks: tuple[CheckResult, ...]
    mass_g: float | None = None
    png: bytes | None = None

    def row(self) -> tuple[Any, ...]:
        """Its line of the table."""
        drive, passes = self.loaded.drive, not failed(self.checks)
        cable, layout = drive.cables[0], layout_of(drive)
        structure = structure_of(layout) if passes else None
        back = losses_report(layout).to_dict()["backdrive"] if passes else None
        mass = f"about {estimated_mass_g(layout.bill()):.0f}" if passes else None
        return (
            drive.name,
            _ratio(drive),
            drive.travel_words,
            f"{cable.drum_radius_mm:.4g}, {cable.input_radius_mm:.3g}",
            f"{drive.cable.name}, {cable.preload_N:g} N",
            f"{drive.motor.name}, {drive.gearhead.name}",
            min(analyse(layout_of(drive)).peak_torque_Nm) if passes else None,
            f"{structure.stiffness_Nm_rad:.3g}" if structure else None,
            f"{back['running_Nm']:.2g}" if back else None,
            mass if self.mass_g is None else f"{self.mass_g:.0f}",
            f"{len(failed(self.checks))} of {len(self.checks)}",
        )


def _ratio(drive: Drive) -> str:
    """Of the cables, and before it that of belt or gears, or of a first cable stage."""
    cables, stage = f"{drive.cables[0].drum_radius_mm / drive.cables[0].input_radius_mm:.4g}", drive.stage
    if drive.cable_stage is not None:
        return f"{drive.cable_stage.ratio:.4g} (cables) x {cables}"
    return cables if stage is None else f"{stage.ratio:.3g} ({stage.kind}) x {cables}"


def told(text: str) -> dict[str, str]:
    """What a file's comments say: under "" what the drive is, the rest under its labels."""
    words = " ".join(line.removeprefix("#").strip() for line in text.splitlines() if line.startswith("#"))
    first, *rest = _LABEL.split(words)
    return {"": first} | dict(zip(rest[::2], rest[1::2], strict=True))


def built_drive(path: Path, cache: Cache) -> BuiltDrive:
    """One drive, drawn if it passes. Raises as ``load_design`` and ``drawn`` do."""
    from mbcdm_cad.workshop.export.picture import picture_png  # loads the drawing library

    loaded = load_design(path)
    drive, layout = loaded.drive, layout_of(loaded.drive)
    with np.errstate(all="ignore"):
        checks = tuple(run_check(check, layout, Budget(0)) for check in checks_of(drive))
    if failed(checks) or drive.cables[0].drum_radius_mm > LARGEST_MM:
        return BuiltDrive(loaded, checks)
    items, parts = drawn(drive, 0.0, cache, lambda name: None)
    mass_g = combined(masses_by_item(layout.bill(), parts).values()).mass_g
    meshes = {name: part.files.mesh for name, part in parts.items()}
    return BuiltDrive(loaded, checks, mass_g, picture_png(items, meshes, "output", _PICTURE_PX))


def section(one: BuiltDrive, folder: str) -> Iterator[str]:
    """Lines of one drive below the table; ``folder``: that of the pictures, relative to the page."""
    name, said = one.loaded.drive.name, told(one.loaded.text)
    yield f"\n## {name}\n"
    yield f"`params/built-by-others/{one.loaded.path.name}`: {said['']}\n"
    yield from (f"{label}: {said[label]}\n" for label in ("Published", "Differs", "Seen") if label in said)
    yield from (f"- `{check.id}` fails: {check.message}" for check in failed(one.checks))
    if one.png is not None:
        yield f"![{name}, drum centred, seen from its output side]({folder}/{name}.png)"


def parts_of(page: str) -> tuple[dict[str, str], dict[str, str]]:
    """Rows of the table and sections of a written page, by the drives' names."""
    table, *sections = page.split("\n\n## ")
    rows = {line.split(" | ")[0].removeprefix("| "): line for line in table.splitlines() if line.startswith("| ")}
    del rows["drive"], rows["---"]
    return rows, {text.split("\n", 1)[0]: f"\n## {text.rstrip()}" for text in sections}


def page(drives: Sequence[BuiltDrive], folder: str, before: str = "") -> str:
    """The page with these drives, and with those that only ``before``, the page so far, has."""
    head = ReportTable(_COLUMNS, tuple(one.row() for one in drives)).markdown()
    rows, sections = parts_of(before) if before else ({}, {})
    for one, row in zip(drives, head[2:], strict=True):
        rows[one.loaded.drive.name] = row
        sections[one.loaded.drive.name] = "\n".join(section(one, folder)).rstrip()
    order = sorted(rows)
    return "\n".join([_HEAD, *head[:2], *(rows[k] for k in order), *(sections[k] for k in order)]) + "\n"


def main(designs: Path, docs: Path, *names: str) -> None:
    """Write page and pictures; with ``names`` those drives only, the others as the page has them."""
    cache, drives = Cache(cache_folder()), []
    for path in sorted(designs.glob("*.yaml")):
        if not names or path.stem in names:
            print(f"drawing {path.stem}", file=sys.stderr, flush=True)
            drives.append(built_drive(path, cache))
    folder, to = Path("pictures", "built-by-others"), docs / "built-by-others.md"
    files = {docs / folder / f"{one.loaded.drive.name}.png": one.png for one in drives if one.png is not None}
    text = page(drives, folder.as_posix(), to.read_text("utf-8") if names else "")
    write_whole({to: text.encode(), **files})


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), *sys.argv[3:])
