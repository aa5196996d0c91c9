"""The bill: placement of all instances, groups that move with the cables, names for any design."""

from collections import Counter
from dataclasses import replace
from math import radians

import numpy as np
import pytest

from mbcdm_cad.layouts.miso_bevel.bill import bill
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.parts.bill import Item, cable_item, sorted_items


def test_counts_of_what_comes_more_than_once(dims: BevelLayout) -> None:
    count = Counter(item.part for item in bill(dims).items)
    drive = dims.drive
    assert count["terminal"] == count["stop"] == 4 and count["nut"] == 8
    assert count["motor"] == count["gearhead"] == count["encoder"] == count["collar"] == 2
    assert sum(n for part, n in count.items() if part.startswith("bearing_")) == 8
    screws = Counter(item.part for item in bill(dims).items if item.part.startswith("screw_"))
    expected: Counter[str] = Counter()
    expected["screw_M2x6"] += 4  # top plate
    expected[f"screw_{drive.gearhead.screw}"] += 2 * drive.gearhead.screw_count
    expected[f"screw_{drive.encoder.screw}"] += 2 * drive.encoder.screw_count
    expected[f"screw_{drive.drum_encoder.screw}"] += drive.drum_encoder.screw_count
    expected[f"screw_{dims.collar.screw}"] += 2
    expected[f"screw_{dims.drum.set_screw}"] += 2
    expected["screw_M2x3-set"] += 1  # guide axle
    assert screws == expected


def test_names_are_unique_and_every_part_is_used(dims: BevelLayout) -> None:
    b = bill(dims)
    assert sorted_items(b.items, b.parts)
    assert {item.part for item in b.items} == set(b.parts)


def test_bought_items_carry_catalogue_masses_and_made_ones_none(dims: BevelLayout) -> None:
    b = bill(dims)
    for item in b.items:
        assert (item.mass_g is None) == (item.kind == "made"), item.name
    drive = dims.drive
    motors = [item.mass_g for item in b.items if item.part == "motor"]
    assert motors == [drive.motor.mass_g] * 2


def point(item: Item) -> np.ndarray:
    return item.location.shift_mm


@pytest.mark.parametrize("angle_deg", [-35.0, 10.0, 35.0])
def test_groups_turn_as_the_cables_make_them(dims: BevelLayout, angle_deg: float) -> None:
    """theta_g = -6 theta_o, theta_m = +9 theta_o: a mark on each rim moves as far as the cable on it."""
    motions = {body.name: body.motion(angle_deg) for body in dims.moving_bodies}
    theta = radians(angle_deg)
    for cable in dims.drive.cables:
        mark = np.array([0.0, 0.0, cable.drum_radius_mm])
        drum = motions["drum"].apply(mark)
        assert np.arctan2(drum[0], drum[2]) == pytest.approx(theta, abs=1e-12)
        for group, radius, ratio in (
            ("guide", cable.guide_radius_mm, -6.0),
            (f"input_{cable.input_name}", cable.input_radius_mm, 9.0),
        ):
            turned = motions[group].rotation @ np.array([radius, 0.0, 0.0])
            moved = radius * (np.arctan2(turned[1], turned[0]) - ratio * theta)
            assert moved / radius % (2 * np.pi) == pytest.approx(0.0, abs=1e-9) or moved / radius % (
                2 * np.pi
            ) == pytest.approx(2 * np.pi, abs=1e-9), f"{cable.name} on {group}"


def test_only_what_moves_moves(dims: BevelLayout) -> None:
    rest, turned = bill(dims, 0.0), bill(dims, 20.0)
    for a, b in zip(rest.items, turned.items, strict=True):
        assert a.name == b.name and a.group == b.group
        if a.group == "fixed":
            assert a.location == b.location, a.name
        elif np.linalg.norm(point(a)[[0, 2]]) > 1.0 and a.group == "drum":
            assert np.linalg.norm(point(a) - point(b)) > 0.1, f"{a.name} stays behind"


def test_cables_end_where_stop_and_terminal_stand(dims: BevelLayout) -> None:
    for angle in (-30.0, 0.0, 30.0):
        items = {item.name: item for item in bill(dims, angle).items}
        for path in dims.cable_paths(radians(angle)):
            name = path.cable.name
            tail = path.piece("tail").points(np.array([0.0, 1.0]))
            terminal = items[f"terminal_{name}"].location
            moved = next(t.drawn_in for t in dims.drum.tensioners if t.cable_name == name)
            land = terminal.apply(np.array([0.0, 0.0, -moved]))
            assert np.abs(land - tail[0]).max() < 1e-9, f"{name} at {angle}"
            axis = terminal.rotation @ np.array([0.0, 0.0, 1.0])
            assert np.abs(axis - path.piece("tail").tangent(0.0)).max() < 1e-9
            stop = items[f"stop_{name}"].location
            chord = path.piece("chord")
            assert np.abs(stop.rotation @ [0, 0, 1] + chord.tangent(0.0)).max() < 0.03, f"{name}: stop not on its chord"
            start = chord.points(np.array([0.0]))[0]
            length = next(s for p in dims.inputs for s in p.slots if s.cable_name == name)
            end = stop.apply(np.array([0.0, 0.0, length.stop_start - length.stop_end]))
            assert np.linalg.norm(end - start) < 0.05, f"{name}: cable ends {np.linalg.norm(end - start):.3f} mm off"


def test_a_cable_may_have_the_name_of_any_other_part(dims: BevelLayout) -> None:
    """Its item is called cable_NAME all the same."""
    names = ("frame", "drum", "cable_x", "1")
    cables = tuple(replace(c, name=n) for c, n in zip(dims.drive.cables, names, strict=True))
    from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout

    b = bill(BevelLayout(replace(dims.drive, cables=cables)))
    sorted_items(b.items, b.parts)
    assert [cable_item(n) for n in names] == ["cable_frame", "cable_drum", "cable_x", "cable_1"]
    assert len(b.items) == len(bill(dims).items)
