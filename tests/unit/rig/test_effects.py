"""Each effect compared with its physics computed by hand, on a bench with perfect sensors."""

from __future__ import annotations

import pkgutil
from importlib import import_module
from math import pi, radians

import numpy as np
import pytest

from mbcdm_cad.layouts.loader import load_design, load_text
from mbcdm_cad.rig import effects
from mbcdm_cad.rig.effects.machine import RigEffect
from mbcdm_cad.rig.experiment import Experiment
from mbcdm_cad.rig.quasistatic import simulate

PERFECT = {
    "input_resolution_rad": 0.0,
    "output_resolution_rad": 0.0,
    "torque_noise_Nm": 0.0,
    "temperature_noise_K": 0.0,
}
BRAKE = {"kind": "brake", "levels_Nm": [0.91]}
E_A = 54e9 * 0.3117e-6
SPUR = """\
name: plain
configuration: siso_spur
travel: {{half_angle_deg: 30.0}}
transmission: {{drum_radius_mm: 60.0, input_to_drum: {ratio}}}
loads: {{peak_torque_Nm: 5.0}}
"""


@pytest.fixture(scope="module")
def drive(project):
    return load_design(project / "params" / "mbcdm.yaml").drive


def run(drive, *effects, load=None, amplitude_mrad=50.0, sensors=None, transport=False, duration_s=20.0):
    return simulate(
        drive,
        Experiment.model_validate(
            {
                "name": "x",
                "duration_s": duration_s,
                "sample_rate_Hz": 50.0,
                "motion": {"shape": "sine", "amplitude_mrad": amplitude_mrad, "period_s": 10.0, "stray_urad": 0.0},
                "load": load or {"kind": "none"},
                "sensors": {**PERFECT, **(sensors or {})},
                "physics": {"cable_transport": transport},
                "effects": list(effects),
            }
        ),
    )


def change_urad(drive, *effects, **more):
    with_effect, without = run(drive, *effects, **more), run(drive, **more)
    return (with_effect.measured_output_rad - without.measured_output_rad) * 1e6, without


def fitted(values, *columns):
    return np.linalg.lstsq(np.stack(columns, axis=1), values, rcond=None)[0]


def test_drum_eccentricity_turns_the_drum_by_its_offset_over_the_radius(drive):
    """The groove's centre goes ahead by e cos: all four cables see it alike, as -e_x (1/r_o) on the mean."""
    effect = {"effect": "eccentric_pulley", "stage": "drum", "eccentricity_um": 20.0, "phase_deg": 90.0}
    change, base = change_urad(drive, effect, amplitude_mrad=450.0)
    drum = base.drum_rad
    amplitude = fitted(change, np.cos(drum + pi / 2) - np.cos(pi / 2), np.ones(drum.size))[0]
    stiff = np.array([1.0 / c.drum_radius_mm for c in drive.cables])
    assert abs(amplitude) == pytest.approx(20e-3 * stiff.mean() * 1e6, rel=0.05), f"{amplitude} urad"


@pytest.mark.parametrize("stage", ["guide", "input_left", "input_right"])
def test_eccentric_pulley_changes_tension_by_newtons(drive, stage):
    effect = {"effect": "eccentric_pulley", "stage": stage, "eccentricity_um": 10.0}
    faulty, base = run(drive, effect, amplitude_mrad=450.0), run(drive, amplitude_mrad=450.0)
    swing = np.abs(faulty.tension_N - base.tension_N).max(axis=1)
    touched = [stage in ("guide", f"input_{c.input_name}") for c in drive.cables]
    assert 2.0 < max(swing) < 10.0, f"{swing} N for 10 um"
    assert all(s > 0.01 for s, t in zip(swing, touched, strict=True) if t)


def test_encoder_errors_come_out_as_they_are(drive):
    scale, base = change_urad(drive, {"effect": "encoder_scale", "stage": "drum", "share_ppm": 1000.0})
    assert np.allclose(scale, 1e3 * base.drum_rad, atol=1e-9)
    once, base = change_urad(
        drive, {"effect": "eccentric_encoder", "stage": "drum", "amplitude_urad": 30.0, "phase_deg": 20.0}
    )
    assert np.allclose(once, 30.0 * np.cos(base.drum_rad + radians(20.0)), atol=1e-9)
    fine, base = change_urad(
        drive, {"effect": "encoder_subdivision", "stage": "drum", "amplitude_urad": 2.0, "cycles_per_rev": 18000.0}
    )
    assert np.allclose(fine, 2.0 * np.sin(18000.0 * base.drum_rad), atol=1e-8)
    faulty = run(drive, {"effect": "encoder_scale", "stage": "input_left", "share_ppm": 1000.0})
    assert np.allclose(faulty.measured_input_rad[0], 1.001 * faulty.input_rad[0], rtol=1e-12)
    assert np.array_equal(faulty.measured_input_rad[1], faulty.input_rad[1])


