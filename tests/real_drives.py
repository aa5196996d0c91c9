"""What the loop says of runs that others recorded on real drives, beside what is seen by hand: docs/real-drives.md.

    MBCDM_SHARED_DATA=... python tests/real_drives.py docs/real-drives.md

The data are not part of the project; without them the script says where it looked. Reading by hand was done before the
loop was written, on plots of the output over the input and of the load.
"""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
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

Written by `MBCDM_SHARED_DATA=... python tests/real_drives.py docs/real-drives.md`; do not edit by hand. Slow tests hold
the main figures (`tests/unit/measurement/test_real_runs.py`). Runs of the loop on benches in software are in
[loop-benches.md](loop-benches.md).

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


def linked(name: str, folder: Path) -> Path:
    """The measurement file of a run, put beside its data."""
    from mbcdm_cad.measurement.file import load_file

    path = folder / f"{name}.yaml"
    shutil.copy(MAPPINGS / path.name, path)
    data = str(load_file(path).content.data)
    if not (folder / data).exists():
        (folder / data).symlink_to((DATA / data).resolve())
    return path


def main() -> None:
    """Run the loop on every case and write the page."""
    if not DATA.is_dir():
        sys.exit(f"the real runs are not here ({DATA}); set MBCDM_SHARED_DATA to the folder that holds davinci/")
    import mbcdm_cad as mc

    design = mc.load(ROOT / "params" / "mbcdm.yaml")
    lines = [HEAD]
    with tempfile.TemporaryDirectory() as folder:
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
