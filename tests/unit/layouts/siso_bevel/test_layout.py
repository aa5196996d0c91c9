"""Geometry of the drive without a guide: cable paths, the one turn of the input, the stop's slot, the frame."""

from dataclasses import replace
from math import cos, degrees, radians, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.checks.run import run_check
from mbcdm_cad.checks.terminals import bodies_of
from mbcdm_cad.layouts.loader import layout_of, new_design_text
from mbcdm_cad.layouts.siso_bevel.bill import bill
from mbcdm_cad.layouts.siso_bevel.cable_path import full_input_turn_deg, stop_of, taken_rad
from mbcdm_cad.layouts.siso_bevel.checks import drum_sweep, highest_ratio, input_under_turn
from mbcdm_cad.layouts.siso_bevel.design_file import DirectDrive
from mbcdm_cad.layouts.siso_bevel.layout import DirectLayout
from mbcdm_cad.layouts.siso_bevel.support import pocket_corner_radius_mm
from mbcdm_cad.layouts.siso_bevel.support.stiffness import frame_compliance, seat_forces
from mbcdm_cad.model.stiffness import unit_tensions_N
from mbcdm_cad.workshop.kernel import bounding_box
from tests.support.checked import failing
from tests.support.reference import ROOT
from tests.support.sliced_cables import assert_joined


def with_ratio(drive: DirectDrive, ratio: float) -> DirectDrive:
    """The drum as it is, the input for another ratio."""
    return replace(drive, cables=tuple(replace(c, input_radius_mm=c.drum_radius_mm / ratio) for c in drive.cables))


def test_params_file_is_what_the_schema_writes() -> None:
    """After a change of schema or reference:
    ``rm params/siso_bevel.yaml && mbcdm init params/siso_bevel.yaml --reference --configuration siso_bevel``."""
    assert (ROOT / "params/siso_bevel.yaml").read_text("utf-8") == new_design_text("siso_bevel", "siso_bevel")


def test_reference_design_fails_no_check(drive: DirectDrive) -> None:
    failed = failing(drive)
    assert not failed, failed


def test_outlines_of_the_terminals_reach_as_far_as_their_solids(drive: DirectDrive, dims: DirectLayout) -> None:
    """They bound the box that is foreseen: a stud's tip has a chamfered edge."""
    own, design = bill(dims), DirectLayout(drive)
    for t in dims.drum.tensioners:
        (item,) = (item for item in own.items if item.name == f"terminal_{t.cable_name}")
        spec = own.parts[item.part]
        low, high = bounding_box(spec.part.solid(), item.location)
        ends = {name: outline for name, outline, _, _ in bodies_of(design, t, moved=False)}["stud"]
        foreseen, drawn = t.side * ends[:, 0], (high if t.side > 0 else low)[0] * t.side
        assert foreseen.max() == pytest.approx(drawn, abs=0.01), f"{t.cable_name}: {foreseen.max()}, drawn {drawn}"


def test_paths_keep_their_length_and_join_without_a_kink(dims: DirectLayout) -> None:
    lengths = []
    for angle in np.radians([-35.0, -10.0, 0.0, 35.0]):
        paths = dims.cable_paths(float(angle))
        lengths.append([path.length_mm for path in paths])
        for path in paths:
            assert_joined(path)
    assert np.ptp(lengths, axis=0) == pytest.approx([0.0, 0.0], abs=1e-9)


@settings(max_examples=60, deadline=None)
@given(radius=st.floats(8.0, 40.0))
def test_end_of_a_full_winding_lets_the_leaving_cable_pass(drive: DirectDrive, radius: float) -> None:
    """By points of winding and bend, a turn less ``taken_rad`` after the transfer, from the straight line y = r."""
    d = drive.cable.diameter_mm
    cable = replace(drive.cables[0], input_radius_mm=radius)
    rho, start = stop_of(drive, cable).bend_radius_mm, taken_rad(drive, cable)
    around = np.linspace(start, start + 1.0, 200)
    wound = radius * np.stack([np.sin(around), np.cos(around)])
    turned = np.linspace(0.0, np.pi / 2, 400)
    u, v = np.array([[sin(start)], [cos(start)]]), np.array([[-cos(start)], [sin(start)]])
    bend = (radius - rho) * u + rho * (np.cos(turned) * u + np.sin(turned) * v)
    for points in (wound, bend):
        gap = np.min(radius - points[1][points[0] > 0.0])
        assert gap >= d + 0.1 - 1e-3, f"{gap} mm to the leaving cable"
    # Beyond the transfer lies the beginning of the winding itself.
    assert np.hypot(*bend[:, bend[0] <= 0.0]).max(initial=0.0) <= radius - d


