"""The commands. Each imports what it needs when it runs, so that none pays for another's libraries."""

from __future__ import annotations

import math
from pathlib import Path

import click

from mbcdm_cad import __version__

# The names of VIEWS in mbcdm_cad.build.export.picture, which needs the drawing library; a test compares them.
VIEW_NAMES = ("output", "iso", "iso_rear", "front", "rear", "left", "right", "top", "bottom")
# Of mbcdm_cad.design.entries.KINDS, for the same reason.
CATALOGUE_KINDS = (
    "ropes",
    "terminations",
    "motors",
    "gearheads",
    "encoders",
    "bearings",
    "screws",
    "inserts",
    "tensioners",
    "materials",
)

_FILE = click.Path(path_type=Path)
_DESIGN = click.argument("design", type=_FILE)


def _examples(*lines: str) -> str:
    """Lines for the end of a help page; the mark keeps click from filling them into a paragraph."""
    return "\b\n" + "\n".join(["Examples:" if len(lines) > 1 else "Example:", *(f"  {line}" for line in lines)])


def _finite(_context: click.Context, _parameter: click.Parameter, value: float) -> float:
    if not math.isfinite(value):
        raise click.BadParameter(f"{value} is not an angle; give degrees within the travel, such as 12.5")
    return value


_ANGLE = click.option(
    "--angle", "angle_deg", type=float, default=0.0, metavar="DEG", callback=_finite, help="Drum angle of the assembly."
)
_NO_CACHE = click.option("--no-cache", is_flag=True, help="Neither read nor write the cache.")


@click.group(
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog=_examples(
        "mbcdm init my_drive.yaml     a commented copy of the reference design",
        "mbcdm check my_drive.yaml    a fraction of a second, no CAD",
        "mbcdm build my_drive.yaml    STEP, STL, GLB, report into out/my_drive",
    ),
)
@click.version_option(__version__, prog_name="mbcdm")
def mbcdm() -> None:
    """Cable drives from a design file: checked, weighed and openable parts.

    Exit codes: 0 done, 1 a check failed, 2 bad input. Completion for the shell: see docs/command-line.md.
    """


@mbcdm.command(
    epilog=_examples("mbcdm check my_drive.yaml", "mbcdm check --failed *.yaml", "mbcdm check my_drive.yaml --json")
)
@click.argument("designs", metavar="DESIGN...", type=_FILE, nargs=-1, required=True)
@click.option("--failed", "only_failed", is_flag=True, help="Show the failing checks only, without warnings.")
@click.option("--all", "show_all", is_flag=True, help="Show the passing checks too.")
@click.option("--json", "as_json", is_flag=True, help="Print all results as JSON; a list for several designs.")
def check(designs: tuple[Path, ...], only_failed: bool, show_all: bool, as_json: bool) -> int:
    """Check designs without drawing them.

    Prints what warns and what fails, with the figure that would pass, and a summary. Exit 1 if a check fails.
    """
    if only_failed and show_all:
        raise click.UsageError("--failed and --all exclude each other; give one of them")
    from mbcdm_cad.cli.checking import check_command

    return check_command(designs, as_json=as_json, show="failed" if only_failed else "all" if show_all else "findings")


@mbcdm.command(
    epilog=_examples(
        "mbcdm explain my_drive.yaml",
        "mbcdm explain my_drive.yaml drum.outer_face_y_mm",
        "mbcdm explain my_drive.yaml --graph why.svg",
    )
)
@_DESIGN
@click.argument("field", required=False)
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
@click.option("--graph", type=_FILE, metavar="FILE.svg", help="Draw what follows from what into this file.")
def explain(design: Path, field: str | None, as_json: bool, graph: Path | None) -> int:
    """Say why a field has its value.

    Without FIELD all fields that have a rule; with it the rule, what it rests on, and what drives it.
    """
    if graph is not None and (field or as_json):
        raise click.UsageError("--graph draws all fields; leave out FIELD and --json")
    from mbcdm_cad.cli.explaining import explain_command

    return explain_command(design, field, as_json=as_json, graph=graph)


@mbcdm.command(epilog=_examples("mbcdm solve my_drive.yaml", "mbcdm solve my_drive.yaml --apply my_drive_solved.yaml"))
@_DESIGN
@click.option("--apply", type=_FILE, metavar="FILE", help="Write the passing design there, comments kept.")
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
def solve(design: Path, apply: Path | None, as_json: bool) -> int:
    """Look for the nearest design that passes every check.

    Moves only what the file leaves free or gives as a range, {min: 30, max: 60} or min; prints the change as a patch.
    Where there is none: which requirements exclude each other, and how far each must give. Exit 1 then.
    """
    from mbcdm_cad.cli.solving import solve_command

    return solve_command(design, apply=apply, as_json=as_json)


