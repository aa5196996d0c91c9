"""Structure and losses in both rigs: the swing at the payload, what is lost over a cycle, and where the energy goes."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.layouts.lumped import compliance_of
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.model import hysteresis
from mbcdm_cad.model.analysis import analyse
from mbcdm_cad.rig.dynamic import plant, run
from mbcdm_cad.rig.dynamic.simulate import simulate_dynamic
from mbcdm_cad.rig.dynamic.train import inertias, rig_of
from mbcdm_cad.rig.experiment import DynamicExperiment, Experiment
from mbcdm_cad.rig.quasistatic import set_up, simulate
from tests.support.reference import PARAMS

REFERENCES = ("mbcdm", "siso_spur", "miso_spur", "siso_bevel")


def drive_of(name: str) -> Any:
    return load_design(PARAMS / f"{name}.yaml").drive


def static(
    load: dict[str, Any], motion: dict[str, Any] | None = None, at: str = "pulley", **physics: Any
) -> Experiment:
    exact = {"input_resolution_rad": 0.0, "output_resolution_rad": 0.0, "torque_noise_Nm": 0.0, "input_at": at}
    motion = motion or {"shape": "hold", "amplitude_mrad": 1e-6, "period_s": 1.0}
    return Experiment.model_validate(
        {
            "name": "parts",
            "duration_s": 40.0,
            "motion": {**motion, "stray_urad": 0.0},
            "load": load,
            "sensors": exact,
            "physics": {"cable_transport": False, **physics},
        }
    )


def swinging(torque_Nm: float) -> dict[str, Any]:
    return {"kind": "torque_motor", "wave": "sine", "wave_period_s": 20.0, "levels_Nm": [torque_Nm]}


def swing_rad(angle: Any) -> float:
    """From one extreme of the load to the other, after the first quarter."""
    return float(np.ptp(angle[angle.size // 4 :]))


@pytest.mark.parametrize("name", REFERENCES)
@pytest.mark.parametrize("held", ["pulley", "motor"])
def test_the_payload_swings_as_far_as_the_page_states(name: str, held: str) -> None:
    drive = drive_of(name)
    torque, structure = drive.loads.test_torque_Nm, structure_of(layout_of(drive))
    run = simulate(drive, static(swinging(torque), at=held, structure=True))
    before = structure.motor_urad_Nm - structure.payload_urad_Nm if held == "motor" else 0.0
    cables = hysteresis.simulate(layout_of(drive).si, np.zeros_like(run.input_rad), run.load_Nm).drum_angle_rad
    for seen, parts in (
        (run.payload_rad, structure.payload_urad_Nm + before),
        (run.measured_output_rad, structure.encoder_urad_Nm + before),
    ):
        stated = swing_rad(cables - parts * 1e-6 * run.load_Nm)
        assert swing_rad(seen) == pytest.approx(stated, rel=0.02), (swing_rad(seen), stated)
    if name != "siso_bevel":  # whose page takes both turns from rest, under the torque of its unequal radii
        page = analyse(layout_of(drive)).reversal_swing_mrad * 1e-3 + 2e-6 * torque * (
            structure.payload_urad_Nm + before
        )
        assert swing_rad(run.payload_rad) == pytest.approx(page, rel=0.02), (swing_rad(run.payload_rad), page)


def test_off_both_rigs_know_the_cables_alone() -> None:
    drive = drive_of("mbcdm")
    run = simulate(drive, static(swinging(0.91)))
    assert np.array_equal(run.payload_rad, run.drum_rad)
    assert swing_rad(run.payload_rad) == pytest.approx(analyse(layout_of(drive)).reversal_swing_mrad * 1e-3, rel=2e-3)
    assert [entry["name"] for entry in run.truth] == []


@pytest.mark.parametrize("name", REFERENCES)
def test_energy_over_a_cycle_is_payload_loop_and_losses(name: str) -> None:
    """The inputs give to the cables what payload, loop of the cables and friction take; the friction is the page's."""
    drive = drive_of(name)
    torque = 0.2 * drive.loads.test_torque_Nm
    motion = {"shape": "triangle", "amplitude_mrad": 50.0, "period_s": 10.0, "corner_s": 0.0}
    load = {"kind": "torque_motor", "levels_Nm": [torque]}
    experiment = static(load, motion, losses=True, structure=True)
    run = simulate(drive, experiment)
    bench = set_up(drive, experiment)
    levers = np.zeros_like(run.input_rad)
    for cable, tension in zip(bench.cables, run.tension_N, strict=True):
        levers[cable.input_index] += cable.sigma * cable.input_radius_m * tension
    cycle = slice(1999, 3000)  # between two passages of the same corner: 10 s at 100 Hz

    def work(force: Any, angle: Any) -> float:
        force, angle = force[..., cycle], angle[..., cycle]
        return float((0.5 * (force[..., 1:] + force[..., :-1]) * np.diff(angle)).sum())

    given, taken = work(levers, run.input_rad), work(run.load_Nm, run.payload_rad)
    # The loop of the cables: the same run without friction of the parts loses that alone.
    plain = simulate(drive, static(load, motion))
    levers_plain = np.zeros_like(plain.input_rad)
    for cable, tension in zip(bench.cables, plain.tension_N, strict=True):
        levers_plain[cable.input_index] += cable.sigma * cable.input_radius_m * tension
    loop = work(levers_plain, plain.input_rad) - work(plain.load_Nm, plain.payload_rad)
    moving = [layout_of(drive).losses.moving(torque, way) for way in (1, -1)]
    at_drum = [
        sum(float(x.torque_Nm[0]) for x in way.losses if "input" not in x.name and x.kind in ("rope", "bearings"))
        for way in moving
    ]
    expected = sum(at_drum) * 0.1  # there and back over 100 mrad
    assert given - taken - loop == pytest.approx(expected, rel=0.03), (given, taken, loop, expected)


