"""Run of all checks: the reference passes; waivers; checks without a figure."""

import random
import re
from collections.abc import Callable
from dataclasses import replace
from math import isfinite
from textwrap import dedent
from typing import Any, NamedTuple

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import mbcdm_cad
from mbcdm_cad.checks.comparison import TOLERANCE, Check, CheckResult, at_least, at_most, failed
from mbcdm_cad.checks.design_variables import ALL_RADII, up
from mbcdm_cad.checks.run import run_check
from mbcdm_cad.checks.size import BUILD_IDS
from mbcdm_cad.design.blocks import Waiver
from mbcdm_cad.design.bought import SpringSpec
from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.check_design import checks_of, known_ids, run_checks
from mbcdm_cad.layouts.loader import layout_of, load_design, load_text, reference_data
from mbcdm_cad.layouts.miso_bevel.checks import CHECKS
from mbcdm_cad.layouts.miso_bevel.layout import VARIABLES, BevelLayout
from tests.support.reference import PARAMS
from tests.support.reference import REFERENCE as OVERRIDES
from tests.unit.checks.designs import (
    Change,
    loaded,
    preloaded,
    put,
    radius_of,
    random_data,
    random_drives,
    reference,
    scaled,
    to,
    with_cable,
)


def by_id(results: tuple[CheckResult, ...]) -> dict[str, CheckResult]:
    return {result.id: result for result in results}


def test_a_drum_without_room_for_its_stop_pin_fails_and_ends_no_program() -> None:
    text = """
        configuration: siso_bevel
        travel: {half_angle_deg: 35.0}
        transmission: {input_to_drum: 3.0, drum_radius_mm: 25.0}
        loads: {peak_torque_Nm: 3.0, continuous_torque_Nm: 3.0}
        limits: {losses: counted}
    """
    found = by_id(run_checks(load_text(dedent(text), "small.yaml").drive))["stop_slot"]
    assert found.status == "fail" and "a larger drum makes room for it" in found.message, found


def test_reference_design_fails_nothing() -> None:
    results = run_checks(load_design(OVERRIDES))
    assert [(r.id, r.message) for r in failed(results)] == []
    warned = {r.id for r in results if r.status == "warn"}
    # The paper's own design: sharper bends than catalogues allow, wraps shorter than slip zones (terminals that can be
    # drawn in take some of the wrap), equal preloads on unequal radii, small bearings, and ratings that count neither
    # losses nor hours; gaps of hundredths of a millimetre that the tolerances of rope and parts exceed.
    expected = {
        "bend_ratio_minimum",
        "preload_bias",
        "motor_losses",
        "gearhead_continuous",
        "quiet_running",
        "self_clearance_stack",
        "flank_stack",
    }
    assert warned == expected, warned ^ expected


def test_ids_are_plain_unique_and_waivable() -> None:
    ids = known_ids(reference())
    assert len(ids) == len(set(ids))
    assert all(re.fullmatch(r"[a-z][a-z0-9_]{0,63}", name) for name in ids), ids
    assert {check.severity for check in CHECKS} <= {"fail", "warn"}
    assert all(check.title and check.source for check in CHECKS)


def test_results_come_in_the_order_of_the_registry_with_all_words(drive: Drive) -> None:
    results = run_checks(drive)
    assert [r.id for r in results] == [check.id for check in CHECKS if check.asked_of(drive)]
    for r in results:
        assert r.message and r.title and r.source, r
        assert all(v is None or isfinite(v) for v in (r.actual, r.limit, r.margin)), r
        assert (r.remedy == "") == (r.status == "pass"), r


def test_a_layout_is_checked_as_it_is(drive: Drive) -> None:
    lay = BevelLayout(drive)
    assert run_checks(lay) == run_checks(drive)
    thin = lay.with_dimensions(drum_shaft=replace(lay.drum_shaft, bore_radius=3.9))
    assert by_id(run_checks(thin))["shaft_wall"].status == "fail"


def test_pulleys_that_overlap_give_sentences_not_errors(drive: Drive) -> None:
    results = by_id(run_checks(put(drive, "centre_distance_mm", 17.0)))
    found = results["centre_distance"]
    assert found.status == "fail" and "raise transmission.centre_distance_mm from 17 to at least" in found.remedy, found
    dependent = results["rim_height"]
    assert dependent.status == "fail" and dependent.actual is None, dependent
    assert dependent.message.startswith("not evaluated because the pulleys have no place"), dependent.message


