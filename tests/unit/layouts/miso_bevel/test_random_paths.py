"""Laws of the cable paths over random radii, centre distances, leads, travels and sides."""

from itertools import pairwise
from math import atan2, degrees, hypot, pi, radians, tau

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.layouts.miso_bevel.cable_path import axial_walk_mm, cable_path, fleet_angle_deg, winding
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive, BevelRun
from mbcdm_cad.routes.curves import Arc, Helix

from .designs import drives, mirrored
from .test_cable_path import crossing_tangent, span_length

FRACTIONS = st.floats(-1.0, 1.0)
ANCHOR = 2.5  # rad, beyond any travel drawn here


def each(drive: BevelDrive, fraction: float) -> list[tuple[BevelRun, float]]:
    theta = fraction * radians(drive.half_travel_deg)
    return [(c, theta) for c in drive.cables]


@settings(max_examples=60, deadline=None)
@given(drives(), FRACTIONS)
def test_every_joint_is_smooth(drive: BevelDrive, fraction: float) -> None:
    for cable, theta in each(drive, fraction):
        pieces = cable_path(drive, cable, ANCHOR, 4.0, theta).pieces
        for (before, a), (after, b) in pairwise(pieces):
            gap = np.abs(a.points(np.array([1.0]))[0] - b.points(np.array([0.0]))[0]).max()
            kink = np.linalg.norm(a.tangent(1.0) - b.tangent(0.0))
            assert gap < 1e-10, f"{cable.name}, {before} to {after}: gap {gap:.3g} mm"
            assert kink < 1e-7, f"{cable.name}, {before} to {after}: kink {kink:.3g} rad"


@settings(max_examples=60, deadline=None)
@given(drives())
def test_tangents_cross_between_pulley_and_guide(drive: BevelDrive) -> None:
    for cable in drive.cables:
        on_pulley, on_guide = crossing_tangent(drive, cable)
        w = winding(drive, cable)
        landing = cable.guide_radius_mm * np.array([np.cos(w.guide_landing_rad), np.sin(w.guide_landing_rad)])
        assert np.abs(landing - on_guide).max() < 1e-9 * drive.centre_distance_mm
        assert abs(np.linalg.norm(on_pulley - on_guide) - w.free_span_mm) < 1e-9 * drive.centre_distance_mm
        # Round the guide in its sense, the wrap ends at the +y point and is less than a turn.
        end = w.guide_landing_rad + w.guide_sense * w.guide_wrap_rad
        assert abs((end - pi / 2 + pi) % tau - pi) < 1e-9
        assert 0 < w.guide_wrap_rad < tau


@settings(max_examples=60, deadline=None)
@given(drives(), FRACTIONS)
def test_cables_of_eq_1_do_not_stretch(drive: BevelDrive, fraction: float) -> None:
    """First order: nothing. Second order: the helix's slope on the length wound, and the slope of the span."""
    lead = drive.helix_lead_mm
    for cable, theta in each(drive, fraction):
        path, centred = (cable_path(drive, cable, ANCHOR, 4.0, a) for a in (theta, 0.0))
        unrolled, r = cable.drum_side * theta * cable.drum_radius_mm, cable.input_radius_mm
        span = winding(drive, cable).free_span_mm
        blend = min(2.5 * drive.cable.diameter_mm, 0.3 * span)
        spans = [span_length(span, -lead / (tau * r), -a / r * lead / tau, blend) for a in (unrolled, 0.0)]
        expected = unrolled * (1 - hypot(r, lead / tau) / r) + spans[0] - spans[1]
        change = path.length_mm - centred.length_mm
        assert abs(change - expected) < 1e-7, f"{cable.name}: {change:.9f} against {expected:.9f} mm"


@settings(max_examples=60, deadline=None)
@given(drives(), FRACTIONS, FRACTIONS)
def test_winding_is_one_helix_in_the_pulleys_frame(drive: BevelDrive, first: float, second: float) -> None:
    for cable in drive.cables:
        seen = []
        for fraction in (first, second):
            theta = fraction * radians(drive.half_travel_deg)
            helix = cable_path(drive, cable, ANCHOR, 4.0, theta).piece("helix")
            assert isinstance(helix, Helix)
            turned = theta * cable.drum_radius_mm / cable.input_radius_mm
            seen.append(
                (
                    helix.angle_start - turned,
                    helix.z_start,
                    (helix.z_end - helix.z_start) / (helix.angle_end - helix.angle_start),
                )
            )
        assert np.abs(np.subtract(*seen)).max() < 1e-9, f"{cable.name}: {seen}"


@settings(max_examples=40, deadline=None)
@given(drives())
def test_fleet_angle_is_that_of_the_steepest_span(drive: BevelDrive) -> None:
    half = radians(drive.half_travel_deg)
    for cable in drive.cables:
        span = winding(drive, cable).free_span_mm
        slopes = [abs(axial_walk_mm(drive, cable, f * half)) / span for f in np.linspace(-1, 1, 41)]
        assert abs(fleet_angle_deg(drive, cable) - degrees(atan2(max(slopes), 1.0))) < 1e-9


@settings(max_examples=40, deadline=None)
@given(drives(), FRACTIONS)
def test_the_mirror_image_is_the_mirror_image(drive: BevelDrive, fraction: float) -> None:
    """x -> -x with the drum turned the other way."""
    other = mirrored(drive)
    for (cable, theta), twin in zip(each(drive, fraction), other.cables, strict=True):
        here = cable_path(drive, cable, ANCHOR, 4.0, theta).sample(2.0)
        there = cable_path(other, twin, ANCHOR, 4.0, -theta).sample(2.0)
        assert np.abs(here * [-1, 1, 1] - there).max() < 1e-9, cable.name


@settings(max_examples=40, deadline=None)
@given(drives(), FRACTIONS)
def test_wrapped_pieces_keep_their_radius(drive: BevelDrive, fraction: float) -> None:
    for cable, theta in each(drive, fraction):
        path = cable_path(drive, cable, ANCHOR, 4.0, theta)
        drum = path.piece("drum")
        assert isinstance(drum, Arc)
        points = drum.points(np.linspace(0, 1, 9))
        assert np.abs(np.hypot(points[:, 0], points[:, 2]) - cable.drum_radius_mm).max() < 1e-9
        assert np.abs(points[:, 1] - cable.guide_radius_mm).max() < 1e-12
        around = path.piece("guide").points(np.linspace(0, 1, 9))
        assert np.abs(np.hypot(around[:, 0], around[:, 1]) - cable.guide_radius_mm).max() < 1e-9
        assert np.abs(around[:, 2] - cable.drum_radius_mm).max() < 1e-12
