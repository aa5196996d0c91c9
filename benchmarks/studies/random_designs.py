"""Build designs that pass the checks: every part must be one valid solid with a watertight mesh, without interference.

    python -m benchmarks.studies.random_designs --count 200 --seed 1 --workers 2
    python -m benchmarks.studies.random_designs --count 100 --workshop
    python -m benchmarks.studies.random_designs --count 50 --configuration siso_spur

``--workshop`` also tests the take-up on solids, the 3MF files, the parts rebuilt from their drawings, the tables of
holes against the solids, and that a forced build with odd sizes never ends with a kernel message.

Seeds are tried upwards from ``--seed`` until ``--count`` of them pass the checks. Failures are counted by stage, with
their seeds; ``--only SEED`` runs one, ``--save DIR`` writes the design files. Exit 1 if anything failed.
"""

import argparse
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
import yaml

from benchmarks.studies.workshop import at_rest, forced, forced_parts, workshop
from benchmarks.study import add_workers, run_many
from mbcdm_cad.checks.size import estimated_mass_g
from mbcdm_cad.design.bought import Material
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.miso_bevel import checks as miso_bevel_checks
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.layouts.siso_bevel import checks as bevel_checks
from mbcdm_cad.layouts.siso_spur.checks import frame
from mbcdm_cad.parts.bill import CABLE, Bill, PartSpec
from mbcdm_cad.workshop.interference import travel_poses
from mbcdm_cad.workshop.kernel import bounding_box
from mbcdm_cad.workshop.mass import PartFiles
from mbcdm_cad.workshop.meshing import drawn_part, make_part_files
from tests.support.interference_of_solids import MESH_TOLERANCE_MM, interferences, mesh_of
from tests.support.random_generator import LAYOUTS, USUAL, Passing, load, passing

STAGES = ("draw", "sound", "mesh", "interference", "box", "mass", "take-up", "drawing", "print", "holes", "forced")
# How far the box worked out before anything is drawn may be from that of the solids: it has the corners of the
# terminals' nuts where they reach furthest, and on each side they may stand otherwise by a few hundredths.
BOX_MM = 0.2
# How far the mass worked out before anything is drawn may be from that of the solids, as a share.
MASS_SHARE = 0.03
SPACES = {**LAYOUTS, USUAL.configuration: USUAL}
# What foresees box and volumes before anything is drawn.
BOXES: dict[str, Any] = {
    "miso_bevel": miso_bevel_checks.box_mm,
    "siso_spur": frame.box_mm,
    "miso_spur": frame.box_mm,
    "siso_bevel": bevel_checks.box_mm,
}


def box_mm(drive: Any) -> tuple[float, float, float]:
    """Box (X, Z, Y) worked out before anything is drawn, mm."""
    size: tuple[float, float, float] = BOXES[drive.configuration](layout_of(drive))
    return size


@dataclass(frozen=True)
class Failure:
    """What went wrong with one design, and at which stage."""

    seed: int
    stage: str
    what: str


@dataclass(frozen=True)
class Outcome:
    """One design tried: why it did not pass the checks, or its figures and failures."""

    seed: int
    rejected: str
    figures: dict[str, float]
    failures: tuple[Failure, ...]


def figures(found: Passing) -> dict[str, float]:
    """What varies, for the table of the spread."""
    d = found.loaded.drive
    first, last = d.cables[0], d.cables[-1]
    own = {"smallest guide radius, mm": first.guide_radius_mm} if hasattr(first, "guide_radius_mm") else {}
    if hasattr(d, "centre_distance_mm"):
        own["centre distance, mm"] = d.centre_distance_mm
    if hasattr(d, "helix_lead_mm"):
        own["lead over diameter"] = d.helix_lead_mm / d.cable.diameter_mm
    return {
        "rope diameter, mm": d.cable.diameter_mm,
        "smallest input radius, mm": first.input_radius_mm,
        **own,
        "largest drum radius, mm": last.drum_radius_mm,
        "drum step, mm": d.cables[1].drum_radius_mm - first.drum_radius_mm,
        "total ratio": first.drum_radius_mm / first.input_radius_mm,
        "half travel, deg": d.half_travel_deg,
        "sector half angle, deg": d.drum.sector_half_angle_deg,
        "preload, N": first.preload_N,
        **{f"box {axis}, mm": side for axis, side in zip("XZY", box_mm(d), strict=True)},
    }


