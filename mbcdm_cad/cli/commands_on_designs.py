"""Commands on the design file: write, check, explain and solve it; its schema and catalogue.

Each calls a function of :mod:`mbcdm_cad.api` and prints its result.
"""

import json
import os
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

import click

from mbcdm_cad import api
from mbcdm_cad.cli.group import (
    DESIGN,
    FILE,
    SCHEDULER,
    TIME,
    WORKERS,
    coloured,
    examples,
    load,
    mbcdm,
    out_folder,
    print_json,
    print_report,
    progress,
    progress_of_trials,
    screen_width,
    sign_of_life,
)
from mbcdm_cad.design.template import slug
from mbcdm_cad.errors import InputError, MbcdmError, Problem
from mbcdm_cad.optimising import GROWTH
from mbcdm_cad.report.table import designs_shown
from mbcdm_cad.storage.folders import refuse_missing_folder, write_whole

# By the catalogue's files: mbcdm_cad.design.catalogue.KINDS takes long to import.
CATALOGUE_KINDS = sorted(path.stem for path in (Path(__file__).parents[1] / "design/catalogue").glob("*.json"))

# Exit code of a command that the keyboard interrupted, as shells have it.
INTERRUPTED = 130

_CONFIGURATION = click.option(
    "--configuration", metavar="NAME", help="Layout of the drive; by default that of the reference design."
)


@mbcdm.command(
    epilog=examples("mbcdm check my_drive.yaml", "mbcdm check --failed *.yaml", "mbcdm check my_drive.yaml --json")
)
@click.argument("designs", metavar="DESIGN...", type=FILE, nargs=-1, required=True)
@click.option("--failed", "only_failed", is_flag=True, help="Show only the checks that fail, without warnings.")
@click.option("--all", "show_all", is_flag=True, help="Show the checks that pass too.")
@click.option("--json", "as_json", is_flag=True, help="Print all results as JSON; a list for several designs.")
def check(designs: tuple[Path, ...], only_failed: bool, show_all: bool, as_json: bool) -> int:
    """Check designs without drawing them.

    Prints warnings, failures with a change that would make them pass, and a summary. Exit code 1 if a check fails.
    """
    if only_failed and show_all:
        raise click.UsageError("--failed and --all exclude each other; give one of them")
    show: Literal["failed", "all", "findings"] = "failed" if only_failed else "all" if show_all else "findings"
    reports, unread = [], []
    for path in designs:
        try:
            with sign_of_life(f"{path}: sizing and checking"):
                loaded = api.load(path)
                reports.append((path, loaded.check()))
        except MbcdmError as error:
            unread.append(str(path))
            click.echo(str(error), err=True)
            continue
        if not as_json:
            text = reports[-1][1].text(width=screen_width(), colour=coloured(), show=show)
            click.echo(("\n" if len(reports) > 1 else "") + text, color=coloured())
            _hint(loaded)
    failing = [str(path) for path, report in reports if not report.passed]
    if as_json:
        found = [report.to_dict() for _, report in reports]
        if found:
            print_json(found[0] if len(designs) == 1 else found)
    elif len(designs) > 1:
        click.echo("\n" + _summary(len(designs), failing, unread))
    return 2 if unread else int(bool(failing))


def _hint(design: api.DriveDesign) -> None:
    """Print a hint on stderr for a file that states every value; only on a terminal."""
    if not sys.stderr.isatty():
        return
    from mbcdm_cad.layouts.loader import design_file

    if not design.loaded.sized and design_file(design.drive.configuration).sizing:
        hint = "states every value; sizing rules compute the fields that a file leaves out"
        click.echo(f"{design.loaded.path}: {hint} (mbcdm explain)", err=True)


def _summary(count: int, failing: Sequence[str], unread: Sequence[str]) -> str:
    """One line about all designs: their number, and those that fail."""
    words = [f"{len(failing)} fail: {', '.join(failing)}"] if failing else []
    words += [f"{len(unread)} cannot be read: {', '.join(unread)}"] if unread else []
    return f"{designs_shown(count)}: " + ("; ".join(words) or "all pass")