@mbcdm.command(epilog=_examples("mbcdm build my_drive.yaml", "mbcdm build my_drive.yaml --angle 20 --out /tmp/drives"))
@_DESIGN
@_ANGLE
@click.option("--force", is_flag=True, help="Build although a check fails; every output then says so.")
@click.option(
    "--out",
    type=_FILE,
    default=Path("out"),
    show_default=True,
    metavar="DIR",
    help="Folder that the design's folder is written into.",
)
@_NO_CACHE
@click.option("--jobs", type=click.IntRange(1, 64), default=None, metavar="N", help="Processes; all cores by default.")
def build(design: Path, angle_deg: float, force: bool, out: Path, no_cache: bool, jobs: int | None) -> int:
    """Build parts, assembly and report of a design.

    Writes STEP and STL of each part, STEP and GLB of the assembly, and the report. Exit 1 if a check fails.
    """
    from mbcdm_cad.cli.building import build_command

    return build_command(design, angle_deg=angle_deg, force=force, out=out, use_cache=not no_cache, jobs=jobs)


@mbcdm.command(
    epilog=_examples(
        "mbcdm compare params/mbcdm.yaml params/siso_bevel.yaml",
        "mbcdm compare my_drive.yaml my_other.yaml --page compared.html",
    )
)
@click.argument("designs", metavar="DESIGN...", type=_FILE, nargs=-1, required=True)
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON, a list with one object a design.")
@click.option("--markdown", is_flag=True, help="Print the table as Markdown.")
@click.option("--page", type=_FILE, metavar="FILE", help="Write a page with pictures, figures and plots there.")
@click.option(
    "--out",
    type=_FILE,
    default=Path("out"),
    show_default=True,
    metavar="DIR",
    help="Folder that the designs are built into where they are not yet.",
)
@_NO_CACHE
@click.option("--jobs", type=click.IntRange(1, 64), default=None, metavar="N", help="Processes; all cores by default.")
def compare(
    designs: tuple[Path, ...],
    as_json: bool,
    markdown: bool,
    page: Path | None,
    out: Path,
    no_cache: bool,
    jobs: int | None,
) -> int:
    """Compare designs side by side, as built.

    Torque both ways, mass, box, backlash, stiffness, lowest mode, parts, tightest margin. Builds those that are not
    built yet; a design that fails a check is not compared.
    """
    if as_json and markdown:
        raise click.UsageError("--json and --markdown exclude each other; give one of them")
    from mbcdm_cad.cli.comparing import compare_command

    return compare_command(
        designs, out=out, as_json=as_json, markdown=markdown, page=page, use_cache=not no_cache, jobs=jobs
    )


@mbcdm.command(
    epilog=_examples(
        "mbcdm picture my_drive.yaml my_drive.png --view iso --angle 20",
        "mbcdm picture my_drive.yaml my_drive.gif --travel",
    )
)
@_DESIGN
@click.argument("png", metavar="PNG", type=_FILE)
@_ANGLE
@click.option("--travel", is_flag=True, help="A moving picture of the drum's swing, into a GIF file.")
@click.option(
    "--view", type=click.Choice(VIEW_NAMES), default="output", show_default=True, help="Where the camera stands."
)
@_NO_CACHE
def picture(design: Path, png: Path, angle_deg: float, travel: bool, view: str, no_cache: bool) -> int:
    """Draw a design into a PNG or GIF file; needs no display."""
    if travel:
        from mbcdm_cad.cli.building import moving_picture_command

        return moving_picture_command(design, png, view=view, use_cache=not no_cache)
    from mbcdm_cad.cli.building import picture_command

    return picture_command(design, png, angle_deg=angle_deg, view=view, use_cache=not no_cache)


@mbcdm.command(epilog=_examples("mbcdm page my_drive.yaml"))
@_DESIGN
@click.option("--force", is_flag=True, help="Make the page although a check fails; it then says so.")
@click.option(
    "--out",
    type=_FILE,
    default=Path("out"),
    show_default=True,
    metavar="DIR",
    help="Folder that the design's folder is written into.",
)
@_NO_CACHE
def page(design: Path, force: bool, out: Path, no_cache: bool) -> int:
    """Write a page with the drive in 3D and all figures.

    Builds the design and writes report.html: checks, figures, plots and lists in one file that needs no network.
    """
    from mbcdm_cad.cli.page import page_command

    return page_command(design, out=out, force=force, use_cache=not no_cache)


