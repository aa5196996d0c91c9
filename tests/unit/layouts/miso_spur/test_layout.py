"""Geometry of several inputs round one drum: paths, grooves, sectors, dowels, frame, rules of the design file."""

from collections.abc import Callable
from dataclasses import replace
from math import degrees, pi

import numpy as np
import pytest

from mbcdm_cad.checks.run import run_check
from mbcdm_cad.layouts.loader import load_text, new_design_text
from mbcdm_cad.layouts.miso_spur.checks import SECTORS
from mbcdm_cad.layouts.miso_spur.layout import RoundDrumLayout
from mbcdm_cad.layouts.siso_spur.bill import bill
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive
from mbcdm_cad.layouts.siso_spur.support.stiffness import frame_compliance
from tests.support.checked import failing
from tests.support.reference import ROOT
from tests.support.sliced_cables import assert_joined

Made = Callable[[int], SpurDrive]


def test_params_file_is_what_the_schema_writes() -> None:
    """After a change of schema or reference:
    ``rm params/miso_spur.yaml && mbcdm init params/miso_spur.yaml --reference --configuration miso_spur``."""
    assert (ROOT / "params/miso_spur.yaml").read_text("utf-8") == new_design_text("miso_spur", "miso_spur")


def test_reference_design_fails_no_check(drive: SpurDrive) -> None:
    failed = failing(drive)
    assert not failed, failed


@pytest.mark.parametrize("count", [3, 4])
def test_more_inputs_fail_no_check_further_out(with_inputs: Made, count: int) -> None:
    failed = failing(with_inputs(count))
    assert not failed, failed


@pytest.mark.parametrize("count", [2, 3, 4])
def test_cables_keep_their_length_and_join_without_a_kink(with_inputs: Made, count: int) -> None:
    dims = RoundDrumLayout(with_inputs(count))
    centred = [path.length_mm for path in dims.cable_paths(0.0)]
    for angle in np.radians([-35.0, 12.0, 35.0]):
        for path, length in zip(dims.cable_paths(float(angle)), centred, strict=True):
            assert path.length_mm == pytest.approx(length, abs=1e-9)
            assert_joined(path)


def test_anchored_cables_fail_no_check_and_end_in_their_stops(anchored: RoundDrumLayout) -> None:
    """Two for each input; the end of each lies at the far end of the stop that the bill places for it."""
    failed = failing(anchored.drive)
    assert not failed, failed
    slots = [slot for pulley in anchored.inputs for slot in pulley.slots]
    for angle in (-35.0, 20.0):
        items = {item.name: item for item in bill(anchored, angle).items}
        paths = anchored.cable_paths(np.radians(angle))
        assert [path.cable.name for path in paths] == [slot.cable_name for slot in slots]
        for slot, path in zip(slots, paths, strict=True):
            stop = np.array([[0.0, 0.0, slot.stop_start - slot.stop_end]])
            end = path.line[0].points(np.array([0.0]))[0]
            assert items[f"stop_{slot.cable_name}"].location.apply(stop)[0] == pytest.approx(end, abs=1e-9)


def test_each_cable_lies_in_its_groove_at_every_angle(dims: RoundDrumLayout) -> None:
    """In each pulley's own frame the wound cable follows the groove's helix, at the level of its sector."""
    for angle in (-35.0, 0.0, 20.0, 35.0):
        items = {item.name: item for item in bill(dims, angle).items}
        for pulley, path in zip(dims.inputs, dims.cable_paths(np.radians(angle)), strict=True):
            groove = pulley.grooves[0]
            own = items[f"input_pulley_{pulley.name}"].location.inverse.apply(
                path.piece("wound").points(np.linspace(0.0, 1.0, 60))
            )
            assert np.hypot(own[:, 0], own[:, 1]) == pytest.approx(groove.root_radius + 0.405, abs=1e-9)
            at = groove.start_angle_rad + (own[:, 2] - groove.start_z) / (groove.lead / (2 * pi))
            off = np.arctan2(own[:, 1], own[:, 0]) - at
            assert np.abs(np.angle(np.exp(1j * off))).max() < 1e-9
            assert groove.start_angle_rad < at.min() and at.max() < groove.end_angle_rad


def test_cables_end_in_their_terminals(dims: RoundDrumLayout) -> None:
    """The end of each drawn cable lies on the axis of the terminal that the bill places for it."""
    for angle in (-35.0, 0.0, 35.0):
        items = {item.name: item for item in bill(dims, angle).items}
        for unit, path in zip(dims.units, dims.cable_paths(np.radians(angle)), strict=True):
            first, second = unit.drive.cables
            for cable, end in (
                (first, path.pieces[0][1].points(np.array([0.0]))[0]),
                (second, path.line[-1].points(np.array([1.0]))[0]),
            ):
                own = items[f"terminal_{cable.name}"].location.inverse.apply(end)
                assert np.hypot(own[0], own[1]) < 1e-9, f"{cable.name} at {angle}: {own}"


