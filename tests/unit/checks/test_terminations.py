"""Ends of ropes: the default fits, a wrong one fails a check with a remedy, and every rope fits some terminal."""

from __future__ import annotations

from dataclasses import replace

import pytest
from designs import reference

from mbcdm_cad.checks.result import CheckResult
from mbcdm_cad.checks.run import run_all
from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import load_text, new_design_text
from mbcdm_cad.layouts.miso_bevel.checks import CHECKS
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout

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
    assert "swaged or soldered or potted" in found.remedy, found.remedy
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