def test_a_load_beyond_all_reason_is_refused_by_the_model_in_a_sentence(drive: Drive) -> None:
    results = by_id(run_checks(put(drive, "loads.peak_torque_Nm", 1000.0)))
    found = results["tension"]
    assert found.status == "fail" and "1000 N m is more than 4 times what the preload can carry" in found.message, found


def test_a_weak_rope_is_told_which_of_the_catalogue_is_strong_enough(drive: Drive) -> None:
    """The named rope holds at the same tensions, and the next weaker one of its kind does not."""
    tight = replace(drive, cables=tuple(replace(cable, preload_N=300.0) for cable in drive.cables))
    found = by_id(run_checks(tight))["tension"]
    told = re.search(r"choose a rope that breaks at ([\d.]+) N or more \(such as (\S+)\)", found.remedy)
    assert told is not None and found.actual is not None and found.limit is not None, found
    ropes = {k: v["breaking_load_N"] for k, v in package_entries("ropes").items() if v["construction"] == "7x7"}
    needed = found.limit / found.actual * drive.cable.breaking_load_N
    assert float(told[1]) == pytest.approx(needed, rel=1e-3)
    assert ropes[told[2]] == min(load for load in ropes.values() if load >= needed), (needed, ropes)


def test_a_loud_bearing_is_told_which_of_the_same_bore_runs_quietly(drive: Drive) -> None:
    found = by_id(run_checks(put(drive, "bearings.guide.static_rating_N", 100.0)))["quiet_running"]
    told = re.search(
        r"choose a guide.bearing of static rating ([\d.]+) N or more, such as (\S+) of the same bore", found.remedy
    )
    assert told is not None, found
    entries = package_entries("bearings")
    assert entries[told[2]]["bore_mm"] == drive.bearings.guide.bore_mm, told
    assert entries[told[2]]["static_rating_N"] >= float(told[1]) * (1.0 - 1e-3), told


def test_frame_below_the_drum_axis_is_told(drive: Drive) -> None:
    results = by_id(run_checks(put(drive, "support.coupling_space_mm", 60.0)))
    assert "below the drum's axis" in results["stop_slot"].message, results["stop_slot"]


def test_other_gearheads_screws_are_told(drive: Drive) -> None:
    found = by_id(run_checks(put(drive, "gearhead.screw_count", 5)))["screw_counts"]
    assert found.status == "fail" and found.actual == 5.0 and "two to four screws" in found.remedy, found
    assert by_id(run_checks(drive))["screw_counts"].status == "pass"


def test_told_figures_have_no_limit(drive: Drive) -> None:
    results = by_id(run_checks(drive))
    for name in ("path_length", "shaft_twist"):
        assert results[name].limit is None and results[name].margin is None and results[name].status == "pass"
    # 35 mm of an 8/5.5 mm steel tube: 32 L / (pi G (D^4 - d^4)).
    assert results["shaft_twist"].actual == pytest.approx(1.369, abs=2e-3)


