"""Two cables anchored on input and drum: their paths, the grooves and slots under them, and their checks."""

from dataclasses import replace
from math import degrees, pi, radians, tau

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbcdm_cad.checks.run import run_check
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.layouts.siso_spur.bill import bill
from mbcdm_cad.layouts.siso_spur.cable_path import cable_paths, input_wrap_rad
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive, laid
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.siso_spur.path_figures import plan
from mbcdm_cad.model.analysis import analyse
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.parts.input_pulley.dims import CHAMFER_MM
from mbcdm_cad.routes.route import contact_point_m
from tests.support.sliced_cables import by_bisection
from tests.support.smooth_path import assert_joined

ANGLES_DEG = (-35.0, 0.0, 20.0, 35.0)


@pytest.fixture(scope="module")
def lay(anchored: SpurDrive) -> SpurLayout:
    return SpurLayout(anchored)


@settings(max_examples=40, deadline=None)
@given(
    ratio=st.floats(3.0, 9.9),
    distance=st.floats(68.0, 120.0),
    turns=st.integers(2, 6),
    lead=st.floats(0.85, 2.0),
    angle=st.floats(-35.0, 35.0),
    surface=st.sampled_from(("smooth", "grooved")),
)
def test_paths_keep_their_length_and_join_without_a_kink(
    anchored: SpurDrive, ratio: float, distance: float, turns: int, lead: float, angle: float, surface: str
) -> None:
    """What leaves the drum lands on the input, and one slope runs from the stop's bend to the terminal's plane."""
    cables = tuple(replace(c, input_radius_mm=c.drum_radius_mm / ratio) for c in anchored.cables)
    reach = cables[0].drum_radius_mm + cables[0].input_radius_mm
    changed = laid(
        replace(
            anchored,
            cables=cables,
            centre_distance_mm=max(distance, reach + 1.0),
            turns=turns,
            helix_lead_mm=lead,
            input_pulleys=replace(anchored.input_pulleys, surface=surface),
        )
    )
    anchors = {c.name: (changed.landing_rad + 1.0, 5.0) for c in cables}
    for centred, path in zip(*(cable_paths(changed, anchors, at) for at in (0.0, np.radians(angle))), strict=True):
        assert path.length_mm == pytest.approx(centred.length_mm, abs=1e-9)
        assert_joined(path)


def test_each_groove_lies_under_its_cable_and_ends_in_the_slot_of_its_stop(lay: SpurLayout) -> None:
    """In the pulley's own frame, at every angle; the end of the winding stays where the slot begins."""
    pulley = lay.inputs[0]
    assert [g.right_handed for g in pulley.grooves] == [True, True]
    for k, (groove, slot) in enumerate(zip(pulley.grooves, pulley.slots, strict=True)):
        assert groove.cable_name == slot.cable_name == lay.drive.cables[k].name
        sense = np.sign(groove.end_angle_rad - groove.start_angle_rad)
        for angle in ANGLES_DEG:
            place = next(i.location for i in bill(lay, angle).items if i.name == "input_pulley_main")
            path = lay.cable_paths(np.radians(angle))[k]
            own = place.inverse.apply(path.piece("wound").points(np.linspace(0.0, 1.0, 60)))
            assert np.hypot(own[:, 0], own[:, 1]) == pytest.approx(groove.root_radius + 0.405, abs=1e-9)
            at = groove.start_angle_rad + sense * np.abs(own[:, 2] - groove.start_z) / (groove.lead / (2 * pi))
            off = np.arctan2(own[:, 1], own[:, 0]) - at
            assert np.abs(np.angle(np.exp(1j * off))).max() < 1e-9, f"{groove.cable_name} at {angle}"
            assert max(abs(at - groove.start_angle_rad)) < abs(groove.end_angle_rad - groove.start_angle_rad)
            end = own[0]
            assert np.arctan2(end[1], end[0]) % tau == pytest.approx(slot.end_angle_rad % tau, abs=1e-9)
            assert end[2] == pytest.approx(slot.end_z, abs=1e-9)


def test_stop_lies_on_the_end_of_its_cable(lay: SpurLayout) -> None:
    """Both ends of each stop, as the bill places it, are points of the chord of its path."""
    items = {item.name: item for item in bill(lay, 20.0).items}
    for path, slot in zip(lay.cable_paths(radians(20.0)), lay.inputs[0].slots, strict=True):
        chord = path.piece("chord").points(np.array([0.0, 1.0]))
        stop = items[f"stop_{path.cable.name}"].location.apply(np.array([[0.0, 0.0, slot.stop_start - slot.stop_end]]))
        assert stop[0] == pytest.approx(chord[0], abs=1e-9), path.cable.name


def test_windings_stand_side_by_side_on_the_land(lay: SpurLayout) -> None:
    """Lowest and highest point of each cable on the input over the travel, against each other and the land's ends."""
    low, high = (
        np.concatenate(
            [lay.cable_paths(np.radians(a))[k].piece("wound").points(np.linspace(0, 1, 50))[:, 1] for a in ANGLES_DEG]
        )
        for k in (0, 1)
    )
    flank, pulley = 0.405, lay.inputs[0]
    assert low.max() + flank < high.min() - flank
    assert low.min() - flank > pulley.land_bottom_z + 0.5 and high.max() + flank < pulley.land_top_z - 0.5
    # A lead a turn over the travel: 0.9 x 9.9 x 70 / 360, on top of what is wound at the unwound end.
    turns = lay.drive.dead_turns + 9.9 * 70.0 / 360.0
    assert high.max() - high.min() == pytest.approx(0.9 * turns, abs=1e-9)


