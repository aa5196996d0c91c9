"""What the loop says of runs that others recorded on real drives, beside what is seen by hand: docs/real-drives.md.

    MBCDM_SHARED_DATA=... python -m benchmarks.studies.real_drives docs/real-drives.md

The data are not part of the project; without them the script says where it looked. Reading by hand was done before the
loop was written, on plots of the output over the input and of the load.
"""

import os
import shutil
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.studies.clustered import Estimate, cluster_estimate
from benchmarks.study import ROOT
from mbcdm_cad.loop.effects.friction import CONSTANT, LOAD, VISCOUS, bases
from mbcdm_cad.measurement.file import load_file
from mbcdm_cad.measurement.reading import read_run
from mbcdm_cad.measurement.run import Run, half_sweeps, smoothed

DATA = Path(os.environ.get("MBCDM_SHARED_DATA", ROOT.parent / "shared" / "data")) / "davinci"
MAPPINGS = ROOT / "params" / "measurements" / "davinci"
GEARBOX = (
    "lost motion of about 31 mrad where the torque changes sides; the side changes at 0.010 N m of the sensor instead "
    "of at zero (the sensor's zero, or friction that it does not see); friction that grows with the load"
)
CABLE = (
    "hysteresis of about 26 mrad half-width that does not depend on the speed (52 mrad from side to side); friction "
    "that grows with the load; no radii, preload or rope are known, so that a run can be explained and not predicted"
)
CASES = (
    *((f"run_{run}_gearbox",) for run in ("00", "05", "20")),
    tuple(f"run_{run}_gearbox" for run in ("00", "05", "20")),
    *((f"run_{run}_cable",) for run in ("00", "05", "20")),
    tuple(f"run_{run}_cable" for run in ("00", "05", "20")),
)
HEAD = """\
# Real drives: what the loop says, and what an expert says

Written by `MBCDM_SHARED_DATA=... python -m benchmarks.studies.real_drives docs/real-drives.md`; do not edit by hand.
Slow tests hold the main figures (`tests/unit/measurement/test_vet.py`). Runs of the loop on benches in software
are in [validation.md](validation.md).

## The runs
Three runs of a da Vinci tool on a test stand, 1 kHz for 20 s each, recorded by the Medical Robotics and Devices Lab of
the University of Minnesota: repository `MRDLab/mis-tool-characterization`, Open Database License (ODbL); cite O'Neill,
Stephens, Kowalewski, IEEE Robotics and Automation Letters 3(4), 2018. They are not shipped with this project. Download
`Tool_4_Maryland_L_4_00.TXT`, `..._05.TXT` and `..._20.TXT` from the repository into one folder with the measurement
files of `params/measurements/davinci`, and run `mbcdm loop params/mbcdm.yaml run_00_gearbox.yaml` (the design is not
used: only the ratio is known). Each run has two drives: the gearbox of the motor, and the cable with the tool. Nobody
gave radii, preload or rope.

The expert's reading was made by hand, from plots, before the loop was run.

"""


FRICTION = """\
## Friction of the cable, from the torques on both its sides
Torque was measured before the cable and behind it, so that its friction can be read without any angle: the difference
of the two, as a sum of a constant, a viscous part and one in proportion to the load (the forms of
[loop-method.md](loop-method.md)), beside a gain and a zero of each run; intervals are of 95 %. One run has one load,
and does not tell a constant from a share of the load. All three together do: the friction grows with the load, as the
expert says, and does not depend on the speed between 0.2 and 1 rad/s. The loop, which sees angles and the load behind
the cable, calls this friction a play taken up by motion: without a stiffness the two move the angle alike, and it says
nothing of the share of the load.
"""


def linked(name: str, folder: Path) -> Path:
    """The measurement file of a run, put beside its data."""
    path = folder / f"{name}.yaml"
    shutil.copy(MAPPINGS / path.name, path)
    data = str(load_file(path).content.data)
    if not (folder / data).exists():
        (folder / data).symlink_to((DATA / data).resolve())
    return path


TERMS = (CONSTANT, VISCOUS, LOAD)