class TestWaivers:
    def test_a_failure_with_a_reason_passes_and_says_so(self, drive: Drive) -> None:
        heavy = put(drive, "loads.peak_torque_Nm", 3.3)
        assert [r.id for r in failed(run_checks(heavy))] == ["motor_torque_back"]
        waived = replace(heavy, waivers=(Waiver(check="motor_torque_back", reason="one direction is enough here"),))
        results = run_checks(waived)
        assert failed(results) == ()
        found = by_id(results)["motor_torque_back"]
        assert found.status == "pass" and found.waived_reason == "one direction is enough here", found
        assert found.margin is not None and found.margin < 0.0 and found.remedy, found

    def test_what_passes_or_warns_is_not_called_waived(self, drive: Drive) -> None:
        waivers = (
            Waiver(check="bend_ratio", reason="never needed"),
            Waiver(check="preload_bias", reason="small enough"),
        )
        results = by_id(run_checks(replace(drive, waivers=waivers)))
        assert results["bend_ratio"].waived_reason is None and results["preload_bias"].status == "warn"

    def test_nothing_to_measure_cannot_be_waived(self, drive: Drive) -> None:
        overlapping = put(drive, "centre_distance_mm", 17.0)
        waived = replace(overlapping, waivers=(Waiver(check="rim_height", reason="whatever"),))
        assert by_id(run_checks(waived))["rim_height"].status == "fail"

    def test_unknown_check_is_bad_input_with_line_and_suggestion(self) -> None:
        data = {**reference_data(), "waivers": [{"check": "bend_ration", "reason": "typed in haste"}]}
        loaded = load_text(yaml.safe_dump(data, sort_keys=False), "haste.yaml")
        with pytest.raises(InputError) as caught:
            run_checks(loaded)
        text = str(caught.value)
        line = loaded.line_of("waivers", 0, "check")
        assert text.startswith(f"haste.yaml:{line}: waivers[0].check: no such check") and line > 1, text
        assert "did you mean bend_ratio?" in text, text

    def test_checks_of_the_build_may_be_waived_beforehand(self, drive: Drive) -> None:
        waivers = tuple(Waiver(check=name, reason="heavier on purpose") for name in BUILD_IDS)
        assert failed(run_checks(replace(drive, waivers=waivers))) == ()


def test_remedies_stop_looking_for_figures_where_everything_fails(drive: Drive) -> None:
    ruin = with_cable(put(drive, "cable.diameter_mm", 5.0), 0, guide_radius_mm=2.0)
    remedies = [r.remedy for r in failed(run_checks(ruin))]
    assert len(remedies) > 20 and all(remedies)
    unsearched = [text.split("; no value was searched")[0] for text in remedies if "no value was searched" in text]
    assert unsearched, remedies
    for text in unsearched:
        fields = [way.split()[-1] for way in text.split(" or ")]
        assert len(set(fields)) == len(fields), text


@pytest.mark.parametrize("layout", ["miso_bevel", "siso_bevel", "siso_spur", "miso_spur"])
def test_advice_names_fields_that_the_design_file_has(layout: str) -> None:
    """What to choose is told by the field that states it; a check that no field corrects says nothing of choosing."""
    schema = mbcdm_cad.schema(layout)
    blocks = {name: _fields_of(schema, node) for name, node in schema["properties"].items()}
    drive = mbcdm_cad.new_design("own", layout).loaded.drive
    told = {c.id: c.advice for c in checks_of(drive) if isinstance(c.advice, str) and c.advice}
    named = {check: re.findall(r"\b([a-z_]+)\.([a-z_]\w+)", text) for check, text in told.items()}
    assert len(told) > 15, told
    for check, fields in named.items():
        assert fields or "choose" not in told[check], (check, told[check])
        assert all(name in blocks.get(block, ()) for block, name in fields), (check, told[check])


def _fields_of(schema: dict[str, Any], node: dict[str, Any]) -> set[str]:
    """Names of the fields of a block of a JSON Schema."""
    if "$ref" in node:
        return _fields_of(schema, schema["$defs"][node["$ref"].rsplit("/", 1)[1]])
    inner = [_fields_of(schema, one) for key in ("anyOf", "allOf", "oneOf") for one in node.get(key, ())]
    return set(node.get("properties", ())).union(*inner)


def test_a_figure_that_is_zero_but_for_rounding_is_zero() -> None:
    """The sine of an angle of 0 is found as 1.5e-8, and ratios agree within 1e-11."""
    angle = CHECKS[0].but(measure=lambda s: at_most("fleet angle", 8.5e-7, 1.5, "deg"))
    found = run_check(angle, layout_of(reference()))
    assert (found.actual, found.margin, found.message) == (0.0, 1.5, "fleet angle 0 deg (limit at most 1.5)")
    for result in run_checks(load_design(OVERRIDES.parent / "siso_spur.yaml")):
        assert not result.limit or result.actual == 0.0 or abs(result.actual or 0.0) > 1e-7 * result.limit, result


BY_ID = {check.id: check for check in CHECKS}
CHANGE = re.compile(r"(?:raise|lower) ([\w.]+) from \S+ to at (?:least|most) ([-\d.e]+)")
SCALE = re.compile(r"scale (?:transmission\.drum_radii_mm|all radii of transmission) by at (?:least|most) ([\d.e]+)")