@mbcdm.command(
    epilog=examples(
        "mbcdm explain my_drive.yaml",
        "mbcdm explain my_drive.yaml drum.outer_face_y_mm",
        "mbcdm explain my_drive.yaml --graph why.svg",
    )
)
@DESIGN
@click.argument("field", required=False)
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
@click.option("--graph", type=FILE, metavar="FILE.svg", help="Draw the dependencies of all values into this file.")
def explain(design: Path, field: str | None, as_json: bool, graph: Path | None) -> None:
    """Explain why a field has its value.

    Without FIELD: all fields that have a sizing rule. With FIELD: its rule, the values from which it follows, and the
    check or requirement that determines it.
    """
    if graph is not None and (field or as_json):
        raise click.UsageError("--graph draws all fields; leave out FIELD and --json")
    loaded = load(design)
    if graph is not None:
        click.echo(loaded.explain_graph(graph))
    else:
        print_report(loaded.explain(field), as_json)


@mbcdm.command(epilog=examples("mbcdm solve my_drive.yaml", "mbcdm solve my_drive.yaml --apply my_drive_solved.yaml"))
@DESIGN
@click.option(
    "--apply", type=FILE, metavar="FILE", help="Write the design that passes to this file, with all comments."
)
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
def solve(design: Path, apply: Path | None, as_json: bool) -> int:
    """Find the nearest design that passes every check.

    Changes only fields that the file leaves out or gives as a range, {min: 30, max: 60} or min; prints the change as a
    patch. If there is no such design: which requirements exclude each other, and how far each must change. Exit code 1
    then.
    """
    if apply is not None:
        # Raise ``InputError`` if the result would replace a file other than the design itself.
        refuse_missing_folder(apply)
        if apply.exists() and apply.resolve() != design.resolve():
            problem = Problem(str(apply), 1, "", "exists already", remedy="choose another name, or remove it first")
            raise InputError([problem])
    with progress_of_trials() as told:
        found = api.solve(design, progress=told)
    if as_json:
        print_json(found.to_dict())
    else:
        click.echo(found.text(colour=coloured()))
    if apply is not None and found.passed:
        found.save(apply)
        click.echo(f"{apply} written", err=as_json)
    return int(not found.passed)


@mbcdm.command(
    epilog=examples(
        "mbcdm optimise my_drive.yaml --aim mass_g:min --aim swing_mrad:min",
        "mbcdm optimise a.yaml b.yaml --aim mass_g:min --time 60s",
    )
)
@click.argument("requirements", metavar="REQUIREMENTS...", type=FILE, nargs=-1, required=True)
@click.option("--aim", "aims", multiple=True, metavar="FIGURE:min|max", help="A figure to improve; one to four.")
@click.option("--keep", "keeps", multiple=True, metavar="FIGURE:>=VALUE", help="A limit (>= or <=) of a figure.")
@click.option(
    "--free",
    multiple=True,
    metavar="FIELD=VALUES",
    help="One more field to choose, of A,B,... or LOW..HIGH; without it those that solve may change.",
)
@click.option("--only-free", is_flag=True, help="Choose only fields of --free and ranges of the file.")
@click.option(
    "--over",
    type=click.Choice(["tolerances"]),
    default=None,
    help="Take of each figure the value that 95 % of the drives reach, as made.",
)
@click.option("--beside", multiple=True, type=FILE, metavar="DESIGN", help="Mark this design beside the front.")
@TIME
@click.option("--evaluations", type=int, metavar="N", default=None, help="Stop after this number of designs.")
@click.option(
    "--growth",
    type=float,
    metavar="SHARE",
    default=GROWTH,
    show_default=True,
    help="Stop when the front's hypervolume grew by less in 12 generations; 0 does not.",
)
@WORKERS
@SCHEDULER
@click.option("--resume", is_flag=True, help="Go on with a search that was stopped.")
@out_folder("Folder for NAME-optimum and the evaluated points.")
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
def optimise(requirements: Sequence[Path], out: Path, as_json: bool, **asked: Any) -> int:
    """Find the best designs that pass every check.

    Figures are those of check and analyse, such as mass_g, swing_mrad or torque_to_weight_Nm_kg; free are all fields
    that solve may change, and ranges such as {min: 30, max: 60}. Several files, one a layout, compete. Writes each
    design of the front as a short file. The search can be stopped at any moment and goes on with --resume. Exit code 1
    if no design passes.
    """
    effort = api.Effort(
        *(asked[name] for name in ("evaluations", "time_s", "workers", "resume", "scheduler", "growth"))
    )
    wishes = {name: asked[name] for name in ("keeps", "free", "only_free", "over", "beside")}
    with progress_of_trials(100, stages=False) as told:
        found = api.optimise(requirements, asked["aims"], out, **wishes, effort=effort, progress=told)
    print_report(found, as_json)
    if not found.finished and not as_json:
        click.echo("it goes on with --resume", err=True)
    return INTERRUPTED if found.interrupted else int(not found.points)


