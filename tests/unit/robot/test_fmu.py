"""The FMU checked and run by fmpy: the standard's rules, the loop of ``simulate``, energy, back-driving, modes."""

import shutil
import zipfile
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mbcdm_cad.design.blocks import Payload
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.layouts.turns import modes_of
from mbcdm_cad.rig.experiment import Experiment
from mbcdm_cad.rig.quasistatic import simulate
from mbcdm_cad.robot.elastic import ElasticDrive, elastic_drive
from mbcdm_cad.robot.fmu import fmu_file
from tests.support.reference import PARAMS

fmpy = pytest.importorskip("fmpy")
pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
STEP_S = 1e-3


class Exported:
    """A design's FMU in a file, with what it was made from."""

    def __init__(self, name: str, folder: Path) -> None:
        self.drive = load_design(PARAMS / f"{name}.yaml").drive
        self.soft: ElasticDrive = elastic_drive(self.drive)
        self.content, self.platform = fmu_file(self.drive, self.soft)
        self.path = folder / f"{name}.fmu"
        self.path.write_bytes(self.content)

    def run(self, until_s: float, start: dict[str, float], **signals: Any) -> Any:
        """All outputs at each step; ``signals`` by input, functions of time; the motors hold the preload else."""
        given = {f"motor_torque_{name}": self.held(i) for i, name in enumerate(self.drive.input_names)} | signals
        time = np.arange(0.0, until_s + STEP_S, STEP_S)
        table = np.zeros(time.size, dtype=[("time", float), *((name, float) for name in given)])
        table["time"] = time
        for name, of in given.items():
            table[name] = of(time)
        return fmpy.simulate_fmu(
            str(self.path), stop_time=until_s, output_interval=STEP_S, step_size=STEP_S, input=table, start_values=start
        )

    def held(self, i: int) -> Any:
        return lambda time: np.full(time.shape, self.soft.held_Nm[i])

    def inputs_rad(self, result: Any) -> Any:
        """Inputs by their encoders, at the drum, weighted by the stiffness of their cables."""
        stiff = np.array([stage.sticking_Nm_rad for stage in self.soft.stages])
        angles = [
            result[f"input_encoder_{name}"] / turn
            for name, turn in zip(self.drive.input_names, self.soft.turns, strict=True)
        ]
        return stiff @ angles / stiff.sum()


@pytest.fixture(scope="module")
def reference(tmp_path_factory: pytest.TempPathFactory) -> Exported:
    return Exported("mbcdm", tmp_path_factory.mktemp("fmu"))


def test_it_keeps_the_rules_of_the_standard_and_its_bytes(reference: Exported) -> None:
    from fmpy.validation import validate_fmu

    assert validate_fmu(str(reference.path)) == []
    names = zipfile.ZipFile(BytesIO(reference.content)).namelist()
    assert {"modelDescription.xml", "sources/drive.c", "sources/parameters.h"} < set(names)
    assert any(name.startswith(f"binaries/{reference.platform}/") for name in names)
    again, _ = fmu_file(reference.drive, reference.soft)
    assert again == reference.content


@pytest.mark.parametrize("share", [0.3, 1.0, 2.0])
def test_swing_and_loop_are_those_of_simulate(reference: Exported, share: float) -> None:
    drive = reference.drive
    torque, period = share * drive.loads.test_torque_Nm, 4.0
    firm = {f"input_friction_{name}": 100.0 for name in drive.input_names} | {"drum_friction": 0.0}
    result = reference.run(2.25 * period, firm, load_torque=lambda t: torque * np.sin(2.0 * np.pi * t / period))
    last = result["time"] >= 1.25 * period
    load = torque * np.sin(2.0 * np.pi * (result["time"][last] - STEP_S) / period)
    turn = (result["payload_angle"] - reference.inputs_rad(result))[last]
    rig = simulate(
        drive,
        Experiment.model_validate(
            {
                "name": "loop",
                "duration_s": 45.0,
                "motion": {"shape": "hold", "amplitude_mrad": 1e-6, "period_s": 1.0, "stray_urad": 0.0},
                "load": {"kind": "torque_motor", "wave": "sine", "wave_period_s": 20.0, "levels_Nm": [torque]},
                "physics": {"cable_transport": False, "structure": True},
            }
        ),
    )
    wanted, at = rig.payload_rad[2500:], rig.load_Nm[2500:]
    assert np.ptp(turn) == pytest.approx(np.ptp(wanted), rel=0.02), (np.ptp(turn), np.ptp(wanted))
    areas = [abs(float(np.trapezoid(np.append(m, m[0]), np.append(x, x[0])))) for m, x in ((load, turn), (at, wanted))]
    assert areas[0] == pytest.approx(areas[1], rel=0.1), areas