def assert_sound(drive: Drive) -> None:
    results = run_checks(drive)
    assert len(results) == sum(check.asked_of(drive) for check in CHECKS)
    for r in results:
        assert all(v is None or isfinite(v) for v in (r.actual, r.limit, r.margin)), r
        assert r.message, r
        assert (r.remedy == "") == (r.status == "pass"), r


@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much])
@given(st.integers(0, 2**32), st.integers(1, 12))
@pytest.mark.slow
def test_no_loadable_design_upsets_a_check(seed: int, changes: int) -> None:
    drive = loaded(random_data(random.Random(seed), changes))
    if drive is not None:
        assert_sound(drive)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8))
def test_no_loadable_design_upsets_a_check_by_the_hundred(seed: int) -> None:
    for _, drive in random_drives(seed, 80, changes=3 + seed):
        assert_sound(drive)


def test_the_same_design_gives_the_same_words() -> None:
    _, drive = next(random_drives(5, 1, 6))
    assert run_checks(drive) == run_checks(drive)


def _mended(drive: Drive, remedy: str) -> list[Drive]:
    """The design changed as each of the remedy's offers says."""
    found = [VARIABLES[path].put(drive, float(value)) for path, value in CHANGE.findall(remedy) if path in VARIABLES]
    return found + [VARIABLES[ALL_RADII].put(drive, float(value)) for value in SCALE.findall(remedy)]


@pytest.mark.parametrize(("count", "least"), [(6, 20), pytest.param(40, 130, marks=pytest.mark.slow)])
def test_every_figure_of_a_remedy_mends_its_check(count: int, least: int) -> None:
    tried = 0
    for _, drive in random_drives(100, count, changes=2):
        for r in run_checks(drive):
            # Advice beside the figures may speak of several parameters at once.
            if r.status != "pass" and r.actual is not None and BY_ID[r.id].adjust:
                for mended in _mended(drive, r.remedy):
                    after = run_check(BY_ID[r.id], BevelLayout(mended))
                    tried += 1
                    assert after.status == "pass", (r.id, r.remedy, after.message)
    assert tried > least, tried


def test_a_remedy_names_the_catalogues_rope() -> None:
    found = run_check(BY_ID["land_width"], BevelLayout(put(reference(), "cable.diameter_mm", 1.0)))
    assert "choose a rope of at most 0.9 mm (such as FF-081)" in found.remedy, found.remedy


@pytest.mark.parametrize(("least", "offered"), [(45.0, True), (60.0, False)])
def test_no_remedy_leaves_the_bounds_of_its_field(least: float, offered: bool) -> None:
    """A bridge may be 50 mm thick; the limit of the remedies' own search lies beyond."""
    layout = layout_of(load_design(PARAMS / "siso_spur.yaml").drive)
    stub = BY_ID["walls"].but(
        measure=lambda s: at_least("bridge", s.drive.support.bridge_mm * 3.0, least * 3.0, "mm"),
        adjust=up("support.bridge_mm"),
        advice="",
    )
    layout = layout.with_drive(layout.variables["support.bridge_mm"].put(layout.drive, 20.0))
    assert ("raise support.bridge_mm from 20 to at least 45" in run_check(stub, layout).remedy) == offered


def test_a_hollow_centre_says_which_bearing_or_that_no_ring_encoder_fits() -> None:
    """The remedy is followed to the letter: a bore of 25 mm needs a shaft round which there is no ring encoder."""
    text = (
        "name: hollow\nconfiguration: siso_spur\ntravel: {half_angle_deg: 40}\nloads: {peak_torque_Nm: 1.5}\n"
        "transmission: {input_to_drum: 8, drum_radius_mm: 60}\ndrum: {shaft_bore_mm: 25}\n"
    )
    found, after = (
        run_check(next(check for check in checks_of(drive) if check.id == "shaft_wall"), layout_of(drive))
        for drive in (load_text(t, "hollow.yaml").drive for t in (text, text + "drive: {drum_encoder: none}\n"))
    )
    assert found.status == "fail" and "set drive.drum_encoder to none" in found.remedy, found
    assert after.status == "pass", after


BISECTIONS = 60
# Margins that differ by less are those of one design.
SAME = 5e-9


