"""Run of all checks: the reference passes; waivers; checks without a figure."""

from __future__ import annotations

import re
from dataclasses import replace
from math import isfinite
from pathlib import Path
from textwrap import dedent
from typing import Any

import pytest
import yaml
from designs import put, reference, with_cable

import mbcdm_cad
from mbcdm_cad.checks.comparison import CheckResult, at_most, failed
from mbcdm_cad.checks.run import run_check
from mbcdm_cad.checks.size import BUILD_IDS
from mbcdm_cad.design.blocks import Waiver
from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.check_design import checks_of, known_ids, run_checks
from mbcdm_cad.layouts.loader import layout_of, load_design, load_text, reference_data
from mbcdm_cad.layouts.miso_bevel.checks import CHECKS
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout

PARAMS = Path(__file__).parents[3] / "params" / "mbcdm.yaml"


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
    results = run_checks(load_design(PARAMS))
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
    for result in run_checks(load_design(PARAMS.parent / "siso_spur.yaml")):
        assert not result.limit or result.actual == 0.0 or abs(result.actual or 0.0) > 1e-7 * result.limit, result
