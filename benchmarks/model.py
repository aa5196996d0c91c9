"""Speed of the analytic model on one core.

    python benchmarks/model.py [params/mbcdm.yaml] [--repeat N] [--json FILE]

Processor time of all threads, the smallest of N runs after a short one that compiles. Exit code 1 if a limit is
exceeded. ``size_many`` sizes the designs of miso_bevel on columns, those of the other layouts one by one.
"""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from timing import Figure, arguments, finish, least

import mbcdm_cad as mc
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.loader import load_design, load_text
from mbcdm_cad.model.analysis import analyse
from mbcdm_cad.model.bulk import analyse_many
from mbcdm_cad.model.capability import requirements
from mbcdm_cad.model.hysteresis import simulate
from mbcdm_cad.model.si import DriveSI, to_si
from tests.support.clip_grid import simulate_on_grid

SAMPLES = 1_000_000
SERIES_LIMIT_S = 3.0
DESIGNS = 100_000
DESIGNS_PER_S_LIMIT = 1e5
SINGLES = 40
SIZED = 10_000
SIZED_PER_S_LIMIT = 1e4
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
    d, need = to_si(drive), requirements(drive)
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
    found += _sized(design, repeat) if drive.configuration == "miso_bevel" else _sized_one_by_one(drive, repeat)
    one = least(lambda: [analyse(drive) for _ in range(SINGLES)], repeat) / SINGLES
    found.append(Figure("analyse, one design", one * 1e3, "ms"))
    return found


def _sized(design: Path, repeat: int) -> list[Figure]:
    """Designs a second from requirements: about one design, and over random ones in usual proportions; one by one."""
    short = mc.load(design.with_name("mbcdm-short.yaml"))
    usual, rng = _usual("miso_bevel", "ratio", 8.0), np.random.default_rng(2)
    near = {
        "transmission.centre_distance_mm": rng.uniform(34.0, 40.0, SIZED),
        "loads.test_torque_Nm": rng.uniform(0.2, 0.9, SIZED),
    }
    wide = {
        "transmission.ratio": rng.uniform(4.0, 12.0, SIZED),
        "transmission.drum_radius_mm": rng.uniform(55.0, 110.0, SIZED),
        "travel.half_angle_deg": rng.uniform(12.0, 40.0, SIZED),
        "loads.peak_torque_Nm": np.exp(rng.uniform(np.log(0.4), np.log(4.0), SIZED)),
    }
    found = []
    for label, of, ranges in (("about one design", short, near), ("of random requirements", usual, wide)):
        taken = least(partial(mc.size_many, of, ranges), repeat)
        limit = SIZED_PER_S_LIMIT if of is short else None
        found.append(Figure(f"size_many, 1e4 {label}", SIZED / taken, "designs/s", limit, at_least=True))
    return [*found, _sized_alone(usual, wide["transmission.drum_radius_mm"][:SINGLES], repeat)]


def _sized_one_by_one(drive: Drive, repeat: int) -> list[Figure]:
    """Designs a second from requirements in usual proportions, and the time of one."""
    ratio = 4.0 if drive.configuration == "siso_bevel" else 8.0  # the travel of siso_bevel is less than a turn
    usual, rng = _usual(drive.configuration, "input_to_drum", ratio), np.random.default_rng(2)
    wide = {
        "transmission.input_to_drum": rng.uniform(0.6, 1.0, SINGLES) * ratio,
        "transmission.drum_radius_mm": rng.uniform(55.0, 110.0, SINGLES),
        "loads.peak_torque_Nm": np.exp(rng.uniform(np.log(0.4), np.log(1.0), SINGLES)),
    }
    taken = least(partial(mc.size_many, usual, wide), repeat)
    many = Figure(f"size_many, {SINGLES} of random requirements, one by one", SINGLES / taken, "designs/s")
    return [many, _sized_alone(usual, wide["transmission.drum_radius_mm"], repeat)]


def _usual(configuration: str, ratio_field: str, ratio: float) -> mc.DriveDesign:
    """A short file in usual proportions."""
    text = f"name: x\nconfiguration: {configuration}\ntravel: {{half_angle_deg: 30.0}}\n"
    text += f"transmission: {{{ratio_field}: {ratio}, drum_radius_mm: 80.0}}\nloads: {{peak_torque_Nm: 1.0}}\n"
    return mc.DriveDesign(load_text(text))


def _sized_alone(usual: mc.DriveDesign, radii: Any, repeat: int) -> Figure:
    """Mean time of one whole design of some drum radii."""
    alone = least(lambda: [usual.with_(transmission__drum_radius_mm=float(radius)) for radius in radii], repeat)
    return Figure("reading and sizing one whole design", alone / len(radii) * 1e3, "ms")


def main() -> int:
    """Print the figures; 1 if a limit is exceeded."""
    options = arguments(__doc__, repeat=3).parse_args()
    figures = measured(options.design, options.repeat)
    for figure in figures:
        print(figure)
    return finish(figures, options.json)


if __name__ == "__main__":
    sys.exit(main())