@pytest.mark.parametrize("name", ["mbcdm", "siso_spur"])
def test_motors_need_the_torque_that_analyse_states(name: str, tmp_path: Path) -> None:
    """Both motors lift a load slowly: their torques at the start of the motion, by the page's sums of all losses."""
    exported = Exported(name, tmp_path)
    drive, load = exported.drive, 0.4
    moving = layout_of(drive).losses.moving(load, 1)
    # A ramp from half of what is needed to half more; the drum moves once every motor is over its friction.
    needs = moving.motor_Nm[:, 0]

    def torque(i: int) -> Any:
        return lambda t: needs[i] * (0.5 + t)

    signals = {f"motor_torque_{input_}": torque(i) for i, input_ in enumerate(drive.input_names)}
    limits = {"peak_torque": 10.0 * float(needs.max())}
    result = exported.run(1.0, limits, load_torque=lambda t: np.full(t.shape, load), **signals)
    speed = np.gradient(result["payload_angle"], result["time"])
    moves = result["time"][np.flatnonzero(np.abs(speed[100:]) > 0.02)[0] + 100]
    assert 0.5 + moves == pytest.approx(1.0, abs=0.08), (moves, needs)


def test_over_a_cycle_the_motors_give_payload_loop_and_losses(reference: Exported) -> None:
    """A payload swung by the motors under a steady load and stopped again: what was lost, from signals alone."""
    drive, load = reference.drive, 0.3
    moving = [layout_of(drive).losses.moving(load, way) for way in (1, -1)]
    names, turns = drive.input_names, reference.soft.turns
    # Torque against friction in the sense of the motion, and a spring and damper that lead along a sine.
    from fmpy import extract, read_model_description
    from fmpy.fmi2 import FMU2Slave

    described = read_model_description(str(reference.path))
    at = {variable.name: variable.valueReference for variable in described.modelVariables}
    unzipped = extract(str(reference.path))
    fmu = FMU2Slave(
        guid=described.guid, unzipDirectory=unzipped, modelIdentifier=described.coSimulation.modelIdentifier
    )
    try:
        fmu.instantiate()
        fmu.setupExperiment(startTime=0.0)
        fmu.enterInitializationMode()
        fmu.setReal([at["load_torque"], at["peak_torque"]], [load, 1.0])
        fmu.exitInitializationMode()
        step, count, period = 2e-4, 20000, 2.0
        motors = [at[f"motor_angle_{name}"] for name in names]
        angle, last = np.zeros((count, len(names))), [0.0] * len(names)
        torque, payload = np.zeros((count, len(names))), np.zeros(count)
        inertia = reference.soft.motor.inertia_kg_m2
        held = [reference.held(i)(np.zeros(1))[0] for i in range(len(names))]
        for k in range(count):
            time = k * step
            aim, speed = 0.05 * np.cos(np.pi * time) - 0.05, -0.05 * np.pi * np.sin(np.pi * time)
            seen = fmu.getReal(motors)
            for i, turn in enumerate(turns):
                shaft = turn * reference.soft.gear_ratio
                rate = (seen[i] - last[i]) / step
                torque[k, i] = held[i] + inertia * (150.0**2 * (aim * shaft - seen[i]) + 300.0 * (speed * shaft - rate))
                last[i] = seen[i]
            fmu.setReal([at[f"motor_torque_{name}"] for name in names], list(torque[k]))
            fmu.doStep(currentCommunicationPoint=time, communicationStepSize=step)
            angle[k] = fmu.getReal(motors)
            (payload[k],) = fmu.getReal([at["payload_angle"]])
        fmu.terminate()
    finally:
        fmu.freeInstance()
        shutil.rmtree(unzipped, ignore_errors=True)
    cycle = slice(count - round(period / step), count)
    given = float((torque[cycle][1:] * np.diff(angle[cycle], axis=0)).sum())
    taken = load * float(payload[cycle][-1] - payload[cycle][0])
    stated = sum(float(way.lost_Nm[0]) for way in moving) * 0.1
    assert given - taken == pytest.approx(stated, rel=0.1), (given, taken, stated)