class Way(NamedTuple):
    """One parameter of the reference design from a value that passes to one that fails."""

    change: Change
    passing: float
    failing: float


def grooved_at_lead(drive: Drive, lead_mm: float) -> Drive:
    """Grooved input pulleys with a helix of this lead."""
    return put(put(drive, "input_pulleys.surface", "grooved"), "helix_lead_mm", lead_mm)


SPRING = SpringSpec(
    name="spring",
    kind="disc",
    outside_mm=5.0,
    inside_mm=2.0,
    strip_mm=0.3,
    free_mm=0.5,
    solid_mm=0.3,
    stiffness_N_mm=1000.0,
    usable_share=0.75,
    mass_g=0.05,
    material="steel",
    source="test",
)


def sprung(path: str) -> Change:
    """A value of the springs, or another one, of the reference with springs."""
    return lambda drive, value: put(put(drive, "spring", SPRING), path, value)


PEAK, TEST = "loads.peak_torque_Nm", "loads.test_torque_Nm"
WAYS: dict[str, Way] = {
    "eq1_guide_drum": Way(radius_of(1, "guide_radius_mm"), 9.6, 9.7),
    "eq1_first_input": Way(radius_of(1, "input_radius_mm"), 6.4, 6.3),
    "eq1_second_input": Way(radius_of(3, "input_radius_mm"), 7.2, 7.3),
    "drum_stress": Way(to("drum_material.yield_MPa"), 503.0, 10.0),
    "payload_screws": Way(to(PEAK), 3.15, 60.0),
    "shaft_stress": Way(to("shaft_material.yield_MPa"), 355.0, 5.0),
    "mounting_screws": Way(to(PEAK), 3.15, 60.0),
    "frame_windup": Way(to("limits.frame_windup_max_mrad"), 0.0232, 0.01),
    "stiffness": Way(to("loads.stiffness_Nm_rad"), 2500.0, 4000.0),
    "structure_share": Way(to("loads.structure_share"), 0.9, 0.3),
    "equal_total_ratio": Way(scaled("input_radius_mm", (2, 3)), 1.0, 1.01),
    "pair_mismatch": Way(radius_of(1, "input_radius_mm"), 6.4, 6.5),
    "surface_radius": Way(scaled("input_radius_mm"), 1.0, 0.2),
    "bend_ratio": Way(to("limits.bend_ratio_min"), 14.8, 20.0),
    "bend_ratio_minimum": Way(to("cable.bend_ratio_minimum"), 10.0, 28.0),
    "bend_ratio_desired": Way(to("cable.bend_ratio_desired"), 10.0, 42.0),
    "anchor_bend": Way(scaled("input_radius_mm"), 1.0, 0.6),
    "pitch_line": Way(radius_of(0, "guide_radius_mm"), 9.0, 9.1),
    "radii_rise": Way(radius_of(1, "drum_radius_mm"), 57.6, 53.0),
    "land_width": Way(to("cable.diameter_mm"), 0.81, 1.0),
    "land_edge": Way(to("clearances.land_edge_mm"), 0.15, 0.0),
    "outermost_land": Way(to("drum.outer_face_y_mm"), 13.0, 11.0),
    "bodies_clear": Way(to("clearances.transfer_gap_mm"), 0.155, 0.01),
    "transfer_gap": Way(to("clearances.transfer_gap_mm"), 0.155, 0.6),
    "centre_distance": Way(to("centre_distance_mm"), 34.6, 17.0),
    "pulley_gap": Way(to("centre_distance_mm"), 34.6, 17.0),
    "guide_wrap": Way(to("centre_distance_mm"), 34.6, 2000.0),
    "fleet_angle": Way(to("helix_lead_mm"), 0.87, 1.0),
    "helix_lead": Way(to("helix_lead_mm"), 0.87, 0.7),
    "groove_walls": Way(grooved_at_lead, 0.9, 0.85),
    "self_clearance": Way(to("helix_lead_mm"), 0.87, 0.8),
    "input_walk": Way(to("helix_lead_mm"), 0.87, 3.0),
    "guide_walk": Way(to("helix_lead_mm"), 0.87, 9.0),
    "dead_turns": Way(to("dead_turns"), 1.0, 0.0),
    "self_clearance_stack": Way(to("making.rope_diameter_share"), 0.0, 0.1),
    "transfer_gap_stack": Way(to("making.position_mm"), 0.02, 0.3),
    "bodies_clear_stack": Way(to("making.run_out_mm"), 0.02, 0.5),
    "land_edge_stack": Way(to("making.position_mm"), 0.0, 0.1),
    "flank_stack": Way(to("cable.diameter_mm"), 0.6, 0.81),
    "guide_walk_stack": Way(to("making.position_mm"), 0.02, 2.0),
    "pair_mismatch_stack": Way(preloaded, 70.0, 12.5),
    "wrap_left": Way(to("half_travel_deg"), 35.0, 65.0),
    "wrap_under_turn": Way(to("half_travel_deg"), 35.0, 300.0),
    "terminal_clears_guide": Way(to("half_travel_deg"), 35.0, 65.0),
    "no_slack": Way(to(PEAK), 3.15, 60.0),
    "life": Way(to("targets.life_cycles"), 2000.0, 20000.0),
    "life_shown": Way(to("targets.life_cycles"), 100.0, 1000.0),
    "tension": Way(to(PEAK), 3.15, 20.0),
    "preload_share": Way(to("limits.preload_share_max"), 0.5, 0.05),
    "cable_ends": Way(to(PEAK), 3.15, 20.0),
    "termination_fits": Way(to("termination.largest_mm"), 6.0, 0.5),
    "sleeve_fits": Way(to("tensioner.swage_diameter_mm"), 2.0, 1.0),
    "preload_bias": Way(preloaded, 40.0, 100.0),
    "motor_torque_forward": Way(to(PEAK), 3.15, 5.0),
    "motor_torque_back": Way(to(PEAK), 3.15, 5.0),
    "gearhead_maximum": Way(to(PEAK), 3.15, 6.0),
    "retension": Way(to("cable.creep_per_decade"), 1e-4, 0.1),
    "motor_losses": Way(to(PEAK), 1.0, 3.15),
    "backdrive": Way(to("loads.backdrive_Nm"), 2.0, 0.3),
    "continuous_torque": Way(to("loads.continuous_torque_Nm"), 0.5, 3.15),
    "gearhead_continuous": Way(to(PEAK), 0.5, 3.15),
    "input_bearings": Way(to("bearings.input_lower.static_rating_N"), 255.0, 10.0),
    "guide_bearings": Way(to("bearings.guide.static_rating_N"), 180.0, 10.0),
    "drum_bearings": Way(to("bearings.drum.static_rating_N"), 570.0, 10.0),
    "quiet_running": Way(to("bearings.guide.static_rating_N"), 300.0, 100.0),
    "drum_bearing_spacing": Way(to("support.back_y_mm"), -14.0, -10.0),
    "coupling_runout": Way(to("pulley_material.youngs_modulus_GPa"), 210.0, 1.0),
    "collar_grip": Way(to(PEAK), 3.15, 20.0),
    "hub_set_screws": Way(to("bearings.drum.outer_diameter_mm"), 16.0, 3e4),
    "stop_pin": Way(to("drum.web_thickness_mm"), 2.0, 20.0),
    "pulley_stress": Way(to("pulley_material.yield_MPa"), 355.0, 5.0),
    "stop_pocket_wall": Way(to("cable.diameter_mm"), 0.81, 4.0),
    "stop_pocket_floor": Way(to("pulley_material.min_wall_mm"), 0.5, 20.0),
    "stop_pocket_bore": Way(to("pulley_material.min_wall_mm"), 0.5, 20.0),
    "bore_wall": Way(to("gearhead.shaft_diameter_mm"), 3.0, 5.0),
    "bearing_shoulders": Way(to("bearings.input_lower.inner_shoulder_mm"), 6.2, 5.0),
    "encoder_fit": Way(to("encoder.bore_mm"), 4.0, 3.0),
    "bought_depth": Way(to("encoder.length_mm"), 14.0, 5.0),
    "shaft_grip": Way(to("gearhead.shaft_length_mm"), 10.0, 6.0),
    "pilot_room": Way(to("gearhead.pilot_height_mm"), 1.0, 9.0),
    "coupling_height": Way(to("support.coupling_space_mm"), 10.6, 5.0),
    "guide_wall": Way(to("bearings.guide.outer_diameter_mm"), 9.0, 19.0),
    "guide_length": Way(to("bearings.guide.width_mm"), 2.5, 8.0),
    "axle_stress": Way(to("axle_material.yield_MPa"), 355.0, 10.0),
    "rim_height": Way(to("drum.rim_inner_radius_mm"), 47.0, 54.0),
    "web_in_rim": Way(to("drum.web_thickness_mm"), 2.0, 6.0),
    "land_thickness": Way(to("clearances.land_edge_mm"), 0.15, 0.6),
    "hub_walls": Way(to("drum.hub_diameter_mm"), 20.0, 10.0),
    "hub_length": Way(to("drum.hub_face_y_mm"), 20.8, 14.0),
    "hub_spigot": Way(to("bearings.drum.inner_shoulder_mm"), 9.5, 8.0),
    "set_screw_tips": Way(to("bearings.drum.bore_mm"), 8.0, 2.5),
    "shaft_wall": Way(to("drum.shaft_bore_mm"), 4.0, 7.9),
    "stop_slot": Way(to("drum.sector_half_angle_deg"), 78.1, 36.0),
    "stop_after_travel": Way(to("stop_clearance_deg"), 0.25, -0.1),
    "stop_within_half_degree": Way(to("stop_clearance_deg"), 0.25, 0.7),
    "terminals_apart": Way(to("tensioner.nut_across_flats_mm"), 3.2, 9.0),
    "lands_intact": Way(to("drum_material.min_internal_radius_mm"), 0.5, 3.0),
    "outer_face": Way(to("drum.outer_face_y_mm"), 13.0, 12.0),
    "pocket_corners": Way(to("drum_material.min_internal_radius_mm"), 0.5, 5.0),
    "stud_stress": Way(to("tensioner.stress_area_mm2"), 1.27, 0.1),
    "take_up": Way(to("tensioner.stud_length_mm"), 12.5, 9.0),
    "thread_at_end": Way(to("tensioner.lug_thickness_mm"), 1.8, 0.2),
    "terminal_angles": Way(radius_of(0, "terminal_angle_rad"), 0.5, 2.0),
    "terminal_twist": Way(to("tensioner.swage_flats_mm"), 1.6, 1.9),
    "lug_stress": Way(to("drum_material.yield_MPa"), 503.0, 10.0),
    "walls": Way(to("support.rib_mm"), 3.0, 0.3),
    "bearing_shelf": Way(to("support.bearing_shelf_mm"), 4.0, 3.0),
    "top_plate": Way(to("support.top_plate_mm"), 3.6, 2.0),
    "engagement": Way(to("support.motor_shelf_mm"), 3.0, 6.0),
    "dowel_engagement": Way(to("support.top_plate_mm"), 3.6, 13.0),
    "front_wall": Way(to("bearings.input_lower.outer_diameter_mm"), 11.0, 14.0),
    "side_wall": Way(to("support.side_wall_mm"), 6.0, 4.0),
    "hole_webs": Way(to("support.side_wall_mm"), 5.6, 4.0),
    "wall_holes": Way(to("support.side_wall_mm"), 5.6, 2.0),
    "key_access": Way(to("gearhead.bolt_circle_mm"), 8.4, 10.0),
    "head_seats": Way(to("gearhead.bolt_circle_mm"), 8.4, 12.0),
    "pulley_corner": Way(to("clearances.running_mm"), 0.25, 1.0),
    "pocket_depth": Way(scaled("input_radius_mm"), 1.0, 1.7),
    "mounts": Way(to("support.coupling_space_mm"), 8.5, 5.0),
    "boss": Way(to("support.back_y_mm"), -14.0, -8.0),
    "encoder_screws": Way(to("drum_encoder.bolt_circle_mm"), 19.6, 17.0),
    "corner_radii": Way(to("frame_material.min_internal_radius_mm"), 0.5, 12.0),
    "drives_apart": Way(to("centre_distance_mm"), 34.6, 19.0),
    "screwdriver": Way(to("encoder.diameter_mm"), 17.0, 30.0),
    "drum_sweep": Way(to("gearhead.diameter_mm"), 16.0, 20.0),
    "frame_front": Way(to("tensioner.swage_diameter_mm"), 2.5, 6.0),
    "collar_space": Way(to("support.back_plate_mm"), 2.6, 9.0),
    "cables_apart": Way(radius_of(1, "drum_radius_mm"), 57.6, 54.2),
    "spans_clear": Way(to("half_travel_deg"), 35.0, 60.0),
    "envelope_x": Way(to("drum.sector_half_angle_deg"), 78.1, 70.0),
    "envelope_z": Way(to("targets.envelope_tolerance_mm"), 0.5, 0.0001),
    "envelope_y": Way(to("drum.hub_face_y_mm"), 20.8, 25.0),
    "spring_fits": Way(sprung("spring.inside_mm"), 2.0, 1.7),
    "spring_flat": Way(sprung("spring.stiffness_N_mm"), 1000.0, 100.0),
    "spring_free": Way(sprung(PEAK), 3.15, 60.0),
    "spring_keeps": Way(sprung("cable.bedding_in_share"), 0.001, 0.02),
    "mass_estimate": Way(to("targets.mass_tolerance_g"), 10.0, 0.1),
}
# Told without a limit, or tried in a test of their own.
OTHERS = {"path_length", "transmission_error", "shaft_twist", "cut_at_pitch", "screw_counts"} | {
    "wrap_slip_test",
    "wrap_slip_peak",
    "spring_hold",
    *("speed", "duty", "seat_temperature"),
}


