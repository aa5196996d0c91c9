"""Commands of the model, of the test rig and of the loop on measured runs."""

from __future__ import annotations

from pathlib import Path

import click

from mbcdm_cad.cli.group import mbcdm
from mbcdm_cad.cli.options import DESIGN, FILE, examples, out_folder


@mbcdm.command(epilog=examples("mbcdm analyse my_drive.yaml", "mbcdm analyse my_drive.yaml --json > figures.json"))
@DESIGN
@click.option("--json", "as_json", is_flag=True, help="Print the results as JSON.")
def analyse(design: Path, as_json: bool) -> int:
    """Compute tensions, backlash, load sharing, torque limits."""
    from mbcdm_cad.cli.studies import analyse_command

    return analyse_command(design, as_json=as_json)


@mbcdm.command(epilog=examples("mbcdm sensitivity my_drive.yaml"))
@DESIGN
@out_folder("Folder that the study's folder, NAME-sensitivity, is written into.")
def sensitivity(design: Path, out: Path) -> int:
    """Show which parameters change backlash and torque most.

    Writes plots and CSV: the panels of the paper's figure 5, global indices, the tolerance stack over the travel, and
    95 % intervals.
    """
    from mbcdm_cad.cli.studies import sensitivity_command

    return sensitivity_command(design, out=out)


@mbcdm.command(epilog=examples("mbcdm reproduce", "mbcdm reproduce my_drive.yaml"))
@click.argument("design", type=FILE, required=False)
def reproduce(design: Path | None) -> int:
    """Compare the paper's figures with the model's.

    For DESIGN, or for the reference design. Exit code 1 if a figure is outside its tolerance.
    """
    from mbcdm_cad.cli.studies import reproduce_command

    return reproduce_command(design)


@mbcdm.command(
    epilog=examples(
        "mbcdm loop my_drive.yaml run1.yaml run2.yaml --report out/loop",
        "mbcdm loop my_drive.yaml run1.yaml --apply my_drive_as_built.yaml",
    )
)
@DESIGN
@click.argument("measurements", type=FILE, nargs=-1, required=True)
@click.option("--json", "json_path", type=FILE, metavar="FILE", help="Write the result as JSON.")
@click.option(
    "--apply",
    "as_built",
    type=FILE,
    metavar="AS_BUILT.yaml",
    help="Write the design file with the effects that were found.",
)
@click.option("--report", type=FILE, metavar="FOLDER", help="Write a page with plots to this folder.")
@click.option(
    "--correction",
    type=FILE,
    metavar="FOLDER",
    help="Write a correction table for the controller to this folder.",
)
@click.option(
    "--next",
    "next_path",
    type=FILE,
    metavar="NEXT.yaml",
    help="If several effects are possible, write the experiment that separates them best.",
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
    """Find effects that the model lacks, from measured runs.

    Each MEASUREMENTS file (YAML) describes one run and names the columns of its CSV file. All runs are used together.
    """
    from mbcdm_cad.layouts.loader import load_design

    loaded = load_design(design)  # before the other imports, so that bad input is reported at once
    from mbcdm_cad.cli.loop import Outputs, loop_command

    return loop_command(loaded, measurements, Outputs(json_path, as_built, report, correction, next_path))


@mbcdm.command(
    epilog=examples(
        "mbcdm plan my_drive.yaml params/experiments/null-long-levels.yaml",
        "mbcdm plan my_drive.yaml planned.yaml --noise-from pilot.yaml",
        "mbcdm plan my_drive.yaml --within bench.yaml --write planned.yaml",
    )
)
@DESIGN
@click.argument("experiment", type=FILE, required=False)
@click.option("--within", type=FILE, metavar="BENCH.yaml", help="Find the best run that this bench can make.")
@click.option("--noise-from", "pilot", type=FILE, metavar="RUN.yaml", help="Take the noise of a measured run.")
@click.option("--write", "written", type=FILE, metavar="FILE", help="Write the best run as an experiment file.")
@click.option("--json", "as_json", type=FILE, metavar="FILE", help="Write the plan as JSON.")
def plan(
    design: Path,
    experiment: Path | None,
    within: Path | None,
    pilot: Path | None,
    written: Path | None,
    as_json: Path | None,
) -> int:
    """Compute what a run could find, before it is made.

    For each effect: the smallest size that the loop would name, and each effect with which it could be confused, with
    the size up to which this happens.
    """
    from mbcdm_cad.layouts.loader import load_design

    loaded = load_design(design)
    from mbcdm_cad.cli.plan import plan_command

    return plan_command(loaded.drive, experiment, within, pilot, written=written, as_json=as_json)


@mbcdm.command(epilog=examples("mbcdm simulate my_drive.yaml params/experiments/winding-short-brake.yaml"))
@DESIGN
@click.argument("experiment", type=FILE)
@out_folder("Folder that the experiment's folder is written into.")
def simulate(design: Path, experiment: Path, out: Path) -> None:
    """Run an experiment on the test rig in software.

    Writes the measured run for 'mbcdm loop', and in a separate file the truth, which the loop does not read.
    """
    from mbcdm_cad.layouts.loader import load_design

    loaded = load_design(design)
    from mbcdm_cad.rig.reading import read_experiment

    wanted = read_experiment(experiment)
    from mbcdm_cad.paper.command import experiment_command

    click.echo(experiment_command(loaded.drive, wanted, out))


@mbcdm.command("measurement-init", epilog=examples("mbcdm measurement-init run.csv my_drive.yaml"))
@click.argument("data", type=FILE)
@DESIGN
@click.option(
    "--out",
    type=FILE,
    metavar="FILE",
    help="Measurement file; by default with the name of the data.",
)
def measurement_init(data: Path, design: Path, out: Path | None) -> int:
    """Draft the measurement file of a logger's CSV.

    Guesses the content of each column from names, units, ranges and the ratio of the design, and marks each guess.
    """
    from mbcdm_cad.cli.files import measurement_init_command

    return measurement_init_command(data, design, out)