@pytest.mark.parametrize("count", [2, 3, 4])
def test_dowels_meet_the_holes_of_both_hubs(with_inputs: Made, count: int) -> None:
    """Holes in the back of a sector stand before those in the face of the one behind it, in the frame of the drum."""
    dims = RoundDrumLayout(with_inputs(count))
    pins = dims.dowels
    turn = 360.0 / count
    behind = {round((a) % 360.0, 6) for a in pins.face_angles_deg}
    before = {round((a + turn) % 360.0, 6) for a in pins.back_angles_deg}
    assert behind == before
    reach = dims.drum.hub_start_y + dims.drive.pitch_mm - dims.drum.hub_face_y
    assert pins.length - pins.face_depth - reach < pins.back_depth, "the dowel stands up before the hubs meet"


def test_every_item_joins_once_in_the_order_of_assembly(
    with_inputs: Made, dims: RoundDrumLayout, anchored: RoundDrumLayout
) -> None:
    for each in (dims, RoundDrumLayout(with_inputs(4)), anchored):
        joined = [name for step in each.assembly_order for name in step.items]
        assert sorted(joined) == sorted(item.name for item in bill(each).items)


@pytest.mark.parametrize(
    ("check", "change", "status"),
    [
        ("sectors_clear_inputs", {"centre_distance_mm": 70.0}, "fail"),
        ("sectors_clear_inputs", {"centre_distance_mm": 74.0}, "pass"),
        ("heads_apart", {"centre_distance_mm": 74.0}, "pass"),
    ],
)
def test_sectors_against_their_limits(with_inputs: Made, check: str, change: dict[str, float], status: str) -> None:
    """With three inputs the terminals of each sector come round to the others'."""
    found = next(c for c in SECTORS if c.id == check)
    result = run_check(found, RoundDrumLayout(replace(with_inputs(3), **change)))
    assert result.status == status, result.message


@pytest.mark.parametrize(
    ("check", "change"),
    [
        ("sectors_apart", {"outer_face_y_mm": 9.0, "hub_face_y_mm": 5.0}),
        ("hub_dowels", {"hub_diameter_mm": 13.0}),
        ("dowel_holes", {"hub_diameter_mm": 13.0}),
    ],
)
def test_drum_against_its_limits(drive: SpurDrive, check: str, change: dict[str, float]) -> None:
    found = next(c for c in SECTORS if c.id == check)
    assert run_check(found, RoundDrumLayout(drive)).status == "pass"
    # Thrice the load shears what holds the reference's.
    loads = replace(drive.loads, peak_torque_Nm=3 * drive.loads.peak_torque_Nm)
    worse = replace(drive, loads=loads, drum=replace(drive.drum, **change))
    result = run_check(found, RoundDrumLayout(worse))
    assert result.status == "fail", result.message


def test_inputs_and_sides_are_counted() -> None:
    text = new_design_text("x", "miso_spur")
    with pytest.raises(Exception, match="take configuration siso_spur for one input"):
        load_text(text.replace("  - {name: lower}\n", ""))
    with pytest.raises(Exception, match="the cable of input lower has not two sides that run apart"):
        load_text(
            text.replace("{name: lower_2, input: lower, drum_side: -x}", "{name: lower_2, input: lower, drum_side: +x}")
        )


@pytest.mark.slow
def test_frame_and_drum_as_heavy_as_drawn(with_inputs: Made) -> None:
    """With three inputs, whose arms share metal next to the axis."""
    parts = bill(RoundDrumLayout(with_inputs(3))).parts
    for name in ("frame", "drum"):
        drawn = parts[name].part.solid().Volume()
        assert parts[name].part.volume_mm3() == pytest.approx(drawn, rel=0.01), name


@pytest.mark.slow
def test_arms_of_the_frame_joined_bend_less_than_alone(dims: RoundDrumLayout, with_inputs: Made) -> None:
    """Two arms in line as one mesh, against the upper bound of each by itself."""
    alone = [frame_compliance(unit).windup_urad_Nm for unit in dims.units]
    together = frame_compliance(dims).windup_urad_Nm
    assert 0.8 * sum(alone) / 4 < together <= 1.001 * sum(alone) / 4, f"{together} of {alone}"
    assert np.isfinite(frame_compliance(RoundDrumLayout(with_inputs(3))).windup_urad_Nm)


def test_levels_are_one_pitch_apart(dims: RoundDrumLayout) -> None:
    drive = dims.drive
    assert [degrees(a) for a in drive.angles_rad] == [0.0, 180.0]
    assert drive.pitch_mm == pytest.approx(dims.drum.hub_face_y - dims.drum.spigot_y)
    wound = [path.piece("wound").points(np.array([0.0, 1.0]))[:, 1].mean() for path in dims.cable_paths(0.0)]
    assert wound == pytest.approx(list(drive.levels_mm), abs=1e-9)