def dynamic(**more: Any) -> DynamicExperiment:
    fine = {"input_resolution_rad": 0.0, "output_resolution_rad": 0.0, "torque_noise_Nm": 0.0}
    given = {"rig": "dynamic", "name": "parts", "sample_rate_Hz": 1000, "sensors": fine, **more}
    return DynamicExperiment.model_validate(given)


LOSSLESS = {"lossless": True, "bandwidth_Hz": 0.5}


class TestDynamicRig:
    def test_the_payload_turns_as_the_page_states(self) -> None:
        drive = drive_of("mbcdm")
        structure = structure_of(layout_of(drive))
        still = {"motion": {"shape": "hold"}, "duration_s": 2.0}

        def turned(**physics: bool) -> tuple[float, float]:
            load = {"ramp_Nm_s": 0.3}
            run, _, rig = simulate_dynamic(drive, dynamic(**still, load=load, drives=LOSSLESS, physics=physics))
            # Where the loops let the inputs go, by the stiffness of each input's cables.
            stiff = [c.drum_radius_m**2 * c.stiffness_N / c.free_span_m for c in rig.cables]
            left = (
                sum(k * run.input_rad[c.input_index] for k, c in zip(stiff, rig.cables, strict=True)) / sum(stiff) / 9.0
            )
            return float((run.drum_rad - left)[-1]), float((run.payload_rad - left)[-1])

        rigid, soft = turned(), turned(structure=True)
        at = 0.3 * 2.0 * 1e-6
        assert rigid[0] == rigid[1]
        assert soft[0] - rigid[0] == pytest.approx(-structure.encoder_urad_Nm * at, rel=0.02), (soft, rigid)
        assert soft[1] - rigid[1] == pytest.approx(-structure.payload_urad_Nm * at, rel=0.02), (soft, rigid)

    @pytest.mark.parametrize("name", ["mbcdm", "siso_spur"])
    def test_motors_lose_what_the_page_states(self, name: str) -> None:
        """A steady load lifted and let down over whole periods: works of the motors, friction by the page's sums."""
        drive = drive_of(name)
        torque = 0.3
        sweep = {"motion": {"amplitude_mrad": 50.0, "frequency_Hz": 0.5}, "duration_s": 6.0}
        physics = {"losses": True, "structure": True, "cable_transport": False}
        run, _, _ = simulate_dynamic(drive, dynamic(**sweep, load={"torque_Nm": torque}, physics=physics))
        turns = np.array([c.drum_radius_mm / c.input_radius_mm for c in drive.cables]).max()
        last = run.time_s >= 2.0 - 1e-9

        def work(force: Any, angle: Any) -> float:
            force, angle = force[..., last], angle[..., last]
            return float((0.5 * (force[..., 1:] + force[..., :-1]) * np.diff(angle)).sum())

        lost = work(run.motor_Nm, run.rotor_rad) - work(np.full(run.time_s.size, torque), run.payload_rad)
        train = layout_of(drive).losses
        stated = sum(float(train.moving(torque, way).lost_Nm[0]) for way in (1, -1)) * 0.1 * 2.0
        assert turns > 4.0
        assert lost == pytest.approx(stated, rel=0.1), (lost, stated)

    def test_energy_is_accounted_for(self) -> None:
        run, _, _ = simulate_dynamic(
            drive_of("mbcdm"),
            dynamic(
                motion={"amplitude_mrad": 50.0, "frequency_Hz": 0.5},
                duration_s=4.0,
                load={"brake_Nm": 0.91, "inertia_kg_m2": 1e-3},
                physics={"losses": True, "structure": True},
            ),
        )
        e = run.energy_J
        spent = sum(v for k, v in e.items() if k not in ("motor", "stored"))
        assert abs(e["motor"] - spent - e["stored"]) < 2e-3 * e["motor"], e

    def test_the_payload_on_the_parts_rings_at_its_mode(self) -> None:
        """A heavy payload against the rotors, on cables, parts and gearheads in series; slow loops leave them free."""
        drive = drive_of("mbcdm")
        heavy = 0.02
        run, _, _ = simulate_dynamic(
            drive,
            dynamic(
                motion={"shape": "hold"},
                duration_s=1.0,
                load={"inertia_kg_m2": heavy, "torque_Nm": 0.02},
                drives=LOSSLESS,
                physics={"structure": True, "step_us": 20, "cable_transport": False},
            ),
        )
        seen = run.payload_rad - run.input_rad.mean(axis=0) / 9.0
        spectrum = np.abs(np.fft.rfft((seen - seen.mean()) * np.hanning(seen.size), 1 << 16))
        found = float(np.fft.rfftfreq(1 << 16, 1e-3)[spectrum.argmax()])
        give = (
            1.0 / analyse(layout_of(drive)).sticking_stiffness_Nm_rad
            + structure_of(layout_of(drive)).motor_urad_Nm * 1e-6
        )
        own = inertias(drive)
        at_inputs = np.array(own.inputs_kg_m2) + own.rotor_kg_m2 * own.gear_ratio**2
        rotors = own.drum_and_passed_kg_m2 + at_inputs @ [body.turns_per_drum**2 for body in own.routes.inputs]
        expected = np.sqrt((1.0 / heavy + 1.0 / rotors) / give) / 2.0 / np.pi
        assert found == pytest.approx(expected, rel=0.01), (found, expected)


def test_a_soft_payload_costs_one_coordinate_and_rigid_ones_none() -> None:
    rig = rig_of(drive_of("mbcdm"))
    assert plant.payload_at(run.plant_tables(rig)) == 4
    assert plant.payload_at(run.plant_tables(replace(rig, compliance=compliance_of(rig.drive)))) == 5
