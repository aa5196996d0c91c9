"""How often the loop finds a low preload and a bearing's friction with motor currents in place of a torque sensor.

    python -m benchmarks.studies.motor_currents --rows out/currents.jsonl --runs 20 --first-seed 100

Runs of the dynamic rig: a weight's torque and inertia at the drum, a sine of the drum, currents logged with noise, no
torque sensor. The torque constant is wrong by 2 % (one standard deviation, as drawn), the preload is 20 % low, and each
input has 0.01 N m of friction behind its gearhead. The physics is that of the declared model otherwise. The measurement
file states the weight on its arm, wrong by 0.5 % (one standard deviation, as drawn); with ``--unstated`` it does not.
"""

import time
from dataclasses import replace

import numpy as np

from benchmarks.study import ROOT, Row, Study, parser
from mbcdm_cad.design.blocks import STANDARD_GRAVITY_M_S2
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.measurement.loads import pendulum_load_Nm
from mbcdm_cad.measurement.run import KNOWN_LOAD, Run, Sensors, TorqueClass
from mbcdm_cad.measurement.schema import MotorBlock, Pendulum
from mbcdm_cad.rig.dynamic.simulate import simulate_dynamic
from mbcdm_cad.rig.experiment import DynamicExperiment
from tests.support.bench_score import interval

# A low preload and more friction in the cables are nearly alike: either, or both as a set, is right.
WANTED = ({"preload_error", "cable_friction"}, {"friction"})
CONSTANT_NM_A, SIGMA_SHARE, CURRENT_NOISE_A = 0.0065, 0.02, 2e-3
# The weight that `mbcdm plan --within` proposes; near the axis, since with more inertia the position loops oscillate.
ARM = Pendulum(mass_kg=5.63, arm_mm=30.0, inertia_kg_m2=0.0003)
WEIGHT_SIGMA = 0.005


def measured(
    drive: Drive,
    seed: int,
    effects: bool = True,
    frequency_Hz: float = 0.16,
    amplitude_mrad: float = 436.3,
    duration_s: float = 100.0,
    stated: bool = True,
) -> Run:
    """One run as its logger has it; the same seed without ``effects`` is its twin."""
    rng = np.random.default_rng([seed, 35])
    lever = 1e-3 * ARM.arm_mm
    load = {
        "unbalance_Nm": ARM.mass_kg * STANDARD_GRAVITY_M_S2 * lever,
        "inertia_kg_m2": ARM.inertia_kg_m2 + ARM.mass_kg * lever**2,
        "torque_Nm": float(rng.uniform(-0.3, 0.3)),
    }
    experiment = DynamicExperiment.model_validate(
        {
            "rig": "dynamic",
            "name": f"current-{seed}",
            "seed": seed,
            "duration_s": duration_s,
            "sample_rate_Hz": 100 if frequency_Hz < 1.0 else 500,
            "motion": {"amplitude_mrad": amplitude_mrad, "frequency_Hz": frequency_Hz},
            "physics": {"cable_transport": False},
            "load": load,
            "bearings": {"input_Nm": 0.01 if effects else 0.0},
            "effects": [{"effect": "preload", "share": -0.2}] if effects else [],
        }
    )
    run, _, rig = simulate_dynamic(drive, experiment)
    true = CONSTANT_NM_A * (1.0 + SIGMA_SHARE * rng.normal())
    current = run.motor_Nm / (rig.gearheads[0].ratio * true)
    current = current + CURRENT_NOISE_A * rng.normal(size=current.shape)
    motor = MotorBlock(
        torque_constant_Nm_A=CONSTANT_NM_A, torque_constant_share=SIGMA_SHARE, friction_Nm=rig.motors[0].coulomb_Nm
    )
    sensors = Sensors(1.9175e-4, 1.3635e-6, torque_class=TorqueClass.of_motors(SIGMA_SHARE))
    logged = Run(run.time_s, run.measured_input_rad, run.measured_drum_rad, sensors=sensors, source="run.csv")
    logged = replace(logged, input_names=drive.input_names, current_A=current, motor=motor)
    if not stated:
        return logged
    scale = 1.0 + WEIGHT_SIGMA * rng.normal()
    known = scale * pendulum_load_Nm(ARM, logged.output_rad, logged.time_s)
    sensors = replace(sensors, torque_class=TorqueClass(2.0 * WEIGHT_SIGMA, 0.0, what=KNOWN_LOAD))
    return replace(logged, load_Nm=known, sensors=sensors)


def judged(asked: tuple[int, bool, bool]) -> Row:
    """What the loop says of one run (seed, with effects, weight stated), as a row of the study's file."""
    from mbcdm_cad.loop.search.engine import close_loop

    (seed, effects, stated), drive = asked, load_design(ROOT / "params" / "mbcdm.yaml").drive
    run = measured(drive, seed, effects, stated=stated)
    begun = time.process_time()
    result = close_loop(drive, [run])
    sets = [{one.name} for one in result.effects] + [{one.name for one in group} for group in result.one_of]
    wanted = WANTED if effects else []
    return {
        "effects": effects,
        "cpu_s": time.process_time() - begun,
        "found": [any(names & want for names in sets) for want in wanted],
        "odd": [sorted(names) for names in sets if not any(names & want for want in wanted)],
        "verdict": result.verdict,
        "sentence": result.sentence,
        "doubts": list(result.doubts),
    }


def summary(rows: list[Row]) -> str:
    """Shares with their 95 % intervals."""
    lines = []
    for effects, what in ((True, "with both effects"), (False, "without effects")):
        mine = [row for row in rows if row["effects"] == effects]
        if not mine:
            continue
        counts = [("all found", sum(all(row["found"]) for row in mine))] if effects else []
        counts.append(("a wrong name", sum(bool(row["odd"]) for row in mine)))
        for words, count in counts:
            low, high = interval(count, len(mine))
            lines.append(f"{what}: {words} in {count} of {len(mine)} ({low:.0%} to {high:.0%})")
    return "\n".join(lines)


def main() -> None:
    """Parse and do."""
    options = parser(__doc__)
    options.add_argument("--without", action="store_true", help="the twins without effects")
    options.add_argument("--unstated", action="store_true", help="the measurement file does not state the weight")
    given = options.parse_args()
    seeds = range(given.first_seed, given.first_seed + given.runs)
    Study(judged, summary).run([(seed, not given.without, not given.unstated) for seed in seeds], given)


if __name__ == "__main__":
    main()