@pytest.mark.parametrize("name", ["mbcdm", "siso_spur", "miso_spur", "siso_bevel"])
def test_a_drive_that_nothing_loads_stays(name: str, tmp_path: Path) -> None:
    """Motors hold the preload against each other; one motor alone holds none, whatever its cables' radii."""
    exported = Exported(name, tmp_path)
    result = exported.run(0.5, {})
    sticking = sum(stage.sticking_Nm_rad for stage in exported.soft.stages)
    turn = abs(sum(stage.preload_Nm for stage in exported.soft.stages)) / sticking
    assert np.abs(result["payload_angle"]).max() <= 2.0 * turn + 1e-6, (result["payload_angle"][-1], turn)
    if len(exported.drive.input_names) == 1:
        assert exported.soft.held_Nm == pytest.approx((0.0,), abs=1e-12)


def test_the_payload_rings_at_the_mode_of_cables_and_parts(reference: Exported) -> None:
    heavy = 0.02
    free = {f"input_friction_{name}": 0.0 for name in reference.drive.input_names}
    free |= {"drum_friction": 0.0, "motor_friction": 0.0, "gear_share": 0.0, "payload_inertia": heavy}
    result = reference.run(1.0, free, load_torque=lambda t: np.full(t.shape, 0.005))
    seen = result["payload_angle"] - reference.inputs_rad(result)
    spectrum = np.abs(np.fft.rfft((seen - seen.mean()) * np.hanning(seen.size), 1 << 16))
    found = float(np.fft.rfftfreq(1 << 16, STEP_S)[spectrum.argmax()])
    sticking = sum(stage.sticking_Nm_rad for stage in reference.soft.stages)
    give = 1.0 / sticking + reference.soft.compliance.land_to_payload
    rotors = sum(reference.drive.rotor_at_input_kg_m2 * turn**2 for turn in reference.soft.turns)
    expected = np.sqrt((1.0 / heavy + 1.0 / rotors) / give) / 2.0 / np.pi
    assert found == pytest.approx(expected, rel=0.05), (found, expected)
    drive = reference.drive
    loads = replace(drive.loads, payload=Payload(inertia_kg_m2=heavy))
    page = modes_of(layout_of(replace(drive, loads=loads))).inputs_free_Hz
    assert min(abs(found / mode - 1.0) for mode in page) < 0.03, (found, page)


def test_two_rotors_swing_against_each_other_at_the_lowest_mode_of_the_page(reference: Exported) -> None:
    """The inputs on gearheads and cables, the payload between them at rest."""
    free = {f"input_friction_{name}": 0.0 for name in reference.drive.input_names}
    free |= {"drum_friction": 0.0, "motor_friction": 0.0, "gear_share": 0.0}
    kick = {
        f"motor_torque_{name}": lambda t, i=i: reference.held(i)(t) + (-1) ** i * 2e-5 * (t < 0.002)
        for i, name in enumerate(reference.drive.input_names)
    }
    result = reference.run(1.0, free, **kick)
    left, right = (result[f"motor_angle_{name}"] for name in reference.drive.input_names)
    seen = left - right
    spectrum = np.abs(np.fft.rfft((seen - seen.mean()) * np.hanning(seen.size), 1 << 16))
    found = float(np.fft.rfftfreq(1 << 16, STEP_S)[spectrum.argmax()])
    lowest = modes_of(layout_of(reference.drive)).inputs_free_Hz[0]
    assert found == pytest.approx(lowest, rel=0.05), (found, lowest)