def friction_of_cable(runs: Sequence[tuple[Run, Run]]) -> tuple[Estimate, float]:
    """Friction of the cable from the torques on both its sides, and what is left, N m RMS.

    ``runs``: of each file the gearbox, whose load drives the cable, and the cable, whose load is what it carries. No
    angle's error is in it, and nothing of the loop but the terms: c, v and k of ``TERMS`` beside a gain and a zero.
    """
    columns, torque, sweep, sector = [], [], [], []
    for number, (before, after) in enumerate(runs):
        assert before.load_Nm is not None and after.load_Nm is not None
        t, step = after.time_s, after.step_s
        output, load = smoothed(after.output_rad, 0.04, step), smoothed(after.load_Nm, 0.04, step)
        speed = smoothed(np.gradient(smoothed(after.input_rad[0], 0.04, step), t), 0.1, step)
        at = np.flatnonzero(np.abs(speed) > 0.1 * np.quantile(np.abs(speed), 0.99))[::10]
        friction = bases(TERMS, np.sign(speed[at]), speed[at], load[at], 1.0).T
        table = np.column_stack(
            [load[at], friction, np.interp(t, before.time_s, smoothed(before.load_Nm, 0.04, step))[at]]
        )
        table -= table.mean(axis=0)
        columns.append(table[:, :-1])
        torque.append(table[:, -1])
        sweep.append(half_sweeps(output)[at] + 100 * number)
        place = (output - output.min()) / np.ptp(output) * 8.0
        sector.append(np.minimum(place[at], 7.0).astype(int))
    x, y = np.concatenate(columns), np.concatenate(torque)
    found = cluster_estimate(x, y, np.concatenate(sweep), np.concatenate(sector))
    return found, float(np.std(y - x @ found.value))


def friction_text(folder: Path) -> str:
    """The section of the page on friction."""
    runs = {}
    for run in ("00", "05", "20"):
        files = (load_file(linked(f"run_{run}_{drive}", folder)) for drive in ("gearbox", "cable"))
        runs[run] = tuple(read_run(file).run for file in files)
    lines = [
        FRICTION,
        "| runs | constant, mN m | viscous, mN m s | share of the load | left, mN m RMS |",
        "|" + " --- |" * 5,
    ]
    for name, chosen in (*((run, [run]) for run in runs), ("all three", list(runs))):
        found, left = friction_of_cable([runs[run] for run in chosen])
        figures = zip(found.value[1:], found.half_width()[1:], (1e3, 1e3, 1e2), strict=True)
        cells = [f"{value * unit:.3g} +- {half * unit:.2g}" for value, half, unit in figures]
        lines.append(f"| {name} | {' | '.join(cells)} | {1e3 * left:.3g} |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Run the loop on every case and write the page."""
    if not DATA.is_dir():
        sys.exit(f"the real runs are not here ({DATA}); set MBCDM_SHARED_DATA to the folder that holds davinci/")
    import mbcdm_cad as mc

    design = mc.load(ROOT / "params" / "mbcdm.yaml")
    lines = [HEAD]
    with tempfile.TemporaryDirectory() as folder:
        lines.append(friction_text(Path(folder)))
        for case in CASES:
            report = mc.close_loop(design, [linked(name, Path(folder)) for name in case])
            drive = "gearbox" if "gearbox" in case[0] else "cable"
            errors = report.result.errors
            title = f"{case[0]}" if len(case) == 1 else f"all three runs of the {drive} together"
            lines.append(f"## {title}\n")
            lines.append("| who | what |\n| --- | --- |")
            lines.append(f"| expert | {GEARBOX if drive == 'gearbox' else CABLE} |")
            lines.append(f"| loop | {report.verdict}: {report.result.sentence} |")
            share = f"{errors.explained_share:.0%} of what lies above the noise"
            lines.append(f"| explained | {share}; left {1e3 * errors.after.value:.3g} mrad RMS |")
            lines += [f"| doubt | {words} |" for words in report.result.doubts]
            lines.append("")
            print(title, report.verdict, report.result.sentence, flush=True)
    if len(sys.argv) > 1:
        Path(sys.argv[1]).write_text("\n".join(lines).rstrip() + "\n", "utf-8")


if __name__ == "__main__":
    main()