def test_radius_error_of_the_drum_changes_the_ratio(drive):
    change, base = change_urad(drive, {"effect": "radius_error", "stage": "drum", "error_um": 50.0})
    slope = fitted(change * 1e-6, base.drum_rad)[0]
    assert slope == pytest.approx(-np.mean([50e-3 / c.drum_radius_mm for c in drive.cables]), rel=0.02), f"{slope}"


def test_modulus_preload_and_friction_change_the_loop_as_they_should(drive):
    def swing(*effects):
        found = run(drive, *effects, load=BRAKE)
        ideal = np.mean([a / 9.0 for a in found.input_rad], axis=0)
        return np.ptp((ideal - found.drum_rad)[500:]) * 1e6

    base = swing()
    assert swing({"effect": "modulus", "share": 0.2}) == pytest.approx(base / 1.2, rel=1e-3)
    less = swing({"effect": "preload", "share": 0.2})
    slick = swing({"effect": "rope_friction", "share": 0.2})
    assert base * 0.9 < less < base * 0.99, f"{less} of {base} urad: the slip part goes with 1/T_pre"
    # mu T_pre is what counts, to second order
    assert slick == pytest.approx(less, rel=2e-3), f"{slick} against {less} urad"


def test_output_shaft_and_friction_work_by_compliance(drive):
    change, base = change_urad(drive, {"effect": "shaft_compliance", "compliance_urad_Nm": 40.0}, load=BRAKE)
    assert np.allclose(change, -40.0 * base.load_Nm, atol=1e-9)
    # Hidden torque acts as the same torque of a brake does, and the sensor does not feel it.
    hidden = run(drive, {"effect": "bearing_friction", "drum_mNm": 200.0, "presliding_urad": 500.0})
    open_ = run(drive, load={"kind": "brake", "levels_Nm": [0.2], "flank_mrad": 0.5})
    assert np.allclose(hidden.drum_rad, open_.drum_rad, atol=1e-12)
    assert np.all(hidden.load_Nm == 0.0)
    guide = run(drive, {"effect": "bearing_friction", "guide_mNm": 200.0 / 6.0, "presliding_urad": 500.0})
    assert np.allclose(guide.drum_rad, hidden.drum_rad, atol=1e-10)
    # A Stribeck part that no speed of the run ends is constant, one that ends at once is not there.
    for fades, drum in ((1e5, 150.0), (1e-3, 200.0)):
        law = {"drum_mNm": drum, "stribeck_mNm": 50.0, "stribeck_mrad_s": fades, "presliding_urad": 500.0}
        both = run(drive, {"effect": "bearing_friction"} | law)
        off = np.abs(both.drum_rad - hidden.drum_rad).max()
        assert off < 1e-6, f"{off:.3g} rad; 50 mN m turn the drum by some 10 urad"


def test_delay_and_viscous_drag_go_with_speed(drive):
    change, base = change_urad(drive, {"effect": "sensor_delay", "delay_ms": 20.0})
    speed = np.gradient(base.drum_rad, base.time_s)
    assert fitted(change[50:] * 1e-6, speed[50:])[0] == pytest.approx(-0.02, rel=0.01)
    drag, base = change_urad(drive, {"effect": "viscous_drag", "drag_Nms": 10.0})
    speed = np.gradient(base.drum_rad, base.time_s)
    assert np.corrcoef(drag, -speed)[0, 1] > 0.98


