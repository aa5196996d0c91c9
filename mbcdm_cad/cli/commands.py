"""The commands. Each imports what it needs when it runs, so that none pays for another's libraries."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mbcdm_cad import __version__

if TYPE_CHECKING:
    from mbcdm_cad.design import LoadedDesign

_DESIGN = click.argument("design", type=click.Path(path_type=Path))


def _loaded(path: Path, use_cache: bool = True) -> LoadedDesign:
    """The design, read before anything else is imported, so that bad input is told at once."""
    from mbcdm_cad.design import load_remembered
    from mbcdm_cad.storage.cache import Cache, cache_folder

    return load_remembered(path, Cache(cache_folder() if use_cache else None))


def _remembered(kind: str, loaded: LoadedDesign, make: Callable[[], dict[str, bytes]]) -> dict[str, bytes]:
    """The answer of one command on a design: a design asked about before is answered without loading the model."""
    from mbcdm_cad.storage.cache import Cache, cache_folder
    from mbcdm_cad.storage.keys import content_key, package_hash

    return Cache(cache_folder()).get_or_make(content_key(kind, loaded.sha256, package_hash(), {}), make)


def _finite(_context: click.Context, _parameter: click.Parameter, value: float) -> float:
    if not math.isfinite(value):
        raise click.BadParameter(f"{value} is not an angle; give degrees within the travel, such as 12.5")
    return value


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="mbcdm")
def mbcdm() -> None:
    """Cable drives from a design file: checked, weighed and openable parts."""


@mbcdm.command()
@_DESIGN
@click.option("--json", "as_json", is_flag=True, help="Print the results as JSON.")
def check(design: Path, as_json: bool) -> int:
    """Check DESIGN without drawing it. Exit 1 if a check fails."""
    loaded = _loaded(design)

    def make() -> dict[str, bytes]:
        from mbcdm_cad.report.check_text import outputs

        return outputs(loaded)

    found = _remembered("check", loaded, make)
    coloured = sys.stdout.isatty() and "NO_COLOR" not in os.environ
    click.echo(found["json" if as_json else "colour" if coloured else "plain"].decode(), color=coloured)
    return int(found["code"])


@mbcdm.command()
@_DESIGN
@click.option(
    "--angle", "angle_deg", type=float, default=0.0, metavar="DEG", callback=_finite, help="Drum angle of the assembly."
)
@click.option("--force", is_flag=True, help="Build although a check fails; every output then says so.")
@click.option("--out", type=click.Path(path_type=Path), default=Path("out"), show_default=True, metavar="DIR",
              help="Folder that the design's folder is written into.")  # fmt: skip
@click.option("--no-cache", is_flag=True, help="Neither read nor write the cache.")
@click.option("--jobs", type=click.IntRange(1, 64), default=None, metavar="N", help="Processes; all cores by default.")
def build(design: Path, angle_deg: float, force: bool, out: Path, no_cache: bool, jobs: int | None) -> int:
    """Build DESIGN: STEP, STL and GLB of parts and assembly, and the report. Exit 1 if a check fails."""
    loaded = _loaded(design, use_cache=not no_cache)
    from mbcdm_cad.cli.building import build_command

    return build_command(loaded, angle_deg=angle_deg, force=force, out=out, use_cache=not no_cache, jobs=jobs)


@mbcdm.command()
@_DESIGN
@click.argument("png", type=click.Path(path_type=Path))
@click.option("--angle", "angle_deg", type=float, default=0.0, metavar="DEG", help="Drum angle of the assembly.")
@click.option("--view", default="output", show_default=True, metavar="VIEW",
              help="output, iso, iso_rear, front, rear, left, right, top or bottom.")  # fmt: skip
@click.option("--no-cache", is_flag=True, help="Neither read nor write the cache.")
def picture(design: Path, png: Path, angle_deg: float, view: str, no_cache: bool) -> int:
    """Draw DESIGN into the picture PNG; needs no display."""
    from mbcdm_cad.cli.building import picture_command
    from mbcdm_cad.design import load_design

    return picture_command(load_design(design), png, angle_deg=angle_deg, view=view, use_cache=not no_cache)


@mbcdm.command()
@_DESIGN
@click.option("--json", "as_json", is_flag=True, help="Print the results as JSON.")
def analyse(design: Path, as_json: bool) -> int:
    """Tension, backlash, load sharing and capability of DESIGN."""
    loaded = _loaded(design)

    def make() -> dict[str, bytes]:
        from mbcdm_cad.report.analysis_text import analysis_outputs

        return analysis_outputs(loaded.drive)

    click.echo(_remembered("analyse", loaded, make)["json" if as_json else "plain"].decode())
    return 0


@mbcdm.command()
@_DESIGN
@click.option("--out", type=click.Path(path_type=Path), default=Path("out"), show_default=True, metavar="DIR",
              help="Folder that the study's folder, NAME-sensitivity, is written into.")  # fmt: skip
def sensitivity(design: Path, out: Path) -> int:
    """Fig. 5 of the paper for DESIGN as plots and CSV, global indices, tolerance stack, intervals."""
    from mbcdm_cad.cli.studies import sensitivity_command
    from mbcdm_cad.design import load_design

    return sensitivity_command(load_design(design), out=out)


@mbcdm.command()
@click.argument("design", type=click.Path(path_type=Path), required=False)
def reproduce(design: Path | None) -> int:
    """The paper's numbers beside the model's, for DESIGN or the reference. Exit 1 if one leaves its tolerance."""
    from mbcdm_cad.cli.studies import reproduce_command

    return reproduce_command(design)


@mbcdm.command()
@_DESIGN
@click.argument("measurements", type=click.Path(path_type=Path), nargs=-1, required=True)
@click.option("--json", "json_path", type=click.Path(path_type=Path), metavar="FILE", help="Write the result as JSON.")
@click.option("--apply", "as_built", type=click.Path(path_type=Path), metavar="AS_BUILT.yaml",
              help="Write the design file with what was found in it.")  # fmt: skip
@click.option("--report", type=click.Path(path_type=Path), metavar="FOLDER", help="Write a page with plots there.")
def loop(
    design: Path, measurements: tuple[Path, ...], json_path: Path | None, as_built: Path | None, report: Path | None
) -> int:
    """What does the model of DESIGN lack? Judge measured runs, described by MEASUREMENTS (YAML beside the CSV)."""
    loaded = _loaded(design)
    from mbcdm_cad.cli.loop import Outputs, loop_command

    return loop_command(loaded, measurements, Outputs(json_path, as_built, report))


@mbcdm.command()
@click.option("--reference", is_flag=True, help="Print the reference page in Markdown instead.")
@click.option("--measurement", is_flag=True, help="Of measurement files, which 'mbcdm loop' reads.")
def schema(reference: bool, measurement: bool) -> None:
    """Print the JSON Schema of design files, for completion in an editor."""
    if reference:
        from mbcdm_cad.design.reference import reference_page
        from mbcdm_cad.measurement.reference import measurement_page

        click.echo(measurement_page() if measurement else reference_page(), nl=False)
        return
    import json

    from mbcdm_cad.design.editor import editor_schema
    from mbcdm_cad.measurement.schema import json_schema

    click.echo(json.dumps(json_schema() if measurement else editor_schema(), indent=2, ensure_ascii=False))


@mbcdm.command()
@click.argument("new", type=click.Path(path_type=Path))
def init(new: Path) -> None:
    """Write NEW, a commented design file with the values of the reference design. Never overwrites."""
    from mbcdm_cad.design.template import new_design_text, slug
    from mbcdm_cad.errors import InputError, Problem

    name = slug(new.stem)
    try:
        with open(new, "x", encoding="utf-8", newline="\n") as file:
            file.write(new_design_text(name))
    except FileExistsError:
        problem = Problem(str(new), 1, "", "exists already", remedy="choose another name, or remove it first")
        raise InputError([problem]) from None
    except ValueError as error:
        raise InputError([Problem(str(new), 1, "", f"cannot be written: {error}", remedy="check the path")]) from None
    click.echo(f"{new}: design {name} written; 'mbcdm check {new}' checks it")


@mbcdm.command()
@_DESIGN
@click.argument("experiment", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), default=Path("out"), show_default=True, metavar="DIR",
              help="Folder that the experiment's folder is written into.")  # fmt: skip
def simulate(design: Path, experiment: Path, out: Path) -> None:
    """Run EXPERIMENT.yaml on the test rig in software with DESIGN: a measured run, and apart from it the truth."""
    loaded = _loaded(design)
    from mbcdm_cad.rig.reading import read_experiment

    wanted = read_experiment(experiment)
    from mbcdm_cad.rig.command import simulate_command

    click.echo(simulate_command(loaded.drive, wanted, out))