def test_every_check_has_its_border_tried() -> None:
    assert set(WAYS) | OTHERS == set(BY_ID), set(WAYS) ^ (set(BY_ID) - OTHERS)


def _margin(check: Check, drive: Drive) -> float:
    """Of the figure from its limit; none where it is only told."""
    with np.errstate(all="ignore"):
        found = check.measure(BevelLayout(drive))
    return found.margin if found.sense else np.inf


def _border(margin: Callable[[float], float], passing: float, failing: float) -> tuple[float, float]:
    """Both ends moved together until the margins differ by rounding, or the ends do where the margin jumps.

    By secants that aim a little beyond the border, further where the same end stays twice, and by halves where these do
    not close in.
    """
    inside, outside, stays, stretch = margin(passing), margin(failing), 0, 1.0
    for step in range(BISECTIONS):
        if inside - outside < SAME:
            break
        share = 0.5
        if step % 3 < 2 and np.isfinite(inside - outside):
            stretch = 4.0 * stretch if abs(stays) > 1 else 1.0
            to_border, whole = inside + TOLERANCE, inside - outside
            if stays < 0:
                share = max(0.5, 1.0 - stretch * (whole - to_border + SAME / 3.0) / whole)
            else:
                share = min(0.5, stretch * (to_border + SAME / 3.0) / whole)
        middle = passing + share * (failing - passing)
        found = margin(middle)
        if found >= -TOLERANCE:
            passing, inside, stays = middle, found, max(stays, 0) + 1
        else:
            failing, outside, stays = middle, found, min(stays, 0) - 1
    return passing, failing


@pytest.mark.parametrize("name", WAYS)
def test_one_design_just_passes_and_one_just_fails(name: str) -> None:
    check, way = BY_ID[name], WAYS[name]

    def design(value: float) -> Drive:
        return way.change(reference(), value)

    passing, failing = way.passing, way.failing
    assert _margin(check, design(passing)) >= -TOLERANCE, check.measure(BevelLayout(design(passing)))
    assert _margin(check, design(failing)) < -TOLERANCE, check.measure(BevelLayout(design(failing)))
    passing, failing = _border(lambda value: _margin(check, design(value)), passing, failing)
    good, bad = (run_check(check, BevelLayout(design(value))) for value in (passing, failing))
    assert good.status == "pass" and good.remedy == "", good
    assert bad.status == check.severity, bad
    assert bad.remedy, bad
    # The two designs differ by rounding alone, so the figure must not jump at the border.
    assert good.margin is not None and bad.margin is not None and bad.limit is not None
    jump = good.margin - bad.margin
    assert -1e-8 <= bad.margin < 0.0 <= good.margin + 1e-8 and jump < 1e-6 * max(1.0, abs(bad.limit)), (
        f"{name}: margins {good.margin} and {bad.margin} at {passing} and {failing}"
    )