@mbcdm.command(epilog=_examples("mbcdm watch my_drive.yaml"))
@_DESIGN
@click.option("--port", type=click.IntRange(0, 65535), default=0, metavar="N", help="Any free port by default.")
@click.option(
    "--out",
    type=_FILE,
    default=Path("out"),
    show_default=True,
    metavar="DIR",
    help="Folder that the design's folders are written into.",
)
@_NO_CACHE
def watch(design: Path, port: int, out: Path, no_cache: bool) -> int:
    """Follow a design file: new checks and page at each save.

    Prints the address of a page that loads itself again. The parts drawn at once go into DIR/NAME-live, the whole build
    into DIR/NAME. Ctrl-C ends it.
    """
    from mbcdm_cad.cli.watch import watch_command

    return watch_command(design, out=out, port=port, use_cache=not no_cache)


@mbcdm.command(
    epilog=_examples("mbcdm export my_drive.yaml --format urdf", "mbcdm export my_drive.yaml --format mjcf --elastic")
)
@_DESIGN
@click.option("--format", "form", type=click.Choice(("urdf", "mjcf")), required=True, help="For which simulators.")
@click.option("--elastic", is_flag=True, help="Cables as springs instead of a rigid ratio (MJCF only).")
@click.option(
    "--out",
    type=_FILE,
    default=Path("out"),
    show_default=True,
    metavar="DIR",
    help="Folder that the description's folder, NAME-FORMAT, is written into.",
)
@_NO_CACHE
def export(design: Path, form: str, elastic: bool, out: Path, no_cache: bool) -> int:
    """Describe a design for robot simulators.

    Links with mass and inertia, joints with the drive's ratios, meshes in metres; see docs/robot-formats.md.
    """
    if elastic and form != "mjcf":
        raise click.UsageError("--elastic: URDF has no springs between joints; give --format mjcf")
    from mbcdm_cad.cli.robot import export_command

    return export_command(design, form=form, elastic=elastic, out=out, use_cache=not no_cache)


@mbcdm.command(epilog=_examples("mbcdm analyse my_drive.yaml", "mbcdm analyse my_drive.yaml --json > figures.json"))
@_DESIGN
@click.option("--json", "as_json", is_flag=True, help="Print the results as JSON.")
def analyse(design: Path, as_json: bool) -> int:
    """Tensions, backlash, load sharing and torque limits."""
    from mbcdm_cad.cli.studies import analyse_command

    return analyse_command(design, as_json=as_json)


@mbcdm.command(epilog=_examples("mbcdm sensitivity my_drive.yaml"))
@_DESIGN
@click.option(
    "--out",
    type=_FILE,
    default=Path("out"),
    show_default=True,
    metavar="DIR",
    help="Folder that the study's folder, NAME-sensitivity, is written into.",
)
def sensitivity(design: Path, out: Path) -> int:
    """What drives backlash and torque, as plots and CSV.

    The panels of the paper's figure 5, global indices, the tolerance stack over the travel, and 95 % intervals.
    """
    from mbcdm_cad.cli.studies import sensitivity_command

    return sensitivity_command(design, out=out)


@mbcdm.command(epilog=_examples("mbcdm reproduce", "mbcdm reproduce my_drive.yaml"))
@click.argument("design", type=_FILE, required=False)
def reproduce(design: Path | None) -> int:
    """The paper's figures beside the model's.

    For DESIGN, or the reference design. Exit 1 if a figure leaves its tolerance.
    """
    from mbcdm_cad.cli.studies import reproduce_command

    return reproduce_command(design)