@mbcdm.command(epilog=examples("mbcdm prices my_drive.yaml --figure mass_g --figure swing_mrad"))
@DESIGN
@click.option("--figure", "figures", multiple=True, required=True, metavar="NAME", help="A figure, as for optimise.")
@WORKERS
@SCHEDULER
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
def prices(design: Path, figures: Sequence[str], workers: int | None, scheduler: str | None, as_json: bool) -> None:
    """Show what each requirement costs.

    Each number of the file is moved by 5 % both ways, and the design is solved again: a table with the change of each
    figure for one unit of the requirement.
    """
    with progress() as told:
        found = api.prices(design, figures, workers=workers, scheduler=scheduler, progress=told)
    print_report(found, as_json)


@mbcdm.command(epilog=examples("mbcdm init my_drive.yaml", "mbcdm init my_drive.yaml --full"))
@click.argument("new", type=FILE)
@_CONFIGURATION
@click.option("--full", is_flag=True, help="Add all derived values as comments.")
@click.option("--reference", is_flag=True, help="Write the reference design with all its values instead.")
def init(new: Path, configuration: str | None, full: bool, reference: bool) -> None:
    """Write a new design file with the requirements.

    Sizing rules compute all other values. For a layout without sizing rules: the reference design with all values.
    Comments state the unit and meaning of each value. Never overwrites a file.
    """
    refuse_missing_folder(new)
    text = api.new_design_text(new.stem, configuration, form="reference" if reference else "full" if full else "short")
    write_new(new, text, "choose another name, or remove it first")
    click.echo(f"{new}: design {slug(new.stem)} written; check it with: mbcdm check {shlex.quote(str(new))}")


def write_new(path: Path, text: str, remedy: str) -> None:
    """Write a new file. Raises ``InputError`` with the remedy if it exists, or if it cannot be written."""
    if os.path.lexists(path):
        raise InputError([Problem(str(path), 1, "", "exists already", remedy=remedy)])
    try:
        write_whole({path: text.encode()})
    except ValueError as error:
        raise InputError([Problem(str(path), 1, "", f"cannot be written: {error}", remedy="check the path")]) from None


@mbcdm.command(epilog=examples("mbcdm schema > design.schema.json", "mbcdm schema --reference --measurement | less"))
@click.option("--reference", is_flag=True, help="Print the reference page in Markdown instead.")
@click.option("--measurement", is_flag=True, help="Schema of measurement files, which 'mbcdm loop' reads.")
@_CONFIGURATION
def schema(reference: bool, measurement: bool, configuration: str | None) -> None:
    """Print the JSON Schema of design files.

    With it an editor can complete and check a design file.
    """
    if reference:
        click.echo(api.schema_page(configuration, measurement=measurement), nl=False)
    else:
        click.echo(json.dumps(api.schema(configuration, measurement=measurement), indent=2, ensure_ascii=False))


@mbcdm.command(
    epilog=examples("mbcdm catalogue", "mbcdm catalogue ropes", "mbcdm catalogue --markdown > docs/catalogue.md")
)
@click.argument("kind", type=click.Choice(CATALOGUE_KINDS), required=False)
@click.option("--markdown", is_flag=True, help="Print a page in Markdown, with all kinds if none is given.")
def catalogue(kind: str | None, markdown: bool) -> None:
    """List ropes, motors, bearings and other catalogue parts.

    Without KIND: the names of all entries. With KIND: the values of the entries of that kind.
    """
    found = api.catalogue(kind)
    click.echo(found.markdown() if markdown else found.text(screen_width()), nl=not markdown)


@mbcdm.command(epilog=examples("mbcdm doctor", "mbcdm doctor --cache"))
@click.option("--json", "as_json", is_flag=True, help="Print the findings as JSON.")
@click.option("--cache", is_flag=True, help="Read every entry of the cache; remove broken ones.")
def doctor(as_json: bool, cache: bool) -> int:
    """Check which programs and libraries this machine has.

    Exit code 1 if something required is missing.
    """
    machine = api.doctor(cache=cache)
    print_report(machine, as_json)
    return int(not machine.passed)
