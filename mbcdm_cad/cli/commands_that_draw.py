"""Commands that draw a design: parts and assembly, pictures, pages, drawings, files for other programs.

Each calls a function of :mod:`mbcdm_cad.api` and prints its result.
"""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from mbcdm_cad import api
from mbcdm_cad.cli import group
from mbcdm_cad.cli.group import ANGLE, DESIGN, FILE, JOBS, NO_CACHE, examples, load, mbcdm, out_folder, progress
from mbcdm_cad.report.page import PAGE
from mbcdm_cad.report.table import designs_shown

if TYPE_CHECKING:
    from mbcdm_cad.report.check_report import BuildReport

# Copy of the names of VIEWS in mbcdm_cad.workshop.export.picture, which needs the drawing library; a test compares.
VIEW_NAMES = ("output", "iso", "iso_rear", "front", "rear", "left", "right", "top", "bottom")


@mbcdm.command(epilog=examples("mbcdm build my_drive.yaml", "mbcdm build my_drive.yaml --angle 20 --out /tmp/drives"))
@DESIGN
@ANGLE
@click.option("--force", is_flag=True, help="Build although a check fails; every output then states it.")
@out_folder("Folder that the design's folder is written into.")
@NO_CACHE
@JOBS
def build(design: Path, angle_deg: float, force: bool, out: Path, no_cache: bool, jobs: int | None) -> int:
    """Build parts, assembly and report of a design.

    Writes STEP and STL of each part, STEP and GLB of the assembly, and the report. Exit code 1 if a check fails.
    """
    loaded = load(design)
    with progress() as note:
        report = loaded.build(out, angle_deg=angle_deg, force=force, jobs=jobs, cache=not no_cache, progress=note)
    if report.cache_problem:
        click.echo(f"warning: {report.cache_problem}; built without it", err=True)
    _print_failures(report)
    if report.folder is None:
        words = f"{design}: not built, {len(report.checks.failed)} check(s) fail; --force builds it anyway"
        click.echo(words, err=True)
    else:
        click.echo(report.text())
        if not (report.folder / PAGE).exists():
            click.echo(f"  mbcdm page {shlex.quote(str(design))} adds {PAGE}: the drive in 3D with all figures")
    return 0 if report.passed else 1


def _print_failures(report: BuildReport) -> None:
    for check in report.checks.failed:
        click.echo(f"fail: {check.id}: {check.message}; {check.remedy}", err=True)


@mbcdm.command(
    epilog=examples(
        "mbcdm compare params/mbcdm.yaml params/siso_bevel.yaml",
        "mbcdm compare my_drive.yaml my_other.yaml --page compared.html",
    )
)
@click.argument("designs", metavar="DESIGN...", type=FILE, nargs=-1, required=True)
@click.option(
    "--json", "as_json", is_flag=True, help="Print the figures as JSON, a list with one object for each design."
)
@click.option("--markdown", is_flag=True, help="Print the table as Markdown.")
@click.option("--page", type=FILE, metavar="FILE", help="Write a page with pictures, figures and plots to this file.")
@out_folder("Folder of the builds; designs that are not in it yet are built.")
@NO_CACHE
@JOBS
def compare(
    designs: tuple[Path, ...],
    as_json: bool,
    markdown: bool,
    page: Path | None,
    out: Path,
    no_cache: bool,
    jobs: int | None,
) -> None:
    """Compare built designs side by side.

    Torque in both directions, mass, box, backlash, stiffness, lowest mode, number of parts, smallest margin. Designs
    that are not built yet are built first; a design that fails a check is not compared.
    """
    if as_json and markdown:
        raise click.UsageError("--json and --markdown exclude each other; give one of them")
    with progress() as note:
        found = api.compare(designs, out, page=page, jobs=jobs, cache=not no_cache, progress=note)
    if page is not None:
        click.echo(f"{page}: {designs_shown(len(designs))} side by side, opens in any browser", err=True)
    if as_json:
        group.print_json(found.to_dict())
    else:
        click.echo(found.markdown() if markdown else found.text())


@mbcdm.command(
    epilog=examples(
        "mbcdm picture my_drive.yaml my_drive.png --view iso --angle 20",
        "mbcdm picture my_drive.yaml my_drive.gif --travel",
    )
)
@DESIGN
@click.argument("png", metavar="PNG", type=FILE)
@ANGLE
@click.option("--travel", is_flag=True, help="Draw the drum's travel as a moving picture (GIF file).")
@click.option(
    "--view", type=click.Choice(VIEW_NAMES), default="output", show_default=True, help="Direction of the view."
)
@NO_CACHE
def picture(design: Path, png: Path, angle_deg: float, travel: bool, view: str, no_cache: bool) -> None:
    """Draw a design into a PNG or GIF file; needs no display."""
    loaded = load(design)
    with progress() as note:
        if travel:
            done = loaded.moving_picture(png, view=view, cache=not no_cache, progress=note)
        else:
            done = loaded.picture(png, angle_deg=angle_deg, view=view, cache=not no_cache, progress=note)
    click.echo(done)