def test_one_turn_limits_the_ratio_and_the_remedy_names_it(drive: DirectDrive) -> None:
    """i x 70 + 18 + slot <= 360: just over 4.5 here, and a ratio of 9 as in (d) is refused with the figure."""
    check, most = input_under_turn, highest_ratio(drive)
    assert 4.5 < most < 4.6
    for ratio, status in ((most * 0.999, "pass"), (most * 1.001, "fail"), (9.0, "fail")):
        result = run_check(check, DirectLayout(with_ratio(drive, ratio)))
        assert result.status == status, f"{ratio}: {result.message}"
    assert "total ratio of at most 4.5" in result.remedy, result.remedy
    assert "lower transmission.input_to_drum from 9 to at most 4.5" in result.remedy, result.remedy
    slot = degrees(taken_rad(drive, drive.cables[0]))
    assert full_input_turn_deg(drive, drive.cables[0]) == pytest.approx(4.5 * 70.0 + 18.0 + slot)


def test_what_turns_passes_the_encoder_and_stays_below_the_motor(drive: DirectDrive) -> None:
    """A motor of any width finds room over the drum; an encoder wider than the drum's distance does not."""

    def status(changed: DirectDrive) -> str:
        return run_check(drum_sweep, DirectLayout(changed)).status

    wide = replace(drive.motor, diameter_mm=90.0)
    assert status(replace(drive, motor=wide)) == "pass"
    web_y = DirectLayout(drive).drum.lands[0].y_start
    for radius, expected in ((web_y - 0.3, "pass"), (web_y + 0.6, "fail")):
        encoder = replace(drive.encoder, diameter_mm=2 * radius)
        assert status(replace(drive, encoder=encoder)) == expected, f"encoder {radius} mm, rim at {web_y} mm"


def test_corners_of_a_printed_frame_are_no_cutters(drive: DirectDrive) -> None:
    printed = replace(drive.frame_material, process="printed")
    deep = 80.0
    assert pocket_corner_radius_mm(drive, deep) == pytest.approx(deep / 8)
    assert pocket_corner_radius_mm(replace(drive, frame_material=printed), deep) == 2.0


def test_every_item_joins_once_in_the_order_of_assembly(dims: DirectLayout) -> None:
    joined = [name for step in dims.assembly_order for name in step.items]
    assert sorted(joined) == sorted(item.name for item in bill(dims).items)


def test_pulley_turns_with_the_drum_and_its_stops_stay_on_their_cables(dims: DirectLayout) -> None:
    """The stop drawn in the pulley's frame lies on the end of its cable's path at any drum angle."""
    for angle in (-35.0, 0.0, 20.0):
        places = {item.name: item.location for item in bill(dims, angle).items}
        for path in dims.cable_paths(radians(angle)):
            start = places[f"stop_{path.cable.name}"].shift_mm
            chord = path.piece("chord")
            ends = chord.points(np.array([0.0, 1.0]))
            along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
            off = start - ends[0]
            assert np.linalg.norm(off - (off @ along) * along) < 1e-9, f"{path.cable.name} at {angle} deg"


def test_forces_of_1_Nm_leave_the_mounts_its_moment_alone(dims: DirectLayout) -> None:
    forces = seat_forces(dims, unit_tensions_N(layout_of(dims.drive).si))
    assert sum(f for _, _, f, _ in forces) == pytest.approx(0.0, abs=1e-9)
    assert sum(p[2] * f for _, p, f, _ in forces) * 1e-3 == pytest.approx(-1.0, rel=1e-9)
    assert sum(c - p[1] * f for _, p, f, c in forces) * 1e-3 == pytest.approx(0.0, abs=1e-9)


@pytest.mark.slow
def test_thicker_walls_turn_less(drive: DirectDrive) -> None:
    def windup(**walls: float) -> float:
        return frame_compliance(DirectLayout(replace(drive, support=replace(drive.support, **walls)))).windup_urad_Nm

    now = windup()
    assert 20.0 < now < 45.0, f"{now} urad per N m"
    for walls in ({"rib_mm": 7.0}, {"back_plate_mm": 5.0, "back_y_mm": -19.3}, {"encoder_shelf_mm": 4.5}):
        assert windup(**walls) < now, walls
