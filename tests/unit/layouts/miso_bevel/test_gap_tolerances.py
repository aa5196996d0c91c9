"""Stack-ups of miso_bevel's gaps compared with small changes of the gaps, computed independently."""

from dataclasses import replace
from math import radians, tan

import numpy as np
import pytest
from hypothesis import assume, given, settings

from mbcdm_cad.checks.transfer import TransferStacks, ratio_contributions
from mbcdm_cad.layouts.miso_bevel import gap_tolerances as gaps
from mbcdm_cad.layouts.miso_bevel.cable_path import fleet_angle_deg
from mbcdm_cad.layouts.miso_bevel.checks.spans import stacks, straight_span_clearance_mm
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive, BevelRun
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.model.equations import pair_mismatch_m
from mbcdm_cad.model.tolerance import Contribution, linear_error, tolerance_stack
from mbcdm_cad.parts.fits import radius_band_mm
from mbcdm_cad.parts.making import model_tolerances

from .designs import drives, reference


def _per_unit(found: tuple[Contribution, ...], name: str) -> float:
    return next(c.per_unit for c in found if c.name == name)


def _with(drive: BevelDrive, cable: BevelRun, **changes: float) -> tuple[BevelDrive, BevelRun]:
    changed = replace(cable, **changes)  # type: ignore[arg-type]
    return replace(drive, cables=tuple(changed if c is cable else c for c in drive.cables)), changed


@settings(max_examples=30, deadline=None)
@given(drives())
def test_closed_form_of_the_self_clearance_is_that_of_the_search(drive: BevelDrive) -> None:
    """For leads and slopes as designs have them: both small against the pulley."""
    for cable in drive.cables:
        try:
            searched = straight_span_clearance_mm(drive, cable)
        except ValueError:
            assume(False)
        lead = drive.helix_lead_mm
        slope = tan(radians(fleet_angle_deg(drive, cable)))
        assume(lead < cable.input_radius_mm / 3 and slope < 0.1)
        found, _ = gaps.self_clearance(drive, cable)
        assert found == pytest.approx(searched, abs=0.01 * lead), (found, searched)


def test_what_each_tolerance_does_to_the_self_clearance() -> None:
    """Against differences of the searched clearance; the slope of the span moves with the centre distance."""
    drive = reference()
    for cable in drive.cables:
        _, found = gaps.self_clearance(drive, cable)
        h = 1e-4

        def clearance(d: BevelDrive, c: BevelRun) -> float:
            return straight_span_clearance_mm(d, c)

        thick = replace(drive, cable=replace(drive.cable, diameter_mm=drive.cable.diameter_mm + h))
        thicker = (clearance(*_with(thick, cable)) - clearance(drive, cable)) / h
        assert _per_unit(found, "rope's diameter") == pytest.approx(thicker, abs=0.02)
        far = replace(drive, centre_distance_mm=drive.centre_distance_mm + h)
        further = (clearance(far, cable) - clearance(drive, cable)) / h
        assert _per_unit(found, "centre distance") == pytest.approx(further, rel=0.1)


def test_a_pair_disagrees_by_what_its_radii_are_off() -> None:
    """Against the model's mismatch of a drive with that one radius off."""
    drive = reference()
    pair = (drive.cables[0], drive.cables[1])
    found = gaps.pair_path_contributions(drive, pair)
    for cable in pair:
        for field, name in (("drum_radius_mm", "drum radius"), ("input_radius_mm", "input radius")):
            off, _ = _with(drive, cable, **{field: getattr(cable, field) + 0.01})
            si = layout_of(off).si
            # The drum at the end of its travel where the input's own radii put it.
            angle = radians(drive.half_travel_deg) * si.total_ratio[:1]
            length = float(np.abs(pair_mismatch_m(si, np.array([angle, angle]))[0]).max()) * 1e3
            expected = 0.01 * _per_unit(found, f"{name} of {cable.name}")
            # Told at the second cable's land, with the drum where the first wants it.
            lever = pair[1].drum_radius_mm / cable.drum_radius_mm
            assert length == pytest.approx(expected * lever, rel=0.01), (cable.name, field)


def test_ratio_of_a_drive_with_one_size_off() -> None:
    drive = reference()
    cable = drive.cables[2]
    found = ratio_contributions(drive, cable)
    ratio = cable.drum_radius_mm / cable.input_radius_mm
    h = 1e-5
    thick = (cable.drum_radius_mm + h / 2) / (cable.input_radius_mm + h / 2)
    small = cable.drum_radius_mm / (cable.input_radius_mm + h)
    assert _per_unit(found, "rope's diameter") == pytest.approx((thick / ratio - 1) / h, rel=1e-4)
    assert _per_unit(found, "input radius") == pytest.approx((small / ratio - 1) / h, rel=1e-4)


def test_play_and_run_out_shrink_the_transfer_gap_as_a_displaced_guide_does() -> None:
    """Every part drawn at random within its tolerance: the gap between the two circles moves as the stack says."""
    drive = reference()
    cable, making = drive.cables[0], drive.making
    rng = np.random.default_rng(1)
    n = 100_000
    guide = rng.uniform(-1, 1, (4, n))
    surface = (
        cable.guide_radius_mm
        + guide[0] * radius_band_mm(cable.guide_radius_mm - drive.cable.diameter_mm / 2, "land")
        + guide[1] * making.run_out_mm / 2
        + guide[2] * making.bearing_play_mm / 2
        + guide[3] * making.position_mm
    )
    drum = rng.uniform(-1, 1, (3, n))
    face = cable.guide_radius_mm + 1.0 + (drum[0] + drum[1]) * making.position_mm + drum[2] * making.run_out_mm / 2
    stack = TransferStacks("guide", "axle").contributions(drive, cable)
    assert np.std(face - surface) * np.sqrt(3.0) == pytest.approx(np.sqrt(sum(c.shift**2 for c in stack)), rel=0.01)


def test_stacks_stand_in_the_order_of_the_gaps_and_name_what_costs_most() -> None:
    found = list(stacks(BevelLayout(reference())))
    assert len(found) == 7
    clearance, flank = found[0], found[4]
    assert clearance.costliest.name == "rope's diameter", clearance
    assert 0.0 < clearance.margin < clearance.rss < clearance.worst_case, "7 um are no clearance with real rope"
    assert flank.figure.startswith("flank of"), flank


def test_linear_error_of_the_check_is_that_of_the_study() -> None:
    drive = reference()
    si, sizes, half = layout_of(drive).si, model_tolerances(drive), radians(drive.half_travel_deg)
    names, error = linear_error(si, half, sizes, poses=31)
    study = tolerance_stack(si, half, sizes, draws=2, poses=31)
    assert names == study.contributor
    assert np.sqrt((error**2).mean(axis=1)) == pytest.approx(study.contribution_rad, abs=1e-15)
    assert sizes.drum_eccentricity_m == pytest.approx(drive.making.run_out_mm / 4e3)
