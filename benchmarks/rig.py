"""Speed of the rig in software on one core, as the ratio of computing time to simulated time.

    python benchmarks/rig.py [params/mbcdm.yaml] [--repeat N] [--json FILE]

Processor time of all threads, the smallest of N runs after a short one that compiles. Exit code 1 if a limit is
exceeded.
"""

import sys

from timing import Figure, arguments, finish, least

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.rig.dynamic.run import run_dynamic
from mbcdm_cad.rig.dynamic.train import LOOP_RATE_HZ, rig_of, sine
from mbcdm_cad.rig.experiment import Experiment
from mbcdm_cad.rig.motion import Load, Motion
from mbcdm_cad.rig.quasistatic import simulate

SIMULATED_S = 160.0
QUASI_STATIC_LIMIT_S = 10.0
DYNAMIC_RATIO_LIMIT = 1.0


def quasi_static(drive: Drive, repeat: int) -> list[Figure]:
    """160 s at 100 Hz of a braked triangle, short and long travel."""
    figures = []
    for amplitude in (50.0, 450.0):
        experiment = Experiment(
            name="speed",
            duration_s=SIMULATED_S,
            motion=Motion(amplitude_mrad=amplitude, period_s=20.0),
            load=Load(kind="brake", levels_Nm=(0.91,)),
        )
        simulate(drive, experiment.model_copy(update={"duration_s": 1.0}))
        taken = least(lambda experiment=experiment: simulate(drive, experiment), repeat)
        figures += [
            Figure(
                f"quasi-static rig, {SIMULATED_S:g} s at 100 Hz, +-{amplitude:g} mrad", taken, "s", QUASI_STATIC_LIMIT_S
            ),
            Figure("  per simulated second, over real time", taken / SIMULATED_S, ""),
        ]
    return figures


def dynamic(drive: Drive, repeat: int) -> list[Figure]:
    """160 s of a braked sine at the usual step."""
    rig = rig_of(drive)
    run_dynamic(rig, sine(0.05, 1.0, 0.1, LOOP_RATE_HZ), brake_Nm=0.91)
    figures = []
    for amplitude, word in ((0.05, "+-50 mrad"), (0.45, "+-450 mrad")):
        reference = sine(amplitude, 0.1, 0.1 * SIMULATED_S, LOOP_RATE_HZ)
        taken = least(lambda reference=reference: run_dynamic(rig, reference, brake_Nm=0.91), repeat)
        figures += [
            Figure(f"dynamic rig, {SIMULATED_S:g} s, {word}, brake 0.91 N m", taken, "s"),
            Figure("  per simulated second, over real time", taken / SIMULATED_S, "", DYNAMIC_RATIO_LIMIT),
        ]
    return figures


def main() -> int:
    """Measure, print, and tell whether all limits hold."""
    options = arguments(__doc__, repeat=2).parse_args()
    drive = load_design(options.design).drive
    figures = quasi_static(drive, options.repeat) + dynamic(drive, options.repeat)
    for figure in figures:
        print(figure)
    return finish(figures, options.json)


if __name__ == "__main__":
    sys.exit(main())