@mbcdm.command(
    epilog=_examples(
        "mbcdm loop my_drive.yaml run1.yaml run2.yaml --report out/loop",
        "mbcdm loop my_drive.yaml run1.yaml --apply my_drive_as_built.yaml",
    )
)
@_DESIGN
@click.argument("measurements", type=_FILE, nargs=-1, required=True)
@click.option("--json", "json_path", type=_FILE, metavar="FILE", help="Write the result as JSON.")
@click.option(
    "--apply", "as_built", type=_FILE, metavar="AS_BUILT.yaml", help="Write the design file with what was found in it."
)
@click.option("--report", type=_FILE, metavar="FOLDER", help="Write a page with plots there.")
@click.option(
    "--correction",
    type=_FILE,
    metavar="FOLDER",
    help="Write a correction table for the controller there.",
)
@click.option(
    "--next",
    "next_path",
    type=_FILE,
    metavar="NEXT.yaml",
    help="Where the data cannot tell which of a set it is, write the experiment that tells best.",
)
def loop(
    design: Path,
    measurements: tuple[Path, ...],
    json_path: Path | None,
    as_built: Path | None,
    report: Path | None,
    correction: Path | None,
    next_path: Path | None,
) -> int:
    """Find in measured runs what the model lacks.

    Judges all runs together; each is described by a MEASUREMENTS file (YAML), which names the columns of its CSV file.
    """
    from mbcdm_cad.configurations.loader import load_design

    loaded = load_design(design)  # before the rest is imported, so that bad input is reported at once
    from mbcdm_cad.cli.loop import Outputs, loop_command

    return loop_command(loaded, measurements, Outputs(json_path, as_built, report, correction, next_path))


@mbcdm.command(
    epilog=_examples(
        "mbcdm plan my_drive.yaml params/experiments/null-long-levels.yaml",
        "mbcdm plan my_drive.yaml planned.yaml --noise-from pilot.yaml",
        "mbcdm plan my_drive.yaml --within bench.yaml --write planned.yaml",
    )
)
@_DESIGN
@click.argument("experiment", type=_FILE, required=False)
@click.option("--within", type=_FILE, metavar="BENCH.yaml", help="Look for the best run that this bench can make.")
@click.option("--noise-from", "pilot", type=_FILE, metavar="RUN.yaml", help="Take the noise of a measured run.")
@click.option("--write", "written", type=_FILE, metavar="FILE", help="Write the best run as an experiment file.")
@click.option("--json", "as_json", type=_FILE, metavar="FILE", help="Write the plan as JSON.")
def plan(
    design: Path,
    experiment: Path | None,
    within: Path | None,
    pilot: Path | None,
    written: Path | None,
    as_json: Path | None,
) -> int:
    """Say what a run could find, before it is made.

    For each effect the smallest size that would be named, and what it could be confused with below which size.
    """
    from mbcdm_cad.configurations.loader import load_design

    loaded = load_design(design)
    from mbcdm_cad.cli.plan import plan_command

    return plan_command(loaded.drive, experiment, within, pilot, written=written, as_json=as_json)


@mbcdm.command(epilog=_examples("mbcdm simulate my_drive.yaml params/experiments/winding-short-brake.yaml"))
@_DESIGN
@click.argument("experiment", type=_FILE)
@click.option(
    "--out",
    type=_FILE,
    default=Path("out"),
    show_default=True,
    metavar="DIR",
    help="Folder that the experiment's folder is written into.",
)
def simulate(design: Path, experiment: Path, out: Path) -> None:
    """Run an experiment on the test rig in software.

    Writes the measured run as 'mbcdm loop' reads it, and in a file of its own the truth that the loop must not see.
    """
    from mbcdm_cad.configurations.loader import load_design

    loaded = load_design(design)
    from mbcdm_cad.rig.reading import read_experiment

    wanted = read_experiment(experiment)
    from mbcdm_cad.paper.command import experiment_command

    click.echo(experiment_command(loaded.drive, wanted, out))


_CONFIGURATION = click.option(
    "--configuration", metavar="NAME", help="Layout of the drive; that of the reference design by default."
)


@mbcdm.command(epilog=_examples("mbcdm init my_drive.yaml", "mbcdm init my_drive.yaml --short"))
@click.argument("new", type=_FILE)
@_CONFIGURATION
@click.option("--short", is_flag=True, help="Only the requirements: all else follows from them by rules.")
@click.option("--derived", is_flag=True, help="The requirements, and every value that follows as a comment.")
def init(new: Path, configuration: str | None, short: bool, derived: bool) -> int:
    """Write a new design file with the reference values.

    Each value has its unit, meaning and source beside it. Never overwrites a file.
    """
    from mbcdm_cad.cli.files import init_command

    return init_command(new, configuration, "derived" if derived else "short" if short else "whole")