@mbcdm.command(epilog=examples("mbcdm page my_drive.yaml"))
@DESIGN
@click.option("--force", is_flag=True, help="Make the page although a check fails; the page then states it.")
@out_folder("Folder that the design's folder is written into.")
@NO_CACHE
def page(design: Path, force: bool, out: Path, no_cache: bool) -> int:
    """Write a page with the drive in 3D and all figures.

    Builds the design and writes report.html: checks, figures, plots and lists in one file that needs no network.
    """
    loaded = load(design)
    with progress() as note:
        found = loaded.page(out, force=force, cache=not no_cache, progress=note)
    _print_failures(found.build)
    if found.path is None:
        text = f"{design}: no page, {len(found.build.checks.failed)} check(s) fail; --force writes it anyway"
        click.echo(text, err=True)
    else:
        click.echo(found.text())
    return 0 if found.passed else 1


@mbcdm.command(epilog=examples("mbcdm watch my_drive.yaml"))
@DESIGN
@click.option(
    "--port", type=click.IntRange(0, 65535), default=0, metavar="N", help="Port of the page; any free port by default."
)
@out_folder("Folder that the design's folders are written into.")
@NO_CACHE
def watch(design: Path, port: int, out: Path, no_cache: bool) -> None:
    """Follow a design file: checks and page at each save.

    Prints the address of a page that is updated at each save. Changed parts are written to DIR/NAME-live at once, the
    complete build to DIR/NAME. Ctrl-C ends the command.
    """
    from mbcdm_cad.live.watch import follow

    follow(design, out=out, port=port, use_cache=not no_cache)


@mbcdm.command(
    epilog=examples("mbcdm export my_drive.yaml --format urdf", "mbcdm export my_drive.yaml --format mjcf --elastic")
)
@DESIGN
@click.option("--format", "form", type=click.Choice(("urdf", "mjcf", "fmu")), required=True, help="Format of the file.")
@click.option(
    "--elastic",
    is_flag=True,
    help="Cables with hysteresis, parts that give, motors, friction instead of a rigid ratio (MJCF only).",
)
@click.option("--package", metavar="NAME", help="Meshes by package://NAME/meshes, as RViz and Gazebo ask (URDF only).")
@click.option("--xacro", is_flag=True, help="A macro with a prefix for all names instead of a robot (URDF only).")
@click.option("--ros2-control", is_flag=True, help="Add the block that ros2_control reads (URDF only).")
@out_folder("Folder that the description's folder, NAME-FORMAT, is written into.")
@NO_CACHE
def export(
    design: Path,
    form: Literal["urdf", "mjcf", "fmu"],
    elastic: bool,
    package: str | None,
    xacro: bool,
    ros2_control: bool,
    out: Path,
    no_cache: bool,
) -> None:
    """Write a design for robot simulators.

    Links with mass and inertia, joints with the drive's ratios, meshes in metres; as FMU the drive's equations, for
    co-simulation. See docs/robot-formats.md.
    """
    if elastic and form != "mjcf":
        raise click.UsageError("--elastic: URDF has no springs between joints, an FMU always; give --format mjcf")
    if form != "urdf" and (package is not None or xacro or ros2_control):
        raise click.UsageError("--package, --xacro, --ros2-control: they belong to ROS; give --format urdf")
    loaded = load(design)
    with progress() as note:
        written = loaded.export(
            form,
            out,
            elastic=elastic,
            package=package,
            xacro=xacro,
            ros2_control=ros2_control,
            cache=not no_cache,
            progress=note,
        )
    click.echo(written)


@mbcdm.command(epilog=examples("mbcdm pictures my_drive.yaml"))
@DESIGN
@out_folder("Folder that the pictures' folder, NAME-pictures, is written into.")
@NO_CACHE
def pictures(design: Path, out: Path, no_cache: bool) -> None:
    """Draw pictures for the assembly of the drive.

    One for each step of the order of assembly, an exploded view, a section through the transfer to the drum.
    """
    loaded = load(design)
    with progress() as note:
        click.echo(loaded.pictures(out, cache=not no_cache, progress=note))


@mbcdm.command(epilog=examples("mbcdm prints my_drive.yaml"))
@DESIGN
@click.option("--all", "every_made_part", is_flag=True, help="Write the milled and turned parts too.")
@out_folder("Folder that the folder of 3MF files, NAME-prints, is written into.")
@NO_CACHE
def prints(design: Path, every_made_part: bool, out: Path, no_cache: bool) -> None:
    """Write 3MF files of the printed parts for a 3D printer.

    One file for each part, in millimetres, with its name, lying on its largest flat face.
    """
    loaded = load(design)
    with progress() as note:
        click.echo(loaded.prints(out, every_made_part=every_made_part, cache=not no_cache, progress=note))


@mbcdm.command(epilog=examples("mbcdm drawings my_drive.yaml", "mbcdm drawings my_drive.yaml --part input_pulley_left"))
@DESIGN
@out_folder("Folder that the drawings' folder, NAME-drawings, is written into.")
@click.option("--part", metavar="NAME", help="Draw only the sheet of this part.")
@NO_CACHE
@JOBS
def drawings(design: Path, out: Path, part: str | None, no_cache: bool, jobs: int | None) -> None:
    """Draw the workshop drawings of all made parts.

    One sheet for each part, as DXF with real dimensions, as PDF and as SVG.
    """
    loaded = load(design)
    with progress() as note:
        click.echo(loaded.drawings(out, part=part, jobs=jobs, cache=not no_cache, progress=note))