def test_lash_follows_the_sign_of_the_torque_the_bias_included(drive):
    """Equal preloads pull each input by 28 mN m one way: an idle drive never changes flank, a loaded one does."""
    effect = {"effect": "gearhead_lash", "stage": "input_left", "play_urad": 1000.0}
    idle = run(drive, effect, sensors={"input_at": "motor"})
    gap = idle.measured_input_rad[0] - idle.input_rad[0]
    assert np.ptp(gap) < 20e-6, f"{np.ptp(gap)} rad"
    loaded = run(drive, effect, sensors={"input_at": "motor"}, load=BRAKE)
    gap = (loaded.measured_input_rad[0] - loaded.input_rad[0])[500:]
    assert np.ptp(gap) == pytest.approx(1000e-6, rel=0.1), f"{np.ptp(gap)} rad"
    seen = run(drive, effect, load=BRAKE)
    assert np.array_equal(seen.measured_input_rad, seen.input_rad), "an encoder on the pulley sees it all"
    assert seen.truth[0]["seen"] is False


@pytest.mark.parametrize("transport", [False, True])
@pytest.mark.parametrize(("play_urad", "stiffness_Nm_rad"), [(300.0, 5000.0), (1000.0, 5000.0), (3000.0, 500.0)])
def test_lash_of_one_input_swings_the_drum_by_the_play_over_the_ratio(transport, play_urad, stiffness_Nm_rad):
    """One input has no bias: where the load changes its sign, the pulley crosses its play, and the drum with it."""
    ratio = 2.95
    spur = load_text(SPUR.format(ratio=ratio), "plain.yaml").drive
    load = {"kind": "torque_motor", "wave": "sine", "levels_Nm": [1.5], "wave_period_s": 13.0}
    effect = {"effect": "gearhead_lash", "stage": "input_main", "stiffness_Nm_rad": stiffness_Nm_rad}
    more = {"load": load, "sensors": {"input_at": "motor"}, "transport": transport}
    swings = [np.ptp(turned_rad(spur, {**effect, "play_urad": play}, **more)) for play in (play_urad, 0.0)]
    assert swings[0] - swings[1] == pytest.approx(play_urad * 1e-6 / ratio, rel=2e-3), swings


def turned_rad(drive, effect, **more):
    found = run(drive, effect, **more)
    return found.drum_rad - found.measured_input_rad[0] / drive.total_ratio


def test_gear_mesh_and_cogging_move_the_pulleys(drive):
    mesh = {"effect": "gear_mesh", "stage": "input_right", "amplitude_urad": 100.0, "cycles_per_input_rev": 30.0}
    found = run(drive, mesh, sensors={"input_at": "motor"})
    gap = found.input_rad[1] - found.measured_input_rad[1]
    assert np.allclose(gap, 100e-6 * np.sin(30.0 * found.measured_input_rad[1]), atol=1e-12)
    cogging = run(drive, {"effect": "motor_cogging", "stage": "input_left", "torque_mNm": 0.05})
    moved = cogging.input_rad[0] - run(drive).input_rad[0]
    assert np.abs(moved).max() == pytest.approx(0.05 / 2.0 / 76.0, rel=0.02)
    assert np.array_equal(cogging.measured_input_rad, cogging.input_rad)


def test_rope_lay_ripples_once_a_lay_of_rope(drive):
    change, base = change_urad(
        drive, {"effect": "rope_lay", "amplitude_um": 30.0, "lay_mm": 6.5, "cables": ["cable_2"]}, amplitude_mrad=450.0
    )
    order = 2 * pi * 57.6 / 6.5
    phase = order * base.drum_rad
    sin, cos, _, _ = fitted(change, np.sin(phase), np.cos(phase), np.ones(phase.size), base.drum_rad)
    # On the input lambda/2pi/r_i of the height, less on the drum; one cable of four moves the drum by a quarter or so.
    path_um = 30.0 * 6.5 / (2 * pi) * (1 / 6.4 + 1 / 57.6)
    assert np.hypot(sin, cos) == pytest.approx(path_um / 57.6e-3 / 4.0, rel=0.2), f"{np.hypot(sin, cos)} urad"


def test_warm_rope_goes_slack_by_its_strain_and_turns_the_drum(drive):
    heat = {"effect": "temperature", "rise_K": 10.0, "time_constant_s": 1.0}
    all_ropes = run(drive, heat, amplitude_mrad=0.01)
    assert all_ropes.tension_N[:, -1] == pytest.approx(70.0 - E_A * 160e-6, abs=0.1)
    assert abs(all_ropes.drum_rad[-1] - run(drive, amplitude_mrad=0.01).drum_rad[-1]) < 2e-6
    one = run(drive, {**heat, "cables": ["cable_1"]}, amplitude_mrad=0.01)
    assert one.drum_rad[-1] > 5e-6, "cable 1 pulls the drum back; it goes slack, so the drum goes ahead"
    assert one.measured_temperature_C[-1] == pytest.approx(32.0, abs=0.01)