def exercise(found: Passing, poses: int) -> Iterator[Failure]:
    """Draw, test, mesh and turn one design; yields what fails."""
    dims: Any = layout_of(found.loaded.drive)
    b = dims.bill()
    material = {item.part: item.material for item in b.items}
    solids: dict[str, Any] = {}
    for name, spec in b.parts.items():
        try:
            solids[name] = spec.part.solid()
        except Exception as error:  # the kernel raises what it likes
            yield Failure(found.seed, "draw", f"{name}: {type(error).__name__}: {error}")
            continue
        try:
            files = _files(spec, solids[name], material[name])
        except Exception as error:
            stage = "mesh" if "mesh" in str(error) else "sound"
            yield Failure(found.seed, stage, f"{error}")
            continue
        mesh = trimesh.load(trimesh.util.wrap_as_stream(files.stl), file_type="stl")
        if not (mesh.is_watertight and mesh.is_winding_consistent and mesh.volume > 0):
            yield Failure(found.seed, "mesh", f"{name}: STL is not watertight to another reader")
    rigid = {name: solid for name, solid in solids.items() if not name.startswith(CABLE)}
    try:
        clashes = interferences(dims, rigid, travel_poses(found.loaded.drive.half_travel_deg, poses))
    except Exception as error:
        yield Failure(found.seed, "interference", f"{type(error).__name__}: {error}")
    else:
        for first, second in sorted({(c.first, c.second) for c in clashes}):
            worst = max(
                (c for c in clashes if (c.first, c.second) == (first, second)),
                key=lambda c: c.volume_mm3 + c.overlap_mm,
            )
            yield Failure(found.seed, "interference", str(worst))
    if len(solids) == len(b.parts):
        corners = np.array([bounding_box(solids[item.part], item.location) for item in b.items])
        size = corners[:, 1].max(axis=0) - corners[:, 0].min(axis=0)
        foreseen = box_mm(found.loaded.drive)
        off = np.abs(size[[0, 2, 1]] - foreseen)
        if off.max() > BOX_MM:
            yield Failure(found.seed, "box", f"X, Z, Y {size[[0, 2, 1]].round(2)}, foreseen {np.round(foreseen, 2)} mm")
        estimated, drawn = masses_g(found, b, solids)
        if abs(estimated / drawn - 1.0) > MASS_SHARE:
            yield Failure(found.seed, "mass", f"{drawn:.1f} g, estimated {estimated:.1f} g")


def _files(spec: PartSpec, solid: Any, material: Material) -> PartFiles:
    """As a build makes them: cables by the way that it has for them; the run for clashes needs the same meshes."""
    if spec.name.startswith(CABLE):
        return drawn_part(spec, material, MESH_TOLERANCE_MM)
    return replace(make_part_files(spec.name, solid, material, None), mesh=mesh_of(spec.name, solid))


def masses_g(found: Passing, b: Bill, solids: dict[str, Any]) -> tuple[float, float]:
    """Mass of all items: estimated before anything is drawn, and by the volumes of the solids."""
    drawn = sum(
        solids[item.part].Volume() * item.material.density_g_cm3 * 1e-3 if item.mass_g is None else item.mass_g
        for item in b.items
    )
    return estimated_mass_g(b), drawn


def exercise_workshop(found: Passing, undrawn: tuple[str, ...] = ()) -> Iterator[Failure]:
    """What the workshop asks of one design, and of one forced in its place; yields what fails."""
    dims: Any = layout_of(found.loaded.drive)
    b = dims.bill()
    try:
        solids = at_rest(b)
    except Exception as error:  # the kernel raises what it likes
        yield Failure(found.seed, "draw", f"{type(error).__name__}: {error}")
        return
    for stage, what in workshop(dims, b, solids, undrawn):
        yield Failure(found.seed, stage, what)
    data, changed = forced(found.data, found.loaded.drive, found.seed)
    try:
        drive = load(data).drive
    except InputError:
        return  # refused before anything is drawn, with line, limit and remedy
    for stage, what in forced_parts(drive, changed):
        yield Failure(found.seed, stage, what)


