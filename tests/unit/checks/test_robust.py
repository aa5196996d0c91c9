"""For every design that loads each check gives a finite number or a message, and never raises; remedies work."""

from __future__ import annotations

import random
import re
from math import isfinite
from pathlib import Path

import pytest
from designs import put, reference
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from loadable_designs import loaded, random_data, random_drives

from mbcdm_cad.checks.comparison import at_least
from mbcdm_cad.checks.design_variables import ALL_RADII, up
from mbcdm_cad.checks.run import run_check
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.check_design import checks_of, run_checks
from mbcdm_cad.layouts.loader import layout_of, load_design, load_text
from mbcdm_cad.layouts.miso_bevel.checks import CHECKS
from mbcdm_cad.layouts.miso_bevel.layout import VARIABLES, BevelLayout

PARAMS = Path(__file__).parents[3] / "params"
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
        adjust=(up("support.bridge_mm"),),
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
