"""A second opinion on one case: the loop and MuJoCo's system identification find the same compliance in the same logs.

Two weights on an arm behind a shaft that twists; the angle of the motor is given, that of the arm measured. The loop
regresses the statics against the known load; ``mujoco.sysid`` fits the stiffness of a simulated arm to its motion.
"""

from pathlib import Path

import mujoco
import numpy as np
from mujoco import sysid

import mbcdm_cad as mc

RATIO, ARM_M, MASSES_KG, COMPLIANCE = 4.0, 0.2, (0.5, 1.0), 4e-3
GRAVITY = 9.80665
TIME = np.arange(0.0, 60.0, 0.02)
DRIVEN = np.radians(100.0) * np.sin(2.0 * np.pi * TIME / 10.0)


def arm(mass_kg: float, seed: int) -> np.ndarray:
    """Angle of the arm from hanging down, with noise: the shaft twists by its compliance times weight and inertia."""
    inertia = mass_kg * ARM_M**2
    acceleration = -((2.0 * np.pi / 10.0) ** 2) * DRIVEN
    angle = DRIVEN
    for _ in range(5):
        angle = DRIVEN - COMPLIANCE * (mass_kg * GRAVITY * ARM_M * np.sin(angle) + inertia * acceleration)
    return np.asarray(angle + 1e-4 * np.random.default_rng(seed).standard_normal(TIME.size))


RUNS = {mass_kg: arm(mass_kg, seed) for seed, mass_kg in enumerate(MASSES_KG)}


def by_the_loop(folder: Path) -> float:
    files = []
    for mass_kg, angle in RUNS.items():
        name = f"with_{1e3 * mass_kg:.0f}_g"
        table = np.column_stack([TIME, RATIO * DRIVEN, angle])
        np.savetxt(folder / f"{name}.csv", table, delimiter=",", header="t,motor_rad,arm_rad", comments="", fmt="%.7f")
        load = f"load: {{pendulum: {{mass_kg: {mass_kg}, arm_mm: {1e3 * ARM_M}}}}}\n"
        files.append(folder / f"{name}.yaml")
        files[-1].write_text(mc.draft_measurement(folder / f"{name}.csv", ratio=RATIO) + load)
    result = mc.close_loop(None, files).result
    assert [one.name for one in result.effects] == ["stiffness_error"], result.sentence
    found = result.effects[0].parameters["compliance_rad_Nm"]
    assert found.low < COMPLIANCE < found.high, result.sentence
    return found.value


def by_mujoco() -> float:
    """A hinge whose position is held to the motor's by a spring; its stiffness and damping are fitted."""
    fine = np.arange(0.0, TIME[-1], 0.002)
    sequences = []
    for mass_kg, angle in RUNS.items():
        spec = mujoco.MjSpec.from_string(
            f"""<mujoco><option timestep="0.002" gravity="0 0 -{GRAVITY}"/><worldbody><body>
            <joint name="arm" type="hinge" axis="0 -1 0" damping="0.02"/>
            <inertial pos="0 0 -{ARM_M}" mass="{mass_kg}" diaginertia="1e-9 1e-9 1e-9"/></body></worldbody>
            <actuator><position name="shaft" joint="arm" kp="100"/></actuator>
            <sensor><jointpos name="angle" joint="arm"/></sensor></mujoco>"""
        )
        model = spec.compile()
        start = sysid.create_initial_state(model, angle[:1], np.gradient(DRIVEN, TIME)[:1], np.empty(0))
        control = sysid.TimeSeries.from_control_names(fine, np.interp(fine, TIME, DRIVEN)[:, None], model)
        seen = sysid.TimeSeries.from_names(TIME, angle[:, None], model, ["angle"])
        sequences.append(sysid.ModelSequences(f"{mass_kg}", spec, "run", start, control, seen))
    wanted = sysid.ParameterDict(
        {
            "shaft": sysid.Parameter(
                "shaft", 100.0, 20.0, 1000.0, modifier=lambda s, p: sysid.apply_pgain(s, "shaft", p.value[0])
            )
        }
    )
    found, _ = sysid.optimize(wanted, sysid.build_residual_fn(models_sequences=sequences), verbose=False)
    return 1.0 / float(found["shaft"].value[0])


def test_loop_and_mujoco_find_the_same_compliance(tmp_path: Path) -> None:
    loop, other = by_the_loop(tmp_path), by_mujoco()
    print(f"compliance: {1e3 * COMPLIANCE} mrad/(N m) true, {1e3 * loop:.3f} by the loop, {1e3 * other:.3f} by MuJoCo")
    assert abs(loop / COMPLIANCE - 1.0) < 0.02 and abs(other / COMPLIANCE - 1.0) < 0.05, (loop, other)
    assert abs(loop / other - 1.0) < 0.05, (loop, other)