def attempt(task: tuple[int, int, str]) -> Outcome:
    """One seed: a design that passes, and what comes of it; the workshop's part where there are no poses."""
    seed, poses, configuration = task
    found = passing(seed, SPACES[configuration])
    if isinstance(found, str):
        return Outcome(seed, found, {}, ())
    return Outcome(seed, "", figures(found), tuple(exercise(found, poses) if poses else exercise_workshop(found)))


def attempts(options: argparse.Namespace) -> Iterator[Outcome]:
    """Outcomes of seeds from the first on, until as many as wanted have passed the checks."""
    seed, left = options.seed, options.count
    while left > 0:
        tasks = [(s, options.poses, options.configuration) for s in range(seed, seed + left)]
        seed += left
        for outcome in run_many(attempt, tasks, options):
            left -= not outcome.rejected
            yield outcome


def report(outcomes: list[Outcome]) -> str:
    """Spread, rejections and failures by stage."""
    built = [o for o in outcomes if not o.rejected]
    lines = [f"{len(built)} designs pass the checks, of {len(outcomes)} drawn"]
    lines.append(
        "Fail: "
        + (
            ", ".join(f"{name} {n}" for name, n in Counter(o.rejected for o in outcomes if o.rejected).most_common())
            or "none"
        )
    )
    lines.append(f"{'spread':28s}{'least':>10s}{'median':>10s}{'most':>10s}")
    for name in built[0].figures if built else ():
        values = [o.figures[name] for o in built]
        lines.append(f"{name:28s}{min(values):10.3f}{np.median(values):10.3f}{max(values):10.3f}")
    by_stage: dict[str, list[Failure]] = defaultdict(list)
    for outcome in built:
        for failure in outcome.failures:
            by_stage[failure.stage].append(failure)
    lines.append(f"{'stage':14s}{'designs that fail':>18s}  seeds")
    for stage in STAGES:
        seeds = sorted({f.seed for f in by_stage[stage]})
        lines.append(f"{stage:14s}{len(seeds):18d}  {' '.join(map(str, seeds))}")
    lines += [f"  seed {f.seed}, {f.stage}: {f.what}" for stage in STAGES for f in by_stage[stage]]
    return "\n".join(lines)


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=200, help="designs to build")
    parser.add_argument("--seed", type=int, default=1, help="first seed")
    parser.add_argument("--poses", type=int, default=9, help="poses of the interference run")
    parser.add_argument("--workshop", action="store_true", help="take-up, drawings, 3MF and tables of holes instead")
    parser.add_argument("--configuration", choices=sorted(SPACES), default="miso_bevel", help="layout to draw from")
    parser.add_argument("--only", type=int, help="this seed alone")
    parser.add_argument("--save", type=Path, help="folder for the design files of all that pass")
    add_workers(parser)
    options = parser.parse_args()
    start = time.monotonic()
    options.poses = 0 if options.workshop else options.poses
    if options.only is not None:
        stream: Iterator[Outcome] = iter([attempt((options.only, options.poses, options.configuration))])
    else:
        stream = attempts(options)
    outcomes = []
    for outcome in stream:
        outcomes.append(outcome)
        if not outcome.failures:
            print(f"seed {outcome.seed}: {'fails ' + outcome.rejected if outcome.rejected else 'sound'}", flush=True)
        for failure in outcome.failures:
            print(f"seed {failure.seed}, {failure.stage}: {failure.what}", flush=True)
        if options.save and not outcome.rejected:
            found = passing(outcome.seed, SPACES[options.configuration])
            assert isinstance(found, Passing)
            options.save.mkdir(parents=True, exist_ok=True)
            text = yaml.safe_dump(found.data, sort_keys=False)
            (options.save / f"random-{outcome.seed}.yaml").write_text(text, "utf-8")
    print(report(outcomes))
    print(f"{time.monotonic() - start:.0f} s")
    return 1 if any(o.failures for o in outcomes) else 0


if __name__ == "__main__":
    sys.exit(main())
