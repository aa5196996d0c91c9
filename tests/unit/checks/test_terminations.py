"""Ends of ropes: the default fits, a wrong one fails a check with a remedy, and every rope fits some terminal."""

from __future__ import annotations

from dataclasses import replace

import pytest
from designs import reference

from mbcdm_cad.checks.comparison import CheckResult
from mbcdm_cad.checks.run import run_all
from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import layout_of, load_text, new_design_text
from mbcdm_cad.layouts.miso_bevel.checks import CHECKS
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from tests.support.checked import failing

ROPES = package_entries("ropes")
OWN_MODULUS = ("  modulus_GPa:", "  modulus_area:")


def _with_rope(rope: str, termination: str = "") -> Drive:
    """The reference drive on another rope, with the rope's own modulus."""
    lines = new_design_text("reference").splitlines()
    kept = [line for line in lines if not line.startswith(OWN_MODULUS)]
    text = "\n".join(line.replace("type: FF-081", f"type: {rope}") for line in kept) + "\n"
    if termination:
        text = text.replace("  friction_coefficient:", f"  termination: {termination}\n  friction_coefficient:")
    return load_text(text).drive


def _result(drive: Drive, check_id: str) -> CheckResult:
    return next(r for r in run_all(CHECKS, BevelLayout(drive)) if r.id == check_id)


@pytest.mark.parametrize("rope", ROPES)
def test_every_rope_of_the_package_has_an_end_and_a_terminal_that_fit(rope: str) -> None:
    drive = _with_rope(rope)
    assert drive.termination.fits(drive.cable), (rope, drive.termination.name)
    d, end = drive.cable.diameter_mm, drive.termination
    fitting = [n for n, t in package_entries("tensioners").items() if t["swage_diameter_mm"] >= end.sleeve_ratio * d]
    assert fitting, f"{rope}: no sleeve of {end.sleeve_ratio * d:.2f} mm"


def test_the_default_follows_the_construction() -> None:
    names = {rope: _with_rope(rope).termination.name for rope in ROPES}
    wires = {names[rope] for rope, entry in ROPES.items() if entry["construction"] != "braid"}
    assert wires == {"swaged"}, names
    thick = {names[r] for r, e in ROPES.items() if e["construction"] == "braid" and e["diameter_mm"] >= 1.0}
    thin = {names[r] for r, e in ROPES.items() if e["construction"] == "braid" and e["diameter_mm"] < 1.0}
    assert (thick, thin) == ({"spliced"}, {"potted"}), names


def test_a_wire_rope_cannot_be_spliced_and_the_remedy_says_what_can_be_done() -> None:
    found = _result(_with_rope("FF-081", "spliced"), "termination_fits")
    assert found.status == "fail" and "not on 7x7" in found.message, found
    assert "swaged or crimped or soldered or ball or potted or clamped" in found.remedy, found.remedy
    assert _result(_with_rope("FF-081", "soldered"), "termination_fits").status == "pass"


def test_a_weaker_end_holds_less() -> None:
    strong, weak = (_result(_with_rope("FF-081", name), "cable_ends") for name in ("swaged", "potted"))
    assert strong.actual is not None and weak.actual is not None
    assert weak.actual / strong.actual == pytest.approx(0.6 / 0.9), (strong, weak)


def test_a_rope_too_thick_for_the_sleeve_is_told_which_terminal_takes_it() -> None:
    found = _result(_with_rope("7x7-2.4"), "sleeve_fits")
    assert found.status == "fail" and found.remedy == "choose drum.tensioner: M4", found
    thick = replace(reference(), cable=replace(reference().cable, diameter_mm=20.0))
    assert "thinner rope" in _result(thick, "sleeve_fits").remedy


def test_an_unknown_termination_is_named() -> None:
    with pytest.raises(InputError, match="not in the catalogue of terminations"):
        _with_rope("FF-081", "glued")


SHORT = """name: ends
configuration: {layout}
travel: {{half_angle_deg: 35.0}}
{transmission}
loads: {{peak_torque_Nm: 2.0}}
rope: {{{rope}}}
"""
SPUR = "transmission: {input_to_drum: 8.0}"


def _short(rope: str, layout: str = "siso_spur", transmission: str = SPUR) -> Drive:
    return load_text(SHORT.format(layout=layout, transmission=transmission, rope=rope)).drive


@pytest.mark.parametrize("end", [n for n, e in package_entries("terminations").items() if "7x7" in e["constructions"]])
def test_an_end_holds_its_share_of_the_rope(end: str) -> None:
    drive = _with_rope("7x7-1.0", end)
    highest = layout_of(drive).loads.highest_N
    held = package_entries("terminations")[end]["strength_share"] * 808.0 / highest
    assert _result(drive, "cable_ends").message.startswith(f"{end} "), end
    at_terminal = float(_result(drive, "cable_ends").message.split("N over")[0].split(":")[1]) / highest
    assert at_terminal == pytest.approx(held, rel=1e-3), (end, at_terminal, held)


@pytest.mark.parametrize(("end", "rope"), [("knotted", "7x7"), ("clamped", "braid"), ("crimped", "braid")])
def test_an_end_that_its_rope_does_not_stand_is_refused_with_those_that_fit(end: str, rope: str) -> None:
    drive = _with_rope("FF-081" if rope == "7x7" else "uhmwpe-1", end)
    found = _result(drive, "termination_fits")
    assert found.status == "fail" and f"not on {rope}" in found.message, found
    assert end not in found.remedy and ("swaged" if rope == "7x7" else "spliced") in found.remedy, found.remedy


@pytest.mark.parametrize(
    ("layout", "transmission", "end", "kind"),
    [
        ("siso_spur", SPUR, "knotted", "braid"),
        ("siso_spur", SPUR, "clamped", "7x7"),
        ("miso_spur", SPUR, "crimped", "7x7"),
        ("siso_bevel", "transmission: {drum_radius_mm: 80.0, input_to_drum: 4.0}", "ball", "7x7"),
        ("miso_bevel", "transmission: {drum_radius_mm: 54.0, ratio: 9.0}", "crimped", "7x7"),
    ],
)
def test_ends_by_name_choose_rope_and_terminal(layout: str, transmission: str, end: str, kind: str) -> None:
    drive = _short(f"termination: {end}", layout, transmission)
    failed = failing(drive)
    assert drive.cable.construction == kind, drive.cable.name
    assert not failed.keys() & {"cable_ends", "termination_fits", "sleeve_fits", "take_up", "tension"}, failed


def test_a_knot_takes_rope_and_take_up_and_says_how_it_is_tied() -> None:
    spliced, knotted = (
        _short(f"type: uhmwpe-1, preload_N: 10.0, termination: {end}") for end in ("spliced", "knotted")
    )
    plans = [layout_of(drive).tensioning for drive in (spliced, knotted)]
    a, b = (plan.cables[0] for plan in plans)
    entry = package_entries("terminations")["knotted"]
    # One end a side of the one cable; the rope is 1 mm thick.
    assert b.need.setting_m == pytest.approx(entry["setting_ratio"] * 1e-3), b
    assert b.need.total_m - a.need.total_m == pytest.approx(entry["setting_ratio"] * 1e-3, rel=0.05), (a, b)
    beyond = [(s.cut_length_m - s.finished_m) * 1e3 for s in (a, b)]
    assert beyond[1] - beyond[0] > 0.9 * entry["tail_ratio"], beyond
    words = " ".join(step.text for step in layout_of(knotted).assembly_order)
    assert entry["making"] in words and "knotted" in words
    assert entry["making"] not in " ".join(step.text for step in layout_of(spliced).assembly_order)