@mbcdm.command("measurement-init", epilog=_examples("mbcdm measurement-init run.csv my_drive.yaml"))
@click.argument("data", type=_FILE)
@_DESIGN
@click.option(
    "--out", type=_FILE, metavar="FILE", help="Measurement file; beside the data, with their name, by default."
)
def measurement_init(data: Path, design: Path, out: Path | None) -> int:
    """Draft the measurement file of a logger's CSV.

    Guesses which column is what from names, units, ranges and the ratio of the design, and marks what is guessed.
    """
    from mbcdm_cad.cli.files import measurement_init_command

    return measurement_init_command(data, design, out)


@mbcdm.command(epilog=_examples("mbcdm schema > design.schema.json", "mbcdm schema --reference --measurement | less"))
@click.option("--reference", is_flag=True, help="Print the reference page in Markdown instead.")
@click.option("--measurement", is_flag=True, help="Of measurement files, which 'mbcdm loop' reads.")
@_CONFIGURATION
def schema(reference: bool, measurement: bool, configuration: str | None) -> int:
    """Print the JSON Schema of design files.

    An editor completes and checks a design file with it.
    """
    from mbcdm_cad.cli.files import schema_command

    return schema_command(reference=reference, measurement=measurement, configuration=configuration)


@mbcdm.command(
    epilog=_examples("mbcdm catalogue", "mbcdm catalogue ropes", "mbcdm catalogue --markdown > docs/catalogue.md")
)
@click.argument("kind", type=click.Choice(CATALOGUE_KINDS), required=False)
@click.option("--markdown", is_flag=True, help="Print a page in Markdown, all kinds if none is given.")
def catalogue(kind: str | None, markdown: bool) -> int:
    """Ropes, motors, bearings and more that a design can name.

    Without KIND the names of all entries; with it the values of that kind's entries.
    """
    from mbcdm_cad.cli.catalogue import catalogue_command

    return catalogue_command(kind, markdown=markdown)


@mbcdm.command(epilog=_examples("mbcdm doctor"))
@click.option("--json", "as_json", is_flag=True, help="Print the findings as JSON.")
def doctor(as_json: bool) -> int:
    """What this machine has of what the program can use.

    Exit 1 if something is missing without which designs cannot be built.
    """
    from mbcdm_cad.cli.doctor import doctor_command

    return doctor_command(as_json=as_json)


@mbcdm.command(epilog=_examples("mbcdm pictures my_drive.yaml"))
@_DESIGN
@click.option(
    "--out",
    type=_FILE,
    default=Path("out"),
    show_default=True,
    metavar="DIR",
    help="Folder that the pictures' folder, NAME-pictures, is written into.",
)
@_NO_CACHE
def pictures(design: Path, out: Path, no_cache: bool) -> int:
    """Draw the pictures that a builder uses.

    One for each step of the order of assembly, an exploded view, a section through the transfer to the drum.
    """
    from mbcdm_cad.cli.building import pictures_command

    return pictures_command(design, out, use_cache=not no_cache)


@mbcdm.command(epilog=_examples("mbcdm prints my_drive.yaml"))
@_DESIGN
@click.option(
    "--out",
    type=_FILE,
    default=Path("out"),
    show_default=True,
    metavar="DIR",
    help="Folder that the folder of 3MF files, NAME-prints, is written into.",
)
@_NO_CACHE
def prints(design: Path, out: Path, no_cache: bool) -> int:
    """Write the made parts for a 3D printer.

    One 3MF file for each part, in millimetres, with its name, lying on its largest flat face.
    """
    from mbcdm_cad.cli.building import prints_command

    return prints_command(design, out, use_cache=not no_cache)


@mbcdm.command(
    epilog=_examples("mbcdm drawings my_drive.yaml", "mbcdm drawings my_drive.yaml --part input_pulley_left")
)
@_DESIGN
@click.option(
    "--out",
    type=_FILE,
    default=Path("out"),
    show_default=True,
    metavar="DIR",
    help="Folder that the drawings' folder, NAME-drawings, is written into.",
)
@click.option("--part", metavar="NAME", help="Only the sheet of this part.")
@click.option("--no-cache", is_flag=True, help="Neither read nor write the cache.")
@click.option("--jobs", type=click.IntRange(1, 64), default=None, metavar="N", help="Processes; all cores by default.")
def drawings(design: Path, out: Path, part: str | None, no_cache: bool, jobs: int | None) -> int:
    """Draw the workshop drawings of all made parts.

    One sheet for each part, as DXF with real dimensions, as PDF and as SVG.
    """
    from mbcdm_cad.cli.building import drawings_command

    return drawings_command(design, out, part=part, use_cache=not no_cache, jobs=jobs)