def test_turns_cover_travel_and_reserve(anchored: SpurDrive) -> None:
    """3 turns less 9.9 x 70 degrees: 1.075 stay on at the end of the travel that unwinds a cable."""
    assert anchored.dead_turns == pytest.approx(3.0 - 9.9 * 70.0 / 360.0)
    for c in anchored.cables:
        ends = [degrees(input_wrap_rad(anchored, c, c.drum_side * way * radians(35.0))) for way in (1, -1)]
        assert ends == pytest.approx([360.0 * anchored.dead_turns, 1080.0], abs=1e-9)


def test_routes_touch_both_pulleys_where_the_paths_do(lay: SpurLayout) -> None:
    """Points where the spans leave the input and land on the drum, heights along the axes included."""
    d = lay.si
    for route, path in zip(d.routes.cables, lay.cable_paths(0.0), strict=True):
        span = path.piece("span").points(np.array([0.0, 1.0])) * 1e-3
        direction = route.spans[0].direction
        touched = [contact_point_m(d.routes.body(wrap.body), wrap, direction) for wrap in route.wraps]
        assert np.array(touched) == pytest.approx(span, abs=1e-12), route.cable


def test_nothing_slips_on_the_input(anchored: SpurDrive, drive: SpurDrive) -> None:
    assert layout_of(anchored).si.through_wrap_rad is None and layout_of(drive).si.through_wrap_rad is not None
    causes = [{limit.cause for limit in analyse(layout_of(d)).limits} for d in (drive, anchored)]
    assert causes[0] - causes[1] == {"slip"} and causes[1] <= causes[0]
    assert not any(wrap.may_slip_through for route in layout_of(anchored).si.routes.cables for wrap in route.wraps)


def test_each_form_has_the_checks_of_what_holds_it(anchored: SpurDrive, drive: SpurDrive) -> None:
    one, two = ({check.id for check in checks_of(d)} for d in (drive, anchored))
    assert one - two == {"input_slip", "input_sticks", "land_spacing"}
    stops = {"stop_pocket_wall", "stop_pocket_floor", "stop_pocket_bore", "anchor_bend", "dead_turns"}
    assert two - one == stops | {"cables_apart"}


@settings(max_examples=20, deadline=None)
@given(load=st.floats(0.05, 3.0), way=st.sampled_from((1, -1)))
def test_turns_as_the_continuous_drive_while_its_wrap_sticks(
    anchored: SpurDrive, drive: SpurDrive, load: float, way: int
) -> None:
    """Where a part of the one cable sticks wholly, each side ends there: two anchored cables are the same springs."""
    one, two = (solve_equilibrium(layout_of(d).si, way * load) for d in (drive, anchored))
    assert float(two.drum_angle_rad) == pytest.approx(float(one.drum_angle_rad), rel=1e-9)
    # Sides are in the order of y, which is the other one where cables are wound outwards.
    assert two.tension_N == pytest.approx(one.tension_N[::-1], rel=1e-9)


def test_equilibrium_is_that_of_cables_summed_up_in_slices(anchored: SpurDrive) -> None:
    at = solve_equilibrium(layout_of(anchored).si, 2.15)
    angle, tensions = by_bisection(anchored, anchored.free_span_mm * 1e-3, 2.15)
    assert float(at.drum_angle_rad) == pytest.approx(angle, rel=1e-4)
    assert at.tension_N == pytest.approx(tensions, rel=1e-5)


@pytest.mark.parametrize(
    ("check", "change", "status"),
    [
        ("dead_turns", {"turns": 3}, "pass"),
        ("dead_turns", {"turns": 2}, "fail"),
        ("helix_lead", {"helix_lead_mm": 0.88}, "fail"),
        ("groove_crest", {"helix_lead_mm": 0.84}, "fail"),
        ("stop_pocket_bore", {}, "pass"),
        ("cables_apart", {}, "pass"),
        ("cables_apart", {"centre_distance_mm": 640.0}, "fail"),
    ],
)
def test_winding_against_its_limits(anchored: SpurDrive, check: str, change: dict[str, float], status: str) -> None:
    changed = laid(replace(anchored, **change))
    found = next(c for c in checks_of(changed) if c.id == check)
    result = run_check(found, SpurLayout(changed))
    assert result.status == status, result.message


def test_too_few_turns_are_told_how_many_it_takes(anchored: SpurDrive) -> None:
    few = laid(replace(anchored, turns=2))
    result = run_check(next(c for c in checks_of(few) if c.id == "dead_turns"), SpurLayout(few))
    assert "transmission.turns" in result.remedy and "3" in result.remedy, result.remedy


def test_every_item_joins_once_in_the_order_of_assembly(lay: SpurLayout) -> None:
    joined = [name for step in lay.assembly_order for name in step.items]
    assert sorted(joined) == sorted(item.name for item in bill(lay).items)
    assert {"stop_side_1", "stop_side_2", "cable_side_1", "cable_side_2"} <= set(joined)


def test_cut_lengths_are_those_of_the_paths_with_their_stops(lay: SpurLayout) -> None:
    """Each cable is cut as long as its centre line, shorter by its stretch and bedding-in."""
    for setting, path in zip(plan(lay).cables, lay.cable_paths(0.0), strict=True):
        assert 0.97 < setting.cut_length_m * 1e3 / path.length_mm < 1.0, (setting.name, setting.cut_length_m)


def test_necks_stay_clear_of_the_stops(lay: SpurLayout) -> None:
    pulley = lay.inputs[0]
    for slot in pulley.slots:
        clear = slot.bend_radius - slot.stop_radius - max(pulley.lower_neck_radius, pulley.upper_neck_radius)
        assert clear > 0.09, f"{slot.cable_name}: {clear} mm"
    assert pulley.lower_journal_radius - CHAMFER_MM > pulley.bore_radius
