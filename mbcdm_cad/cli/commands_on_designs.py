"""Commands on the design file: write, check, explain and solve it; its schema and catalogue."""

from __future__ import annotations

from pathlib import Path

import click

from mbcdm_cad.cli.group import mbcdm
from mbcdm_cad.cli.options import DESIGN, FILE, examples

# Copy of mbcdm_cad.design.entries.KINDS, which takes long to import; a test compares them.
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
    from mbcdm_cad.cli.checking import check_command

    return check_command(designs, as_json=as_json, show="failed" if only_failed else "all" if show_all else "findings")


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
def explain(design: Path, field: str | None, as_json: bool, graph: Path | None) -> int:
    """Explain why a field has its value.

    Without FIELD: all fields that have a sizing rule. With FIELD: its rule, the values from which it follows, and the
    check or requirement that determines it.
    """
    if graph is not None and (field or as_json):
        raise click.UsageError("--graph draws all fields; leave out FIELD and --json")
    from mbcdm_cad.cli.explaining import explain_command

    return explain_command(design, field, as_json=as_json, graph=graph)


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
    from mbcdm_cad.cli.solving import solve_command

    return solve_command(design, apply=apply, as_json=as_json)


@mbcdm.command(epilog=examples("mbcdm init my_drive.yaml", "mbcdm init my_drive.yaml --full"))
@click.argument("new", type=FILE)
@_CONFIGURATION
@click.option("--full", is_flag=True, help="Add all derived values as comments.")
@click.option("--reference", is_flag=True, help="Write the reference design with all its values instead.")
def init(new: Path, configuration: str | None, full: bool, reference: bool) -> int:
    """Write a new design file with the requirements.

    Sizing rules compute all other values. For a layout without sizing rules: the reference design with all values.
    Comments state the unit and meaning of each value. Never overwrites a file.
    """
    from mbcdm_cad.cli.files import init_command

    return init_command(new, configuration, "reference" if reference else "full" if full else "short")


@mbcdm.command(epilog=examples("mbcdm schema > design.schema.json", "mbcdm schema --reference --measurement | less"))
@click.option("--reference", is_flag=True, help="Print the reference page in Markdown instead.")
@click.option("--measurement", is_flag=True, help="Schema of measurement files, which 'mbcdm loop' reads.")
@_CONFIGURATION
def schema(reference: bool, measurement: bool, configuration: str | None) -> int:
    """Print the JSON Schema of design files.

    With it an editor can complete and check a design file.
    """
    from mbcdm_cad.cli.files import schema_command

    return schema_command(reference=reference, measurement=measurement, configuration=configuration)


@mbcdm.command(
    epilog=examples("mbcdm catalogue", "mbcdm catalogue ropes", "mbcdm catalogue --markdown > docs/catalogue.md")
)
@click.argument("kind", type=click.Choice(CATALOGUE_KINDS), required=False)
@click.option("--markdown", is_flag=True, help="Print a page in Markdown, with all kinds if none is given.")
def catalogue(kind: str | None, markdown: bool) -> int:
    """List ropes, motors, bearings and other catalogue parts.

    Without KIND: the names of all entries. With KIND: the values of the entries of that kind.
    """
    from mbcdm_cad.cli.catalogue import catalogue_command

    return catalogue_command(kind, markdown=markdown)


@mbcdm.command(epilog=examples("mbcdm doctor"))
@click.option("--json", "as_json", is_flag=True, help="Print the findings as JSON.")
def doctor(as_json: bool) -> int:
    """Check which programs and libraries this machine has.

    Exit code 1 if something required is missing.
    """
    from mbcdm_cad.cli.doctor import doctor_command

    return doctor_command(as_json=as_json)
