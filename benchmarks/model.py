"""Speed of the analytic model on one core.

    python benchmarks/model.py [params/mbcdm.yaml] [--repeat N] [--json FILE]

Processor time of all threads, the smallest of N runs after a short one that compiles. Exit code 1 if a limit is
exceeded.
"""

import sys
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import mbcdm_cad as mc
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.loader import layout_of, load_design, load_text
from mbcdm_cad.model.analysis import analyse
from mbcdm_cad.model.bulk import analyse_many
from mbcdm_cad.model.capability import requirements
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.model.si import DriveSI

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "support"))
from clip_grid import simulate_on_grid
from timing import Figure, arguments, finish, least

SAMPLES = 1_000_000
SERIES_LIMIT_S = 3.0
DESIGNS = 100_000
DESIGNS_PER_S_LIMIT = 1e5
SINGLES = 40
SIZED = 10
GRID_SAMPLES = 5_000
GRID_CELL_RAD = 1e-3


def brake_series(drive: Drive, samples: int) -> tuple[Any, Any]:
    """Input angles of 32 cycles of +-50 mrad of the drum, and a brake of the test torque against the motion."""
    phase = np.linspace(0.0, 64.0 * np.pi, samples)
    angle = 0.05 * drive.cables[0].drum_radius_mm / drive.cables[0].input_radius_mm * np.sin(phase)
    return np.tile(angle, (len(drive.input_names), 1)), drive.loads.test_torque_Nm * np.where(
        np.cos(phase) >= 0.0, 1.0, -1.0
    )


def noisy_series(drive: Drive, samples: int) -> tuple[Any, Any]:
    """The same with sensor noise, so that nearly every sample is a turning point."""
    rng = np.random.default_rng(1)
    angle, load = brake_series(drive, samples)
    return angle + rng.normal(0.0, 1e-4, angle.shape), load + rng.normal(0.0, 0.02, samples)


def designs(d: DriveSI, n: int) -> DriveSI:
    """Random designs about ``d``."""
    rng = np.random.default_rng(0)
    size, each = rng.uniform(0.8, 1.5, n), (d.n_cables, n)
    lengths = {name: np.multiply.outer(value, size) for name, value in d.parameters.items()}
    lengths["input_radius_m"] *= rng.uniform(0.97, 1.03, each)
    if "centre_distance_m" in lengths:
        # Not less than it is: the pulleys of some layouts would meet.
        lengths["centre_distance_m"] *= rng.uniform(1.0, 1.3, n)
    return d.with_(
        **lengths,
        preload_N=rng.uniform(40, 120, each),
        friction_coefficient=rng.uniform(0.05, 0.4, n),
        modulus_Pa=rng.uniform(30e9, 90e9, n),
    )


def measured(design: Path, repeat: int) -> list[Figure]:
    """All figures."""
    drive = load_design(design).drive
    d, need = layout_of(drive).si, requirements(layout_of(drive))
    finite = d.with_(input_wrap_rad=np.full(d.n_cables, 16.0), drum_wrap_rad=np.full(d.n_cables, 3.0))
    found = []
    for label, series in (("sine under a brake", brake_series), ("the same with noise", noisy_series)):
        angle, load = series(drive, SAMPLES)
        for kind, model, winding, limit in (
            ("endless wraps", d, False, SERIES_LIMIT_S),
            ("finite wraps", finite, False, None),
            ("winding history", d, True, None),
        ):
            simulate(model, angle[:, :10], load[:10], winding=winding)
            taken = least(partial(simulate, model, angle, load, winding=winding), repeat)
            found.append(Figure(f"1e6 samples, {d.n_cables} cables, {label}: {kind}", taken, "s", limit))
    angle, load = brake_series(drive, GRID_SAMPLES)
    simulate_on_grid(d, angle[:, :10], load[:10], True, GRID_CELL_RAD)
    cells = least(lambda: simulate_on_grid(d, angle, load, True, GRID_CELL_RAD), 1)
    knots = least(lambda: simulate(d, angle, load, winding=True), repeat)
    found.append(Figure("winding history cell by cell (1 mrad) over in closed form", cells / knots, "times"))
    batch = designs(d, DESIGNS)
    analyse_many(designs(d, 1000), need)
    bulk = least(lambda: analyse_many(batch, need), repeat)
    found.append(Figure("analyse_many", DESIGNS / bulk, "designs/s", DESIGNS_PER_S_LIMIT, at_least=True))
    found.append(_sized_alone(drive.configuration, repeat))
    one = least(lambda: [analyse(layout_of(drive)) for _ in range(SINGLES)], repeat) / SINGLES
    found.append(Figure("analyse, one design", one * 1e3, "ms"))
    return found


def _usual(configuration: str, ratio_field: str, ratio: float) -> mc.DriveDesign:
    """A short file in usual proportions."""
    text = f"name: x\nconfiguration: {configuration}\ntravel: {{half_angle_deg: 30.0}}\n"
    text += f"transmission: {{{ratio_field}: {ratio}, drum_radius_mm: 80.0}}\nloads: {{peak_torque_Nm: 1.0}}\n"
    return mc.DriveDesign(load_text(text))


def _sized_alone(configuration: str, repeat: int) -> Figure:
    """Mean time of one whole design in usual proportions, of some drum radii."""
    key = "ratio" if configuration == "miso_bevel" else "input_to_drum"
    usual = _usual(configuration, key, 4.0 if configuration == "siso_bevel" else 8.0)
    radii = np.random.default_rng(2).uniform(55.0, 110.0, SIZED)
    alone = least(lambda: [usual.with_(transmission__drum_radius_mm=float(radius)) for radius in radii], repeat)
    return Figure("reading and sizing one whole design", alone / SIZED * 1e3, "ms")


def main() -> int:
    """Print the figures; 1 if a limit is exceeded."""
    options = arguments(__doc__, repeat=3).parse_args()
    figures = measured(options.design, options.repeat)
    for figure in figures:
        print(figure)
    return finish(figures, options.json)


if __name__ == "__main__":
    sys.exit(main())