def test_warm_body_without_warm_rope_tightens(drive):
    heat = {
        "effect": "temperature",
        "rise_K": 10.0,
        "time_constant_s": 1.0,
        "body_share": 1.0,
        "rope_ppm_K": 0.0,
        "frame_ppm_K": 20.0,
        "drum_ppm_K": 20.0,
        "input_ppm_K": 20.0,
    }
    assert run(drive, heat, amplitude_mrad=0.01).tension_N[:, -1] == pytest.approx(70.0 + E_A * 200e-6, rel=2e-3)


def test_creep_takes_tension_by_the_logarithm(drive):
    found = run(drive, {"effect": "creep", "strain_ppm": 20.0, "t0_s": 2.0}, amplitude_mrad=0.01)
    expected = 70.0 - E_A * 20e-6 * np.log1p(found.time_s / 2.0)
    assert np.abs(found.tension_N - expected).max() < 0.05


def test_anchor_slip_is_a_step_in_time(drive):
    change, base = change_urad(drive, {"effect": "anchor_slip", "cable": "cable_3", "at_s": 9.0, "slip_um": 20.0})
    assert np.abs(change[base.time_s < 8.9]).max() < 1e-6
    assert np.abs(change[base.time_s > 9.2]).min() > 20.0 / 61.2e-3 / 10.0


def test_local_faults_show_only_where_they_lie(drive):
    wear, base = change_urad(
        drive,
        {"effect": "land_wear", "cable": "cable_2", "depth_um": 50.0, "from_deg": 10.0, "to_deg": 16.0},
        amplitude_mrad=450.0,
    )
    before = (base.time_s < 10.0) & (-base.drum_rad < radians(10.0)) & (base.time_s < 5.0)
    assert np.abs(wear[before]).max() < 1e-6
    assert np.abs(wear).max() > 1.0
    climb, base = change_urad(
        drive, {"effect": "step_climb", "cable": "cable_1", "height_um": 50.0, "from_deg": 12.0}, amplitude_mrad=450.0
    )
    assert np.abs(climb[(base.time_s < 2.5) & (base.drum_rad < radians(12.0))]).max() < 1e-6
    assert np.abs(climb).max() > 3.0
    bump, base = change_urad(
        drive,
        {"effect": "strand_damage", "cable": "cable_2", "height_um": 100.0, "position_mm": 26.0},
        amplitude_mrad=450.0,
    )
    assert np.ptp(bump) > 3.0


def test_a_sticking_brake_saws_between_static_and_as_far_below(drive):
    found = run(drive, {"effect": "brake_stick_slip", "static_share": 1.2, "scatter": 0.0}, load=BRAKE)
    late = np.abs(found.load_Nm[300:])
    assert late.max() == pytest.approx(0.91 * 1.2, rel=0.03)
    assert np.sum(np.abs(np.diff(found.load_Nm)) > 0.2) > 10, "drops"


def test_many_effects_together_and_each_tells_the_truth(drive):
    effects = [
        {"effect": "eccentric_pulley", "stage": "guide", "eccentricity_um": 5.0},
        {"effect": "preload", "share": -0.2, "cables": ["cable_3"]},
        {"effect": "gearhead_lash", "stage": "input_right", "play_urad": 300.0, "stiffness_Nm_rad": 50.0},
        {"effect": "creep", "strain_ppm": 10.0},
        {"effect": "rope_lay", "amplitude_um": 5.0},
        {"effect": "anchor_slip", "cable": "cable_1", "at_s": 5.0, "slip_um": 5.0},
    ]
    found = run(drive, *effects, load=BRAKE, transport=True, sensors={"input_at": "motor"})
    names = [entry["name"] for entry in found.truth]
    assert names == ["once_per_rev", "preload_error", "lash", "creep", *["ripple"] * 4, "slip_step", "winding_history"]


def test_every_effect_is_in_the_registry():
    for module in pkgutil.iter_modules(effects.__path__, f"{effects.__name__}."):
        import_module(module.name)
    listed = set(effects.AnyEffect.__args__[0].__args__)
    assert set(RigEffect.__subclasses__()) == listed
